"""What a run of a study would be: points, tasks, bytes and time, from points that are tried."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Hashable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr

from remanent._machine import available_processor_count
from remanent._threads import WorkStopped, work_stopped_after
from remanent.studies.ensemble.memory import BYTES_PER_TRAJECTORY
from remanent.studies.sweep.chunks import Chunking, chunking
from remanent.studies.sweep.grid import Grid, GridPart
from remanent.studies.sweep.run import TASK_SECONDS
from remanent.studies.sweep.study import Study

#: Seconds for which points are tried.
_TRIAL_SECONDS: Final = 1.0
#: Seconds after which a trial is broken off.
_LONGEST_TRIAL_SECONDS: Final = 20.0
#: Shorter trials are repeated, as the first one also compiles.
_LONGEST_REPEATED_SECONDS: Final = 8.0
#: How much finer a trial is than the one before, and along how many dimensions: points of one call
#: share work, so that few of them say little of many.
_GROWTH: Final = 2
_GROWING_DIMENSIONS: Final = 2
#: How often the numbers of a task are in memory: as computed, joined and encoded.
_COPIES: Final = 3


@dataclass(frozen=True)
class Plan:
    """What a run of a study would be.

    Attributes
    ----------
    verb : str
    sizes : tuple of (str, int)
        Name and length of each dimension of the grid.
    cores : int
        Processors that this process may use.
    points_tried : int
        Points on which the estimates stand; 0 where not one was done in the time for trials.
    chunks : int or None
        Chunks of the store; None where no point was done.
    store_bytes : int or None
        Bytes of all numbers, uncompressed; lists, such as those of orbits, as long as in the
        longest that was tried.
    task_bytes : int or None
        Bytes that one task needs beside its process.
    seconds : float or None
        Time of a run on this machine, by the pace of the last trial.  Points of one call share
        work, so that many are quicker: it is too long rather than too short.
    """

    verb: str
    sizes: tuple[tuple[str, int], ...]
    cores: int
    points_tried: int
    chunks: int | None
    store_bytes: int | None
    task_bytes: int | None
    seconds: float | None

    @property
    def points(self) -> int:
        """Points of the grid."""
        return math.prod(size for _, size in self.sizes)

    @property
    def tasks(self) -> int | None:
        """Tasks of about half a second, none smaller than a chunk."""
        if self.chunks is None or self.seconds is None:
            return None
        return min(self.chunks, max(1, math.ceil(self.seconds / TASK_SECONDS)))


def plan_study(study: Study, clock: Callable[[], float] = time.perf_counter) -> Plan:
    """Try some points of a study, spread over its grid, and say what a run would be.

    Parameters
    ----------
    study : Study
    clock : callable
        Gives the time in seconds.

    Returns
    -------
    Plan
        Nothing is written.

    Raises
    ------
    InputError
        The verb refuses its arguments.
    """
    grid, verb = study.grid, study.verb
    sizes = tuple(zip(grid.dims, grid.shape, strict=True))
    cores = available_processor_count()
    try:
        with work_stopped_after(_LONGEST_TRIAL_SECONDS):
            tried, seconds, result = _trial(
                study, next(_samples(study.needs_whole_grid, grid)), clock
            )
    except WorkStopped:
        return Plan(verb, sizes, cores, 0, None, None, None, None)
    if seconds < _LONGEST_REPEATED_SECONDS:  # the first trial also compiled
        tried, seconds, result = _last_trial(study, clock)
    per_point = _bytes_per_point(result, grid)
    cut = chunking(study, int(max(per_point, default=8.0)))
    return Plan(
        verb,
        sizes,
        cores,
        tried,
        cut.chunk_count,
        _store_bytes(result, grid),
        _task_bytes(cut, sum(per_point), seconds / tried),
        seconds / tried * grid.point_count,
    )


def _last_trial(study: Study, clock: Callable[[], float]) -> tuple[int, float, xr.Dataset]:
    """The last of several trials, which grow until one is long; the code is compiled before."""
    begin = clock()
    for part in _samples(study.needs_whole_grid, study.grid):
        tried, seconds, result = _trial(study, part, clock)
        if clock() - begin > _TRIAL_SECONDS:
            break
    return tried, seconds, result


def _trial(
    study: Study, part: GridPart, clock: Callable[[], float]
) -> tuple[int, float, xr.Dataset]:
    """Number of points of a part, seconds that they took, and their result."""
    begin = clock()
    result = study.result_over(study.grid.over(part))
    seconds = max(clock() - begin, 1e-9)
    return math.prod(result.sizes.get(dim, 1) for dim in study.grid.dims), seconds, result


def _samples(at_once: bool, grid: Grid) -> Iterator[GridPart]:
    """Parts of the grid, each with several times the points of the one before, spread evenly."""
    if at_once:
        yield grid.whole
        return
    counts = [1] * len(grid.shape)
    while True:
        yield tuple(
            slice(size // (2 * n), None, max(1, size // n))
            for n, size in zip(counts, grid.shape, strict=True)
        )
        growing = [k for k, n in enumerate(counts) if n < grid.shape[k]]
        if not growing:
            return
        for axis in sorted(growing, key=lambda k: counts[k])[:_GROWING_DIMENSIONS]:
            counts[axis] = min(_GROWTH * counts[axis], grid.shape[axis])


def _bytes_per_point(result: xr.Dataset, grid: Grid) -> list[float]:
    """Bytes for one point of the grid, of each variable that depends on it."""
    return [
        v.nbytes / math.prod(v.sizes.get(dim, 1) for dim in grid.dims)
        for v in result.data_vars.values()
        if set(v.dims) & set(grid.dims)
    ]


def _store_bytes(result: xr.Dataset, grid: Grid) -> int:
    """Bytes of all variables for the whole grid."""
    lengths: dict[Hashable, int] = dict(result.sizes)
    lengths |= zip(grid.dims, grid.shape, strict=True)
    return sum(
        v.dtype.itemsize * math.prod(lengths[dim] for dim in v.dims)
        for v in result.variables.values()
    )


def _task_bytes(cut: Chunking, per_point: float, seconds_per_point: float) -> int:
    """Bytes of the largest task: a chunk, or what is computed in the time of a task."""
    chunk = math.prod(min(step, n) for step, n in zip(cut.shape, cut.grid.shape, strict=True))
    along = min(cut.counts[cut.task_axis], max(1, int(TASK_SECONDS / seconds_per_point) // chunk))
    return math.ceil(chunk * along * (_COPIES * per_point + BYTES_PER_TRAJECTORY))


def text(plan: Plan) -> str:
    """The plan as a small table for people."""
    grid = " x ".join(f"{name} {size}" for name, size in plan.sizes)
    rows = [
        ("verb", plan.verb),
        ("grid", f"{grid} = {plan.points:,} points"),
        ("chunks", "unknown" if plan.chunks is None else f"{plan.chunks:,}"),
        ("tasks", "unknown" if plan.tasks is None else f"about {plan.tasks:,}"),
        ("disk", f"{_size(plan.store_bytes)}, uncompressed; lists as long as in what was tried"),
        ("memory", f"{_size(plan.task_bytes)} a task, beside the process itself"),
        ("time", f"{_duration(plan.seconds)} on {plan.cores} processors"),
        ("tried", _trial_text(plan)),
    ]
    return "\n".join(f"{name:<8}{value}" for name, value in rows)


def _trial_text(plan: Plan) -> str:
    if not plan.points_tried:
        return f"no point ended within {_LONGEST_TRIAL_SECONDS:g} s"
    return f"{plan.points_tried:,} of the points, spread over the grid; nothing was written"


def _size(count: int | None) -> str:
    if count is None:
        return "unknown"
    for unit, one in (("GiB", 2**30), ("MiB", 2**20), ("KiB", 2**10)):
        if count >= one:
            return f"about {count / one:.3g} {unit}"
    return f"{count} bytes"


def _duration(seconds: float | None) -> str:
    if seconds is None:
        return "unknown"
    for unit, one in (("days", 86400.0), ("h", 3600.0), ("min", 60.0)):
        if seconds >= 2.0 * one:
            return f"about {_rounded(seconds / one)} {unit} or less"
    return f"about {_rounded(max(seconds, 0.1))} s or less"


def _rounded(number: float) -> str:
    """Two digits, without an exponent."""
    return np.format_float_positional(number, precision=2, fractional=False, trim="-")
