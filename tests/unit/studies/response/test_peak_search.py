"""Peaks of branches whose orbits and amplitudes are known in closed form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

from remanent._typing import FloatArray
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.curves import Curve, CurvePoints
from remanent.analysis.orbits.maps import MapImage
from remanent.studies.orbits._tracing import Branch, Tracing
from remanent.studies.response import _peak_search
from remanent.studies.response._peak_search import Peak, PeakSearch

#: Of the linear oscillator x'' + DAMPING x' + x = FORCE cos(omega t).
DAMPING, FORCE = 0.02, 1e-5
RANGE = (0.4, 1.6)


def linear_response(omega: FloatArray) -> FloatArray:
    """Amplitude of the linear oscillator, largest at omega^2 = 1 - DAMPING^2/2."""
    return np.asarray(FORCE / np.abs(1.0 - omega**2 + 1j * DAMPING * omega))


@dataclass(frozen=True)
class OscillatorMap:
    """x, x' of the linear oscillator over a period of its drive, in closed form."""

    period_tolerance: float = 1e-12
    dimension: int = 2

    def __call__(self, states: FloatArray, parameters: FloatArray, _: int) -> MapImage:
        rates, omega = np.array([[0.0, 1.0], [-1.0, -DAMPING]]), parameters[:, 0]
        period = 2.0 * np.pi / omega
        turned = expm(rates * period[:, None, None])
        factor = FORCE / (1.0 - omega**2 + 1j * DAMPING * omega)
        slope = -(factor**2) / FORCE * (1j * DAMPING - 2.0 * omega)
        orbit = np.real(np.column_stack([factor, 1j * omega * factor]))
        moved = np.real(np.column_stack([slope, 1j * (factor + omega * slope)]))
        away = (turned @ (states - orbit)[..., None])[..., 0]
        by_omega = moved - (turned @ moved[..., None])[..., 0]
        by_omega -= (rates @ away[..., None])[..., 0] * (period / omega)[:, None]
        return MapImage(orbit + away, turned, by_omega[..., None], np.zeros(len(states)))


@dataclass(frozen=True)
class RestingMap:
    """x -> x/10, at rest at every frequency."""

    period_tolerance: float = 1e-12
    dimension: int = 1

    def __call__(self, states: FloatArray, _: FloatArray, __: int) -> MapImage:
        jacobian = np.full((len(states), 1, 1), 0.1)
        return MapImage(0.1 * states, jacobian, 0.0 * jacobian, np.zeros(len(states)))


@dataclass(frozen=True)
class ClosedFormSearch(PeakSearch):
    """A search for the peaks of amplitudes that a function of the frequency gives."""

    response: Callable[[FloatArray], FloatArray] = linear_response

    def _amplitudes(
        self,
        points: CurvePoints,
        position_errors: FloatArray | None = None,
        tolerances: tuple[float, ...] = (),
    ) -> tuple[FloatArray, FloatArray]:
        return self.response(points.unknown[:, -1]), np.full(len(points), 1e-15)


def closed_form_search(map_: Any, response: Callable[[FloatArray], FloatArray]) -> ClosedFormSearch:
    box = np.tile([-1e3, 1e3], (map_.dimension, 1))
    tracing = Tracing(map_, box, RANGE, 1, residual_tolerance=1e-11, max_points=100)
    nothing: Any = None  # no motion is integrated
    return ClosedFormSearch(nothing, tracing, np.nan, response)


def points_at(search: PeakSearch, omega: list[float]) -> CurvePoints:
    """The orbits at some frequencies."""
    settings = search.tracing.continuation_settings
    guess = np.zeros((len(omega), settings.scale.size))
    guess[:, -1] = omega
    upwards = np.tile(np.eye(settings.scale.size)[-1], (len(omega), 1))
    points, reached = correct_points(
        search.tracing.curve_equations, guess, upwards,
        scale=settings.scale, tolerance=settings.tolerance,
    )  # fmt: skip
    assert reached.all()
    return points


def peaks_on(search: PeakSearch, omega: list[float], monkeypatch: pytest.MonkeyPatch) -> list[Peak]:
    """Peaks of the branch with points at some frequencies."""
    monkeypatch.setattr(_peak_search, "describe_orbits", lambda *_: {"stability": ["stable"]})
    curve = Curve(points_at(search, omega), is_closed=False, end_reasons=("bounds", "bounds"))
    return search.peaks_of(Branch(curve, [], []))


@pytest.mark.parametrize("omega", [[0.4, 0.8, 0.95, 1.1, 1.6], [0.5, 0.96, 1.08, 1.5]])
def test_few_points_do_not_hide_the_peak_of_a_linear_oscillator(
    omega: list[float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Law: the only peak of x'' + d x' + x = f cos(w t) is at w^2 = 1 - d^2/2, however sharp."""
    search = closed_form_search(OscillatorMap(), linear_response)
    (peak,) = peaks_on(search, omega, monkeypatch)
    exact = np.sqrt(1.0 - 0.5 * DAMPING**2)
    assert abs(peak.omega - exact) <= peak.omega_error < 1e-8
    assert peak.amplitude == pytest.approx(float(linear_response(exact)), rel=1e-12)


@pytest.mark.parametrize("limits", [[0.7, 0.99], [1.01, 1.6]])
def test_points_are_added_until_neighbours_have_multipliers_alike(limits: list[float]) -> None:
    """Law: from point to point mu changes by half its distance from 1 at most."""
    search = closed_form_search(OscillatorMap(), linear_response)
    given = points_at(search, limits)
    points = search.resolved(given)
    omega = points.unknown[:, -1]
    assert (np.diff(omega) > 0.0).all()
    assert np.isin(given.unknown[:, -1], omega).all()
    pole = -0.5 * DAMPING + 1j * np.sqrt(1.0 - 0.25 * DAMPING**2)
    multiplier = np.exp(2.0 * np.pi * pole / omega)
    distance = np.abs(1.0 - multiplier)
    change = np.abs(np.diff(multiplier)) / np.minimum(distance[1:], distance[:-1])
    assert change.max() <= 0.5 + 1e-9
    assert change.max() > 0.1  # nor are there many more than that


def test_orbits_beside_a_peak_lie_on_both_sides_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """Law: the neighbours of a peak enclose it, at equal distances, and are orbits themselves."""
    search = closed_form_search(OscillatorMap(), linear_response)
    (peak,) = peaks_on(search, [0.4, 0.8, 0.95, 1.1, 1.6], monkeypatch)
    below, at, above = peak.nearby_omega - peak.omega
    assert at == pytest.approx(0.0, abs=1e-15)
    assert above == pytest.approx(-below, rel=1e-3)
    assert above >= 0.9 * peak.omega_error
    image = search.tracing.map(peak.nearby_states, peak.nearby_omega[:, None], 1)
    np.testing.assert_allclose(image.state, peak.nearby_states, atol=1e-11)


def test_a_small_peak_on_a_steep_flank_is_looked_for_more_closely(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Law: a peak is found also where its neighbours are so far apart that the flank hides it."""

    def falling(omega: FloatArray) -> FloatArray:
        return np.asarray(0.1 * np.exp(-0.5 * ((omega - 1.0) / 0.05) ** 2) - omega)

    search = closed_form_search(RestingMap(), falling)
    (peak,) = peaks_on(search, [0.93, 0.98, 1.4], monkeypatch)
    exact = brentq(lambda w: (1.0 - w) / 0.05**2 * (falling(w) + w) - 1.0, 0.95, 0.99)
    assert abs(peak.omega - exact) <= peak.omega_error < 1e-3
