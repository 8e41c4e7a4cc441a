"""Periodic orbits of maps: Newton's method from many guesses, each orbit once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.maps import Map

#: Newton steps at most.
_MAX_NEWTON_STEPS = 25
#: A guess makes progress where its residual falls below this share of what it was at the last
#: progress.
_PROGRESS_SHARE_OF_RESIDUAL = 0.7
#: Longest step of a component of the state: far from an orbit a whole step leads anywhere.
_MAX_NEWTON_STEP_COMPONENT = 0.25
#: A residual cannot be expected to fall below this many times the error of the image.
_RESIDUAL_FLOOR_OVER_ERROR = 4.0
#: Share of its width by which a point may lie outside the box, for rounding.
_BOX_SLACK_SHARE_OF_WIDTH = 1e-9
#: Points nearer to each other than this, relative to their size, are one, whatever their errors.
_MIN_DISTANCE = 1e-10
#: Points nearer to each other than this many times their errors are one, too.
_MIN_DISTANCE_OVER_ERROR = 2.0
#: Digits of the states by which orbits are put in order.
_STATE_DIGITS_FOR_SORTING = 6


@dataclass(frozen=True)
class PeriodicOrbits:
    """Periodic orbits of a map, one point of each.

    Attributes
    ----------
    state : array (orbit, state)
    jacobian : array (orbit, state, state)
        Of the iterate that closes the orbit.
    residual : array (orbit,)
        Distance of the point from its image.
    image_error : array (orbit,)
        Estimated error of the image.
    """

    state: FloatArray
    jacobian: FloatArray
    residual: FloatArray
    image_error: FloatArray

    @property
    def index(self) -> IntArray:
        """Sign of det(1 - J), array (orbit,): the index of a fixed point of the iterate."""
        return np.asarray(
            np.sign(np.linalg.det(np.eye(self.state.shape[1]) - self.jacobian)), dtype=np.int64
        )

    def subset(self, indices: IntArray | BoolArray) -> PeriodicOrbits:
        """Some of the orbits, in the order of the indices."""
        return PeriodicOrbits(
            self.state[indices], self.jacobian[indices], self.residual[indices],
            self.image_error[indices],
        )  # fmt: skip


def newton_fixed_points(
    map_: Map,
    guesses: FloatArray,
    parameters: FloatArray,
    *,
    iterate: int,
    tolerance: float,
    box: FloatArray,
    max_error: float = 1e-6,
    patience: int = _MAX_NEWTON_STEPS,
) -> PeriodicOrbits:
    """Fixed points of an iterate of a map, from many guesses; those that were reached.

    Parameters
    ----------
    map_ : Map
    guesses : array (point, state)
    parameters : array (point, parameter)
    iterate : int
        Of the map.
    tolerance : float
        Of the residual, beside the map's own error.
    box : array (state, 2)
        Where fixed points are looked for.  Guesses that leave a box of twice this size are
        given up.
    max_error : float
        So are guesses whose image has a larger error.
    patience : int
        So are guesses that have made no progress for so many steps in a row.
    """
    x, p = guesses.copy(), parameters
    if not len(x):
        return concatenate_orbits([], map_.dimension)
    least, idle = np.full(len(x), np.inf), np.zeros(len(x), dtype=np.int64)
    centre, width = box.mean(axis=1), box[:, 1] - box[:, 0]
    parts: list[PeriodicOrbits] = []
    for _ in range(_MAX_NEWTON_STEPS):
        image = map_(x, p, iterate)
        move, residual = fixed_point_newton_step(
            x, image.state, image.jacobian, longest=_MAX_NEWTON_STEP_COMPONENT
        )
        converged = residual <= np.maximum(tolerance, _RESIDUAL_FLOOR_OVER_ERROR * image.error)
        accurate = image.error <= max_error
        reached = converged & accurate & _is_inside_box(x, box)
        if reached.any():
            points = PeriodicOrbits(x, image.jacobian, residual, image.error)
            parts.append(points.subset(reached))
        is_close = (np.abs(x + move - centre) <= width).all(axis=1)
        progress = residual < _PROGRESS_SHARE_OF_RESIDUAL * least
        least, idle = np.where(progress, residual, least), np.where(progress, 0, idle + 1)
        going_on = ~converged & accurate & np.isfinite(move).all(axis=1) & is_close
        going_on &= idle < patience
        if not going_on.any():
            break
        x, p = (x + move)[going_on], p[going_on]
        least, idle = least[going_on], idle[going_on]
    return concatenate_orbits(parts, map_.dimension)


def _is_inside_box(x: FloatArray, box: FloatArray) -> BoolArray:
    slack = _BOX_SLACK_SHARE_OF_WIDTH * (box[:, 1] - box[:, 0])
    return np.asarray(((x >= box[:, 0] - slack) & (x <= box[:, 1] + slack)).all(axis=1))


def fixed_point_newton_step(
    x: FloatArray, image: FloatArray, jacobian: FloatArray, *, longest: float = np.inf
) -> tuple[FloatArray, FloatArray]:
    """The next move of every point towards one that is its own image, and its residual.

    Parameters
    ----------
    x, image : array (point, state)
    jacobian : array (point, state, state)
    longest : float
        Moves with a longer component are shortened to it.

    Returns
    -------
    move : array (point, state)
        The solution of (1 - J) move = image - x; NaN where that is singular or unknown.
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


