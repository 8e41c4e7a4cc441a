"""Motions that are carried from one value of a parameter to the next."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from remanent._status import Status
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.long_runs import ESCAPE_BOUND
from remanent.integrate.ensemble.problem import Problem
from remanent.integrate.maps.advance import BlockAdvancer
from remanent.integrate.maps.period_map import PeriodMap
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.progress import ProgressFunction

#: Periods advanced at once.
_PERIODS_ADVANCED_AT_ONCE = 64


@dataclass(frozen=True)
class SweepSection:
    """Points of the stroboscopic section at every value, for every sweep.

    Attributes
    ----------
    states : array (trajectory, sweep, period, state)
    largest_period_error : array (trajectory, sweep)
        Largest error of one period.
    status : array (trajectory, sweep) of int
    """

    states: FloatArray
    largest_period_error: FloatArray
    status: IntArray


@dataclass(frozen=True)
class ParameterSweep:
    """Sweeps the last dimension of an ensemble, for all values of the others together.

    Attributes
    ----------
    ensemble : Ensemble
    problem : Problem
        Its trajectories as arrays.
    sweep_directions : tuple of "up" and "down"
        The order in which values are visited, for each sweep.
    discarded_periods, kept_periods : int
        Periods that pass at each value before points are kept, and points kept.
    period_tolerance : float
        Bound of a period's error.
    """

    ensemble: Ensemble
    problem: Problem
    sweep_directions: tuple[str, ...]
    discarded_periods: int
    kept_periods: int
    period_tolerance: float

    @cached_property
    def period_map(self) -> PeriodMap:
        """The map over one drive period."""
        together = self.trajectory_indices.shape[0] * len(self.sweep_directions)
        waveform = self.problem.load_schedule.waveforms_at_phase
        return PeriodMap(self.problem.field, waveform, expected_points=together)

    @cached_property
    def period_lengths(self) -> FloatArray:
        """The drive period of each trajectory in tau, array (trajectory,)."""
        return require_drive_periods(self.ensemble)

    @cached_property
    def trajectory_indices(self) -> IntArray:
        """Numbers of the trajectories, array (other parameters, value)."""
        values = list(self.ensemble.dimension_sizes.values())[-1]
        return np.arange(self.ensemble.trajectory_count).reshape(-1, values)

    def run(self, report: ProgressFunction | None) -> SweepSection:
        """Visit all values, one after the other."""
        count, values = self.trajectory_indices.shape
        sweep = np.repeat(np.arange(len(self.sweep_directions)), count)
        shape = (self.ensemble.trajectory_count, len(self.sweep_directions))
        states = np.full((*shape, self.kept_periods, self.period_map.dimension), np.nan)
        section = SweepSection(states, np.full(shape, np.nan), np.zeros(shape, dtype=np.int8))
        initial = np.tile(
            self.ensemble.initial_states[self.trajectory_indices[:, 0]], (shape[1], 1)
        )
        current = initial.copy()
        for step in range(values):
            visited = [step if d == "up" else values - 1 - step for d in self.sweep_directions]
            trajectory = self.trajectory_indices[:, visited].T.ravel()
            current = self._visit_value(section, trajectory, sweep, current, initial)
            if report is not None:
                report((step + 1) / values)
        return section

    def _visit_value(
        self,
        section: SweepSection,
        trajectory: IntArray,
        sweep: IntArray,
        current: FloatArray,
        initial: FloatArray,
    ) -> FloatArray:
        """Fill in one value of each sweep; return the states in which the motions leave it.

        A motion that escaped, or whose error is not known, starts again at the next value.
        """
        invalid = self.ensemble.is_invalid[trajectory]
        section.status[trajectory[invalid], sweep[invalid]] = Status.INVALID
        valid = np.flatnonzero(~invalid)
        if not valid.size:
            return current
        rows, columns = trajectory[valid], sweep[valid]
        outcome = self._settle_and_record(rows, current[valid])
        escaped = ~(np.abs(outcome.recorded_states) < ESCAPE_BOUND).all(axis=(1, 2))
        codes = np.where(outcome.is_trusted, int(Status.OK), int(Status.MAX_STEPS))
        section.status[rows, columns] = np.where(escaped, int(Status.ESCAPED), codes)
        section.largest_period_error[rows, columns] = outcome.largest_period_error
        good = ~escaped & outcome.is_trusted
        section.states[rows[good], columns[good]] = outcome.recorded_states[good]
        following = current.copy()
        following[valid] = np.where(good[:, None], outcome.last_states, initial[valid])
        return following

    def _settle_and_record(self, rows: IntArray, states: FloatArray) -> _SettledMotions:
        """Let periods pass at one value, then keep points."""
        advance = BlockAdvancer(
            self.period_map,
            self.problem.parameters[rows],
            self.period_lengths[rows],
            self.period_tolerance,
        )
        subset = np.arange(len(states))
        no_tangents = np.empty((len(states), 0, states.shape[1]))
        error, trusted = np.zeros(len(states)), np.ones(len(states), dtype=np.bool_)
        recorded: list[FloatArray] = []
        passed = _block_lengths(self.discarded_periods)
        for n, periods in enumerate([*passed, *_block_lengths(self.kept_periods)]):
            keeping = n >= len(passed)
            step = advance(subset, states, no_tangents, periods, every=keeping)
            states = step.visited_states[:, -1]
            error, trusted = (
                np.maximum(error, step.largest_period_error),
                trusted & step.error_bound_met,
            )
            if keeping:
                recorded.append(step.visited_states)
        return _SettledMotions(states, np.concatenate(recorded, axis=1), error, trusted)


@dataclass(frozen=True)
class _SettledMotions:
    """What became of motions at one value of the parameter.

    Attributes
    ----------
    last_states : array (motion, state)
    recorded_states : array (motion, period, state)
    largest_period_error : array (motion,)
    is_trusted : array (motion,) of bool
        Whether all periods met their error bound.
    """

    last_states: FloatArray
    recorded_states: FloatArray
    largest_period_error: FloatArray
    is_trusted: BoolArray


def _block_lengths(periods: int) -> list[int]:
    """Periods in parts that are advanced at once."""
    full, rest = divmod(periods, _PERIODS_ADVANCED_AT_ONCE)
    return [_PERIODS_ADVANCED_AT_ONCE] * full + [rest] * (rest > 0)
