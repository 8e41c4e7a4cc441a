"""Frequency response: the largest excursion of the thickness stretch against ω."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._checks import not_negative_rule, positive_rule, require_increasing, require_real
from remanent._errors import InputError
from remanent._status import Status
from remanent._typing import ArrayLike, FloatArray, IntArray
from remanent.analysis.response.subdivision import BracketedMaxima, refine_maxima
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import (
    EXTREME_NAMES,
    Outcome,
    Request,
    merge_outcomes,
)
from remanent.integrate.ensemble.progress import report_part_of_whole
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import (
    DriveArgument,
    require_drive,
    require_drive_frequency,
    require_tolerance,
)
from remanent.studies.ensemble.dataset import to_dataset
from remanent.studies.ensemble.durations import (
    DEFAULT_RESPONSE_DURATION_IN_TAU,
    require_drive_periods,
    require_exactly_one_argument,
    trajectory_durations,
)
from remanent.studies.ensemble.ensemble import TRAJECTORIES_PER_BATCH, Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble, require_over
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.progress import ProgressArgument, ProgressFunction, as_progress
from remanent.studies.ensemble.quantities import without_unit

_RESONANCE_WIDTH_RULE = positive_rule(
    "It is the width of the last bracket.", "Pass for example 1e-6."
)
#: Words for a resonance that is missing.
_AT_END_REASON = "the amplitude is largest at an end of the range of omega: no peak inside"
_FLAT_REASON = "the amplitude does not rise above its error to a peak inside the range of omega"
_NO_REASON = "no amplitude is known"
_LONG_REASON = (
    "the search for the resonance takes too many steps: runs at these frequencies have too many "
    "periods, and the bracket is as wide as its error tells"
)
#: Steps for which the resonance of one combination of the fields is searched, and about how many a
#: run takes in each of its periods, and in each unit of time.
_MOST_STEPS_OF_SEARCH = 1e8
_STEPS_PER_PERIOD, _STEPS_PER_TIME = 64.0, 25.0
_DISCARD_RULE = not_negative_rule("It is the time before the window.", "Pass 0 to start at once.")


def frequency_response(
    system: System,
    drive: DriveArgument,
    omega: ArrayLike,
    *,
    duration: float | None = None,
    periods: int | None = None,
    discard: float = 0.0,
    initial: ArrayLike | None = None,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
    resonance_width: float = 1e-6,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Amplitude of the thickness stretch for each drive frequency.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A load with a field ``omega``, whose value is not used.
    omega : array (omega,)
        Drive frequencies, radians per unit of tau, or with a unit, ``["820 Hz", "920 Hz"]``,
        where the actuator has SI sizes; increasing, positive.
    duration : float, str or quantity, optional
        Length of each run in tau, 100 by default; with a unit, ``"60 ms"``, where
        the actuator has SI sizes.
    periods : int, optional
        Length of each run in drive periods, in place of `duration`.
    discard : float, str or quantity
        Time at the beginning that does not count, as `duration`.
    initial : array_like (state,), optional
        State at the start; rest by default.
    over : mapping of name to values, optional
        Values of other numeric fields; they become dimensions of the result.
    tolerance : float
        Of the error of the extremes.
    resonance_width : float
        Width of the last bracket of ``resonance``.  The error of the amplitudes hides the top of
        a smooth peak: about it they are computed with a smaller tolerance, where that is needed
        and possible.
    progress : bool or callable, optional
        True draws a bar; a callable is called with the share of the runs that are finished.

    Returns
    -------
    xarray.Dataset
        ``amplitude`` = (maximum − minimum)/2, ``maximum`` and ``minimum`` of the
        thickness stretch λ₃ over the window, between steps as well as at them, with
        ``amplitude_error``; ``maximum_time`` and ``minimum_time``, when they occur, of extremes
        that are equal but for their error any, so that times have no error of their own;
        ``resonance``, the ω of the largest amplitude between the
        first and last `omega`, found by repeated subdivision, and its
        ``resonance_amplitude``, with errors.  Where there is no peak inside they are NaN,
        ``resonance_status`` is ``incomplete``, and ``reason`` says why.  So it is where runs are
        too long to search as closely as `resonance_width`: ``resonance_error`` tells how closely.
        ``error``, ``horizon``, ``status``.  A point whose error bound could not be
        met to the end is NaN.

    Raises
    ------
    InputError
        A bad argument, or a drive without ``omega``.

    See Also
    --------
    response_diagram : The periodic orbits behind the response, stable and unstable.
    manifold_crossing : Where it jumps.

    Notes
    -----
    The response from rest is not smooth in ω: it jumps where the initial state crosses
    the stable manifold of a saddle orbit, and beside the jump it has ripples, one for each
    oscillation that the motion stays near the saddle, ever narrower towards it.  So the maximum is
    found by subdivision.  Its error is the distance to the nearest frequencies whose amplitudes are
    surely smaller, by more than both errors; where ripples are left that might be higher it
    reaches as far as these, and the error of the amplitude is as large as they might be.  Maxima
    that only their errors make equal are computed again with smaller tolerances.

    Examples
    --------
    >>> import numpy as np, remanent as rm
    >>> hot = rm.Actuator(temperature=350)
    >>> ds = rm.frequency_response(hot, rm.SineSquared(0.4, 1.0), np.linspace(1, 1.5, 101))
    >>> round(float(ds.resonance), 2)
    1.25
    """
    if periods is None and duration is None:
        duration = DEFAULT_RESPONSE_DURATION_IN_TAU
    require_exactly_one_argument(duration=duration, periods=periods)
    tolerance = require_tolerance(tolerance, "the error of the extremes")
    duration = without_unit("duration", duration, "time", system)
    discard = require_real(
        "discard", without_unit("discard", discard, "time", system), _DISCARD_RULE
    )
    resonance_width = require_real("resonance_width", resonance_width, _RESONANCE_WIDTH_RULE)
    require_over(over)
    drive = require_drive(drive)
    grid = _require_frequencies(system, drive, omega, over)
    ens = lay_out_ensemble(system, drive, {**(over or {}), "omega": grid}, initial)

    def respond(
        runs: Ensemble, tolerance: float, first_resolution: IntArray | None = None
    ) -> Outcome:
        return thickness_extremes_over_window(
            runs, duration, periods, discard, tolerance, first_resolution=first_resolution,
            progress=as_progress(progress) if runs is ens else None,
        )  # fmt: skip

    def lengths(runs: Ensemble) -> FloatArray:
        return trajectory_durations(runs, duration, periods)

    outcome = respond(ens, tolerance)
    amplitude = _amplitude(outcome)
    peak = _find_resonance(
        ens, grid, amplitude, outcome, respond, lengths, tolerance, resonance_width
    )
    columns = {"amplitude": amplitude} | {name: getattr(outcome, name) for name in EXTREME_NAMES}
    return to_dataset(
        ens,
        columns,
        shared=_resonance_variables(ens, peak),
        outcome=outcome,
        error="amplitude_error",
        tolerance=tolerance,
        duration=duration,
        periods=periods,
        discard=discard,
    )


