"""Zeros of a smooth function in a box, all of them: cells are excluded, solved or divided.

A cell is a box with the value F and the derivative D of the function at its centre c.  With the
second derivatives, which are known from the derivatives of neighbouring cells, Taylor's formula
bounds each component of F on the cell, and each linear combination of them.  A cell is

* excluded where one of these cannot vanish: components, rows of D^-1 F, and F along the left
  singular vectors of D are tried,
* solved where D varies so little that Newton's method contracts: it holds one zero at most,
* divided otherwise, along the direction in which F is most curved.

So every zero lies in a cell that was solved, as far as the second derivatives at the centres
tell those in between.  Where zeros form a curve, or nearly do, cells along it are neither
excluded nor solved however small they are; such cells are set aside as flat.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from remanent._typing import BoolArray, FloatArray
from remanent.analysis.orbits.cell_samples import (
    ERROR_LIMITS,
    MAX_DERIVATIVE_CHANGE,
    Cells,
    Sample,
    SampledFunction,
    is_known,
)
from remanent.analysis.orbits.flat_cells import landings, may_be_flat

#: Second derivatives are taken to be this many times as large as neighbours tell.
_SAFETY_OF_CURVATURE = 2.5
#: A zero in a solved cell is no further than this many half-widths from where Newton's step ends.
_MAX_NEWTON_STEP_OVER_HALF_WIDTH = 2.0
#: Share of the smallest half-width of cells that the function is computed to.
_ERROR_SHARE_OF_HALF_WIDTH = 0.02
#: Cells as small as this share of the box are not divided.
_MIN_SHARE_OF_BOX = 2.0**-26
#: Where the function could not be computed, first cells are divided so many times.
_MAX_DIVISIONS_OF_UNKNOWN = 8
#: Rounds between two trials for flatness.
_ROUNDS_BETWEEN_FLATNESS_TRIALS = 2
#: Share of all effort that may be spent where it could not.
_EFFORT_SHARE_OF_UNKNOWN = 0.03
#: Most cells that are divided at once: that takes seconds, however few steps each of them needs.
_MOST_CELLS = 125_000
#: Weight of mixed second derivatives beside the others where it is decided along which direction
#: a cell is divided: they decide where nothing else does, as of products of two coordinates, and
#: count for the direction in which the cell is wider.
_WEIGHT_OF_MIXED = 1e-3
#: First cells that were divided so many times are small enough to tell their second derivatives.
_MAX_DIVISIONS_OF_COARSE = 4
#: Cells no further apart than this share of their size touch.
_TOUCHING_SLACK = 1e-6
#: What stands for a second derivative that is not known.
_UNKNOWN = 1e200


@dataclass(frozen=True)
class CellSearchOutcome:
    """What is known of the zeros in a box.

    Attributes
    ----------
    starts : array (start, coordinate)
        Newton's method converges from them to the zeros in solved cells, to each from one
        start at least.
    flat : array (cell, coordinate)
        Points where the function vanishes within `flatness`, along a curve.
    unresolved : array (cell, coordinate)
        Centres of cells of which nothing is known.
    first_sample : Sample
        The function at the centres of all first cells, unknown at those that were excluded.
    effort : float
        Of all evaluations of the function together.
    """

    starts: FloatArray
    flat: FloatArray
    unresolved: FloatArray
    first_sample: Sample
    effort: float


@np.errstate(all="ignore")  # values and slopes may be infinite
def zeros_by_cells(
    function: SampledFunction,
    edges: list[FloatArray],
    *,
    is_excluded: BoolArray | None = None,
    flatness: float,
    max_effort: float,
    is_settled: Callable[[FloatArray, FloatArray], BoolArray] | None = None,
) -> CellSearchOutcome:
    """Where all zeros of a function in a box are.

    Parameters
    ----------
    function : SampledFunction
    edges : list of array
        Of the first cells, along each coordinate.
    is_excluded : array (*first cells) of bool, optional
        First cells that are known to hold no zero.
    flatness : float
        The function vanishes up to this on curves through flat cells.
    max_effort : float
        Of all evaluations of the function together; cells that are left then are unresolved, as
        are those that become too many.
    is_settled : callable, optional
        Whether cells, given by their centres and half-widths, arrays (cell, coordinate), lie where
        all zeros are known already; nothing is looked for there.
    """
    width = np.array([e[-1] - e[0] for e in edges])
    cells, first_sample = _first_cells(function, edges, is_excluded)
    effort, effort_of_unknown, d = cells.sample.total_effort, 0.0, len(edges)
    starts, flat, unresolved = [], [], []
    for turn in range(1, 10_000):
        excluded, solved, newton = _judge(cells)
        starts.append(newton[solved])
        cells = cells.subset(~excluded & ~solved)
        if is_settled is not None:
            cells = cells.subset(~is_settled(cells.centre, cells.half_width))
        share = (cells.half_width / width).max(axis=1, initial=0.0)
        tiny = share <= _MIN_SHARE_OF_BOX
        coarse = ~(cells.sample.error <= 2.0 * ERROR_LIMITS[1]) | ~is_known(cells.sample)
        effort_of_unknown += cells.sample.subset(coarse).total_effort
        if effort_of_unknown > _EFFORT_SHARE_OF_UNKNOWN * max_effort:
            tiny |= coarse
        tiny |= coarse & (cells.divisions >= _MAX_DIVISIONS_OF_UNKNOWN)
        unresolved.append(cells.centre[tiny])
        cells = cells.subset(~tiny)
        if d > 1 and turn % _ROUNDS_BETWEEN_FLATNESS_TRIALS == 0:
            share = (cells.half_width / width).max(axis=1, initial=0.0)
            tried = np.flatnonzero(may_be_flat(cells, share))
            landed, is_flat, spent = landings(function, cells.subset(tried), flatness, width)
            effort += spent
            flat.append(landed[is_flat])
            cells = cells.subset(~np.isin(np.arange(len(cells.centre)), tried[is_flat]))
        if not len(cells.centre):
            break
        if effort >= max_effort or len(cells.centre) > _MOST_CELLS:
            unresolved.append(cells.centre)
            break
        cells = _divided(function, cells, width)
        if turn <= _MAX_DIVISIONS_OF_COARSE:
            cells = _with_curvature_of_neighbours(cells, edges)
        effort += cells.sample.total_effort
    none = np.empty((0, d))
    return CellSearchOutcome(
        np.concatenate([none, *starts]), np.concatenate([none, *flat]),
        np.concatenate([none, *unresolved]), first_sample, effort,
    )  # fmt: skip


def _first_cells(
    function: SampledFunction, edges: list[FloatArray], is_excluded: BoolArray | None
) -> tuple[Cells, Sample]:
    """Cells between edges, and what is known at all centres.

    Curvatures are the largest differences from neighbours.
    """
    shape = tuple(len(e) - 1 for e in edges)
    middle = [0.5 * (e[1:] + e[:-1]) for e in edges]
    half = [0.5 * np.diff(e) for e in edges]
    centre = np.stack([m.ravel() for m in np.meshgrid(*middle, indexing="ij")], axis=1)
    half_width = np.stack([m.ravel() for m in np.meshgrid(*half, indexing="ij")], axis=1)
    kept = np.ones(len(centre), np.bool_) if is_excluded is None else ~is_excluded.ravel()
    sample = function(centre[kept], _tolerance(half_width[kept]), None)
    m, d = sample.value.shape[1], len(edges)
    everywhere = Sample.unknown(len(centre), m, d)
    everywhere.update(np.flatnonzero(kept), sample)
    curvature = np.zeros((*shape, m, d, d))
    on_grid = everywhere.derivative.reshape(*shape, m, d)
    for k in range(d):
        with np.errstate(all="ignore"):
            slope = np.moveaxis(np.abs(np.diff(on_grid, axis=k)), k, 0)
            slope = slope / np.diff(middle[k]).reshape(-1, *[1] * (d + 1))
        # Next to an excluded cell nothing is known from that side.
        slope = np.where(np.isfinite(slope), slope, -1.0)
        edge = np.full((1, *slope.shape[1:]), -1.0)
        larger = np.maximum(np.concatenate([slope, edge]), np.concatenate([edge, slope]))
        larger = np.moveaxis(np.where(larger < 0.0, _UNKNOWN, larger), 0, k)
        curvature[..., k, :] = np.maximum(curvature[..., k, :], larger)
        curvature[..., :, k] = np.maximum(curvature[..., :, k], larger)
    none = np.zeros(len(sample.error), dtype=np.int64)
    curvature = curvature.reshape(-1, m, d, d)[kept]
    return Cells(centre[kept], half_width[kept], sample, curvature, none), everywhere


def _tolerance(half_width: FloatArray) -> float:
    least = half_width.min(initial=np.inf)
    return float(np.clip(_ERROR_SHARE_OF_HALF_WIDTH * least, *ERROR_LIMITS))


def _judge(cells: Cells) -> tuple[BoolArray, BoolArray, FloatArray]:
    """Which cells are excluded, which are solved, and where Newton's step from the centre ends."""
    h, sample, d = cells.half_width, cells.sample, cells.centre.shape[1]
    with np.errstate(all="ignore"):
        known = is_known(sample)
        value = np.where(known[:, None], sample.value, 0.0)
        derivative = np.where(known[:, None, None], sample.derivative, 0.0)
        bend = 0.5 * np.einsum("cmij,ci,cj->cm", cells.curvature, h, h)
        rest = _SAFETY_OF_CURVATURE * bend + sample.error[:, None]
        largest = np.abs(derivative).max(axis=(1, 2))
        rest += (sample.error * largest * h.sum(axis=1))[:, None]
        excluded = (np.abs(value) > np.einsum("cmj,cj->cm", np.abs(derivative), h) + rest).any(
            axis=1
        )
        sought, slope, bound = value[:, :d], derivative[:, :d], rest[:, :d]
        inverse = _inverses(slope)
        rows = [inverse, np.linalg.svd(slope)[0].swapaxes(1, 2)] if d > 1 else [inverse]
        for row in rows:
            combined = np.abs(np.einsum("crm,cm->cr", row, sought))
            linear = np.einsum("crj,cj->cr", np.abs(row @ slope), h)
            excluded |= (combined > linear + np.einsum("crm,cm->cr", np.abs(row), bound)).any(1)
        change = np.einsum("crm,cmjk,ck->crj", np.abs(inverse), cells.curvature[:, :d], h)
        unsure = (sample.error * largest)[:, None] * np.abs(inverse).sum(axis=2)
        change = _SAFETY_OF_CURVATURE * change + unsure[:, :, None]
        relative = np.einsum("crj,cj->cr", change, h) / h
        contracts = (relative.max(axis=1) <= MAX_DERIVATIVE_CHANGE) & known
        step = -np.einsum("crm,cm->cr", inverse, sought)
        blur = np.abs(inverse).sum(axis=2) * sample.error[:, None]
        near = (np.abs(step) <= _MAX_NEWTON_STEP_OVER_HALF_WIDTH * h + 2.0 * blur).all(axis=1)
    excluded &= known
    excluded |= contracts & ~near
    return excluded, contracts & ~excluded, cells.centre + step


