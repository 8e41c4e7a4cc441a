"""Bifurcation diagrams: what a motion does while a parameter is swept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import require_choice, shortened_repr
from remanent._errors import InputError
from remanent._typing import ArrayLike
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import DriveArgument, require_parameter, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.durations import require_count, require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import (
    RESERVED_DIMENSIONS,
    OverArgument,
    lay_out_ensemble,
    require_over,
)
from remanent.studies.ensemble.memory import require_memory
from remanent.studies.ensemble.observables import evaluate_observable
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.regimes._arguments import rename_arguments_in_errors
from remanent.studies.regimes._parameter_sweep import ParameterSweep, SweepSection

#: Sweeps of each direction asked for: the order in which values are visited.
_SWEEPS_OF_DIRECTION = {"up": ("up",), "down": ("down",), "both": ("up", "down")}
#: Bytes that a point of the section takes.
_BYTES_PER_POINT = 64.0
#: Most periods that pass at a value before points are kept.
_MOST_DISCARDED_PERIODS = 1_000_000
#: Names of dimensions that results have of their own.
_RESERVED_DIMENSIONS = RESERVED_DIMENSIONS | {"sweep"}


def bifurcation_diagram(
    system: System,
    drive: DriveArgument,
    parameter: str,
    values: ArrayLike,
    *,
    direction: str = "up",
    discard: int = 200,
    keep: int = 50,
    initial: ArrayLike | None = None,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Sweep a parameter and keep the last points of the section at every value.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load.
    parameter : str
        A numeric field of the system or the drive.
    values : array (value,)
        Its values, ascending.
    direction : {"up", "down", "both"}
        The order in which values are visited.  Each value starts from the state in which the
        motion left the one before, so that sweeps show hysteresis.
    discard, keep : int
        Drive periods that pass at each value before points are kept, at most a million, and
        points kept.
    initial : array (state,), optional
        State at the first value of each sweep, (stretch, rate) of each coordinate; rest by
        default.
    over : mapping of str to array_like or DataArray, optional
        Values of further numeric fields; they become dimensions of the result.  Every set of
        them has sweeps of its own.
    tolerance : float
        Bound of the error that one drive period adds.
    progress : bool or callable, optional
        True draws a bar; a function is called with the share of values that are
        finished, in [0, 1].

    Returns
    -------
    xarray.Dataset
        Along the dimensions of `over`, ``sweep`` (``"up"``, ``"down"``; only for ``"both"``),
        the parameter and ``period`` (of those kept): the state, ``thickness_stretch`` and
        ``thickness_stretch_rate``; for each value also ``drive_period``, ``local_error``
        (the largest error of one period) and ``status``.  Where the motion has escaped, NaN;
        the next value starts from `initial` again.  Points have no global error: they are those
        of a motion whose every period is within ``local_error``.  On a stable orbit
        whose multipliers have the size μ < 1 per period they are off by about 1/(1 − μ) times that;
        in chaos they belong to a motion nearby.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    See Also
    --------
    remanent.continue_orbit : Branches of orbits, the unstable ones too.
    remanent.classify : What kind of motion the points belong to.
    remanent.poincare_section : Points of the section at one set of parameters.

    Notes
    -----
    Points are not joined to branches and unstable motions do not show: they are found by
    :func:`remanent.continue_orbit`.

    Examples
    --------
    >>> import numpy as np, remanent as rm
    >>> ds = rm.bifurcation_diagram(
    ...     rm.Actuator(dissipation=rm.Rayleigh(0.3)),
    ...     rm.SineSquared(0.4, 1.25),
    ...     "b",
    ...     np.linspace(0.2, 0.4, 3),
    ...     discard=100,
    ...     keep=4,
    ... )
    >>> bool(np.ptp(ds.stretch.values, axis=1).max() < 1e-6)  # period 1 throughout
    True
    """
    require_choice("direction", direction, ["up", "down", "both"])
    discard = require_count("discard", discard, "Whole drive periods pass.", 0)
    if discard > _MOST_DISCARDED_PERIODS:
        raise InputError(
            "discard",
            must=f"be at most {_MOST_DISCARDED_PERIODS}",
            got=discard,
            why="So many drive periods pass at each value, which takes seconds for a million.",
            fix="Pass fewer; motion at the value before is where the next begins.",
        )
    keep = require_count("keep", keep, "It is a number of points.")
    tolerance = require_tolerance(tolerance, "the error that one drive period adds")
    ens = _lay_out_sweep(system, drive, parameter, values, over, initial)
    require_drive_periods(ens)
    directions = _SWEEPS_OF_DIRECTION[direction]
    needed = _BYTES_PER_POINT * ens.trajectory_count * keep * len(directions)
    require_memory("keep", needed, f"{ens.trajectory_count} x {keep} points")
    sweep = ParameterSweep(
        ensemble=ens,
        problem=initial_value_problem(ens, np.ones(ens.trajectory_count)),
        sweep_directions=directions,
        discarded_periods=discard,
        kept_periods=keep,
        period_tolerance=tolerance,
    )
    result = to_dataset(
        ens,
        _diagram_variables(sweep, sweep.run(as_progress(progress))),
        coords=_diagram_coordinates(sweep),
        tolerance=tolerance,
        direction=direction,
        discard=discard,
        keep=keep,
    )
    if len(directions) > 1:  # one picture for each sweep: its dimension stands before the values
        result = result.transpose(*ens.dims[:-1], "sweep", ...)
    return result


