"""Threads that attempt chunks of trajectories."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import Self

import numpy as np

from remanent._threads import StoppableThreads, as_finished
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
        run = Run(
            problem,
            request,
            self.kernel_pair,
            self.tolerance,
            self._cycle_tables,
            self.work_sizes,
        )
        lane_count = self.kernel_pair.lane_count
        futures = {
            self._executor.submit(attempt_chunk, run, chunk): chunk
            for chunk in divide_into_chunks(
                problem, pending, lane_count, self.thread_count, self.work_sizes
            )
        }
        for future in as_finished(futures):
            yield futures[future], future.result()


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
