"""Special points of a branch of periodic orbits: where multipliers leave or meet.

At each kind of bifurcation a test function changes its sign.  The test functions are known at
the points of the branch; a sign that changes between two of them brackets a root.  A test
function may also pass zero and come back between two points: its minima are looked for too.

References
----------
Y. A. Kuznetsov, Elements of Applied Bifurcation Theory (Springer, 2004), chapter 10.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations
from types import MappingProxyType

import numpy as np

from remanent._roots import find_minima, find_roots
from remanent._typing import FloatArray
from remanent.analysis.orbits.correction import correct_points, unit_tangents
from remanent.analysis.orbits.curves import CurveEquations, CurvePoints, interpolate_curve
from remanent.analysis.orbits.extended_systems import LocatedPoint, locate_special_points

#: A test function is beyond zero if it is by this many times its error.
_MIN_CROSSING_DEPTH_OVER_ERROR = 8.0
#: Tolerance of the place of a root along the branch, which counts points, before it is located.
_ROUGH_ROOT_POSITION_TOLERANCE = 1e-6
#: How far from its bracket a special point may be, in lengths of the bracket.
_MAX_DISTANCE_IN_BRACKETS = 1.0
#: The same, beside these, in scaled unknowns.
_MAX_DISTANCE_FROM_BRACKET = 1e-3
#: Brackets farther from each other along the branch, in points, hold different special points.
_MAX_SEGMENTS_TO_SAME_POINT = 3.0
#: A turn nearer to a crossing of branches, in scaled unknowns, is that of the crossing.
_MAX_TURN_DISTANCE_FROM_CROSSING = 1e-3
#: Tolerance of a minimum along the branch.
_LOCATED_MINIMUM_POSITION_TOLERANCE = 1e-7
#: Relative tolerance of the value of a minimum.
_LOCATED_MINIMUM_RELATIVE_VALUE_TOLERANCE = 1e-9
#: Iterations of the search for a root or a minimum, at most.
_MAX_ROOT_OR_MINIMUM_ITERATIONS = 60
#: Smallest imaginary part of a complex multiplier.
_MIN_COMPLEX_IMAGINARY_PART = 1e-6


@dataclass(frozen=True)
class SpecialPoint:
    """A special point of a branch.

    Attributes
    ----------
    kind : str
        ``fold``, ``period doubling``, ``Neimark-Sacker`` or ``branch point``.
    segment_index : int
        It lies between this point of the branch and the next.
    point : CurvePoints
        The point itself, of length 1.
    error : array (state + 1,)
        Estimated errors of the variables of the state and of the parameter.
    """

    kind: str
    segment_index: int
    point: CurvePoints
    error: FloatArray

    @property
    def parameter_error(self) -> float:
        """Estimated error of the parameter."""
        return float(self.error[-1])

    @property
    def state_error(self) -> float:
        """Largest estimated error of the variables of the state."""
        return float(self.error[:-1].max())


# Test functions: points (point,) in, values (point,) out.


def _fold_test(points: CurvePoints) -> FloatArray:
    """The part of the tangent along the parameter: at a fold the branch turns back."""
    return points.tangent[:, -1]


def _period_doubling_test(points: CurvePoints) -> FloatArray:
    """det(J + 1), the product of all multipliers plus one: zero where one of them is -1."""
    jacobian = points.extra_arrays["jacobian"]
    return np.asarray(np.linalg.det(jacobian + np.eye(jacobian.shape[1])))


def _branch_point_test(points: CurvePoints) -> FloatArray:
    """Determinant of the equations' derivatives, bordered by the tangent.

    Along a branch the derivatives have one null vector, the tangent, and the border makes the
    matrix regular.  Where another branch crosses they have two, and it is singular.  Units of the
    unknowns, in which the tangent is and the derivatives are not, change neither sign nor zeros.
    """
    bordered = np.concatenate([points.extra_arrays["derivative"], points.tangent[:, None]], axis=1)
    return np.asarray(np.linalg.det(bordered))


def _neimark_sacker_test(points: CurvePoints) -> FloatArray:
    """Product over all pairs of multipliers of (their product less one).

    A complex pair on the unit circle has product 1.  So have two real ones that are inverse
    to each other, which is no bifurcation: :func:`_is_bifurcation` tells them apart.
    """
    values = np.linalg.eigvals(points.extra_arrays["jacobian"])
    pairs = [values[:, i] * values[:, j] - 1.0 for i, j in combinations(range(values.shape[1]), 2)]
    return np.asarray(np.prod(pairs, axis=0).real if pairs else np.ones(len(points)))


TestFunction = Callable[[CurvePoints], FloatArray]
#: The test function of each kind; a further kind of bifurcation is a line here.
TEST_FUNCTION_OF_KIND: Mapping[str, TestFunction] = MappingProxyType(
    {
        "fold": _fold_test,
        "period doubling": _period_doubling_test,
        "branch point": _branch_point_test,
        "Neimark-Sacker": _neimark_sacker_test,
    }
)


@dataclass(frozen=True)
class _InterpolatedBranch:
    """A branch as a function of a real number: 2.5 lies midway between its third and fourth."""

    equations: CurveEquations
    points: CurvePoints
    scale: FloatArray
    tolerance: float

    def points_at(self, places: FloatArray) -> CurvePoints:
        """Points of the branch itself, by Newton's method from the cubic between its points."""
        segment = np.clip(places.astype(np.int64), 0, len(self.points) - 2)
        guess, direction = interpolate_curve(self.points, segment, places - segment, self.scale)
        ends = self.points.unknown[segment + 1] - self.points.unknown[segment]
        points, _ = correct_points(
            self.equations, guess, direction, scale=self.scale, tolerance=self.tolerance,
            reach=np.linalg.norm(ends / self.scale, axis=1),
        )  # fmt: skip
        return points


