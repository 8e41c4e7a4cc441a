"""Time histories."""

from __future__ import annotations

import numpy as np
import xarray as xr

from remanent._typing import ArrayLike
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.models.system import System
from remanent.studies.ensemble.checks import DriveArgument, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.durations import require_exactly_one_argument
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.observables import (
    blank_beyond_horizon,
    evaluate_observable,
    largest_observable_error,
)
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.ensemble.quantities import without_unit
from remanent.studies.ensemble.time_grid import time_grid


def simulate(
    system: System,
    drive: DriveArgument,
    *,
    duration: float | None = None,
    periods: int | None = None,
    times: ArrayLike | None = None,
    initial: ArrayLike | None = None,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    r"""Integrate the equation of motion and return the history.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        The magnetic load on it.
    duration : float, str or quantity, optional
        Length of the run in units of tau; with a unit, ``"60 ms"``, where
        the actuator has SI sizes.
    periods : int, optional
        Length of the run in smallest periods of the load.
    times : array_like (time,), optional
        When the state is returned: tau, increasing, not negative.  Exactly one of
        `duration`, `periods` and `times` must be given; the first two give a uniform
        grid from 0 to the end.
    initial : array_like (2,), (4,) or (state,), optional
        Stretch and rate, of each coordinate in turn; rest, (1, 0), by default.  Internal
        variables and the temperature may follow; they start from 1 and from the actuator's
        temperature.
    over : mapping of str to array_like or DataArray, optional
        Values of numeric fields; they become dimensions of the result.
    tolerance : float
        Largest error of the state that is allowed, at any of the times; absolute.
    progress : bool or callable, optional
        True draws a bar; a function is called with the share of trajectories that are
        finished, in [0, 1].

    Returns
    -------
    xarray.Dataset
        The state (``stretch``, ``stretch_rate``, or those of two coordinates, internal
        variables, ``body_temperature``), ``thickness_stretch``,
        ``thickness_stretch_rate``, ``energy`` and the magnetic ``load`` against ``time``
        (dimensionless), NaN beyond the trusted horizon.  Per trajectory ``error`` (estimated,
        absolute, of each state variable), ``thickness_stretch_error``,
        ``thickness_stretch_rate_error`` and ``energy_error``, what it makes of these, each the
        largest over the times; ``horizon`` and ``status``.  The load is exact but for rounding.
        Where lengths differ between trajectories the dimension is ``cycle`` and ``time`` has a
        value for each.

    Raises
    ------
    InputError
        A bad argument; the message says which and what to do.

    See Also
    --------
    poincare_section : The state once per period, for long runs.
    energy_balance : The work of the load and what is dissipated, with the motion.
    crossings : When a quantity passes through a value.

    Notes
    -----
    Solves M(λ)λ'' − 6cλ⁻⁷λ'² + 3[θ(λ − λ⁻⁵) − S + mλ⁻³] = 0 and its generalisations
    [Thermal, eq. 16].

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.simulate(rm.Actuator(temperature=350), rm.Constant(0.16), duration=20)
    >>> float(ds.thickness_stretch.max().round(4))
    1.0948
    """
    require_exactly_one_argument(duration=duration, periods=periods, times=times)
    tolerance = require_tolerance(tolerance, "the global error of the state")
    report = as_progress(progress)
    ens = lay_out_ensemble(system, drive, over, initial)
    duration = without_unit("duration", duration, "time", system)
    grid = time_grid(ens, duration, periods, times)
    problem = initial_value_problem(ens, grid.durations)
    request = Request(times=grid.times)
    outcome = integrate(problem, request, tolerance=tolerance, progress=report)
    assert outcome.states is not None
    states = blank_beyond_horizon(outcome.states, grid.times, outcome)
    variables: dict[str, PerTrajectoryArray] = {
        name: ((grid.time_dimension,), states[:, :, k])
        for k, name in enumerate(ens.vector_field.state_names)
    }
    field = ens.vector_field
    for name in dict.fromkeys(
        (*field.observable_and_rate_names, *field.energy_names, *field.load_names)
    ):
        values = evaluate_observable(problem, name, grid.times, states)
        # The load does not depend on the state: without this it would go on past the horizon.
        values = np.where(np.isnan(states[:, :, 0]), np.nan, values)
        variables[name] = ((grid.time_dimension,), values)
        if name != "load":
            variables[f"{name}_error"] = largest_observable_error(
                problem, name, grid.times, states, outcome.error
            )
    return to_dataset(
        ens,
        variables,
        coords={"time": grid.time_coordinate(ens)},
        outcome=outcome,
        tolerance=tolerance,
        duration=duration,
        periods=periods,
    )
