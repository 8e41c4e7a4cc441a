"""Many trajectories, each refined until its error bound meets the tolerance.

Trajectories are tried at a first resolution.  Those whose bound is too large are
collected, sorted and tried again at the resolution that the known order of the
method predicts.  What one trajectory undergoes depends on nothing but itself, so
results are bit-identical however the work is divided.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from remanent._status import Status
from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble import short_runs
from remanent.integrate.ensemble.best_attempts import BestAttempts
from remanent.integrate.ensemble.pool import KernelPool, PendingTrajectories
from remanent.integrate.ensemble.problem import (
    EXTREME_NAMES,
    Outcome,
    Problem,
    Request,
    merge_outcomes,
)
from remanent.integrate.ensemble.progress import ProgressFunction, report_part_of_whole
from remanent.integrate.ensemble.refinement import RefinementPolicy
from remanent.integrate.ensemble.resolution import (
    MAX_RESOLUTION,
    choose_method,
    estimate_resolutions_from_beginnings,
    initial_resolutions,
)
from remanent.integrate.ensemble.run import Attempt, Chunk
from remanent.integrate.ensemble.work_sizes import DEFAULT_WORK_SIZES, WorkSizes
from remanent.integrate.kernel.options import KernelOptions, Method, OwnStepsKind

#: Looser tolerances are met with this one: with larger errors the difference of two
#: solutions is no measure of either (2 in 100 bounds at 1e-3 were too small).
LOOSEST_TOLERANCE_USED = 1e-4


def integrate(
    problem: Problem,
    request: Request,
    *,
    tolerance: float,
    method: Method | None = None,
    first_resolution: IntArray | None = None,
    max_resolution: int = MAX_RESOLUTION,
    workers: int | None = None,
    progress: ProgressFunction | None = None,
    sizes: WorkSizes = DEFAULT_WORK_SIZES,
) -> Outcome:
    """Integrate every trajectory to the tolerance, or as far as that is possible.

    Parameters
    ----------
    problem : Problem
        What to integrate.
    request : Request
        What to return.
    tolerance : float
        Of the error of what is returned, absolute.
    method : RungeKuttaMethod or AdamsMethod, optional
        Of the steps after the first few of every piece; by default as :func:`choose_method` says.
    first_resolution : array (trajectory,), optional
        Double steps per cycle to begin with, such as similar trajectories needed; 0 where that is
        to be found out.  Runs that end early in their first period do not take it over.
    max_resolution : int
        Refinement stops there with status ``MAX_STEPS``.
    workers : int, optional
        Threads; the number of processors by default.
    progress : callable, optional
        Called from this thread with the share of trajectories that are finished.
    sizes : WorkSizes
        How work is divided; results do not depend on it.

    Returns
    -------
    Outcome

    See Also
    --------
    remanent.integrate.events.find_crossings : Where an observable passes through a value.
    remanent.integrate.maps.period_map.PeriodMap : The map over whole drive periods.
    """
    short = short_runs.where_short(problem, request)
    if short.any():
        common: dict[str, Any] = {"method": method, "max_resolution": max_resolution}
        common |= {"tolerance": tolerance, "workers": workers, "sizes": sizes}

        def outcomes() -> Iterator[tuple[IntArray, Outcome]]:
            for indices, part, place in short_runs.split(problem, short):
                known = None if place.start == 0 else first_resolution
                yield (
                    indices,
                    integrate(
                        part,
                        short_runs.subset_of_request(request, indices),
                        first_resolution=None if known is None else known[indices],
                        progress=report_part_of_whole(progress, place, short.size),
                        **common,
                    ),
                )

        return merge_outcomes(short.size, outcomes())
    tolerance = min(tolerance, LOOSEST_TOLERANCE_USED)
    method = method or choose_method(request, tolerance)
    policy = RefinementPolicy(tolerance, method.order, max_resolution)
    best = BestAttempts.before_first_attempt(problem, request)
    # States at given times cost more than the steps: they are taken in one more attempt, when
    # the resolution is known.  Strobed states cost nothing and are taken on the way.
    search = replace(request, times=None, inspect_window=None)
    options = _kernel_options(request)
    with KernelPool(problem, method, options, tolerance, workers=workers, sizes=sizes) as pool:
        coarsest = np.minimum(initial_resolutions(problem, tolerance, method), max_resolution)
        pending = best.without_unaffordable(_every_valid_trajectory_pending_at(problem, coarsest))
        pending = estimate_resolutions_from_beginnings(
            pool, problem, search, pending, method, known=first_resolution, most=max_resolution
        )
        finished = problem.duration.size - pending.indices.size

        def record(chunk: Chunk, attempt: Attempt) -> PendingTrajectories:
            nonlocal finished
            again = best.without_unaffordable(best.record_attempt(policy, chunk, attempt))
            finished += chunk.indices.size - again.indices.size
            if progress is not None:
                progress(finished / problem.duration.size)
            return again

        pool.run_until_settled(problem, search, best.without_unaffordable(pending), record)
        if request.times is not None or request.inspect_window is not None:
            return best.outcome_with_samples(
                pool.run_attempts(problem, request, best.computed_trajectories())
            )
    return best.outcome


def states_of_known_run(
    problem: Problem, times: FloatArray, outcome: Outcome, *, tolerance: float
) -> FloatArray:
    """States of a run at further times, at the resolutions that it was found to need.

    They are those that :func:`integrate` gives, without the search for the resolutions.

    Parameters
    ----------
    problem : Problem
        What was integrated.
    times : array (trajectory, time)
        Ascending in every row.
    outcome : Outcome
        Of the problem, where no extremes were wanted.
    tolerance : float
        With which it was integrated.

    Returns
    -------
    array (trajectory, time, state)
    """
    request = Request(times=times)
    if short_runs.where_short(problem, request).any():
        states = integrate(problem, request, tolerance=tolerance).states
    else:
        tolerance = min(tolerance, LOOSEST_TOLERANCE_USED)
        best = BestAttempts.of_known_run(problem, request, outcome)
        method = choose_method(request, tolerance)
        with KernelPool(problem, method, KernelOptions(), tolerance) as pool:
            attempts = pool.run_attempts(problem, request, best.computed_trajectories())
            states = best.outcome_with_samples(attempts).states
    assert states is not None
    return states


def integrate_without_error_bound(
    problem: Problem,
    request: Request,
    *,
    resolution: int,
    workers: int | None = None,
) -> Outcome:
    """Integrate every trajectory once, without a second solution to estimate its error.

    Only ``benchmarks`` uses it, to measure beside programs that give no bound either; no verb
    of this package does.  Its ``error`` is NaN.

    Parameters
    ----------
    problem : Problem
        What to integrate.
    request : Request
        What to return.
    resolution : int
        Double steps per cycle, or per nominal time where the load has no period.
    workers : int, optional
        Threads; the number of processors by default.

    Returns
    -------
    Outcome
    """
    method = choose_method(request, LOOSEST_TOLERANCE_USED)
    outcome = BestAttempts.before_first_attempt(problem, request).outcome
    options = replace(_kernel_options(request), has_coarse_solution=False)
    with KernelPool(problem, method, options, np.inf, workers=workers) as pool:
        for chunk, attempt in pool.run_attempts(
            problem, request, _every_valid_trajectory_pending_at(problem, resolution)
        ):
            indices = chunk.indices
            finite = np.isfinite(attempt.last_state).all(axis=1)
            outcome.status[indices] = np.where(finite, Status.OK, Status.DIVERGED)
            outcome.horizon[indices] = problem.duration[indices]
            outcome.resolution[indices] = chunk.resolution
            for name in EXTREME_NAMES:
                getattr(outcome, name)[indices] = getattr(attempt, name)
            if outcome.states is not None and attempt.states is not None:
                outcome.states[indices, : attempt.states.shape[1]] = attempt.states
    return outcome


def _kernel_options(request: Request) -> KernelOptions:
    """What kernels follow; groups whose trajectories differ in their steps record no states."""
    own_steps: OwnStepsKind = "going on" if request.wants_extremes else "none"
    return KernelOptions(request.wants_extremes, own_steps=own_steps)


def _every_valid_trajectory_pending_at(
    problem: Problem, resolution: IntArray | int
) -> PendingTrajectories:
    """All trajectories that may be computed, at one resolution or each at its own."""
    indices = np.flatnonzero(~problem.invalid)
    of_all = np.broadcast_to(resolution, problem.duration.shape)
    return PendingTrajectories(indices, of_all[indices])