def _with_curvature_of_neighbours(cells: Cells, edges: list[FloatArray]) -> Cells:
    """Cells with the largest second derivatives of those that they touch.

    Two points of a cell may miss what happens beyond them.
    """
    lower, upper = (
        np.column_stack(
            [
                np.interp(cells.centre[:, k] + sign * cells.half_width[:, k], e, np.arange(len(e)))
                for k, e in enumerate(edges)
            ]
        )
        for sign in (-1.0, 1.0)
    )
    middle, half = 0.5 * (lower + upper), 0.5 * (upper - lower)
    reach = 2.0 * half.max(axis=0) * (1.0 + _TOUCHING_SLACK)
    tree = cKDTree(middle / reach)
    a, b = tree.query_pairs(1.0, p=np.inf, output_type="ndarray").T
    apart = np.abs(middle[a] - middle[b])
    touching = (apart <= (half[a] + half[b]) * (1.0 + _TOUCHING_SLACK)).all(axis=1)
    a, b = a[touching], b[touching]
    curvature = cells.curvature.copy()
    known = np.where(cells.curvature < _UNKNOWN, cells.curvature, 0.0)
    np.maximum.at(curvature, a, known[b])
    np.maximum.at(curvature, b, known[a])
    return replace(cells, curvature=curvature)


