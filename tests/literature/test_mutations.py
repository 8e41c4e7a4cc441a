"""The reproduction is sensitive: a wrong model does not bring the resonances back."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import sympy as sp

import remanent as rm
from remanent.codegen import build as codegen_build
from remanent.derivation import lagrange
from remanent.derivation.motion import Motion
from remanent.report.settings import (
    MAX_RESONANCE_MISFIT,
    PRESTRESSES,
    PUBLISHED_RESONANCES,
    TEMPERATURES,
)
from remanent.studies.ensemble import layout

OMEGAS = np.linspace(0.6, 1.6, 201)
#: A mutation must move a resonance by more than this.
SEEN = 0.005


def resonances(actuator: rm.Actuator, prestresses: tuple[float, ...] = PRESTRESSES) -> Any:
    """Resonances (prestress, temperature) of the published response curves."""
    over = {"prestress": prestresses, "temperature": TEMPERATURES}
    drive = rm.SineSquared(0.4, 1.0)
    found = rm.frequency_response(
        actuator, drive, OMEGAS, over=over, tolerance=1e-6, resonance_width=1e-4
    )
    return found["resonance"].transpose("prestress", "temperature").values


@pytest.fixture(scope="module")
def right() -> Any:
    """Resonances of the model as it is."""
    return resonances(rm.Actuator())


def test_all_six_resonances_lie_within_a_hundredth_of_the_published(right: Any) -> None:
    """The unchanged equation gives the published resonances, so that mutations can be judged."""
    assert np.abs(right - np.array(PUBLISHED_RESONANCES)).max() <= MAX_RESONANCE_MISFIT


def _velocity(a: Any, _x: Any, v: Any) -> Any:
    """The sign of the term 6 c lambda'^2."""
    return a.subs(v, sp.I * v)


def _load(a: Any, _x: Any, _v: Any) -> Any:
    """The sign of the magnetic load m."""
    (load,) = [s for s in a.free_symbols if s.name == "effective_load"]
    return a.subs(load, -load)


def _exponent(a: Any, x: Any, _v: Any) -> Any:
    """The exponent of lambda^-5 becomes -4."""
    (stiffness,) = [s for s in a.free_symbols if s.name == "stiffness"]
    (c,) = [s for s in a.free_symbols if s.name == "c"]
    return a + 3 * stiffness * (x**-4 - x**-5) / (1 + 2 * c * x**-6)


@pytest.mark.parametrize(
    "mutate", [_velocity, *(pytest.param(m, marks=pytest.mark.slow) for m in (_load, _exponent))]
)
def test_a_mutated_equation_moves_a_resonance(
    mutate: Callable[[Any, Any, Any], Any], right: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each wrong term in the acceleration moves a resonance by more than the agreement."""
    original = lagrange.solve_accelerations

    def mutated(motion: Motion) -> lagrange.Accelerations:
        solution = original(motion)
        (a,) = solution.coordinate_accelerations
        for symbol, meaning in reversed(list(solution.definitions.items())):
            a = a.subs(symbol, meaning)
        a = motion.eliminate_thickness(a)
        x, v = motion.coordinates[0], motion.rates[0]
        changed = mutate(a, x, v)
        assert sp.simplify(changed - a) != 0
        thickness = sp.diff(x**-2, x) * changed + sp.diff(x**-2, x, 2) * v**2
        return lagrange.Accelerations({}, (changed,), thickness)

    monkeypatch.setattr(lagrange, "solve_accelerations", mutated)
    field = codegen_build.build_field(rm.Actuator(), rm.SineSquared(0.4, 1.0))
    monkeypatch.setattr(layout, "vector_field_for", lambda *_: field)
    assert np.nanmax(np.abs(resonances(rm.Actuator()) - right)) > SEEN


def test_a_reference_temperature_off_by_ten_kelvin_moves_a_resonance(right: Any) -> None:
    """Ten kelvin in the reference temperature move a resonance by more than the agreement."""
    wrong = resonances(rm.Actuator(reference_temperature=303.0))
    assert np.abs(wrong - right).max() > SEEN


def test_a_wrong_prestress_moves_a_resonance(right: Any) -> None:
    """A tenth in the prestress moves its resonances by more than the agreement."""
    wrong = resonances(rm.Actuator(), prestresses=(0.0, 0.9))
    assert np.abs(wrong - right)[1].max() > SEEN
