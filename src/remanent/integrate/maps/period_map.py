"""The map over whole drive periods, with its derivatives: what analysis works on.

Unlike an ensemble's run, a map is applied again and again to states that analysis chooses
(Newton's guesses, renormalised tangents), so the error that counts is that of each period.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from remanent._field import Field
from remanent._threads import results_of_all
from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble.resolution import (
    FINE_RESOLUTION_LADDER,
    MAX_RESOLUTION,
    refine_resolution,
    round_up_resolution,
)
from remanent.integrate.kernel.compile import Kernel, compiled_kernel
from remanent.integrate.kernel.memory import LaneMemory
from remanent.integrate.kernel.options import KernelOptions
from remanent.integrate.kernel.tables import cycle_tables
from remanent.integrate.methods.runge_kutta import default_method
from remanent.integrate.variations import field_with_tangents

#: Whose errors are controlled: those of the state and of the derivatives, of the state alone,
#: or none.
ErrorControl = Literal["all", "state", "none"]
#: Groups of a segment, that is one call of a kernel, at most: their records stay small.
_GROUPS_PER_SEGMENT = 32
#: Double steps of groups that make a chunk, the task of a thread: about a millisecond.
_DOUBLE_STEPS_PER_CHUNK = 4096
#: Double steps per period to begin with.
_FIRST_RESOLUTION = 8
#: Errors from here on no longer follow the order of the method.
_ASYMPTOTIC_ERROR_LIMIT = 1.0
#: Errors below this are round-off where steps shorter by the factor below do not halve them.
_LARGEST_ROUND_OFF = 1e-10
_TELLING_REFINEMENT_FACTOR = 1.4


@dataclass(frozen=True)
class PeriodMapImage:
    """What a map made of some states.

    Attributes
    ----------
    state : array (point, state)
        After the last period.
    tangents : array (point, column, state)
        Derivatives, those along directions first, then those by parameters.
    largest_period_error : array (point,)
        Estimated largest error that one period adds: of the state absolute, of the
        tangents, where theirs is controlled, relative to the largest of them.
    resolution : array (point,)
        Double steps per period.
    visited_states : array (point, period, state), optional
        The state after each period.
    last_state_error : array (point, state), optional
        Estimated error that the last period adds to each variable of the state, with its sign:
        with the factor of safety of :class:`~remanent.integrate.kernel.options.KernelOptions`.
    last_tangents_error : array (point, column, state), optional
        The same of the tangents.
    """

    state: FloatArray
    tangents: FloatArray
    largest_period_error: FloatArray
    resolution: IntArray
    visited_states: FloatArray | None
    last_state_error: FloatArray | None = None
    last_tangents_error: FloatArray | None = None


@dataclass(frozen=True)
class _MapExtent:
    """How far a map is applied.

    Attributes
    ----------
    periods : int
        Periods.
    adds_half_period : bool
        Half a period more.
    keeps_visited_states : bool
        Keep the state after each period.
    """

    periods: int
    adds_half_period: bool
    keeps_visited_states: bool


@dataclass(frozen=True)
class _StartingPoints:
    """Where a map is applied.

    Attributes
    ----------
    states_and_tangents : array (point, component)
        State and tangents.
    parameters : array (point, parameter)
    period_lengths : array (point,)
        Of a period, tau.
    """

    states_and_tangents: FloatArray
    parameters: FloatArray
    period_lengths: FloatArray

    def subset(self, indices: IntArray) -> _StartingPoints:
        """Some of the points."""
        return _StartingPoints(
            self.states_and_tangents[indices],
            self.parameters[indices],
            self.period_lengths[indices],
        )


@dataclass(frozen=True)
class _Segment:
    """Some groups that are advanced by one call of the kernel.

    Attributes
    ----------
    groups : slice
        Several of one resolution, or one whose lanes differ.
    levels : array (lane,) of int
        The resolutions of the lanes of each group.
    """

    groups: slice
    levels: IntArray

    @property
    def finest_level(self) -> int:
        """Of the lanes, which take as long as the finest of them."""
        return int(self.levels[0])

    @property
    def is_mixed(self) -> bool:
        """Whether its lanes differ."""
        return bool(self.levels[-1] != self.levels[0])


@dataclass(frozen=True)
class _Lanes:
    """Which points are computed where: those of one resolution are neighbours.

    Attributes
    ----------
    points : array (lane,) of int
        The point of each lane.  The last group is filled up with copies.
    levels : array (lane,) of int
        The resolution of each lane, the finest first.
    lane_count : int
        Lanes of a group.
    """

    points: IntArray
    levels: IntArray
    lane_count: int

    @classmethod
    def of_points(cls, points: IntArray, levels: IntArray, lane_count: int) -> _Lanes:
        """Lanes for points that have these resolutions."""
        order = np.argsort(-levels, kind="stable")
        padded = -(-levels.size // lane_count) * lane_count
        order = order[np.minimum(np.arange(padded), levels.size - 1)]
        return cls(points[order], levels[order], lane_count)

    def segments(self) -> Iterator[_Segment]:
        """All groups: those of one resolution together, and each whose lanes differ by itself."""
        levels = self.levels.reshape(-1, self.lane_count)
        is_mixed = levels[:, 0] != levels[:, -1]
        changes = (np.diff(levels[:, 0], prepend=-1) != 0) | is_mixed
        changes[1:] |= is_mixed[:-1]
        firsts = np.flatnonzero(changes).tolist()
        for begin, end in itertools.pairwise([*firsts, len(levels)]):
            for first in range(begin, end, _GROUPS_PER_SEGMENT):
                groups = slice(first, min(first + _GROUPS_PER_SEGMENT, end))
                yield _Segment(groups, levels[begin])

    def chunks(self, periods: int) -> list[list[_Segment]]:
        """The segments, in chunks that are worth a thread."""
        chunks: list[list[_Segment]] = []
        room = 0
        for segment in self.segments():
            if room <= 0:
                chunks.append([])
                room = _DOUBLE_STEPS_PER_CHUNK
            chunks[-1].append(segment)
            room -= (segment.groups.stop - segment.groups.start) * segment.finest_level * periods
        return chunks


class PeriodMap:
    """A field over whole periods of its load.

    Tables of the load are remembered; no result depends on earlier calls.

    Parameters
    ----------
    field : Field
        Of the motion.
    waveform : callable
        ``waveform(phase)``: the field's waveforms, array (waveform, *phase.shape).
    direction_count : int
        How many directions of the initial state are carried along.
    parameters : sequence of str
        Parameters with respect to which derivatives are carried along, or
        :data:`~remanent.integrate.variations.LOG_PERIOD_PARAMETER_NAME`.
    phase : float
        Of the load where a period begins, in [0, 1).
    error_control : {"all", "state", "none"}
        Whose errors are controlled: "all", that of the derivatives too; "state", of the state
        alone, which takes less time; or "none", so that the map takes the steps it is told.
    resolution_ladder : array of int
        The resolutions there are.
    is_threaded : bool
        Threads share the work of one call; whoever calls from many threads does without.
    expected_points : int, optional
        How many points a call has, where they are known to be few.
    """

    def __init__(
        self,
        field: Field,
        waveform: Callable[[FloatArray], FloatArray],
        *,
        directions: int = 0,
        parameters: Sequence[str] = (),
        phase: float = 0.0,
        error_control: ErrorControl = "all",
        resolution_ladder: IntArray = FINE_RESOLUTION_LADDER,
        is_threaded: bool = True,
        expected_points: int | None = None,
    ) -> None:
        self.field, self.dimension = field, len(field.state_names)
        self.direction_count, self.column_count = directions, directions + len(parameters)
        with_tangents = field_with_tangents(field, directions=directions, parameters=parameters)
        method = default_method()
        # The state does not depend on its tangents, so that the coarse solution may do
        # without them where only the state's error is controlled.
        state_only = error_control == "state" and self.column_count > 0
        options = KernelOptions(
            estimates_error_per_cycle=True,
            has_coarse_solution=error_control != "none",
            absolute_error_count=self.dimension,
            coarse_variable_count=self.dimension if state_only else None,
            own_steps="waiting",
        )
        self.kernel: Kernel = compiled_kernel(
            with_tangents if self.column_count else field, method, options,
            trajectory_count=expected_points,
        )  # fmt: skip
        self.order = method.order
        self._cycle_tables = cycle_tables(waveform, phase)
        self._resolution_ladder = resolution_ladder
        self._is_threaded = is_threaded

    def __call__(
        self,
        states: FloatArray,
        parameters: FloatArray,
        length: FloatArray,
        *,
        tolerance: FloatArray | float,
        cycles: int = 1,
        half: bool = False,
        tangent: FloatArray | None = None,
        resolution: IntArray | int = _FIRST_RESOLUTION,
        max_resolution: int = MAX_RESOLUTION,
        visited: bool = False,
    ) -> PeriodMapImage:
        """Apply the map to many states.

        Parameters
        ----------
        states : array (point, state)
            To start from.
        parameters : array (point, parameter)
            In the order of ``field.parameter_names``.
        length : array (point,)
            Of a period, tau.
        tolerance : array (point,) or float
            Of the error that one period adds.
        cycles : int
            Periods.
        half : bool
            Half a period more.
        tangent : array (point, column, state), optional
            To start from; by default unit directions, and nothing along parameters.
        resolution : array (point,) or int
            Double steps per period to begin with; the image says which were enough.
        max_resolution : int
            Most double steps per period; points that need more keep the error they have.  So do
            points whose error is round-off, which shorter steps do not make smaller.
        visited : bool
            Keep the state after each period.

        Returns
        -------
        Image
        """
        count, d = states.shape[0], self.dimension
        points = _StartingPoints(self._states_and_tangents(states, tangent), parameters, length)
        course = _MapExtent(cycles, half, visited)
        first = round_up_resolution(np.asarray(resolution), self._resolution_ladder)
        levels = np.broadcast_to(first, (count,)).copy()
        levels += levels % 2 if half else 0  # half a period needs whole double steps
        tolerances = np.broadcast_to(np.asarray(tolerance, dtype=np.float64), (count,))
        ends, error = np.full(points.states_and_tangents.shape, np.nan), np.full(count, np.inf)
        last_error = np.full(ends.shape, np.nan)
        path = np.full((count, cycles, d), np.nan) if visited else None
        halved_error, halved_level = np.full(count, np.inf), np.zeros(count, dtype=np.int64)
        pending = np.arange(count)
        while pending.size:
            lanes = _Lanes.of_points(pending, levels[pending], self.kernel.lane_count)
            memory = self._initial_memory(points.subset(lanes.points), lanes.levels, course)
            self._advance(memory, lanes, course, path)
            ends[lanes.points] = fine = memory.state_vectors("fine")
            difference = fine - memory.state_vectors("coarse")
            last_error[lanes.points] = self.kernel.method.error_per_solution_difference * difference
            error[lanes.points] = memory.column("largest_error")
            halved = pending[error[pending] < 0.5 * halved_error[pending]]
            halved_error[halved], halved_level[halved] = error[halved], levels[halved]
            is_round_off = (error < _LARGEST_ROUND_OFF) & (
                levels >= _TELLING_REFINEMENT_FACTOR * halved_level
            )
            missed = pending[~(error[pending] <= tolerances[pending]) & ~is_round_off[pending]]
            finer = self._refined_resolutions(
                error[missed], tolerances[missed], levels[missed], half
            )
            pending = missed[finer <= max_resolution]
            levels[pending] = finer[finer <= max_resolution]
        columns, columns_error = (
            vectors[:, d:].reshape(count, self.column_count, d) for vectors in (ends, last_error)
        )
        return PeriodMapImage(
            ends[:, :d], columns, error, levels, path, last_error[:, :d], columns_error
        )

    def _states_and_tangents(self, states: FloatArray, tangent: FloatArray | None) -> FloatArray:
        """States followed by their tangents, array (point, component)."""
        count = states.shape[0]
        if tangent is None:
            tangent = np.zeros((count, self.column_count, self.dimension))
            for k in range(self.direction_count):
                tangent[:, k, k] = 1.0
        return np.concatenate(
            [states, tangent.reshape(count, math.prod(tangent.shape[1:]))], axis=1
        )

    def _refined_resolutions(
        self, error: FloatArray, tolerance: FloatArray, levels: IntArray, half: bool
    ) -> IntArray:
        """The resolutions to try next."""
        finer = refine_resolution(
            levels, error, tolerance, self.order,
            asymptotic_limit=_ASYMPTOTIC_ERROR_LIMIT, ladder=self._resolution_ladder,
        )  # fmt: skip
        return np.asarray(finer + (finer % 2 if half else 0))

    def _advance(
        self, memory: LaneMemory, lanes: _Lanes, course: _MapExtent, path: FloatArray | None
    ) -> None:
        """Advance points in place, and write their states after each period into `path`."""

        def advance(chunk: list[_Segment]) -> None:
            for segment in chunk:
                record = self._advance_segment(memory, segment, course)
                if path is not None and record is not None:
                    begin, end = (
                        group * lanes.lane_count
                        for group in (segment.groups.start, segment.groups.stop)
                    )
                    states = memory.by_trajectory(record)[:, :, : self.dimension]
                    path[lanes.points[begin:end]] = states

        all_at_once = [[*lanes.segments()]]
        results_of_all(advance, lanes.chunks(course.periods) if self._is_threaded else all_at_once)

    def _advance_segment(
        self, memory: LaneMemory, segment: _Segment, course: _MapExtent
    ) -> FloatArray | None:
        """Advance some groups in place; the states after each period where asked."""
        lanes, level = memory.slots[segment.groups], segment.finest_level
        slot_of_name = self.kernel.layout.slot_of_name
        nodes = self.kernel.method.nodes
        if segment.is_mixed:
            tables, first_row = self._cycle_tables.of_lanes(nodes, segment.levels)
            lanes[:, slot_of_name["first_row"]] = first_row
            lanes[:, slot_of_name["own_double_steps"]] = segment.levels
        else:
            tables = self._cycle_tables(nodes, level)
        record = None
        if course.periods:
            if course.keeps_visited_states:
                states = self.kernel.layout.state_count
                record = np.empty((course.periods, lanes.shape[0], states, lanes.shape[2]))
            every = 2 * level if course.keeps_visited_states else 0
            self.kernel(
                lanes, tables, record, cycles=course.periods, every=every, double_steps=level
            )
        if course.adds_half_period:
            lanes[:, slot_of_name["own_double_steps"]] /= 2
            self.kernel(lanes, tables, None, cycles=1, double_steps=level // 2)
        return record

    def _initial_memory(
        self, points: _StartingPoints, levels: IntArray, course: _MapExtent
    ) -> LaneMemory:
        """The numbers of some points before the first period."""
        vectors = {
            "fine": points.states_and_tangents,
            "coarse": points.states_and_tangents,
            "parameter": points.parameters,
        }
        scalars: dict[str, FloatArray | float] = {
            "cycle_length": points.period_lengths,
            "fine_step_length": points.period_lengths / (2 * levels),
            # Later than the end of the run, so that no cycle is left out.
            "run_end": 2.0 * (course.periods + 1) * points.period_lengths,
            "tolerance": np.inf,
            "error_ceiling": np.inf,
            "within_tolerance": 1.0,
        }
        return LaneMemory.with_values(self.kernel.layout, self.kernel.lane_count, vectors, scalars)
