"""Curves that run over themselves: which of their points are drawn already."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from remanent._typing import FloatArray

__all__ = ["new_stretches", "turning_points"]

#: Distance from a drawn curve, over the height or width of all that is drawn, at which a point
#: lies on it: at 3 inches a third of the width of a thin line.
_ON_CURVE_DISTANCE: Final = 1.5e-3
#: Length of a stretch on a drawn curve, over that size, from which it is a second pass: the two
#: arms of a fold are as close as this where they meet.
_MIN_SECOND_PASS_LENGTH: Final = 0.05
#: Most points that a drawn curve is resolved with.
_MAX_POINT_COUNT: Final = 100_000


def turning_points(x: FloatArray) -> list[int]:
    """Places at which a curve turns back in `x`, between its first and its last point.

    Parameters
    ----------
    x : array (point,)
        Finite.

    Returns
    -------
    list of int
    """
    direction = np.sign(np.diff(x))
    known = np.flatnonzero(direction)
    turns = np.flatnonzero(direction[known[1:]] != direction[known[:-1]])
    return [int(place) for place in known[turns + 1]]


def new_stretches(points: FloatArray, drawn: Sequence[FloatArray], size: FloatArray) -> list[slice]:
    """Stretches of a curve that do not lie on the curves drawn before.

    A doubled branch meets every orbit twice, half of its period apart, and both times at the
    same amplitude: the dashes of the second pass would fill the gaps of the first.

    Parameters
    ----------
    points : array (point, 2)
        The curve.
    drawn : sequence of array (any, 2)
        Curves of the same look that are drawn.
    size : array (2,)
        Extent of all that is drawn.

    Returns
    -------
    list of slice
        Each with the neighbours that join it to what was drawn; the whole where nothing is
        drawn twice.
    """
    scaled = points / size
    is_on = np.zeros(len(points), dtype=np.bool_)
    for curve in drawn:
        is_on |= _lies_on(scaled, curve / size)
    steps = np.concatenate([[0.0], np.nancumsum(np.hypot(*np.diff(scaled, axis=0).T))])
    for first, last in _runs(is_on):
        if steps[last - 1] - steps[first] < _MIN_SECOND_PASS_LENGTH:
            is_on[first:last] = False
    return [slice(max(a - 1, 0), min(b + 1, len(points))) for a, b in _runs(~is_on)]


def _runs(marks: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First place and the place after the last one of each run of true marks."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], marks.astype(np.int8), [0]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _lies_on(points: FloatArray, curve: FloatArray) -> NDArray[np.bool_]:
    """Whether each point is as near to a polygon as a third of a line's width."""
    curve = curve[np.isfinite(curve).all(axis=1)]
    found: NDArray[np.bool_] = np.asarray(np.isfinite(points).all(axis=1))
    if len(curve) < 2 or not found.any():
        return np.zeros(len(points), dtype=np.bool_)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(curve, axis=0).T))])
    count = min(int(along[-1] / _ON_CURVE_DISTANCE) + 2, _MAX_POINT_COUNT)
    places = np.linspace(0.0, along[-1], count)
    dense = np.stack([np.interp(places, along, column) for column in curve.T], axis=1)
    from scipy.spatial import KDTree  # takes a while

    distance, _ = KDTree(np.concatenate([dense, curve])).query(points[found])
    found[found] = distance <= _ON_CURVE_DISTANCE
    return found
