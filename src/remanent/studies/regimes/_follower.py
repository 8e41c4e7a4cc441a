"""Ensembles followed over many drive periods, a chunk at a time, in threads."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from remanent._status import Status
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.following import Advance, Path, block_lengths, follow
from remanent.integrate.ensemble.ensemble import Progress
from remanent.integrate.ensemble.problem import Problem
from remanent.integrate.maps.advance import Advancer, CoarseReplay
from remanent.integrate.maps.period_map import ErrorControl, PeriodMap
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.ensemble.durations import require_periods
from remanent.studies.ensemble.ensemble import Ensemble, problem

#: Trajectories followed together: enough of each resolution to fill the lanes of a kernel.
CHUNK = 4096
T = TypeVar("T")


@dataclass(frozen=True)
class Follower:
    """Follows trajectories of an ensemble.

    Attributes
    ----------
    periods
        How many drive periods.
    directions
        Tangents that are carried along.
    """

    ensemble: Ensemble
    periods: int
    directions: int

    @cached_property
    def problem(self) -> Problem:
        """The trajectories as arrays."""
        return problem(self.ensemble, np.ones(self.ensemble.count))

    @cached_property
    def lengths(self) -> FloatArray:
        """The drive period of each trajectory, tau; NaN-free where that is invalid."""
        return np.where(self.ensemble.invalid, 1.0, require_periods(self.ensemble))

    @cached_property
    def flow(self) -> Callable[..., PeriodMap]:
        """The period map with so many tangents, made once for each choice."""
        asked = self.problem

        @lru_cache
        def flow(directions: int, error_control: ErrorControl = "all") -> PeriodMap:
            return PeriodMap(
                asked.field,
                asked.timeline.waveform,
                directions=directions,
                error_control=error_control,
            )

        return flow

    def advancer(
        self,
        which: IntArray,
        tolerance: float,
        *,
        directions: int | None = None,
        error_control: ErrorControl = "all",
    ) -> Advancer:
        """What advances some of the trajectories, from then on by their number among these."""
        flow = self.flow(self.directions if directions is None else directions, error_control)
        return Advancer(flow, self.problem.parameters[which], self.lengths[which], tolerance)

    def run(
        self,
        which: IntArray,
        tolerance: float,
        states: FloatArray | None = None,
        *,
        directions: int | None = None,
        every: bool = False,
        block: int | None = None,
        cancelled: Callable[[], bool] = lambda: False,
    ) -> Path:
        """Follow some of the trajectories; the errors of their periods stay below `tolerance`.

        They start from `states` (trajectory, state); by default where the ensemble does.  Of
        their tangents no error is known.
        """
        directions = self.directions if directions is None else directions
        return follow(
            self.advancer(which, tolerance, directions=directions, error_control="state"),
            self.problem.initial[which] if states is None else states,
            self.periods,
            directions=directions,
            every=every,
            block=block,
            cancelled=cancelled,
        )

    def follow_with_doubled_steps(
        self,
        which: IntArray,
        tolerance: float,
        *,
        error_control: ErrorControl,
        block: int | None,
        cancelled: Callable[[], bool],
    ) -> tuple[Path, Path]:
        """Follow some of the trajectories, and once more with steps twice as long."""
        first = self.advancer(which, tolerance, error_control=error_control)
        flow = self.flow(self.directions, "none")
        again = CoarseReplay(flow, first.parameters, first.lengths, first.resolution_history)

        def path(advance: Advance) -> Path:
            return follow(
                advance,
                self.problem.initial[which],
                self.periods,
                directions=self.directions,
                block=block,
                cancelled=cancelled,
            )

        return path(first), path(again)

    def blocks(self, block: int | None) -> IntArray:
        """Periods of each block of a run."""
        return block_lengths(self.periods, self.directions, block)

    def each(
        self,
        work: Callable[[IntArray, Callable[[], bool]], T],
        progress: Progress | None,
        *,
        most: int = CHUNK,
    ) -> list[tuple[IntArray, T]]:
        """Do `work` on every chunk of the valid trajectories, in threads.

        A chunk holds every so-manieth trajectory: neighbours cost about the same, and so
        should chunks.
        """
        index = np.flatnonzero(~self.ensemble.invalid)
        threads = os.cpu_count() or 1
        rounds = -(-index.size // (most * threads))
        chunks = [
            some for k in range(rounds * threads) if (some := index[k :: rounds * threads]).size
        ]
        if chunks:
            self.flow(self.directions)  # compiled before the threads ask for it
        stop = threading.Event()
        found: list[tuple[IntArray, T]] = []
        with ThreadPoolExecutor(max_workers=os.cpu_count()) as pool:
            try:
                futures = {pool.submit(work, chunk, stop.is_set): chunk for chunk in chunks}
                for done, future in enumerate(as_completed(futures), start=1):
                    found.append((futures[future], future.result()))
                    if progress is not None:
                        progress(done / len(chunks))
            except BaseException:
                stop.set()
                pool.shutdown(wait=False, cancel_futures=True)
                raise
        return found


def damped(ens: Ensemble) -> BoolArray:
    """Where the motion loses energy, array (trajectory,)."""
    found = ens.system.dissipative(ens.values)
    return np.asarray(np.broadcast_to(found, (ens.count,)))


def status_of(path: Path) -> IntArray:
    """Status of followed trajectories."""
    kinds = np.where(path.trusted, int(Status.OK), int(Status.MAX_STEPS))
    return np.where(path.escaped, int(Status.ESCAPED), kinds)


def gathered(
    parts: list[tuple[IntArray, dict[str, np.ndarray]]],
    ens: Ensemble,
    kinds: Mapping[str, np.ndarray],
) -> dict[str, np.ndarray]:
    """Arrays of all trajectories from those of chunks; what was not computed is NaN, 0 or ''.

    Parameters
    ----------
    kinds
        For each name an array with the type and the later dimensions of its values.
    """
    whole = {name: _empty(name, like, ens) for name, like in kinds.items()}
    for which, values in parts:
        for name in kinds:
            whole[name][which] = values[name]
    return whole


def _empty(name: str, like: np.ndarray, ens: Ensemble) -> np.ndarray:
    shape = (ens.count, *like.shape[1:])
    if name == "status":
        codes = np.where(ens.invalid, int(Status.INVALID), int(Status.NOT_COMPUTED))
        return codes.astype(np.int8)
    if like.dtype.kind == "f":
        return np.full(shape, np.nan)
    return np.zeros(shape, dtype=like.dtype)


def labelled(
    ens: Ensemble,
    variables: Mapping[str, Labelled],
    coords: Mapping[str, Labelled],
    tolerance: float,
    **settings: Any,
) -> xr.Dataset:
    """Variables with their coordinates, labelled and attributed."""
    attributes = provenance.attributes(
        ens.system,
        ens.drive,
        tolerance,
        over=ens.coords,
        **settings,
    )
    return build.dataset(dict(variables), {**ens.coords, **coords}, attributes)
