"""pynamicalsys: an adaptive Runge-Kutta pair compiled by Numba, one trajectory at a time.

The whole trajectory is asked for, and its last state is taken.  ``evolve_system``, which keeps
the last state only, takes 0.88 of the time, but in pynamicalsys 1.7.0 it ends later than it is
told, by its first step.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.jobs import Job, thickness_stretch
from benchmarks.tools.tool import Package, Run, Tool, clocked
from remanent._typing import FloatArray


def build(job: Job) -> Run:
    """The thickness stretch at the end, one motion after another."""
    import numba
    from pynamicalsys import ContinuousDynamicalSystem

    theta, prestress, c, half = job.theta, job.prestress, job.c, 0.5 * job.b**2

    @numba.njit(fastmath={"contract"})  # type: ignore[untyped-decorator,unused-ignore]
    def rates(tau: float, u: Any, parameters: Any) -> Any:
        # The same form as Job.acceleration, in which Numba cannot look.
        x, v = u[0], u[1]
        m = half - half * np.cos(2.0 * parameters[0] * tau)
        x2 = x * x
        x4, x7 = x2 * x2, x2 * x2 * x2 * x
        force = theta * (x4 * x4 - x2) + m * x4 - prestress * x7
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


def variational_system(theta: float) -> Any:
    """Stretch and rate of the cube without prestress, with their derivatives.

    Parameters of the system are the drive frequency omega and the root b of the peak load.
    """
    import numba
    from pynamicalsys import ContinuousDynamicalSystem

    @numba.njit(fastmath={"contract"})  # type: ignore[untyped-decorator,unused-ignore]
    def rates(tau: float, u: Any, parameters: Any) -> Any:
        x, v = u[0], u[1]
        omega, b = parameters[0], parameters[1]
        m = 0.5 * b * b * (1.0 - np.cos(2.0 * omega * tau))
        x2 = x * x
        x4 = x2 * x2
        force = theta * (x4 * x4 - x2) + m * x4
        return np.array([v, (6.0 * v * v - 3.0 * force) / (x4 * x2 * x + 2.0 * x)])

    @numba.njit(fastmath={"contract"})  # type: ignore[untyped-decorator,unused-ignore]
    def jacobian(tau: float, u: Any, parameters: Any) -> Any:
        x, v = u[0], u[1]
        omega, b = parameters[0], parameters[1]
        m = 0.5 * b * b * (1.0 - np.cos(2.0 * omega * tau))
        x2 = x * x
        x3, x4, x6 = x2 * x, x2 * x2, x2 * x2 * x2
        x7 = x6 * x
        # The acceleration is a quotient; each of its derivatives needs the same division.
        reciprocal = 1.0 / (x7 + 2.0 * x)
        acceleration = (6.0 * v * v - 3.0 * (theta * (x4 * x4 - x2) + m * x4)) * reciprocal
        by_stretch = -3.0 * (theta * (8.0 * x7 - 2.0 * x) + 4.0 * m * x3)
        out = np.zeros((2, 2))
        out[0, 1] = 1.0
        out[1, 0] = (by_stretch - acceleration * (7.0 * x6 + 2.0)) * reciprocal
        out[1, 1] = 12.0 * v * reciprocal
        return out

    return ContinuousDynamicalSystem(
        equations_of_motion=rates, jacobian=jacobian, system_dimension=2, number_of_parameters=2
    )


TOOL = Tool(
    "pynamicalsys",
    "pynamicalsys rk45, end state only",
    Package("pynamicalsys"),
    "end",
    build,
    sample=8,
)
