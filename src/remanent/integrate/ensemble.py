"""Many trajectories, each refined until its error bound meets the tolerance.

Trajectories are tried at a first resolution.  Those whose bound is too large are
collected, sorted and tried again at the resolution that the known order of the
method predicts.  What one trajectory undergoes depends on nothing but itself, so
results are bit-identical however the work is divided.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.adams import Adams, adams
from remanent.integrate.chunk import (
    NOMINAL,
    NONLINEAR,
    Attempt,
    attempt,
    cycle_counts,
    double_steps,
    step_counts,
)
from remanent.integrate.compile import Kernels, compiled
from remanent.integrate.kernel import Method, Options
from remanent.integrate.layout import PAST
from remanent.integrate.methods import default_method
from remanent.integrate.problem import Outcome, Problem, Request
from remanent.integrate.status import Status
from remanent.integrate.tables import waveform_tables

#: Fine steps in a chunk: about a tenth of a second.
_CHUNK_STEPS = 2.0**23
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
#: Refinement aims this factor below the tolerance.
_MARGIN = 0.5
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
#: Below this tolerance rounding of past rates would show.
_FINE = 1e-10
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
    options = Options(extremes=request.extremes)
    method = method or method_for(request, tolerance)
    kernels = Kernels(
        compiled(problem.field, default_method(), options),
        compiled(problem.field, method, options),
    )
    outcome = _empty(problem, request)
    threads = workers or os.cpu_count() or 1
    index = np.flatnonzero(~problem.invalid)
    pending = _Pending(
        index, np.full(index.size, min(max_resolution, first_resolution(tolerance, method)))
    )
    stalls = np.zeros(problem.duration.size, dtype=np.int64)
    late = request.times is not None or request.inspect is not None
    search = replace(request, times=None, inspect=None)  # these cost more than the steps
    stop = threading.Event()

    @cache
    def tables(nodes: tuple[float, ...], resolution: int) -> tuple[FloatArray, FloatArray]:
        return waveform_tables(problem.timeline.waveform, nodes, resolution)

    with ThreadPoolExecutor(max_workers=threads) as pool:

        def start(
            request: Request, chunks: Iterator[tuple[int, IntArray]]
        ) -> dict[Future[Attempt], tuple[int, IntArray]]:
            def run(resolution: int, which: IntArray) -> Attempt:
                return attempt(
                    problem, request, kernels, tolerance, resolution, which, tables,
                    lambda: not stop.is_set(),
                )  # fmt: skip

            return {pool.submit(run, *chunk): chunk for chunk in chunks}

        try:
            while pending.index.size:
                pending = _affordable(problem, outcome, pending)
                chunks = _chunks(problem, pending, kernels.width, threads)
                futures = start(search, chunks)
                again = _settled(
                    problem, outcome, futures, tolerance, max_resolution, stalls, method.order
                )
                pending = _joined(again)
                if progress is not None:
                    progress(1.0 - pending.index.size / max(problem.duration.size, 1))
            if late:
                found = _Pending(*_found(outcome))
                outcome = _sampled(
                    outcome, start(request, _chunks(problem, found, kernels.width, threads))
                )
        except BaseException:
            stop.set()
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return outcome


def integrate_fixed(
    problem: Problem,
    request: Request,
    *,
    resolution: int,
    method: Method | None = None,
    workers: int | None = None,
) -> Outcome:
    """Integrate every trajectory with the same number of steps, and learn nothing of the error.

    For measurements of the kernel and of the order of a method: what is returned has NaN for
    its ``error``, and no verb of this package uses it.

    Parameters
    ----------
    problem, request, method, workers
        As for :func:`integrate`.
    resolution
        Double steps per cycle, or per nominal time where the load has no period.
    """
    options = Options(extremes=request.extremes, companion=False)
    method = method or (adams(PAST) if request.extremes else default_method())
    kernels = Kernels(
        compiled(problem.field, default_method(), options),
        compiled(problem.field, method, options),
    )
    outcome = _empty(problem, request)
    threads = workers or os.cpu_count() or 1
    index = np.flatnonzero(~problem.invalid)
    pending = _Pending(index, np.full(index.size, resolution))

    @cache
    def tables(nodes: tuple[float, ...], resolution: int) -> tuple[FloatArray, FloatArray]:
        return waveform_tables(problem.timeline.waveform, nodes, resolution)

    def run(chunk: tuple[int, IntArray]) -> tuple[IntArray, Attempt]:
        level, which = chunk
        return which, attempt(problem, request, kernels, np.inf, level, which, tables, lambda: True)

    with ThreadPoolExecutor(max_workers=threads) as pool:
        for which, result in pool.map(run, _chunks(problem, pending, kernels.width, threads)):
            finite = np.isfinite(result.last).all(axis=1)
            outcome.status[which] = np.where(finite, Status.OK, Status.DIVERGED)
            outcome.horizon[which] = problem.duration[which]
            outcome.resolution[which] = resolution
            outcome.maximum[which] = result.values["maximum"]
            outcome.minimum[which] = result.values["minimum"]
            if outcome.states is not None and result.states is not None:
                outcome.states[which, : result.states.shape[1]] = result.states
    return outcome


def _found(outcome: Outcome) -> tuple[IntArray, IntArray]:
    """Trajectories that were computed, and the resolution that reached furthest."""
    index = np.flatnonzero(outcome.resolution > 0)
    return index, outcome.resolution[index]


def _sampled(outcome: Outcome, futures: dict[Future[Attempt], tuple[int, IntArray]]) -> Outcome:
    """Take in the states at the times wanted, and what was found between them."""
    findings: list[Any] = []
    for future in as_completed(futures):
        result = future.result()
        if outcome.states is not None and result.states is not None:
            outcome.states[futures[future][1]] = result.states
        findings += result.findings
    return replace(outcome, findings=tuple(findings))


def _affordable(problem: Problem, outcome: Outcome, pending: _Pending) -> _Pending:
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
    return _Pending(pending.index[possible], pending.resolution[possible])


@dataclass(frozen=True)
class _Pending:
    """Trajectories to try, and how finely."""

    index: IntArray
    resolution: IntArray


def _joined(some: list[_Pending]) -> _Pending:
    return _Pending(
        np.concatenate([one.index for one in some]),
        np.concatenate([one.resolution for one in some]),
    )


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


def _settled(
    problem: Problem,
    outcome: Outcome,
    futures: dict[Future[Attempt], tuple[int, IntArray]],
    tolerance: float,
    max_resolution: int,
    stalls: IntArray,
    order: int,
) -> list[_Pending]:
    """Take in finished chunks; tell which trajectories to try again and how finely."""
    again = [_Pending(np.empty(0, dtype=np.int64), np.empty(0, dtype=np.int64))]
    for future in as_completed(futures):
        resolution, which = futures[future]
        result = future.result()
        hopeless = _record(problem, outcome, result, resolution, which, stalls, tolerance)
        unfinished = (result.values["alive"] < 0.5) & ~hopeless
        wanted = _next_resolution(result.values["total"], tolerance, resolution, order)
        possible = wanted <= max_resolution * _slowness(problem, which)
        begun = outcome.horizon[which] > _begun(problem, which)
        unresolved = ~begun | (stalls[which] == 0)
        capped = unfinished & ~possible & unresolved & (outcome.status[which] != Status.SINGULAR)
        outcome.status[which[capped]] = Status.MAX_STEPS
        retry = unfinished & possible
        again.append(_Pending(which[retry], wanted[retry]))
    return again


def _slowness(problem: Problem, which: IntArray) -> FloatArray:
    """How many times longer a drive period is than the nominal time, up to a limit."""
    if not problem.timeline.periodic:
        return np.ones(which.size)
    return np.asarray((problem.timeline.lengths[0, which] / NOMINAL).clip(1.0, _SLOWEST))


def _chunks(
    problem: Problem, pending: _Pending, width: int, threads: int
) -> Iterator[tuple[int, IntArray]]:
    """Group trajectories that share a resolution, step counts, and about a length."""
    cycles = cycle_counts(problem, pending.index)
    for level in np.unique(pending.resolution):
        members = pending.index[pending.resolution == level]
        steps = double_steps(problem.timeline, int(level), members)
        order = np.lexsort((members, cycles[pending.resolution == level], *steps[::-1]))
        members, steps = members[order], steps[:, order]
        cuts = np.flatnonzero((steps[:, 1:] != steps[:, :-1]).any(axis=0)) + 1
        for same in np.split(members, cuts):
            share = -(-same.size // (threads * width)) * width
            size = min(share, _fitting(problem, same, int(level), width))
            for first in range(0, same.size, size):
                yield int(level), same[first : first + size]


def _fitting(problem: Problem, which: IntArray, resolution: int, width: int) -> int:
    """How many trajectories make a chunk that is over soon, and is worth its overhead."""
    each = float(step_counts(problem, resolution, which[:1])[0])
    groups = np.clip(_CHUNK_STEPS / (each * width), 4, 256)
    return int(groups) * width


def _next_resolution(total: FloatArray, tolerance: float, resolution: int, order: int) -> IntArray:
    """What the order of the method predicts, between the next step up and fourfold."""
    with np.errstate(all="ignore"):
        factor = (total / (_MARGIN * tolerance)) ** (1.0 / order)
    factor = np.where(np.isfinite(factor) & (total < NONLINEAR), factor, 2.0).clip(1.05, 4.0)
    return np.maximum(ladder(factor * resolution), ladder(resolution + 1))


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
