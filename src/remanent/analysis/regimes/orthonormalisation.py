"""Gram-Schmidt for many sets of vectors at once, in the order of their growth."""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray

#: A vector with less than this share of its length left after the projections is rounding.
_MIN_REMAINDER_SHARE = 1e-15


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
    # A power of two out of each vector: squares of tangents that have shrunk or grown much
    # would not fit into a double.
    with np.errstate(invalid="ignore"):
        _, exponent = np.frexp(np.abs(vectors).max(axis=2, initial=0.0))
    q = np.ldexp(vectors, -exponent[:, :, None])
    count = q.shape[1]
    r = np.zeros((q.shape[0], count, count))
    with np.errstate(all="ignore"):
        for j in range(count):
            length = _lengths(q[:, j])
            for _ in range(2):  # once more restores what cancellation took
                _project_out_earlier_rows(q, r, j)
            rounding = _MIN_REMAINDER_SHARE * length
            lined_up = _lengths(q[:, j]) <= rounding
            if lined_up.any():
                q[lined_up, j] = _orthogonal_vectors(q[lined_up], j)
            r[:, j, j] = np.where(lined_up, rounding, _lengths(q[:, j]))
            q[:, j] /= _lengths(q[:, j])[:, None]
    return q, np.ldexp(r, exponent[:, None, :])


def _lengths(vectors: FloatArray) -> FloatArray:
    return np.asarray(np.sqrt(np.einsum("ps,ps->p", vectors, vectors)))


def _project_out_earlier_rows(q: FloatArray, r: FloatArray, j: int) -> None:
    """Take from vector j what lies along the rows before it."""
    for i in range(j):
        projection = np.einsum("ps,ps->p", q[:, i], q[:, j])
        r[:, i, j] += projection
        q[:, j] -= projection[:, None] * q[:, i]


def _orthogonal_vectors(q: FloatArray, j: int) -> FloatArray:
    """Vectors orthogonal to the first j rows: the coordinate that these have least of."""
    least = np.argmin(np.einsum("pis,pis->ps", q[:, :j], q[:, :j]), axis=1)
    q = q.copy()
    q[:, j] = np.eye(q.shape[2])[least]
    for _ in range(2):
        _project_out_earlier_rows(q, np.zeros((q.shape[0], j + 1, j + 1)), j)
    return np.asarray(q[:, j])
