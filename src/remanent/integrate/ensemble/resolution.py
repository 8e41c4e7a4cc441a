"""How finely trajectories must be resolved: where to begin, and what errors say about it."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble.counts import (
    MAX_FINE_STEPS_PER_TRAJECTORY,
    NOMINAL_CYCLE_TIME,
    cycle_counts,
    cycle_lengths,
)
from remanent.integrate.ensemble.pool import KernelPool, PendingTrajectories
from remanent.integrate.ensemble.problem import Problem, Request
from remanent.integrate.kernel.layout import PAST_RATE_COUNT
from remanent.integrate.kernel.options import Method
from remanent.integrate.methods.adams import AdamsMethod, adams_method
from remanent.integrate.methods.runge_kutta import default_method


def _ladder(*bases: int) -> IntArray:
    """Some numbers from 4 on, below 8, and their multiples by powers of 2."""
    return np.array([base << k for k in range(40) for base in bases], dtype=np.int64)


#: Largest resolution tried, double steps per cycle.
MAX_RESOLUTION = 2**14
#: Refinement aims this factor below the tolerance.
TOLERANCE_SHARE_AIMED_AT = 0.5
#: Least factor by which a resolution is refined.
_MIN_REFINEMENT_FACTOR = 1.05
#: Largest factor by which a resolution is refined at once.
_MAX_REFINEMENT_FACTOR = 4.0
#: Factor of refinement where the error tells nothing about the resolution.
_BLIND_REFINEMENT_FACTOR = 2.0
#: Below this tolerance rounding of past rates would show in Adams steps.
_MIN_ADAMS_TOLERANCE = 1e-10
#: Least double steps of Adams in a cycle, or in a run, to begin with: errors of fewer say little
#: about those with other steps.
_LEAST_DOUBLE_STEPS_BY_ADAMS = 24.0
#: Tolerance for which the resolutions of :func:`initial_resolution` are given.
_REFERENCE_TOLERANCE = 1e-9
#: Runs of at least so many cycles, or nominal times, are begun to estimate their resolution.
_MIN_LONG_RUN_CYCLES = 24
#: The beginning is one part in so many of the run.
_RUN_TO_BEGINNING_RATIO = 8
#: The finest try of a beginning takes at most so many times the steps of the first; more in
#: proportion in a long cycle.
_MAX_REFINEMENT_OF_BEGINNING = 32
#: Errors of beginnings from here on foretell too little.
_LARGEST_TELLING_ERROR = 1e-4
#: A run takes at most so many times the steps per cycle of the last try of its beginning.
_MAX_FACTOR_FROM_BEGINNING = 3.0
#: Least double steps per cycle of a run that was begun, by Adams and by Runge-Kutta.
_LEAST_OF_RUN_BY_ADAMS, _LEAST_OF_RUN = 12, 6
#: The error of an extreme or a state grows with the time, or with its square: it is taken to
#: grow with this power.
_POWER_OF_TIME_IN_ERROR_GROWTH = 1.5
#: The resolutions tried: 4, 5, 6, 7, 8, 10, 12, 14, 16 ...
FINE_RESOLUTION_LADDER: Final = _ladder(4, 5, 6, 7)
#: Half as many, for calls with few points of many resolutions: 4, 6, 8, 12, 16 ...
COARSE_RESOLUTION_LADDER: Final = _ladder(4, 6)


def round_up_resolution(
    resolution: FloatArray | IntArray | float, ladder: IntArray = FINE_RESOLUTION_LADDER
) -> IntArray:
    """The smallest of a ladder of resolutions that is not below `resolution`."""
    return np.asarray(ladder[np.searchsorted(ladder, resolution)])


def choose_method(request: Request, tolerance: float) -> Method:
    """Adams for extremes, of many short runs; Runge-Kutta for states and for many digits.

    Adams is faster by evaluations, but needs a start, more memory, and loses digits to
    rounding sooner, which long runs show.
    """
    if request.wants_extremes and tolerance >= _MIN_ADAMS_TOLERANCE:
        return adams_method(PAST_RATE_COUNT)
    return default_method()


def initial_resolution(tolerance: float, method: Method) -> int:
    """Double steps per cycle to begin with: enough for a gentle trajectory."""
    by_adams = isinstance(method, AdamsMethod)
    reference, least = (28.0, _LEAST_DOUBLE_STEPS_BY_ADAMS) if by_adams else (12.0, 6.0)
    growth = (_REFERENCE_TOLERANCE / tolerance) ** (1.0 / method.order)
    return int(round_up_resolution(max(least, reference * growth)))


def initial_resolutions(problem: Problem, tolerance: float, method: Method) -> IntArray:
    """The same for every trajectory, array (trajectory,).

    It is larger where an Adams run is so short that it would have few steps.
    """
    resolution = np.full(problem.duration.shape, float(initial_resolution(tolerance, method)))
    if isinstance(method, AdamsMethod):
        with np.errstate(all="ignore"):
            of_run = _LEAST_DOUBLE_STEPS_BY_ADAMS * cycle_lengths(problem) / problem.duration
        # A run of no length needs none.
        resolution = np.maximum(resolution, np.nan_to_num(of_run, posinf=0.0))
    return round_up_resolution(resolution.clip(max=MAX_RESOLUTION))


def refine_resolution(
    resolution: IntArray | int,
    error: FloatArray,
    tolerance: FloatArray | float,
    order: int,
    *,
    asymptotic_limit: float,
    ladder: IntArray = FINE_RESOLUTION_LADDER,
) -> IntArray:
    """The resolution that the order of the method predicts to meet a tolerance.

    It is between the next one and four times as fine.

    Parameters
    ----------
    resolution : array (trajectory,) or int
        That was tried.
    error : array (trajectory,)
        Its error.
    tolerance : array (trajectory,) or float
        That was missed.
    order : int
        Of the global error.
    asymptotic_limit : float
        Errors from here on no longer follow the order: twice as fine, then.
    ladder : array of int
        The resolutions there are.
    """
    factor = _refinement_factor(error, tolerance, order, error < asymptotic_limit)
    factor = factor.clip(_MIN_REFINEMENT_FACTOR, _MAX_REFINEMENT_FACTOR)
    following = round_up_resolution(np.asarray(resolution) + 1, ladder)
    return np.maximum(round_up_resolution(factor * resolution, ladder), following)


def _refinement_factor(
    error: FloatArray, tolerance: FloatArray | float, order: int, is_asymptotic: BoolArray
) -> FloatArray:
    """How many times as fine the steps must be, by the order where the error follows it."""
    with np.errstate(all="ignore"):
        factor = (error / (TOLERANCE_SHARE_AIMED_AT * tolerance)) ** (1.0 / order)
    return np.where(is_asymptotic & np.isfinite(factor), factor, _BLIND_REFINEMENT_FACTOR)


def estimate_resolutions_from_beginnings(
    pool: KernelPool,
    problem: Problem,
    request: Request,
    pending: PendingTrajectories,
    method: Method,
    *,
    known: IntArray | None = None,
    most: int,
) -> PendingTrajectories:
    """Trajectories with the resolution that the beginnings of long runs ask for.

    An estimate that is too coarse is refined later; one that is too fine costs little.  Where a
    beginning loses the motion, it is tried again at twice the resolution: the run would lose it
    too, after more steps.  Where a resolution is `known` to be about right, array (trajectory,),
    and not 0, nothing is begun.
    """
    beginnings = _beginnings_of_long_runs(problem, pending.indices)
    resolution = np.zeros(problem.duration.shape, dtype=np.int64)
    resolution[pending.indices] = pending.resolution
    long = beginnings.duration > 0.0
    if known is not None:
        resolution = np.where(known > 0, round_up_resolution(known), resolution)
        long &= known == 0
    long_indices = pending.indices[long[pending.indices]]
    tried = PendingTrajectories(long_indices, resolution[long_indices])
    request = replace(
        request, extremes_begin=None
    )  # extremes may be asked for after the beginning only
    most_tried = np.zeros(problem.duration.shape)
    most_tried[tried.indices] = np.minimum(
        _most_double_steps_of_beginning(problem, tried.indices, pool.tolerance, method), most
    )
    while tried.indices.size:
        lost = np.zeros(problem.duration.shape, dtype=np.bool_)
        for chunk, attempt in pool.run_attempts(beginnings, request, tried):
            i = chunk.indices
            lost[i] = ~(attempt.largest_error < _LARGEST_TELLING_ERROR)
            resolution[i] = _resolution_of_run(
                attempt.largest_error,
                problem.duration[i] / beginnings.duration[i],
                chunk.resolution,
                pool.tolerance,
                method,
            )
        again = np.flatnonzero(lost & (resolution <= most_tried))
        tried = PendingTrajectories(again, resolution[again])
    return PendingTrajectories(pending.indices, np.minimum(resolution[pending.indices], most))


def _most_double_steps_of_beginning(
    problem: Problem, indices: IntArray, tolerance: float, method: Method
) -> FloatArray:
    """Up to how many double steps a cycle the beginnings of some runs are tried, array (run,)."""
    slowness = problem.load_schedule.piece_lengths[0, indices] / NOMINAL_CYCLE_TIME
    finest = _MAX_REFINEMENT_OF_BEGINNING * initial_resolution(tolerance, method)
    affordable = MAX_FINE_STEPS_PER_TRAJECTORY / (2.0 * cycle_counts(problem, indices))
    return np.asarray(np.minimum(finest * slowness.clip(min=1.0), affordable))


def _resolution_of_run(
    error: FloatArray,
    length_ratio: FloatArray,
    resolution: IntArray | int,
    tolerance: float,
    method: Method,
) -> IntArray:
    """The resolution of a run, from the error of its beginning and the ratio of their lengths."""
    grown = error * length_ratio**_POWER_OF_TIME_IN_ERROR_GROWTH
    is_asymptotic = error < _LARGEST_TELLING_ERROR
    factor = _refinement_factor(grown, tolerance, method.order, is_asymptotic)
    factor = factor.clip(max=_MAX_FACTOR_FROM_BEGINNING)
    least = _LEAST_OF_RUN_BY_ADAMS if isinstance(method, AdamsMethod) else _LEAST_OF_RUN
    return round_up_resolution(np.maximum(least, factor * resolution))


def _beginnings_of_long_runs(problem: Problem, indices: IntArray) -> Problem:
    """The beginnings of long runs; nothing of others."""
    beginning = np.zeros(problem.duration.shape)
    if problem.load_schedule.periodic:
        duration, length = (
            problem.duration[indices],
            problem.load_schedule.piece_lengths[0, indices],
        )
        cycles = cycle_counts(problem, indices)
        few_but_long = duration >= _MIN_LONG_RUN_CYCLES * NOMINAL_CYCLE_TIME
        beginning[indices] = np.where(
            cycles >= _MIN_LONG_RUN_CYCLES,
            cycles // _RUN_TO_BEGINNING_RATIO * length,
            np.where(few_but_long, duration / _RUN_TO_BEGINNING_RATIO, 0.0),
        )
    return replace(problem, duration=beginning)
