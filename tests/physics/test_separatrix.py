"""Where motion crosses a stable manifold: by energy, and by another integrator."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import remanent as rm

LOAD, START = 2.5, 0.62


def potential(x: float, s: float) -> float:
    """V of equation (16) at theta = 1 under a constant load."""
    return 3.0 * (x**2 / 2 + x**-4 / 4 - s * x - LOAD * x**-2 / 2)


def middle(s: float) -> float:
    """The unstable equilibrium between two stable ones."""
    return float(brentq(lambda x: x - x**-5 - s + LOAD * x**-3, 0.9, 1.4))


def test_under_constant_load_the_manifold_is_a_level_of_energy() -> None:
    """Motion crosses it where its energy is that of the saddle: an equation in S alone."""
    exact = brentq(lambda s: potential(START, s) - potential(middle(s), s), 2.2, 2.45)
    ds = rm.manifold_crossing(
        rm.Actuator(),
        rm.Sine(0.0, 4.0, mean=LOAD),
        "prestress",
        (exact - 0.03, exact + 0.02),
        saddle=(middle(exact - 0.03), 0.0),
        initial=(START, 0.0),
        width=1e-9,
    )
    assert float(ds.prestress_error) <= 1e-9
    assert abs(float(ds.prestress) - exact) <= float(ds.prestress_error)
    assert float(ds.stretch) == pytest.approx(middle(exact), abs=1e-7)


def beyond(omega: float, saddle: float) -> bool:
    """Whether the motion from rest passes the saddle at 350 K, by DOP853."""

    def rates(tau: float, y: np.ndarray) -> list[float]:
        x, v = y
        m = (0.4 * math.sin(omega * tau)) ** 2
        force = 3.0 * (350.0 / 293.0 * (x**8 - x**2) + m * x**4)
        return [v, (6.0 * v * v - force) / (x**7 + 2.0 * x)]

    times = np.arange(90) * np.pi / omega
    run = solve_ivp(rates, (0.0, times[-1]), [1.0, 0.0], method="DOP853", t_eval=times,
                    rtol=1e-12, atol=1e-13)  # fmt: skip
    return bool(run.y[0].max() > saddle)


def test_the_jump_from_rest_is_where_another_integrator_sees_it() -> None:
    """Two runs by DOP853, 2e-7 apart, pass the saddle on different sides."""
    ds = rm.manifold_crossing(
        rm.Actuator(temperature=350),
        rm.SineSquared(0.4, 1.25),
        "omega",
        (1.25, 1.26),
        saddle=(1.433, 0.0),
        width=1e-9,
    )
    omega, stretch = float(ds.omega), float(ds.stretch)
    assert not beyond(omega - 1e-7, stretch)
    assert beyond(omega + 1e-7, stretch)


def test_a_bracket_without_a_crossing_is_refused() -> None:
    """Where the sides of the bracket do not differ, there is no crossing to find."""
    with pytest.raises(rm.InputError, match="one crossing"):
        rm.manifold_crossing(
            rm.Actuator(temperature=350),
            rm.SineSquared(0.4, 1.25),
            "omega",
            (1.2500, 1.2505),
            saddle=(1.433, 0.0),
            periods=60,
        )


def test_an_elliptic_orbit_is_no_saddle() -> None:
    """An elliptic orbit has no stable manifold, and is refused."""
    with pytest.raises(rm.InputError, match="near a saddle orbit"):
        rm.manifold_crossing(
            rm.Actuator(temperature=350),
            rm.SineSquared(0.4, 1.25),
            "omega",
            (1.25, 1.26),
            saddle=(1.113, 0.0),
        )
