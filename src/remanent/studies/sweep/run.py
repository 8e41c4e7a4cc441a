"""Running a study: in this process, task after task, into a store that a later run completes."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from filelock import FileLock

from remanent._errors import InputError, error_sentence, shortened_repr
from remanent._extras import require_extra
from remanent._machine import keep_large_arrays_apart
from remanent.studies.sweep.layout import create_store
from remanent.studies.sweep.locks import sole_writer
from remanent.studies.sweep.sample import TakeSample, sample_here
from remanent.studies.sweep.store import (
    Store,
    is_store_of_study,
    open_store,
    partial_files,
    require_same,
    was_only_begun,
)
from remanent.studies.sweep.study import Study, study_from_plain
from remanent.studies.sweep.tasks import TaskRunner

#: Seconds that a task takes, about.
TASK_SECONDS = 0.6
#: Chunks of a task, at most.
_MAX_CHUNKS_PER_TASK = 256


@dataclass(frozen=True)
class Task:
    """Chunks that are computed together: the first, and how many along the axis of tasks."""

    first: tuple[int, ...]
    count: int


@dataclass(frozen=True)
class Progress:
    """How far a run is.

    Attributes
    ----------
    done, total : int
        Points of the grid.
    rate : float
        Points a second in this run; NaN before the first task has ended.
    """

    done: int
    total: int
    rate: float

    @property
    def seconds_left(self) -> float:
        """By the rate so far."""
        return (self.total - self.done) / self.rate if self.rate > 0.0 else float("nan")


ReportProgress = Callable[[Progress], None]


@contextmanager
def writable_store(
    path: Path,
    study: Study,
    part: tuple[int, int] = (1, 1),
    take_sample: TakeSample = sample_here,
) -> Iterator[Store]:
    """The store of a study, new or as an earlier run left it, for one writer of this part.

    Parameters
    ----------
    path : Path
    study : Study
    part : (int, int)
        I of N.
    take_sample : callable
        Computes one point of a study of which there is no store yet.

    Raises
    ------
    InputError, RemanentError
        The path holds something else, another study, or is being written.
    """
    require_extra("studies", "a store")
    path = path.resolve()
    _create_if_missing(path, study, take_sample)
    store = open_store(path)
    require_same(store, study)
    with sole_writer(store.bookkeeping, part):
        if part == (1, 1):
            for file in partial_files(path):
                file.unlink(missing_ok=True)
        store.finish_lengthening()
        yield store


def _create_if_missing(path: Path, study: Study, take_sample: TakeSample) -> None:
    """Make the store; where several processes begin at once, one makes it and the others wait."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if is_store_of_study(path):
            return
        is_no_folder = path.exists() and not path.is_dir()
    except OSError as error:
        raise InputError(
            "store",
            must="be a folder that can be written",
            got=shortened_repr(str(path)),
            why=error_sentence(error),
            fix="Pass another path.",
        ) from error
    if is_no_folder:
        raise InputError(
            "store",
            must="be a folder, or not exist yet",
            got=str(path),
            why="A store is a folder, with folders for its variables in it.",
            fix="Pass another path.",
        )
    _require_outside_of_stores(path)
    study_from_plain(study.plain)  # raises where it could not be read back
    lock = FileLock(path.with_name(f".{path.name}.lock"))
    try:
        with lock:
            if not is_store_of_study(path):
                _require_empty(path)
                create_store(path, study, take_sample(study, path))
    finally:
        Path(lock.lock_file).unlink(missing_ok=True)


def _require_empty(path: Path) -> None:
    """Refuse a folder with other content; what a killed process began of a store is removed."""
    if not path.exists() or not any(path.iterdir()):
        return
    if not was_only_begun(path):
        raise InputError(
            "store",
            must="be an empty folder, or not exist yet",
            got=str(path),
            why="There are other files in it, and a store has its folder for itself.",
            fix="Pass another path; `remanent verify --repair` mends a store that is damaged.",
        )
    shutil.rmtree(path)


def _require_outside_of_stores(path: Path) -> None:
    for folder in path.parents:
        if (folder / "zarr.json").exists():
            raise InputError(
                "store",
                must="lie outside of other stores",
                got=str(path),
                why=f"{folder} is one, and has its folder for itself.",
                fix="Pass another path.",
            )


def chunks_of_share(store: Store, part: tuple[int, int]) -> list[tuple[int, ...]]:
    """Chunks of the I-th of N shares: runs of neighbours, as equal as whole chunks allow."""
    chunks = list(store.chunking.chunks())
    index, count = part
    begin, end = (len(chunks) * k // count for k in (index - 1, index))
    return chunks[begin:end]


def run_here(
    store: Store, part: tuple[int, int] = (1, 1), report: ReportProgress | None = None
) -> None:
    """Compute in this process what is missing of a share of a store.

    Parameters
    ----------
    store : Store
        As :func:`writable_store` lends it.
    part : (int, int)
        I of N.
    report : callable, optional
        Told after each task.
    """
    keep_large_arrays_apart()
    runner = TaskRunner(store)
    meter = Meter(store, chunks_of_share(store, part), report)
    size = 1
    missing = meter.missing
    position = 0
    while position < len(missing):
        task = next_task(store, missing, position, size)
        begin = time.perf_counter()
        runner.compute(task.first, task.count)
        size = next_size(task.count, time.perf_counter() - begin)
        position += task.count
        meter.add(store.chunking.chunks_of(task.first, task.count))


def next_task(store: Store, missing: list[tuple[int, ...]], position: int, size: int) -> Task:
    """A task of at most `size` missing chunks that lie side by side."""
    first, axis = missing[position], store.chunking.task_axis
    count = 1
    for chunk in missing[position + 1 : position + size]:
        expected = (*first[:axis], first[axis] + count, *first[axis + 1 :])
        if chunk != expected:
            break
        count += 1
    return Task(first, count)


def next_size(count: int, seconds: float) -> int:
    """Chunks of the next task, by how long the last one took; never more than twice as many."""
    wanted = count * TASK_SECONDS / max(seconds, 1e-3)
    return max(1, min(round(wanted), 2 * count, _MAX_CHUNKS_PER_TASK))


class Meter:
    """Counts what is done of a share, and reports it; its counts change as work goes on."""

    def __init__(
        self, store: Store, chunks: list[tuple[int, ...]], report: ReportProgress | None
    ) -> None:
        self._store, self._report = store, report
        self._begin = time.perf_counter()
        self.missing = [chunk for chunk in chunks if not store.computed(chunk)]
        self._total = sum(map(self._points, chunks))
        self._before = self._total - sum(map(self._points, self.missing))
        self._done = 0
        self.add([])

    def _points(self, chunk: tuple[int, ...]) -> int:
        count = 1
        for axis in self._store.chunking.part_of(chunk):
            count *= axis.stop - axis.start
        return count

    def add(self, chunks: list[tuple[int, ...]]) -> None:
        """These chunks are there now."""
        self._done += sum(map(self._points, chunks))
        if self._report is not None:
            seconds = time.perf_counter() - self._begin
            rate = self._done / seconds if self._done else float("nan")
            self._report(Progress(self._before + self._done, self._total, rate))
