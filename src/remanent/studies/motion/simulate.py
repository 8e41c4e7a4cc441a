"""Time histories."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import require_increasing
from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray
from remanent.integrate.ensemble.ensemble import Progress, integrate
from remanent.integrate.ensemble.problem import Request
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectory, to_dataset
from remanent.studies.ensemble.durations import durations, require_one
from remanent.studies.ensemble.ensemble import Ensemble, Over, ensemble, problem, require_memory
from remanent.studies.ensemble.observables import observe

#: Points of the default time grid per unit of tau, and their least and largest number.
_PER_TAU, _FEWEST, _MOST = 20, 200, 20_000


def simulate(
    system: Actuator,
    drive: Drive,
    *,
    duration: float | None = None,
    periods: int | None = None,
    times: ArrayLike | None = None,
    initial: ArrayLike | None = None,
    over: Over | None = None,
    tolerance: float = 1e-9,
    progress: Progress | None = None,
) -> xr.Dataset:
    r"""Integrate the equation of motion and return the history.

    Parameters
    ----------
    system, drive
        What moves, and the magnetic load on it.
    duration
        Length of the run in units of tau.
    periods
        Length of the run in smallest periods of the load.
    times : array (time,)
        When the state is wanted: tau, increasing, not negative.  Exactly one of
        `duration`, `periods` and `times` must be given; the first two give a uniform
        grid from 0 to the end.
    initial : (stretch, rate), or both of each coordinate
        Rest, (1, 0), by default.  Internal variables and the temperature may follow; they
        start from 1 and from the actuator's temperature.
    over
        Values of numeric fields; they become dimensions of the result.
    tolerance
        Asked of the global error of the state, absolute.
    progress
        Called with the share of trajectories finished, in [0, 1].

    Returns
    -------
    xarray.Dataset
        The state (``stretch``, ``stretch_rate``, or those of two coordinates, internal
        variables, ``body_temperature``), ``thickness_stretch``,
        ``thickness_stretch_rate``, ``energy`` against ``time`` (dimensionless), NaN
        beyond the trusted horizon; ``error`` (estimated, absolute), ``horizon`` and
        ``status`` per trajectory.  Where lengths differ between trajectories the
        dimension is ``cycle`` and ``time`` has a value for each.

    Raises
    ------
    InputError
        A bad argument; the message says which and what to do.

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
    require_one(duration=duration, periods=periods, times=times)
    require_tolerance(tolerance)
    ens = ensemble(system, drive, over, initial)
    grid, shared = time_grid(ens, duration, periods, times)
    asked = problem(ens, np.maximum(grid[:, -1], np.finfo(float).tiny))
    outcome = integrate(asked, Request(times=grid), tolerance=tolerance, progress=progress)
    states = outcome.states
    assert states is not None
    states[grid > outcome.horizon[:, None] * (1 + 1e-12)] = np.nan
    axis = "time" if shared else "cycle"
    variables: dict[str, PerTrajectory] = {
        name: ((axis,), states[:, :, k]) for k, name in enumerate(ens.field.state)
    }
    for name in ("thickness_stretch", "thickness_stretch_rate", "energy"):
        variables[name] = ((axis,), observe(asked, name, grid, states))
    time: Labelled = (("time",), grid[0]) if shared else ((*ens.dims, "cycle"), ens.shaped(grid))
    return to_dataset(
        ens, variables, coords={"time": time}, outcome=outcome, tolerance=tolerance,
        duration=duration, periods=periods,
    )  # fmt: skip


def time_grid(ens: Ensemble, duration: Any, periods: Any, times: Any) -> tuple[FloatArray, bool]:
    """Times (trajectory, time), and whether all trajectories share them."""
    if times is not None:
        wanted = np.array(require_increasing("times", times))
        if wanted[0] < 0.0:
            raise InputError(
                "times",
                "not be negative",
                wanted[0],
                "The motion starts at tau = 0.",
                "Pass times from 0 on.",
            )
        require_memory(80.0 * ens.count * wanted.size, f"{ens.count} x {wanted.size} states")
        return np.tile(wanted, (ens.count, 1)), True
    end = durations(ens, duration, periods)
    longest = float(np.nanmax(np.where(ens.invalid, 0.0, end), initial=0.0))
    points = int(np.clip(np.ceil(_PER_TAU * longest), _FEWEST, _MOST)) + 1
    require_memory(80.0 * ens.count * points, f"{ens.count} x {points} states")
    shared = bool(np.all(end == end[0]))
    grid = np.linspace(0.0, 1.0, points) * end[:, None]
    grid[:, -1] = end
    return grid, shared
