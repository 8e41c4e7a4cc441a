"""Floquet multipliers of periodic orbits, and what they say of stability."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from remanent._typing import ComplexArray, FloatArray, IntArray

#: Distance of complex multipliers of a conservative map from the unit circle, at most.
_MAX_UNIT_CIRCLE_DISTANCE = 1e-6
#: Smallest singular value of the eigenvectors below which two multipliers have met.
_MIN_EIGENVECTOR_SINGULAR_VALUE = 1e-7
#: Rounding of the eigenvalues of a matrix, relative to its largest entry.
_ROUNDING_OF_EIGENVALUES = 2.0 * float(np.finfo(float).eps)
#: Below the least normal number products lose their digits, and rounding is no share of them.
_SMALLEST_ERROR = float(np.finfo(float).tiny)
#: Of two conjugate multipliers, the one with the positive imaginary part comes first.
_CONJUGATE_SORTING_WEIGHT = 1e-9


class Stability(IntEnum):
    """What the multipliers say of an orbit."""

    UNDECIDED = 0
    ELLIPTIC = 1
    SADDLE = 2
    STABLE = 3
    UNSTABLE = 4

    @property
    def meaning(self) -> str:
        """The word that results show: ``saddle``."""
        return self.name.lower()


def floquet_multipliers(jacobian: FloatArray, error: FloatArray) -> tuple[ComplexArray, FloatArray]:
    """Floquet multipliers, largest first, and bounds of their errors.

    Parameters
    ----------
    jacobian : array (orbit, state, state)
        Of the iterate that closes the orbit.
    error : array (orbit,) or (orbit, state, state)
        Of the Jacobian: relative to its largest entry, or of each entry.

    Returns
    -------
    values : array (orbit, multiplier) of complex
    errors : array (orbit, multiplier)
        Twice |l| E |r|/|l r|, where l and r are the left and right eigenvectors and E is the
        error of each entry [Horn and Johnson, section 6.3]: the change of first order, doubled for
        what is beyond.  It grows without bound as two eigenvalues meet, while those of a matrix
        A of order d move at most by 4 (2 |A| + |E|)^(1 - 1/d) |E|^(1/d) [Bhatia, Elsner and
        Krause]; of order two, by the change of half the trace and the root of that of the
        discriminant.  The smallest of these bounds is taken.
    """
    values, right = np.linalg.eig(jacobian)
    values, right = values.astype(complex), right.astype(complex)
    size = np.abs(jacobian).max(axis=(1, 2))
    relative = np.ndim(error) == 1
    change = (error * size)[:, None, None] if relative else np.asarray(error)
    change = change + (_ROUNDING_OF_EIGENVALUES * size)[:, None, None] + np.zeros_like(jacobian)
    with np.errstate(all="ignore"):
        left = np.linalg.pinv(right)
        first_order = np.einsum("kij,kjl,kli->ki", np.abs(left), change, np.abs(right))
        met = np.linalg.svd(right, compute_uv=False)[:, -1] < _MIN_EIGENVECTOR_SINGULAR_VALUE
        first_order[met] = np.inf
        errors = np.fmin(2.0 * first_order, _change_of_any_eigenvalue(jacobian, change)[:, None])
    errors = np.maximum(errors, _SMALLEST_ERROR)
    rank = -np.abs(values) - _CONJUGATE_SORTING_WEIGHT * values.imag
    order = np.argsort(rank, axis=1, kind="stable")
    return np.take_along_axis(values, order, 1), np.take_along_axis(errors, order, 1)


def _change_of_any_eigenvalue(matrix: FloatArray, change: FloatArray) -> FloatArray:
    """How far eigenvalues can move when entries change by so much, array (orbit,)."""
    d = matrix.shape[-1]
    if d == 2:
        half = 0.5 * (matrix[:, 0, 0] - matrix[:, 1, 1])
        half_change = 0.5 * (change[:, 0, 0] + change[:, 1, 1])
        product_change = (
            np.abs(matrix[:, 0, 1]) * change[:, 1, 0]
            + np.abs(matrix[:, 1, 0]) * change[:, 0, 1]
            + change[:, 0, 1] * change[:, 1, 0]
        )
        discriminant = half**2 + matrix[:, 0, 1] * matrix[:, 1, 0]
        moved = (2.0 * np.abs(half) + half_change) * half_change + product_change
        root = np.fmin(np.sqrt(moved), moved / np.sqrt(np.abs(discriminant)))
        return np.asarray(half_change + root)
    size, moved = (np.linalg.norm(part, axis=(1, 2)) for part in (matrix, change))
    return np.asarray(4.0 * (2.0 * size + moved) ** (1.0 - 1.0 / d) * moved ** (1.0 / d))


def orbit_stability(values: ComplexArray, errors: FloatArray, *, conservative: bool) -> IntArray:
    """What multipliers, with their errors, say of each orbit.

    Parameters
    ----------
    values : array (orbit, multiplier) of complex
    errors : array (orbit, multiplier)
    conservative : bool
        The map preserves area: multipliers come in pairs whose product is 1.

    Returns
    -------
    array (orbit,) of int
        Values of :class:`Stability`; undecided where an error could change the answer.
    """
    size = np.abs(values)
    outside, inside = size > 1.0 + errors, size < 1.0 - errors
    if conservative:
        # Multipliers off the unit circle are real, but for quartets of four or more.
        elliptic = (np.abs(values.imag) > errors).all(axis=1) & (
            np.abs(size - 1.0) <= np.maximum(errors, _MAX_UNIT_CIRCLE_DISTANCE)
        ).all(axis=1)
        saddle = outside.any(axis=1) & inside.any(axis=1)
        kinds = [(elliptic, Stability.ELLIPTIC), (saddle, Stability.SADDLE)]
    else:
        kinds = [
            (inside.all(axis=1), Stability.STABLE),
            (outside.any(axis=1) & inside.any(axis=1), Stability.SADDLE),
            (outside.all(axis=1), Stability.UNSTABLE),
        ]
    result = np.full(values.shape[0], int(Stability.UNDECIDED))
    for mask, kind in kinds:
        result[mask] = int(kind)
    return result
