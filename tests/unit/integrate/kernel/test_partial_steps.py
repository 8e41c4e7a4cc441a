"""Steps of single states are those of the method, and depend on nothing but themselves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp

from remanent._typing import FloatArray
from remanent.integrate.ensemble.dense import partial_step
from remanent.integrate.methods.runge_kutta import default_method
from tests.unit.integrate.handmade import SINE, Oscillator, Q, V, turning

FIELD = Oscillator(
    -sp.Symbol("k") * Q - sp.Symbol("g") * V - sp.exp(Q) / (1 + Q**2) + sp.Symbol("a") * SINE,
    {"k": 1.3, "g": 0.1, "a": 0.4},
).field()


def steps(count: int) -> dict[str, Any]:
    """States, parameters, loads and lengths that all differ; some steps have no length."""
    rng = np.random.default_rng(2)
    time = rng.uniform(0.0, 0.3, 100)
    time[::7] = 0.0
    return {
        "states": rng.uniform(-1.0, 1.0, (100, 2))[:count],
        "parameters": [rng.uniform(0.1, 2.0, 100)[:count] for _ in range(3)],
        "phase": rng.uniform(0.0, 1.0, 100)[:count],
        "span": (time / 5.0)[:count],
        "time": time[:count],
    }


@pytest.mark.parametrize("count", [0, 1, 16, 33, 100])
def test_they_are_steps_of_the_method(count: int) -> None:
    """The same formula with NumPy, but for rounding; where there is no time nothing moves."""
    given, method = steps(count), default_method()

    def rates(node: int, y: list[FloatArray]) -> Any:
        phase = given["phase"] + float(method.nodes[node]) * given["span"]
        return FIELD.rates([phase, *y, *given["parameters"], *turning(phase)], functions=np)

    expected = np.stack(method.step(rates, list(given["states"].T), given["time"]), axis=1)
    moved = partial_step(FIELD, method, turning, **given)
    np.testing.assert_allclose(moved, expected, rtol=0.0, atol=1e-15)
    at_rest = given["time"] == 0.0
    np.testing.assert_array_equal(moved[at_rest], given["states"][at_rest])


def test_they_are_the_same_in_any_company() -> None:
    """The first eleven and the last of a hundred, alone and among the others."""
    method, given = default_method(), steps(100)
    together = partial_step(FIELD, method, turning, **given)
    first = partial_step(FIELD, method, turning, **steps(11))
    np.testing.assert_array_equal(first, together[:11])
    last: dict[str, Any] = {
        name: [v[-1:] for v in values] if name == "parameters" else values[-1:]
        for name, values in given.items()
    }
    np.testing.assert_array_equal(partial_step(FIELD, method, turning, **last), together[-1:])
