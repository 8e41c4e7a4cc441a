"""Where a function that may jump is largest: repeated subdivision, many cases at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from remanent._typing import FloatArray, IntArray

#: ``function(case, x)`` with arrays (point,) gives the values (point,); NaN where unknown.
CaseFunction = Callable[[IntArray, FloatArray], FloatArray]


@dataclass(frozen=True)
class BracketedMaxima:
    """The largest value found for each case, and between which points it lies.

    Attributes
    ----------
    position, value : array (case,)
    bracket_lower, bracket_upper : array (case,)
        Neighbours of `position` among all points tried: the last bracket.
    """

    position: FloatArray
    value: FloatArray
    bracket_lower: FloatArray
    bracket_upper: FloatArray


def refine_maxima(
    x: FloatArray,
    values: FloatArray,
    function: CaseFunction,
    *,
    width: float,
    candidates: int = 3,
    division: int = 8,
) -> BracketedMaxima:
    """Refine the largest of tabulated values.

    The intervals on both sides of the `candidates` largest local maxima are divided,
    then again around the largest, until the bracket is narrower than `width`.  No
    smoothness is assumed: a maximum narrower than the table's spacing, away from the
    candidates, is not found.

    Parameters
    ----------
    x : array (point,)
        Increasing.
    values : array (case, point)
        NaN is never the largest.
    function : callable
        Of arrays (point,) of cases and places: further values.
    width : float
        Of the last bracket.
    candidates : int
        Local maxima that are refined at first; one less at each level, down to one.
    division : int
        Parts that an interval is divided into.
    """
    tables = [_CaseTable(x, row).restricted_to_peaks(candidates) for row in values]
    while True:
        points = [t.refinement_points(width, candidates, division) for t in tables]
        case = np.repeat(np.arange(len(tables)), [p.size for p in points])
        if not case.size:
            break
        new = function(case, np.concatenate(points))
        tables = [
            t.with_points(p, new[case == k]) if p.size else t
            for k, (t, p) in enumerate(zip(tables, points, strict=True))
        ]
        candidates = max(1, candidates - 1)
    return BracketedMaxima(
        *(np.array(column) for column in zip(*(t.best_peak() for t in tables), strict=True))
    )


@dataclass(frozen=True)
class _CaseTable:
    """Values of one case at increasing places, arrays (point,)."""

    positions: FloatArray
    values: FloatArray

    def peak_indices(self) -> IntArray:
        """Local maxima, ends included, largest first; beside NaN, what is finite is one."""
        is_peak = np.isfinite(self.values)
        is_peak[1:] &= ~(self.values[:-1] > self.values[1:])
        is_peak[:-1] &= ~(self.values[1:] > self.values[:-1])
        index = np.flatnonzero(is_peak)
        return index[np.argsort(-self.values[index], kind="stable")]

    def restricted_to_peaks(self, count: int) -> _CaseTable:
        """The largest peaks and their neighbours: no other point is looked at again."""
        neighbours = (self.peak_indices()[:count, None] + np.array([-1, 0, 1])).clip(
            0, self.positions.size - 1
        )
        subset = np.unique(neighbours)
        return _CaseTable(self.positions[subset], self.values[subset])

    def bracket_of_point(self, k: int) -> tuple[float, float]:
        """The neighbours of point k."""
        return float(self.positions[max(k - 1, 0)]), float(
            self.positions[min(k + 1, self.positions.size - 1)]
        )

    def refinement_points(self, width: float, candidates: int, division: int) -> FloatArray:
        """New points around the largest peaks, or none if the best is narrow enough."""
        peaks = self.peak_indices()
        if not peaks.size or self.positions.size < 2:
            return np.empty(0)
        lower, upper = self.bracket_of_point(int(peaks[0]))
        if upper - lower <= width:
            return np.empty(0)
        new = [_division_points(self.positions, int(k), division) for k in peaks[:candidates]]
        points = np.setdiff1d(np.concatenate(new), self.positions)
        return points if points.size else np.empty(0)

    def with_points(self, x: FloatArray, values: FloatArray) -> _CaseTable:
        """A table with further points, in order."""
        places = np.concatenate([self.positions, x])
        order = np.argsort(places, kind="stable")
        return _CaseTable(places[order], np.concatenate([self.values, values])[order])

    def best_peak(self) -> tuple[float, float, float, float]:
        """Place and value of the largest peak, and its bracket; NaN without one."""
        peaks = self.peak_indices()
        if not peaks.size:
            return (np.nan,) * 4
        k = int(peaks[0])
        return float(self.positions[k]), float(self.values[k]), *self.bracket_of_point(k)


def _division_points(x: FloatArray, k: int, division: int) -> FloatArray:
    """Points that divide the intervals on both sides of ``x[k]``."""
    sides = [(a, b) for a, b in ((k - 1, k), (k, k + 1)) if a >= 0 and b < x.size]
    inner = np.arange(1, division) / division
    return np.concatenate([x[a] + inner * (x[b] - x[a]) for a, b in sides])
