"""Poincaré sections: the state once per so many drive periods."""

from __future__ import annotations

import numpy as np
import xarray as xr

from remanent._checks import Rule, require_real
from remanent._typing import ArrayLike
from remanent.integrate.ensemble.ensemble import Progress, integrate
from remanent.integrate.ensemble.problem import Request
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectory, to_dataset
from remanent.studies.ensemble.durations import require_count, require_periods
from remanent.studies.ensemble.ensemble import Over, ensemble, problem, require_memory
from remanent.studies.ensemble.observables import observe

_PHASE = Rule(
    "lie in [0, 1)",
    lambda x: np.asarray((x >= 0.0) & (x < 1.0)),
    "It is the fraction of a drive period at which the state is taken.",
    "Pass 0 for the beginning of each period.",
)


def poincare_section(
    system: Actuator,
    drive: Drive,
    *,
    periods: int,
    every: int = 1,
    section_phase: float = 0.0,
    initial: ArrayLike | None = None,
    over: Over | None = None,
    tolerance: float = 1e-9,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Take the state once per `every` drive periods.

    Parameters
    ----------
    system, drive
        What moves, and a periodic load.
    periods
        Length of the run in smallest periods of the load.
    every
        Periods between points.  The flux b sin(ωτ) repeats at every second period of
        its square: pass 2 to strobe at the period of the flux.
    section_phase
        Fraction of a period, in [0, 1), at which the state is taken.
    initial, over, tolerance, progress
        As for :func:`remanent.simulate`.

    Returns
    -------
    xarray.Dataset
        ``stretch``, ``stretch_rate``, ``thickness_stretch``,
        ``thickness_stretch_rate`` against ``period`` (the number of whole periods
        before each point: 0, every, 2 every ...), NaN beyond the trusted horizon;
        ``drive_period``, ``error``, ``horizon``, ``status`` per trajectory.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

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
    periods = require_count("periods", periods, "Sections are taken after whole drive periods.")
    every = require_count("every", every, "Points are whole drive periods apart.")
    section_phase = require_real("section_phase", section_phase, _PHASE)
    require_tolerance(tolerance)
    ens = ensemble(system, drive, over, initial)
    length = require_periods(ens)
    points = periods // every + 1
    require_memory(80.0 * ens.count * points, f"{ens.count} x {points} states")
    number = np.arange(0, periods + 1, every)
    if section_phase:
        number = number[number + section_phase <= periods]
    asked = problem(ens, periods * length)
    with np.errstate(invalid="ignore"):  # where the period is none, the status says so
        times = (number + section_phase) * length[:, None]
    request = Request(times=times) if section_phase else Request(strobe=every)
    outcome = integrate(asked, request, tolerance=tolerance, progress=progress)
    assert outcome.states is not None
    states = outcome.states[:, : number.size]
    states[times > outcome.horizon[:, None] * (1 + 1e-12)] = np.nan
    variables: dict[str, PerTrajectory] = {
        name: (("period",), states[:, :, k]) for k, name in enumerate(ens.field.state)
    }
    for name in ("thickness_stretch", "thickness_stretch_rate"):
        variables[name] = (("period",), observe(asked, name, times, states))
    variables["drive_period"] = length
    coords: dict[str, Labelled] = {"period": (("period",), number)}
    return to_dataset(
        ens, variables, coords=coords, outcome=outcome, tolerance=tolerance,
        periods=periods, every=every, section_phase=section_phase,
    )  # fmt: skip
