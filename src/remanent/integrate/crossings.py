"""Crossings that were found, their errors, and those that are but the error of the motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Self

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble.problem import ERROR_SHARE_IN_FUNCTIONS, latest_trusted_time

#: Stands as direction for the end of a window of steps, which is no crossing.
NO_CROSSING = 9
#: Rounding of a time, relative to it.
_RELATIVE_TIME_ROUNDING = 4.0 * float(np.finfo(float).eps)


@dataclass(frozen=True)
class Crossings:
    """Crossings of all trajectories, sorted by trajectory and time.

    Attributes
    ----------
    trajectory : array (crossing,)
    time : array (crossing,)
        tau.
    states : array (crossing, state)
    direction : array (crossing,)
        1 upwards, -1 downwards, 0 where the observable touches the value and turns back.
    rate, curvature : array (crossing,)
        Rate of the observable there, and the size of its second derivative.
    sensitivity : array (crossing,)
        Change of the observable by an error of the state, the largest for one of size 1.
    speed : array (crossing,)
        Largest rate of a state variable.
    largest_before : array (crossing,)
        Largest distance of the observable from the value since the crossing before, at ends
        of steps.
    step : array (crossing,)
        Number of the step, in the window where it was found.
    """

    trajectory: IntArray
    time: FloatArray
    states: FloatArray
    direction: IntArray
    rate: FloatArray
    curvature: FloatArray
    sensitivity: FloatArray
    speed: FloatArray
    largest_before: FloatArray
    step: IntArray

    @classmethod
    def none(cls, dimension: int) -> Self:
        """No crossing of states of so many variables."""
        numbers, values = np.empty(0, dtype=np.int64), np.empty(0)
        return cls(
            trajectory=numbers,
            time=values,
            states=np.empty((0, dimension)),
            direction=numbers,
            rate=values,
            curvature=values,
            sensitivity=values,
            speed=values,
            largest_before=values,
            step=numbers,
        )

    @classmethod
    def concatenated(cls, parts: Sequence[Crossings], dimension: int) -> Self:
        """Several lists as one, in the order of the parts.

        Parameters
        ----------
        parts : sequence of Crossings
            May be empty.
        dimension : int
            Of the state.
        """
        lists = (cls.none(dimension), *parts)
        names = (f.name for f in fields(cls))
        return cls(*(np.concatenate([getattr(part, name) for part in lists]) for name in names))

    def subset(self, chosen: IntArray | BoolArray) -> Crossings:
        """Some of the crossings, in the order of `chosen`."""
        return Crossings(*(getattr(self, f.name)[chosen] for f in fields(self)))

    def sorted_up_to(self, ends: FloatArray) -> Crossings:
        """Those that come before the `ends` of their trajectories, sorted.

        Ends of windows are kept, after the crossings at the same time.
        """
        end = latest_trusted_time(ends[self.trajectory])
        closes = self.direction == NO_CROSSING
        time = np.where(closes, np.fmin(self.time, end), self.time)
        trusted = np.flatnonzero(time <= end)
        return self.subset(
            trusted[np.lexsort((closes[trusted], time[trusted], self.trajectory[trusted]))]
        )

    def time_error(self, state_error: FloatArray) -> FloatArray:
        """Estimated errors of the times, array (crossing,).

        An error d of the observable, whose rate is r and second derivative a, moves a passage
        by t with d = |r| t - |a| t^2/2.  Where that has no solution, and at a touch, it is not
        known whether the motion turns before or beyond: both passages are within
        (1 + sqrt 2) sqrt(2 d/|a|).

        Parameters
        ----------
        state_error : array (crossing,)
            Estimated error of the state at a given time, in the trajectory of each.
        """
        level = self.sensitivity * ERROR_SHARE_IN_FUNCTIONS * state_error
        with np.errstate(all="ignore"):
            root = np.sqrt(self.rate**2 - 2.0 * self.curvature * level)
            passage = 2.0 * level / (np.abs(self.rate) + root)
            turn = (1.0 + np.sqrt(2.0)) * np.sqrt(2.0 * level / self.curvature)
        moved = np.where(np.isnan(root) | (self.direction == 0), turn, passage)
        return np.asarray(moved + _RELATIVE_TIME_ROUNDING * np.abs(self.time))

    def state_error(self, state_error: FloatArray) -> FloatArray:
        """Estimated errors of the states, array (crossing,): errors of the times move them too.

        The two do not add up: most of the error of a state is along the motion, and this part
        the error of the time takes back.

        Parameters
        ----------
        state_error : array (crossing,)
            As for :meth:`time_error`.
        """
        moved = self.speed * self.time_error(state_error)
        return np.asarray(np.maximum(ERROR_SHARE_IN_FUNCTIONS * state_error, moved))


def with_distances(
    found: Crossings, distance: FloatArray, rows: IntArray, ends: Crossings
) -> Crossings:
    """The crossings of a window, with the largest distance before each, and the window's ends.

    Parameters
    ----------
    found : Crossings
        Sorted.  Of two in one step, the second knows the distance between them.
    distance : array (trajectory, node)
        Of the observable from the value, at the ends of steps.
    rows : array (crossing,)
        Row of `distance` of each crossing.
    ends : Crossings
        The end of the window in each row.
    """
    count, nodes = distance.shape
    # A crossing lies between two nodes; distances are gathered from one crossing to the next.
    next_node = rows * nodes + found.step + 1
    row_starts = np.arange(count) * nodes
    bounds = np.unique(np.concatenate([row_starts, next_node]))
    largest = np.maximum.reduceat(distance.ravel(), bounds)
    before = largest[np.searchsorted(bounds, next_node) - 1]
    is_second_of_step = np.diff(next_node, prepend=-1) == 0
    found = replace(found, largest_before=np.where(is_second_of_step, found.largest_before, before))
    last = np.searchsorted(bounds, row_starts + nodes) - 1
    ends = replace(ends, largest_before=largest[last])
    return Crossings.concatenated([found, ends], found.states.shape[1])


def merge_within_error(found: Crossings, state_error: FloatArray) -> Crossings:
    """Crossings between which the observable leaves the value by more than its error.

    Between others the motion is as near to the value as its own error, and passes it as that
    error does.  They count as one passage, or as a touch where the motion comes from the side
    to which it goes.  Where it never leaves again, or was there from the start, there is none.

    Parameters
    ----------
    found : Crossings
        Sorted, with the ends of windows among them.
    state_error : array (trajectory,)
        Of the states.

    Returns
    -------
    Crossings
        Without the ends of windows.
    """
    is_crossing = found.direction != NO_CROSSING
    crossings = found.subset(is_crossing)
    if not crossings.trajectory.size:
        return crossings
    before, after = _largest_distances_beside(found, is_crossing)
    error = crossings.sensitivity * state_error[crossings.trajectory]
    leaves_before, leaves_after = ~(before <= error), ~(after <= error)
    row = crossings.trajectory
    joins = np.concatenate([[False], (row[1:] == row[:-1]) & ~leaves_before[1:]])
    first = np.flatnonzero(~joins)
    last = np.append(first[1:], row.size) - 1
    alone = first == last
    # What comes after the end of the run is not known, so that one side is enough for one.
    left, right = leaves_before[first], leaves_after[last]
    kept = np.where(alone, left | right, left & right)
    middle, direction = (first + last) // 2, crossings.direction.copy()
    for k in np.flatnonzero(kept & ~alone):
        passages = direction[first[k] : last[k] + 1]
        passages = passages[passages != 0]
        goes_back = not passages.size or passages[0] != passages[-1]
        direction[middle[k]] = 0 if goes_back else passages[-1]
    return replace(crossings, direction=direction).subset(middle[kept])


def _largest_distances_beside(
    found: Crossings, is_crossing: BoolArray
) -> tuple[FloatArray, FloatArray]:
    """Largest distances from the value before and after each crossing, up to the next ones."""
    row = found.trajectory
    begins = np.concatenate([[True], (row[1:] != row[:-1]) | is_crossing[:-1]])
    starts = np.flatnonzero(begins)
    largest = np.maximum.reduceat(found.largest_before, starts)
    group = (np.cumsum(begins) - 1)[is_crossing]
    following = np.minimum(group + 1, largest.size - 1)
    goes_on = (group + 1 < largest.size) & (row[starts[following]] == row[is_crossing])
    return largest[group], np.where(goes_on, largest[following], 0.0)
