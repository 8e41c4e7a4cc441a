"""Bounds of motions in which errors of rounding grow past those of the steps."""

from __future__ import annotations

import numpy as np

import remanent as rm
from remanent._typing import FloatArray
from remanent.integrate.ensemble.pool import KernelPool, PendingTrajectories
from remanent.integrate.ensemble.problem import Problem, Request
from remanent.integrate.ensemble.resolution import choose_method
from remanent.integrate.kernel.options import KernelOptions, Method
from remanent.integrate.methods.runge_kutta import default_method
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem

#: End of the run, tau; extremes are those of the second half.
END = 83.83798580308898
#: Double steps per cycle from which on shorter steps no longer help.
RESOLUTIONS = (512, 640, 768, 896, 1024, 1280, 1536, 1792, 2048, 3072)


def maximum_and_bound(
    problem: Problem, method: Method, resolution: int
) -> tuple[FloatArray, FloatArray]:
    """The maximum that one attempt at a resolution finds, and the bound of its error."""
    request = Request(wants_extremes=True, extremes_begin=np.full(1, 0.5 * END))
    options = KernelOptions(follows_extremes=True, own_steps="going on")
    pending = PendingTrajectories(np.array([0]), np.array([resolution]))
    with KernelPool(problem, method, options, 1e-3) as pool:
        ((_, attempt),) = pool.run_attempts(problem, request, pending)
    assert attempt.within_tolerance.all()
    return attempt.maximum, attempt.largest_error


def test_bounds_of_extremes_cover_what_rounding_has_become() -> None:
    """A thin cube thrown to six times its thickness: rounding has grown to 5e-7 at the end.

    Shorter steps do not lower it.  With the Runge-Kutta method it grows to 1e-8 only.
    """
    body = rm.Actuator(
        c=0.0010370766585762825,
        temperature=192.7999148452305,
        reference_temperature=293.0,
        prestress=1.8151911028552132,
    )
    drive = rm.Sine(
        m=1.7115275791828044,
        omega=4.576859958948118,
        mean=0.07656217714191338,
        phase=2.8051741710276676,
    )
    problem = initial_value_problem(lay_out_ensemble(body, drive, None), np.full(1, END))
    exact, _ = maximum_and_bound(problem, default_method(), 2048)
    adams = choose_method(Request(wants_extremes=True), 1e-6)
    found, bound = np.array([maximum_and_bound(problem, adams, r) for r in RESOLUTIONS])[..., 0].T
    error = np.abs(found - exact)
    assert np.median(error) > 1e-8
    assert (error <= bound).all()