def concatenate_orbits(parts: list[PeriodicOrbits], dimension: int) -> PeriodicOrbits:
    """Some sets of orbits as one."""
    if not parts:
        empty = np.empty((0, dimension))
        return PeriodicOrbits(empty, np.empty((0, dimension, dimension)), np.empty(0), np.empty(0))
    names = ("state", "jacobian", "residual", "image_error")
    return PeriodicOrbits(
        *(np.concatenate([getattr(part, name) for part in parts]) for name in names)
    )


def distinct_orbits_of_least_period(
    map_: Map,
    orbits: PeriodicOrbits,
    parameter: FloatArray,
    *,
    iterate: int,
    errors: FloatArray | None = None,
) -> PeriodicOrbits:
    """Each orbit once, those only whose least period is `iterate`.

    Of two points of an orbit the one with the smaller first variable is kept.

    Parameters
    ----------
    map_ : Map
    orbits : PeriodicOrbits
        Fixed points of the iterate: an orbit may be there several times, by several of its
        points, and orbits of shorter periods may be there.
    parameter : array (parameter,)
        At which all of them were found.
    iterate : int
        Of the map.
    errors : array (orbit,), optional
        Of the points; by default from their residuals.
    """
    if not orbits.residual.size:
        return orbits
    error = position_errors(orbits) if errors is None else errors
    order = np.lexsort(np.round(orbits.state, _STATE_DIGITS_FOR_SORTING).T[::-1])
    orbits, error = orbits.subset(order), error[order]
    index = orbits.index
    path, reach = [orbits.state], [error]
    for _ in range(iterate - 1):
        image = map_(path[-1], np.tile(parameter, (len(order), 1)), 1)
        path.append(image.state)
        step = np.abs(image.jacobian).sum(axis=2).max(axis=1)
        reach.append(np.maximum(step, 1.0) * reach[-1] + image.error)
    divisors = [j for j in range(1, iterate) if iterate % j == 0]
    kept: list[int] = []
    for k in range(len(order)):
        if any(are_one(path[0][k], path[j][k], error[k] + reach[j][k]) for j in divisors):
            continue
        if not any(
            index[i] == index[k] and are_one(path[j][k], orbits.state[i], reach[j][k] + error[i])
            for i in kept
            for j in range(iterate)
        ):
            kept.append(k)
    return orbits.subset(np.array(kept, dtype=np.int64))


def distinct_fixed_points(orbits: PeriodicOrbits, errors: FloatArray) -> IntArray:
    """Indices of different points: each fixed point of the iterate once.

    Parameters
    ----------
    orbits : PeriodicOrbits
    errors : array (orbit,)
        Of the points.
    """
    kept: list[int] = []
    index = orbits.index
    for k in np.argsort(errors, kind="stable"):
        if not any(
            index[i] == index[k]
            and are_one(orbits.state[i], orbits.state[k], errors[i] + errors[k])
            for i in kept
        ):
            kept.append(int(k))
    return np.array(sorted(kept), dtype=np.int64)


def position_errors(orbits: PeriodicOrbits) -> FloatArray:
    """How far from the orbit a point with its residual may be, array (orbit,), to first order."""
    matrix = np.eye(orbits.state.shape[1]) - orbits.jacobian
    smallest = np.linalg.svd(matrix, compute_uv=False)[:, -1]
    defect = orbits.residual + orbits.image_error
    return np.asarray(defect / np.maximum(smallest, np.finfo(float).tiny))


def are_one(a: FloatArray, b: FloatArray, error: float) -> bool:
    """Whether two points may be the same, with the sum of their errors."""
    slack = _MIN_DISTANCE * (1.0 + np.abs(a).max()) + _MIN_DISTANCE_OVER_ERROR * error
    return bool(np.abs(a - b).max() <= slack)
