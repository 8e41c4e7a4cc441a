"""What each drive period takes out of a motion and puts into it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from remanent._typing import ArrayLike
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import ERROR_SHARE_IN_FUNCTIONS, Request
from remanent.integrate.variations import field_with_integrals
from remanent.models.system import System
from remanent.studies.ensemble.checks import DriveArgument, require_energy, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.durations import require_count, require_drive_periods
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.memory import require_memory
from remanent.studies.ensemble.observables import blank_beyond_horizon
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.motion._strobed_states import strobed_states

#: Bytes that a period of one trajectory takes.
_BYTES_PER_PERIOD = 100.0
#: The integral over each period, and what is integrated.
_POWER_OBSERVABLE_OF_ENERGY = {"dissipated_energy": "dissipated_power", "drive_work": "drive_power"}


def cycle_losses(
    system: System,
    drive: DriveArgument,
    *,
    periods: int,
    discard: int = 0,
    initial: ArrayLike | None = None,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Energy dissipated, and work done by the load, in each drive period.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load.
    periods : int
        Length of the run in smallest periods of the load.
    discard : int
        Periods at the beginning that are not returned.
    initial : array_like (2,), (4,) or (state,), optional
        State to start from; rest by default, as for :func:`remanent.simulate`.
    over : mapping of str to array_like or DataArray, optional
        Values of numeric fields; they become dimensions of the result.
    tolerance : float
        Largest error of the state and of the integrals that is allowed, at any of the times;
        absolute.
    progress : bool or callable, optional
        True draws a bar; a function is called with the share that is done.

    Returns
    -------
    xarray.Dataset
        Along ``period``, the number of the period that ends, from 1: ``dissipated_energy``
        per reference volume and μ, and ``drive_work`` of the magnetic load.  Once the motion is
        periodic both are equal.  Per trajectory ``dissipated_energy_error`` and
        ``drive_work_error``, the largest over the periods; ``error``, the largest of the state
        and of the sums since τ = 0; ``drive_period``, exact but for rounding, ``horizon``,
        ``status``; NaN beyond the horizon.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    See Also
    --------
    energy_balance : The same work and dissipation against time.

    Notes
    -----
    The integrals of the dissipated power, Σ q' ∂D/∂q' + Σ 2η(ε̇₁² + ε̇₂² + (ε̇₁ + ε̇₂)²) over
    dashpots and branches, and of the load's power are advanced with the state.  Where the
    temperature of the magnet is a state, the load's power is that of
    :func:`remanent.energy_balance`.

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
    tolerance = require_tolerance(tolerance, "the global error of the state and of the integrals")
    report = as_progress(progress)
    ens = lay_out_ensemble(system, drive, over, initial)
    require_energy(ens)
    length = require_drive_periods(ens)
    require_memory(
        "periods",
        _BYTES_PER_PERIOD * ens.trajectory_count * periods,
        f"{ens.trajectory_count} x {periods} sums",
    )
    problem = initial_value_problem(ens, periods * length)
    start = np.pad(problem.initial_states, ((0, 0), (0, len(_POWER_OBSERVABLE_OF_ENERGY))))
    field = field_with_integrals(problem.field, tuple(_POWER_OBSERVABLE_OF_ENERGY.values()))
    problem = replace(problem, field=field, initial_states=start)
    outcome = integrate(problem, Request(strobe_cycles=1), tolerance=tolerance, progress=report)
    with np.errstate(invalid="ignore"):  # of points without a period
        ends = np.arange(periods + 1) * length[:, None]
    sums = strobed_states(outcome, periods + 1)[:, :, -len(_POWER_OBSERVABLE_OF_ENERGY) :]
    losses = np.diff(blank_beyond_horizon(sums, ends, outcome), axis=1)[:, discard:]
    variables: dict[str, PerTrajectoryArray] = {
        name: (("period",), losses[:, :, k]) for k, name in enumerate(_POWER_OBSERVABLE_OF_ENERGY)
    }
    # Each is a difference of two sums, whose errors are much the same.
    error = ERROR_SHARE_IN_FUNCTIONS * outcome.error
    variables |= {f"{name}_error": error for name in _POWER_OBSERVABLE_OF_ENERGY}
    variables["drive_period"] = length
    return to_dataset(
        ens,
        variables,
        coords={"period": (("period",), np.arange(discard + 1, periods + 1))},
        outcome=outcome,
        tolerance=tolerance,
        periods=periods,
        discard=discard,
    )
