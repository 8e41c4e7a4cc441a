"""How nearly orbits come back: distances after so many iterates, and what they tend to."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.periodic_orbits import newton_step

#: Longest period that is looked for.
LONGEST_PERIOD = 128
#: Orbits smaller than this count as this large.
_SMALLEST = 1e-3
#: Among distances this near to the least, the shortest period is the period.
_ALIKE = 10.0
#: Orbits looked at together, so that their points stay in the cache.
_TOGETHER = 128
#: Newton steps.
_STEPS = 6


@dataclass(frozen=True)
class BestReturns:
    """The period after which orbits come back best.

    Attributes
    ----------
    period : array (orbit,)
    defect : array (orbit,)
        Largest distance after a period over the stretch looked at, relative to the spread.
    late : array (orbit,)
        The same over the last quarter of the stretch.
    spread : array (orbit,)
        Extent of the orbit.
    """

    period: IntArray
    defect: FloatArray
    late: FloatArray
    spread: FloatArray


def find_best_returns(points: FloatArray, *, closed: float = 0.0) -> BestReturns:
    """Look for the period after which orbits come back best.

    Parameters
    ----------
    points : array (orbit, iterate, observable)
        Without the transient.
    closed
        Distances below this, relative to the extent, are as good as none: the shortest
        period that reaches it is the best.
    """
    length = points.shape[1]
    spread = np.maximum(np.ptp(points, axis=1).max(axis=1), _SMALLEST)
    most = max(min(LONGEST_PERIOD, length // 2), 1)
    late = np.concatenate(
        [_late(points[i : i + _TOGETHER], most) for i in range(0, max(len(points), 1), _TOGETHER)]
    )
    late /= spread[:, None]
    with np.errstate(invalid="ignore"):
        alike = late <= _ALIKE * np.nanmin(late, axis=1, initial=np.inf)[:, None] + 1e-15
    alike |= late <= closed
    best = np.argmax(alike, axis=1)
    whole = np.full(len(points), np.inf)
    for k in np.unique(best) if length > 1 else ():
        some = best == k
        one = points[some]
        whole[some] = np.abs(one[:, k + 1 :] - one[:, : -k - 1]).max(axis=(1, 2))
    return BestReturns(best + 1, whole / spread, late[np.arange(len(points)), best], spread)


def _late(points: FloatArray, most: int) -> FloatArray:
    """Largest distance after 1, 2 ... `most` iterates over the last quarter of orbits."""
    # Orbits last, so that the inner loops run over them.
    x = np.ascontiguousarray(np.moveaxis(points, 0, 2))
    length = len(x)
    late = np.full((most, len(points)), np.inf)
    for q in range(1, min(most, length - 1) + 1):
        tail = min(max(length // 4, q), length - q)
        late[q - 1] = np.abs(x[-tail:] - x[length - tail - q : length - q]).max(axis=(0, 1))
    return np.ascontiguousarray(late.T)


@dataclass(frozen=True)
class LimitOrbit:
    """The periodic orbit that motions tend to.

    Attributes
    ----------
    state : array (orbit, state)
        A point of it; NaN where Newton's method did not get there.
    residual : array (orbit,)
        Distance of the point from its image.
    multiplier : array (orbit,)
        Size of the largest multiplier of the whole period.
    """

    state: FloatArray
    residual: FloatArray
    multiplier: FloatArray


#: Image and Jacobian (point, state, state) of some points after so many periods.
IterateMap = Callable[[IntArray, FloatArray, int], tuple[FloatArray, FloatArray]]


def find_limit_orbit(
    iterate: IterateMap, which: IntArray, states: FloatArray, period: int
) -> LimitOrbit:
    """Periodic orbits near some states, by a few steps of Newton's method.

    Parameters
    ----------
    which : array (point,)
        Numbers of the points.
    states : array (point, state)
        Near the orbits.
    period
        The same for all.
    """
    x = states.copy()
    residual, largest = np.full((2, len(x)), np.inf)
    for _ in range(_STEPS):
        image, jacobian = iterate(which, x, period)
        move, residual = newton_step(x, image, jacobian)
        known = np.isfinite(jacobian).all(axis=(1, 2)) & np.isfinite(residual)
        safe = np.where(known[:, None, None], jacobian, 0.0)
        largest = np.where(known, np.abs(np.linalg.eigvals(safe)).max(axis=1), np.inf)
        x = x + move
    return LimitOrbit(x, residual, largest)


def approaches_limit(
    points: FloatArray, end: FloatArray, period: int, rate: FloatArray
) -> BoolArray:
    """Whether orbits come nearer to a limit as its multiplier says.

    Parameters
    ----------
    points : array (orbit, iterate, state)
        The last stretch.
    end : array (orbit, state)
        The point of the limit that belongs to the last iterate.
    period : int
    rate : array (orbit,)
        Logarithm of the multiplier, per period of the map.
    """
    distance = np.sqrt(((points[:, ::-1][:, ::period] - end[:, None]) ** 2).sum(axis=2))
    count = distance.shape[1]
    if count < _SHORTEST:
        return np.zeros(len(points), dtype=np.bool_)
    with np.errstate(all="ignore"):
        size = np.log(distance[:, ::-1])
        n = period * np.arange(count)
        slope = ((n - n.mean()) * (size - size.mean(axis=1, keepdims=True))).sum(axis=1)
        slope = slope / ((n - n.mean()) ** 2).sum()
        fallen = -slope * n[-1]
        alike = np.abs(slope - rate) <= _RATE * np.abs(rate)
        nearer = distance[:, 0] <= distance[:, -max(count // 4, 1) :].min(axis=1)
    return np.asarray((fallen >= _FALLEN) & alike & nearer)


#: Fewest distances that show a rate; how well it must agree; e-folds that must be seen.
_SHORTEST, _RATE, _FALLEN = 6, 0.15, 1.2
