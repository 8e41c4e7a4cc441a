"""Points and their tangents followed over many periods: what all long statistics are made of.

Works for any map that can say where points and tangents go: the period map of a flow, the
logistic map.  Tangents are made orthonormal again after every few periods, before they
line up or overflow; how much each had grown, and how they had lined up, is kept.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.orthonormalisation import orthonormalise

#: Tangents that shrink by more than this within a block have lost digits.
SMALLEST_GROWTH = 1e-290
#: A state beyond this has escaped.
ESCAPE_BOUND = 1e6
#: Periods between renormalisations of a single tangent, which must not overflow, at most.
_MAX_PERIODS_PER_BLOCK_OF_ONE_TANGENT = 16
#: Periods between renormalisations of several tangents, which must not line up, at most.
_MAX_PERIODS_PER_BLOCK_OF_SEVERAL_TANGENTS = 4
#: Blocks that even a short run has, since statistics are made of them.
_MIN_BLOCK_COUNT = 32
#: Seed of the tangents' first directions.
_INITIAL_TANGENTS_SEED = 7


class TangentImage(Protocol):
    """Where some points and their tangents went."""

    @property
    def visited_states(self) -> FloatArray:
        """States after each period, or after the last alone: (point, period, state)."""

    @property
    def tangents(self) -> FloatArray:
        """Tangents after the last period, array (point, direction, state)."""

    @property
    def largest_period_error(self) -> FloatArray:
        """Largest error of the state that one period added, array (point,)."""

    @property
    def error_bound_met(self) -> BoolArray:
        """Whether the error that was asked for was met, array (point,)."""


class TangentMap(Protocol):
    """A map with tangents, of points that it knows by their numbers."""

    def __call__(
        self,
        points: IntArray,
        states: FloatArray,
        tangents: FloatArray,
        periods: int,
        /,
        *,
        every: bool,
    ) -> TangentImage:
        """Advance points by a number of periods.

        Parameters
        ----------
        points : array (point,) of int
            Numbers of the points, so that what differs between them can be looked up.
        states : array (point, state)
        tangents : array (point, direction, state)
        periods : int
            How many.
        every : bool
            Whether the state after each period is asked for, or after the last only.
        """


@dataclass(frozen=True)
class LongRun:
    """Many points followed over the same number of periods.

    Attributes
    ----------
    periods : int
        How many were asked for.
    periods_per_block : int
        Periods between renormalisations.
    triangular_factors : array (point, block, direction, direction)
        Upper triangles R of the tangents' factorisation Q R after each block; NaN after
        the end of a point.
    last_state : array (point, state)
        Where the points ended.
    visited_states : array (point, period + 1, state), optional
        All states, the start included, or those of the last periods; NaN after the end.
    escaped : array (point,) of bool
        The state exceeded :data:`ESCAPE_BOUND` or became NaN.
    error_bound_met : array (point,) of bool
        Every period met its error.
    completed_periods : array (point,) of int
        Whole periods before the point escaped or could not be trusted.
    largest_period_error : array (point,)
        Largest error of one period.
    horizon : array (point,)
        Periods over which errors, magnified as tangents are, stay below what was asked.
    """

    periods: int
    periods_per_block: int
    triangular_factors: FloatArray
    last_state: FloatArray
    visited_states: FloatArray | None
    escaped: BoolArray
    error_bound_met: BoolArray
    completed_periods: IntArray
    largest_period_error: FloatArray
    horizon: FloatArray

    @property
    def log_growth(self) -> FloatArray:
        """Logarithms of the tangents' growth in each block, array (point, block, direction).

        Minus infinity where tangents shrank to less than a double holds with all its digits.
        """
        factors = np.diagonal(self.triangular_factors, axis1=2, axis2=3)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.log(np.where(factors < SMALLEST_GROWTH, 0.0, factors))

    @property
    def block_lengths_in_periods(self) -> IntArray:
        """Periods of each block, of which the last may be shorter, array (block,)."""
        return np.diff(_block_ends_in_periods(self.periods, self.periods_per_block), prepend=0)

    def with_replaced_rows(self, points: IntArray, rows: LongRun) -> LongRun:
        """A run in which some points are replaced by those of another; it has no tangents."""
        names = (
            "last_state", "visited_states", "escaped", "error_bound_met", "completed_periods",
            "largest_period_error", "horizon",
        )  # fmt: skip
        values = {name: getattr(self, name).copy() for name in names}
        for name, value in values.items():
            value[points] = getattr(rows, name)
        return replace(self, triangular_factors=self.triangular_factors[:, :0], **values)


def block_lengths_in_periods(periods: int, directions: int, block: int | None = None) -> IntArray:
    """Periods of each block of a run, array (block,); the last may be shorter."""
    return np.diff(
        _block_ends_in_periods(periods, block or _default_periods_per_block(periods, directions)),
        prepend=0,
    )


def _first_kept_period(ends: IntArray, kept: int) -> int:
    """The end of a block, or the start, after which at least so many periods are left."""
    return int(max(ends[ends <= ends[-1] - kept], default=0))


def _block_ends_in_periods(periods: int, block: int) -> IntArray:
    return np.append(np.arange(block, periods, block), periods)


def _default_periods_per_block(periods: int, directions: int) -> int:
    longest = (
        _MAX_PERIODS_PER_BLOCK_OF_ONE_TANGENT
        if directions <= 1
        else _MAX_PERIODS_PER_BLOCK_OF_SEVERAL_TANGENTS
    )
    return min(max(periods // _MIN_BLOCK_COUNT, 1), longest)


def propagate_tangents(
    advance: TangentMap,
    states: FloatArray,
    periods: int,
    *,
    directions: int,
    width: int | None = None,
    every: bool | int = False,
    max_state_error: float = 1e-2,
    block: int | None = None,
) -> LongRun:
    """Follow points and tangents over many periods.

    Parameters
    ----------
    advance : TangentMap
        Moves points and tangents.
    states : array (point, state)
        To start from.
    periods : int
        How many.
    directions : int
        Tangents that are carried along.
    width : int, optional
        Components of a tangent; those of a state by default.
    every : bool or int
        Keep all states, or those of about so many periods at the end.
    max_state_error : float
        Error of the state from which on it counts as unknown, for `horizon`.
    block : int, optional
        Periods between renormalisations; one where the smallest exponent matters, since of
        tangents that lined up nothing is left but rounding.
    """
    count, dimension = states.shape
    block = block or _default_periods_per_block(periods, directions)
    ends = _block_ends_in_periods(periods, block)
    factors = np.full((count, ends.size, directions, directions), np.nan)
    first = _first_kept_period(ends, periods if every is True else int(every))
    visited = np.full((count, periods - first + 1, dimension), np.nan) if every else None
    if visited is not None and first == 0:
        visited[:, 0] = states
    now = states.copy()
    frame = np.tile(_initial_tangents(width or dimension)[:directions], (count, 1, 1))
    escaped, trusted = np.zeros(count, dtype=np.bool_), np.ones(count, dtype=np.bool_)
    completed, error = np.zeros(count, dtype=np.int64), np.zeros(count)
    accumulated, horizon = np.zeros(count), np.full(count, np.inf)
    active, done = np.arange(count), 0
    for k in range(ends.size):
        if not active.size:
            break
        end = int(ends[k])
        keeps = visited is not None and end > first
        image = advance(active, now[active], frame[active], end - done, every=keeps)
        is_beyond_bound = ~(np.abs(image.visited_states) < ESCAPE_BOUND).all(axis=(1, 2))
        # A point that escapes is beyond its error bound too; that is no reason for distrust.
        escaped[active], trusted[active] = is_beyond_bound, image.error_bound_met | is_beyond_bound
        going_on = np.flatnonzero(~is_beyond_bound & image.error_bound_met)
        points = active[going_on]
        if visited is not None and end >= first:
            kept = (
                image.visited_states[going_on, -1:]
                if end == first
                else image.visited_states[going_on]
            )
            visited[points, end - first + 1 - kept.shape[1] : end - first + 1] = kept
        now[points], completed[points] = image.visited_states[going_on, -1], end
        error[points] = np.maximum(error[points], image.largest_period_error[going_on])
        frame[points], factors[points, k] = orthonormalise(image.tangents[going_on])
        if directions:
            # The error so far grows as the first tangent does, and each period adds its own.
            growth = np.maximum(factors[points, k, 0, 0], 1.0)
            with np.errstate(over="ignore"):
                added = image.largest_period_error[going_on] * (end - done)
                accumulated[points] = accumulated[points] * growth + added
            is_accurate = accumulated[points] <= max_state_error
            horizon[points] = np.where(is_accurate, np.inf, np.minimum(horizon[points], done))
        active, done = points, end
    horizon = np.minimum(horizon, completed)
    return LongRun(
        periods, block, factors, now, visited, escaped, trusted, completed, error, horizon
    )


def _initial_tangents(dimension: int) -> FloatArray:
    """Orthonormal directions with no preference for any coordinate, the same every time."""
    random = np.random.default_rng(_INITIAL_TANGENTS_SEED).normal(size=(1, dimension, dimension))
    return np.asarray(orthonormalise(random)[0][0])
