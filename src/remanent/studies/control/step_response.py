"""What follows a command of steps: rise, overshoot, settling, residual vibration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from remanent._checks import positive_rule, require_real
from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray
from remanent.analysis.control import shaping
from remanent.codegen.field import vector_field_for
from remanent.models.drives.base import Drive
from remanent.models.drives.piecewise import Steps
from remanent.models.drives.waves import Constant
from remanent.models.system import System
from remanent.studies.control._step_metrics import (
    StepMotion,
    Transient,
    final_rest_and_residual_vibration,
)
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.layout import OverArgument
from remanent.studies.ensemble.physical_scales import PhysicalScales, lay_out_physical_scales
from remanent.studies.statics._static_state import StaticState

_SETTLING_BAND_RULE = positive_rule(
    "It is a share of the change of thickness stretch.", "Pass 0.02."
)
_DURATION_RULE = positive_rule("A run takes a positive time.", "Pass a time in units of tau.")
#: Half periods after the last step that are followed by default.
_HALF_PERIODS_AFTER_LAST_STEP = 20.0
#: Samples in each half period.
_SAMPLES_PER_HALF_PERIOD = 24


def step_response(
    system: System,
    drive: Drive,
    *,
    duration: float | None = None,
    band: float = 0.02,
    initial: ArrayLike | None = None,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """Measure how the thickness stretch answers a command of steps.

    Parameters
    ----------
    system : System
        What moves.
    drive : Steps or Constant
        :class:`remanent.Steps`, or :class:`remanent.Constant`, one step at τ = 0.
    duration : float, optional
        Length of the run, τ; by default ten natural periods after the last step.
    band : float
        Share of the change within which the answer counts as settled.
    initial : array_like (state,), optional
        State at τ = 0: stretch and rate of each coordinate in turn, to which internal variables
        and the temperature may be added; rest, (1, 0), by default.
    over : mapping of str to array_like or DataArray, optional
        Values of numeric fields, and of ``shear_modulus``, ``density`` and ``remanence``
        over their nominal values, while the command, the dead loads and the viscosities stay
        as they are in SI; they become dimensions of the result.
    tolerance : float
        Bound of the absolute global error of the state.

    Returns
    -------
    xarray.Dataset
        Along the dimensions of `over`, times in the actuator's unit of time:

        ``final``
            The thickness stretch x∞ of rest under the last load.
        ``residual_energy``, ``residual_amplitude``
            The energy above that rest right after the last step, per reference volume over
            μ, and the amplitude of the vibration of thickness stretch that it makes.
        ``rise_time``
            From 10 to 90 % of the change x∞ − x(0).
        ``settling_time``
            The last instant outside the band, NaN if the motion ends outside.
        ``farthest``, ``overshoot``
            The farthest thickness stretch in the direction of the change, and
            (farthest − x∞)/change, at least 0; NaN without a change.
        ``error``, ``horizon``, ``status``
            Of the motion.

        The other variables have errors of their own, ``rise_time_error`` and so on.

    Raises
    ------
    InputError
        A bad argument, or a last load without a state of rest near the start.

    Notes
    -----
    residual amplitude = √(2 E_r/k), with k = dm/dx along the states of rest: for a small
    vibration its amplitude, for any other the static deflection of the same energy.  Passages
    of levels are bracketed between 24 samples per half period and refined on the dense output.

    Examples
    --------
    >>> import remanent as rm
    >>> command = rm.shape_command(rm.Actuator(), 1.5)
    >>> shaped = rm.step_response(rm.Actuator(), command)
    >>> plain = rm.step_response(rm.Actuator(), rm.Constant(command.loads[-1]))
    >>> bool(shaped.residual_amplitude < 1e-6 * plain.residual_amplitude)
    True

    See Also
    --------
    remanent.shape_command : steps that leave no vibration.
    remanent.simulate : the motion itself.
    """
    require_tolerance(tolerance, "the global error of the state")
    band = require_real("band", band, _SETTLING_BAND_RULE)
    _require_step_drive(drive)
    scaled = lay_out_physical_scales(system, drive, over, initial)
    ens = scaled.ensemble_in_own_units
    rests = _final_rest_states(scaled)
    half_period = _longest_half_periods(rests)
    last_step = _last_step_times(scaled)
    if duration is None:
        duration = float(
            np.nanmax(
                (last_step + _HALF_PERIODS_AFTER_LAST_STEP * half_period)
                / scaled.time_factor_to_trajectory_unit
            )
        )
    duration = require_real("duration", duration, _DURATION_RULE)
    motion = StepMotion.from_problem(
        scaled.build_problem_lasting(np.full(ens.trajectory_count, duration)), tolerance
    )
    after_last = motion.states_at(last_step[:, None])[:, 0]
    values = final_rest_and_residual_vibration(rests, after_last, motion.outcome.error)
    start = motion(np.zeros((ens.trajectory_count, 1)))[0][:, 0]
    spacing = float(np.nanmin(half_period)) / _SAMPLES_PER_HALF_PERIOD
    values |= Transient(
        motion, start, values["final"], band, spacing, scaled.time_factor_to_trajectory_unit
    ).compute_metrics()
    variables: dict[str, PerTrajectoryArray] = {
        name: np.where(ens.is_invalid, np.nan, column) for name, column in values.items()
    }
    return to_dataset(
        ens,
        variables,
        outcome=motion.outcome,
        tolerance=tolerance,
        duration=duration,
        band=band,
    )


def _require_step_drive(drive: object) -> None:
    if not isinstance(drive, Steps | Constant):
        raise InputError(
            "drive",
            must="be rm.Steps or rm.Constant",
            got=repr(drive),
            why="A response to steps ends under a load that stays.",
            fix="Pass rm.shape_command(...).",
        )


def _last_step_times(scaled: PhysicalScales) -> FloatArray:
    """Time of the last step of each trajectory, in its own unit."""
    drive = scaled.ensemble_in_own_units.drive
    return scaled.time_factor_to_trajectory_unit * (
        float(drive.times[-1]) if isinstance(drive, Steps) else 0.0
    )


def _final_rest_states(scaled: PhysicalScales) -> list[StaticState | None]:
    """Every trajectory's state of rest under the last load."""
    ens = scaled.ensemble_in_own_units
    drive = ens.drive
    loads = (
        scaled.load_factor_to_trajectory_unit * float(drive.loads[-1])
        if isinstance(drive, Steps)
        else ens.parameter_values["m"]
    )
    field = vector_field_for(ens.system, Constant(0.0))
    rests: list[StaticState | None] = []
    for k in np.arange(ens.trajectory_count):
        values = {name: v[k] for name, v in ens.parameter_values.items()} | {"m": loads[k]}
        row = np.array([float(values[name]) for name in field.parameter_names])
        rests.append(
            None
            if ens.is_invalid[k]
            else StaticState(field, row, ens.initial_states[k]).rest_nearby()
        )
    if all(body is None for body in rests):
        raise InputError(
            "drive",
            must="end under a load with a state of rest near the start",
            got=loads.tolist(),
            why="What is left of a vibration is counted from there.",
            fix="Pass a smaller last load.",
        )
    return rests


def _longest_half_periods(rests: Sequence[StaticState | None]) -> FloatArray:
    """Half the longest natural period at every rest, array (trajectory,)."""
    return np.array(
        [
            np.nan
            if b is None
            else shaping.default_impulse_spacing(shaping.controllable_poles(*b.rate_derivatives()))
            for b in rests
        ]
    )
