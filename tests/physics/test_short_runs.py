"""Runs that end long before the first period of their load does."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import remanent as rm

BODY = rm.Actuator()


@pytest.mark.parametrize("omega", [1e-2, 1e-5, 1e-12])
def test_a_run_within_a_small_part_of_a_period_is_that_of_scipy(omega: float) -> None:
    """DOP853 on the equation of motion [Thermal, eq. 16], written out once more."""

    def rates(tau: float, y: np.ndarray) -> list[float]:
        x, v = y
        m = (0.4 * np.sin(omega * tau + 1.0)) ** 2
        force = x**8 - x**2 + m * x**4
        return [v, (6.0 * BODY.c * v**2 - 3.0 * force) / (x**7 + 2.0 * BODY.c * x)]

    ds = rm.simulate(BODY, rm.SineSquared(0.4, omega, phase=1.0), times=[1.0, 2.0])
    exact = solve_ivp(rates, (0, 2), [1, 0], "DOP853", [1.0, 2.0], rtol=1e-12, atol=1e-12).y[0]
    assert int(ds.status) == rm.Status.OK
    assert np.abs(ds.stretch.values - exact).max() <= max(float(ds.error), 1e-11)


def test_response_to_a_very_slow_load_is_a_point_of_its_own() -> None:
    """Slow loads give the same response beside others and alone."""
    omega = np.array([1e-5, 1e-3, 1.0])
    together = rm.frequency_response(BODY, rm.SineSquared(0.4, 1.0), omega)
    alone = rm.frequency_response(BODY, rm.SineSquared(0.4, 1.0), omega[:1])
    assert float(alone.amplitude[0]) == float(together.amplitude[0])
    assert float(alone.amplitude[0]) == pytest.approx(2.667e-8, rel=1e-3)
    assert together.status.values.tolist() == [rm.Status.OK] * 3
