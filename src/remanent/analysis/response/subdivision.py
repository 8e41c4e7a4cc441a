"""Where a function that may jump is largest: repeated subdivision, many cases at once.

Values have errors.  A point is *surely smaller* than the largest one if it is smaller by more
than both errors; the maximum lies between the nearest surely smaller points on either side.
Where the function is smooth these errors hide its top, whose width is the root of the error
over the curvature, long before a bracket is as narrow as is asked for: the top is then
computed again with smaller errors.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray

#: ``function(case, x, tolerance, resolution)`` with arrays (point,) gives values, NaN where
#: unknown, their errors, and the resolutions that they needed, arrays (point,), for a tolerance.
#: It is told the resolution that points beside these needed, 0 where that is not known.
CaseFunction = Callable[
    [IntArray, FloatArray, float, IntArray], tuple[FloatArray, FloatArray, IntArray]
]
#: ``effort(case, x)`` with arrays (point,): what the function takes there, in any unit.
EffortFunction = Callable[[IntArray, FloatArray], FloatArray]
#: Factor between the tolerances with which the top of a maximum is computed.
_TOLERANCE_STEP = 0.1
#: Smallest tolerance: below it, rounding is all that is left of an error.
_FINEST_TOLERANCE = 1e-12


@dataclass(frozen=True)
class BracketedMaxima:
    """The largest value found for each case, and where the maximum may lie.

    Attributes
    ----------
    position, value : array (case,)
        NaN where no value is known.
    position_error, value_error : array (case,)
    is_inside : array (case,) of bool
        Whether points on both sides are surely smaller: there is a maximum between the ends of
        the table.
    is_at_end : array (case,) of bool
        Whether the largest value is that of the first or of the last point.
    is_cut_short : array (case,) of bool
        Whether a narrower bracket would have taken too much effort.
    """

    position: FloatArray
    value: FloatArray
    position_error: FloatArray
    value_error: FloatArray
    is_inside: BoolArray
    is_at_end: BoolArray
    is_cut_short: BoolArray


def refine_maxima(
    x: FloatArray,
    values: FloatArray,
    errors: FloatArray,
    resolutions: IntArray,
    function: CaseFunction,
    *,
    tolerance: float,
    width: float,
    candidates: int = 3,
    division: int = 8,
    effort: EffortFunction | None = None,
    max_effort: float = np.inf,
) -> BracketedMaxima:
    """Refine the largest of tabulated values.

    The intervals on both sides of the `candidates` largest local maxima are divided,
    then again around the largest, until it lies between surely smaller points that are no
    farther apart than `width`, or than rounding lets tell.  No smoothness is assumed: a maximum
    narrower than the table's spacing, away from the candidates, is not found.

    Parameters
    ----------
    x : array (point,)
        Increasing.
    values, errors : array (case, point)
        NaN is never the largest.
    resolutions : array (case, point)
        How fine a computation the values needed.
    function : callable
        Further values, errors and resolutions, from arrays (point,) of cases and places, a
        tolerance, and the resolutions that neighbours needed.
    tolerance : float
        With which `values` were computed.
    width : float
        Of the last bracket.
    candidates : int
        Local maxima that are refined at first; one less at each level, down to one.
    division : int
        Parts that an interval is divided into.
    effort : callable, optional
        What the function takes at each of some points.
    max_effort : float
        Of all points of a case together.
    """
    tables = [
        _CaseTable(x, v, e, r, tolerance).restricted_to_peaks(candidates)
        for v, e, r in zip(values, errors, resolutions, strict=True)
    ]
    spent, is_cut_short = np.zeros(len(tables)), np.zeros(len(tables), dtype=np.bool_)
    while True:
        steps = [t.next_step(width, candidates, division) for t in tables]
        if effort is not None:
            spent += [effort(np.full(p.size, k), p).sum() for k, (_, p) in enumerate(steps)]
            is_cut_short = spent > max_effort
            for k in np.flatnonzero(is_cut_short).tolist():
                steps[k] = steps[k][0], steps[k][1][:0]
        levels = sorted({level for level, points in steps if points.size}, reverse=True)
        if not levels:
            break
        for level in levels:
            chosen = [k for k, (own, p) in enumerate(steps) if own == level and p.size]
            points = [steps[k][1] for k in chosen]
            case = np.repeat(np.array(chosen), [p.size for p in points])
            near = [
                tables[k].resolutions_beside(p, level) for k, p in zip(chosen, points, strict=True)
            ]
            new = function(case, np.concatenate(points), level, np.concatenate(near))
            for k, p in zip(chosen, points, strict=True):
                own_values, own_errors, own_resolutions = (column[case == k] for column in new)
                own = _CaseTable(p, own_values, own_errors, own_resolutions, level)
                tables[k] = tables[k].with_points(own)
        candidates = max(1, candidates - 1)
    found = np.array([t.best_peak() for t in tables])
    position, value, position_error, value_error, has_two_sides = found.T
    with np.errstate(invalid="ignore"):
        is_at_end = np.asarray((position <= x[0]) | (position >= x[-1]))
    is_inside = (has_two_sides > 0.0) & ~is_at_end
    return BracketedMaxima(
        position, value, position_error, value_error, np.asarray(is_inside), is_at_end,
        np.asarray(is_cut_short),
    )  # fmt: skip


@dataclass(frozen=True)
class _CaseTable:
    """Values, errors and resolutions of one case at increasing places, arrays (point,).

    Attributes
    ----------
    tolerance : float
        With which they were computed.
    outer : (float, float)
        Surely smaller places that were known before, or infinite.
    finest : float
        Smallest tolerance that is worth a try: with the next one a value was unknown.
    """

    positions: FloatArray
    values: FloatArray
    errors: FloatArray
    resolutions: IntArray
    tolerance: float
    outer: tuple[float, float] = (-np.inf, np.inf)
    finest: float = _FINEST_TOLERANCE

    def peak_indices(self) -> IntArray:
        """Local maxima, ends included, largest first; beside NaN, what is finite is one."""
        is_peak = np.isfinite(self.values)
        is_peak[1:] &= ~(self.values[:-1] > self.values[1:])
        is_peak[:-1] &= ~(self.values[1:] > self.values[:-1])
        index = np.flatnonzero(is_peak)
        return index[np.argsort(-self.values[index], kind="stable")]

    def restricted_to_peaks(self, count: int) -> _CaseTable:
        """The largest peaks, with what is around each down to the nearest surely smaller point."""
        peaks = self.peak_indices()[:count]
        kept = [(peaks[:, None] + np.array([-1, 0, 1])).ravel()]
        kept += [np.arange(*self.bracket_indices(int(k))) for k in peaks[:1]]
        kept += [np.array(self.bracket_indices(int(k))) for k in peaks[:1]]
        subset = np.unique(np.concatenate([np.empty(0, np.int64), *kept]))
        subset = subset[(subset >= 0) & (subset < self.positions.size)]
        return replace(
            self,
            positions=self.positions[subset],
            values=self.values[subset],
            errors=self.errors[subset],
            resolutions=self.resolutions[subset],
        )

    def bracket_indices(self, k: int) -> tuple[int, int]:
        """Numbers of the nearest points on both sides that are surely smaller than point k.

        -1 or the number of points where there is none.
        """
        with np.errstate(invalid="ignore"):
            smaller = self.values + self.errors < self.values[k] - self.errors[k]
        below, above = np.flatnonzero(smaller[:k]), np.flatnonzero(smaller[k + 1 :])
        return (
            int(below[-1]) if below.size else -1,
            k + 1 + int(above[0]) if above.size else self.positions.size,
        )

    def bracket(self, k: int) -> tuple[float, float]:
        """The places of these points, or those known before, or infinity."""
        low, high = self.bracket_indices(k)
        return (
            float(self.positions[low]) if low >= 0 else self.outer[0],
            float(self.positions[high]) if high < self.positions.size else self.outer[1],
        )

    def next_step(self, width: float, candidates: int, division: int) -> tuple[float, FloatArray]:
        """New points around the largest peaks, and the tolerance for them; none at the end."""
        peaks = self.peak_indices()
        nothing = self.tolerance, np.empty(0)
        if not peaks.size or self.positions.size < 2:
            return nothing
        best = int(peaks[0])
        low, high = self.bracket(best)
        if high - low <= width:
            return nothing
        first, last = self.bracket_indices(best)
        if (first, last) == (best - 1, best + 1) or not np.isfinite(high - low):
            neighbours = self.positions[max(best - 1, 0) : best + 2]
            if np.ptp(neighbours) <= width:
                return nothing
            new = [_division_points(self.positions, int(k), division) for k in peaks[:candidates]]
            points = np.setdiff1d(np.concatenate(new), self.positions)
            return self.tolerance, points
        return self._points_with_smaller_errors(low, high, width, division)

    def _points_with_smaller_errors(
        self, low: float, high: float, width: float, division: int
    ) -> tuple[float, FloatArray]:
        """The top of the peak once more, which errors hide; none where rounding does."""
        level = self.tolerance
        # The width of the top is as the root of the error.
        needed = self.tolerance * (width / (high - low)) ** 2
        while level > max(needed, self.finest):
            level *= _TOLERANCE_STEP
        level = max(level, self.finest)
        if level >= self.tolerance:
            return self.tolerance, np.empty(0)
        return level, np.unique(np.linspace(low, high, 2 * division + 1))

    def resolutions_beside(self, x: FloatArray, tolerance: float) -> IntArray:
        """What the points on both sides of others needed: the larger; 0 at another tolerance."""
        if tolerance != self.tolerance:
            return np.zeros(x.shape, dtype=np.int64)
        above = np.searchsorted(self.positions, x).clip(1, self.positions.size - 1)
        return np.asarray(np.maximum(self.resolutions[above - 1], self.resolutions[above]))

    def with_points(self, new: _CaseTable) -> _CaseTable:
        """A table with further points, in order; or of these alone if their errors are smaller."""
        if new.tolerance < self.tolerance:
            if not np.isfinite(new.values).all():
                return replace(self, finest=new.tolerance / _TOLERANCE_STEP)
            outer = (float(new.positions[0]), float(new.positions[-1]))
            return replace(new, outer=outer, finest=self.finest)
        order = np.argsort(np.concatenate([self.positions, new.positions]), kind="stable")
        return replace(
            self,
            positions=np.concatenate([self.positions, new.positions])[order],
            values=np.concatenate([self.values, new.values])[order],
            errors=np.concatenate([self.errors, new.errors])[order],
            resolutions=np.concatenate([self.resolutions, new.resolutions])[order],
        )

    def best_peak(self) -> tuple[float, float, float, float, bool]:
        """Place and value of the largest peak, their errors, and whether it has two sides."""
        peaks = self.peak_indices()
        if not peaks.size:
            return np.nan, np.nan, np.nan, np.nan, False
        k = int(peaks[0])
        low, high = self.bracket(k)
        position = float(self.positions[k])
        return (
            position,
            float(self.values[k]),
            max(position - low, high - position),
            float(self.errors[k]) + self._hidden_rise(k),
            bool(np.isfinite(high - low)),
        )

    def _hidden_rise(self, k: int) -> float:
        """How much the maximum may rise above its largest point, between the points beside it.

        A smooth function rises by less than it falls to the second point on either side, and one
        that jumps by less than it falls to the second on the side where it does not.
        """
        falls = []
        for side in (self.values[:k][::-1][:2], self.values[k + 1 :][:2]):
            if side.size and np.isfinite(side).all():
                falls.append(float(self.values[k] - side.min()))
        return min(falls, default=np.inf)


def _division_points(x: FloatArray, k: int, division: int) -> FloatArray:
    """Points that divide the intervals on both sides of ``x[k]``."""
    sides = [(a, b) for a, b in ((k - 1, k), (k, k + 1)) if a >= 0 and b < x.size]
    inner = np.arange(1, division) / division
    return np.concatenate([x[a] + inner * (x[b] - x[a]) for a, b in sides])
