"""A frequency response beside heyoka.py and SciPy, on one core, in one run.

Every tool integrates equation (16) with the load (0.4 sin ωτ)² from rest over τ = 100.
Ours gives the extremes of the thickness stretch and a bound on their error; the peers give
the state at the end only, without a bound, which is less work.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from importlib.metadata import version
from importlib.util import find_spec
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import remanent as rm
from remanent.integrate.ensemble import integrate
from remanent.integrate.problem import Request
from remanent.studies._ensemble import ensemble, problem

TRAJECTORIES, SAMPLE, WINDOW, THETA, B = 12_288, 24, 100.0, 350.0 / 293.0, 0.4
OMEGAS = np.linspace(0.5, 2.0, TRAJECTORIES)


def seconds(work: Callable[[], object], repeats: int = 3) -> float:
    """Median time of one call, after one that does not count."""
    work()
    times = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        times.append(time.perf_counter() - begin)
    return statistics.median(times)


def ours(tolerance: float) -> Callable[[], object]:
    """The ensemble with its error bound, one thread."""
    actuator = rm.Actuator(temperature=350.0)
    ens = ensemble(actuator, rm.SineSquared(B, 1.0), {"omega": OMEGAS})
    asked = problem(ens, np.full(TRAJECTORIES, WINDOW))
    return lambda: integrate(asked, Request(extremes=True), tolerance=tolerance, workers=1)


def heyoka(tolerance: float) -> Callable[[], object]:
    """Batches of eight lanes, one division, all trajectories."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    omega, theta, b = hy.par[0], hy.par[1], hy.par[2]
    load = b * hy.sin(omega * hy.time)
    m = load * load
    x2 = x * x
    x4, x7 = x2 * x2, x2 * x2 * x2 * x
    rate = (6.0 * v * v - 3.0 * (theta * (x4 * x4 - x2) + m * x4)) / (x7 + 2.0 * x)
    lanes = 8
    start = np.vstack([np.ones(lanes), np.zeros(lanes)])
    pars = np.vstack([np.ones(lanes), np.full(lanes, THETA), np.full(lanes, B)])
    ta = hy.taylor_adaptive_batch(
        [(x, v), (v, rate)], start, pars=pars, tol=tolerance, time=[0.0] * lanes
    )

    def work() -> None:
        for group in OMEGAS.reshape(-1, lanes):
            ta.set_time(0.0)
            ta.state[:] = start
            ta.pars[0] = group
            ta.propagate_until([WINDOW] * lanes)

    return work


def scipy(tolerance: float) -> Callable[[], object]:
    """DOP853 on a sample of the frequencies."""

    def work() -> None:
        for omega in OMEGAS[:: TRAJECTORIES // SAMPLE]:
            solve_ivp(_equation(float(omega)), (0.0, WINDOW), [1.0, 0.0], method="DOP853",
                      rtol=tolerance, atol=tolerance)  # fmt: skip

    return work


def _equation(omega: float) -> Callable[[float, Any], tuple[float, float]]:
    def rates(tau: float, y: Any) -> tuple[float, float]:
        x, v = y.tolist()
        load = (B * np.sin(omega * tau)) ** 2
        force = THETA * (x**8 - x**2) + load * x**4
        return v, (6.0 * v * v - 3.0 * force) / (x**7 + 2.0 * x)

    return rates


def main() -> None:
    """Print microseconds per trajectory and unit of tau, and ratios."""
    tolerance = 1e-8
    rows = [(f"remanent {version('remanent')}, extremes and bound", ours(tolerance), TRAJECTORIES)]
    if find_spec("heyoka") is not None:
        rows.append((f"heyoka.py {version('heyoka')}, batch of 8", heyoka(tolerance), TRAJECTORIES))
    rows.append((f"SciPy {version('scipy')} DOP853", scipy(tolerance), SAMPLE))
    first = None
    print(f"tolerance {tolerance:g}, one core, median of 3 after a first that does not count")
    for name, work, count in rows:
        cost = seconds(work) / count / WINDOW * 1e6
        first = first or cost
        print(f"{name:<42} {cost:10.3f} us per trajectory and tau {cost / first:10.1f} x")


if __name__ == "__main__":
    main()
