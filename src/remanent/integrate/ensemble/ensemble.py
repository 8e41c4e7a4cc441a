"""Many trajectories, each refined until its error bound meets the tolerance.

Trajectories are tried at a first resolution.  Those whose bound is too large are
collected, sorted and tried again at the resolution that the known order of the
method predicts.  What one trajectory undergoes depends on nothing but itself, so
results are bit-identical however the work is divided.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import as_completed
from dataclasses import replace
from typing import Any

import numpy as np

from remanent._status import Status
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble.pool import Crew, Futures, Pending, joined
from remanent.integrate.ensemble.problem import Outcome, Problem, Request
from remanent.integrate.ensemble.resolution import finer, first_resolution, foreseen, method_for
from remanent.integrate.ensemble.segments import (
    NOMINAL,
    NONLINEAR,
    Attempt,
    cycle_counts,
    step_counts,
)
from remanent.integrate.kernel.kernel import Method, Options

#: Largest resolution tried, double steps per cycle.
MAX_RESOLUTION = 2**14
#: Most fine steps of one trajectory.
MAX_STEPS = 2.0**28
#: For a slow drive the largest resolution is up to so many times larger.
_SLOWEST = 16.0
_LONGEST_PERIOD = NOMINAL * MAX_RESOLUTION * _SLOWEST / 4.0
#: Looser tolerances are met with this one: with larger errors the difference of two
#: solutions is no measure of either (2 in 100 bounds at 1e-3 were too small).
COARSEST = 1e-4
#: A state beyond this has left the range of any actuator.
ESCAPE = 1e6
#: Least round-off, in units of the last place per root of a step.
_ROUND_OFF = 1.0
#: A horizon that grows by less than this factor on refinement will not reach the end.
_STALLED = 1.05
#: Refinement is given up at the first such attempt with so many times the steps of the best,
#: at the second if the horizon lies past this share of the run ...
_FINER, _ALMOST = 1.5, 0.8
#: ... but not while it lies within so many cycles, in which a fast stretch of time may just
#: not be resolved,
_BEGUN = 3.0
#: nor where the error was below this share of the tolerance until it passed it.
_JUMP = 0.05
Progress = Callable[[float], None]


def integrate(
    problem: Problem,
    request: Request,
    *,
    tolerance: float,
    method: Method | None = None,
    max_resolution: int = MAX_RESOLUTION,
    workers: int | None = None,
    progress: Progress | None = None,
) -> Outcome:
    """Integrate every trajectory to the tolerance, or as far as that is possible.

    Parameters
    ----------
    problem, request
        What to integrate and what to return.
    tolerance
        Of the error of what is returned, absolute.
    method
        Of the steps after the first few of every piece; by default as :func:`method_for` says.
    max_resolution
        Refinement stops there with status ``MAX_STEPS``.
    workers
        Threads; the number of processors by default.
    progress
        Called from this thread with the share of trajectories that are finished.

    Returns
    -------
    Outcome
    """
    tolerance = min(tolerance, COARSEST)
    method = method or method_for(request, tolerance)
    outcome = _empty(problem, request)
    index = np.flatnonzero(~problem.invalid)
    first = min(max_resolution, first_resolution(tolerance, method))
    pending = Pending(index, np.full(index.size, first))
    stalls = np.zeros(problem.duration.size, dtype=np.int64)
    late = request.times is not None or request.inspect is not None
    search = replace(request, times=None, inspect=None)  # these cost more than the steps
    with Crew(problem, method, Options(request.extremes), tolerance, workers) as crew:
        pending = _affordable(problem, outcome, pending)
        pending = foreseen(crew, problem, search, pending, method, most=max_resolution)
        while pending.index.size:
            pending = _affordable(problem, outcome, pending)
            futures = crew.attempts(problem, search, pending)
            again = _settled(
                problem, outcome, futures, tolerance, max_resolution, stalls, method.order
            )
            pending = joined(again)
            if progress is not None:
                progress(1.0 - pending.index.size / max(problem.duration.size, 1))
        if late:
            found = Pending(*_found(outcome))
            outcome = _sampled(outcome, crew.attempts(problem, request, found))
    return outcome


def integrate_unbounded(
    problem: Problem,
    request: Request,
    *,
    resolution: int,
    workers: int | None = None,
) -> Outcome:
    """Integrate every trajectory once, without a second solution to tell its error.

    For measurements beside programs that give no bound either: what is returned has NaN for
    its ``error``, and no verb of this package uses it.

    Parameters
    ----------
    problem, request, workers
        As for :func:`integrate`.
    resolution
        Double steps per cycle, or per nominal time where the load has no period.
    """
    method = method_for(request, COARSEST)
    outcome = _empty(problem, request)
    index = np.flatnonzero(~problem.invalid)
    pending = Pending(index, np.full(index.size, resolution))
    options = Options(request.extremes, companion=False)
    with Crew(problem, method, options, np.inf, workers) as crew:
        futures = crew.attempts(problem, request, pending)
        for future in as_completed(futures):
            level, which = futures[future]
            result = future.result()
            finite = np.isfinite(result.last).all(axis=1)
            outcome.status[which] = np.where(finite, Status.OK, Status.DIVERGED)
            outcome.horizon[which] = problem.duration[which]
            outcome.resolution[which] = level
            outcome.maximum[which] = result.values["maximum"]
            outcome.minimum[which] = result.values["minimum"]
            if outcome.states is not None and result.states is not None:
                outcome.states[which, : result.states.shape[1]] = result.states
    return outcome


def _found(outcome: Outcome) -> tuple[IntArray, IntArray]:
    """Trajectories that were computed, and the resolution that reached furthest."""
    index = np.flatnonzero(outcome.resolution > 0)
    return index, outcome.resolution[index]


def _sampled(outcome: Outcome, futures: Futures) -> Outcome:
    """Take in the states at the times wanted, and what was found between them."""
    findings: list[Any] = []
    for future in as_completed(futures):
        result = future.result()
        if outcome.states is not None and result.states is not None:
            outcome.states[futures[future][1]] = result.states
        findings += result.findings
    return replace(outcome, findings=tuple(findings))


def _affordable(problem: Problem, outcome: Outcome, pending: Pending) -> Pending:
    """Leave out what would take too many steps; that is its status."""
    possible = np.zeros(pending.index.size, dtype=np.bool_)
    for level in np.unique(pending.resolution):
        members = pending.resolution == level
        steps = step_counts(problem, int(level), pending.index[members])
        lengths = problem.timeline.lengths[:, pending.index[members]]
        # A cycle too long to be resolved at all, even if the run ends early in it.
        endless = problem.timeline.periodic & (lengths > _LONGEST_PERIOD).any(axis=0)
        possible[members] = (steps <= MAX_STEPS) & ~endless
    outcome.status[pending.index[~possible]] = Status.MAX_STEPS
    return Pending(pending.index[possible], pending.resolution[possible])


def _settled(
    problem: Problem,
    outcome: Outcome,
    futures: Futures,
    tolerance: float,
    max_resolution: int,
    stalls: IntArray,
    order: int,
) -> list[Pending]:
    """Take in finished chunks; tell which trajectories to try again and how finely."""
    again = [Pending(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))]
    for future in as_completed(futures):
        resolution, which = futures[future]
        result = future.result()
        hopeless = _record(problem, outcome, result, resolution, which, stalls, tolerance)
        unfinished = (result.values["alive"] < 0.5) & ~hopeless
        wanted = finer(resolution, result.values["total"], tolerance, order, meaningless=NONLINEAR)
        possible = wanted <= max_resolution * _slowness(problem, which)
        begun = outcome.horizon[which] > _begun(problem, which)
        unresolved = ~begun | (stalls[which] == 0)
        capped = unfinished & ~possible & unresolved & (outcome.status[which] != Status.SINGULAR)
        outcome.status[which[capped]] = Status.MAX_STEPS
        retry = unfinished & possible
        again.append(Pending(which[retry], wanted[retry]))
    return again


def _slowness(problem: Problem, which: IntArray) -> FloatArray:
    """How many times longer a drive period is than the nominal time, up to a limit."""
    if not problem.timeline.periodic:
        return np.ones(which.size)
    return np.asarray((problem.timeline.lengths[0, which] / NOMINAL).clip(1.0, _SLOWEST))


def _record(
    problem: Problem,
    outcome: Outcome,
    result: Attempt,
    resolution: int,
    which: IntArray,
    stalls: IntArray,
    tolerance: float,
) -> BoolArray:
    """Keep the attempt where it is the best so far; tell where refining is in vain."""
    values = result.values
    ok = values["alive"] > 0.5
    horizon = np.where(ok, problem.duration[which], values["horizon"])
    before = outcome.horizon[which]
    # An error that jumps past the tolerance tells of steps too long for a fast stretch of
    # the motion; one that grows past it, of a motion that magnifies errors.
    jumped = values["error"] < _JUMP * tolerance
    stuck = horizon <= _STALLED * before
    telling = stuck & ~jumped & (resolution >= _FINER * outcome.resolution[which])
    stalls[which] = np.where(stuck, stalls[which] + telling, 0)
    begun = horizon > _begun(problem, which)
    patience = np.where(horizon > _ALMOST * problem.duration[which], 2, 1)
    stalled = ~ok & begun & (stalls[which] >= patience)
    better = ok | (outcome.resolution[which] == 0) | (horizon > before)
    target, source = which[better], np.flatnonzero(better)
    outcome.horizon[target] = horizon[source]
    outcome.resolution[target] = resolution
    outcome.status[target] = np.where(ok, Status.OK, Status.HORIZON)[source]
    floor = _round_off(problem, horizon, resolution, which)
    error = np.where(ok, values["total"], values["error"])
    outcome.error[target] = np.maximum(error, floor)[source]
    for name, into in (("maximum", outcome.maximum), ("minimum", outcome.minimum)):
        into[target] = np.where(ok, values[name], np.nan)[source]
    if outcome.states is not None and result.states is not None:
        reached = result.states.shape[1]  # of the longest in its chunk
        outcome.states[target, :reached] = result.states[source]
    # Steps that are too long run away as well, but not twice to the same time.
    escaped = ~ok & stuck & (np.abs(result.last).max(axis=1) > ESCAPE)
    outcome.status[which[escaped]] = Status.ESCAPED
    at_once = ~ok & (horizon <= 0.0) & np.isnan(values["total"])
    outcome.status[which[at_once]] = Status.SINGULAR
    return np.asarray(stalled | escaped)


def _begun(problem: Problem, which: IntArray) -> FloatArray:
    """When a motion has shown its fast stretches of time."""
    return np.asarray(_BEGUN * problem.timeline.lengths[0, which].clip(max=NOMINAL))


def _round_off(
    problem: Problem, horizon: FloatArray, resolution: int, which: IntArray
) -> FloatArray:
    if problem.timeline.periodic:
        steps = 2 * resolution * horizon / problem.timeline.lengths[0, which]
    else:
        steps = 2 * resolution * horizon / NOMINAL
    scale = np.maximum(1.0, np.abs(problem.initial[which]).max(axis=1))
    return np.asarray(_ROUND_OFF * np.finfo(float).eps * scale * np.sqrt(1.0 + steps))


def _empty(problem: Problem, request: Request) -> Outcome:
    count, dimension = problem.initial.shape
    states = None
    if request.strobe:
        samples = int(cycle_counts(problem).max(initial=0)) // request.strobe + 1
        states = np.full((count, samples, dimension), np.nan)
    elif request.times is not None:
        states = np.full((count, request.times.shape[1], dimension), np.nan)
    status = np.where(problem.invalid, Status.INVALID, Status.NOT_COMPUTED).astype(np.int8)
    maximum, minimum, error, horizon = (np.full(count, np.nan) for _ in range(4))
    return Outcome(
        states, maximum, minimum, error, horizon, status, np.zeros(count, dtype=np.int64)
    )
