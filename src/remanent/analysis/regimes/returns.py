"""How nearly orbits come back to where they were, and after how many periods."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import FloatArray, IntArray

#: Longest period that is looked for.
MAX_RETURN_PERIOD = 128
#: Orbits smaller than this count as this large.
_MIN_ORBIT_EXTENT = 1e-3
#: Of distances up to this factor above the least, the one with the shortest period counts.
_MAX_RATIO_TO_LEAST_DISTANCE = 10.0
#: Distances this small are rounding.
_RELATIVE_ROUNDING_DISTANCE = 1e-15
#: Orbits looked at together, so that their points stay in the cache.
_ORBITS_PER_BATCH = 128


@dataclass(frozen=True)
class BestReturns:
    """The period after which orbits come back best.

    Attributes
    ----------
    period : array (orbit,) of int
    return_defect : array (orbit,)
        Largest distance of a point from the point a period later, relative to the extent.
    late_return_defect : array (orbit,)
        The same over the last quarter of the points.
    extent : array (orbit,)
        Of the orbit: the widest of its coordinates.
    """

    period: IntArray
    return_defect: FloatArray
    late_return_defect: FloatArray
    extent: FloatArray


def find_best_returns(points: FloatArray, *, closed: float = 0.0) -> BestReturns:
    """Look for the period after which orbits come back best.

    Parameters
    ----------
    points : array (orbit, iterate, observable)
        Without the transient.
    closed : float
        Distances below this, relative to the extent, are as good as none: the shortest
        period that reaches it is the best.
    """
    length = points.shape[1]
    longest = max(min(MAX_RETURN_PERIOD, length // 2), 1)
    starts = range(0, max(len(points), 1), _ORBITS_PER_BATCH)
    # Orbits last, so that the inner loops run over them.
    batches = [
        np.ascontiguousarray(np.moveaxis(points[i : i + _ORBITS_PER_BATCH], 0, 2)) for i in starts
    ]
    extent = np.concatenate([np.ptp(batch, axis=0).max(axis=0) for batch in batches])
    extent = np.maximum(extent, _MIN_ORBIT_EXTENT)
    late = np.concatenate([_late_return_distances(batch, longest) for batch in batches])
    late /= extent[:, None]
    # A multiple of the period returns as well as the period, but for rounding: so the first
    # of the distances that are nearly the least is taken.
    with np.errstate(invalid="ignore"):
        alike = (
            late
            <= _MAX_RATIO_TO_LEAST_DISTANCE * np.nanmin(late, axis=1, initial=np.inf)[:, None]
            + _RELATIVE_ROUNDING_DISTANCE
        )
    alike |= late <= closed
    best = np.argmax(alike, axis=1)
    defect = np.full(len(points), np.inf)
    for k in np.unique(best) if length > 1 else ():
        same = best == k
        orbit = points[same]
        defect[same] = np.abs(orbit[:, k + 1 :] - orbit[:, : -k - 1]).max(axis=(1, 2))
    late_defect = late[np.arange(len(points)), best]
    return BestReturns(best + 1, defect / extent, late_defect, extent)


def _late_return_distances(points: FloatArray, longest: int) -> FloatArray:
    """Largest distance after 1, 2 ... `longest` iterates over the last quarter of orbits.

    Parameters
    ----------
    points : array (iterate, observable, orbit)
    longest : int

    Returns
    -------
    array (orbit, distance)
    """
    length, _, orbits = points.shape
    late = np.full((longest, orbits), np.inf)
    distance = np.empty_like(points)
    for q in range(1, min(longest, length - 1) + 1):
        tail = min(max(length // 4, q), length - q)
        d = distance[:tail]
        np.subtract(points[-tail:], points[length - tail - q : length - q], out=d)
        late[q - 1] = np.abs(d, out=d).max(axis=(0, 1))
    return np.ascontiguousarray(late.T)
