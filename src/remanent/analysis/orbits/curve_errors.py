"""How far points of curves are from the curves, and Jacobians from those of the orbits.

A point misses its curve by the residual and by the error of the equations, carried through the
inverse of their derivatives bordered by the tangent, which is regular at folds.  What is told is
the error of the other unknowns where one of them, the parameter, is taken as it is.  Then the
distance is measured along that parameter, and grows towards a fold until the bend of the curve
limits it: with a tangent whose part along the parameter is t, and which turns by k in a unit of
length, a shift d of the parameter is one s along the curve with t s + k s^2/2 = d.
"""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.orbits.curves import CurveEquations, CurvePoints

#: Second derivatives are taken at every so many points, and hold between these.
_POINTS_BETWEEN_SECOND_DERIVATIVES = 12
#: Distance over which Jacobians are differenced.
_JACOBIAN_DIFFERENCE_STEP = 1e-4
#: Factor by which second derivatives may be larger between the points where they are known.
_SECOND_DERIVATIVE_MARGIN = 1.2
#: Rounding of a number, relative to it.
_ROUNDING = 8.0 * float(np.finfo(float).eps)


def errors_at_fixed_unknown(
    points: CurvePoints, value_error: FloatArray, scale: FloatArray, fixed: int
) -> FloatArray:
    """Errors of all unknowns where one of them is exact, array (point, n + 1).

    Parameters
    ----------
    points : CurvePoints
        In order along a curve, with ``value`` and ``derivative`` in their ``extra_arrays``.
    value_error : array (point, n)
        Of the value of each equation.
    scale : array (n + 1,)
        Units of the unknowns.
    fixed : int
        Number of that unknown; its own error is 0.
    """
    if not len(points):
        return np.empty(points.unknown.shape)
    along = points.tangent[:, fixed]
    with np.errstate(all="ignore"):
        bordered = np.concatenate(
            [points.extra_arrays["derivative"] * scale, points.tangent[:, None]], axis=1
        )
        inverse = _inverses(bordered)[:, :, :-1]
        value = points.extra_arrays["value"]
        # Newton's step, and once more its size at most for what is beyond first order.
        across = np.abs(np.einsum("pij,pj->pi", inverse, value))
        across += np.einsum("pij,pj->pi", np.abs(inverse), np.abs(value) + value_error)
        shift, bend = across[:, fixed], _largest_bends(points, scale, fixed)
        # t s - k s^2/2 = d is the worst case; without a solution the curve turns before d.
        root = np.sqrt(np.maximum(along**2 - 2.0 * bend * shift, 0.0))
        move = 2.0 * shift / (np.abs(along) + root)
        error = across + np.abs(points.tangent) * move[:, None]
    error = error * scale + _ROUNDING * np.abs(points.unknown)
    error[:, fixed] = 0.0
    return np.asarray(error)


def _largest_bends(points: CurvePoints, scale: FloatArray, fixed: int) -> FloatArray:
    """How fast the tangent's part along an unknown changes near each point, array (point,)."""
    count = len(points)
    if count < 2:
        return np.zeros(count)
    gaps = np.linalg.norm(np.diff(points.unknown / scale, axis=0), axis=1)
    bend = np.abs(np.diff(points.tangent[:, fixed])) / np.maximum(gaps, 1e-300)
    padded = np.concatenate([bend[:1], bend, bend[-1:]])
    return np.asarray(np.maximum(padded[:-1], padded[1:]))


def _inverses(matrices: FloatArray) -> FloatArray:
    """Inverses; infinite where there is none."""
    try:
        return np.asarray(np.linalg.inv(matrices))
    except np.linalg.LinAlgError:
        regular = np.asarray(np.isfinite(matrices).all(axis=(1, 2)))
        regular[regular] = np.linalg.matrix_rank(matrices[regular]) == matrices.shape[-1]
        inverse = np.full(matrices.shape, np.inf)
        inverse[regular] = np.linalg.inv(matrices[regular])
        return inverse


def jacobian_errors(
    equations: CurveEquations,
    points: CurvePoints,
    computed_error: FloatArray,
    state_error: FloatArray,
) -> FloatArray:
    """Errors of the entries of Jacobians, as those of the orbits, array (point, state, state).

    The error of what was computed, and the second derivatives times the error of the state.  Second
    derivatives vary smoothly along a curve, so that they are taken at some of its points.

    Parameters
    ----------
    equations : callable
        Of the orbits.
    points : CurvePoints
        In order along a curve.
    computed_error : array (point, state, state)
        Of the entries as those at the points.
    state_error : array (point, state)
    """
    jacobian = points.extra_arrays["jacobian"]
    count, d = state_error.shape
    largest = np.abs(jacobian).max(axis=(1, 2), keepdims=True)
    if not count:
        return computed_error
    sampled = np.unique(
        np.append(np.arange(0, count, _POINTS_BETWEEN_SECOND_DERIVATIVES), count - 1)
    )
    # No shorter than the error of the state, over which the derivatives are to hold.
    step = np.clip(
        np.where(np.isfinite(state_error[sampled]), state_error[sampled], 0.0),
        _JACOBIAN_DIFFERENCE_STEP, 1e-2,
    )  # fmt: skip
    places = np.repeat(points.unknown[sampled][:, None], d, axis=1)
    places[:, np.arange(d), np.arange(d)] += step
    moved = equations(places.reshape(-1, places.shape[-1])).extra_arrays["jacobian"]
    moved = moved.reshape(sampled.size, d, d, d)
    slopes = np.abs(moved - jacobian[sampled][:, None]) / step[:, :, None, None]
    slopes /= np.maximum(largest[sampled][:, None], 1.0)  # they vary less than the Jacobian
    after = np.minimum(np.searchsorted(sampled, np.arange(count)), sampled.size - 1)
    before = np.maximum(after - 1, 0)
    slope = _SECOND_DERIVATIVE_MARGIN * np.fmax(slopes[before], slopes[after])
    slope = slope * np.maximum(largest, 1.0)[:, None]
    with np.errstate(invalid="ignore"):
        return np.asarray(computed_error + np.einsum("pkij,pk->pij", slope, state_error))
