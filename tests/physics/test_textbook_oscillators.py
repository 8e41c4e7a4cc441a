"""Oscillators of the textbooks with known answers, through systems that users write."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ai_zeros, ellipk

import remanent as rm
from remanent._typing import FloatArray

#: Duffing's oscillator with one well, without damping.
SINGLE_WELL = rm.LagrangianSystem(
    coordinates="x",
    kinetic="x_rate**2/2",
    potential="a*x**2/2 + k*x**4/4 - load*x",
    parameters={"a": 1.0, "k": 1.0},
)
VAN_DER_POL = rm.FirstOrderSystem(
    rates={"x": "v", "v": "mu*(1 - x**2)*v - x"}, parameters={"mu": 1.0}, rest={"x": 2.0}
)
#: Two equal oscillators with a spring between them.
COUPLED = rm.LagrangianSystem(
    coordinates=("x", "y"),
    kinetic="(x_rate**2 + y_rate**2)/2",
    potential="(x**2 + y**2 + k*(x - y)**2)/2",
    parameters={"k": 0.1},
)
FREE = rm.Constant(0.0)


def test_the_backbone_of_the_single_well() -> None:
    """Duffing's x'' + x + x^3 = 0 has the frequencies of Jacobi's elliptic function cn.

    From rest at A the solution is A cn, omega = pi sqrt(1 + A^2)/(2 K(m)), where
    m = A^2/(2 (1 + A^2)) is the parameter of the complete elliptic integral.
    """
    start = np.array([0.1, 0.5, 1.0, 3.0, 10.0])
    found = rm.backbone(SINGLE_WELL, start)
    squared = 1.0 + start**2
    exact = np.pi * np.sqrt(squared) / (2.0 * ellipk(start**2 / (2.0 * squared)))
    assert (np.abs(found.frequency - exact) <= found.frequency_error).all()
    assert float(found.frequency_error.max()) < 1e-8


@pytest.mark.parametrize(("a", "k", "force"), [(1.0, 1.0, 0.1), (-1.0, 1.0, 0.7), (1.0, 0.2, 0.3)])
def test_the_subharmonic_that_is_a_cosine(a: float, k: float, force: float) -> None:
    """x'' + a x + k x^3 = F cos wt has the orbit A cos(wt/3), A^3 = 4 F/k, w^2/9 = a + 3 k A^2/4.

    For cos^3 s = (3 cos s + cos 3s)/4: the third harmonic of the spring is the load.
    """
    amplitude = (4.0 * force / k) ** (1.0 / 3.0)
    omega = 3.0 * np.sqrt(a + 0.75 * k * amplitude**2)
    system = SINGLE_WELL.replace(parameters={"a": a, "k": k})
    drive = rm.Sine(force, omega, phase=np.pi / 2.0)
    around = {"x": (amplitude - 0.05, amplitude + 0.05), "x_rate": (-0.05, 0.05)}
    found = rm.periodic_orbits(system, drive, orbit_period=3, state_box=around)
    away = np.abs(found.initial - [amplitude, 0.0]).max("state")
    here = found.isel(orbit=int(away.values.argmin()))
    assert float(away.min()) <= float(here.error) < 1e-8
    for name, exact in (("maximum", amplitude), ("minimum", -amplitude)):
        assert abs(float(here[name]) - exact) <= float(here[f"{name}_error"])


def limit_cycle(mu: float) -> tuple[float, float, float, float]:
    """Period and amplitude of van der Pol's limit cycle, with the error of each."""
    slow = 2.0 * np.pi + 2.0 * mu
    section = rm.poincare_section(
        VAN_DER_POL.replace(parameters={"mu": mu}),
        FREE,
        where="v",
        direction=-1,
        duration=slow * (3.0 + 8.0 / mu),
        tolerance=1e-8 if mu > 5.0 else 1e-10,
    )
    time, error = section.crossing_time.values, section.crossing_time_error.values
    period = float(time[-1] - time[-2])
    # The motion is on the cycle: the period before was the same.
    assert abs(period - (time[-2] - time[-3])) <= error[-3:].sum() + error[-2]
    return (
        period, float(error[-2:].sum()),
        float(section.x[-1]), float(section.state_error[-1]),
    )  # fmt: skip


