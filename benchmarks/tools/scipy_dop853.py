"""SciPy's DOP853: one trajectory after another, and many together as one system.

One after another is how most use it: each takes its own steps, and nearly all of the time goes
into Python between them.  Together, the steps are those of the hardest trajectory and the
error is a mean over all, but NumPy shares Python's time among the group.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.jobs import Job, thickness_stretch
from benchmarks.tools.tool import TOLERANCES, Package, Run, Tool, clocked
from remanent._typing import FloatArray

#: Neighbouring frequencies that step together; more are hardly faster, fewer are slower.
_GROUP = 1024


def build(job: Job) -> Run:
    """The thickness stretch at the end, one motion after another."""

    def end(omega: float, tolerance: float) -> Any:
        solution = solve_ivp(
            _rates(job, omega), (0.0, job.window), (1.0, 0.0), method="DOP853",
            rtol=tolerance, atol=tolerance,
        )  # fmt: skip
        return thickness_stretch(solution.y[0, -1])

    def run(omegas: FloatArray, tolerance: float) -> FloatArray:
        return np.array([[end(omega, tolerance)] for omega in omegas.tolist()])

    return clocked(run)


def _rates(job: Job, omega: float) -> Callable[[float, Any], tuple[float, float]]:
    """Rates of one motion, with every number in a local variable.

    It is the form of `Job.acceleration` in Python's floats, which are faster than NumPy's.
    """
    theta, prestress, c2, c6 = job.theta, job.prestress, 2.0 * job.c, 6.0 * job.c
    half, load_frequency, cos = 0.5 * job.b**2, 2.0 * omega, math.cos

    def rates(tau: float, y: Any) -> tuple[float, float]:
        x, v = y.tolist()
        m = half - half * cos(load_frequency * tau)
        x2 = x * x
        x4 = x2 * x2
        x7 = x4 * x2 * x
        force = theta * (x4 * x4 - x2) + m * x4 - prestress * x7
        return v, (c6 * (v * v) - 3.0 * force) / (x7 + c2 * x)

    return rates


def build_together(job: Job) -> Run:
    """The thickness stretch at the end, of groups of motions that take the same steps."""

    def ends(omegas: FloatArray, tolerance: float) -> FloatArray:
        count, half = omegas.size, 0.5 * job.b**2

        def rates(tau: float, y: FloatArray) -> FloatArray:
            x, v = y[:count], y[count:]
            m = half - half * np.cos((2.0 * tau) * omegas)
            return np.concatenate((v, job.acceleration(m, x, v)))

        solution = solve_ivp(
            rates, (0.0, job.window), np.repeat((1.0, 0.0), count), method="DOP853",
            rtol=tolerance, atol=tolerance, t_eval=(job.window,),
        )  # fmt: skip
        return np.asarray(thickness_stretch(solution.y[:count, -1]))[:, None]

    def run(omegas: FloatArray, tolerance: float) -> FloatArray:
        groups = [omegas[k : k + _GROUP] for k in range(0, omegas.size, _GROUP)]
        return np.concatenate([ends(group, tolerance) for group in groups])

    return clocked(run)


_PACKAGE = Package("scipy")
_SETTINGS = tuple(t for t in TOLERANCES if t > 3e-14)  # below, SciPy takes its own
TOOL = Tool(
    "scipy",
    "SciPy DOP853, end state only",
    _PACKAGE,
    "end",
    build,
    settings=_SETTINGS,
    sample=8,
    compiles=False,
)
TOGETHER = Tool(
    "scipy-together",
    f"SciPy DOP853, {_GROUP} motions as one system, end state only",
    _PACKAGE,
    "end",
    build_together,
    settings=_SETTINGS,
    compiles=False,
)
