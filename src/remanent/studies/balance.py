"""The balance of energy: work of the drive, dissipation, and averages along a motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from remanent._typing import ArrayLike
from remanent.integrate.ensemble import Progress, integrate
from remanent.integrate.problem import Request
from remanent.integrate.variations import with_integrals
from remanent.models.actuator import Actuator
from remanent.models.drives import Drive
from remanent.results.build import Labelled
from remanent.studies._checks import require_tolerance
from remanent.studies._ensemble import Over, ensemble, problem
from remanent.studies._label import label
from remanent.studies._observe import observe
from remanent.studies._time import require_one
from remanent.studies.simulate import time_grid

_INTEGRALS = ("drive_power", "dissipated_power", "thickness_stretch")


def energy_balance(
    actuator: Actuator,
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
    """Follow the work of the drive and what is dissipated, beside the energy of the block.

    Parameters
    ----------
    actuator, drive, duration, periods, times, initial, over, progress
        As for :func:`remanent.simulate`.
    tolerance
        Asked of the global error of the state and of the integrals, absolute.

    Returns
    -------
    xarray.Dataset
        Against ``time``, per reference volume and μ: ``stored_energy`` (kinetic, elastic
        and of the dead loads, without that in the field), ``drive_work`` and
        ``dissipated_energy`` since τ = 0, ``balance`` = change of the stored energy − work
        + dissipation, which is zero but for the error; ``mean_thickness_stretch``, the
        average since τ = 0.  ``error``, ``horizon``, ``status`` per trajectory.

    Raises
    ------
    InputError
        A bad argument; the message says which and what to do.

    Notes
    -----
    The integrals are advanced with the state, by the same steps and under the same error
    bound; nothing is summed from samples.  Work and dissipation per cycle are differences
    over a drive period.

    Examples
    --------
    >>> import remanent as rm
    >>> damped = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    >>> ds = rm.energy_balance(damped, rm.SineSquared(0.4, 1.25), periods=50)
    >>> bool(abs(ds.balance).max() < 1e-8)
    True
    """
    require_one(duration=duration, periods=periods, times=times)
    require_tolerance(tolerance)
    ens = ensemble(actuator, drive, over, initial)
    grid, shared = time_grid(ens, duration, periods, times)
    plain = problem(ens, np.maximum(grid[:, -1], np.finfo(float).tiny))
    start = np.pad(plain.initial, ((0, 0), (0, len(_INTEGRALS))))
    asked = replace(plain, field=with_integrals(plain.field, _INTEGRALS), initial=start)
    outcome = integrate(asked, Request(times=grid), tolerance=tolerance, progress=progress)
    states = outcome.states
    assert states is not None
    states[grid > outcome.horizon[:, None] * (1 + 1e-12)] = np.nan
    stored = observe(asked, "stored_energy", grid, states)
    before = observe(asked, "stored_energy", np.zeros((ens.count, 1)), asked.initial[:, None])
    work, lost, total = np.moveaxis(states[:, :, -len(_INTEGRALS) :], 2, 0)
    at_first = observe(asked, "thickness_stretch", grid, states)
    with np.errstate(all="ignore"):
        mean = np.where(grid > 0.0, total / grid, at_first)
    found = {
        "stored_energy": stored,
        "drive_work": work,
        "dissipated_energy": lost,
        "balance": stored - before - work + lost,
        "mean_thickness_stretch": mean,
    }
    axis = "time" if shared else "cycle"
    variables: dict[str, Labelled] = {
        name: ((*ens.dims, axis), ens.shaped(values)) for name, values in found.items()
    }
    time: Labelled = (("time",), grid[0]) if shared else ((*ens.dims, "cycle"), ens.shaped(grid))
    settings = {"duration": duration, "periods": periods}
    return label(ens, outcome, variables, {"time": time}, tolerance, **settings)
