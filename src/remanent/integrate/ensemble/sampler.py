"""Picks the states that a request asks for from the steps of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from remanent._threads import raise_if_stopped
from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble import dense
from remanent.integrate.ensemble.counts import cycle_counts
from remanent.integrate.ensemble.problem import StepWindow
from remanent.integrate.ensemble.run import Run
from remanent.integrate.ensemble.sample_places import SamplePlaces
from remanent.integrate.ensemble.segments import Segment
from remanent.integrate.kernel.compile import Kernel
from remanent.integrate.kernel.memory import LaneMemory
from remanent.integrate.methods.runge_kutta import default_method


@dataclass(frozen=True)
class Sampler:
    """Runs segments and picks states from each.

    What changes: `states` are filled in, and `inspection_results` grow, with every segment.

    Attributes
    ----------
    run : Run
        What is asked of which trajectories.
    indices : array (trajectory,)
        Numbers of the trajectories.
    times : array (trajectory, time), optional
        When states are wanted, tau.
    cycle_counts : array (trajectory,)
        Cycles of the run of each.
    states : array (trajectory, sample, state), optional
        NaN where not reached.
    inspection_results : list
        What ``Request.inspect_window`` returned.
    """

    run: Run
    indices: IntArray
    times: FloatArray | None
    cycle_counts: IntArray
    states: FloatArray | None
    inspection_results: list[Any]

    @classmethod
    def before_first_segment(cls, run: Run, indices: IntArray, most_cycles: int) -> Self:
        """A sampler before the first segment."""
        problem, request = run.problem, run.request
        times = None if request.times is None else request.times[indices]
        dimension = problem.initial_states.shape[1]
        states = None
        if request.strobe_cycles:
            samples = most_cycles // request.strobe_cycles + 1
            states = np.full((indices.size, samples, dimension), np.nan)
            states[:, 0] = problem.initial_states[indices]
        elif times is not None:
            states = np.full((indices.size, times.shape[1], dimension), np.nan)
        return cls(run, indices, times, cycle_counts(problem, indices), states, [])

    def run_segment(
        self,
        memory: LaneMemory,
        kernel: Kernel,
        tables: tuple[FloatArray, FloatArray],
        segment: Segment,
    ) -> None:
        """Run one segment and take in what is asked for."""
        places = self._sample_places(segment)
        every = self._record_interval_in_fine_steps(segment, places)
        before = memory.vectors_as_record("fine").copy()
        count = segment.fine_step_count // every if every else 0
        record = np.full((count, *before.shape[1:]), np.nan)
        kernel(
            memory.slots,
            tables,
            record,
            cycles=segment.cycle_count,
            every=every,
            first_cycle=segment.first_cycle,
            first_step=2 * segment.double_step_slice.start,
        )
        if self.run.request.strobe_cycles:
            self._take_strobed_states(memory, record, every, segment)
        elif count:
            states = memory.by_trajectory(np.concatenate([before, record]))
            if self.run.request.inspect_window is not None:
                self.inspection_results.append(
                    self.run.request.inspect_window(
                        self._build_step_window(states, memory, segment)
                    )
                )
            if places is not None:
                self._interpolate_samples(places, states, memory, segment)

    def _record_interval_in_fine_steps(self, segment: Segment, places: SamplePlaces | None) -> int:
        """Fine steps between the states that the kernel records in a segment; 0 for none."""
        request = self.run.request
        if request.strobe_cycles:
            return self._strobe_interval_in_fine_steps(segment)
        if request.inspect_window is not None:
            return 1
        return int(places is not None and places.trajectory_rows.size > 0)

    def _strobe_interval_in_fine_steps(self, segment: Segment) -> int:
        """Every step in a start, which may end within a stride; else every stride."""
        strobe = self.run.request.strobe_cycles
        if not segment.has_past_rates:
            return 1
        complete = (
            segment.double_steps_per_cycle == segment.resolution
            and segment.first_cycle % strobe == 0
        )
        if complete and segment.cycle_count >= strobe:
            return 2 * segment.double_steps_per_cycle * strobe
        return 0

    def _take_strobed_states(
        self, memory: LaneMemory, record: FloatArray, every: int, segment: Segment
    ) -> None:
        """Keep the state after every so many cycles, recorded or at the end of a segment."""
        assert self.states is not None
        strobe = self.run.request.strobe_cycles
        if every == 1 and segment.cycles_completed_at_end > 0:  # a start: every step was recorded
            per_cycle = 2 * segment.double_steps_per_cycle
            due = np.arange(1, segment.cycle_count + 1) % strobe == 0
            record = record[per_cycle - 1 :: per_cycle][due]
        elif every <= 1:
            due_at_end = (
                segment.cycles_completed_at_end > 0
                and segment.cycles_completed_at_end % strobe == 0
            )
            record = memory.vectors_as_record("fine")[: int(due_at_end)].copy()
        states = memory.by_trajectory(record)
        first = segment.first_cycle // strobe + 1
        self.states[:, first : first + states.shape[1]] = states

    def _build_step_window(
        self, states: FloatArray, memory: LaneMemory, segment: Segment
    ) -> StepWindow:
        """The states of a segment as what ``Request.inspect_window`` takes."""
        nodes = np.arange(states.shape[1])
        return StepWindow(
            self.indices,
            states,
            segment,
            segment.phase_after(nodes),
            memory.parameters(),
            self._steps_in_run(segment),
        )

    def _steps_in_run(self, segment: Segment) -> IntArray:
        """Steps of the segment that belong to the run of each trajectory."""
        cycles = (self.cycle_counts - segment.first_cycle).clip(0, segment.cycle_count)
        return np.asarray(2 * segment.double_steps_per_cycle * cycles)

    def _sample_places(self, segment: Segment) -> SamplePlaces | None:
        """Where the times lie that belong to a segment."""
        if self.times is None:
            return None
        cycles = self.cycle_counts if segment.is_periodic else np.ones_like(self.cycle_counts)
        return SamplePlaces.in_segment(segment, self.times, cycles)

    def _interpolate_samples(
        self, places: SamplePlaces, states: FloatArray, memory: LaneMemory, segment: Segment
    ) -> None:
        """Fill in the states at those times that lie in a segment, up to the horizon."""
        assert self.states is not None
        places = places.up_to_horizon(memory.column("horizon"))
        parameters = memory.parameters()
        size = self.run.work_sizes.samples_per_block
        for first in range(0, places.trajectory_rows.size, size):
            raise_if_stopped()
            block = slice(first, first + size)
            row, step, part = (
                places.trajectory_rows[block],
                places.fine_steps_before[block],
                places.step_fractions[block],
            )
            self.states[row, places.time_columns[block]] = dense.partial_step(
                self.run.problem.field,
                default_method(),
                self.run.problem.load_schedule.waveforms_at_phase,
                states=states[row, step],
                parameters=list(parameters[:, row]),
                phase=segment.phase_after(step),
                span=part / (2 * segment.resolution),
                time=part * segment.fine_step_length[row],
            )
