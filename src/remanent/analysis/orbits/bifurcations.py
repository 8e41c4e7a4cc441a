"""Special points of a branch of periodic orbits: where multipliers leave or meet.

References
----------
Y. A. Kuznetsov, Elements of Applied Bifurcation Theory (Springer, 2004), chapter 10.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from itertools import combinations
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.optimize import elementwise

from remanent._typing import FloatArray, IntArray
from remanent.analysis.orbits.continuation import (
    CurveEquations,
    CurvePoints,
    EquationValues,
    correct_points,
)
from remanent.analysis.orbits.maps import Map

#: Their annotations know nothing of `args`.
_find_root: Any = elementwise.find_root
_find_minimum: Any = elementwise.find_minimum
#: A test function is beyond zero if it is by so many times its error.
_NOISE = 8.0
#: Roots are found to this share of their number along the branch.
_ROOT = 1e-13


@dataclass(frozen=True)
class SpecialPoint:
    """A special point of a branch.

    Attributes
    ----------
    kind
        ``fold``, ``period doubling``, ``Neimark-Sacker`` or ``branch point``.
    segment
        It lies between this point of the branch and the next.
    points
        The point itself, a :class:`CurvePoints` of length 1.
    error
        Estimated error of the parameter.
    """

    kind: str
    segment: int
    points: CurvePoints
    error: float


def orbit_equations(map_: Map, iterate: int) -> CurveEquations:
    """Periodic orbits as curves: unknowns (state, parameters), equations map^q(x) - x = 0.

    The last parameter varies along a curve; those before it, if there are any, stay as they
    are where the curve begins, so that curves of different systems are followed together.
    ``extra["jacobian"]`` is that of the iterate, ``extra["derivative"]`` of the equations.
    """

    def equations(unknown: FloatArray) -> EquationValues:
        d = map_.dimension
        x, p = unknown[:, :d], unknown[:, d:]
        image = map_(x, p, iterate)
        derivative = np.concatenate([image.jacobian - np.eye(d), image.slope], axis=2)
        value, held = image.state - x, p.shape[1] - 1
        if held:
            rows = np.zeros((len(x), held, d + held + 1))
            rows[:, np.arange(held), d + np.arange(held)] = 1.0
            derivative = np.concatenate([derivative, rows], axis=1)
            value = np.concatenate([value, np.zeros((len(x), held))], axis=1)
        extra = {"jacobian": image.jacobian, "derivative": derivative}
        return EquationValues(value, derivative, image.error, extra)

    return equations


# Test functions: each changes sign at its kind of point.  Points in, array (point,) out.


def _fold(points: CurvePoints, _scale: FloatArray) -> FloatArray:
    return points.tangent[:, -1]


def _doubling(points: CurvePoints, _scale: FloatArray) -> FloatArray:
    jacobian = points.extra["jacobian"]
    return np.asarray(np.linalg.det(jacobian + np.eye(jacobian.shape[1])))


def _branch_point(points: CurvePoints, scale: FloatArray) -> FloatArray:
    """Determinant of the derivatives bordered by the tangent."""
    bordered = np.concatenate([points.extra["derivative"] * scale, points.tangent[:, None]], axis=1)
    return np.asarray(np.linalg.det(bordered))


def _torus(points: CurvePoints, _scale: FloatArray) -> FloatArray:
    """Product over pairs of multipliers of their product less one."""
    values = np.linalg.eigvals(points.extra["jacobian"])
    pairs = [values[:, i] * values[:, j] - 1.0 for i, j in combinations(range(values.shape[1]), 2)]
    return np.asarray(np.prod(pairs, axis=0).real if pairs else np.ones(len(points)))


TestFunction = Callable[[CurvePoints, FloatArray], FloatArray]
TEST_FUNCTIONS: Mapping[str, TestFunction] = MappingProxyType(
    {
        "fold": _fold,
        "period doubling": _doubling,
        "branch point": _branch_point,
        "Neimark-Sacker": _torus,
    }
)


def find_special_points(
    equations: CurveEquations,
    points: CurvePoints,
    *,
    scale: FloatArray,
    tolerance: float,
    conservative: bool,
) -> list[SpecialPoint]:
    """All special points of a branch, in order along it.

    Parameters
    ----------
    points
        Along the branch, with ``jacobian`` and ``derivative`` in their ``extra``.
    conservative
        Products of multipliers are 1 throughout, so that no Neimark-Sacker point exists.
    """
    found: list[SpecialPoint] = []
    along = partial(_along, equations, points, scale, tolerance)
    for kind, test in TEST_FUNCTIONS.items():
        if kind == "Neimark-Sacker" and conservative:
            continue

        def value(where: FloatArray, test: TestFunction = test) -> FloatArray:
            return np.asarray(test(along(where), scale), dtype=np.float64)

        values = test(points, scale)
        with np.errstate(invalid="ignore"):
            crossed = np.flatnonzero(values[:-1] * values[1:] < 0.0)
        middle, left, right = _dips(value, values, points)
        low = np.concatenate([crossed, left, middle]).astype(np.float64)
        high = np.concatenate([crossed + 1, middle, right]).astype(np.float64)
        if low.size:
            found += _located(kind, along, value, low, high, scale)
    return sorted(found, key=lambda special: special.segment)


def _along(
    equations: CurveEquations,
    points: CurvePoints,
    scale: FloatArray,
    tolerance: float,
    where: FloatArray,
) -> CurvePoints:
    """Points of a branch at real numbers: 2.5 lies midway between its third and fourth."""
    segment = np.clip(where.astype(np.int64), 0, len(points) - 2)
    guess, direction = interpolate_curve(points, segment, where - segment, scale)
    return correct_points(equations, guess, direction, scale=scale, tolerance=tolerance)[0]


def _dips(
    value: Callable[[FloatArray], FloatArray], values: FloatArray, points: CurvePoints
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Where a test function passes zero and comes back between points of one sign.

    The size of its values is least at some points.  Where its neighbours differ from that by
    more than it is away from zero, the minimum near it is looked for.

    Returns
    -------
    middle, left, right : array (dip,)
        Numbers along the branch: beyond zero, and on this side before and after.
    """
    size = np.abs(values)
    before, here, after = size[:-2], size[1:-1], size[2:]
    with np.errstate(invalid="ignore"):
        same = (values[:-2] * values[1:-1] > 0.0) & (values[2:] * values[1:-1] > 0.0)
        near = (here <= before) & (here < after) & (here < before + after - 2.0 * here)
    k = np.flatnonzero(same & near) + 1
    if not k.size:
        return (np.empty(0),) * 3
    side, x = np.sign(values[k]), k.astype(np.float64)
    least = _find_minimum(
        lambda x, side: side * value(x), (x - 1.0, x, x + 1.0), args=(side,), maxiter=60,
        tolerances={"xatol": 1e-7, "xrtol": 0.0, "fatol": 0.0, "frtol": 1e-9},
    )  # fmt: skip
    rounding = _NOISE * (points.error[k] + points.residual[k] + np.finfo(float).eps)
    beyond = least.f_x < -rounding * _sizes(points)[k]
    return least.x[beyond], x[beyond] - 1.0, x[beyond] + 1.0


