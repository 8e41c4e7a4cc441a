"""Long rates and steps with them are functions, which take the same steps but for rounding."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy as sp

from remanent.integrate.kernel import compile as kernels
from remanent.integrate.kernel import field_code
from remanent.integrate.maps.period_map import PeriodMap
from tests.unit.integrate.handmade import SINE, Oscillator, Q, V, problem, turning

#: Its parameters multiply the state, its rate, a power and the load.
OSCILLATOR = Oscillator(
    -sp.Symbol("k") * Q - sp.Symbol("g") * V - Q**3 / (1 + Q**2) + sp.Symbol("a") * SINE,
    {"k": 1.3, "g": 0.1, "a": 0.4},
)


@pytest.fixture(autouse=True)
def own_kernels() -> Iterator[None]:
    """No other test gets these kernels, whose keys say nothing of functions."""
    yield
    kernels._cached_kernel.cache_clear()


@pytest.mark.parametrize(
    "options",
    [
        pytest.param({"directions": 0}, id="states"),
        pytest.param({"directions": 2}, id="tangents"),
        pytest.param({"directions": 1, "error_control": "state"}, id="coarse states alone"),
        pytest.param({"directions": 2, "parameters": ["a"]}, id="derivatives by the load"),
    ],
)
def test_functions_change_no_more_than_rounding(
    options: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Images, tangents and errors of a period, written out in place and called."""
    start = np.random.default_rng(1).uniform(-1.0, 1.0, (20, 2))
    asked = problem(OSCILLATOR, start, 1.0, period=5.0, a=np.linspace(0.1, 0.6, 20))
    images = []
    for most in (10**9, 0):
        monkeypatch.setattr(field_code, "MAX_INLINED_INSTRUCTIONS", most)
        monkeypatch.setenv("REMANENT_CACHE_DIR", str(tmp_path / str(most)))
        kernels._cached_kernel.cache_clear()
        period_map = PeriodMap(asked.field, turning, **options)
        images.append(
            period_map(
                asked.initial_states, asked.parameters, np.full(20, 5.0),
                resolution=20, tolerance=np.inf, cycles=3,
            )
        )  # fmt: skip
    in_place, called = images
    np.testing.assert_allclose(called.state, in_place.state, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(called.tangents, in_place.tangents, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(
        called.largest_period_error, in_place.largest_period_error, rtol=1e-3
    )
