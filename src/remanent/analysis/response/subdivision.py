"""Where a function that may jump is largest: repeated subdivision, many cases at once.

Values have errors.  A point is *surely smaller* than the largest one if it is smaller by more
than both errors; the maximum lies between the nearest surely smaller points on either side.
Where the function is smooth these errors hide its top, whose width is the root of the error
over the curvature, long before a bracket is as narrow as is asked for: the top is then
computed again with smaller errors.

Where points are added depends on the function: about the place that a polynomial foretells where
one agrees with the values, else in the intervals beside the largest value, more of them on the
side where it falls more steeply.  The amplitudes of motions that pass a saddle have ripples
beside their jump, ever narrower towards it.  So other maxima, and the edge of a jump, are looked
at as long as the function might be as large there; what is left of them counts in the errors.
Maxima that only their errors make equal are computed again with smaller errors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import Polynomial

from remanent._typing import BoolArray, FloatArray, IntArray

#: ``function(case, x, tolerance, resolution)`` with arrays (point,) gives values, NaN where
#: unknown, their errors, and the resolutions that they needed, arrays (point,), for a tolerance.
#: It is told the resolution that points beside these needed, 0 where that is not known.
CaseFunction = Callable[
    [IntArray, FloatArray, float, IntArray], tuple[FloatArray, FloatArray, IntArray]
]
#: ``effort(case, x)`` with arrays (point,): what the function takes there, in any unit.
EffortFunction = Callable[[IntArray, FloatArray], FloatArray]
#: New points around the largest value at a time, and around all others: as many as a kernel
#: advances together.
_NEW_POINTS = 16
#: Others that are looked at together, and how many times at each tolerance.
_OTHERS_AT_A_TIME, _ROUNDS_WITH_OTHERS = 4, 4
#: A function might be larger beside a point by so many times what its values there tell.
_RISE_FACTOR = 2.0
#: The same between two points where no value is known.
_RISE_FACTOR_OF_UNKNOWN = 8.0
#: At an edge the fall is so many times as steep as the change on the other side.
_EDGE_RATIO = 6.0
#: Second differences about a smooth top are within this factor of each other.
_LARGEST_CURVATURE_RATIO = 4.0
#: About a smooth top each point is at most so many times nearer to it than the next one.
_DISTANCE_RATIO = 4.0
#: Share of the points beside a jump on the side where it is not.
_SHARE_BEYOND_JUMP = 0.25
#: A bracket with so few points across shows little of the top.
_FEW_POINTS = 4
#: Points on each side of one that tell what the function does there.
_NEIGHBOURS = 4
#: Factor between the tolerances with which the top of a maximum is computed.
_TOLERANCE_STEP = 0.1
#: Relative difference of tolerances that are equal but for rounding.
_TOLERANCE_SLACK = 1e-9
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
    effort: EffortFunction | None = None,
    max_effort: float = np.inf,
) -> BracketedMaxima:
    """Refine the largest of tabulated values.

    Points are added around the largest, and around others that might be, until it lies between
    surely smaller points that are no farther apart than `width`, or than rounding lets tell.  No
    smoothness is assumed of the largest.  A maximum narrower than the table's spacing, of which
    the table shows nothing, is not found.

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
    effort : callable, optional
        What the function takes at each of some points.
    max_effort : float
        Of all points of a case together.
    """
    tables = [
        _CaseTable(x, v, e, r, tolerance, width).restricted_to_candidates()
        for v, e, r in zip(values, errors, resolutions, strict=True)
    ]
    spent, is_cut_short = np.zeros(len(tables)), np.zeros(len(tables), dtype=np.bool_)
    while True:
        steps = [t.next_step() for t in tables]
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
                own = _CaseTable(p, own_values, own_errors, own_resolutions, level, width)
                tables[k] = tables[k].with_points(own)
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
    width : float
        Of the last bracket.
    outer : (float, float)
        Surely smaller places that were known before, or infinite.
    finest : float
        Smallest tolerance that is worth a try: with the next one a value was unknown.
    rounds : int
        How many times points were added.
    left_behind : tuple of (array (place,), float)
        Places around others that were not computed again with this tolerance, and what the
        function might come to there.
    """

    positions: FloatArray
    values: FloatArray
    errors: FloatArray
    resolutions: IntArray
    tolerance: float
    width: float
    outer: tuple[float, float] = (-np.inf, np.inf)
    finest: float = _FINEST_TOLERANCE
    rounds: int = 0
    left_behind: tuple[tuple[FloatArray, float], ...] = ()

    def peak_indices(self) -> IntArray:
        """Local maxima, ends included, largest first; beside NaN, what is finite is one."""
        is_peak = np.isfinite(self.values)
        is_peak[1:] &= ~(self.values[:-1] > self.values[1:])
        is_peak[:-1] &= ~(self.values[1:] > self.values[:-1])
        index = np.flatnonzero(is_peak)
        return index[np.argsort(-self.values[index], kind="stable")]

    def edge_indices(self) -> IntArray:
        """Points with a much steeper fall on one side than what the function does on the other."""
        with np.errstate(all="ignore"):
            spacing = np.diff(self.positions)
            slopes = np.diff(self.values) / spacing
            noise = (self.errors[:-1] + self.errors[1:]) / spacing
            least, most = np.abs(slopes) - noise, _EDGE_RATIO * (np.abs(slopes) + noise)
            is_edge = (slopes[:-1] > 0.0) & (least[:-1] > most[1:])
            is_edge |= (slopes[1:] < 0.0) & (least[1:] > most[:-1])
        edges = np.flatnonzero(is_edge) + 1
        return edges[[not self._is_smooth(k) for k in edges.tolist()]]

    def other_candidates(self, best: int) -> list[tuple[int, float]]:
        """Maxima and edges beside which the function might be larger than at the largest point.

        With what it might come to there, the largest first.  Beside an edge whose neighbours are
        no farther apart than the last bracket nothing else is looked for.
        """
        first, last = self.bracket_indices(best)
        lowest = self.values[best] - self.errors[best]
        possible: dict[int, float] = {}
        for k in self.peak_indices().tolist():
            if self._has_valley_between(k, best):
                possible[k] = self._largest_possible(k, self._hidden_rise(k))
        for k in self.edge_indices().tolist():
            if not self._is_narrow(k):
                beside = self._largest_possible(k, _change_beside(self.values, k))
                possible[k] = max(beside, possible.get(k, beside))
        others = [k for k, value in possible.items() if value >= lowest and not first < k < last]
        return [(k, possible[k]) for k in sorted(others, key=possible.__getitem__, reverse=True)]

    def _equal_maxima(self, best: int, others: Sequence[int]) -> list[int]:
        """Those of the others, with narrow neighbourhoods, that are as large within the errors."""
        lowest = self.values[best] - self.errors[best]
        return [
            k for k in others if self._is_narrow(k) and self.values[k] + self.errors[k] >= lowest
        ]

    def _places_that_might_be_larger(
        self, best: int, computed_again: int = 0
    ) -> tuple[tuple[FloatArray, float], ...]:
        """Places where the function might be larger than at the largest point, and how large.

        Without the first equal maxima, which are computed again.
        """
        others = dict(self.other_candidates(best))
        equals = self._equal_maxima(best, list(others))
        around = (
            (self._inner_bracket(k) if k in equals else self._neighbourhood(k), largest)
            for k, largest in others.items()
            if k not in equals[:computed_again]
        )
        unknown = (
            (self.positions[ends], largest) for ends, largest in self.unknown_stretches(best)
        )
        return (*self.left_behind, *around, *unknown)

    def _has_valley_between(self, k: int, other: int) -> bool:
        """Whether a point between two is surely smaller than the first."""
        between = slice(min(k, other) + 1, max(k, other))
        smaller = self.values[between] + self.errors[between] < self.values[k] - self.errors[k]
        return bool(smaller.any())

    def _is_narrow(self, k: int) -> bool:
        """Whether the points beside one are no farther apart than the last bracket."""
        return bool(np.ptp(self._neighbourhood(k)) <= self.width)

    def _neighbourhood(self, k: int) -> FloatArray:
        """The places of a point and of those beside it."""
        return np.asarray(self.positions[max(k - 1, 0) : k + 2])

    def restricted_to_candidates(self) -> _CaseTable:
        """What is around the largest point and others that might be."""
        kept = [np.empty(0, dtype=np.int64)]
        for best in self.peak_indices()[:1].tolist():
            chosen = np.array([best, *(k for k, _ in self.other_candidates(best))])
            kept.append((chosen[:, None] + np.arange(-_NEIGHBOURS, _NEIGHBOURS + 1)).ravel())
            low, high = self.bracket_indices(best)
            kept.append(np.arange(low, high + 1))
            kept += [np.arange(a, b + 1) for (a, b), _ in self.unknown_stretches(best)]
        subset = np.unique(np.concatenate(kept))
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

    def _inner_bracket(self, k: int) -> FloatArray:
        """The places of a bracket, or the ends of the table."""
        return np.clip(self.bracket(k), self.positions[0], self.positions[-1])

    def next_step(self) -> tuple[float, FloatArray]:
        """New points around the largest one and some others, and the tolerance for them.

        None at the end.
        """
        peaks, x = self.peak_indices().tolist(), self.positions
        if not peaks or x.size < 2:
            return self.tolerance, np.empty(0)
        best = peaks[0]
        low, high = self.bracket(best)
        others = [k for k, _ in self.other_candidates(best)]
        equals = self._equal_maxima(best, others)
        wide = [k for k in others if not self._is_narrow(k)]
        undecided = [k for k in others if k not in equals]
        looked_at = undecided[:_OTHERS_AT_A_TIME] if self.rounds < _ROUNDS_WITH_OTHERS else []
        new = [self._points_around(k, _NEW_POINTS // len(looked_at)) for k in looked_at]
        first, last = self.bracket_indices(best)
        is_tight = (first, last) == (best - 1, best + 1) or not np.isfinite(high - low)
        is_found = self._is_narrow(best) if is_tight else high - low <= self.width
        if is_tight and not is_found:
            new.append(self._points_around(best, _NEW_POINTS))
        elif not wide and not looked_at and (equals or not is_found):
            if is_found or last - first > _FEW_POINTS:
                return self._points_with_smaller_errors([best, *equals[:_OTHERS_AT_A_TIME]])
            new.append(_inner_points(low, high, _NEW_POINTS))
        return self.tolerance, np.setdiff1d(np.concatenate([np.empty(0), *new]), x)

    def _largest_possible(self, k: int, rise: float) -> float:
        """What the function might come to beside a point, where it is known on a side.

        Values that are equal but for their errors tell of no rise.
        """
        noise = self.errors[k] + np.nanmax(self.errors[max(k - 2, 0) : k + 3])
        known = float(self.values[k] + self.errors[k])
        return known + _RISE_FACTOR * max(rise - noise, 0.0) if np.isfinite(rise) else known

    def _points_around(self, k: int, count: int) -> FloatArray:
        """Points about a smooth top, or in the intervals on both sides of another point."""
        x, last = self.positions, self.positions.size - 1
        top = self._smooth_top(k)
        if top is not None:
            reach = max(x[k + 1] - top, top - x[k - 1])
            least = max(0.25 * self.width, reach / _DISTANCE_RATIO ** (count // 2))
            distances = np.geomspace(least, reach, count // 2 + 1)[:-1]
            points = np.concatenate([[top], top - distances[:-1], top + distances])
            return np.asarray(points[(points > x[k - 1]) & (points < x[k + 1])])
        if k in (0, last):
            return _inner_points(x[max(k - 1, 0)], x[min(k + 1, last)], count)
        steepness = (self.values[k] - self.values[[k - 1, k + 1]]) / np.abs(
            x[[k - 1, k + 1]] - x[k]
        )
        share = 0.5
        if np.isfinite(steepness).all() and steepness[0] != steepness[1]:
            is_below = steepness[0] > steepness[1]
            share = 1.0 - _SHARE_BEYOND_JUMP if is_below else _SHARE_BEYOND_JUMP
        below = round(share * count)
        return np.concatenate(
            [_inner_points(x[k - 1], x[k], below), _inner_points(x[k], x[k + 1], count - below)]
        )

    def _is_smooth(self, k: int) -> bool:
        """Whether second differences about a point agree that the function is one arch there."""
        x, v = self.positions[max(k - 2, 0) : k + 3], self.values[max(k - 2, 0) : k + 3]
        if x.size < 5 or not np.isfinite(v).all():
            return False
        curvatures = np.diff(np.diff(v) / np.diff(x)) / (x[2:] - x[:-2])
        return bool(curvatures.max() < curvatures.min() / _LARGEST_CURVATURE_RATIO < 0.0)

    def _smooth_top(self, k: int) -> float | None:
        """Where the polynomial through a peak and two points on either side is largest.

        None where second differences say that the function is not smooth.
        """
        if not self._is_smooth(k):
            return None
        x, v = self.positions[k - 2 : k + 3], self.values[k - 2 : k + 3]
        roots = Polynomial.fit(x, v, 4).deriv().roots()
        real = roots[np.abs(roots.imag) <= 1e-7 * np.ptp(x)].real
        inside = real[(real > x[1]) & (real < x[3])]
        return float(inside[0]) if inside.size == 1 else None

    def _points_with_smaller_errors(self, peaks: list[int]) -> tuple[float, FloatArray]:
        """The tops of peaks once more, which errors hide; none where rounding does."""
        brackets = np.array([self._inner_bracket(k) for k in peaks])
        # The width of the top is as the root of the error.
        narrower = max(np.ptp(brackets[0]) / self.width, 1.0)
        steps = np.ceil(-2.0 * np.log(narrower) / np.log(_TOLERANCE_STEP))
        level = max(self.tolerance * _TOLERANCE_STEP ** max(steps, 1.0), self.finest)
        if not level < (1.0 - _TOLERANCE_SLACK) * self.tolerance:
            return self.tolerance, np.empty(0)
        return level, np.unique(np.linspace(brackets[:, 0], brackets[:, 1], _NEW_POINTS))

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
            first, last = float(new.positions[0]), float(new.positions[-1])
            outer = (
                first if first > self.positions[0] else self.outer[0],
                last if last < self.positions[-1] else self.outer[1],
            )
            best = int(self.peak_indices()[0])
            left_behind = self._places_that_might_be_larger(best, _OTHERS_AT_A_TIME)
            return replace(new, outer=outer, finest=self.finest, left_behind=left_behind)
        order = np.argsort(np.concatenate([self.positions, new.positions]), kind="stable")
        return replace(
            self,
            positions=np.concatenate([self.positions, new.positions])[order],
            values=np.concatenate([self.values, new.values])[order],
            errors=np.concatenate([self.errors, new.errors])[order],
            resolutions=np.concatenate([self.resolutions, new.resolutions])[order],
            rounds=self.rounds + 1,
        )

    def best_peak(self) -> tuple[float, float, float, float, bool]:
        """Place and value of the largest point, their errors, and whether it has two sides.

        The errors reach as far as others that might be larger, and stretches where it is unknown.
        """
        peaks = self.peak_indices().tolist()
        if not peaks:
            return np.nan, np.nan, np.nan, np.nan, False
        k = peaks[0]
        position, value = float(self.positions[k]), float(self.values[k])
        low, high = self.bracket(k)
        value_error, rise = float(self.errors[k]), self._hidden_rise(k)
        if np.isfinite(rise) or not self.unknown_stretches(k):
            value_error += rise
        reach = [position - low, high - position]
        for places, largest in self._places_that_might_be_larger(k):
            if largest >= value - float(self.errors[k]):
                reach += np.abs(places - position).tolist()
                value_error = max(value_error, largest - value)
        return position, value, max(reach), value_error, bool(np.isfinite(high - low))

    def unknown_stretches(self, best: int) -> list[tuple[IntArray, float]]:
        """Where no value is known and the function might be larger than at the largest point.

        Numbers of the known points on both sides, or of one and the end of the table, and what
        the function might come to between them: more than the larger of these, by what it changes
        beside them, on the side where it changes less, in proportion to the width.
        """
        known, last = np.flatnonzero(np.isfinite(self.values)), self.values.size - 1
        ends = np.concatenate([[-1], known, [last + 1]])
        stretches = []
        for below, above in ends[np.flatnonzero(np.diff(ends) > 1)[:, None] + [0, 1]].tolist():
            width = self.positions[min(above, last)] - self.positions[max(below, 0)]
            beside = (known[known <= below][::-1], known[known >= above])
            largest = max(self.values[k[0]] + self.errors[k[0]] for k in beside if k.size)
            change = min(self._change_along(k[: _NEIGHBOURS + 1], width) for k in beside)
            largest += _RISE_FACTOR_OF_UNKNOWN * change
            if largest >= self.values[best] - self.errors[best]:
                stretches.append((np.array([max(below, 0), min(above, last)]), float(largest)))
        return stretches

    def _change_along(self, points: IntArray, width: float) -> float:
        """How much values change over points, or in proportion over a larger width."""
        if points.size < 2:
            return np.inf
        reach = float(np.ptp(self.positions[points]))
        return float(np.ptp(self.values[points])) * max(1.0, width / reach)

    def _hidden_rise(self, k: int) -> float:
        """How much the function may rise above a maximum, between the points beside it.

        A smooth function rises by less than it falls to the second point on either side, and one
        that jumps by less than it falls to the second on the side where it does not.
        """
        falls = []
        for side in (self.values[:k][::-1][:2], self.values[k + 1 :][:2]):
            if side.size and np.isfinite(side).all():
                falls.append(float(self.values[k] - side.min()))
        return min(falls, default=np.inf)


def _change_beside(values: FloatArray, k: int) -> float:
    """How much values change beside one, on the side where they change less.

    Infinite where some are unknown on both sides.
    """
    changes = [
        float(np.abs(values[k] - side).max())
        for side in (values[:k][::-1][:_NEIGHBOURS], values[k + 1 :][:_NEIGHBOURS])
        if side.size and np.isfinite(side).all()
    ]
    return min(changes, default=np.inf)


def _inner_points(low: float, high: float, count: int) -> FloatArray:
    """Points that divide an interval into equal parts."""
    return np.linspace(low, high, count + 2)[1:-1]
