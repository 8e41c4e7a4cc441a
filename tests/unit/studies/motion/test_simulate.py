"""Histories: the error that is told, and where they end."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import remanent as rm
from tests.physics.block import Block


def test_a_strongly_driven_motion_ends_at_its_horizon() -> None:
    """Status horizon: numbers before it, NaN after it, never the last good value."""
    ds = rm.simulate(rm.Actuator(), rm.SineSquared(2.5, 1.5), duration=600.0, tolerance=1e-9)
    assert int(ds.status) == 2
    horizon = float(ds.horizon)
    assert 10.0 < horizon < 600.0
    before = ds.time.values <= horizon
    assert np.isfinite(ds.stretch.values[before]).all()
    for name in ("stretch", "stretch_rate", "thickness_stretch", "energy"):
        assert np.isnan(ds[name].values[~before]).all()
    assert 0.0 < float(ds.error) <= 1e-9


@pytest.mark.parametrize("tolerance", [1e-5, 1e-8])
def test_bounds_hold_at_loose_tolerances(tolerance: float) -> None:
    """The true error is at most the error that is told, and that is at most the tolerance.

    Law: Coverage.
    """
    times, drive = np.linspace(0.0, 6.0, 13), rm.Sine(0.3, 1.7, 0.1, 0.4)
    block = Block(
        loads=(0.3, 0.0),
        branches=((0.5, 1.3),),
        theta=0.8,
        m=lambda t: 0.1 + 0.3 * math.sin(1.7 * t + 0.4),
        m_rate=lambda t: 0.3 * 1.7 * math.cos(1.7 * t + 0.4),
    )
    actuator = rm.Actuator(
        prestress=(0.3, 0.0),
        dissipation=rm.Zener(0.5, 1.3),
        temperature=300.0 * 0.8,
        reference_temperature=300.0,
    )
    ds = rm.simulate(actuator, drive, times=times, tolerance=tolerance)
    names = ["stretch_1", "stretch_1_rate", "stretch_2", "stretch_2_rate"]
    names += [f"dissipation.0.viscous_stretch_{k}" for k in (1, 2)]
    states = np.stack([ds[name].values for name in names], axis=1)
    true = np.abs(states - block.run(times)[:, :6]).max()
    assert true <= float(ds.error) <= tolerance


@pytest.mark.parametrize("seed", range(6))
def test_what_is_computed_from_the_state_has_an_error_of_its_own(seed: int) -> None:
    """Thickness, its rate and energy [Thermal, eq. 16], written out once more for DOP853.

    A thin block has λ₃ = λ⁻², whose slope is the larger the smaller λ is: the error of the state
    does not cover it.  Law: Coverage.
    """
    draw = np.random.default_rng(seed)
    c, theta, eta = 10.0 ** draw.uniform(-1, 0), draw.uniform(0.8, 1.2), draw.uniform(0.0, 0.3)
    b, omega = draw.uniform(0.4, 1.0), draw.uniform(0.8, 2.0)

    def load(tau: np.ndarray | float) -> np.ndarray:
        return np.asarray((b * np.sin(omega * tau)) ** 2)

    def rates(tau: float, y: np.ndarray) -> list[float]:
        x, v = y
        force = theta * (x - x**-5) + load(tau) * x**-3 + eta * v
        return [v, (6.0 * c * v**2 * x**-7 - 3.0 * force) / (1.0 + 2.0 * c * x**-6)]

    times = np.linspace(0.0, 12.0, 40)
    body = rm.Actuator(c=c, temperature=293.0 * theta, dissipation=rm.Rayleigh(eta))
    for tolerance in (1e-4, 1e-7):
        ds = rm.simulate(body, rm.SineSquared(b, omega), times=times, tolerance=tolerance)
        x, v = solve_ivp(rates, (0, 12), [1, 0], "DOP853", times, rtol=1e-12, atol=1e-13).y
        inertia = 1.0 + 2.0 * c * x**-6
        true = {
            "thickness_stretch": x**-2,
            "thickness_stretch_rate": -2.0 * v * x**-3,
            "energy": inertia * v**2 / 3.0 + theta * (2.0 * x**2 + x**-4 - 3.0) / 2.0
            - load(times) * x**-2,
        }  # fmt: skip
        for name, exact in true.items():
            off = np.abs(ds[name].values - exact).max()
            assert off <= float(ds[f"{name}_error"]) < 1e3 * tolerance, name
