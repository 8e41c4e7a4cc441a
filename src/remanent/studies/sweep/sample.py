"""What a verb returns for one point, by which a store knows its variables.

A point may take down the process that computes it.  Such a point is left, after as many failures
as a task allows, and another one is taken.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import xarray as xr

from remanent._errors import RemanentError
from remanent.studies.sweep.attempts import MAX_FAILURES, Attempts, ended_after
from remanent.studies.sweep.grid import GridPart
from remanent.studies.sweep.study import Study, study_from_plain

#: Where along each dimension of the grid a point is taken: first, last, between.
_SHARES = (0.0, 1.0, 0.5)


@dataclass(frozen=True)
class Sample:
    """The result for the least part of a grid for which a verb can be called.

    Attributes
    ----------
    part : tuple of slice
    result : xarray.Dataset
    """

    part: GridPart
    result: xr.Dataset


#: Seconds that compiling takes at most, with much to spare.
_COMPILING_SECONDS = 60.0
#: Computes a sample of a study for the store at a path.
TakeSample = Callable[[Study, Path], Sample]


def sample_here(study: Study, path: Path) -> Sample:
    """Compute a sample in this process.

    A process that dies of it leaves a mark beside the store, so that the next one knows.

    Raises
    ------
    RemanentError
        Each point that was tried took its process down.
    """
    folder = path.with_name(f".{path.name}.sample")
    attempts = Attempts(folder)
    for part in sample_parts(study):
        name = "-".join(str(s.start) for s in part)
        if attempts.failures(name) < MAX_FAILURES:
            with attempts.begun(name):
                result = study.result_of(part)
            shutil.rmtree(folder, ignore_errors=True)
            return Sample(part, result)
    shutil.rmtree(folder, ignore_errors=True)
    raise _no_sample()


def sample_on(client: Any, point_seconds: float | None = None) -> TakeSample:
    """As :func:`sample_here`, on a worker of a Dask client, which replaces those that die of it.

    Parameters
    ----------
    client : distributed.Client
    point_seconds : float, optional
        Cap on a point, to which the time for compiling is added.
    """

    def take_sample(study: Study, path: Path) -> Sample:
        from distributed.scheduler import KilledWorker

        for _ in range(MAX_FAILURES * len(_SHARES)):
            future = client.submit(
                _sample_of_text, study.text, str(path), point_seconds, pure=False
            )
            with suppress(KilledWorker):
                sample: Sample = future.result()
                return sample
        raise _no_sample()

    return take_sample


def _sample_of_text(text: str, path: str, point_seconds: float | None) -> Sample:
    """The sample of a study given as text, in a process that ends where it takes too long."""
    study = study_from_plain(json.loads(text))
    if point_seconds is None:
        return sample_here(study, Path(path))
    with ended_after(point_seconds + _COMPILING_SECONDS):
        return sample_here(study, Path(path))


def sample_parts(study: Study) -> list[GridPart]:
    """Least parts of its grid for which the verb can be called, in the order they are tried."""
    grid = study.grid
    if study.needs_whole_grid:
        return [grid.whole]
    places = [tuple(round(share * (size - 1)) for size in grid.shape) for share in _SHARES]
    return [tuple(slice(k, k + 1) for k in place) for place in dict.fromkeys(places)]


def _no_sample() -> RemanentError:
    return RemanentError(
        "The first point of the grid ended its process, and so did two more. "
        "Call the verb for one of them to see why."
    )
