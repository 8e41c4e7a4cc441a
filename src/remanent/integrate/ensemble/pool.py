"""Threads that attempt chunks of trajectories."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from types import TracebackType
from typing import Self

import numpy as np

from remanent._threads import StoppableThreads, as_finished, first_finished
from remanent._typing import BoolArray, IntArray
from remanent.integrate.ensemble.attempt import attempt_chunk
from remanent.integrate.ensemble.counts import (
    counts_of_double_steps,
    cycle_counts,
    fine_step_counts,
)
from remanent.integrate.ensemble.problem import Problem, Request
from remanent.integrate.ensemble.run import Attempt, Chunk, Run
from remanent.integrate.ensemble.work_sizes import DEFAULT_WORK_SIZES, WorkSizes
from remanent.integrate.kernel.compile import KernelPair, compiled_kernel
from remanent.integrate.kernel.options import KernelOptions, Method
from remanent.integrate.kernel.tables import CycleTables
from remanent.integrate.methods.runge_kutta import default_method


@dataclass(frozen=True)
class PendingTrajectories:
    """Trajectories to try, and how finely.

    Attributes
    ----------
    indices, resolution : array (trajectory,)
        Numbers of the trajectories, and double steps per cycle for each.
    """

    indices: IntArray
    resolution: IntArray

    @classmethod
    def concatenated(cls, lists: Sequence[PendingTrajectories]) -> PendingTrajectories:
        """Several lists as one."""
        nothing = np.empty(0, dtype=np.int64)
        return cls(
            np.concatenate([nothing, *(pending.indices for pending in lists)]),
            np.concatenate([nothing, *(pending.resolution for pending in lists)]),
        )

    def subset(self, where: BoolArray) -> PendingTrajectories:
        """Some of them."""
        return PendingTrajectories(self.indices[where], self.resolution[where])


#: ``record(chunk, attempt)``: takes in an attempt, and tells what to try again, and how finely.
RecordFunction = Callable[[Chunk, Attempt], PendingTrajectories]


class KernelPool:
    """A pool of threads with the kernels of one field; leaving it by an exception stops it.

    What changes: threads are started and stopped, and tables of the load are remembered.

    Parameters
    ----------
    problem : Problem
        Whose field and waveforms the kernels are for.
    method, options : Method, KernelOptions
        Of the kernels.
    tolerance : float
        Of the controlled error, absolute.
    workers : int, optional
        Threads; as many as this process may use processors by default.
    work_sizes : WorkSizes
        Of chunks and segments.
    """

    def __init__(
        self,
        problem: Problem,
        method: Method,
        options: KernelOptions,
        tolerance: float,
        *,
        workers: int | None = None,
        sizes: WorkSizes = DEFAULT_WORK_SIZES,
    ) -> None:
        self.kernel_pair = KernelPair(
            compiled_kernel(problem.field, default_method(), options),
            compiled_kernel(problem.field, method, options),
        )
        self.tolerance = tolerance
        self.work_sizes = sizes
        self._executor = StoppableThreads(workers)
        self.thread_count = self._executor.thread_count
        self._cycle_tables = CycleTables(problem.load_schedule.waveforms_at_phase)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._executor.__exit__(kind, value, trace)

    def run_attempts(
        self, problem: Problem, request: Request, pending: PendingTrajectories
    ) -> Iterator[tuple[Chunk, Attempt]]:
        """Integrate trajectories, each at its resolution; chunks come as they are finished."""
        run = self._run(problem, request)
        futures = {
            self._executor.submit(attempt_chunk, run, chunk): chunk
            for chunk in self._chunks(problem, pending)
        }
        for future in as_finished(futures):
            yield futures[future], future.result()

    def run_until_settled(
        self,
        problem: Problem,
        request: Request,
        pending: PendingTrajectories,
        record: RecordFunction,
    ) -> None:
        """Integrate trajectories again and again, until there is none to be tried again.

        The coarsest are first: what must be refined meets what was waiting for that resolution,
        and groups are fuller.

        Parameters
        ----------
        problem : Problem
        request : Request
        pending : PendingTrajectories
        record : callable
            Called from this thread with each chunk and its attempt; returns what to try again, at
            finer resolutions.
        """
        run = self._run(problem, request)
        coarsest: deque[Chunk] = deque()
        running: dict[Future[Attempt], Chunk] = {}
        while running or coarsest or pending.indices.size:
            if not coarsest and pending.indices.size:
                is_coarsest = pending.resolution == pending.resolution.min()
                coarsest.extend(self._chunks(problem, pending.subset(is_coarsest)))
                pending = pending.subset(~is_coarsest)
            while coarsest and len(running) < self.thread_count:
                chunk = coarsest.popleft()
                running[self._executor.submit(attempt_chunk, run, chunk)] = chunk
            if len(running) < self.thread_count and pending.indices.size:
                continue
            for future in first_finished(running):
                again = record(running.pop(future), future.result())
                pending = PendingTrajectories.concatenated([pending, again])

    def _run(self, problem: Problem, request: Request) -> Run:
        """What all chunks of a run have in common."""
        return Run(
            problem,
            request,
            self.kernel_pair,
            self.tolerance,
            self._cycle_tables,
            self.work_sizes,
        )

    def _chunks(self, problem: Problem, pending: PendingTrajectories) -> Iterator[Chunk]:
        """Trajectories as tasks of threads."""
        return divide_into_chunks(
            problem, pending, self.kernel_pair.lane_count, self.thread_count, self.work_sizes
        )


def divide_into_chunks(
    problem: Problem, pending: PendingTrajectories, lane_count: int, threads: int, sizes: WorkSizes
) -> Iterator[Chunk]:
    """Group trajectories that share a resolution, step counts, and about a length.

    All lanes of a group take as many steps as the longest of them, so that trajectories are
    sorted by their length.
    """
    cycles = cycle_counts(problem, pending.indices)
    for level in np.unique(pending.resolution):
        resolution = int(level)
        members = pending.indices[pending.resolution == level]
        steps = counts_of_double_steps(problem.load_schedule, resolution, members)
        order = np.lexsort((members, cycles[pending.resolution == level], *steps[::-1]))
        members, steps = members[order], steps[:, order]
        cuts = np.flatnonzero((steps[:, 1:] != steps[:, :-1]).any(axis=0)) + 1
        for alike in np.split(members, cuts):
            steps_each = float(fine_step_counts(problem, resolution, alike[:1])[0])
            share = -(-alike.size // (threads * lane_count)) * lane_count
            size = min(share, sizes.trajectories_per_chunk(steps_each, lane_count))
            for first in range(0, alike.size, size):
                yield Chunk(resolution, alike[first : first + size])
