"""Bifurcation diagrams: what a motion does while a parameter is swept."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import require_choice, require_known
from remanent._errors import InputError
from remanent._status import Status
from remanent._typing import ArrayLike, FloatArray
from remanent.analysis.following import FARTHEST
from remanent.integrate.ensemble.ensemble import Progress
from remanent.integrate.ensemble.problem import Problem
from remanent.integrate.maps.advance import Advancer
from remanent.integrate.maps.period_map import PeriodMap
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import require_count, require_periods
from remanent.studies.ensemble.ensemble import Ensemble, ensemble, problem, require_memory
from remanent.studies.ensemble.observables import observe
from remanent.studies.regimes._follower import labelled

#: Sweeps of each direction asked for: the order in which values are visited.
_SWEEPS = {"up": ("up",), "down": ("down",), "both": ("up", "down")}
#: Periods advanced at once.
_BLOCK = 64


def bifurcation_diagram(
    system: Actuator,
    drive: Drive,
    parameter: str,
    values: ArrayLike,
    *,
    direction: str = "up",
    discard: int = 200,
    keep: int = 50,
    initial: ArrayLike | None = None,
    tolerance: float = 1e-9,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Sweep a parameter and keep the last points of the section at every value.

    Parameters
    ----------
    system, drive
        What moves, and a periodic load.
    parameter
        A field of the actuator or the drive.
    values : array
        Its values, ascending.
    direction
        ``"up"``, ``"down"``, or ``"both"``.  Each value starts from the state in which the
        motion left the one before, so that sweeps show hysteresis.
    discard, keep
        Drive periods that pass at each value before points are kept, and points kept.
    initial
        State at the first value of each sweep; rest by default.
    tolerance
        Of the error that one drive period adds.
    progress
        Called with the share of values that are finished.

    Returns
    -------
    xarray.Dataset
        ``stretch``, ``stretch_rate``, ``thickness_stretch``, ``thickness_stretch_rate``
        against ``sweep`` (``"up"``, ``"down"``; only for ``"both"``), the parameter and
        ``period`` (of those kept); ``local_error``, ``status`` per value.  Where the motion
        has escaped, NaN; the next value starts from `initial` again.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    Notes
    -----
    Points are not joined to branches and unstable motions do not show; see the literature
    on numerical continuation for these.

    Examples
    --------
    >>> import numpy as np, remanent as rm
    >>> ds = rm.bifurcation_diagram(
    ...     rm.Actuator(dissipation=rm.Rayleigh(0.3)),
    ...     rm.SineSquared(0.4, 1.25),
    ...     "b",
    ...     np.linspace(0.2, 0.4, 3),
    ...     discard=100,
    ...     keep=4,
    ... )
    >>> bool(np.ptp(ds.stretch.values, axis=1).max() < 1e-6)  # period 1 throughout
    True
    """
    require_choice("direction", direction, ["up", "down", "both"])
    discard = require_count("discard", discard, "Whole drive periods pass.", 0)
    keep = require_count("keep", keep, "It is a number of points.")
    tolerance = require_tolerance(tolerance)
    base = ensemble(system, drive, None, initial)
    require_known([parameter], base.values, "the actuator and the drive")
    ens = ensemble(system, drive, {parameter: values}, initial)
    if ens.sizes.keys() != {parameter}:
        raise InputError(
            "values",
            "be a plain array",
            repr(values)[:80],
            "A sweep visits one value after the other.",
            "Pass for example numpy.linspace(0.5, 2.0, 300).",
        )
    lengths = require_periods(ens)
    sweeps = _SWEEPS[direction]
    require_memory(64.0 * ens.count * keep * len(sweeps), f"{ens.count} x {keep} points")
    asked = problem(ens, np.ones(ens.count))
    found = _sweep(ens, asked, lengths, sweeps, (discard, keep), tolerance, progress)
    states, error, status = found
    dims: tuple[str, ...] = (*(("sweep",) if direction == "both" else ()), parameter)

    def shaped(array: Any) -> Any:
        return array if direction == "both" else array[0]

    variables: dict[str, Labelled] = {
        name: ((*dims, "period"), shaped(states[..., k])) for k, name in enumerate(ens.field.state)
    }
    times = np.zeros((ens.count, keep))
    for name in ("thickness_stretch", "thickness_stretch_rate"):
        seen = np.stack([observe(asked, name, times, one) for one in states])
        variables[name] = ((*dims, "period"), shaped(seen))
    variables["drive_period"] = ((parameter,), lengths)
    variables["local_error"] = (dims, shaped(error))
    variables["status"] = (dims, shaped(status))
    coords: dict[str, Labelled] = {"period": (("period",), np.arange(1, keep + 1) + discard)}
    if direction == "both":
        coords["sweep"] = (("sweep",), np.array(sweeps))
    settings = {"direction": direction, "discard": discard, "keep": keep}
    return labelled(ens, variables, coords, tolerance, **settings)


