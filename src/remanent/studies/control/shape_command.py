"""Step commands that land a block at rest on a target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr

from remanent._checks import Rule, require_field_names, require_real
from remanent._errors import InputError
from remanent._status import Status
from remanent._typing import ArrayLike, FloatArray
from remanent.models.actuator import Actuator
from remanent.models.drives.piecewise import Steps
from remanent.models.drives.waves import Constant
from remanent.models.physical_sizes import PHYSICAL_SIZES
from remanent.studies.control._shaped_steps import find_shaped_steps
from remanent.studies.ensemble.checks import require_actuator, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble

_TARGET_RULE = Rule(
    "be a finite number from 1e-6 to 1e6",
    lambda x: np.asarray((x >= 1e-6) & (x <= 1e6)),
    "It is a thickness stretch, a ratio of lengths.",
    "Pass for example 1.2.",
)
#: The load of the ensemble's own drive: each step has its load in place of it.
_ZERO_LOAD_DRIVE = Constant(0.0)
#: Names of dimensions that results have of their own.
_RESERVED_DIMENSIONS = frozenset({"step"})


def shape_command(
    actuator: Actuator,
    target: float,
    *,
    initial: ArrayLike | None = None,
    robust_to: str | Sequence[str] = (),
    tolerance: float = 1e-10,
) -> Steps:
    r"""Steps of the magnetic load that land on a thickness stretch at rest.

    Parameters
    ----------
    actuator : Actuator
        Any: prestressed, damped, of any material, with internal variables.
    target : float
        Thickness stretch λ₃ at which it is to stay.
    initial : array (state,), optional
        State at τ = 0, (stretch, rate) of each coordinate; (1, 0) by default, as in every
        verb, also with prestress, where it is not an equilibrium under no load.  For a move
        from there pass the ``stretch`` that :func:`remanent.equilibria` gives, and 0.
    robust_to : str or sequence of str
        Fields of the actuator (``"temperature"`` ...), or ``"shear_modulus"``, ``"density"``,
        ``"remanence"``: the residual vibration shall not change, to first order, with each of
        them.  The command is longer by about half a period for each.
    tolerance : float
        Bound of the error of the state at the last step.

    Returns
    -------
    Steps
        The drive; its last load is held for ever.

    Raises
    ------
    InputError
        A bad argument, a target that is no stable equilibrium under any load, or no command
        found.

    See Also
    --------
    remanent.shape_commands : The same for many values of the actuator's fields.
    remanent.step_response : What a command leaves of vibration.

    Notes
    -----
    Without prestress and damping, for the neo-Hookean solid, the answer is two steps:
    m₁ = θ(x − 1)(x + 2)/(2x), whose motion from rest turns at x, for half its period, then
    m₂ = θ(x³ − 1)/x², under which x is an equilibrium.  In general the last load and state of
    rest solve the equations of equilibrium; loads and durations before it solve
    y(end) = y(rest), and dy(end)/dp = dy(rest)/dp for each p in `robust_to`, by least squares
    from the answer for small moves, the command that leaves a linear oscillator without vibration.

    Examples
    --------
    >>> import remanent as rm
    >>> command = rm.shape_command(rm.Actuator(), 1.5)
    >>> [round(m, 6) for m in command.loads]
    [0.583333, 1.055556]
    """
    command = shape_commands(
        actuator, target, initial=initial, robust_to=robust_to, tolerance=tolerance
    )
    return Steps(command.step_time.values, command.step_load.values)


def shape_commands(
    actuator: Actuator,
    target: float,
    *,
    initial: ArrayLike | None = None,
    robust_to: str | Sequence[str] = (),
    over: OverArgument | None = None,
    tolerance: float = 1e-10,
) -> xr.Dataset:
    """Steps of the magnetic load that land on a target, for many actuators.

    Each is the command of :func:`remanent.shape_command` for its actuator.

    Parameters
    ----------
    actuator : Actuator
        Any: prestressed, damped, of any material, with internal variables.
    target : float
        Thickness stretch λ₃ at which it is to stay.
    initial : array (state,), optional
        State at τ = 0, (stretch, rate) of each coordinate; (1, 0) by default.
    robust_to : str or sequence of str
        Fields of the actuator, or ``"shear_modulus"``, ``"density"``, ``"remanence"``: the
        residual vibration shall not change, to first order, with each of them.
    over : mapping of str to array_like or DataArray, optional
        Values of fields of the actuator or the initial state; they become dimensions of the
        result.
    tolerance : float
        Bound of the error of the state at the last step.

    Returns
    -------
    xarray.Dataset
        Along the dimensions of `over` and ``step``: ``step_time`` and ``step_load``;
        ``switch_time``, that of the last step, with ``switch_time_error``; ``residual``, the
        largest distance of the state from rest then, with ``residual_error``; ``status``.  Loads
        and times are those of the command itself, to the last digit.  NaN where there is no
        command, with the status ``invalid`` or ``diverged``.

    Raises
    ------
    InputError
        A bad argument; without `over` also a target for which there is no command.

    See Also
    --------
    remanent.shape_command : One command, as a drive.
    remanent.sensitivity : How a switching time depends on a field.

    Notes
    -----
    The equations are those of :func:`remanent.shape_command`, solved for all points together.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.shape_commands(rm.Actuator(), 1.5, over={"temperature": [250.0, 350.0]})
    >>> ds.switch_time.values.round(4).tolist()
    [1.5415, 1.3028]
    """
    require_actuator("actuator", actuator)
    target = require_real("target", target, _TARGET_RULE)
    tolerance = require_tolerance(tolerance, "the error of the state at the last step")
    ens = lay_out_ensemble(
        actuator,
        _ZERO_LOAD_DRIVE,
        over,
        initial,
        reserved=_RESERVED_DIMENSIONS,
        system_argument="actuator",
    )
    fields = [name for name in ens.vector_field.parameter_names if name != "m"]
    names = _require_robust_to(robust_to, [*fields, *PHYSICAL_SIZES])
    commands = [
        _find_command(ens, k, target, names, tolerance) for k in range(ens.trajectory_count)
    ]
    longest = max(command.times.size for command in commands) or 1
    return to_dataset(
        ens,
        _command_variables(commands, longest, ens),
        coords={"step": (("step",), np.arange(longest))},
        tolerance=tolerance,
        driven=False,
        target=target,
        robust_to=" ".join(names) or None,
    )


def _require_robust_to(robust_to: str | Sequence[str], known: Sequence[str]) -> tuple[str, ...]:
    if isinstance(robust_to, Sequence) and not robust_to and not isinstance(robust_to, str):
        return ()
    return tuple(
        require_field_names("robust_to", robust_to, known, "the actuator, or physical sizes")
    )


@dataclass(frozen=True)
class _StepCommand:
    """The steps for one actuator.

    Attributes
    ----------
    times, loads : array (step,)
        Empty where there is no command.
    distance_from_rest, distance_error : float
        Largest distance of the state from rest at the last step, and its error.
    last_step_time_error : float
        Of the time of the last step.
    """

    times: FloatArray
    loads: FloatArray
    distance_from_rest: float = np.nan
    distance_error: float = np.nan
    last_step_time_error: float = np.nan


def _find_command(
    ens: Ensemble, index: int, target: float, robust_to: Sequence[str], tolerance: float
) -> _StepCommand:
    """The steps for one trajectory; an empty command where there is none on a grid."""
    try:
        sequence, last = find_shaped_steps(ens.single_member(index), target, robust_to, tolerance)
    except InputError:
        if not ens.dimension_sizes:
            raise
        return _StepCommand(np.empty(0), np.empty(0))
    return _StepCommand(
        np.concatenate([[0.0], np.cumsum(sequence.durations)]),
        np.append(sequence.loads, last),
        sequence.residual,
        sequence.residual_error,
        sequence.total_duration_error,
    )


def _command_variables(
    commands: Sequence[_StepCommand], longest: int, ens: Ensemble
) -> dict[str, PerTrajectoryArray]:
    """Commands as arrays, filled up with NaN to the longest."""
    times, loads = np.full((2, ens.trajectory_count, longest), np.nan)
    for k, command in enumerate(commands):
        times[k, : command.times.size] = command.times
        loads[k, : command.loads.size] = command.loads
    missing = np.array([command.times.size == 0 for command in commands])
    codes = np.where(missing, Status.DIVERGED, Status.OK)
    return {
        "step_time": (("step",), times),
        "step_load": (("step",), loads),
        "switch_time": np.fmax.reduce(times, axis=1),
        "switch_time_error": np.array([command.last_step_time_error for command in commands]),
        "residual": np.array([command.distance_from_rest for command in commands]),
        "residual_error": np.array([command.distance_error for command in commands]),
        "status": np.where(ens.is_invalid, Status.INVALID, codes),
    }
