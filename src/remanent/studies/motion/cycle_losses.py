"""What each drive period takes out of a motion and puts into it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from remanent._typing import ArrayLike
from remanent.integrate.ensemble.ensemble import Progress, integrate
from remanent.integrate.ensemble.problem import Request
from remanent.integrate.variations import with_integrals
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectory, to_dataset
from remanent.studies.ensemble.durations import require_count, require_periods
from remanent.studies.ensemble.ensemble import Over, ensemble, problem, require_memory

_POWERS = {"dissipated_energy": "dissipated_power", "drive_work": "drive_power"}


def cycle_losses(
    system: Actuator,
    drive: Drive,
    *,
    periods: int,
    discard: int = 0,
    initial: ArrayLike | None = None,
    over: Over | None = None,
    tolerance: float = 1e-9,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Energy dissipated, and work done by the load, in each drive period.

    Parameters
    ----------
    system, drive
        What moves, and a periodic load.
    periods
        Length of the run in smallest periods of the load.
    discard
        Periods at the beginning that are not returned.
    initial, over, progress
        As for :func:`remanent.simulate`.
    tolerance
        Asked of the global error of the state and of the integrals, absolute.

    Returns
    -------
    xarray.Dataset
        Along ``period``, the number of the period that ends, from 1: ``dissipated_energy``
        per reference volume and μ, and ``drive_work`` of the magnetic load.  Once the motion is
        periodic both are equal.  ``error``, ``horizon``, ``status``; NaN beyond the horizon.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    Notes
    -----
    The integrals of the dissipated power, Σ q' ∂D/∂q' + Σ 2η(ε̇₁² + ε̇₂² + (ε̇₁ + ε̇₂)²) over
    dashpots and branches, and of the load's power are advanced with the state.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.cycle_losses(
    ...     rm.Actuator(dissipation=rm.Zener(0.5, 1.0)),
    ...     rm.SineSquared(0.4, 1.25),
    ...     periods=60,
    ...     discard=59,
    ... )
    >>> bool(abs(ds.dissipated_energy - ds.drive_work) < 1e-3 * ds.dissipated_energy)
    True
    """
    periods = require_count("periods", periods, "Losses are counted in whole drive periods.")
    discard = require_count("discard", discard, "Losses are counted in whole periods.", 0)
    require_tolerance(tolerance)
    ens = ensemble(system, drive, over, initial)
    length = require_periods(ens)
    require_memory(100.0 * ens.count * periods, f"{ens.count} x {periods} periods")
    plain = problem(ens, periods * length)
    start = np.pad(plain.initial, ((0, 0), (0, len(_POWERS))))
    field = with_integrals(plain.field, tuple(_POWERS.values()))
    asked = replace(plain, field=field, initial=start)
    outcome = integrate(asked, Request(strobe=1), tolerance=tolerance, progress=progress)
    assert outcome.states is not None
    sums = outcome.states[:, : periods + 1, -len(_POWERS) :]
    ends = np.arange(periods + 1) * length[:, None]
    sums[ends > outcome.horizon[:, None] * (1 + 1e-12)] = np.nan
    each = np.diff(sums, axis=1)[:, discard:]
    variables: dict[str, PerTrajectory] = {
        name: (("period",), each[:, :, k]) for k, name in enumerate(_POWERS)
    }
    variables["drive_period"] = length
    coords: dict[str, Labelled] = {"period": (("period",), np.arange(discard + 1, periods + 1))}
    return to_dataset(
        ens, variables, coords=coords, outcome=outcome, tolerance=tolerance,
        periods=periods, discard=discard,
    )  # fmt: skip
