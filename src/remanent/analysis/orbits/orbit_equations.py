"""The equations of periodic orbits, of folds and of period doublings, as curves."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.orbits.curves import CurveEquations, EquationValues
from remanent.analysis.orbits.maps import Map

#: Half the distance over which a test function is differenced, in scaled unknowns, at most.
_SCALED_DIFFERENCE_HALF_STEP = 1e-6
#: Where entries of J are larger than this that distance is shorter in proportion: J varies over
#: distances that shrink as it grows.
_LARGE_JACOBIAN_ENTRY = 10.0
#: What vanishes at each kind is det(J + sign 1).
IDENTITY_SIGN_OF_KIND: Final[Mapping[str, float]] = MappingProxyType(
    {"fold": -1.0, "period doubling": 1.0}
)


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
        ``extra_arrays["derivative"]`` that of the equations, ``extra_arrays["value"]`` their
        value.
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
        extra = {"jacobian": image.jacobian, "derivative": derivative, "value": value}
        return EquationValues(value, derivative, image.error, extra)

    return equations


def build_bifurcation_equations(
    map_: Map, iterate: int, kind: str, scale: FloatArray, *, by_determinant: bool = False
) -> CurveEquations:
    """Folds or period doublings as curves: unknowns (state, two parameters).

    Equations: map^q(x) - x = 0, and the smallest singular value of J - 1 at a fold, of J + 1 at
    a doubling, with the sign of the determinant, is zero.  It vanishes where the determinant
    does, and an error of J changes it by no more than itself, however large the other singular
    values are.

    Parameters
    ----------
    map_ : Map
    iterate : int
        The period q of the orbits.
    kind : str
        ``fold`` or ``period doubling``.
    scale : array (state + 2,)
        Units of the unknowns.
    by_determinant : bool
        Let the determinant vanish in place of the singular value.  It is smooth also where two
        singular values meet, so that Newton's method finds its way from farther off, but less
        accurate where multipliers are large.

    Returns
    -------
    callable
        Its ``extra_arrays`` hold ``jacobian``, that of the iterate; ``derivative`` and ``value``,
        those of the equations; and ``equation_error``, the error of each equation's value.
    """
    sign = IDENTITY_SIGN_OF_KIND[kind]

    def equations(unknown: FloatArray) -> EquationValues:
        count, size = unknown.shape
        d = size - 2
        image = map_(unknown[:, :d], unknown[:, d:], iterate)
        jacobian = image.jacobian
        half_step = _difference_half_steps(jacobian)
        places = places_around(unknown, scale, half_step).reshape(count, -1, size)[:, 1:]
        places = places.reshape(-1, size)
        around = map_(places[:, :d], places[:, d:], iterate)
        jacobians = np.concatenate(
            [jacobian[:, None], around.jacobian.reshape(count, -1, d, d)], axis=1
        )
        test, slope, entry_weight = smallest_singular_values(jacobians, sign, scale, half_step)
        if by_determinant:
            with np.errstate(all="ignore"):  # points that are not followed have no numbers
                determinants = np.linalg.det(jacobians + sign * np.eye(d))
                slope = central_differences(determinants, scale, half_step)
            test = determinants[:, 0]
        orbit = np.concatenate([jacobian - np.eye(d), image.parameter_jacobian], axis=2)
        value = np.column_stack([image.state - unknown[:, :d], test])
        derivative = np.concatenate([orbit, slope[:, None, :]], axis=1)
        error = image.error
        test_error = entry_weight * error * np.abs(jacobian).max(axis=(1, 2))
        errors = np.column_stack([np.tile(error[:, None], d), test_error])
        extra = {
            "jacobian": jacobian, "derivative": derivative, "value": value,
            "equation_error": errors,
        }  # fmt: skip
        return EquationValues(value, derivative, errors.max(axis=1), extra)

    return equations


def _difference_half_steps(jacobian: FloatArray) -> FloatArray:
    """Half the distance over which each point's test function is differenced, array (point,)."""
    largest = np.abs(jacobian).max(axis=(1, 2))
    shorter = np.maximum(np.where(np.isfinite(largest), largest, 0.0) / _LARGE_JACOBIAN_ENTRY, 1.0)
    return np.asarray(_SCALED_DIFFERENCE_HALF_STEP / shorter)


def places_around(
    unknown: FloatArray, scale: FloatArray, half_step: FloatArray | None = None
) -> FloatArray:
    """Each point, then a step forwards in each unknown, then one backwards.

    Parameters
    ----------
    unknown : array (point, unknown)
    scale : array (unknown,)
        Units of the unknowns.
    half_step : array (point,), optional
        Length of the steps in scaled unknowns.

    Returns
    -------
    array (point * (2 unknown + 1), unknown)
    """
    size = scale.size
    steps = np.concatenate([np.zeros((1, size)), np.diag(scale), -np.diag(scale)])
    lengths = _SCALED_DIFFERENCE_HALF_STEP if half_step is None else half_step[:, None, None]
    places = unknown[:, None, :] + lengths * steps
    return np.asarray(places.reshape(-1, size))


def central_differences(
    values: FloatArray, scale: FloatArray, half_step: FloatArray | None = None
) -> FloatArray:
    """Derivatives by each unknown of what was evaluated at :func:`places_around` points.

    Parameters
    ----------
    values : array (point, 2 unknown + 1, ...)
    scale : array (unknown,)
    half_step : array (point,), optional
        That they were evaluated with.

    Returns
    -------
    array (point, unknown, ...)
    """
    size = scale.size
    lengths = np.full(len(values), _SCALED_DIFFERENCE_HALF_STEP) if half_step is None else half_step
    width = (2.0 * lengths[:, None] * scale).reshape(-1, size, *[1] * (values.ndim - 2))
    return np.asarray((values[:, 1 : 1 + size] - values[:, 1 + size :]) / width)


def smallest_singular_values(
    jacobians: FloatArray, sign: float, scale: FloatArray, half_step: FloatArray | None = None
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Smallest singular values of J + sign 1, with the signs of the determinants.

    Parameters
    ----------
    jacobians : array (point, 2 unknown + 1, state, state)
        At :func:`places_around` points.
    sign : float
    scale : array (unknown,)
    half_step : array (point,), optional
        That they were evaluated with.

    Returns
    -------
    value : array (point,)
    slope : array (point, unknown)
        The derivative is u' dJ v with the singular vectors u, v.
    entry_weight : array (point,)
        By how much the value changes at most if every entry of J changes by one.
    """
    matrix = jacobians[:, 0] + sign * np.eye(jacobians.shape[-1])
    finite = np.asarray(np.isfinite(matrix).all(axis=(1, 2)))
    left, values, right = np.linalg.svd(np.where(finite[:, None, None], matrix, 0.0))
    with np.errstate(invalid="ignore"):
        side = np.where(np.linalg.det(matrix) < 0.0, -1.0, 1.0)
    u, v = left[:, :, -1] * side[:, None], right[:, -1, :]
    slope = np.einsum("pi,pkij,pj->pk", u, central_differences(jacobians, scale, half_step), v)
    weight = np.abs(u).sum(axis=1) * np.abs(v).sum(axis=1)
    return np.where(finite, side * values[:, -1], np.nan), slope, weight
