"""Newton's method onto curves, for many points at once."""

from __future__ import annotations

import numpy as np

from remanent._typing import BoolArray, FloatArray
from remanent.analysis.orbits.curves import CurveEquations, CurvePoints, EquationValues

#: Newton steps at most.
_MAX_NEWTON_STEPS = 6
#: Share of the tolerance that Newton's method aims at.
_AIM_SHARE_OF_TOLERANCE = 0.1
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
    reach: FloatArray | float = np.inf,
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
        Of the residual.  Newton's method aims at a tenth of it where the error of the equations
        allows that; no point beyond it counts as reached.

    reach : array (point,) or float
        Points that would go farther from their guess, in scaled unknowns, are given up.

    Returns
    -------
    points : CurvePoints
    reached : array (point,) of bool
        Whether the residual meets the tolerance.
    """
    z, equation_values = guess.copy(), equations(guess)
    lost = np.zeros(len(z), dtype=np.bool_)
    for _ in range(_MAX_NEWTON_STEPS - 1):
        residual, finite = _residuals(equation_values)
        # A residual cannot be expected to fall below the error of the equations.
        aim = np.clip(
            _RESIDUAL_FLOOR_OVER_ERROR * equation_values.value_error,
            _AIM_SHARE_OF_TOLERANCE * tolerance,
            tolerance,
        )
        # Points that have converged are left alone: each further evaluation costs a period map.
        moving = np.flatnonzero(finite & ~lost & (residual > aim))
        if not moving.size:
            break
        matrix = np.concatenate(
            [equation_values.derivative[moving] * scale, direction[moving, None, :]], axis=1
        )
        offset = np.einsum("ij,ij->i", direction[moving], (guess - z)[moving] / scale)
        right = np.concatenate([-equation_values.value[moving], offset[:, None]], axis=1)
        moved = z[moving] + _solve_linear_systems(matrix, right) * scale
        distance = np.linalg.norm((moved - guess[moving]) / scale, axis=1)
        near = distance <= np.broadcast_to(reach, len(z))[moving]
        lost[moving[~near]] = True
        moving = moving[near]
        if not moving.size:
            break
        z[moving] = moved[near]
        equation_values = equation_values.with_replaced_rows(moving, equations(z[moving]))
    residual, finite = _residuals(equation_values)
    derivative = np.where(finite[:, None, None], equation_values.derivative, 0.0)
    tangent = unit_tangents(derivative, direction, scale)
    return CurvePoints(
        z, tangent, residual, equation_values.value_error, equation_values.extra_arrays
    ), (residual <= tolerance) & finite


def _residuals(equation_values: EquationValues) -> tuple[FloatArray, BoolArray]:
    """Residuals, and where all is finite."""
    with np.errstate(all="ignore"):
        residual = np.abs(equation_values.value).max(axis=1)
    finite = np.isfinite(equation_values.derivative).all(axis=(1, 2)) & np.isfinite(residual)
    return np.asarray(residual), np.asarray(finite)


def _solve_linear_systems(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Solutions of linear equations, of least squares if one matrix of them is singular."""
    with np.errstate(all="ignore"):
        try:
            return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
        except np.linalg.LinAlgError:
            return np.asarray((np.linalg.pinv(matrix) @ right[..., None])[..., 0])
