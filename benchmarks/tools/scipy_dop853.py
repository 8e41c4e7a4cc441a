"""SciPy's DOP853, one trajectory after the other."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.jobs import Job, thickness_stretch
from benchmarks.tools.tool import TOLERANCES, Package, Run, Tool, clocked
from remanent._typing import FloatArray


def build(job: Job) -> Run:
    def one(omega: float, tolerance: float) -> Any:
        def rates(tau: float, y: Any) -> tuple[float, float]:
            # Python's floats are faster than NumPy's.
            x, v = y.tolist()
            load = job.b * math.sin(omega * tau)
            return v, job.acceleration(load * load, x, v)

        solution = solve_ivp(
            rates, (0.0, job.window), (1.0, 0.0), method="DOP853", rtol=tolerance, atol=tolerance
        )
        return thickness_stretch(solution.y[0, -1])

    def run(omegas: FloatArray, tolerance: float) -> FloatArray:
        return np.array([[one(omega, tolerance)] for omega in omegas.tolist()])

    return clocked(run)


TOOL = Tool(
    "scipy",
    "SciPy DOP853, end state only",
    Package("scipy"),
    "end",
    build,
    settings=tuple(t for t in TOLERANCES if t > 3e-14),  # below, SciPy takes its own
    sample=8,
    compiles=False,
)
