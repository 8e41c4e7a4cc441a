"""Newton's method onto curves, for many points at once."""

from __future__ import annotations

import numpy as np

from remanent._typing import BoolArray, FloatArray
from remanent.analysis.orbits.curves import CurveEquations, CurvePoints, EquationValues

#: Newton steps at most.
_MAX_NEWTON_STEPS = 6
#: A residual cannot be expected to fall below this many times the error of the equations.
_RESIDUAL_FLOOR_OVER_ERROR = 4.0


def unit_tangents(derivative: FloatArray, like: FloatArray, scale: FloatArray) -> FloatArray:
    """Unit null vectors of the scaled derivatives.

    Parameters
    ----------
    derivative : array (point, n, n + 1)
    like : array (point, n + 1)
        Each tangent points to the same side as this vector.
    scale : array (n + 1,)
        Units of the unknowns.

    Returns
    -------
    array (point, n + 1)
        Of scaled unknowns.
    """
    _, _, right = np.linalg.svd(derivative * scale)
    t = right[:, -1, :]
    side = np.sign(np.einsum("ij,ij->i", t, like))
    return np.asarray(t * np.where(side == 0.0, 1.0, side)[:, None])


def correct_points(
    equations: CurveEquations,
    guess: FloatArray,
    direction: FloatArray,
    *,
    scale: FloatArray,
    tolerance: float,
) -> tuple[CurvePoints, BoolArray]:
    """Points of curves nearest to guesses, in planes across given directions.

    Parameters
    ----------
    equations : callable
        Of unknowns (point, n + 1).
    guess, direction : array (point, n + 1)
        The direction is of scaled unknowns.
    scale : array (n + 1,)
        Units of the unknowns.
    tolerance : float
        Of the residual, where the error of the equations allows it.

    Returns
    -------
    points : CurvePoints
    reached : array (point,) of bool
        Whether Newton's method converged.
    """
    z, equation_values = guess.copy(), equations(guess)
    for _ in range(_MAX_NEWTON_STEPS - 1):
        residual, reached, finite = _residuals_and_convergence(equation_values, tolerance)
        # Points that have converged are left alone: each further evaluation costs a period map.
        moving = np.flatnonzero(finite & ~reached)
        if not moving.size:
            break
        matrix = np.concatenate(
            [equation_values.derivative[moving] * scale, direction[moving, None, :]], axis=1
        )
        offset = np.einsum("ij,ij->i", direction[moving], (guess - z)[moving] / scale)
        right = np.concatenate([-equation_values.value[moving], offset[:, None]], axis=1)
        z[moving] += _solve_linear_systems(matrix, right) * scale
        equation_values = equation_values.with_replaced_rows(moving, equations(z[moving]))
    residual, reached, finite = _residuals_and_convergence(equation_values, tolerance)
    derivative = np.where(finite[:, None, None], equation_values.derivative, 0.0)
    tangent = unit_tangents(derivative, direction, scale)
    return CurvePoints(
        z, tangent, residual, equation_values.value_error, equation_values.extra_arrays
    ), reached & finite


def _residuals_and_convergence(
    equation_values: EquationValues, tolerance: float
) -> tuple[FloatArray, BoolArray, BoolArray]:
    """Residuals, where they are small enough, and where all is finite."""
    with np.errstate(all="ignore"):
        residual = np.abs(equation_values.value).max(axis=1)
    finite = np.isfinite(equation_values.derivative).all(axis=(1, 2)) & np.isfinite(residual)
    return (
        residual,
        residual <= np.maximum(tolerance, _RESIDUAL_FLOOR_OVER_ERROR * equation_values.value_error),
        finite,
    )


def _solve_linear_systems(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Solutions of linear equations, of least squares if one matrix of them is singular."""
    with np.errstate(all="ignore"):
        try:
            return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
        except np.linalg.LinAlgError:
            return np.asarray((np.linalg.pinv(matrix) @ right[..., None])[..., 0])