@pytest.mark.parametrize("mu", [0.2, 0.1])
def test_the_weak_limit_cycle_of_van_der_pol(mu: float) -> None:
    """Van der Pol's weak cycle has T = 2 pi/(1 - mu^2/16 + 17 mu^4/3072) and A = 2 + mu^2/96.

    The series of Poincare and Lindstedt, up to O(mu^6) in the denominator and O(mu^4).
    """
    period, period_error, amplitude, amplitude_error = limit_cycle(mu)
    series = 2.0 * np.pi / (1.0 - mu**2 / 16.0 + 17.0 * mu**4 / 3072.0)
    assert abs(period - series) <= mu**6 + period_error
    assert abs(amplitude - 2.0 - mu**2 / 96.0) <= 0.01 * mu**4 + amplitude_error
    assert period_error < mu**6


@pytest.mark.parametrize("mu", [5.0, 10.0, 20.0])
def test_the_relaxation_oscillation_of_van_der_pol(mu: float) -> None:
    """Van der Pol's relaxation oscillation has the period and amplitude of Dorodnitsyn's series.

    T = (3 - 2 ln 2) mu + 3 a mu^(-1/3) - 2/3 ln mu/mu + O(1/mu), with -a the first zero of Ai, and
    A = 2 + a/3 mu^(-4/3) - 16/27 ln mu/mu^2 + O(1/mu^2): the series, corrected.
    """
    period, period_error, amplitude, amplitude_error = limit_cycle(mu)
    zero = -float(ai_zeros(1)[0][0])
    log = np.log(mu)
    series = (3.0 - 2.0 * np.log(2.0)) * mu + 3.0 * zero * mu ** (-1 / 3) - 2.0 / 3.0 * log / mu
    assert abs(period - series) < 2.0 / mu
    largest = 2.0 + zero / 3.0 * mu ** (-4 / 3) - 16.0 / 27.0 * log / mu**2
    assert abs(amplitude - largest) < 1.0 / mu**2
    assert max(period_error, amplitude_error) < 1e-8


def test_the_limit_cycle_between_both_limits() -> None:
    """Van der Pol's cycle between both limits is that of SciPy's DOP853.

    It finds where the rate vanishes on its own interpolant.
    """
    period, period_error, amplitude, amplitude_error = limit_cycle(1.0)

    def rates(_: float, y: FloatArray) -> list[float]:
        return [y[1], (1.0 - y[0] ** 2) * y[1] - y[0]]

    def rate(_: float, y: FloatArray) -> float:
        return float(y[1])

    run = solve_ivp(
        rates, (0.0, 60.0), [2.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-13, events=rate
    )
    assert run.t_events is not None
    assert run.y_events is not None
    times, states = run.t_events[0], run.y_events[0]
    tops = times[states[:, 0] > 0.0]
    assert abs(period - (tops[-1] - tops[-2])) <= period_error + 1e-10
    assert abs(amplitude - states[:, 0].max()) <= amplitude_error + 1e-10


def test_normal_modes_and_beats_of_coupled_oscillators() -> None:
    """Two coupled oscillators have the frequencies 1 and w = sqrt(1 + 2 k), and beat.

    From (1, 0) at rest the energy goes to and fro: x = cos((w + 1) t/2) cos((w - 1) t/2),
    y = sin((w + 1) t/2) sin((w - 1) t/2).
    """
    slow, fast = 1.0, np.sqrt(1.2)
    box = {"x": (-1.0, 1.0), "y": (-1.0, 1.0)}
    rest = rm.equilibria(COUPLED, 0.0, state_box=box).isel(equilibrium=0)
    off = np.abs(np.sort(np.abs(rest.eigenvalues.values.imag)) - [slow, slow, fast, fast])
    assert (off <= rest.eigenvalues_error.values.max()).all()
    motion = rm.simulate(COUPLED, FREE, duration=200.0, initial=(1.0, 0.0, 0.0, 0.0))
    mean, half_gap = (fast + slow) / 2.0 * motion.time, (fast - slow) / 2.0 * motion.time
    for name, exact in (
        ("x", np.cos(mean) * np.cos(half_gap)),
        ("y", np.sin(mean) * np.sin(half_gap)),
    ):
        assert float(np.abs(motion[name] - exact).max()) <= float(motion.error)
