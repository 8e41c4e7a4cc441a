"""Poincaré sections: the state once per so many drive periods."""

from __future__ import annotations

import numpy as np
import xarray as xr

from remanent._checks import Rule, require_real
from remanent._errors import InputError
from remanent._typing import ArrayLike
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.models.system import System
from remanent.studies.ensemble.checks import DriveArgument, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.durations import require_count, require_drive_periods
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.observables import (
    blank_beyond_horizon,
    evaluate_observable,
    largest_observable_error,
)
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.ensemble.time_grid import require_memory_for_samples
from remanent.studies.motion._section_by_formula import require_direction, section_by_formula
from remanent.studies.motion._strobed_states import strobed_states

_SECTION_PHASE_RULE = Rule(
    "lie in [0, 1)",
    lambda x: np.asarray((x >= 0.0) & (x < 1.0)),
    "It is the fraction of a drive period at which the state is taken.",
    "Pass 0 for the beginning of each period.",
)


def poincare_section(
    system: System,
    drive: DriveArgument,
    *,
    periods: int | None = None,
    every: int = 1,
    section_phase: float = 0.0,
    where: str | None = None,
    direction: int = 1,
    duration: float | None = None,
    initial: ArrayLike | None = None,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Take the state once per `every` drive periods, or at each passage of a section.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load; any load where there is a section.
    periods : int, optional
        Length of the run in smallest periods of the load.
    every : int
        Periods between points.  The flux b sin(ωτ) repeats at every second period of
        its square: pass 2 to strobe at the period of the flux.
    section_phase : float
        Fraction of a period, in [0, 1), at which the state is taken.
    where : str, optional
        A section in the space of states, in place of the phase: a formula in states,
        parameters and loads, such as ``"z - 27"``, that vanishes on it.
    direction : int
        Which passages of the section: 1 where the formula grows, -1 where it falls, 0 both.
    duration : float, str or quantity, optional
        Length of the run in tau, in place of `periods`, where there is a section; with a unit,
        ``"60 ms"``, where the actuator has SI sizes.
    initial : array_like (2,), (4,) or (state,), optional
        State to start from; rest by default, as for :func:`remanent.simulate`.
    over : mapping of str to array_like or DataArray, optional
        Values of numeric fields; they become dimensions of the result.
    tolerance : float
        Largest error of the state that is allowed, at any of the times; absolute.
    progress : bool or callable, optional
        True draws a bar; a function is called with the share that is done.

    Returns
    -------
    xarray.Dataset
        ``stretch``, ``stretch_rate``, ``thickness_stretch``,
        ``thickness_stretch_rate`` against ``period`` (the number of whole periods
        before each point: 0, every, 2 every ...), NaN beyond the trusted horizon.  Per
        trajectory ``error``, the largest of the state variables at these points, and
        ``thickness_stretch_error``, ``thickness_stretch_rate_error``, what it makes of these;
        ``drive_period``, exact but for rounding, ``horizon``, ``status``.  At a section the
        states stand against ``crossing``, with ``crossing_time``, its error, ``state_error``,
        ``direction`` and the number of ``crossings``, as of :func:`remanent.crossings`.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    See Also
    --------
    simulate : The motion between the points.
    crossings : Sections where a quantity passes through a value, for any load.
    bifurcation_diagram : Sections over a parameter.

    Notes
    -----
    Steps are locked to the phase of the load: the points are ends of steps, with no
    interpolation at phase 0, and periods are counted, never accumulated.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.poincare_section(rm.Actuator(), rm.SineSquared(0.4, 1.25), periods=10, every=2)
    >>> ds.period.values.tolist()
    [0, 2, 4, 6, 8, 10]
    """
    require_direction(direction)
    if where is not None:
        return section_by_formula(
            lay_out_ensemble(system, drive, over, initial),
            where,
            direction,
            duration=duration,
            periods=periods,
            tolerance=tolerance,
            progress=progress,
        )
    _require_phase_only(duration)
    periods = require_count("periods", periods, "Sections are taken after whole drive periods.")
    every = require_count("every", every, "Points are whole drive periods apart.")
    section_phase = require_real("section_phase", section_phase, _SECTION_PHASE_RULE)
    tolerance = require_tolerance(tolerance, "the global error of the state")
    report = as_progress(progress)
    ens = lay_out_ensemble(system, drive, over, initial)
    length = require_drive_periods(ens)
    require_memory_for_samples("periods", ens, periods // every + 1)
    number = np.arange(0, periods + 1, every)
    number = number[number + section_phase <= periods]
    with np.errstate(invalid="ignore"):  # where the period is none, the status says so
        times = (number + section_phase) * length[:, None]
    problem = initial_value_problem(ens, periods * length)
    # At phase 0 points are ends of steps; elsewhere they are interpolated.
    request = Request(times=times) if section_phase else Request(strobe_cycles=every)
    outcome = integrate(problem, request, tolerance=tolerance, progress=report)
    states = blank_beyond_horizon(strobed_states(outcome, number.size), times, outcome)
    variables: dict[str, PerTrajectoryArray] = {
        name: (("period",), states[:, :, k]) for k, name in enumerate(ens.vector_field.state_names)
    }
    for name in ens.vector_field.observable_and_rate_names:
        variables[name] = (("period",), evaluate_observable(problem, name, times, states))
        if name not in ens.vector_field.state_names:
            variables[f"{name}_error"] = largest_observable_error(
                problem, name, times, states, outcome.error
            )
    variables["drive_period"] = length
    return to_dataset(
        ens,
        variables,
        coords={"period": (("period",), number)},
        outcome=outcome,
        tolerance=tolerance,
        periods=periods,
        every=every,
        section_phase=section_phase,
    )


def _require_phase_only(duration: object) -> None:
    """Refuse a duration where sections are taken after drive periods."""
    if duration is not None:
        raise InputError(
            "duration",
            must="be left out where there is no section `where`",
            got=duration,
            why="Points are taken once per period of the load.",
            fix="Pass periods=..., or a section as in where='x'.",
        )