def _sizes(points: CurvePoints) -> FloatArray:
    return np.asarray(np.maximum(1.0, np.abs(points.extra["jacobian"]).max(axis=(1, 2))))


def _located(
    kind: str,
    along: Callable[[FloatArray], CurvePoints],
    value: Callable[[FloatArray], FloatArray],
    low: FloatArray,
    high: FloatArray,
    scale: FloatArray,
) -> list[SpecialPoint]:
    """Roots of a test function between numbers along a branch, all together."""
    root = _find_root(
        value, (low, high),
        tolerances={"xatol": _ROOT, "xrtol": _ROOT, "fatol": 0.0, "frtol": 0.0}, maxiter=60,
    )  # fmt: skip
    here, ends = along(root.x), (along(low), along(high))
    steps = [np.linalg.norm((end.unknown - here.unknown) / scale, axis=1) for end in ends]
    # No steeper at the root than towards either end: next to a turn it is half as steep.
    slope = np.minimum(*(np.abs(value(x)) / s for x, s in zip((low, high), steps, strict=True)))
    error = (here.error + here.residual) * _sizes(here)
    shift = error / np.maximum(slope, 1e-300)
    shift += 2.0 * _ROOT * (1.0 + root.x) * (steps[0] + steps[1]) / (high - low)
    uncertainty = scale[-1] * (error + shift * (np.abs(here.tangent[:, -1]) + shift))
    return [
        SpecialPoint(kind, int(root.x[k]), here.taken(slice(k, k + 1)), float(uncertainty[k]))
        for k in range(root.x.size)
        if root.success[k] and _is(kind, here, k)
    ]


