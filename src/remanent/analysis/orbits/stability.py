"""Floquet multipliers of periodic orbits, and what they say of stability."""

from __future__ import annotations

from enum import IntEnum

import numpy as np

from remanent._typing import ComplexArray, FloatArray, IntArray

#: Distance of complex multipliers of a conservative map from the unit circle, at most.
_MAX_UNIT_CIRCLE_DISTANCE = 1e-6
#: Smallest singular value of the eigenvectors below which two multipliers have met.
_MIN_EIGENVECTOR_SINGULAR_VALUE = 1e-7
#: Multipliers are told from 1 in size only beyond this many times their error.
_MIN_MODULUS_DEPARTURE_OVER_ERROR = 4.0
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
    """Floquet multipliers, largest first, and an estimate of their error.

    Parameters
    ----------
    jacobian : array (orbit, state, state)
        Of the iterate that closes the orbit.
    error : array (orbit,)
        Of the Jacobian, relative to its largest entry.

    Returns
    -------
    values : array (orbit, multiplier) of complex
    errors : array (orbit, multiplier)
        The condition number of each eigenvalue times the error of the Jacobian.  That number
        grows without bound as two eigenvalues meet, while the eigenvalues of a matrix of order
        d move by the d-th root of its change at most: so no error exceeds that root.
    """
    values, right = np.linalg.eig(jacobian)
    values, right = values.astype(complex), right.astype(complex)
    size = np.abs(jacobian).max(axis=(1, 2))
    change = (error + 4.0 * np.finfo(float).eps) * size
    d = jacobian.shape[1]
    with np.errstate(all="ignore"):
        left = np.linalg.pinv(right)
        condition = np.linalg.norm(left, axis=2) * np.linalg.norm(right, axis=1)
        met = np.linalg.svd(right, compute_uv=False)[:, -1] < _MIN_EIGENVECTOR_SINGULAR_VALUE
        condition[met] = np.inf
        root = np.maximum(size, 1.0) ** (1.0 - 1.0 / d) * change ** (1.0 / d)
        errors = np.fmin(condition * change[:, None], root[:, None])
    rank = -np.abs(values) - _CONJUGATE_SORTING_WEIGHT * values.imag
    order = np.argsort(rank, axis=1, kind="stable")
    return np.take_along_axis(values, order, 1), np.take_along_axis(errors, order, 1)


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
    size, slack = np.abs(values), _MIN_MODULUS_DEPARTURE_OVER_ERROR * errors
    outside, inside = size > 1.0 + slack, size < 1.0 - slack
    if conservative:
        # Multipliers off the unit circle are real, but for quartets of four or more.
        elliptic = (np.abs(values.imag) > slack).all(axis=1) & (
            np.abs(size - 1.0) <= np.maximum(slack, _MAX_UNIT_CIRCLE_DISTANCE)
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