def _inverses(matrices: FloatArray) -> FloatArray:
    """Inverses of small matrices; NaN where there is none."""
    if matrices.shape[1] == 1:
        return np.asarray(1.0 / matrices)
    regular = np.abs(np.linalg.det(matrices)) > np.finfo(float).tiny
    inverse = np.full(matrices.shape, np.nan)
    inverse[regular] = np.linalg.inv(matrices[regular])
    return inverse


def _divided(function: SampledFunction, cells: Cells, width: FloatArray) -> Cells:
    """Each cell as two halves, across the direction in which the function is most curved."""
    h, n = cells.half_width, np.arange(len(cells.centre))
    with np.errstate(all="ignore"):
        bend = np.einsum("cmii,ci,ci->ci", cells.curvature, h, h)
        share = h / width
        of_wider = share[:, :, None] / (share[:, :, None] + share[:, None, :])
        mixed = np.einsum("cmij,ci,cj->cij", cells.curvature, h, h)
        bend += _WEIGHT_OF_MIXED * (of_wider * mixed).sum(axis=2)
    unknown = ~(bend < _UNKNOWN).all(axis=1)
    bend[unknown] = (h / width)[unknown]
    axis = np.argmax(bend, axis=1)
    half_width = h.copy()
    half_width[n, axis] *= 0.5
    shift = np.zeros_like(h)
    shift[n, axis] = half_width[n, axis]
    centre = np.concatenate([cells.centre + shift, cells.centre - shift])
    effort = np.concatenate([cells.sample.effort] * 2)
    sample = function(centre, _tolerance(half_width), effort)
    upper, lower = sample.subset(n), sample.subset(n + len(n))
    distance = half_width[n, axis]
    with np.errstate(all="ignore"):
        slope = np.abs(upper.derivative - lower.derivative) / (2.0 * distance)[:, None, None]
        # What the parent did not foresee of the values at its halves.
        along = cells.sample.derivative[n, :, axis] * distance[:, None]
        missed = [
            np.abs(part.value - cells.sample.value - sign * along)
            for part, sign in ((upper, 1.0), (lower, -1.0))
        ]
        unforeseen = 2.0 * np.maximum(*missed) / distance[:, None] ** 2
    slope = np.where(np.isfinite(slope), slope, _UNKNOWN)
    unforeseen = np.where(np.isfinite(unforeseen), unforeseen, _UNKNOWN)
    curvature = cells.curvature.copy()
    curvature[n, :, axis, :] = slope
    curvature[n, :, :, axis] = slope
    curvature[n, :, axis, axis] = np.maximum(slope[n, :, axis], unforeseen)
    return Cells(
        centre, np.concatenate([half_width] * 2), sample, np.concatenate([curvature] * 2),
        np.concatenate([cells.divisions + 1] * 2),
    )  # fmt: skip
