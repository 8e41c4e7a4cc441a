"""The balance of energy: work of the drive, dissipation, and averages along a motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from remanent._typing import ArrayLike, FloatArray
from remanent.integrate.ensemble.ensemble import Progress, integrate
from remanent.integrate.ensemble.problem import Request
from remanent.integrate.variations import with_integrals
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectory, to_dataset
from remanent.studies.ensemble.durations import require_one
from remanent.studies.ensemble.ensemble import Over, ensemble, problem
from remanent.studies.ensemble.observables import observe
from remanent.studies.motion.simulate import time_grid

#: What is integrated along a motion, and the name of the integral.
_INTEGRALS = {
    "thickness_stretch": "mean_thickness_stretch",
    "drive_power": "drive_work",
    "dissipated_power": "dissipated_energy",
}
_OF_HEAT = {
    "heat_flow": "heat_given_off",
    "entropy_flow": "entropy_given_off",
    "entropy_production": "entropy_produced",
}


def energy_balance(
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
    """Follow the work of the drive and what is dissipated, beside the energy of the block.

    Parameters
    ----------
    system, drive, duration, periods, times, initial, over, progress
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
        average since τ = 0.  With a heat balance ``stored_energy`` is the internal energy
        and the kinetic, and the balance has ``heat_given_off`` to the surroundings in place
        of the dissipation, which stays in the body; in units of μ/T0 also its ``entropy``,
        ``entropy_produced`` within and by the exchange, ``entropy_given_off``, and
        ``entropy_balance`` = change of the entropy − production + what was given off.
        ``error``, ``horizon``, ``status`` per trajectory.

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
    ens = ensemble(system, drive, over, initial)
    grid, shared = time_grid(ens, duration, periods, times)
    plain = problem(ens, np.maximum(grid[:, -1], np.finfo(float).tiny))
    names = _INTEGRALS | (_OF_HEAT if system.heat is not None else {})
    start = np.pad(plain.initial, ((0, 0), (0, len(names))))
    asked = replace(plain, field=with_integrals(plain.field, tuple(names)), initial=start)
    outcome = integrate(asked, Request(times=grid), tolerance=tolerance, progress=progress)
    states = outcome.states
    assert states is not None
    states[grid > outcome.horizon[:, None] * (1 + 1e-12)] = np.nan
    sums = np.moveaxis(states[:, :, -len(names) :], 2, 0)
    found = dict(zip(names.values(), sums, strict=True))

    def gained(name: str) -> FloatArray:
        """What a function of the state has gained since the start."""
        before = observe(asked, name, np.zeros((ens.count, 1)), asked.initial[:, None])
        return observe(asked, name, grid, states) - before

    at_first = observe(asked, "thickness_stretch", grid, states)
    with np.errstate(all="ignore"):
        found["mean_thickness_stretch"] = np.where(
            grid > 0.0, found["mean_thickness_stretch"] / grid, at_first
        )
    found["stored_energy"] = observe(asked, "stored_energy", grid, states)
    left = found["dissipated_energy" if system.heat is None else "heat_given_off"]
    found["balance"] = gained("stored_energy") - found["drive_work"] + left
    if system.heat is not None:
        found["entropy"] = observe(asked, "entropy", grid, states)
        inner = gained("entropy") - found["entropy_produced"]
        found["entropy_balance"] = inner + found["entropy_given_off"]
    axis = "time" if shared else "cycle"
    variables: dict[str, PerTrajectory] = {name: ((axis,), v) for name, v in found.items()}
    time: Labelled = (("time",), grid[0]) if shared else ((*ens.dims, "cycle"), ens.shaped(grid))
    return to_dataset(
        ens, variables, coords={"time": time}, outcome=outcome, tolerance=tolerance,
        duration=duration, periods=periods,
    )  # fmt: skip
