"""Threads that attempt chunks of trajectories."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from types import TracebackType
from typing import Self

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble.problem import Problem, Request
from remanent.integrate.ensemble.segments import (
    Attempt,
    attempt,
    cycle_counts,
    double_steps,
    step_counts,
)
from remanent.integrate.kernel.compile import Kernels, compiled
from remanent.integrate.kernel.kernel import Method, Options
from remanent.integrate.kernel.tables import waveform_tables
from remanent.integrate.methods.runge_kutta import default_method

#: Fine steps in a chunk: about a tenth of a second.
_CHUNK_STEPS = 2.0**23


@dataclass(frozen=True)
class Pending:
    """Trajectories to try, and how finely."""

    index: IntArray
    resolution: IntArray


def joined(some: list[Pending]) -> Pending:
    """Several lists as one."""
    return Pending(
        np.concatenate([one.index for one in some]),
        np.concatenate([one.resolution for one in some]),
    )


#: Attempts under way, and the resolution and the trajectories of each.
Futures = dict[Future[Attempt], tuple[int, IntArray]]


class Crew:
    """A pool of threads with the kernels of one field; leaving it by an exception stops it.

    Parameters
    ----------
    problem
        Whose field and waveforms the kernels are for.
    method, options
        Of the kernels.
    tolerance
        Of the controlled error.
    workers
        Threads; the number of processors by default.
    """

    def __init__(
        self,
        problem: Problem,
        method: Method,
        options: Options,
        tolerance: float,
        workers: int | None = None,
    ) -> None:
        self.kernels = Kernels(
            compiled(problem.field, default_method(), options),
            compiled(problem.field, method, options),
        )
        self.tolerance = tolerance
        self.threads = workers or os.cpu_count() or 1
        self._pool = ThreadPoolExecutor(max_workers=self.threads)
        self._stop = threading.Event()

        @lru_cache(maxsize=256)
        def tables(nodes: tuple[float, ...], resolution: int) -> tuple[FloatArray, FloatArray]:
            return waveform_tables(problem.timeline.waveform, nodes, resolution)

        self._tables = tables

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        _value: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        if kind is not None:
            self._stop.set()
        self._pool.shutdown(wait=kind is None, cancel_futures=kind is not None)

    def attempts(self, problem: Problem, request: Request, pending: Pending) -> Futures:
        """Begin to integrate the trajectories, each at its resolution."""

        def run(resolution: int, which: IntArray) -> Attempt:
            return attempt(
                problem, request, self.kernels, self.tolerance, resolution, which, self._tables,
                lambda: not self._stop.is_set(),
            )  # fmt: skip

        return {
            self._pool.submit(run, *chunk): chunk
            for chunk in chunks(problem, pending, self.kernels.width, self.threads)
        }


def chunks(
    problem: Problem, pending: Pending, width: int, threads: int
) -> Iterator[tuple[int, IntArray]]:
    """Group trajectories that share a resolution, step counts, and about a length."""
    cycles = cycle_counts(problem, pending.index)
    for level in np.unique(pending.resolution):
        members = pending.index[pending.resolution == level]
        steps = double_steps(problem.timeline, int(level), members)
        order = np.lexsort((members, cycles[pending.resolution == level], *steps[::-1]))
        members, steps = members[order], steps[:, order]
        cuts = np.flatnonzero((steps[:, 1:] != steps[:, :-1]).any(axis=0)) + 1
        for same in np.split(members, cuts):
            share = -(-same.size // (threads * width)) * width
            size = min(share, _fitting(problem, same, int(level), width))
            for first in range(0, same.size, size):
                yield int(level), same[first : first + size]


def _fitting(problem: Problem, which: IntArray, resolution: int, width: int) -> int:
    """How many trajectories make a chunk that is over soon, and is worth its overhead."""
    each = float(step_counts(problem, resolution, which[:1])[0])
    groups = np.clip(_CHUNK_STEPS / (each * width), 4, 256)
    return int(groups) * width
