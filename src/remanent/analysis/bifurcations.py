"""Special points of a branch of periodic orbits: where multipliers leave or meet.

References
----------
Y. A. Kuznetsov, Elements of Applied Bifurcation Theory (Springer, 2004), chapter 10.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.optimize import elementwise

from remanent._typing import FloatArray, IntArray
from remanent.analysis.continuation import Equations, Evaluated, Points, corrected
from remanent.analysis.maps import Map

#: Its annotations know nothing of `args`.
find_root: Any = elementwise.find_root


@dataclass(frozen=True)
class Special:
    """A special point of a branch.

    Attributes
    ----------
    kind
        ``fold``, ``period doubling``, ``Neimark-Sacker`` or ``branch point``.
    segment
        It lies between this point of the branch and the next.
    points
        The point itself, a :class:`Points` of length 1.
    error
        Estimated error of the parameter.
    """

    kind: str
    segment: int
    points: Points
    error: float


def orbit_equations(map_: Map, iterate: int) -> Equations:
    """Periodic orbits as curves: unknowns (state, parameters), equations map^q(x) - x = 0.

    The last parameter varies along a curve; those before it, if there are any, stay as they
    are where the curve begins, so that curves of different systems are followed together.
    ``extra["jacobian"]`` is that of the iterate, ``extra["derivative"]`` of the equations.
    """

    def equations(unknown: FloatArray) -> Evaluated:
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
        return Evaluated(value, derivative, image.error, extra)

    return equations


# Test functions: each changes sign at its kind of point.  Points in, array (point,) out.


def _fold(points: Points, _scale: FloatArray) -> FloatArray:
    return points.tangent[:, -1]


def _doubling(points: Points, _scale: FloatArray) -> FloatArray:
    jacobian = points.extra["jacobian"]
    return np.asarray(np.linalg.det(jacobian + np.eye(jacobian.shape[1])))


def _branch_point(points: Points, scale: FloatArray) -> FloatArray:
    """Determinant of the derivatives bordered by the tangent."""
    bordered = np.concatenate([points.extra["derivative"] * scale, points.tangent[:, None]], axis=1)
    return np.asarray(np.linalg.det(bordered))


def _torus(points: Points, _scale: FloatArray) -> FloatArray:
    """Product over pairs of multipliers of their product less one."""
    values = np.linalg.eigvals(points.extra["jacobian"])
    pairs = [values[:, i] * values[:, j] - 1.0 for i, j in combinations(range(values.shape[1]), 2)]
    return np.asarray(np.prod(pairs, axis=0).real if pairs else np.ones(len(points)))


TESTS: Mapping[str, Callable[[Points, FloatArray], FloatArray]] = MappingProxyType(
    {
        "fold": _fold,
        "period doubling": _doubling,
        "branch point": _branch_point,
        "Neimark-Sacker": _torus,
    }
)


def special_points(
    equations: Equations,
    points: Points,
    *,
    scale: FloatArray,
    tolerance: float,
    conservative: bool,
) -> list[Special]:
    """All special points of a branch, in order along it.

    Parameters
    ----------
    points
        Along the branch, with ``jacobian`` and ``derivative`` in their ``extra``.
    conservative
        Products of multipliers are 1 throughout, so that no Neimark-Sacker point exists.
    """
    found: list[Special] = []
    for kind, test in TESTS.items():
        if kind == "Neimark-Sacker" and conservative:
            continue
        values = test(points, scale)
        with np.errstate(invalid="ignore"):
            segment = np.flatnonzero(values[:-1] * values[1:] < 0.0)
        if segment.size:
            found += _located(equations, points, segment, kind, scale, tolerance)
    return sorted(found, key=lambda special: special.segment)


def _located(
    equations: Equations,
    points: Points,
    segment: IntArray,
    kind: str,
    scale: FloatArray,
    tolerance: float,
) -> list[Special]:
    """Roots of a test function on some segments, all together."""
    test = TESTS[kind]

    def at(part: FloatArray, number: FloatArray) -> Points:
        k = segment[number.astype(np.int64)]
        guess, direction = between(points, k, part, scale)
        return corrected(equations, guess, direction, scale=scale, tolerance=tolerance)[0]

    number = np.arange(segment.size, dtype=np.float64)
    ends = (np.zeros(segment.size), np.ones(segment.size))
    root = find_root(
        lambda s, k: test(at(s, k), scale), ends, args=(number,),
        tolerances={"xatol": 1e-13, "xrtol": 1e-13, "fatol": 0.0, "frtol": 0.0}, maxiter=60,
    )  # fmt: skip
    here = at(root.x, number)
    kept = [k for k in range(segment.size) if root.success[k] and _is(kind, here, k)]
    return [
        Special(
            kind,
            int(segment[k]),
            here.taken(slice(k, k + 1)),
            _uncertainty(points, int(segment[k]), here, k, test, scale),
        )
        for k in kept
    ]


def _is(kind: str, here: Points, k: int) -> bool:
    """Whether a Neimark-Sacker point is one: the multipliers that meet 1 are complex."""
    if kind != "Neimark-Sacker":
        return True
    values = np.linalg.eigvals(here.extra["jacobian"][k])
    pair = min(combinations(values, 2), key=lambda two: abs(two[0] * two[1] - 1.0))
    return bool(abs(pair[0].imag) > 1e-6)


def _uncertainty(
    points: Points, segment: int, here: Points, k: int, test: Any, scale: FloatArray
) -> float:
    """Error of the parameter: of the point itself, and of where the test vanishes."""
    ends = points.taken(slice(segment, segment + 2))
    values = test(ends, scale)
    chord = np.diff(ends.unknown, axis=0)[0] / scale
    slope = abs(values[1] - values[0]) / max(float(np.linalg.norm(chord)), 1e-300)
    jacobian = here.extra["jacobian"][k]
    size = max(1.0, float(np.abs(jacobian).max()))
    error = float(here.error[k] + here.residual[k])
    shift = error * size / max(slope, 1e-300)
    return float(scale[-1] * (error * size + shift * (abs(here.tangent[k, -1]) + shift)))


def between(
    points: Points, segment: IntArray, part: FloatArray, scale: FloatArray
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


def special_equations(map_: Map, iterate: int, kind: str, scale: FloatArray) -> Equations:
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

    def equations(unknown: FloatArray) -> Evaluated:
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
        return Evaluated(value, derivative, image.error[here] * grown, {"jacobian": jacobian})

    return equations
