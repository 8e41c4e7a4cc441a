"""How many times a function of a plane winds around zero along a closed polygon.

That is the sum of the indices of its zeros inside: of the signs of the determinant of its
derivative there, where none vanishes.

Each side is divided until the function stays on one side of a line through zero along each piece:
then it turns by the angle between its ends.  How far it strays in between is bounded by its second
derivative along the piece, as far as the first ones at the ends tell it.
"""

from __future__ import annotations

import numpy as np

from remanent._typing import BoolArray, FloatArray
from remanent.analysis.orbits.cell_samples import Sample, SampledFunction, is_known

#: Second derivatives along the polygon are taken to be this many times as large as its ends tell.
_SAFETY_OF_CURVATURE = 2.5
#: Error that the function is computed to.
_TOLERANCE = 1e-3
#: Sides are divided so many times at most: then the function vanishes on them, or is not known.
_MAX_DIVISIONS = 20


def winding_number(
    function: SampledFunction, corners: FloatArray, at_corners: Sample, *, max_effort: float
) -> int | None:
    """How many times a function winds around zero along a closed polygon, in its direction.

    Parameters
    ----------
    function : SampledFunction
        Its first two components.
    corners : array (corner, 2)
        Of the polygon, in order.
    at_corners : Sample
        The function there.
    max_effort : float
        Of all evaluations of the function together.

    Returns
    -------
    int or None
        None where the function vanishes, or is not known, somewhere along the polygon, and
        where it turns too often for the effort.
    """
    begin, end = corners, np.roll(corners, -1, axis=0)
    at_begin = at_corners
    at_end = at_corners.subset(np.roll(np.arange(len(corners)), -1))
    total, effort = 0.0, 0.0
    for _ in range(_MAX_DIVISIONS):
        turn, is_sure = _turns(at_begin, at_end, end - begin)
        total += float(turn[is_sure].sum())
        if is_sure.all():
            return round(total / (2.0 * np.pi))
        if effort >= max_effort:
            return None
        left = ~is_sure
        begin, end = begin[left], end[left]
        at_begin, at_end = at_begin.subset(left), at_end.subset(left)
        middle = 0.5 * (begin + end)
        at_middle = function(middle, _TOLERANCE, at_begin.effort)
        effort += at_middle.total_effort
        begin, end = np.concatenate([begin, middle]), np.concatenate([middle, end])
        at_begin, at_end = at_begin.followed_by(at_middle), at_middle.followed_by(at_end)
    return None


def _turns(first: Sample, last: Sample, step: FloatArray) -> tuple[FloatArray, BoolArray]:
    """The angle by which a function turns along each piece of a way, and whether it is sure."""
    a, b = first.value[:, :2], last.value[:, :2]
    with np.errstate(all="ignore"):
        known = is_known(first) & is_known(last)
        side = a / np.linalg.norm(a, axis=1)[:, None] + b / np.linalg.norm(b, axis=1)[:, None]
        side /= np.linalg.norm(side, axis=1)[:, None]
        least = np.minimum(*(np.einsum("pi,pi->p", side, value) for value in (a, b)))
        slopes = [np.einsum("pij,pj->pi", s.derivative[:, :2], step) for s in (first, last)]
        bends = [slopes[1] - slopes[0], *(2.0 * (slope - (b - a)) for slope in slopes)]
        bend = np.max([np.linalg.norm(one, axis=1) for one in bends], axis=0)
        error = np.sqrt(2.0) * np.maximum(first.error, last.error)
        is_sure = known & (least > _SAFETY_OF_CURVATURE * bend / 8.0 + error)
        turn = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], np.einsum("pi,pi->p", a, b))
    return turn, np.asarray(is_sure)
