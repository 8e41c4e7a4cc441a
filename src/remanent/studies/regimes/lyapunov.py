"""Lyapunov exponents: how fast neighbouring motions part."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import shortened_repr
from remanent._errors import InputError
from remanent._typing import ArrayLike
from remanent.models.drives.base import Drive
from remanent.models.drives.loads import Loads
from remanent.models.drives.strobed import StrobedConstant
from remanent.models.drives.waves import Constant
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import DriveArgument, require_drive, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.durations import (
    require_count,
    require_drive_periods,
    require_duration,
    require_exactly_one_argument,
)
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import RESERVED_DIMENSIONS, OverArgument, lay_out_ensemble
from remanent.studies.ensemble.memory import require_memory
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.ensemble.quantities import without_unit
from remanent.studies.regimes._exponent_estimator import MAX_HISTORY_POINTS, ExponentEstimator
from remanent.studies.regimes._follower import (
    EnsembleFollower,
    missing_exponent_reasons,
    require_memory_for_runs,
)

#: Variables with a value for each exponent.
_EXPONENT_VARIABLE_NAMES = ("exponent", "exponent_error")
#: Fewest and most intervals of a run under a load that does not change; about one per tau.
_INTERVAL_COUNT_LIMITS = (200, 20_000)
#: Bytes that a run needs for each of its periods and each entry of the tangents' factors.
_BYTES_PER_PERIOD_AND_ENTRY = 16.0


def lyapunov(
    system: System,
    drive: DriveArgument,
    *,
    periods: int | None = None,
    duration: float | None = None,
    count: int = 1,
    initial: ArrayLike | None = None,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Average the growth of small differences over many drive periods.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load, or one that does not change.
    periods : int, optional
        Length of the run in smallest periods of the load.  The first tenth is left out of
        the average.
    duration : float, str or quantity, optional
        Length of the run in tau, under ``rm.Constant``: of systems without a load too.  With a
        unit, ``"60 ms"``, where the actuator has SI sizes.
    count : int
        How many exponents, the largest first; at most as many as there are state variables.
    initial : array_like (state,), optional
        State at τ = 0: stretch and rate of each coordinate in turn, to which internal variables
        and the temperature may be added; rest, (1, 0), by default.
    over : mapping of str to array_like or DataArray, optional
        Values of numeric fields of the system, the drive or the initial state; they become
        dimensions of the result.
    tolerance : float
        Bound of the absolute error that one drive period adds.  Where a state variable
        exceeds 10 the bound is relative to a tenth of it, so a body's temperature of 300 K
        is allowed 30 times as much.  Chaotic motion itself is known for a short time only;
        its statistics are those of a motion nearby.
    progress : bool or callable, optional
        True draws a bar; a function is called with the share of motions that are
        finished, in [0, 1].

    Returns
    -------
    xarray.Dataset
        Along the dimensions of `over`:

        ``exponent``, ``exponent_error``
            Per unit of τ, with a dimension ``exponent_number`` if `count` is above 1.  Where
            the motion is seen to end on a stable periodic orbit, from the multipliers of that
            orbit, with an estimate of their error; elsewhere the mean over the run.  Of regular
            motion, on a torus or still settling, its error is a bound: how far the growth
            swings about its trend, plus what of the mean may be growth in proportion to time,
            plus the difference from a run with steps twice as long; all three fall with the
            length of the run.  Of chaotic motion, where the mean exceeds that, it is a standard
            error, within which the true exponent lies 68 % of the time: by the swings of the
            growth and, in squares, the difference of the two runs.
        ``settled_period``
            Period of the orbit in drive periods, 0 where none is known.
        ``exponent_history``
            The mean up to each value of ``period``, or of ``time`` under a load that does not
            change: it shows how the mean settles and has no error of its own.
        ``drive_period``, ``horizon``, ``local_error``, ``status``, ``reason``
            The load's period, exact but for rounding; how long the motion itself is known to
            0.01, and the largest error of one period, which are themselves estimates of errors;
            and what became of the run: ``incomplete`` where differences shrink within one
            period to less than any number can tell, so that the exponent is NaN, as
            ``reason`` says.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    See Also
    --------
    remanent.classify : Regimes, by this and other evidence.
    remanent.periodic_orbits : Multipliers of closed orbits, which need no average.

    Notes
    -----
    Tangents obey w' = J w along the motion and are made orthonormal again after every few
    periods (W = Q R); the exponent of direction j is the mean of ln R[j, j] over time.
    Source: G. Benettin et al., Meccanica 15 (1980) 9.  With few periods, ``exponent_error``
    is infinite: there are no batches to compare.  On a periodic orbit of n drive periods the
    exponents are the logarithms of the sizes of its Floquet multipliers over its length; orbit
    and multipliers are computed with steps of two lengths, whose difference is the error.

    Examples
    --------
    An undamped torus has exponent 0:

    >>> import remanent as rm
    >>> ds = rm.lyapunov(rm.Actuator(), rm.SineSquared(0.4, 1.25), periods=100)
    >>> bool(abs(ds.exponent) < 3 * ds.exponent_error + 0.05)
    True
    """
    require_exactly_one_argument(periods=periods, duration=duration)
    count = require_count("count", count, "It is a number of exponents.")
    tolerance = require_tolerance(tolerance, "the error that one drive period adds")
    drive = strobed = require_drive(drive)
    interval = 1.0
    if duration is not None:
        length = without_unit("duration", duration, "time", system)
        strobed, interval, periods = _strobed(drive, length)
    periods = require_count("periods", periods, "Exponents are averaged over whole drive periods.")
    ens = lay_out_ensemble(
        system, strobed, over, initial, reserved=RESERVED_DIMENSIONS | {"exponent_number"}
    )
    period_lengths = require_drive_periods(ens)
    _require_exponent_count(count, ens)
    needed = 8.0 * ens.trajectory_count * count * (min(periods, MAX_HISTORY_POINTS) + 3)
    require_memory("over", needed, f"{ens.trajectory_count} histories")
    require_memory_for_runs(ens, periods, _BYTES_PER_PERIOD_AND_ENTRY * (1 + count**2))
    estimator = ExponentEstimator(EnsembleFollower(ens, periods, count), tolerance)
    values = estimator.follower.compute_in_chunks(
        estimator, estimator.result_templates, as_progress(progress)
    )
    number: tuple[str, ...] = ("exponent_number",) if count > 1 else ()
    variables: dict[str, PerTrajectoryArray] = {
        "drive_period": period_lengths,
        "reason": missing_exponent_reasons(values["exponent"], values["status"]),
    }
    for name in _EXPONENT_VARIABLE_NAMES:
        variables[name] = (number, _drop_single_exponent_axis(values.pop(name)))
    history = _drop_single_exponent_axis(values.pop("exponent_history"))
    along = "period" if duration is None else "time"
    variables["exponent_history"] = ((along, *number), history)
    passed: np.ndarray[Any, Any] = estimator.history_periods
    if duration is not None:
        passed = passed * interval
        del variables["drive_period"], values["settled_period"]
        ens = replace(ens, drive=drive)
    coords: dict[str, Labelled] = {along: ((along,), passed)}
    if count > 1:
        coords["exponent_number"] = (number, np.arange(count))
    return to_dataset(
        ens,
        variables | values,
        coords=coords,
        tolerance=tolerance,
        periods=periods if duration is None else None,
        duration=duration,
        count=count,
    )


