"""Ensembles followed over many drive periods, a chunk at a time, in threads."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

from remanent._machine import available_processor_count
from remanent._status import Status
from remanent._threads import StoppableThreads, as_finished
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.limit_orbits import IterateWithJacobian
from remanent.analysis.regimes.long_runs import (
    LongRun,
    TangentMap,
    block_lengths_in_periods,
    propagate_tangents,
)
from remanent.analysis.regimes.orbit_exponents import (
    MapsOfTwoResolutions,
    OrbitExponents,
    orbit_exponents,
)
from remanent.integrate.ensemble.problem import Problem
from remanent.integrate.ensemble.resolution import round_up_resolution
from remanent.integrate.maps.advance import BlockAdvancer, CoarseReplay
from remanent.integrate.maps.period_map import ErrorControl, PeriodMap
from remanent.integrate.methods.runge_kutta import default_method
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.memory import require_memory
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.progress import ProgressFunction

#: Trajectories followed together: enough of each resolution to fill the lanes of a kernel.
TRAJECTORIES_PER_CHUNK = 4096
#: Bound of a period's error for orbits that motions settle on, at most.
LIMIT_ORBIT_TOLERANCE = 1e-9
#: Double steps per period of the coarser of two maps, at least.
MIN_COARSE_RESOLUTION = 4
#: Error of what a map gives over its difference from that of steps twice as long.
ERROR_PER_DIFFERENCE = default_method().error_per_solution_difference
#: Why a run of its full length has no exponent.
_STRONG_CONTRACTION_REASON = (
    "no exponent: differences shrink within one period to less than numbers can hold"
)
#: Arrays by name.
NamedArrays = Mapping[str, np.ndarray]
#: ``work(indices)``: arrays (trajectory, ...) of a chunk of trajectories.
ChunkFunction = Callable[[IntArray], NamedArrays]


def require_memory_for_runs(
    ens: Ensemble, periods: int, bytes_per_period: float, chunk_size: int = TRAJECTORIES_PER_CHUNK
) -> None:
    """Refuse runs that are too long for the memory that this process may use.

    Parameters
    ----------
    ens : Ensemble
    periods : int
        Length of each run.
    bytes_per_period : float
        What one run needs for each of its periods while it is worked on.
    chunk_size : int
        Trajectories that one thread follows together, at most.

    Raises
    ------
    InputError
        If the runs that are worked on at once need more than may be taken.
    """
    together = min(ens.trajectory_count, chunk_size * available_processor_count())
    require_memory(
        "periods", bytes_per_period * together * periods, f"{together} runs of {periods} periods"
    )


@dataclass(frozen=True)
class EnsembleFollower:
    """Follows trajectories of an ensemble.

    What it returns of a trajectory depends on that trajectory alone.

    Attributes
    ----------
    ensemble : Ensemble
    periods : int
        How many drive periods.
    tangent_count : int
        Tangents that are carried along.
    """

    ensemble: Ensemble
    periods: int
    tangent_count: int

    @cached_property
    def problem(self) -> Problem:
        """The trajectories as arrays."""
        return initial_value_problem(self.ensemble, np.ones(self.ensemble.trajectory_count))

    @cached_property
    def period_lengths(self) -> FloatArray:
        """The drive period of each trajectory in tau, array (trajectory,); 1 where invalid."""
        return np.where(self.ensemble.is_invalid, 1.0, require_drive_periods(self.ensemble))

    @cached_property
    def period_map_maker(self) -> Callable[..., PeriodMap]:
        """``period_map(directions, error_control)``: the map, made once for each pair of these."""
        field, waveform = self.problem.field, self.problem.load_schedule.waveforms_at_phase

        @lru_cache
        def period_map(directions: int, error_control: ErrorControl = "all") -> PeriodMap:
            # Chunks of trajectories have threads of their own.
            return PeriodMap(
                field, waveform, directions=directions, error_control=error_control,
                is_threaded=False, expected_points=self.ensemble.trajectory_count,
            )  # fmt: skip

        return period_map

    def make_advancer(
        self,
        indices: IntArray,
        tolerance: float,
        *,
        directions: int | None = None,
        error_control: ErrorControl = "all",
    ) -> BlockAdvancer:
        """What advances a subset of the trajectories, which it numbers from 0."""
        flow = self.period_map_maker(
            self.tangent_count if directions is None else directions, error_control
        )
        return BlockAdvancer(
            flow, self.problem.parameters[indices], self.period_lengths[indices], tolerance
        )

    def follow(
        self,
        indices: IntArray,
        tolerance: float,
        states: FloatArray | None = None,
        *,
        directions: int | None = None,
        every: bool = False,
    ) -> LongRun:
        """Follow a subset of the trajectories.

        Parameters
        ----------
        indices : array (trajectory,) of int
        tolerance : float
            Bound of the state's error in each period.  The errors of tangents are not known.
        states : array (trajectory, state), optional
            Where they start; by default where the ensemble does.
        directions : int, optional
            Tangents carried along, if not those of the follower.
        every : bool
            Whether to keep the state after every period.
        """
        directions = self.tangent_count if directions is None else directions
        return propagate_tangents(
            self.make_advancer(indices, tolerance, directions=directions, error_control="state"),
            self.problem.initial_states[indices] if states is None else states,
            self.periods,
            directions=directions,
            every=every,
        )

    def follow_with_doubled_steps(
        self,
        indices: IntArray,
        tolerance: float,
        *,
        error_control: ErrorControl,
        block: int | None,
        kept: int,
    ) -> tuple[LongRun, LongRun]:
        """Follow a subset of the trajectories, and once more with steps twice as long.

        The difference of the two runs is the error of discretisation: the second repeats the
        resolutions that the first chose, halved, and so has nothing of its own to choose.
        The first keeps the states after about the last `kept` periods.
        """
        fine = self.make_advancer(indices, tolerance, error_control=error_control)
        flow = self.period_map_maker(self.tangent_count, "none")
        coarse = CoarseReplay(flow, fine.parameters, fine.period_lengths, fine.resolution_history)

        def path(advance: TangentMap, every: int) -> LongRun:
            return propagate_tangents(
                advance,
                self.problem.initial_states[indices],
                self.periods,
                directions=self.tangent_count,
                every=every,
                block=block,
            )

        return path(fine, kept), path(coarse, 0)

    def iterate_map(self, indices: IntArray, tolerance: float) -> IterateWithJacobian:
        """Images and Jacobians of a subset's maps, within a bound of a period's error."""
        dimension = len(self.ensemble.vector_field.state_names)
        advance = self.make_advancer(indices, tolerance, directions=dimension)

        def image(
            subset: IntArray, states: FloatArray, period: int
        ) -> tuple[FloatArray, FloatArray]:
            unit = np.tile(np.eye(dimension), (subset.size, 1, 1))
            step = advance(subset, states, unit, period, every=False)
            return step.visited_states[:, -1], np.moveaxis(step.tangents, 1, 2)

        return image

    def settled_orbits(
        self, indices: IntArray, states: FloatArray, period: IntArray, tolerance: float
    ) -> OrbitExponents:
        """The periodic orbits, of known periods, that a subset's motions end on.

        Parameters
        ----------
        indices : array (trajectory,) of int
        states : array (trajectory, state)
            Near the orbits.
        period : array (trajectory,) of int
            Of each orbit; 0 where there is none.
        tolerance : float
            Bound of a period's error.  An orbit takes few periods, so that a finer one than
            this may be used.
        """
        tolerance = min(tolerance, LIMIT_ORBIT_TOLERANCE)
        dimension = len(self.ensemble.vector_field.state_names)
        flow = self.period_map_maker(dimension, "all")
        unchecked = self.period_map_maker(dimension, "none")
        parameters, lengths = self.problem.parameters[indices], self.period_lengths[indices]

        def maps_of_orbits(orbits: IntArray, near: FloatArray, q: int) -> MapsOfTwoResolutions:
            enough = flow(
                near, parameters[orbits], lengths[orbits], tolerance=tolerance, cycles=q
            ).resolution
            # Whole double steps of the coarser map, and not so few that its error says nothing.
            resolution = np.zeros(indices.size, dtype=np.int64)
            resolution[orbits] = round_up_resolution(
                np.maximum(0.5 * enough, MIN_COARSE_RESOLUTION)
            )

            def at_resolution(factor: int) -> IterateWithJacobian:
                def image(
                    some: IntArray, states: FloatArray, periods: int
                ) -> tuple[FloatArray, FloatArray]:
                    step = unchecked(
                        states,
                        parameters[some],
                        lengths[some],
                        tolerance=np.inf,
                        cycles=periods,
                        resolution=factor * resolution[some],
                    )
                    return step.state, np.moveaxis(step.tangents, 1, 2)

                return image

            return at_resolution(2), at_resolution(1)

        return orbit_exponents(
            self.iterate_map(indices, tolerance),
            maps_of_orbits,
            np.arange(indices.size),
            states,
            period,
            ERROR_PER_DIFFERENCE,
        )

    def block_lengths_in_periods(self, block: int | None) -> IntArray:
        """Periods between renormalisations of the tangents, array (block,)."""
        return block_lengths_in_periods(self.periods, self.tangent_count, block)

    def compute_in_chunks(
        self,
        work: ChunkFunction,
        templates: NamedArrays,
        report: ProgressFunction | None,
        *,
        chunk_size: int = TRAJECTORIES_PER_CHUNK,
    ) -> dict[str, np.ndarray]:
        """Do `work` on every chunk of the valid trajectories, in threads.

        Parameters
        ----------
        work : callable
        templates : mapping of str to array (0, ...)
            For each name an array with the type and the later dimensions of its values.
        report : callable or None
        chunk_size : int
            Trajectories in a chunk, at most.

        Returns
        -------
        dict of str to array (trajectory, ...)
            What was not computed is NaN, 0 or an empty text.
        """
        results = {
            name: _missing_values(name, like, self.ensemble) for name, like in templates.items()
        }
        chunks = self._chunk_indices(chunk_size)
        if chunks:
            self.period_map_maker(self.tangent_count)  # compiled before the threads ask for it
        for indices, values in _run_in_threads(work, chunks, report):
            for name, result in results.items():
                result[indices] = values[name]
        return results

    def _chunk_indices(self, chunk_size: int) -> list[IntArray]:
        """Indices of the valid trajectories, chunk by chunk.

        Neighbours on a grid cost about the same.  Each stretch of them is dealt out to as many
        chunks as there are threads, so that these cost about the same too; and what needs very
        short steps is found in few stretches, where it fills its groups.  The last stretches are
        begun first: larger loads take longer, and what takes long should not come last.
        """
        indices = np.flatnonzero(~self.ensemble.is_invalid)
        threads = available_processor_count()
        stretches = max(1, -(-indices.size // (chunk_size * threads)))
        chunks = (
            stretch[k::threads]
            for stretch in reversed(np.array_split(indices, stretches))
            for k in range(threads)
        )
        return [chunk for chunk in chunks if chunk.size]


def _run_in_threads(
    work: ChunkFunction, chunks: list[IntArray], report: ProgressFunction | None
) -> list[tuple[IntArray, NamedArrays]]:
    """Results of `work` with the chunks they are of; an interrupt stops all threads."""
    results: list[tuple[IntArray, NamedArrays]] = []
    with StoppableThreads() as pool:
        futures = {pool.submit(work, chunk): chunk for chunk in chunks}
        for done, future in enumerate(as_finished(futures), start=1):
            results.append((futures[future], future.result()))
            if report is not None:
                report(done / len(chunks))
    return results


def _missing_values(name: str, template: np.ndarray, ens: Ensemble) -> np.ndarray:
    """The values of trajectories that are not computed, array (trajectory, ...)."""
    if name == "status":
        codes = np.where(ens.is_invalid, int(Status.INVALID), int(Status.NOT_COMPUTED))
        return codes.astype(np.int8)
    shape = (ens.trajectory_count, *template.shape[1:])
    if template.dtype.kind in "fc":
        return np.full(shape, np.nan, dtype=template.dtype)
    return np.zeros(shape, dtype=template.dtype)


def is_damped(ens: Ensemble) -> BoolArray:
    """Where the motion loses energy, array (trajectory,)."""
    dissipative = ens.system.where_dissipative(ens.parameter_values)
    return np.asarray(np.broadcast_to(dissipative, (ens.trajectory_count,)))


def missing_exponent_reasons(exponent: FloatArray, status: IntArray) -> np.ndarray:
    """Why exponents (trajectory, ...) of finished runs are missing, empty text where they are not.

    Nothing else than a contraction to 0 within a period leaves such a run without one.
    """
    unknown = np.isnan(exponent).reshape(len(exponent), -1).any(axis=1)
    finished = np.isin(status, (Status.OK, Status.INCOMPLETE))
    return np.where(unknown & finished, _STRONG_CONTRACTION_REASON, "")


def status_of_run(path: LongRun) -> IntArray:
    """Status of followed trajectories, array (trajectory,)."""
    codes = np.where(path.error_bound_met, int(Status.OK), int(Status.MAX_STEPS))
    return np.where(path.escaped, int(Status.ESCAPED), codes)
