"""Threads that attempt chunks of trajectories."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from types import TracebackType
from typing import Self

import numpy as np

from remanent._typing import IntArray
from remanent.integrate.ensemble.attempt import attempt
from remanent.integrate.ensemble.counts import cycle_counts, double_steps, step_counts
from remanent.integrate.ensemble.problem import Problem, Request
from remanent.integrate.ensemble.run import Attempt, Chunk, Run
from remanent.integrate.ensemble.work_sizes import DEFAULT_SIZES, WorkSizes
from remanent.integrate.kernel.compile import Kernels, compiled
from remanent.integrate.kernel.options import Method, Options
from remanent.integrate.kernel.tables import CycleTables
from remanent.integrate.methods.runge_kutta import default_method


@dataclass(frozen=True)
class Pending:
    """Trajectories to try, and how finely.

    Attributes
    ----------
    indices, resolution : array (trajectory,)
        Numbers of the trajectories, and double steps per cycle for each.
    """

    indices: IntArray
    resolution: IntArray

    @classmethod
    def joined(cls, lists: Sequence[Pending]) -> Pending:
        """Several lists as one."""
        nothing = np.empty(0, dtype=np.int64)
        return cls(
            np.concatenate([nothing, *(pending.indices for pending in lists)]),
            np.concatenate([nothing, *(pending.resolution for pending in lists)]),
        )


class KernelPool:
    """A pool of threads with the kernels of one field; leaving it by an exception stops it.

    What changes: threads are started and stopped, and tables of the load are remembered.

    Parameters
    ----------
    problem : Problem
        Whose field and waveforms the kernels are for.
    method, options : Method, Options
        Of the kernels.
    tolerance : float
        Of the controlled error, absolute.
    workers : int, optional
        Threads; the number of processors by default.
    sizes : WorkSizes
        Of chunks and segments.
    """

    def __init__(
        self,
        problem: Problem,
        method: Method,
        options: Options,
        tolerance: float,
        *,
        workers: int | None = None,
        sizes: WorkSizes = DEFAULT_SIZES,
    ) -> None:
        self.kernels = Kernels(
            compiled(problem.field, default_method(), options),
            compiled(problem.field, method, options),
        )
        self.tolerance = tolerance
        self.sizes = sizes
        self.threads = workers or os.cpu_count() or 1
        self._pool = ThreadPoolExecutor(max_workers=self.threads)
        self._stop = threading.Event()
        self._tables = CycleTables(problem.timeline.waveform)

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

    def attempts(
        self, problem: Problem, request: Request, pending: Pending
    ) -> Iterator[tuple[Chunk, Attempt]]:
        """Integrate trajectories, each at its resolution; chunks come as they are finished."""
        run = Run(
            problem,
            request,
            self.kernels,
            self.tolerance,
            self._tables,
            self.sizes,
            self._stop.is_set,
        )
        width = self.kernels.width
        futures = {
            self._pool.submit(attempt, run, chunk): chunk
            for chunk in chunks(problem, pending, width, self.threads, self.sizes)
        }
        for future in as_completed(futures):
            yield futures[future], future.result()


def chunks(
    problem: Problem, pending: Pending, width: int, threads: int, sizes: WorkSizes
) -> Iterator[Chunk]:
    """Group trajectories that share a resolution, step counts, and about a length.

    All lanes of a group take as many steps as the longest of them, so that trajectories are
    sorted by their length.
    """
    cycles = cycle_counts(problem, pending.indices)
    for level in np.unique(pending.resolution):
        resolution = int(level)
        members = pending.indices[pending.resolution == level]
        steps = double_steps(problem.timeline, resolution, members)
        order = np.lexsort((members, cycles[pending.resolution == level], *steps[::-1]))
        members, steps = members[order], steps[:, order]
        cuts = np.flatnonzero((steps[:, 1:] != steps[:, :-1]).any(axis=0)) + 1
        for alike in np.split(members, cuts):
            steps_each = float(step_counts(problem, resolution, alike[:1])[0])
            share = -(-alike.size // (threads * width)) * width
            size = min(share, sizes.trajectories_per_chunk(steps_each, width))
            for first in range(0, alike.size, size):
                yield Chunk(resolution, alike[first : first + size])
