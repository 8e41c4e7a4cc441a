"""Equilibria under a constant magnetic load."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._field import Role
from remanent._typing import FloatArray, IntArray
from remanent.analysis.statics.equilibria import find_force_zeros, force_slope
from remanent.integrate.variations import transverse_field
from remanent.models.actuator import Actuator
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_system
from remanent.studies.ensemble.constant_drive import ConstantLoadArgument, constant_drive
from remanent.studies.ensemble.dataset import to_dataset
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.two_coordinates import ensemble_with_two_coordinates
from remanent.studies.statics._biaxial import biaxial_equilibria
from remanent.studies.statics._folds import fold_points, folds_along_first_varied_parameter
from remanent.studies.statics._static_box import require_no_box
from remanent.studies.statics._static_ensemble import StaticEnsemble
from remanent.studies.statics._static_errors import (
    largest,
    least,
    square_root_error,
    squared_frequency_error,
    stretch_error,
    thickness_error,
)
from remanent.studies.statics._written_equilibria import written_equilibria

#: Thickness stretches at which the potential is tabulated, around equilibria and rest.
_POTENTIAL_POINT_COUNT = 401
#: The smallest of them.
_LEAST_TABULATED_THICKNESS = 0.05


def equilibria(
    actuator: System,
    m: ConstantLoadArgument = 0.0,
    *,
    state_box: Mapping[str, Any] | None = None,
    over: OverArgument | None = None,
) -> xr.Dataset:
    """Find every equilibrium under the constant load `m`, with its stability.

    Parameters
    ----------
    actuator : System
        What is at rest.  Branches are relaxed, temperature is that of the surroundings.
    m : float, or mapping of str to float
        Magnetic load, dimensionless; of a system of one's own its load, or its loads by their
        names, 0 where they are left out.
    state_box : mapping of str to (float, float), optional
        Of a system of one's own: where its coordinates and internal variables may be.  All
        equilibria in the box are found, or the status is ``incomplete`` with the ``reason``.
    over : mapping of str to array_like or DataArray, optional
        Values of numeric fields (``m`` among them); they become dimensions.  Along the
        first of them, between its least and largest value, folds are located.

    Returns
    -------
    xarray.Dataset
        Along ``equilibrium``, in order of the in-plane stretch, NaN where there are
        fewer, each with its error (``stretch_error`` ...), a bound of what rounding does:
        ``equilibrium_stretch`` (thickness stretch), ``stretch``, ``equilibrium_potential``,
        ``natural_frequency`` (radians per unit of tau, NaN where unstable) and ``stability``
        (``stable``, ``unstable`` or empty), within equal stretches; ``transverse_stiffness``,
        ω_a² of λ₁ − λ₂, negative where the stretches do not stay equal.
        ``potential`` against ``thickness_stretch`` is the potential energy per
        reference volume over mu, ``level`` that of rest, whose motion runs between
        ``turning_lower`` and ``turning_upper``.  With `over`, along ``fold``, the values
        of its first field at which two equilibria meet, ``fold_m`` for example, and the
        ``fold_stretch`` and ``fold_thickness_stretch`` there, with errors.  ``potential`` and
        ``level`` are closed forms at exact stretches, with no error but rounding.  Where a
        value of `over` is invalid, as ``status`` says, everything is NaN.  With two coordinates:
        ``stretch_1``, ``stretch_2``, ordered by the first, and ``natural_frequency`` along
        ``mode`` too; no folds and no table of the potential.
        Of a system of one's own: its coordinates and internal variables with their errors,
        ``observable`` where that is none of them, ``equilibrium_potential`` where there is an
        energy, ``natural_frequency`` without damping, and ``eigenvalues`` of small motions
        along ``eigenvalue``, by which ``stability`` is told (``undecided`` near 0); folds along
        the first field of `over` with ``fold_stability``, see :func:`remanent.snap_through`.

    Raises
    ------
    InputError
        A bad argument; the message says which and what to do.

    See Also
    --------
    snap_through : The loads at which an equilibrium is lost, slowly and at a step.
    backbone : Frequency of free oscillations about an equilibrium at any amplitude.

    Notes
    -----
    Sign changes of the force on 4001 stretches from 0.05 to 20, or between the limits of the
    material where these are nearer, refined to round-off; the error is the force that rounding
    may leave there, over its slope;
    the natural frequency is √(−∂λ''/∂λ) at rest, by a complex step.  Without dissipation
    ω_a² of a neo-Hookean solid is 3[θ(1 + λ⁻⁶) − mλ⁻⁴].  At a fold the parameter
    that balances the force, as a function of the stretch, has an extremum: a sign change of
    ∂f/∂λ along it.  One value of the parameter is found for each stretch, which is all there
    is for loads, prestress and temperature, in which the force is linear.  With two
    coordinates Newton's method starts where both forces change sign between neighbouring
    pairs of stretches, in 96 directions from rest and at 96 distances up to stretches of 0.001
    and 1000 or the limit of the material: what is missed are pairs that are about to merge.

    Examples
    --------
    >>> import numpy as np
    >>> import remanent as rm
    >>> rm.equilibria(rm.Actuator(), 0.16).equilibrium_stretch.values.round(4).tolist()
    [1.0563]
    >>> curve = rm.equilibria(rm.Actuator(prestress=2.2), over={"m": np.linspace(1, 4, 31)})
    >>> curve.fold_m.values.round(4).tolist()
    [2.1777, 2.8483]
    """
    actuator = require_system("actuator", actuator)
    drive = constant_drive(actuator, m)
    ens = lay_out_ensemble(actuator, drive, over, system_argument="actuator")
    if not isinstance(actuator, Actuator):
        return written_equilibria(ens, state_box)
    require_no_box(state_box)
    if actuator.coordinate_count == 2:
        return biaxial_equilibria(ens)
    static = StaticEnsemble(ens)
    stretch = find_force_zeros(static.first_acceleration, ens.trajectory_count, static.stretch_grid)
    stretch[ens.is_invalid] = np.nan
    variables = _equilibrium_properties(static, stretch)
    fold_variables = folds_along_first_varied_parameter(ens, partial(fold_points, static))
    landscape = _potential_variables(static, variables["equilibrium_stretch"])
    coords: dict[str, Labelled] = {
        **({"fold": fold_variables.pop("fold")} if fold_variables else {}),
        "equilibrium": (("equilibrium",), np.arange(stretch.shape[1])),
        "thickness_stretch": landscape.pop("thickness_stretch"),
    }
    return to_dataset(
        ens,
        {name: (("equilibrium",), values) for name, values in variables.items()},
        shared=fold_variables | landscape,
        coords=coords,
        tolerance=None,
    )


def _equilibrium_properties(static: StaticEnsemble, stretch: FloatArray) -> dict[str, NDArray[Any]]:
    """What is known of equilibria with in-plane stretches (case, equilibrium)."""
    case = np.repeat(np.arange(len(stretch)), stretch.shape[1]).reshape(stretch.shape)
    # A force that falls with the stretch brings it back.
    stiffness = -force_slope(static.first_acceleration, case, stretch)
    force = static.first_acceleration_with_rounding(case, stretch)
    error = stretch_error(static, case, stretch, force)
    transverse, transverse_error = _transverse_stiffness(static.ensemble, case, stretch, error)
    with np.errstate(invalid="ignore"):
        known = (stiffness > 0) & np.isfinite(stiffness)
        frequency = np.sqrt(np.where(known, stiffness, np.nan))
        squared_error = squared_frequency_error(static, case, stretch, error, force)
    return {
        "equilibrium_stretch": static.thickness(case, stretch),
        "equilibrium_stretch_error": thickness_error(static, case, stretch, error),
        "stretch": stretch,
        "stretch_error": error,
        "equilibrium_potential": static.potential(case, stretch),
        "equilibrium_potential_error": static.potential_with_rounding(case, stretch).value.bound,
        "natural_frequency": frequency,
        "natural_frequency_error": square_root_error(frequency, squared_error),
        "stability": np.where(stiffness > 0, "stable", np.where(stiffness <= 0, "unstable", "")),
        "transverse_stiffness": transverse,
        "transverse_stiffness_error": transverse_error,
    }


def _transverse_stiffness(
    ens: Ensemble, case: IntArray, stretch: FloatArray, error: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """omega_a^2 of a small difference of the in-plane stretches at rest, and its error."""
    biaxial, pairs = ensemble_with_two_coordinates(ens)
    field = transverse_field(biaxial.vector_field, pairs)
    static = StaticEnsemble(replace(biaxial, vector_field=field))
    (rate,) = field.names_of_roles(Role.RATE)
    (difference,) = field.names_belonging_to(rate)
    number = static.evaluate_with_rounding(field.rates, case, stretch)[
        field.state_names.index(difference)
    ]
    return -np.asarray(number.value.value), np.asarray(
        number.value.bound + largest(number.slope) * error
    )


def _potential_variables(static: StaticEnsemble, equilibria: FloatArray) -> dict[str, Labelled]:
    """The potential on a common grid that holds rest, equilibria and turning points.

    `equilibria` are thickness stretches (case, equilibrium).
    """
    ens = static.ensemble
    places = np.concatenate([equilibria[np.isfinite(equilibria)], [1.0]])
    low, high = places.min(), places.max()
    margin = 0.75 * (high - low) + 0.1
    grid = np.linspace(
        max(_LEAST_TABULATED_THICKNESS, low - margin), high + margin, _POTENTIAL_POINT_COUNT
    )
    case = np.repeat(np.arange(ens.trajectory_count), grid.size)
    potential = static.potential(case, np.tile(grid**-0.5, ens.trajectory_count))
    level = static.potential(np.arange(ens.trajectory_count), np.ones(ens.trajectory_count))
    with np.errstate(all="ignore"):  # of loads near the largest number
        turning, error = _turning_points(static, level)
    order = np.argsort(turning, axis=0)
    turning, error = (np.take_along_axis(a, order, axis=0) for a in (turning, error))
    rows = {
        "level": level,
        "turning_lower": turning[0],
        "turning_lower_error": error[0],
        "turning_upper": turning[1],
        "turning_upper_error": error[1],
        "potential": potential.reshape(ens.trajectory_count, grid.size),
    }
    variables: dict[str, Labelled] = {"thickness_stretch": (("thickness_stretch",), grid)}
    for name, values in rows.items():
        is_invalid = ens.is_invalid.reshape(-1, *[1] * (values.ndim - 1))
        dims = (*ens.dims, "thickness_stretch") if name == "potential" else ens.dims
        variables[name] = (dims, ens.reshape_to_dims(np.where(is_invalid, np.nan, values)))
    return variables


def _turning_points(static: StaticEnsemble, level: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Thickness stretches (2, trajectory) between which the motion from rest runs, and errors.

    One of them is rest.  The other is the nearest stretch, in the direction in which the force
    pushes, at which the potential is again what it is at rest, `level`.
    """
    count = static.ensemble.trajectory_count
    case, rest = np.arange(count), np.ones(count)
    # The grid is moved by a little, so that rest itself is not one of its points.
    passages = find_force_zeros(
        lambda i, x: static.potential(i, x) - level[i], count, static.stretch_grid * (1.0 - 1e-9)
    )
    direction = np.sign(static.first_acceleration(case, rest))
    distance = np.where(
        (passages - 1.0) * direction[:, None] > 1e-8, np.abs(passages - 1.0), np.inf
    )
    nearest = distance.min(axis=1, initial=np.inf)
    shift = np.where(np.isfinite(nearest), nearest, np.nan) * direction
    opposite_end = np.where(direction == 0.0, 1.0, 1.0 + shift)
    potential = static.potential_with_rounding(
        np.stack([case, case]), np.stack([opposite_end, rest])
    )
    left = np.abs(potential.value.value[0] - level) + np.sum(potential.value.bound, axis=0)
    error = np.where(direction == 0.0, 0.0, left / least(potential.slope)[0])
    return (
        np.stack([static.thickness(case, rest), static.thickness(case, opposite_end)]),
        np.stack([0.0 * rest, thickness_error(static, case, opposite_end, error)]),
    )
