"""pynamicalsys: an adaptive Runge-Kutta pair compiled by Numba, one trajectory at a time."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.jobs import Job, thickness_stretch
from benchmarks.tools.tool import Package, Run, Tool, clocked
from remanent._typing import FloatArray


def build(job: Job) -> Run:
    import numba
    from pynamicalsys import ContinuousDynamicalSystem

    theta, prestress, b, c = job.theta, job.prestress, job.b, job.c

    @numba.njit  # type: ignore[untyped-decorator,unused-ignore]
    def rates(tau: float, u: Any, parameters: Any) -> Any:
        # The same form as Job.acceleration, in which Numba cannot look.
        x, v = u[0], u[1]
        load = b * np.sin(parameters[0] * tau)
        x2 = x * x
        x4, x7 = x2 * x2, x2 * x2 * x2 * x
        force = theta * (x4 * x4 - x2) + load * load * x4 - prestress * x7
        acceleration = (6.0 * c * v * v - 3.0 * force) / (x7 + 2.0 * c * x)
        return np.array([v, acceleration])

    system = ContinuousDynamicalSystem(
        equations_of_motion=rates, system_dimension=2, number_of_parameters=1
    )

    def run(omegas: FloatArray, tolerance: float) -> FloatArray:
        system.integrator("rk45", atol=tolerance, rtol=tolerance)
        ends = [
            system.trajectory([1.0, 0.0], job.window, parameters=[omega])[-1, 1]
            for omega in omegas.tolist()
        ]
        return np.asarray(thickness_stretch(np.array(ends)))[:, None]

    return clocked(run)


TOOL = Tool(
    "pynamicalsys",
    "pynamicalsys rk45, end state only",
    Package("pynamicalsys"),
    "end",
    build,
    sample=8,
)
