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
from remanent.studies.ensemble.durations import require_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.progress import Report

#: Periods advanced at once.
_BLOCK = 64


@dataclass(frozen=True)
class Section:
    """Points of the stroboscopic section at every value, for every sweep.

    Attributes
    ----------
    states : array (trajectory, sweep, period, state)
    error : array (trajectory, sweep)
        Largest error of one period.
    status : array (trajectory, sweep) of int
    """

    states: FloatArray
    error: FloatArray
    status: IntArray


@dataclass(frozen=True)
class ParameterSweep:
    """Sweeps the last dimension of an ensemble, for all values of the others together.

    Attributes
    ----------
    ensemble : Ensemble
    problem : Problem
        Its trajectories as arrays.
    directions : tuple of "up" and "down"
        The order in which values are visited, for each sweep.
    discard, keep : int
        Periods that pass at each value before points are kept, and points kept.
    tolerance : float
        Bound of a period's error.
    """

    ensemble: Ensemble
    problem: Problem
    directions: tuple[str, ...]
    discard: int
    keep: int
    tolerance: float

    @cached_property
    def flow(self) -> PeriodMap:
        """The map over one drive period."""
        return PeriodMap(self.problem.field, self.problem.timeline.waveform)

    @cached_property
    def period_lengths(self) -> FloatArray:
        """The drive period of each trajectory in tau, array (trajectory,)."""
        return require_periods(self.ensemble)

    @cached_property
    def trajectories(self) -> IntArray:
        """Numbers of the trajectories, array (other parameters, value)."""
        values = list(self.ensemble.sizes.values())[-1]
        return np.arange(self.ensemble.count).reshape(-1, values)

    def run(self, report: Report | None) -> Section:
        """Visit all values, one after the other."""
        count, values = self.trajectories.shape
        sweep = np.repeat(np.arange(len(self.directions)), count)
        shape = (self.ensemble.count, len(self.directions))
        states = np.full((*shape, self.keep, self.flow.dimension), np.nan)
        section = Section(states, np.full(shape, np.nan), np.zeros(shape, dtype=np.int8))
        initial = np.tile(self.ensemble.initial[self.trajectories[:, 0]], (shape[1], 1))
        current = initial.copy()
        for step in range(values):
            visited = [step if d == "up" else values - 1 - step for d in self.directions]
            trajectory = self.trajectories[:, visited].T.ravel()
            current = self._visit(section, trajectory, sweep, current, initial)
            if report is not None:
                report((step + 1) / values)
        return section

    def _visit(
        self,
        section: Section,
        trajectory: IntArray,
        sweep: IntArray,
        current: FloatArray,
        initial: FloatArray,
    ) -> FloatArray:
        """Fill in one value of each sweep; return the states in which the motions leave it.

        A motion that escaped, or whose error is not known, starts again at the next value.
        """
        invalid = self.ensemble.invalid[trajectory]
        section.status[trajectory[invalid], sweep[invalid]] = Status.INVALID
        valid = np.flatnonzero(~invalid)
        if not valid.size:
            return current
        rows, columns = trajectory[valid], sweep[valid]
        outcome = self._settle(rows, current[valid])
        escaped = ~(np.abs(outcome.visited) < ESCAPE_BOUND).all(axis=(1, 2))
        codes = np.where(outcome.trusted, int(Status.OK), int(Status.MAX_STEPS))
        section.status[rows, columns] = np.where(escaped, int(Status.ESCAPED), codes)
        section.error[rows, columns] = outcome.error
        good = ~escaped & outcome.trusted
        section.states[rows[good], columns[good]] = outcome.visited[good]
        following = current.copy()
        following[valid] = np.where(good[:, None], outcome.last, initial[valid])
        return following

    def _settle(self, rows: IntArray, states: FloatArray) -> _Settled:
        """Let periods pass at one value, then keep points."""
        advance = BlockAdvancer(
            self.flow, self.problem.parameters[rows], self.period_lengths[rows], self.tolerance
        )
        subset = np.arange(len(states))
        no_tangents = np.empty((len(states), 0, states.shape[1]))
        error, trusted = np.zeros(len(states)), np.ones(len(states), dtype=np.bool_)
        kept: list[FloatArray] = []
        passed = _blocks(self.discard)
        for n, periods in enumerate([*passed, *_blocks(self.keep)]):
            keeping = n >= len(passed)
            step = advance(subset, states, no_tangents, periods, every=keeping)
            states = step.visited_states[:, -1]
            error, trusted = (
                np.maximum(error, step.largest_period_error),
                trusted & step.error_bound_met,
            )
            if keeping:
                kept.append(step.visited_states)
        return _Settled(states, np.concatenate(kept, axis=1), error, trusted)


@dataclass(frozen=True)
class _Settled:
    """What became of motions at one value of the parameter.

    Attributes
    ----------
    last : array (motion, state)
    visited : array (motion, period, state)
    error : array (motion,)
    trusted : array (motion,) of bool
        Whether all periods met their error bound.
    """

    last: FloatArray
    visited: FloatArray
    error: FloatArray
    trusted: BoolArray


def _blocks(periods: int) -> list[int]:
    """Periods in parts that are advanced at once."""
    full, rest = divmod(periods, _BLOCK)
    return [_BLOCK] * full + [rest] * (rest > 0)