def _require_frequencies(
    system: System, drive: Drive, omega: ArrayLike, over: OverArgument | None
) -> FloatArray:
    require_drive_frequency(drive, "A frequency response varies the frequency of the drive.")
    if over and "omega" in over:
        raise InputError(
            "over",
            must="not name `omega`",
            got="'omega'",
            why="The frequencies are an argument of their own.",
            fix="Pass them as the third argument.",
        )
    return require_increasing(
        "omega",
        without_unit("omega", omega, "omega", system),
        what="frequencies",
        why="The response is computed at each of them.",
    )


def thickness_extremes_over_window(
    ens: Ensemble,
    duration: float | None,
    periods: int | None,
    discard: float,
    tolerance: float,
    *,
    progress: ProgressFunction | None = None,
    first_resolution: IntArray | None = None,
    batch_size: int = TRAJECTORIES_PER_BATCH,
) -> Outcome:
    """Extremes of the thickness stretch of every trajectory, worked out `batch_size` at a time."""
    if ((trajectory_durations(ens, duration, periods) <= discard) & ~ens.is_invalid).any():
        raise InputError(
            "discard",
            must="be shorter than the run",
            got=discard,
            why="Nothing would be left of the window.",
            fix="Pass a longer `duration`.",
        )

    def parts() -> Iterator[tuple[slice, Outcome]]:
        for part, batch in ens.batches(batch_size):
            request = Request(
                wants_extremes=True, extremes_begin=np.full(batch.trajectory_count, discard)
            )
            report = report_part_of_whole(progress, part, ens.trajectory_count)
            problem = initial_value_problem(batch, trajectory_durations(batch, duration, periods))
            yield part, integrate(
                problem, request, tolerance=tolerance, progress=report,
                first_resolution=None if first_resolution is None else first_resolution[part],
            )  # fmt: skip

    return merge_outcomes(ens.trajectory_count, parts())