def find_special_points(
    equations: CurveEquations,
    points: CurvePoints,
    *,
    scale: FloatArray,
    tolerance: float,
    conservative: bool,
    precise_equations: CurveEquations | None = None,
    judging_equations: CurveEquations | None = None,
    touching_ends: tuple[bool, bool] = (False, False),
) -> list[SpecialPoint]:
    """All special points of a branch, in order along it.

    Parameters
    ----------
    equations : callable
        Of the orbits, as :func:`~remanent.analysis.orbits.orbit_equations.build_orbit_equations`
        makes them.
    points : CurvePoints
        Along the branch, with ``jacobian`` and ``derivative`` in their ``extra_arrays``.
    scale : array (n + 1,)
        Units of the unknowns.
    tolerance : float
        Of the equations.
    conservative : bool
        Products of multipliers are 1 throughout, so that no Neimark-Sacker point exists.
    precise_equations : callable, optional
        The same equations with a smaller error, by which the points are located in the end.
    judging_equations : callable, optional
        The same once more, by which the errors of the points located are judged.
    touching_ends : two bool
        Whether the first and the last point are on another branch: they are no special points of
        this one, although its folds and crossings have their values there.
    """
    branch = _InterpolatedBranch(equations, points, scale, tolerance)
    brackets: list[_Bracket] = []
    for kind, test in TEST_FUNCTION_OF_KIND.items():
        if kind == "Neimark-Sacker" and conservative:
            continue

        def value(places: FloatArray, test: TestFunction = test) -> FloatArray:
            return np.asarray(test(branch.points_at(places)), dtype=np.float64)

        values = test(points)
        if kind in ("fold", "branch point"):
            values = _with_signs_of_neighbours(values, touching_ends)
        with np.errstate(invalid="ignore"):
            crossed = np.flatnonzero(values[:-1] * values[1:] < 0.0)
        middle, before, after = _bracket_double_crossings(value, values, points)
        low = np.concatenate([crossed, before, middle]).astype(np.float64)
        high = np.concatenate([crossed + 1, middle, after]).astype(np.float64)
        if low.size:
            brackets += _narrow_brackets(kind, value, low, high)
    return _locate_in_brackets(
        precise_equations or equations, judging_equations, branch,
        sorted(brackets, key=lambda one: one.root),
    )  # fmt: skip


