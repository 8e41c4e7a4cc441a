"""What follows a command of steps: rise, overshoot, settling, residual vibration."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._checks import positive_rule, require_real
from remanent._errors import InputError
from remanent._field import Role
from remanent._status import Status
from remanent._typing import ArrayLike, BoolArray, FloatArray
from remanent.analysis.control import shaping
from remanent.codegen.field import vector_field_for
from remanent.models.drives.base import Drive
from remanent.models.drives.piecewise import Steps
from remanent.models.drives.waves import Constant
from remanent.models.system import System
from remanent.studies.control._final_rest import FinalRests, find_final_rests
from remanent.studies.control._step_metrics import (
    StepMotion,
    Transient,
    end_states_with_errors,
    residual_vibration,
)
from remanent.studies.ensemble.checks import require_actuator, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.durations import require_duration
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.quantities import without_unit
from remanent.studies.statics._static_ensemble import StaticEnsemble
from remanent.studies.statics._static_state import StaticState

_SETTLING_BAND_RULE = positive_rule(
    "It is a share of the change of thickness stretch.", "Pass 0.02."
)
#: Half periods after the last step that are followed by default.
_HALF_PERIODS_AFTER_LAST_STEP = 20.0
#: Names of dimensions that the result, or the motion behind it, has of its own.
_RESERVED_DIMENSIONS = frozenset({"time", "cycle", "step"})
#: Words for numbers that are missing.
_UNCHANGED_REASON = "the motion ends where it starts, so that there is no change to measure"
_NOT_RISEN_REASON = "the run ends before 90 % of the change is reached: pass a longer duration"
_NOT_SETTLED_REASON = "the run ends before the motion has settled: pass a longer duration"
_NEVER_SETTLES_REASON = "nothing takes energy out of the motion, which never settles"


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
    duration : float, str or quantity, optional
        Length of the run, τ, or with a unit, ``"60 ms"``, where the actuator has SI sizes; by
        default ten natural periods after the last step.
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
            The thickness stretch x∞ of the state of rest that the motion tends to under the
            last load, or vibrates about where nothing takes its energy.
        ``residual_energy``, ``residual_amplitude``
            The energy above that rest right after the last step, per reference volume over
            μ, and the amplitude of the vibration of thickness stretch that it makes.
        ``rise_time``
            From 10 to 90 % of the change x∞ − x(0).
        ``settling_time``
            The last instant outside the band; NaN if the motion has not settled in the run.
        ``farthest``, ``overshoot``
            The farthest thickness stretch in the direction of the change, and
            (farthest − x∞)/change, at least 0; NaN without a change.
        ``reason``
            In words why numbers are missing; the status is ``incomplete`` where the run is too
            short for them, or no state of rest is known that the motion tends to.
        ``error``, ``horizon``, ``status``
            Of the motion.

        The other variables have errors of their own, ``rise_time_error`` and so on.

    Raises
    ------
    InputError
        A bad argument, or a run that ends with the command.

    See Also
    --------
    remanent.shape_command : Steps that leave no vibration.
    remanent.simulate : The motion itself.

    Notes
    -----
    residual amplitude = √(2 E_r/k), with k = dm/dx along the states of rest: for a small
    vibration its amplitude, for any other the static deflection of the same energy.  Between
    turning points, which are roots of the rate, the response is monotonic: they decide which
    levels it passes, and when is then located on the dense output.  For the final rest all
    equilibria under the last load are found, and the motion is followed until its energy lies
    below the barriers about one of them.  A body with a heat balance is followed until its
    temperature has settled.

    Examples
    --------
    >>> import remanent as rm
    >>> command = rm.shape_command(rm.Actuator(), 1.5)
    >>> shaped = rm.step_response(rm.Actuator(), command)
    >>> plain = rm.step_response(rm.Actuator(), rm.Constant(command.loads[-1]))
    >>> bool(shaped.residual_amplitude < 1e-6 * plain.residual_amplitude)
    True
    """
    require_actuator("system", system)
    tolerance = require_tolerance(tolerance, "the global error of the state")
    band = require_real("band", band, _SETTLING_BAND_RULE)
    _require_step_drive(drive)
    ens = lay_out_ensemble(system, drive, over, initial, reserved=_RESERVED_DIMENSIONS)
    after_last, error = _states_after_last_step(ens, tolerance)
    under_last_load = _ensemble_under_last_load(ens)
    rests = find_final_rests(under_last_load, after_last, error.max(axis=1), tolerance)
    duration = without_unit("duration", duration, "time", system)
    duration = _run_length(ens, duration, rests)
    values = residual_vibration(rests.bodies, after_last, error)
    values["final_error"] = rests.thickness_error
    motion = StepMotion.from_problem(
        initial_value_problem(ens, np.full(ens.trajectory_count, duration)),
        tolerance,
        values["final"],
        band,
    )
    values |= Transient(
        motion,
        values["final"],
        values["final_error"],
        _stays_in_band(under_last_load, motion, values["final"], band),
        band,
    ).compute_metrics()
    variables: dict[str, PerTrajectoryArray] = {
        name: np.where(ens.is_invalid, np.nan, column) for name, column in values.items()
    }
    status, reasons = _status_and_reasons(ens, motion, rests, values)
    variables["reason"] = reasons
    return to_dataset(
        ens,
        variables,
        outcome=replace(motion.outcome, status=status),
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


def _last_step_time(drive: Drive) -> float:
    """Time of the last step in the actuator's unit."""
    return float(drive.times[-1]) if isinstance(drive, Steps) else 0.0


def _run_length(ens: Ensemble, duration: float | None, rests: FinalRests) -> float:
    """The `duration` itself, or ten natural periods after the last step."""
    last_step = _last_step_time(ens.drive)
    if duration is None:
        half_periods = _longest_half_periods(rests.bodies)
        longest = np.max(half_periods, initial=0.0, where=np.isfinite(half_periods))
        return last_step + _HALF_PERIODS_AFTER_LAST_STEP * float(longest or 1.0)
    duration = require_duration(duration)
    if duration <= last_step:
        raise InputError(
            "duration",
            must=f"be longer than the command, whose last step is at {last_step}",
            got=duration,
            why="What follows the last step is measured.",
            fix="Pass a longer one, or leave it out for ten natural periods after that step.",
        )
    return duration


def _ensemble_under_last_load(ens: Ensemble) -> Ensemble:
    """The same trajectories under the load that stays."""
    loads = (
        np.full(ens.trajectory_count, float(ens.drive.loads[-1]))
        if isinstance(ens.drive, Steps)
        else ens.parameter_values["m"]
    )
    return replace(
        ens,
        drive=Constant(0.0),
        vector_field=vector_field_for(ens.system, Constant(0.0)),
        parameter_values={**ens.parameter_values, "m": loads},
    )


def _states_after_last_step(ens: Ensemble, tolerance: float) -> tuple[FloatArray, FloatArray]:
    """States right after the last step, and errors, arrays (trajectory, state)."""
    last_step = _last_step_time(ens.drive)
    if last_step == 0.0:
        return ens.initial_states, np.zeros(ens.initial_states.shape)
    problem = initial_value_problem(ens, np.full(ens.trajectory_count, last_step))
    return end_states_with_errors(problem, tolerance)


def _stays_in_band(ens: Ensemble, motion: StepMotion, final: FloatArray, band: float) -> BoolArray:
    """Whether motions that end their run within the band stay there.

    Its energy does not take a motion of one coordinate to an edge of the band that lies higher.
    Of others the end of the run alone is known.
    """
    static, end = StaticEnsemble(ens), motion.end_states
    stays = np.asarray(np.isfinite(end).all(axis=1))
    if len(ens.vector_field.indices_of_roles(Role.COORDINATE, Role.TEMPERATURE)) > 1:
        return stays
    start = motion.node_thickness[:, 0]
    case = np.arange(ens.trajectory_count)
    with np.errstate(all="ignore"):
        edges = [final + side * band * (final - start) for side in (-1.0, 1.0)]
        barrier = np.fmin(*(static.potential(case, edge**-0.5) for edge in edges))
    inputs = [np.zeros(case.size), *end.T]
    inputs += [ens.parameter_values[name] for name in ens.vector_field.parameter_names]
    with np.errstate(all="ignore"):
        (energy,) = ens.vector_field.observables["energy"](inputs, functions=np)
    return np.asarray(stays & ~(energy >= barrier))


def _status_and_reasons(
    ens: Ensemble, motion: StepMotion, rests: FinalRests, values: Mapping[str, FloatArray]
) -> tuple[NDArray[np.int8], NDArray[Any]]:
    """Status of every trajectory, and in words why numbers are missing."""
    count = ens.trajectory_count
    status, reasons = motion.outcome.status.copy(), list(rests.reasons)
    loses = np.broadcast_to(ens.system.where_dissipative(ens.parameter_values), count)
    for k in np.flatnonzero(status == Status.OK):
        if not reasons[k]:
            reasons[k] = (
                _UNCHANGED_REASON if np.isnan(values["overshoot"][k])
                else _NOT_RISEN_REASON if np.isnan(values["rise_time"][k])
                else "" if np.isfinite(values["settling_time"][k])
                else _NOT_SETTLED_REASON if loses[k]
                else _NEVER_SETTLES_REASON
            )  # fmt: skip
        if reasons[k] and reasons[k] not in (_UNCHANGED_REASON, _NEVER_SETTLES_REASON):
            status[k] = Status.INCOMPLETE
    return status, np.array(reasons, dtype="<U100")


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
