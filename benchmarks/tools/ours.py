"""Remanent: through the public verb, with its error; and at one resolution, without."""

from __future__ import annotations

import numpy as np

import remanent as rm
from benchmarks.jobs import Job
from benchmarks.tools.tool import TOLERANCES, Package, Run, Tool, clocked
from remanent._typing import FloatArray
from remanent.integrate.ensemble.ensemble import integrate_without_error_bound
from remanent.integrate.ensemble.problem import Problem, Request
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem


def actuator(job: Job) -> rm.Actuator:
    """The actuator of a job."""
    return rm.Actuator(temperature=job.temperature, prestress=job.prestress, c=job.c)


def response_problem(job: Job, omegas: FloatArray) -> Problem:
    """The initial value problems of a job, in plain arrays."""
    ens = lay_out_ensemble(actuator(job), rm.SineSquared(job.b, 1.0), {"omega": omegas})
    return initial_value_problem(ens, np.full(omegas.size, job.window))


def build_verb(job: Job) -> Run:
    """Extremes of the thickness stretch through the public verb, which bounds their error."""
    drive = rm.SineSquared(job.b, 1.0)

    def run(omegas: FloatArray, tolerance: float) -> FloatArray:
        ds = rm.frequency_response(
            actuator(job), drive, omegas, duration=job.window, tolerance=tolerance
        )
        return np.column_stack([ds.maximum.values, ds.minimum.values])

    return clocked(run)


def build_fixed(job: Job) -> Run:
    """Extremes at one resolution for all, without the coarse solution that the bound needs."""

    def run(omegas: FloatArray, resolution: float) -> FloatArray:
        outcome = integrate_without_error_bound(
            response_problem(job, omegas),
            Request(wants_extremes=True),
            resolution=int(resolution),
            workers=1,
        )
        return np.column_stack([outcome.maximum, outcome.minimum])

    return clocked(run)


_PACKAGE = Package("remanent")
#: Double steps per cycle that are tried, cheapest first.
RESOLUTIONS = tuple(float(r) for r in np.unique(np.geomspace(8, 8192, 150).astype(int)))
FIXED = Tool(
    "remanent-fixed",
    "Remanent, one resolution, no bound",
    _PACKAGE,
    "extremes",
    build_fixed,
    settings=RESOLUTIONS,
    setting_name="double steps per cycle",
)
VERB = Tool(
    "remanent",
    "Remanent, with its error",
    _PACKAGE,
    "extremes",
    build_verb,
    settings=tuple(t for t in TOLERANCES if t >= 1e-12),
)
