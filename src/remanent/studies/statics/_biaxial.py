"""Equilibria of two in-plane stretches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.ndimage import maximum_filter

from remanent._field import Role
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.maps import MapImage
from remanent.analysis.orbits.periodic_orbits import (
    distinct_orbits_of_least_period,
    newton_fixed_points,
)
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.statics._static_ensemble import StaticEnsemble, bisect_last_inside
from remanent.studies.statics._static_errors import largest

#: Equilibria of two coordinates are sought up to this stretch and down to its inverse.
_LARGEST_SOUGHT_STRETCH = 1000.0
#: Directions from rest in which they are sought.
_DIRECTION_COUNT = 96
#: Distances from rest at which they are sought in each direction.
_DISTANCE_COUNT = 96
#: Largest acceleration, relative to the loads', of what counts as an equilibrium.
_MAX_RELATIVE_ACCELERATION = 1e-12
#: Relative change of a stretch over which a derivative of the accelerations is a difference.
_RELATIVE_STEP = 1e-6
#: Units of the last digit by which rounding may move derivatives of the accelerations.
_MATRIX_ROUNDINGS = 32.0


def biaxial_equilibria(ens: Ensemble) -> xr.Dataset:
    """All equilibria of two coordinates, labelled."""
    static = StaticEnsemble(ens)
    stretches = _equilibrium_stretches(static)
    count = stretches.shape[1]
    case = np.repeat(np.arange(ens.trajectory_count), count).reshape(ens.trajectory_count, count)
    pair = stretches[..., 0], stretches[..., 1]
    matrix = acceleration_derivatives_by_stretch(static, case, *pair)
    exists = np.isfinite(pair[0])
    values = np.linalg.eigvals(np.where(exists[..., None, None], -matrix, np.eye(2)))
    squared = np.sort(np.where(exists[..., None], values.real, np.nan), axis=-1)
    errors = biaxial_stretch_error(static, case, *pair)
    thickness = static.thickness(case, *pair)
    potential = static.potential_with_rounding(case, *pair)
    with np.errstate(invalid="ignore"):
        frequency = np.sqrt(np.where(squared > 0.0, squared, np.nan))
        stable = np.where((squared > 0.0).all(axis=-1), "stable", "unstable")
        frequency_error = _squared_frequency_error(static, case, stretches, errors) / frequency
        # The thickness stretch is 1/(lambda_1 lambda_2).
        relative_error = errors[..., 0] / pair[0] + errors[..., 1] / pair[1]
    columns = {
        "equilibrium_stretch": thickness,
        "equilibrium_stretch_error": thickness * (relative_error + 4.0 * np.finfo(float).eps),
        "stretch_1": pair[0],
        "stretch_1_error": errors[..., 0],
        "stretch_2": pair[1],
        "stretch_2_error": errors[..., 1],
        "equilibrium_potential": static.potential(case, *pair),
        "equilibrium_potential_error": np.where(exists, potential.value.bound, np.nan),
        "stability": np.where(exists, stable, ""),
    }
    variables: dict[str, PerTrajectoryArray] = {
        k: (("equilibrium",), v) for k, v in columns.items()
    }
    variables["natural_frequency"] = (("equilibrium", "mode"), frequency)
    variables["natural_frequency_error"] = (("equilibrium", "mode"), frequency_error)
    return to_dataset(
        ens,
        variables,
        coords={
            "equilibrium": (("equilibrium",), np.arange(count)),
            "mode": (("mode",), np.arange(2)),
        },
        tolerance=None,
    )


def _equilibrium_stretches(static: StaticEnsemble) -> FloatArray:
    """Stretches of all equilibria, (case, equilibrium, 2), NaN where there are fewer."""
    ens = static.ensemble
    roots = [
        np.empty((0, 2)) if ens.is_invalid[k] else equilibria_of_case(static, k)
        for k in range(ens.trajectory_count)
    ]
    stretches = np.full(
        (ens.trajectory_count, max((len(rows) for rows in roots), default=0), 2), np.nan
    )
    for k, rows in enumerate(roots):
        stretches[k, : len(rows)] = rows
    return stretches


def acceleration_derivatives_by_stretch(
    static: StaticEnsemble, case: IntArray, first: FloatArray, second: FloatArray
) -> FloatArray:
    """Derivatives of the accelerations by the stretches, by complex steps: (..., 2, 2)."""
    step = 1e-100
    columns = [
        np.stack(
            static.accelerations(case, first + 1j * step * e, second + 1j * step * (1 - e)), -1
        )
        for e in (1, 0)
    ]
    return np.asarray(np.stack(columns, axis=-1).imag / step)


def biaxial_stretch_error(
    static: StaticEnsemble, case: IntArray, first: FloatArray, second: FloatArray
) -> FloatArray:
    """Errors of both stretches of equilibria, (..., 2): the accelerations that may be left.

    They are carried to the stretches by the inverse of their derivatives, sign by sign.
    """
    field = static.ensemble.vector_field
    rates = static.evaluate_with_rounding(field.rates, case, first, second)
    left = np.stack(
        [
            np.broadcast_to(largest(rates[k].value), np.shape(first))
            for k in field.indices_of_roles(Role.RATE)
        ],
        axis=-1,
    )
    matrix = acceleration_derivatives_by_stretch(static, case, first, second)
    known = np.asarray(np.isfinite(matrix).all(axis=(-2, -1)))
    matrix = np.where(known[..., None, None], matrix, np.eye(2))
    error = np.abs(np.linalg.pinv(matrix)) @ left[..., None]
    return np.where(known[..., None], error[..., 0], np.nan)


def _squared_frequency_error(
    static: StaticEnsemble, case: IntArray, stretches: FloatArray, errors: FloatArray
) -> FloatArray:
    """Half the error of the squares of both natural frequencies, (..., mode), an estimate.

    The derivatives of the accelerations change with the stretches, by their errors, and are
    rounded; eigenvalues move as far as the matrix does, times the condition of its vectors.
    """
    matrix = acceleration_derivatives_by_stretch(static, case, *np.moveaxis(stretches, -1, 0))
    known = np.asarray(np.isfinite(matrix).all(axis=(-2, -1)))
    matrix = np.where(known[..., None, None], matrix, np.eye(2))
    change = _MATRIX_ROUNDINGS * np.finfo(float).eps * np.abs(matrix).max(axis=(-2, -1))
    for k in range(2):
        step = _RELATIVE_STEP * stretches * np.eye(2)[k]
        moved = acceleration_derivatives_by_stretch(
            static, case, *np.moveaxis(stretches + step, -1, 0)
        )
        with np.errstate(all="ignore"):
            slope = np.abs(moved - matrix).max(axis=(-2, -1)) / step[..., k]
        change = change + np.where(known, 2.0 * slope * errors[..., k], np.nan)
    condition = np.linalg.cond(np.linalg.eig(matrix)[1])
    return np.asarray(0.5 * (condition * change)[..., None] * np.ones(2))


def equilibria_of_case(static: StaticEnsemble, k: int) -> FloatArray:
    """Stretches of the equilibria of one actuator, (equilibrium, 2).

    An equilibrium is a fixed point of the map that adds the accelerations to the logarithms
    of the stretches, which keeps these positive.
    """
    map_ = _AccelerationMap(static, k)
    guesses = _equilibrium_guesses(static, k)
    bounds = np.log(2.0 * _LARGEST_SOUGHT_STRETCH) * np.array([[-1.0, 1.0]] * 2)
    none = np.empty((len(guesses), 0))
    orbits = newton_fixed_points(
        map_, guesses, none, iterate=1, tolerance=_MAX_RELATIVE_ACCELERATION, box=bounds
    )
    stretches = np.exp(distinct_orbits_of_least_period(map_, orbits, np.empty(0), iterate=1).state)
    return np.asarray(stretches[np.lexsort(stretches.T[::-1])])


def _equilibrium_guesses(static: StaticEnsemble, k: int) -> FloatArray:
    """Corners of the cells in which both accelerations change sign, and of those beside them."""
    nodes = _log_stretch_nodes(static, k)
    case = np.full(nodes.shape[:2], k)
    accelerations = np.stack(static.accelerations(case, *np.moveaxis(np.exp(nodes), -1, 0)))
    corners = [
        np.roll(accelerations, -i, axis=1)[..., j : j - 1 or None] for i in (0, 1) for j in (0, 1)
    ]
    low, high = np.fmin.reduce(corners), np.fmax.reduce(corners)
    changes = ((low <= 0.0) & (high >= 0.0)).all(axis=0)
    # Neighbours too: a curve of zeros may pass near the corner of a cell.
    near_zeros = maximum_filter(changes, 3, mode=("wrap", "nearest"))
    used = np.zeros(nodes.shape[:2], dtype=np.bool_)
    for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
        used[:, j : j - 1 or None] |= np.roll(near_zeros, i, axis=0)
    return np.asarray(nodes[used])


def _log_stretch_nodes(static: StaticEnsemble, k: int) -> FloatArray:
    """Logarithms of stretches, (direction, distance, 2), from rest up to the limits.

    Where the material has a limit, 1 less the share of the way to it falls with the fourth
    power: forces grow without bound there, so that equilibria lie close to it.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, _DIRECTION_COUNT, endpoint=False)
    towards = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    reach = np.log(_LARGEST_SOUGHT_STRETCH) / np.abs(towards).max(axis=1)

    def inside(distance: FloatArray, row: IntArray) -> BoolArray:
        stretches = np.exp(distance[..., None] * towards[row])
        return static.is_reachable(np.full(row.shape, k), stretches[..., 0], stretches[..., 1])

    limited = np.flatnonzero(~inside(reach, np.arange(angle.size)))
    share = np.linspace(0.0, 1.0, _DISTANCE_COUNT)
    shares = np.tile(share, (angle.size, 1))
    if limited.size:
        reach[limited] = bisect_last_inside(inside, 0.0 * reach[limited], reach[limited], limited)
        shares[limited] = 1.0 - (1.0 - share) ** 4
    return np.asarray((reach[:, None] * shares)[..., None] * towards[:, None])


@dataclass(frozen=True)
class _AccelerationMap:
    """Logarithms of stretches plus accelerations, as a map whose fixed points are equilibria."""

    static: StaticEnsemble
    case_index: int
    dimension: int = 2

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        case, stretches = np.full(len(states), self.case_index), np.exp(states)
        accelerations = np.stack(self.static.accelerations(case, *stretches.T), axis=1)
        matrix = acceleration_derivatives_by_stretch(self.static, case, *stretches.T) * stretches[
            :, None
        ] + np.eye(2)
        rounding = 4.0 * np.finfo(float).eps * (1.0 + np.abs(matrix).max(axis=(1, 2)))
        return MapImage(states + accelerations, matrix, np.zeros((len(states), 2, 0)), rounding)
