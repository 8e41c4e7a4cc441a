"""Periodic orbits of maps: Newton's method from many guesses, multipliers, stability."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from remanent._typing import BoolArray, ComplexArray, FloatArray, IntArray
from remanent.analysis.orbits.maps import Map, MapImage

#: Newton steps at most, and the longest one, of a component of the state.
_STEPS, _LONGEST = 25, 0.25
#: How near to 1 the size of a complex multiplier of a conservative map is, on the circle.
_CIRCLE = 1e-6
#: Orbits nearer to each other than this are one.
_APART = 1e-7


class Stability(IntEnum):
    """What the multipliers say of an orbit."""

    UNDECIDED = 0
    ELLIPTIC = 1
    SADDLE = 2
    STABLE = 3
    UNSTABLE = 4

    @property
    def meaning(self) -> str:
        return self.name.lower()


@dataclass(frozen=True)
class Orbits:
    """Periodic orbits of a map, one point of each.

    Attributes
    ----------
    state : array (orbit, state)
    jacobian : array (orbit, state, state)
        Of the iterate that closes the orbit.
    residual : array (orbit,)
        Distance of the point from its image.
    error : array (orbit,)
        Estimated error of the image.
    """

    state: FloatArray
    jacobian: FloatArray
    residual: FloatArray
    error: FloatArray


def newton_fixed_points(
    map_: Map,
    guesses: FloatArray,
    parameters: FloatArray,
    *,
    iterate: int,
    tolerance: float,
    bounds: FloatArray,
    worst: float = 1e-6,
) -> Orbits:
    """Fixed points of an iterate of a map, from many guesses; those that were reached.

    Parameters
    ----------
    guesses : array (point, state)
    parameters : array (point, parameter)
    tolerance
        Of the residual, beside the map's own error.
    bounds : array (state, 2)
        Guesses that leave a box of twice this size are given up.
    worst
        So are guesses whose image has a larger error.
    """
    x, p = guesses.copy(), parameters
    if not len(x):
        return _joined([], map_.dimension)
    centre, reach = bounds.mean(axis=1), bounds[:, 1] - bounds[:, 0]
    found: list[Orbits] = []
    for _ in range(_STEPS):
        image = map_(x, p, iterate)
        move, residual = newton_step(x, image.state, image.jacobian, longest=_LONGEST)
        done = residual <= np.maximum(tolerance, 4.0 * image.error)
        known = image.error <= worst
        kept = done & known & _within(x, bounds)
        if kept.any():
            found.append(_orbits(x, image, residual, kept))
        inside = (np.abs(x + move - centre) <= reach).all(axis=1)
        going = ~done & known & np.isfinite(move).all(axis=1) & inside
        if not going.any():
            break
        x, p = (x + move)[going], p[going]
    return _joined(found, map_.dimension)


def _within(x: FloatArray, bounds: FloatArray) -> BoolArray:
    slack = 1e-9 * (bounds[:, 1] - bounds[:, 0])
    return np.asarray(((x >= bounds[:, 0] - slack) & (x <= bounds[:, 1] + slack)).all(axis=1))


def newton_step(
    x: FloatArray, image: FloatArray, jacobian: FloatArray, *, longest: float = np.inf
) -> tuple[FloatArray, FloatArray]:
    """The next move of every point towards one that is its own image, and its residual.

    Parameters
    ----------
    x, image : array (point, state)
    jacobian : array (point, state, state)
    longest
        Moves with a longer component are shortened to it.

    Returns
    -------
    move : array (point, state)
        NaN where the equations are singular or unknown.
    residual : array (point,)
    """
    defect = image - x
    with np.errstate(all="ignore"):
        residual = np.abs(defect).max(axis=1)
        matrix = np.eye(x.shape[1]) - jacobian
        usable = np.isfinite(matrix).all(axis=(1, 2)) & np.isfinite(residual)
        safe = np.where(usable[:, None, None], matrix, np.eye(x.shape[1]))
        singular = np.abs(np.linalg.det(safe)) < np.finfo(float).tiny
        safe[singular] = np.eye(x.shape[1])
        move = np.linalg.solve(safe, defect[..., None])[..., 0]
        move[~usable | singular] = np.nan
        length = np.abs(move).max(axis=1)
        move *= np.minimum(1.0, longest / np.maximum(length, 1e-300))[:, None]
    return np.asarray(move), np.where(np.isfinite(residual), residual, np.inf)


def _orbits(x: FloatArray, image: MapImage, residual: FloatArray, which: BoolArray) -> Orbits:
    return Orbits(x[which], image.jacobian[which], residual[which], image.error[which])


def _joined(some: list[Orbits], dimension: int) -> Orbits:
    if not some:
        empty = np.empty((0, dimension))
        return Orbits(empty, np.empty((0, dimension, dimension)), np.empty(0), np.empty(0))
    names = ("state", "jacobian", "residual", "error")
    return Orbits(*(np.concatenate([getattr(one, name) for one in some]) for name in names))


def orbit_subset(orbits: Orbits, which: IntArray | BoolArray) -> Orbits:
    """Some of the orbits."""
    return Orbits(
        orbits.state[which], orbits.jacobian[which], orbits.residual[which], orbits.error[which]
    )


def distinct_orbits(map_: Map, orbits: Orbits, parameter: FloatArray, *, iterate: int) -> Orbits:
    """Each orbit once, those only whose least period is `iterate`.

    Parameters
    ----------
    parameter : array (parameter,)
        At which all of them were found.
    """
    if not orbits.residual.size:
        return orbits
    order = np.lexsort(np.round(orbits.state, 6).T[::-1])
    orbits = orbit_subset(orbits, order)
    points = [orbits.state]
    for _ in range(iterate - 1):
        points.append(map_(points[-1], np.tile(parameter, (len(order), 1)), 1).state)
    path = np.stack(points)  # (iterate, orbit, state)
    slack = _APART + 10.0 * _sensitivity(orbits)
    kept: list[int] = []
    for k in range(len(order)):
        returns = [j for j in range(1, iterate) if iterate % j == 0]
        if any(_near(path[0, k], path[j, k], slack[k]) for j in returns):
            continue
        if not any(
            _near(path[j, k], orbits.state[i], slack[k] + slack[i])
            for i in kept
            for j in range(iterate)
        ):
            kept.append(k)
    return orbit_subset(orbits, np.array(kept, dtype=np.int64))


def _sensitivity(orbits: Orbits) -> FloatArray:
    """How far from the orbit a point with its residual may be."""
    matrix = np.eye(orbits.state.shape[1]) - orbits.jacobian
    smallest = np.linalg.svd(matrix, compute_uv=False)[:, -1]
    reach = (orbits.residual + orbits.error) / np.maximum(smallest, 1e-12)
    return np.asarray(np.minimum(reach, np.sqrt(orbits.residual + orbits.error)))


def _near(a: FloatArray, b: FloatArray, slack: float) -> bool:
    return bool(np.abs(a - b).max() <= slack)


def floquet_multipliers(jacobian: FloatArray, error: FloatArray) -> tuple[ComplexArray, FloatArray]:
    """Floquet multipliers, largest first, and an estimate of their error.

    Parameters
    ----------
    jacobian : array (orbit, state, state)
    error : array (orbit,)
        Of the Jacobian, relative to its largest entry.

    Returns
    -------
    values : array (orbit, multiplier) of complex
    errors : array (orbit, multiplier)
        By the condition number of each eigenvalue, at most the root that a double
        eigenvalue's error is.
    """
    values, right = np.linalg.eig(jacobian)
    values, right = values.astype(complex), right.astype(complex)
    size = np.abs(jacobian).max(axis=(1, 2))
    change = (error + 4.0 * np.finfo(float).eps) * size
    d = jacobian.shape[1]
    with np.errstate(all="ignore"):
        left = np.linalg.pinv(right)
        condition = np.linalg.norm(left, axis=2) * np.linalg.norm(right, axis=1)
        together = np.linalg.svd(right, compute_uv=False)[:, -1] < 1e-7
        condition[together] = np.inf  # two multipliers have met
        double = np.maximum(size, 1.0) ** (1.0 - 1.0 / d) * change ** (1.0 / d)
        errors = np.fmin(condition * change[:, None], double[:, None])
    order = np.argsort(-np.abs(values) - 1e-9 * values.imag, axis=1, kind="stable")
    return np.take_along_axis(values, order, 1), np.take_along_axis(errors, order, 1)


def orbit_stability(values: ComplexArray, errors: FloatArray, *, conservative: bool) -> IntArray:
    """What multipliers, with their errors, say of each orbit.

    Parameters
    ----------
    conservative
        The map preserves area: multipliers come in pairs whose product is 1.
    """
    size, slack = np.abs(values), 4.0 * errors
    outside, inside = size > 1.0 + slack, size < 1.0 - slack
    if conservative:
        # Multipliers off the unit circle are real, but for quartets of four or more.
        turning = (np.abs(values.imag) > slack).all(axis=1) & (
            np.abs(size - 1.0) <= np.maximum(slack, _CIRCLE)
        ).all(axis=1)
        saddle = outside.any(axis=1) & inside.any(axis=1)
        kinds = [(turning, Stability.ELLIPTIC), (saddle, Stability.SADDLE)]
    else:
        kinds = [
            (inside.all(axis=1), Stability.STABLE),
            (outside.any(axis=1) & inside.any(axis=1), Stability.SADDLE),
            (outside.all(axis=1), Stability.UNSTABLE),
        ]
    result = np.full(values.shape[0], int(Stability.UNDECIDED))
    for which, kind in kinds:
        result[which] = int(kind)
    return result