def _strobed(drive: Drive, duration: object) -> tuple[Drive, float, int]:
    """Loads that do not change in intervals, the length of these and how many there are."""
    length = require_duration(duration)
    drives = drive.parts() if isinstance(drive, Loads) else {"load": drive}
    loads = {name: one.m for name, one in drives.items() if isinstance(one, Constant)}
    if len(loads) < len(drives):
        raise InputError(
            "duration",
            must="be left out where the load changes",
            got=shortened_repr(drive),
            why="Exponents are averaged over whole periods of the load.",
            fix="Pass periods=..., or rm.Constant(...) for a system without a load.",
        )
    intervals = int(np.clip(np.ceil(length), *_INTERVAL_COUNT_LIMITS))
    strobed = {name: StrobedConstant(m, length / intervals) for name, m in loads.items()}
    several = isinstance(drive, Loads)
    return Loads(strobed) if several else strobed["load"], length / intervals, intervals


def _require_exponent_count(count: int, ens: Ensemble) -> None:
    dimension = len(ens.vector_field.state_names)
    if count > dimension:
        raise InputError(
            "count",
            must=f"be at most {dimension}",
            got=count,
            why="There is one exponent for each state variable.",
            fix=f"Pass {dimension} for the whole spectrum.",
        )


def _drop_single_exponent_axis(values: np.ndarray) -> Any:
    """Values (..., exponent); without that dimension where there is one exponent."""
    return values[..., 0] if values.shape[-1] == 1 else values
