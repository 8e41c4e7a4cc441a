"""Where given times lie in the steps of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble.problem import latest_trusted_time
from remanent.integrate.ensemble.segments import Segment

#: A time this close to the end of a step, in steps, is that end: rounding in the time.
_STEP_END_SLACK_IN_STEPS = 1e-9
#: Rounding in the time of a step, relative to that time.
_RELATIVE_TIME_ROUNDING = 4.0 * np.finfo(float).eps


@dataclass(frozen=True)
class SamplePlaces:
    """Those of the given times that lie in a segment, and where in it.

    Which step a time lies in, and where in the step, follows from the trajectory alone: from
    the start of its cycle.  A segment only selects, since its cuts depend on the company.

    Attributes
    ----------
    trajectory_rows, time_columns : array (sample,)
        Trajectory, and number of the time.
    sample_times : array (sample,)
        The time, tau.
    fine_steps_before : array (sample,)
        Fine steps of the segment before the time.
    step_fractions : array (sample,)
        Fraction of the next step, in [0, 1).
    """

    trajectory_rows: IntArray
    time_columns: IntArray
    sample_times: FloatArray
    fine_steps_before: IntArray
    step_fractions: FloatArray

    @classmethod
    def in_segment(cls, segment: Segment, times: FloatArray, cycles: IntArray) -> Self:
        """The places in a segment.

        Parameters
        ----------
        segment : Segment
        times : array (trajectory, time)
            When states are wanted, tau.
        cycles : array (trajectory,)
            Cycles of the run of each; 1 where the piece is no cycle.
        """
        # The comparison of times selects generously, by a step; the places decide.
        with np.errstate(invalid="ignore"):  # a piece that never ends
            begin = segment.time_after(0) - segment.fine_step_length
            end = segment.time_after(segment.fine_step_count) + segment.fine_step_length
        # A piece may be empty for some trajectories, and the run of others may be over.
        end[(segment.fine_step_length <= 0.0) | (cycles <= segment.first_cycle)] = np.nan
        row, column = np.nonzero((times >= begin[:, None]) & (times <= end[:, None]))
        time = times[row, column]
        step, part = _locate_in_piece(segment, time, row, cycles[row])
        step -= segment.fine_steps_before
        count = segment.fine_step_count
        # A time at the very end belongs to it and, if there is one, to the next segment.
        inside = (step >= 0) & ((step < count) | ((step == count) & (part == 0.0)))
        return cls(row, column, time, step, part).subset(inside)

    def subset(self, where: BoolArray) -> Self:
        """Some of the places."""
        return type(self)(
            self.trajectory_rows[where],
            self.time_columns[where],
            self.sample_times[where],
            self.fine_steps_before[where],
            self.step_fractions[where],
        )

    def up_to_horizon(self, horizon: FloatArray) -> Self:
        """Those not beyond the horizons of their trajectories, array (trajectory,)."""
        trusted = self.sample_times <= latest_trusted_time(horizon)[self.trajectory_rows]
        return self if trusted.all() else self.subset(trusted)


def _locate_in_piece(
    segment: Segment, time: FloatArray, row: IntArray, cycles: IntArray
) -> tuple[IntArray, FloatArray]:
    """Fine steps of the piece before each time, and the fraction of the next one.

    Steps are -1 where the time is not in the piece.
    """
    start, length, step = (
        segment.piece_start[row],
        segment.cycle_length[row],
        segment.fine_step_length[row],
    )
    per_cycle = 2 * segment.resolution
    cycle = np.floor((time - start) / length).clip(0, cycles - 1)
    position = (time - (start + cycle * length)) / step
    # Rounding may put a time just outside the piece, or a time between two cycles in neither.
    reach = _STEP_END_SLACK_IN_STEPS + _RELATIVE_TIME_ROUNDING * time / step
    outside = (position < -reach) | (position > per_cycle + reach)
    position = position.clip(0.0, per_cycle)
    near = np.rint(position)
    position = np.where(np.abs(position - near) < _STEP_END_SLACK_IN_STEPS, near, position)
    before = np.floor(position)
    steps = cycle.astype(np.int64) * per_cycle + before.astype(np.int64)
    return np.where(outside, -1, steps), position - before
