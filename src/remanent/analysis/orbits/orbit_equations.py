"""The equations of periodic orbits, of folds and of period doublings, as curves."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.orbits.curves import CurveEquations, EquationValues
from remanent.analysis.orbits.maps import Map

#: Half the distance over which a test function is differenced, in scaled unknowns.
_SCALED_DIFFERENCE_HALF_STEP = 1e-5
#: The test function of each kind is det(J + sign 1).
_IDENTITY_SIGN_OF_KIND = MappingProxyType({"fold": -1.0, "period doubling": 1.0})


def build_orbit_equations(map_: Map, iterate: int) -> CurveEquations:
    """Periodic orbits as curves: unknowns (state, parameters), equations map^q(x) - x = 0.

    The last parameter varies along a curve; those before it, if there are any, stay as they
    are where the curve begins, so that curves of different systems are followed together.

    Parameters
    ----------
    map_ : Map
    iterate : int
        The period q of the orbits.

    Returns
    -------
    callable
        Its ``extra_arrays["jacobian"]`` is that of the iterate,
        ``extra_arrays["derivative"]`` that of the equations.
    """

    def equations(unknown: FloatArray) -> EquationValues:
        d = map_.dimension
        x, p = unknown[:, :d], unknown[:, d:]
        image = map_(x, p, iterate)
        derivative = np.concatenate([image.jacobian - np.eye(d), image.parameter_jacobian], axis=2)
        value, held = image.state - x, p.shape[1] - 1
        if held:
            # One equation p_k - p_k(start) = 0 for each parameter that stays: its value is zero
            # at every guess, since the prediction does not change the parameter.
            rows = np.zeros((len(x), held, d + held + 1))
            rows[:, np.arange(held), d + np.arange(held)] = 1.0
            derivative = np.concatenate([derivative, rows], axis=1)
            value = np.concatenate([value, np.zeros((len(x), held))], axis=1)
        extra = {"jacobian": image.jacobian, "derivative": derivative}
        return EquationValues(value, derivative, image.error, extra)

    return equations


def build_bifurcation_equations(
    map_: Map, iterate: int, kind: str, scale: FloatArray
) -> CurveEquations:
    """Folds or period doublings as curves: unknowns (state, two parameters).

    Equations: map^q(x) - x = 0 and det(J - 1) = 0 at a fold, det(J + 1) = 0 at a doubling.
    The derivatives of the determinant are differences; they decide how fast Newton's method
    converges, not where.

    Parameters
    ----------
    map_ : Map
    iterate : int
        The period q of the orbits.
    kind : str
        ``fold`` or ``period doubling``.
    scale : array (state + 2,)
        Units of the unknowns.
    """
    sign = _IDENTITY_SIGN_OF_KIND[kind]

    def determinant(jacobian: FloatArray) -> FloatArray:
        return np.asarray(np.linalg.det(jacobian + sign * np.eye(jacobian.shape[-1])))

    def equations(unknown: FloatArray) -> EquationValues:
        count, size = unknown.shape
        d = size - 2
        # The point itself, then a step forwards in each unknown, then one backwards: one call.
        steps = np.concatenate([np.zeros((1, size)), np.diag(scale), -np.diag(scale)])
        places = (unknown[:, None, :] + _SCALED_DIFFERENCE_HALF_STEP * steps).reshape(-1, size)
        image = map_(places[:, :d], places[:, d:], iterate)
        test = determinant(image.jacobian).reshape(count, -1)
        here = slice(None, None, 2 * size + 1)
        slope = (test[:, 1 : 1 + size] - test[:, 1 + size :]) / (
            2.0 * _SCALED_DIFFERENCE_HALF_STEP * scale
        )
        jacobian = image.jacobian[here]
        orbit = np.concatenate([jacobian - np.eye(d), image.parameter_jacobian[here]], axis=2)
        value = np.column_stack([image.state[here] - unknown[:, :d], test[:, 0]])
        derivative = np.concatenate([orbit, slope[:, None, :]], axis=1)
        # An error of the entries of J changes a determinant of order d by up to |J|^d times it.
        magnification = np.maximum(1.0, np.abs(jacobian).max(axis=(1, 2))) ** d
        error = image.error[here] * magnification
        return EquationValues(value, derivative, error, {"jacobian": jacobian})

    return equations
