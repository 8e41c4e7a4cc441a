"""Points and their tangents followed over many periods: what all long statistics are made of.

Works for any map that can say where points and tangents go: the period map of a flow, the
logistic map.  Tangents are made orthonormal again after every few periods, before they
line up or overflow; how much each had grown, and how they had lined up, is kept.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray

#: A state beyond this has escaped.
ESCAPE_BOUND = 1e6
#: Most periods between renormalisations of one tangent, and of several, which must not line up.
_ALONE, _TOGETHER = 16, 4
#: Blocks that even a short run has: statistics are made of them.
_BLOCKS = 32


class TangentImage(Protocol):
    """Where some points and their tangents went."""

    @property
    def visited(self) -> FloatArray:
        """States after each period, or after the last alone: (point, period, state)."""

    @property
    def tangents(self) -> FloatArray:
        """Tangents after the last period, array (point, direction, state)."""

    @property
    def error(self) -> FloatArray:
        """Largest error of the state that one period added, array (point,)."""

    @property
    def trusted(self) -> BoolArray:
        """Whether the error that was asked for was met, array (point,)."""


class TangentMap(Protocol):
    """A map with tangents, of points that it knows by their numbers."""

    def __call__(
        self,
        which: IntArray,
        states: FloatArray,
        tangents: FloatArray,
        periods: int,
        *,
        every: bool,
    ) -> TangentImage:
        """Advance points by so many periods.

        Parameters
        ----------
        which : array (point,)
            Numbers of the points, so that what differs between them can be looked up.
        states : array (point, state)
        tangents : array (point, direction, state)
        periods
            How many.
        every
            Whether the state after each period is wanted, or after the last only.
        """


@dataclass(frozen=True)
class LongRun:
    """Many points followed over the same number of periods.

    Attributes
    ----------
    periods : int
        How many were asked for.
    block : int
        Periods between renormalisations.
    factors : array (point, block, direction, direction)
        Upper triangles R of the tangents' factorisation Q R after each block; NaN after
        the end of a point.
    last : array (point, state)
        Where the points ended.
    visited : array (point, period + 1, state), optional
        All states, the start included; NaN after the end.
    escaped : array (point,) of bool
        Left every bound, or all numbers.
    trusted : array (point,) of bool
        Every period met its error.
    length : array (point,)
        Whole periods before the point escaped or could not be trusted.
    error : array (point,)
        Largest error of one period.
    horizon : array (point,)
        Periods over which errors, magnified as tangents are, stay below what was asked.
    """

    periods: int
    block: int
    factors: FloatArray
    last: FloatArray
    visited: FloatArray | None
    escaped: BoolArray
    trusted: BoolArray
    length: IntArray
    error: FloatArray
    horizon: FloatArray

    @property
    def growth(self) -> FloatArray:
        """Logarithms of the tangents' growth in each block, array (point, block, direction)."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.log(np.diagonal(self.factors, axis1=2, axis2=3))

    def updated(self, other: LongRun, which: IntArray) -> LongRun:
        """With what became of some points in another run, but for their tangents."""
        names = ("last", "visited", "escaped", "trusted", "length", "error", "horizon")
        values = {name: getattr(self, name).copy() for name in names}
        for name, value in values.items():
            value[which] = getattr(other, name)
        return replace(self, factors=self.factors[:, :0], **values)

    @property
    def lengths(self) -> IntArray:
        """Periods of each block, of which the last may be shorter, array (block,)."""
        return np.diff(_ends(self.periods, self.block), prepend=0)


def _ends(periods: int, block: int) -> IntArray:
    return np.append(np.arange(block, periods, block), periods)


def block_lengths(periods: int, directions: int, block: int | None = None) -> IntArray:
    """Periods of each block of a run; the last may be shorter."""
    return np.diff(_ends(periods, block or _block(periods, directions)), prepend=0)