def _is(kind: str, here: CurvePoints, k: int) -> bool:
    """Whether a Neimark-Sacker point is one: the multipliers that meet 1 are complex."""
    if kind != "Neimark-Sacker":
        return True
    values = np.linalg.eigvals(here.extra["jacobian"][k])
    pair = min(combinations(values, 2), key=lambda two: abs(two[0] * two[1] - 1.0))
    return bool(abs(pair[0].imag) > 1e-6)


def interpolate_curve(
    points: CurvePoints, segment: IntArray, part: FloatArray, scale: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """A guess on the cubic between two points of a curve, and its direction."""
    a, b = points.unknown[segment] / scale, points.unknown[segment + 1] / scale
    ta, tb = points.tangent[segment], points.tangent[segment + 1]
    gap = np.linalg.norm(b - a, axis=1)[:, None]
    s = part[:, None]
    h01 = s * s * (3.0 - 2.0 * s)
    guess = a + h01 * (b - a) + gap * s * (1.0 - s) * ((1.0 - s) * ta - s * tb)
    direction = (1.0 - s) * ta + s * tb
    return guess * scale, direction / np.linalg.norm(direction, axis=1)[:, None]


#: Half the distance over which a test function is differenced, in scaled unknowns.
_APART = 1e-5
_SIGNS = MappingProxyType({"fold": -1.0, "period doubling": 1.0})


def bifurcation_equations(map_: Map, iterate: int, kind: str, scale: FloatArray) -> CurveEquations:
    """Folds or period doublings as curves: unknowns (state, two parameters).

    Equations: map^q(x) - x = 0 and det(J - 1) = 0 at a fold, det(J + 1) = 0 at a doubling.
    The derivatives of the determinant are differences; they decide how fast Newton's method
    converges, not where.

    Parameters
    ----------
    kind
        ``fold`` or ``period doubling``.
    scale : array (state + 2,)
    """
    sign = _SIGNS[kind]

    def determinant(jacobian: FloatArray) -> FloatArray:
        return np.asarray(np.linalg.det(jacobian + sign * np.eye(jacobian.shape[-1])))

    def equations(unknown: FloatArray) -> EquationValues:
        count, size = unknown.shape
        d = size - 2
        moves = _APART * np.concatenate([np.zeros((1, size)), np.diag(scale), -np.diag(scale)])
        all_ = (unknown[:, None, :] + moves).reshape(-1, size)
        image = map_(all_[:, :d], all_[:, d:], iterate)
        test = determinant(image.jacobian).reshape(count, -1)
        here = slice(None, None, 2 * size + 1)
        slope = (test[:, 1 : 1 + size] - test[:, 1 + size :]) / (2.0 * _APART * scale)
        orbit = np.concatenate([image.jacobian[here] - np.eye(d), image.slope[here]], axis=2)
        jacobian = image.jacobian[here]
        grown = np.maximum(1.0, np.abs(jacobian).max(axis=(1, 2))) ** d
        value = np.column_stack([image.state[here] - unknown[:, :d], test[:, 0]])
        derivative = np.concatenate([orbit, slope[:, None, :]], axis=1)
        return EquationValues(value, derivative, image.error[here] * grown, {"jacobian": jacobian})

    return equations
