"""Where the work goes: steps taken, over those that an oracle would take.

An oracle knows, of every trajectory, the least resolution with which its true error meets the
tolerance, and takes these steps alone.  What is taken beyond is told apart into factors:
resolutions that are finer than needed, runs that are thrown away, lanes that are idle, and the
second solution that tells the error.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any
from unittest.mock import patch

import numpy as np

from benchmarks.jobs import FILM, RESPONSE, Job
from benchmarks.machine import one_core
from benchmarks.rows.plan import Plan
from benchmarks.tools.ours import response_problem
from remanent._status import Status
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble import pool
from remanent.integrate.ensemble.attempt import attempt_chunk
from remanent.integrate.ensemble.counts import cycle_counts, fine_step_counts
from remanent.integrate.ensemble.ensemble import integrate, integrate_without_error_bound
from remanent.integrate.ensemble.problem import Outcome, Problem, Request
from remanent.integrate.ensemble.resolution import FINE_RESOLUTION_LADDER
from remanent.integrate.ensemble.run import Attempt, Chunk, Run

#: Work of both solutions over that of the first: the second has steps twice as long, or carries
#: amplified errors with half as many evaluations.
_COMPANION = 1.5
#: The reference solution has this share of the tolerance.
_REFERENCE_SHARE = 1e-4
#: Resolutions from here on are tried, up to this many times the finest that was used.
_COARSEST, _BEYOND_FINEST = 8, 2
#: Trajectories of a quick run.
_QUICK_COUNT = 96


@dataclass(frozen=True)
class Case:
    """Work whose steps are counted: a job, its tolerance, and whether states are asked for."""

    name: str
    job: Job
    tolerance: float
    states: bool = False


CASES = (
    Case("response", replace(RESPONSE, count=1024), 1e-8),
    Case("response, many frequencies", RESPONSE, 1e-8),
    Case("film", replace(FILM, count=1024), 1e-8),
    Case("film, many frequencies", replace(FILM, count=4096), 1e-8),
    Case("strong load, $b = 1.2$", replace(RESPONSE, b=1.2, count=512), 1e-8),
    Case("long window, $\\tau = 2000$", replace(RESPONSE, window=2000.0, count=256), 1e-6),
    Case("states at every period", replace(RESPONSE, count=1024), 1e-8, states=True),
)


@dataclass
class _Log:
    """What all chunks took together; grows as they end.

    Attributes
    ----------
    seconds, kept_seconds : float
        Of all runs, and of those that are kept.
    group_steps, steps : float
        Fine steps of all lanes of the groups, and of their motions.
    """

    seconds: float = 0.0
    kept_seconds: float = 0.0
    group_steps: float = 0.0
    steps: float = 0.0

    def add(self, run: Run, chunk: Chunk, kept: BoolArray, seconds: float) -> None:
        """Take in a chunk; `kept` says which of its runs are."""
        self.seconds += seconds
        self.kept_seconds += seconds * float(kept.mean())
        cycles, lanes = cycle_counts(run.problem, chunk.indices), run.kernel_pair.lane_count
        steps = np.sort(2.0 * chunk.resolution * cycles)[::-1]
        self.group_steps += lanes * float(steps[::lanes].sum())
        self.steps += float(steps.sum())


def measure(plan: Plan) -> dict[str, Any]:
    """The factors of every case."""
    with one_core():
        rows = [_row(plan, case) for case in CASES]
    return {"rows": rows, "companion": _COMPANION}


def _row(plan: Plan, case: Case) -> dict[str, Any]:
    job = replace(case.job, count=_QUICK_COUNT) if plan.quick else case.job
    problem = response_problem(job, job.omegas)
    request = Request(strobe_cycles=1) if case.states else Request(wants_extremes=True)

    def solved(tolerance: float) -> Outcome:
        return integrate(problem, request, tolerance=tolerance, workers=1)

    solved(case.tolerance)  # kernels are compiled here
    with _logged(problem.duration) as log:
        outcome = solved(case.tolerance)
    reference = solved(_REFERENCE_SHARE * case.tolerance)
    known = (outcome.status == Status.OK) & (reference.status == Status.OK)
    least = _least_resolutions(problem, request, case.tolerance, outcome, reference)
    used = _steps(problem, outcome.resolution)[known].sum()
    finer = used / _steps(problem, least)[known].sum()
    runs, lanes = log.seconds / log.kept_seconds, log.group_steps / log.steps
    true = _difference(outcome, reference, case.states)
    ratio = outcome.error[known] / np.maximum(true[known], np.finfo(float).eps)
    plan.say(f"steps: {case.name}: {finer:.2f} finer, {runs:.2f} runs, {lanes:.2f} lanes")
    return {
        "name": case.name,
        "trajectories": job.count,
        "known": int(known.sum()),
        "tolerance": case.tolerance,
        "resolution": float(finer),
        "runs": float(runs),
        "lanes": float(lanes),
        "all": float(finer * runs * lanes * _COMPANION),
        "bound_over_error": float(np.median(ratio)),
    }


@contextmanager
def _logged(duration: FloatArray) -> Iterator[_Log]:
    """All chunks that are attempted in the block; those as long as `duration` may be kept."""
    log = _Log()

    def attempt(run: Run, chunk: Chunk) -> Attempt:
        begin = time.perf_counter()
        result = attempt_chunk(run, chunk)
        seconds = time.perf_counter() - begin
        whole = run.problem.duration[chunk.indices] >= duration[chunk.indices]
        log.add(run, chunk, result.within_tolerance & whole, seconds)
        return result

    with patch.object(pool, "attempt_chunk", attempt):
        yield log


def _least_resolutions(
    problem: Problem, request: Request, tolerance: float, outcome: Outcome, reference: Outcome
) -> IntArray:
    """The resolution from which on the true error of each trajectory meets the tolerance."""
    ladder = FINE_RESOLUTION_LADDER
    finest = _BEYOND_FINEST * outcome.resolution.max()
    tried = ladder[(ladder >= _COARSEST) & (ladder <= finest)]
    least = np.full(problem.duration.size, tried[0])
    for resolution, finer in itertools.pairwise(tried.tolist()):
        run = integrate_without_error_bound(problem, request, resolution=resolution, workers=1)
        met = _difference(run, reference, request.strobe_cycles > 0) <= tolerance
        least[~met | (run.status != Status.OK)] = finer
    return least


def _difference(one: Outcome, other: Outcome, states: bool) -> FloatArray:
    """Largest difference of extremes, or of states, array (trajectory,)."""
    if not states:
        return np.maximum(np.abs(one.maximum - other.maximum), np.abs(one.minimum - other.minimum))
    assert one.states is not None
    assert other.states is not None
    # After the end of a run there are no states.
    distance = np.abs(one.states - other.states)
    return np.asarray(np.nanmax(distance.reshape(len(distance), -1), axis=1))


def _steps(problem: Problem, resolution: IntArray) -> FloatArray:
    """Fine steps of every trajectory, each at its resolution."""
    steps = np.zeros(problem.duration.size)
    for level in np.unique(resolution[resolution > 0]):
        members = np.flatnonzero(resolution == level)
        steps[members] = fine_step_counts(problem, int(level), members)
    return steps