def _block(periods: int, directions: int) -> int:
    return min(max(periods // _BLOCKS, 1), _ALONE if directions <= 1 else _TOGETHER)


def propagate_tangents(
    advance: TangentMap,
    states: FloatArray,
    periods: int,
    *,
    directions: int,
    width: int | None = None,
    every: bool = False,
    lost: float = 1e-2,
    block: int | None = None,
    cancelled: Callable[[], bool] = lambda: False,
) -> LongRun:
    """Follow points over many periods.

    Parameters
    ----------
    states : array (point, state)
        To start from.
    periods
        How many.
    directions
        Tangents that are carried along.
    width
        Components of a tangent; those of a state by default.
    every
        Keep all states.
    lost
        Error of the state from which on it is not known any more, for `horizon`.
    block
        Periods between renormalisations; one where the smallest exponent matters, since of
        tangents that lined up nothing is left but rounding.
    cancelled
        Asked before each block; if it says so, the rest is left out.
    """
    count, dimension = states.shape
    block = block or _block(periods, directions)
    ends = _ends(periods, block)
    factors = np.full((count, ends.size, directions, directions), np.nan)
    visited = np.full((count, periods + 1, dimension), np.nan) if every else None
    if visited is not None:
        visited[:, 0] = states
    now, frame = states.copy(), np.tile(_frame(width or dimension)[:directions], (count, 1, 1))
    escaped, trusted = np.zeros(count, dtype=np.bool_), np.ones(count, dtype=np.bool_)
    length, error = np.zeros(count, dtype=np.int64), np.zeros(count)
    carried, horizon = np.zeros(count), np.full(count, np.inf)
    active, done = np.arange(count), 0
    for k, end in enumerate(ends.tolist()):
        if not active.size or cancelled():
            break
        image = advance(active, now[active], frame[active], end - done, every=every)
        out = ~(np.abs(image.visited) < ESCAPE_BOUND).all(axis=(1, 2))
        good = ~out & image.trusted
        escaped[active], trusted[active] = out, image.trusted | out
        into, some = active[good], np.flatnonzero(good)
        if visited is not None:
            visited[into, done + 1 : end + 1] = image.visited[some]
        now[into], length[into] = image.visited[some, -1], end
        error[into] = np.maximum(error[into], image.error[some])
        frame[into], factors[into, k] = orthonormalise(image.tangents[some])
        if directions:
            grown = np.maximum(factors[into, k, 0, 0], 1.0)
            with np.errstate(over="ignore"):
                carried[into] = carried[into] * grown + image.error[some] * (end - done)
            horizon[into] = np.where(carried[into] <= lost, np.inf, np.minimum(horizon[into], done))
        active, done = into, end
    horizon = np.minimum(horizon, length)
    return LongRun(periods, block, factors, now, visited, escaped, trusted, length, error, horizon)


def _frame(dimension: int) -> FloatArray:
    """Orthonormal directions with no preference for any coordinate, the same every time."""
    random = np.random.default_rng(7).normal(size=(1, dimension, dimension))
    return np.asarray(orthonormalise(random)[0][0])


def orthonormalise(vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Gram-Schmidt, twice where it has to be: vectors = R^T Q by rows.

    Parameters
    ----------
    vectors : array (point, direction, state)

    Returns
    -------
    rows : array (point, direction, state)
        Orthonormal, the first along the first vector.
    factors : array (point, direction, direction)
        Upper triangular with a positive diagonal: vector j is the sum over i of
        ``factors[i, j]`` times row i.  Of a vector that lies among those before it to
        within rounding, the diagonal says how large that is, and its row is any.
    """
    q = vectors.copy()
    count = q.shape[1]
    r = np.zeros((q.shape[0], count, count))
    with np.errstate(all="ignore"):
        for j in range(count):
            whole = _sizes(q[:, j])
            for _ in range(2):  # once more restores what cancellation took
                _remove(q, r, j)
            rounding = _LOST * whole
            lined_up = _sizes(q[:, j]) <= rounding
            if lined_up.any():
                q[lined_up, j] = _any(q[lined_up], j)
            r[:, j, j] = np.where(lined_up, rounding, _sizes(q[:, j]))
            q[:, j] /= _sizes(q[:, j])[:, None]
    return q, r


#: A vector with less than this share of its length left is rounding.
_LOST = 1e-15


def _sizes(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("ps,ps->p", vectors, vectors)))


def _remove(q: FloatArray, r: FloatArray, j: int) -> None:
    """Take from vector j what lies along the rows before it."""
    for i in range(j):
        along = np.einsum("ps,ps->p", q[:, i], q[:, j])
        r[:, i, j] += along
        q[:, j] -= along[:, None] * q[:, i]


def _any(q: FloatArray, j: int) -> FloatArray:
    """Vectors orthogonal to the first j rows: the coordinate that these have least of."""
    least = np.argmin(np.einsum("pis,pis->ps", q[:, :j], q[:, :j]), axis=1)
    q = q.copy()
    q[:, j] = np.eye(q.shape[2])[least]
    for _ in range(2):
        _remove(q, np.zeros((q.shape[0], j + 1, j + 1)), j)
    return np.asarray(q[:, j])
