"""The names of resonances, against the linear oscillator and the theory of weak damping."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from scipy.optimize import minimize_scalar

import remanent as rm
from remanent._errors import InputError
from remanent._typing import ComplexArray, FloatArray
from remanent.analysis.response.harmonics import (
    ResonantHarmonic,
    find_resonant_harmonic,
    fourier_amplitudes,
    phase_lag_behind_load,
    resonance_kind_and_order,
)


def test_harmonics_of_a_sum_of_cosines_are_its_coefficients() -> None:
    """The amplitudes and phases that were put in come out."""
    t = 2.0 * np.pi * np.arange(64) / 64
    c = fourier_amplitudes((0.7 + 2.0 * np.cos(t - 0.3) + 0.5 * np.cos(3.0 * t + 1.0))[None], 5)[0]
    expected = [0.7, 2.0 * np.exp(-0.3j), 0.0, 0.5 * np.exp(1j), 0.0, 0.0]
    np.testing.assert_allclose(c, expected, atol=1e-14)


def test_the_harmonic_that_resonates_is_the_one_nearest_to_the_free_oscillation() -> None:
    """Its share is of the energy of all harmonics, its detuning relative to the free frequency."""
    found = find_resonant_harmonic(
        np.array([[1.0, 3.0, 4.0j, 0.0]]), np.array([1.0]), np.array([2.05])
    )
    assert found.harmonic_number.tolist() == [2]
    assert found.power_share[0] == pytest.approx(16.0 / 25.0)
    assert found.relative_detuning[0] == pytest.approx(2.0 / 2.05 - 1.0)


@pytest.mark.parametrize(
    ("harmonic", "period", "doubled", "expected"),
    [
        (1, 1, False, ("primary", 1, 1)),
        (2, 2, True, ("primary", 1, 1)),
        (3, 1, False, ("superharmonic", 3, 1)),
        (1, 3, False, ("subharmonic", 1, 3)),
        (1, 2, False, ("subharmonic", 1, 2)),
        (1, 2, True, ("parametric", 1, 2)),
        (3, 2, False, ("ultrasubharmonic", 3, 2)),
    ],
)
def test_orders_have_their_names(
    harmonic: int, period: int, doubled: bool, expected: tuple[str, int, int]
) -> None:
    """The resonant harmonic and the period of the orbit decide the name of a resonance."""
    found = ResonantHarmonic(np.array([harmonic]), np.array([0.01]), np.array([0.9]))
    assert resonance_kind_and_order(found, 0, period, doubled=doubled) == expected


@pytest.mark.parametrize(("detuning", "share"), [(0.2, 0.9), (-0.2, 0.9), (0.0, 0.01), (np.nan, 1)])
def test_what_the_evidence_does_not_carry_is_undecided(detuning: float, share: float) -> None:
    """A harmonic far from the free frequency, or with a small share, has no name."""
    found = ResonantHarmonic(np.array([1]), np.array([detuning]), np.array([share]))
    assert resonance_kind_and_order(found, 0, 1, doubled=False) == ("undecided", 0, 0)


def small_load_resonance(body: rm.Actuator, b: float, limits: tuple[float, float]) -> xr.Dataset:
    """The one resonance under the square of a sine, with its distance to that of no load.

    The mean load and the amplitude move it in proportion to b^2, so that two loads tell it to
    b^4: it is the attribute ``linear``.
    """
    found = [
        rm.resonances(body, rm.SineSquared(size, 1.0), limits, slices=3) for size in (b, b / 2)
    ]
    large, small = (float(ds.omega[0]) for ds in found)
    return found[0].assign_attrs(linear=(4.0 * small - large) / 3.0)


def test_a_small_load_finds_the_linear_resonance() -> None:
    """x'' + eta x' + 6 x at c = 1: largest at W² = 6 − eta²/2, behind by atan(eta W/(6 − W²))."""
    eta = 0.2
    ds = small_load_resonance(rm.Actuator(dissipation=rm.Rayleigh(eta)), 0.03, (1.0, 1.5))
    assert ds.resonance_kind.values.tolist() == ["primary"]
    exact = np.sqrt(6.0 - eta**2 / 2.0)
    assert 2.0 * ds.linear == pytest.approx(exact, abs=1e-6)
    load = 2.0 * float(ds.omega[0])
    lag = np.arctan2(eta * load, 6.0 - load**2)
    assert float(ds.phase_lag[0]) == pytest.approx(lag, abs=2e-3)
    assert float(ds.share[0]) > 0.999


@pytest.mark.slow
@pytest.mark.parametrize(("relaxation_time", "eta"), [(0.7, 0.0), (5.0, 0.1)])
def test_a_small_load_finds_the_resonance_of_a_relaxing_body(
    relaxation_time: float, eta: float
) -> None:
    """Its stiffness at the frequency W is 6 [1 + mu i W t/(1 + i W t)] + i eta W, c = 1."""
    modulus = 0.5
    body = rm.Actuator(dissipation=[rm.Zener(modulus, relaxation_time), rm.Rayleigh(eta)])
    ds = small_load_resonance(body, 0.03, (1.2, 1.7))
    assert ds.resonance_kind.values.tolist() == ["primary"]

    def stiffness(W: FloatArray) -> ComplexArray:
        turn = 1j * W * relaxation_time
        return np.asarray(6.0 * (1.0 + modulus * turn / (1.0 + turn)) + 1j * eta * W - W**2)

    largest = minimize_scalar(
        lambda W: float(np.abs(stiffness(np.asarray(W)))),
        bounds=(2.4, 3.4),
        options={"xatol": 1e-9},
    ).x
    assert 2.0 * ds.linear == pytest.approx(largest, abs=1e-6)
    lag = np.angle(stiffness(2.0 * ds.omega.values))[0]
    assert float(ds.phase_lag[0]) == pytest.approx(lag, abs=3e-3)
    assert abs(float(ds.detuning[0])) < 0.01