def _with_signs_of_neighbours(values: FloatArray, at_ends: tuple[bool, bool]) -> FloatArray:
    """Values of a test function without a change of sign in the first or the last segment."""
    values = values.copy()
    for end, neighbour, changed in ((0, 1, at_ends[0]), (-1, -2, at_ends[1])):
        if changed and len(values) > 1:
            values[end] = values[neighbour]
    return values


def _bracket_double_crossings(
    value: Callable[[FloatArray], FloatArray], values: FloatArray, points: CurvePoints
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Where a test function passes zero and comes back between points of one sign.

    The size of its values is least at some points.  Where its neighbours differ from that by
    more than it is away from zero, the minimum near it is looked for.

    Parameters
    ----------
    value : callable
        The test function at places along the branch.
    values : array (point,)
        The same at the points of the branch.
    points : CurvePoints

    Returns
    -------
    middle, before, after : array (dip,)
        Places along the branch: beyond zero, and on this side before and after.
    """
    size = np.abs(values)
    before, middle, after = size[:-2], size[1:-1], size[2:]
    with np.errstate(invalid="ignore"):
        one_sign = (values[:-2] * values[1:-1] > 0.0) & (values[2:] * values[1:-1] > 0.0)
        # A parabola through three points with this curvature may reach zero between them.
        dips = (middle <= before) & (middle < after) & (middle < before + after - 2.0 * middle)
    k = np.flatnonzero(one_sign & dips) + 1
    if not k.size:
        return (np.empty(0),) * 3
    side, x = np.sign(values[k]), k.astype(np.float64)
    least = find_minima(
        lambda x, side: side * value(x),
        (x - 1.0, x, x + 1.0),
        args=(side,),
        maxiter=_MAX_ROOT_OR_MINIMUM_ITERATIONS,
        tolerances={
            "xatol": _LOCATED_MINIMUM_POSITION_TOLERANCE,
            "xrtol": 0.0,
            "fatol": 0.0,
            "frtol": _LOCATED_MINIMUM_RELATIVE_VALUE_TOLERANCE,
        },
    )
    # A function that only touches zero is beyond it by rounding: that is no crossing.
    rounding = _MIN_CROSSING_DEPTH_OVER_ERROR * (
        points.residual_error[k] + points.residual[k] + np.finfo(float).eps
    )
    beyond = least.f_x < -rounding * _state_error_magnifications(points)[k]
    return least.x[beyond], x[beyond] - 1.0, x[beyond] + 1.0


def _state_error_magnifications(points: CurvePoints) -> FloatArray:
    """Largest entry of each Jacobian, at least 1: what errors of the state are magnified by."""
    return np.asarray(np.maximum(1.0, np.abs(points.extra_arrays["jacobian"]).max(axis=(1, 2))))


@dataclass(frozen=True)
class _Bracket:
    """Where along a branch a test function changes its sign.

    Attributes
    ----------
    kind : str
    root, low, high : float
        Places along the branch: of the root, roughly, and of the ends.
    """

    kind: str
    root: float
    low: float
    high: float


def _narrow_brackets(
    kind: str, value: Callable[[FloatArray], FloatArray], low: FloatArray, high: FloatArray
) -> list[_Bracket]:
    """Rough roots of a test function between places along a branch, all together."""
    root = find_roots(
        value,
        (low, high),
        tolerances={
            "xatol": _ROUGH_ROOT_POSITION_TOLERANCE,
            "xrtol": 0.0,
            "fatol": 0.0,
            "frtol": 0.0,
        },
        maxiter=_MAX_ROOT_OR_MINIMUM_ITERATIONS,
    )
    found = np.flatnonzero(root.success)
    return [_Bracket(kind, float(root.x[k]), float(low[k]), float(high[k])) for k in found]


def _locate_in_brackets(
    equations: CurveEquations,
    judging_equations: CurveEquations | None,
    branch: _InterpolatedBranch,
    brackets: list[_Bracket],
) -> list[SpecialPoint]:
    """Special points in brackets, in order along a branch, each once.

    A test function is uncertain by its error: near a crossing of branches the tangent turns at
    random, so that folds seem to be there.  What counts is the solution of the extended system.
    """
    if not brackets:
        return []
    scale = branch.scale
    rough, low, high = (
        branch.points_at(np.array([getattr(one, place) for one in brackets]))
        for place in ("root", "low", "high")
    )
    width = np.linalg.norm((high.unknown - low.unknown) / scale, axis=1)
    located = locate_special_points(
        equations, [one.kind for one in brackets], rough.unknown,
        _MAX_DISTANCE_IN_BRACKETS * width + _MAX_DISTANCE_FROM_BRACKET, scale,
        judging_equations=judging_equations,
    )  # fmt: skip
    kept: list[tuple[_Bracket, LocatedPoint, FloatArray]] = []
    for k, (bracket, one) in enumerate(zip(brackets, located, strict=True)):
        if one is not None and not any(
            bracket.kind == other.kind and _is_same_point(bracket, one, other, earlier)
            for other, earlier, _ in kept
        ):
            kept.append((bracket, one, rough.tangent[k]))
    crossings = [(b, one) for b, one, _ in kept if b.kind == "branch point"]
    kept = [
        (bracket, one, like)
        for bracket, one, like in kept
        if bracket.kind != "fold"
        or not any(_turns_at_crossing(bracket, one, *c, scale) for c in crossings)
    ]
    if not kept:
        return []
    unknown = np.array([one.unknown for _, one, _ in kept])
    values = equations(unknown)
    tangents = unit_tangents(
        values.extra_arrays["derivative"], np.array([like for _, _, like in kept]), scale
    )
    points = CurvePoints(
        unknown, tangents, np.abs(values.value).max(axis=1), values.value_error,
        values.extra_arrays,
    )  # fmt: skip
    return [
        SpecialPoint(
            bracket.kind, int(bracket.root), points.subset(slice(k, k + 1)), one.error
        )
        for k, (bracket, one, _) in enumerate(kept)
        if _is_bifurcation(bracket.kind, points, k)
    ]  # fmt: skip


def _is_same_point(
    bracket: _Bracket, one: LocatedPoint, other: _Bracket, earlier: LocatedPoint
) -> bool:
    """Whether two brackets beside each other lead to the same point."""
    if abs(bracket.root - other.root) > _MAX_SEGMENTS_TO_SAME_POINT:
        return False
    return bool((np.abs(one.unknown - earlier.unknown) <= 2.0 * (one.error + earlier.error)).all())


def _turns_at_crossing(
    fold: _Bracket, turn: LocatedPoint, crossing: _Bracket, point: LocatedPoint, scale: FloatArray
) -> bool:
    """Whether a turn is only that of the parabola in which a branch crosses another."""
    if abs(fold.root - crossing.root) > _MAX_SEGMENTS_TO_SAME_POINT:
        return False
    distance = np.linalg.norm((turn.unknown - point.unknown) / scale)
    return bool(distance <= _MAX_TURN_DISTANCE_FROM_CROSSING)


def _is_bifurcation(kind: str, located: CurvePoints, k: int) -> bool:
    """Whether a Neimark-Sacker point is one: the multipliers with product 1 are complex."""
    if kind != "Neimark-Sacker":
        return True
    values = np.linalg.eigvals(located.extra_arrays["jacobian"][k])
    pair = min(combinations(values, 2), key=lambda two: abs(two[0] * two[1] - 1.0))
    return bool(abs(pair[0].imag) > _MIN_COMPLEX_IMAGINARY_PART)
