"""The best attempt of every trajectory so far, which becomes the outcome of a run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from remanent._status import Status
from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble.counts import NOMINAL, cycle_counts, step_counts
from remanent.integrate.ensemble.pool import Pending
from remanent.integrate.ensemble.problem import Outcome, Problem, Request
from remanent.integrate.ensemble.refinement import (
    AttemptSummary,
    Decision,
    History,
    RefinementPolicy,
    Trajectories,
)
from remanent.integrate.ensemble.resolution import MAX_RESOLUTION
from remanent.integrate.ensemble.run import Attempt, Chunk

#: Most fine steps of one trajectory.
MAX_STEPS = 2.0**28
#: For a slow drive the largest resolution is up to so many times larger.
_MOST_SLOWNESS = 16.0
#: Longest cycle that is resolved with that many steps, at four double steps per nominal time.
_LONGEST_CYCLE = NOMINAL * MAX_RESOLUTION * _MOST_SLOWNESS / 4.0
#: Least round-off, in units of the last place per root of a step.
_ROUND_OFF = 1.0


@dataclass(frozen=True)
class BestAttempts:
    """The best attempt of every trajectory so far.

    What changes: the arrays of `outcome`, and `stalls`, are written as attempts come in.

    Attributes
    ----------
    problem : Problem
    outcome : Outcome
        Of the best attempts.
    stalls : array (trajectory,)
        See :class:`~remanent.integrate.ensemble.refinement.History`.
    """

    problem: Problem
    outcome: Outcome
    stalls: IntArray

    @classmethod
    def none(cls, problem: Problem, request: Request) -> Self:
        """Before the first attempt."""
        count = problem.duration.size
        return cls(problem, _empty(problem, request), np.zeros(count, dtype=np.int64))

    def trajectories(self, indices: IntArray) -> Trajectories:
        """What of some trajectories does not depend on how they are resolved."""
        timeline = self.problem.timeline
        lengths = timeline.piece_lengths[0, indices]
        slowness = np.ones(indices.size)
        if timeline.periodic:
            slowness = (lengths / NOMINAL).clip(1.0, _MOST_SLOWNESS)
        return Trajectories(self.problem.duration[indices], lengths.clip(max=NOMINAL), slowness)

    def history(self, indices: IntArray) -> History:
        """What the attempts of some trajectories came to so far."""
        outcome = self.outcome
        return History(
            outcome.horizon[indices],
            outcome.resolution[indices],
            self.stalls[indices],
            outcome.status[indices],
        )

    def settle(self, policy: RefinementPolicy, chunk: Chunk, attempt: Attempt) -> Pending:
        """Take in the attempt of a chunk; tell which of its trajectories to try again."""
        indices = chunk.indices
        summary = AttemptSummary(
            chunk.resolution,
            attempt.within_tolerance,
            attempt.horizon,
            attempt.error_to_horizon,
            attempt.largest_error,
            attempt.size,
        )
        decision = policy.decide(self.trajectories(indices), self.history(indices), summary)
        self._keep(chunk, attempt, decision)
        return Pending(indices[decision.refine], decision.resolution[decision.refine])

    def _keep(self, chunk: Chunk, attempt: Attempt, decision: Decision) -> None:
        """Replace the results of those trajectories that are better now."""
        outcome, met = self.outcome, attempt.within_tolerance
        self.stalls[chunk.indices] = decision.stalls
        outcome.status[chunk.indices] = decision.status
        source = np.flatnonzero(decision.improved)
        target = chunk.indices[source]
        outcome.horizon[target] = decision.horizon[source]
        outcome.resolution[target] = chunk.resolution
        floor = self._round_off(chunk, decision.horizon)
        error = np.where(met, attempt.largest_error, attempt.error_to_horizon)
        outcome.error[target] = np.maximum(error, floor)[source]
        # Extremes of a part of the run are not those of the run.
        outcome.maximum[target] = np.where(met, attempt.maximum, np.nan)[source]
        outcome.minimum[target] = np.where(met, attempt.minimum, np.nan)[source]
        if outcome.states is not None and attempt.states is not None:
            reached = attempt.states.shape[1]  # of the longest in its chunk
            outcome.states[target, :reached] = attempt.states[source]

    def _round_off(self, chunk: Chunk, horizon: FloatArray) -> FloatArray:
        """Least error that rounding makes: it walks at random, by a last place in each step."""
        timeline, initial = self.problem.timeline, self.problem.initial[chunk.indices]
        cycle = timeline.piece_lengths[0, chunk.indices] if timeline.periodic else NOMINAL
        steps = 2 * chunk.resolution * horizon / cycle
        scale = np.maximum(1.0, np.abs(initial).max(axis=1))
        return np.asarray(_ROUND_OFF * np.finfo(float).eps * scale * np.sqrt(1.0 + steps))

    def affordable(self, pending: Pending) -> Pending:
        """Leave out what would take too many steps; that is its status."""
        timeline = self.problem.timeline
        possible = np.zeros(pending.indices.size, dtype=np.bool_)
        for level in np.unique(pending.resolution):
            members = pending.resolution == level
            indices = pending.indices[members]
            steps = step_counts(self.problem, int(level), indices)
            # A cycle too long to be resolved at all, even if the run ends early in it.
            too_long = (timeline.piece_lengths[:, indices] > _LONGEST_CYCLE).any(axis=0)
            possible[members] = (steps <= MAX_STEPS) & ~(timeline.periodic & too_long)
        self.outcome.status[pending.indices[~possible]] = Status.MAX_STEPS
        return Pending(pending.indices[possible], pending.resolution[possible])

    def computed(self) -> Pending:
        """Trajectories that were computed, and the resolution that reached furthest."""
        indices = np.flatnonzero(self.outcome.resolution > 0)
        return Pending(indices, self.outcome.resolution[indices])

    def sampled(self, attempts: Iterable[tuple[Chunk, Attempt]]) -> Outcome:
        """The outcome with the states, and the findings, of one more attempt of each."""
        findings: list[Any] = []
        for chunk, attempt in attempts:
            if self.outcome.states is not None and attempt.states is not None:
                self.outcome.states[chunk.indices] = attempt.states
            findings += attempt.findings
        return replace(self.outcome, findings=tuple(findings))


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
