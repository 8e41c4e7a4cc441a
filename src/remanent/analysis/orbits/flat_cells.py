"""Cells on curves where a function of a plane vanishes, or almost does."""

from __future__ import annotations

import numpy as np

from remanent._typing import BoolArray, FloatArray
from remanent.analysis.orbits.cell_samples import (
    MAX_DERIVATIVE_CHANGE,
    MAX_ERROR_SHARE,
    Cells,
    SampledFunction,
)

#: Cells on which the smallest component of the function is larger than this are not flat.
_MAX_VALUE_OF_FLAT_CELL = 0.02
#: Cells whose half-widths are this share of the box are tried for flatness.
_FLAT_SHARE_OF_BOX = 2.0**-6
#: Larger ones, up to this share, if they are known to hold one curve at most.
_STRAIGHT_FLAT_SHARE_OF_BOX = 2.0**-5
#: Within such a part of the box the function rises along a flat curve to so many times its flatness
#: at most.
_MAX_RISE_OF_FLATNESS = 10.0
#: Newton steps that lead to a flat curve.
_LANDING_STEPS = 4


def may_be_flat(cells: Cells, share: FloatArray) -> BoolArray:
    """Whether a cell may hold one curve on which the function is small, and no more, array (cell,).

    The component along the left singular vector of the smallest singular value is small at the
    centre; the cell is small, or the other component varies along it as a linear function does.
    """
    d, h = cells.centre.shape[1], cells.half_width
    value, slope = cells.sample.value[:, :d], cells.sample.derivative[:, :d]
    known = np.isfinite(slope).all(axis=(1, 2)) & (cells.sample.error <= MAX_ERROR_SHARE)
    slope = np.where(known[:, None, None], slope * h[:, None, :], 0.0)
    left, size, _ = np.linalg.svd(slope)
    with np.errstate(all="ignore"):
        small = np.abs(np.einsum("cm,cm->c", left[:, :, -1], value)) - cells.sample.error
        bend = np.einsum("cmjk,cj,ck->cm", cells.curvature[:, :d], h, h)
        change = np.einsum("cmr,cm->cr", np.abs(left[:, :, :-1]), bend) / size[:, :-1]
    is_straight = (change <= MAX_DERIVATIVE_CHANGE).all(axis=1)
    fits = (share <= _FLAT_SHARE_OF_BOX) | (is_straight & (share <= _STRAIGHT_FLAT_SHARE_OF_BOX))
    return np.asarray(known & fits & (small <= _MAX_VALUE_OF_FLAT_CELL))


def landings(
    function: SampledFunction, cells: Cells, flatness: float, box_width: FloatArray
) -> tuple[FloatArray, BoolArray, float]:
    """Where Newton's method without its flattest direction lands, and whether it is flat there.

    It starts at both sides of the centre along that direction, so that a single multiple zero
    is not taken for a curve of zeros; nor is one of which the derivative tells that the function
    does not stay small around it.  The last value is the effort.
    """
    count, d = cells.centre.shape
    if not count:
        return cells.centre, np.empty(0, np.bool_), 0.0
    h = cells.half_width
    slope = cells.sample.derivative[:, :d] * h[:, None, :]
    flattest = np.linalg.svd(slope)[2][:, -1] * h
    places = np.concatenate([cells.centre + 0.5 * flattest, cells.centre - 0.5 * flattest])
    effort, reach = np.concatenate([cells.sample.effort] * 2), np.concatenate([h, h])
    is_near, pending, spent = np.zeros(2 * count, np.bool_), np.arange(2 * count), 0.0
    for _ in range(_LANDING_STEPS):
        sample = function(places[pending], 0.1 * flatness, effort[pending])
        spent += sample.total_effort
        good = np.isfinite(sample.derivative).all(axis=(1, 2))
        good = np.asarray(good & np.isfinite(sample.value).all(axis=1))
        pending, sample = pending[good], sample.subset(good)
        effort[pending] = sample.effort
        near = np.abs(sample.value[:, :d]).max(axis=1) <= flatness
        around = _FLAT_SHARE_OF_BOX * box_width * sample.derivative[:, :d]
        stays = np.linalg.svd(around, compute_uv=False)[:, -1] <= _MAX_RISE_OF_FLATNESS * flatness
        is_near[pending[near & stays]] = True
        pending, sample = pending[~near], sample.subset(~near)
        if not pending.size:
            break
        u, s, vt = np.linalg.svd(sample.derivative[:, :d])
        with np.errstate(all="ignore"):
            part = np.einsum("cms,cm->cs", u, sample.value[:, :d]) / s
        part[:, -1] = 0.0
        part[~np.isfinite(part)] = 0.0
        step = -np.einsum("csj,cs->cj", vt, part)
        places[pending] += np.clip(step, -reach[pending], reach[pending])
    is_flat = is_near.reshape(2, count).all(axis=0)
    apart = np.abs(places[:count] - places[count:]) >= 0.25 * np.abs(flattest)
    return places[:count], np.asarray(is_flat & apart.any(axis=1)), spent