@pytest.mark.slow
def test_resonances_of_a_body_that_warms_little_are_those_at_its_temperature() -> None:
    """As the coupling to heat tends to 0, the resonances tend to those without heat."""
    drive, span = rm.SineSquared(0.03, 1.0), (1.1, 1.4)
    body = rm.Actuator(temperature=320.0, dissipation=rm.Rayleigh(0.2))
    warm = body.replace(heat=rm.Heat(1e-6, exchange=1.0))
    plain, heated = (rm.resonances(a, drive, span, slices=3) for a in (body, warm))
    assert heated.resonance_kind.values.tolist() == ["primary"]
    for name in ("omega", "free_frequency", "phase_lag"):
        np.testing.assert_allclose(heated[name], plain[name], rtol=2e-3)


def test_two_coordinates_are_refused() -> None:
    """A nonlinear mode is known for one coordinate only."""
    with pytest.raises(InputError, match="one coordinate"):
        rm.resonances(rm.Actuator(prestress=(0.0, 0.0)), rm.SineSquared(0.03, 1.0), (1.0, 1.5))


def test_superharmonic_peaks_lie_on_the_backbone() -> None:
    """With slight damping both peaks have the free frequency of their amplitude."""
    ds = rm.resonances(
        rm.Actuator(dissipation=rm.Rayleigh(0.03)), rm.SineSquared(0.4, 1.0), (0.56, 1.3), slices=5
    )
    assert ds.resonance_kind.values.tolist() == ["superharmonic", "primary"]
    assert ds.order_p.values.tolist() == [2, 1]
    assert np.abs(ds.detuning.values).max() < 2e-3
    np.testing.assert_allclose(ds.phase_lag, np.pi / 2.0, atol=0.05)


def test_a_response_born_by_period_doubling_is_parametric() -> None:
    """Near twice the natural frequency the forced orbit is unstable, and a 1:2 response grows."""
    body = rm.Actuator(dissipation=rm.Rayleigh(0.01))
    ds = rm.resonances(
        body, rm.SineSquared(0.8, 1.0), (2.1, 2.6), orbit_periods=(2,), slices=3,
        state_box={"stretch": (0.7, 2.0), "stretch_rate": (-2.0, 2.0)},
    )  # fmt: skip
    assert set(ds.resonance_kind.values.tolist()) == {"parametric"}
    assert set(ds.order_p.values.tolist()) == {1}
    assert set(ds.order_q.values.tolist()) == {2}
    assert ds.unbounded.values.all()  # cut by the bounds before it turns back
    inside = rm.periodic_orbits(body, rm.SineSquared(0.8, 2.315))
    assert "stable" not in inside.stability.values.tolist()


@pytest.mark.parametrize("phase", [pytest.param(0.0, marks=pytest.mark.slow), 1.0])
def test_the_phase_of_the_load_moves_no_peak(phase: float) -> None:
    """Law: a load that begins later has the same response later, with every peak."""
    body = rm.Actuator(dissipation=rm.Rayleigh(0.05))
    drive = rm.Sine(0.05, 1.0, mean=0.05, phase=phase)
    ds = rm.resonances(body, drive, (0.75, 0.9), slices=3)
    assert ds.omega.values == pytest.approx([0.80655156], abs=1e-7)
    assert ds.amplitude.values == pytest.approx([0.01940290], abs=1e-8)
    assert (np.abs(ds.omega - 0.8065515648) <= 3.0 * ds.omega_error).all()


@pytest.mark.slow
@pytest.mark.parametrize(("multiples", "limits"), [([2, 3], (1.15, 1.3)), ([1, 3], (0.78, 0.85))])
def test_a_harmonic_that_the_load_has_is_a_primary_resonance(
    multiples: list[int], limits: tuple[float, float]
) -> None:
    """A quarter of a turn behind the term of its own frequency, as a linear oscillator is."""
    body = rm.Actuator(dissipation=rm.Rayleigh(0.05))
    ds = rm.resonances(body, rm.Sines([0.02, 0.02], multiples, 1.0), limits, slices=3)
    assert set(ds.resonance_kind.values.tolist()) == {"primary"}
    np.testing.assert_allclose(ds.phase_lag, 0.5 * np.pi, atol=0.03)


def test_a_stiff_block_under_a_mean_load_has_its_primary_resonance() -> None:
    """The free oscillation about the rest under the mean load names it, however far that is."""
    body = rm.Actuator(c=0.05, prestress=0.1, dissipation=rm.Rayleigh(0.05))
    ds = rm.resonances(body, rm.Sine(0.02, 1.0, mean=2.0), (4.8, 7.8), slices=3)
    assert ds.resonance_kind.values.tolist() == ["primary"]
    assert abs(float(ds.detuning[0])) < 1e-3
    assert ds.omega_error.values < 1e-6


def test_a_lag_counts_up_to_the_turns_of_the_load() -> None:
    """A response of a third of the load's frequency is told up to a third of a turn."""
    load = np.array([0.0, np.exp(-0.5j), 0.0])
    third = phase_lag_behind_load(0.4, 1, 3, load)
    assert third.modulus == pytest.approx(2.0 * np.pi / 3.0)
    assert not third.in_load
    assert third.angle == pytest.approx(np.mod(-0.5 / 3.0 - 0.4, 2.0 * np.pi / 3.0))
    whole = phase_lag_behind_load(0.4, 3, 3, load)
    assert whole.angle == pytest.approx(np.mod(-0.9, 2.0 * np.pi))
    assert whole.in_load
