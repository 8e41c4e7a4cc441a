"""How many cycles and steps a trajectory takes at a resolution."""

from __future__ import annotations

import numpy as np

from remanent._load_schedule import LoadSchedule
from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble.problem import Problem

#: Without a period, resolution counts double steps per this time (about one oscillation), tau.
NOMINAL_CYCLE_TIME = 2.5
#: Most fine steps of one trajectory.
MAX_FINE_STEPS_PER_TRAJECTORY = 2.0**28
#: Most cycles that are counted; more than anybody waits for, and an exact double.
_MAX_CYCLE_COUNT = 2**53
#: Most double steps of a piece that are counted.
_MAX_DOUBLE_STEP_COUNT = 2**40
#: Rounding in a length must not add a step: the share of a double step that is overlooked.
_STEP_COUNT_SLACK = 1e-9
#: Nor may rounding in a duration add a cycle: the relative excess that is overlooked.
_CYCLE_COUNT_SLACK = 1e-12


def counts_of_double_steps(
    load_schedule: LoadSchedule, resolution: int, indices: IntArray | slice = slice(None)
) -> IntArray:
    """Double steps in every piece, array (piece, trajectory), at a resolution."""
    lengths = load_schedule.piece_lengths[:, indices]
    if load_schedule.periodic:
        return np.full(lengths.shape, resolution, dtype=np.int64)
    with np.errstate(over="ignore"):
        count = np.ceil(lengths * (resolution / NOMINAL_CYCLE_TIME) - _STEP_COUNT_SLACK)
    return np.asarray(np.clip(count, 1, _MAX_DOUBLE_STEP_COUNT), dtype=np.int64)


def cycle_lengths(problem: Problem, indices: IntArray | slice = slice(None)) -> FloatArray:
    """Length of a cycle of each of some trajectories, tau, or the nominal time without a period."""
    if problem.load_schedule.periodic:
        return problem.load_schedule.piece_lengths[0, indices]
    return np.full(problem.duration[indices].shape, NOMINAL_CYCLE_TIME)


def cycle_counts(problem: Problem, indices: IntArray | slice = slice(None)) -> IntArray:
    """How many cycles each of some trajectories takes, array (trajectory,)."""
    duration = problem.duration[indices]
    if not problem.load_schedule.periodic:
        return np.ones(duration.shape, dtype=np.int64)
    with np.errstate(over="ignore"):
        ratio = duration / problem.load_schedule.piece_lengths[0, indices]
    return np.asarray(
        np.ceil(ratio * (1 - _CYCLE_COUNT_SLACK)).clip(1, _MAX_CYCLE_COUNT), dtype=np.int64
    )


def fine_step_counts(
    problem: Problem, resolution: int, indices: IntArray | slice = slice(None)
) -> FloatArray:
    """Fine steps of each trajectory, array (trajectory,)."""
    steps = counts_of_double_steps(problem.load_schedule, resolution, indices).sum(axis=0)
    return np.asarray(2.0 * steps * cycle_counts(problem, indices))
