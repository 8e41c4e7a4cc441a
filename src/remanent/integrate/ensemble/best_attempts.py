"""The best attempt of every trajectory so far, which becomes the outcome of a run."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from remanent._status import Status
from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble.counts import (
    MAX_FINE_STEPS_PER_TRAJECTORY,
    NOMINAL_CYCLE_TIME,
    cycle_counts,
    cycle_lengths,
    fine_step_counts,
)
from remanent.integrate.ensemble.pool import PendingTrajectories
from remanent.integrate.ensemble.problem import EXTREME_NAMES, Outcome, Problem, Request
from remanent.integrate.ensemble.refinement import (
    AttemptHistory,
    AttemptSummary,
    RefinementDecision,
    RefinementPolicy,
    TrajectoryScales,
)
from remanent.integrate.ensemble.resolution import MAX_RESOLUTION
from remanent.integrate.ensemble.run import Attempt, Chunk

#: For a slow drive the largest resolution is up to so many times larger.
_MAX_DRIVE_SLOWNESS = 16.0
#: Longest cycle that is resolved with that many steps, at four double steps per nominal time.
_LONGEST_RESOLVABLE_CYCLE = NOMINAL_CYCLE_TIME * MAX_RESOLUTION * _MAX_DRIVE_SLOWNESS / 4.0
#: Least round-off, in units of the last place per root of a step.
_ROUND_OFF_FACTOR = 1.0


@dataclass(frozen=True)
class BestAttempts:
    """The best attempt of every trajectory so far.

    What changes: the arrays of `outcome`, `largest_error` and `stall_counts` are written as
    attempts come in.

    Attributes
    ----------
    problem : Problem
    outcome : Outcome
        Of the best attempts.
    largest_error, stall_counts : array (trajectory,)
        See :class:`~remanent.integrate.ensemble.refinement.AttemptHistory`.
    """

    problem: Problem
    outcome: Outcome
    largest_error: FloatArray
    stall_counts: IntArray

    @classmethod
    def before_first_attempt(cls, problem: Problem, request: Request) -> Self:
        """Before the first attempt."""
        count = problem.duration.size
        largest_error, stall_counts = np.full(count, np.nan), np.zeros(count, dtype=np.int64)
        return cls(problem, _empty_outcome(problem, request), largest_error, stall_counts)

    @classmethod
    def of_known_run(cls, problem: Problem, request: Request, outcome: Outcome) -> Self:
        """Those of a run that is known but for its samples."""
        empty = cls.before_first_attempt(problem, request)
        known = replace(outcome, states=empty.outcome.states, inspection_results=())
        return replace(empty, outcome=known)

    def trajectory_scales(self, indices: IntArray) -> TrajectoryScales:
        """What of some trajectories does not depend on how they are resolved."""
        load_schedule = self.problem.load_schedule
        lengths = load_schedule.piece_lengths[0, indices]
        slowness = np.ones(indices.size)
        if load_schedule.periodic:
            slowness = (lengths / NOMINAL_CYCLE_TIME).clip(1.0, _MAX_DRIVE_SLOWNESS)
        return TrajectoryScales(
            self.problem.duration[indices], lengths.clip(max=NOMINAL_CYCLE_TIME), slowness
        )

    def attempt_history(self, indices: IntArray) -> AttemptHistory:
        """What the attempts of some trajectories came to so far."""
        outcome = self.outcome
        return AttemptHistory(
            outcome.horizon[indices],
            outcome.resolution[indices],
            self.largest_error[indices],
            self.stall_counts[indices],
            outcome.status[indices],
        )

    def record_attempt(
        self, policy: RefinementPolicy, chunk: Chunk, attempt: Attempt
    ) -> PendingTrajectories:
        """Take in the attempt of a chunk; tell which of its trajectories to try again."""
        indices = chunk.indices
        summary = AttemptSummary(
            chunk.resolution,
            attempt.within_tolerance,
            attempt.horizon,
            attempt.error_to_horizon,
            attempt.largest_error,
            attempt.state_size,
        )
        decision = policy.decide(
            self.trajectory_scales(indices), self.attempt_history(indices), summary
        )
        self._keep_improved(chunk, attempt, decision)
        return PendingTrajectories(
            indices[decision.must_refine], decision.next_resolution[decision.must_refine]
        )

    def _keep_improved(self, chunk: Chunk, attempt: Attempt, decision: RefinementDecision) -> None:
        """Replace the results of those trajectories that are better now."""
        outcome, met = self.outcome, attempt.within_tolerance
        self.largest_error[chunk.indices] = attempt.largest_error
        self.stall_counts[chunk.indices] = decision.stall_counts
        outcome.status[chunk.indices] = decision.status
        source = np.flatnonzero(decision.is_improvement)
        target = chunk.indices[source]
        outcome.horizon[target] = decision.horizon[source]
        resolution = np.broadcast_to(chunk.resolution, chunk.indices.shape)
        outcome.resolution[target] = resolution[source]
        floor = self._round_off_error(chunk, decision.horizon)
        error = np.where(met, attempt.largest_error, attempt.error_to_horizon)
        outcome.error[target] = np.maximum(error, floor)[source]
        # Extremes of a part of the run are not those of the run.
        for name in EXTREME_NAMES:
            extreme = np.where(met, getattr(attempt, name), np.nan)
            getattr(outcome, name)[target] = extreme[source]
        if outcome.states is not None and attempt.states is not None:
            reached = attempt.states.shape[1]  # of the longest in its chunk
            outcome.states[target, :reached] = attempt.states[source]

    def _round_off_error(self, chunk: Chunk, horizon: FloatArray) -> FloatArray:
        """Least error that rounding makes: it walks at random, by a last place in each step."""
        initial = self.problem.initial_states[chunk.indices]
        cycle = cycle_lengths(self.problem, chunk.indices)
        steps = 2 * chunk.resolution * horizon / cycle
        scale = np.maximum(1.0, np.abs(initial).max(axis=1))
        return np.asarray(_ROUND_OFF_FACTOR * np.finfo(float).eps * scale * np.sqrt(1.0 + steps))

    def without_unaffordable(self, pending: PendingTrajectories) -> PendingTrajectories:
        """Leave out what would take too many steps; that is its status."""
        load_schedule = self.problem.load_schedule
        possible = np.zeros(pending.indices.size, dtype=np.bool_)
        for level in np.unique(pending.resolution):
            members = pending.resolution == level
            indices = pending.indices[members]
            steps = fine_step_counts(self.problem, int(level), indices)
            # A cycle too long to be resolved at all, even if the run ends early in it.
            too_long = (load_schedule.piece_lengths[:, indices] > _LONGEST_RESOLVABLE_CYCLE).any(
                axis=0
            )
            possible[members] = (steps <= MAX_FINE_STEPS_PER_TRAJECTORY) & ~(
                load_schedule.periodic & too_long
            )
        self.outcome.status[pending.indices[~possible]] = Status.MAX_STEPS
        return PendingTrajectories(pending.indices[possible], pending.resolution[possible])

    def computed_trajectories(self) -> PendingTrajectories:
        """Trajectories that were computed, and the resolution that reached furthest."""
        indices = np.flatnonzero(self.outcome.resolution > 0)
        return PendingTrajectories(indices, self.outcome.resolution[indices])

    def outcome_with_samples(self, attempts: Iterable[tuple[Chunk, Attempt]]) -> Outcome:
        """The outcome with the states, and the findings, of one more attempt of each."""
        findings: list[Any] = []
        for chunk, attempt in attempts:
            if self.outcome.states is not None and attempt.states is not None:
                self.outcome.states[chunk.indices] = attempt.states
            findings += attempt.inspection_results
        return replace(self.outcome, inspection_results=tuple(findings))


def _empty_outcome(problem: Problem, request: Request) -> Outcome:
    count, dimension = problem.initial_states.shape
    states = None
    if request.strobe_cycles:
        samples = int(cycle_counts(problem).max(initial=0)) // request.strobe_cycles + 1
        states = np.full((count, samples, dimension), np.nan)
    elif request.times is not None:
        states = np.full((count, request.times.shape[1], dimension), np.nan)
    status = np.where(problem.invalid, Status.INVALID, Status.NOT_COMPUTED).astype(np.int8)
    extremes: dict[str, Any] = {name: np.full(count, np.nan) for name in EXTREME_NAMES}
    return Outcome(
        states,
        **extremes,
        error=np.full(count, np.nan),
        horizon=np.full(count, np.nan),
        status=status,
        resolution=np.zeros(count, dtype=np.int64),
    )