def _amplitude(outcome: Outcome) -> FloatArray:
    amplitude = outcome.maximum - outcome.minimum
    amplitude *= 0.5
    return np.asarray(amplitude)


def _needed_resolution(outcome: Outcome) -> IntArray:
    """Double steps per cycle that met the tolerance; 0 where none did."""
    return np.where(outcome.status == Status.OK, outcome.resolution, 0)


def _find_resonance(
    ens: Ensemble,
    grid: FloatArray,
    amplitude: FloatArray,
    outcome: Outcome,
    respond: Callable[[Ensemble, float, IntArray], Outcome],
    lengths: Callable[[Ensemble], FloatArray],
    tolerance: float,
    width: float,
) -> BracketedMaxima:
    """The largest amplitude for every combination of the other fields."""
    axis = ens.dims.index("omega")
    values, errors, resolutions = (
        np.moveaxis(ens.reshape_to_dims(column), axis, -1).reshape(-1, grid.size)
        for column in (amplitude, outcome.error, _needed_resolution(outcome))
    )
    first = [1 if dim == "omega" else size for dim, size in ens.dimension_sizes.items()]
    index = np.ravel_multi_index(
        tuple(np.indices(first)), tuple(ens.dimension_sizes.values())
    ).ravel()

    def measure(
        case: IntArray, omega: FloatArray, tolerance: float, resolution: IntArray
    ) -> tuple[FloatArray, FloatArray, IntArray]:
        runs = _ensemble_at_frequencies(ens, index[case], omega)
        outcome = respond(runs, tolerance, resolution)
        return _amplitude(outcome), outcome.error, _needed_resolution(outcome)

    def effort(case: IntArray, omega: FloatArray) -> FloatArray:
        runs = _ensemble_at_frequencies(ens, index[case], omega)
        with np.errstate(all="ignore"):
            steps = _STEPS_PER_TIME + _STEPS_PER_PERIOD / require_drive_periods(runs)
            return np.nan_to_num(lengths(runs) * steps)

    return refine_maxima(
        grid, values, errors, resolutions, measure, tolerance=tolerance, width=width,
        effort=effort, max_effort=_MOST_STEPS_OF_SEARCH,
    )  # fmt: skip


def _ensemble_at_frequencies(ens: Ensemble, indices: IntArray, omega: FloatArray) -> Ensemble:
    """Trajectories like those of an ensemble with some indices, at other frequencies."""
    values = {name: column[indices] for name, column in ens.parameter_values.items()} | {
        "omega": omega
    }
    return replace(
        ens,
        dimension_sizes={"point": indices.size},
        coords={},
        parameter_values=values,
        initial_states=ens.initial_states[indices],
        is_invalid=ens.is_invalid[indices],
    )


def _resonance_variables(ens: Ensemble, peak: BracketedMaxima) -> dict[str, Labelled]:
    """Resonances, along the dimensions of the ensemble but for that of frequency."""
    dims = tuple(d for d in ens.dims if d != "omega")
    shape = tuple(ens.dimension_sizes[d] for d in dims)
    values = {
        "resonance": peak.position,
        "resonance_error": peak.position_error,
        "resonance_amplitude": peak.value,
        "resonance_amplitude_error": peak.value_error,
    }
    variables: dict[str, NDArray[Any]] = {
        name: np.where(peak.is_inside, column, np.nan) for name, column in values.items()
    }
    is_known = np.isfinite(peak.value)
    codes = np.where(is_known, Status.INCOMPLETE, Status.INVALID)
    is_found = peak.is_inside & ~peak.is_cut_short
    variables["resonance_status"] = np.where(is_found, Status.OK, codes)
    words = np.where(is_known, np.where(peak.is_at_end, _AT_END_REASON, _FLAT_REASON), _NO_REASON)
    words = np.where(is_known & peak.is_cut_short, _LONG_REASON, words)
    variables["reason"] = np.where(is_found, "", words)
    return {name: (dims, array.reshape(shape)) for name, array in variables.items()}
