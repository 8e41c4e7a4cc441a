"""How finely trajectories must be resolved: where to begin, and what a beginning tells."""

from __future__ import annotations

from concurrent.futures import as_completed
from dataclasses import replace

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble.pool import Crew, Pending
from remanent.integrate.ensemble.problem import Problem, Request
from remanent.integrate.ensemble.segments import cycle_counts
from remanent.integrate.kernel.kernel import Method
from remanent.integrate.kernel.layout import PAST
from remanent.integrate.methods.adams import Adams, adams
from remanent.integrate.methods.runge_kutta import default_method

#: Refinement aims this factor below the tolerance.
MARGIN = 0.5
#: Below this tolerance rounding of past rates would show.
_FINE = 1e-10
#: Runs of so many cycles are begun for this part of them, to foresee the resolution from
#: the error there, which grows with this power of the time.
_LONG, _PART, _GROWTH = 24, 8, 1.5
#: The resolutions tried: 4, 5, 6, 7, 8, 10, 12, 14, 16 ...
_LADDER = np.array([base << k for k in range(40) for base in (4, 5, 6, 7)], dtype=np.int64)


def ladder(wanted: FloatArray | IntArray | float) -> IntArray:
    """The smallest of 4, 5, 6, 7, 8, 10, 12 ... that is not below `wanted`."""
    return np.asarray(_LADDER[np.searchsorted(_LADDER, wanted)])


def method_for(request: Request, tolerance: float) -> Method:
    """Adams for extremes, of many short runs; Runge-Kutta for states and for many digits.

    Adams is faster by evaluations, but needs a start, more memory, and loses digits to
    rounding sooner, which long runs show.
    """
    return adams(PAST) if request.extremes and tolerance >= _FINE else default_method()


def first_resolution(tolerance: float, method: Method) -> int:
    """Double steps per cycle to begin with: enough for a gentle trajectory.

    With fewer than the least, differences of solutions say little about their errors.
    """
    nine_digits, least = (28.0, 12.0) if isinstance(method, Adams) else (12.0, 6.0)
    return int(ladder(max(least, nine_digits * (1e-9 / tolerance) ** (1.0 / method.order))))


def finer(
    resolution: IntArray | int,
    error: FloatArray,
    tolerance: FloatArray | float,
    order: int,
    *,
    meaningless: float,
) -> IntArray:
    """What the order of the method predicts, between the next step up and fourfold.

    Errors from `meaningless` on no longer follow the order: twice as fine, then.
    """
    with np.errstate(all="ignore"):
        factor = (error / (MARGIN * tolerance)) ** (1.0 / order)
    factor = np.where(np.isfinite(factor) & (error < meaningless), factor, 2.0).clip(1.05, 4.0)
    return np.maximum(ladder(factor * resolution), ladder(np.asarray(resolution) + 1))


def foreseen(
    crew: Crew,
    problem: Problem,
    request: Request,
    pending: Pending,
    method: Method,
    *,
    most: int,
) -> Pending:
    """Trajectories with the resolution that the beginnings of long runs ask for.

    The error of an extreme or a state grows with the time, or with its square; what is
    foreseen too coarse is refined later, and what too fine costs little.
    """
    short = _shortened(problem, pending.index)
    has = short.duration[pending.index] > 0.0
    begun = Pending(pending.index[has], pending.resolution[has])
    resolution = np.zeros(problem.duration.shape, dtype=np.int64)
    resolution[pending.index] = pending.resolution
    least = first_resolution(np.inf, method)
    futures = crew.attempts(short, replace(request, begin=None), begun)
    for future in as_completed(futures):
        level, which = futures[future]
        growth = (problem.duration[which] / short.duration[which]) ** _GROWTH
        total = future.result().values["total"] * growth
        with np.errstate(all="ignore"):
            factor = (total / (MARGIN * crew.tolerance)) ** (1.0 / method.order)
        factor = np.where(np.isfinite(factor), factor, 2.0).clip(0.0, 2.0)
        resolution[which] = ladder(np.maximum(least, factor * level))
    return Pending(pending.index, np.minimum(resolution[pending.index], most))


def _shortened(problem: Problem, which: IntArray) -> Problem:
    """The beginnings of long runs; nothing of others."""
    cycles = np.zeros(problem.duration.shape, dtype=np.int64)
    if problem.timeline.periodic:
        cycles[which] = cycle_counts(problem, which)
    begun = np.where(cycles >= _LONG, cycles // _PART, 0)
    return replace(problem, duration=begun * problem.timeline.lengths[0])
