"""Whether equal in-plane stretches stay equal: the growth of their difference."""

from __future__ import annotations

import numpy as np
import xarray as xr

from remanent._typing import ArrayLike
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import DriveArgument, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.durations import require_count, require_drive_periods
from remanent.studies.ensemble.layout import RESERVED_DIMENSIONS, OverArgument, lay_out_ensemble
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.regimes._follower import EnsembleFollower, require_memory_for_runs
from remanent.studies.regimes._transverse import TransverseFlow

#: Shorter runs cannot tell growth like a power of time from an exponential one.
_MIN_PERIODS = 50
#: Bytes that a run needs for each of its periods: the tangents' factors, two by two, and copies.
_BYTES_PER_PERIOD = 128.0


def symmetry_check(
    system: System,
    drive: DriveArgument,
    *,
    periods: int = 200,
    initial: ArrayLike | None = None,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Say whether the model of one coordinate holds: whether equal stretches stay equal.

    Parameters
    ----------
    system : System
        With equal dead loads and edges, of one coordinate.
    drive : Drive, or mapping of str to Drive
        A periodic load.
    periods : int
        Length of the run in smallest periods of the load, at least 50.
    initial : array (state,), optional
        State at τ = 0, (stretch, rate) of the one coordinate; rest by default.
    over : mapping of str to array_like or DataArray, optional
        Values of numeric fields of the system, the drive or the initial state; they become
        dimensions of the result.
    tolerance : float
        Bound of the error that one drive period adds.
    progress : bool or callable, optional
        True draws a bar; a function is called with the share of motions that are
        finished, in [0, 1].

    Returns
    -------
    xarray.Dataset
        Along the dimensions of `over`:

        ``symmetry``
            ``kept``, ``lost`` or ``undecided``.
        ``transverse_growth``
            The logarithm of the growth of a difference λ₁ − λ₂ over the run, the largest of
            all directions and times.  It says what happened in this run and has no error of
            its own: its digits are those of ``local_error`` over the size 0.001 of a difference.
        ``settled_period``
            Of the periodic orbit that the motion starts on or settles on, in drive periods; 0
            where there is none.
        ``transverse_exponent``, ``transverse_exponent_error``
            The growth of the difference per unit of τ: that of the orbit, from its multipliers;
            without an orbit its mean over the second half of the run, with a standard error.
        ``transverse_multipliers``, ``transverse_multipliers_error``
            The Floquet multipliers of the difference over the period of the orbit, largest
            first, and their estimated errors; NaN without an orbit.
        ``drive_period``, ``local_error``, ``status``
            The load's period, the largest error of one period, and what became of the run.

    Raises
    ------
    InputError
        A bad argument, a load without a period, or an actuator of two coordinates.

    See Also
    --------
    remanent.simulate : The motion with both coordinates, ``prestress=(S, S)``.

    Notes
    -----
    The equations of both coordinates are linearised about the motion with λ₁ = λ₂; the
    difference a of the stretches obeys
    a'' = −{3[θ(1 + λ⁻⁶) − mλ⁻⁴] + c λ⁻⁴ (λ⁻²)''} a without dissipation, and differences of
    viscous stretches follow it.  It is parametrically driven: the
    symmetry is lost in tongues, at resonance with half the drive's frequency or the
    motion's above all.  Nothing else than the growth of small differences is looked at; the
    run itself stays symmetric.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.symmetry_check(rm.Actuator(), rm.SineSquared(0.4, 2.0))
    >>> str(ds.symmetry.values)
    'kept'
    """
    periods = require_count("periods", periods, "Growth shows in a long run.", _MIN_PERIODS)
    tolerance = require_tolerance(tolerance, "the error that one drive period adds")
    ens = lay_out_ensemble(
        system, drive, over, initial, reserved=RESERVED_DIMENSIONS | {"multiplier"}
    )
    period_lengths = require_drive_periods(ens)
    flow = TransverseFlow.from_ensemble(ens, tolerance)
    require_memory_for_runs(ens, periods, _BYTES_PER_PERIOD)
    follower = EnsembleFollower(ens, periods, 0)
    values = follower.compute_in_chunks(
        lambda indices: flow.examine_growth(indices, periods, follower),
        flow.result_templates,
        as_progress(progress),
    )
    multipliers: dict[str, PerTrajectoryArray] = {
        name: (("multiplier",), values.pop(name))
        for name in ("transverse_multipliers", "transverse_multipliers_error")
    }
    coords: dict[str, Labelled] = {
        "multiplier": (("multiplier",), np.arange(flow.difference_dimension))
    }
    return to_dataset(
        ens,
        {"drive_period": period_lengths, **multipliers, **values},
        coords=coords,
        tolerance=tolerance,
        periods=periods,
    )
