"""The order of every method, and that wrong coefficients are refused."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import mpmath
import numpy as np
import pytest

from remanent._typing import FloatArray
from remanent.codegen.field import vector_field_for
from remanent.integrate.ensemble import dense
from remanent.integrate.methods.runge_kutta import RungeKuttaMethod, cooper_verner_8, default_method
from remanent.models.actuator import Actuator
from remanent.models.drives.waves import SineSquared
from tests.unit.integrate.observed_order import WITHIN, order

ACTUATOR = Actuator(c=0.5, temperature=350.0, prestress=0.3)
DRIVE = SineSquared(0.8, 1.25, 0.2)


def march(method: RungeKuttaMethod, steps: int, number: Any, functions: Any) -> list[Any]:
    """Equation 16 over half a drive period in `steps` steps, with numbers of any kind."""
    field = vector_field_for(ACTUATOR, DRIVE)
    values = {**ACTUATOR.parameter_values(), **DRIVE.parameter_values()}
    parameters = [number(values[name]) for name in field.parameter_names]
    pi, y = functions.pi, [number(1), number(0)]
    h = pi / number(DRIVE.omega) / 2 / steps
    for k in range(steps):

        def rates(node: int, z: list[Any], k: int = k) -> list[Any]:
            s = (k + method.nodes[node]) / number(2 * steps)
            u = [functions.sin(pi * s), functions.cos(pi * s)]
            return field.rates([s, *z, *parameters, *u], functions=functions, constant=number)

        y = method.step(rates, y, h)
    return y


def slopes(errors: list[float]) -> FloatArray:
    return np.diff(-np.log2(errors))


def test_runge_kutta_is_of_order_8_in_fifty_digits() -> None:
    """Halving the step divides the error by 2**8, within 2**0.2."""
    with mpmath.workdps(50):
        method = cooper_verner_8(mpmath.sqrt, mpmath.mpf)
        exact = march(method, 600, mpmath.mpf, mpmath)
        errors = []
        for steps in (50, 100):
            found = march(method, steps, mpmath.mpf, mpmath)
            errors.append(float(max(abs(a - b) for a, b in zip(found, exact, strict=True))))
    assert errors[-1] < 1e-15
    np.testing.assert_allclose(slopes(errors), 8.0, atol=0.2)


def test_runge_kutta_is_of_order_8_in_double_precision() -> None:
    """The same in double precision, while errors are above round-off."""
    exact = march(default_method(), 1600, float, np)
    found = [march(default_method(), steps, float, np) for steps in (8, 16)]
    errors = [max(abs(a - b) for a, b in zip(y, exact, strict=True)) for y in found]
    assert min(errors) > 1e-12
    np.testing.assert_allclose(slopes(errors), 8.0, atol=0.2)


def local_errors(part: Any, steps: list[Any]) -> list[Any]:
    """Errors of y' = y cos t after a step of length part * h from t = 0.3."""
    method = cooper_verner_8(mpmath.sqrt, mpmath.mpf)
    begin = mpmath.mpf("0.3")
    errors = []
    for h in steps:
        length = part * h

        def rates(node: int, y: list[Any], length: Any = length) -> list[Any]:
            return [y[0] * mpmath.cos(begin + method.nodes[node] * length)]

        exact = mpmath.exp(mpmath.sin(begin + length) - mpmath.sin(begin))
        errors.append(abs(method.step(rates, [mpmath.mpf(1)], length)[0] - exact))
    return errors


@pytest.mark.parametrize("part", [0.1, 0.5, 0.9, 1.0])
def test_order_of_a_step_in_fifty_digits(part: float) -> None:
    """Whole steps, and the shorter ones that give states between them: O(h**9).

    Law: Order of the methods.
    """
    with mpmath.workdps(50):
        steps = [mpmath.mpf(2) ** -k for k in range(4, 9)]
        errors = local_errors(mpmath.mpf(part), steps)
    assert order([1 / float(h) for h in steps], errors) == pytest.approx(9.0, abs=WITHIN)


def test_states_between_steps_have_the_order_of_a_step() -> None:
    """A step of length t h from an exact state errs by O(h**9), for any t in (0, 1)."""
    field = vector_field_for(ACTUATOR, DRIVE)
    values = {**ACTUATOR.parameter_values(), **DRIVE.parameter_values()}
    part = np.array([0.3, 0.5, 0.9])
    errors = []
    for h in (0.2, 0.1):
        arguments = {
            "states": np.tile([1.0, 0.5], (3, 1)),
            "parameters": [np.full(3, values[name]) for name in field.parameter_names],
            "phase": np.full(3, 0.1),
        }
        span = part * h / (math.pi / DRIVE.omega)
        waveform = DRIVE.load_schedule({}, np.ones(1)).waveforms_at_phase

        def advanced(
            parts: int, a: Any = arguments, s: Any = span, h: float = h, wave: Any = waveform
        ) -> FloatArray:
            y: FloatArray = a["states"]
            small = {"span": s / parts, "time": part * h / parts}
            for k in range(parts):
                now = {**a, "states": y, "phase": a["phase"] + k * s / parts}
                y = dense.partial_step(field, default_method(), wave, **now, **small)
            return y

        errors.append(np.abs(advanced(1) - advanced(16)).max(axis=1))
    np.testing.assert_allclose(np.log2(errors[0] / errors[1]), 9.0, atol=0.35)


def test_a_state_at_the_end_of_a_step_is_kept_exactly() -> None:
    """A step of length zero changes no bit, whatever the state."""
    field = vector_field_for(ACTUATOR, DRIVE)
    values = {**ACTUATOR.parameter_values(), **DRIVE.parameter_values()}
    states = np.array([[1.0 / 3.0, -0.1], [1e300, np.inf]])
    zero = np.zeros(2)
    found = dense.partial_step(
        field,
        default_method(),
        DRIVE.load_schedule({}, np.ones(1)).waveforms_at_phase,
        states=states,
        parameters=[np.full(2, values[name]) for name in field.parameter_names],
        phase=zero,
        span=zero,
        time=zero,
    )
    assert np.array_equal(found, states)


METHOD = default_method()
WRONG = {
    "a node": {"nodes": (0.0, 0.2, *METHOD.nodes[2:])},
    "a weight": {
        "stage_weights": (*METHOD.stage_weights[:4], {0: 0.1, 2: 0.2}, *METHOD.stage_weights[5:])
    },
    "a stage that is not explicit": {
        "stage_weights": (*METHOD.stage_weights[:3], {0: 0.5, 7: 0.3}, *METHOD.stage_weights[4:])
    },
    "a final coefficient": {"final_weights": {**METHOD.final_weights, 8: 0.35}},
    "a claimed order": {"order": 10},
}


@pytest.mark.parametrize("change", WRONG.values(), ids=list(WRONG))
def test_wrong_coefficients_are_refused(change: dict[str, Any]) -> None:
    """A method whose row sums or quadrature conditions fail cannot be built."""
    with pytest.raises(ValueError, match="cooper-verner-8"):
        replace(METHOD, **change)
