"""Threads that attempt chunks of trajectories."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from types import TracebackType
from typing import Self

import numpy as np

from remanent._threads import StoppableThreads, as_finished, first_finished
from remanent._typing import IntArray
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

#: Least and largest double steps per cycle of trajectories that share groups with others: more
#: than those of a start, and with tables of the load that are short.
_LEAST_MIXED_RESOLUTION, _LARGEST_MIXED_RESOLUTION = 8, 4096


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
        field, count = problem.field, problem.duration.size
        self.kernel_pair = KernelPair(
            compiled_kernel(field, default_method(), options, trajectory_count=count),
            compiled_kernel(field, method, options, trajectory_count=count),
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
            for chunk in self._chunks(problem, request, pending)
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
        chunks: deque[Chunk] = deque()
        running: dict[Future[Attempt], Chunk] = {}
        while running or chunks or pending.indices.size:
            if not chunks:
                chunks.extend(self._chunks(problem, request, pending))
                pending = PendingTrajectories.concatenated([])
            # One waits, so that no thread does.
            while chunks and len(running) <= self.thread_count:
                chunk = chunks.popleft()
                running[self._executor.submit(attempt_chunk, run, chunk)] = chunk
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

    def _chunks(
        self, problem: Problem, request: Request, pending: PendingTrajectories
    ) -> Iterator[Chunk]:
        """Trajectories as tasks of threads."""
        return divide_into_chunks(
            problem, pending, self.kernel_pair.lane_count, self.thread_count, self.work_sizes,
            mixes=request.is_of_extremes_alone and problem.load_schedule.periodic,
        )  # fmt: skip


def divide_into_chunks(
    problem: Problem,
    pending: PendingTrajectories,
    lane_count: int,
    threads: int,
    sizes: WorkSizes,
    *,
    mixes: bool = False,
) -> Iterator[Chunk]:
    """Group trajectories that share a resolution, step counts, and about a length.

    All lanes of a group take as many steps as the longest of them, so that trajectories are
    sorted by their length.

    Parameters
    ----------
    problem : Problem
    pending : PendingTrajectories
    lane_count : int
        Trajectories of a group.
    threads : int
    sizes : WorkSizes
    mixes : bool
        Groups are filled with trajectories of several resolutions where those of one do not
        fill them.
    """
    cycles = cycle_counts(problem, pending.indices)
    rest: dict[int, IntArray] = {}
    for level in np.unique(pending.resolution).tolist():
        members = pending.indices[pending.resolution == level]
        steps = counts_of_double_steps(problem.load_schedule, level, members)
        order = np.lexsort((members, cycles[pending.resolution == level], *steps[::-1]))
        members, steps = members[order], steps[:, order]
        if mixes and _LEAST_MIXED_RESOLUTION <= level <= _LARGEST_MIXED_RESOLUTION:
            whole = members.size - members.size % lane_count
            rest[level] = members[whole:]
            members, steps = members[:whole], steps[:, :whole]
        cuts = np.flatnonzero((steps[:, 1:] != steps[:, :-1]).any(axis=0)) + 1
        for alike in np.split(members, cuts):
            if alike.size:
                yield from _chunks_of_one_resolution(
                    problem, alike, level, lane_count, threads, sizes
                )
    yield from _mixed_chunks(problem, rest, lane_count)


def _chunks_of_one_resolution(
    problem: Problem, alike: IntArray, level: int, lane_count: int, threads: int, sizes: WorkSizes
) -> Iterator[Chunk]:
    """Chunks of trajectories that take the same steps."""
    steps_each = float(fine_step_counts(problem, level, alike[:1])[0])
    share = -(-alike.size // (threads * lane_count)) * lane_count
    size = min(share, sizes.trajectories_per_chunk(steps_each, lane_count))
    for first in range(0, alike.size, size):
        yield Chunk(level, alike[first : first + size])


def _mixed_chunks(
    problem: Problem, members_of_level: Mapping[int, IntArray], lane_count: int
) -> Iterator[Chunk]:
    """Groups of trajectories of several resolutions that take about as many steps in all."""
    nothing = np.empty(0, dtype=np.int64)
    indices = np.concatenate([nothing, *members_of_level.values()])
    sizes = [members.size for members in members_of_level.values()]
    resolution = np.repeat(np.array([*members_of_level], dtype=np.int64), sizes)
    order = np.argsort(-resolution * cycle_counts(problem, indices), kind="stable")
    for first in range(0, order.size, lane_count):
        part = order[first : first + lane_count]
        level, *others = np.unique(resolution[part]).tolist()
        yield Chunk(resolution[part] if others else level, indices[part])