def _lay_out_sweep(
    system: System,
    drive: DriveArgument,
    parameter: str,
    values: ArrayLike,
    over: OverArgument | None,
    initial: ArrayLike | None,
) -> Ensemble:
    """Trajectories over the values of `over` first, then over those of the parameter."""
    require_parameter("parameter", parameter, lay_out_ensemble(system, drive, None, initial))
    require_over(over)
    _require_values_with_own_dimension(parameter, values, over or {})
    with rename_arguments_in_errors({f"over[{parameter!r}]": "values"}):
        return lay_out_ensemble(
            system,
            drive,
            {**(over or {}), parameter: values},
            initial,
            reserved=_RESERVED_DIMENSIONS,
        )


def _require_values_with_own_dimension(
    parameter: str, values: Any, over: Mapping[str, Any]
) -> None:
    """Refuse values that do not make a dimension of their own, the last one."""
    if isinstance(values, xr.DataArray) and values.dims != (parameter,):
        raise InputError(
            "values",
            must="be a plain array",
            got=shortened_repr(values),
            why="A sweep visits one value after the other.",
            fix="Pass for example numpy.linspace(0.5, 2.0, 300).",
        )
    clash = [
        name
        for name, given in over.items()
        if parameter in (given.dims if isinstance(given, xr.DataArray) else (name,))
    ]
    if clash or parameter in over:
        raise InputError(
            "over",
            must=f"not vary {parameter}",
            got=", ".join(map(repr, clash or [parameter])),
            why="That is what is swept.",
            fix="Leave it out, or rename the dimension.",
        )


def _diagram_variables(
    sweep: ParameterSweep, section: SweepSection
) -> dict[str, PerTrajectoryArray]:
    """The state, what is observed of it, and the evidence, by name."""
    ens, count = sweep.ensemble, len(sweep.sweep_directions)

    def labelled(values: np.ndarray, *dims: str) -> PerTrajectoryArray:
        return (("sweep", *dims), values) if count > 1 else (dims, values[:, 0])

    variables: dict[str, PerTrajectoryArray] = {
        name: labelled(section.states[..., k], "period")
        for k, name in enumerate(ens.vector_field.state_names)
    }
    times = np.zeros((ens.trajectory_count, sweep.kept_periods))  # at the beginning of a period
    for name in ens.vector_field.observable_and_rate_names:
        observed = [
            evaluate_observable(sweep.problem, name, times, section.states[:, k])
            for k in range(count)
        ]
        variables[name] = labelled(np.stack(observed, axis=1), "period")
    variables["drive_period"] = sweep.period_lengths
    variables["local_error"] = labelled(section.largest_period_error)
    variables["status"] = labelled(section.status)
    return variables


def _diagram_coordinates(sweep: ParameterSweep) -> dict[str, Labelled]:
    numbers = np.arange(1, sweep.kept_periods + 1) + sweep.discarded_periods
    coords: dict[str, Labelled] = {"period": (("period",), numbers)}
    if len(sweep.sweep_directions) > 1:
        coords["sweep"] = (("sweep",), np.array(sweep.sweep_directions))
    return coords