def _sweep(
    ens: Ensemble,
    asked: Problem,
    lengths: FloatArray,
    sweeps: tuple[str, ...],
    counts: tuple[int, int],
    tolerance: float,
    progress: Progress | None,
) -> tuple[FloatArray, FloatArray, np.ndarray]:
    """States (sweep, value, point, state), errors and status (sweep, value)."""
    discard, keep = counts
    flow = PeriodMap(asked.field, asked.timeline.waveform)
    shape = (len(sweeps), ens.count)
    states = np.full((*shape, keep, flow.dimension), np.nan)
    error, status = np.full(shape, np.nan), np.zeros(shape, dtype=np.int8)
    now = np.tile(ens.initial[0], (len(sweeps), 1))
    for n in range(ens.count):
        at = np.array([n if sweep == "up" else ens.count - 1 - n for sweep in sweeps])
        valid = np.flatnonzero(~ens.invalid[at])
        if valid.size:
            some = at[valid]
            lap = Advancer(flow, asked.parameters[some], lengths[some], tolerance)
            last, visited, worst, trusted = _settle(lap, now[valid], discard, keep)
            gone = ~(np.abs(visited) < FARTHEST).all(axis=(1, 2))
            kinds = np.where(trusted, int(Status.OK), int(Status.MAX_STEPS))
            status[valid, some] = np.where(gone, int(Status.ESCAPED), kinds)
            good = ~gone & trusted
            states[valid[good], some[good]] = visited[good]
            error[valid, some] = worst
            now[valid] = np.where(good[:, None], last, ens.initial[0])
        status[np.setdiff1d(np.arange(len(sweeps)), valid), at[ens.invalid[at]]] = Status.INVALID
        if progress is not None:
            progress((n + 1) / ens.count)
    return states, error, status


def _settle(
    lap: Advancer, states: FloatArray, discard: int, keep: int
) -> tuple[FloatArray, FloatArray, FloatArray, np.ndarray]:
    """Last states, those kept, the largest error of a period, whether all were met."""
    everyone = np.arange(len(states))
    lines = np.empty((len(states), 0, states.shape[1]))
    worst, trusted = np.zeros(len(states)), np.ones(len(states), dtype=np.bool_)
    seen: list[FloatArray] = []
    left = [*_blocks(discard), *_blocks(keep)]
    for n, periods in enumerate(left):
        wanted = n >= len(_blocks(discard))
        step = lap(everyone, states, lines, periods, every=wanted)
        states = step.visited[:, -1]
        worst, trusted = np.maximum(worst, step.error), trusted & step.trusted
        if wanted:
            seen.append(step.visited)
    return states, np.concatenate(seen, axis=1), worst, trusted


def _blocks(periods: int) -> list[int]:
    whole, rest = divmod(periods, _BLOCK)
    return [_BLOCK] * whole + [rest] * (rest > 0)
