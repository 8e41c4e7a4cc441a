"""Picks the states that a request asks for from the steps of a run."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble import dense
from remanent.integrate.ensemble.counts import cycle_counts
from remanent.integrate.ensemble.problem import Window
from remanent.integrate.ensemble.run import Run
from remanent.integrate.ensemble.sample_places import SamplePlaces
from remanent.integrate.ensemble.segments import Segment
from remanent.integrate.kernel.compile import Kernel
from remanent.integrate.kernel.memory import LaneMemory
from remanent.integrate.methods.runge_kutta import default_method


@dataclass(frozen=True)
class Sampler:
    """Runs segments and picks states from each.

    What changes: `states` are filled in, and `findings` grow, with every segment.

    Attributes
    ----------
    run : Run
        What is asked of which trajectories.
    indices : array (trajectory,)
        Numbers of the trajectories.
    times : array (trajectory, time), optional
        When states are wanted, tau.
    cycles : array (trajectory,)
        Cycles of the run of each.
    states : array (trajectory, sample, state), optional
        NaN where not reached.
    findings : list
        What ``Request.inspect`` returned.
    """

    run: Run
    indices: IntArray
    times: FloatArray | None
    cycles: IntArray
    states: FloatArray | None
    findings: list[Any]

    @classmethod
    def empty(cls, run: Run, indices: IntArray, most_cycles: int) -> Self:
        """A sampler before the first segment."""
        problem, request = run.problem, run.request
        times = None if request.times is None else request.times[indices]
        dimension = problem.initial.shape[1]
        states = None
        if request.strobe:
            samples = most_cycles // request.strobe + 1
            states = np.full((indices.size, samples, dimension), np.nan)
            states[:, 0] = problem.initial[indices]
        elif times is not None:
            states = np.full((indices.size, times.shape[1], dimension), np.nan)
        return cls(run, indices, times, cycle_counts(problem, indices), states, [])

    def advance(
        self,
        memory: LaneMemory,
        kernel: Kernel,
        tables: tuple[FloatArray, FloatArray],
        segment: Segment,
    ) -> None:
        """Run one segment and take in what is asked for."""
        places = self._places(segment)
        every = self._every(segment, places)
        before = memory.snapshot("fine").copy()
        count = segment.fine_steps // every if every else 0
        record = np.full((count, *before.shape[1:]), np.nan)
        kernel(
            memory.values,
            tables,
            record,
            cycles=segment.cycles,
            every=every,
            first_cycle=segment.first,
            first_step=2 * segment.part.start,
        )
        if self.run.request.strobe:
            self._strobe(memory, record, every, segment)
        elif count:
            states = memory.by_trajectory(np.concatenate([before, record]))
            if self.run.request.inspect is not None:
                self.findings.append(
                    self.run.request.inspect(self._window(states, memory, segment))
                )
            if places is not None:
                self._interpolate(places, states, memory, segment)

    def _every(self, segment: Segment, places: SamplePlaces | None) -> int:
        """Fine steps between the states that the kernel records in a segment; 0 for none."""
        request = self.run.request
        if request.strobe:
            return self._strobe_interval(segment)
        if request.inspect is not None:
            return 1
        return int(places is not None and places.row.size > 0)

    def _strobe_interval(self, segment: Segment) -> int:
        """Every step in a start, which may end within a stride; else every stride."""
        strobe = self.run.request.strobe
        if not segment.has_past:
            return 1
        complete = segment.double_steps == segment.resolution and segment.first % strobe == 0
        if complete and segment.cycles >= strobe:
            return 2 * segment.double_steps * strobe
        return 0

    def _strobe(self, memory: LaneMemory, record: FloatArray, every: int, segment: Segment) -> None:
        """Keep the state after every so many cycles, recorded or at the end of a segment."""
        assert self.states is not None
        strobe = self.run.request.strobe
        if every == 1 and segment.end > 0:  # a start: every step was recorded
            per_cycle = 2 * segment.double_steps
            due = np.arange(1, segment.cycles + 1) % strobe == 0
            record = record[per_cycle - 1 :: per_cycle][due]
        elif every <= 1:
            due_at_end = segment.end > 0 and segment.end % strobe == 0
            record = memory.snapshot("fine")[: int(due_at_end)].copy()
        states = memory.by_trajectory(record)
        first = segment.first // strobe + 1
        self.states[:, first : first + states.shape[1]] = states

    def _window(self, states: FloatArray, memory: LaneMemory, segment: Segment) -> Window:
        """The states of a segment as what ``Request.inspect`` takes."""
        nodes = np.arange(states.shape[1])
        return Window(
            self.indices,
            states,
            segment,
            segment.phase(nodes),
            memory.parameters(),
            self._steps(segment),
        )

    def _steps(self, segment: Segment) -> IntArray:
        """Steps of the segment that belong to the run of each trajectory."""
        cycles = (self.cycles - segment.first).clip(0, segment.cycles)
        return np.asarray(2 * segment.double_steps * cycles)

    def _places(self, segment: Segment) -> SamplePlaces | None:
        """Where the times lie that belong to a segment."""
        if self.times is None:
            return None
        cycles = self.cycles if segment.periodic else np.ones_like(self.cycles)
        return SamplePlaces.within(segment, self.times, cycles)

    def _interpolate(
        self, places: SamplePlaces, states: FloatArray, memory: LaneMemory, segment: Segment
    ) -> None:
        """Fill in the states at those times that lie in a segment, up to the horizon."""
        assert self.states is not None
        places = places.up_to(memory.column("horizon"))
        parameters = memory.parameters()
        size = self.run.sizes.samples
        for first in range(0, places.row.size, size):
            if self.run.cancelled():
                return
            block = slice(first, first + size)
            row, step, part = places.row[block], places.step[block], places.part[block]
            self.states[row, places.column[block]] = dense.partial_step(
                self.run.problem.field,
                default_method(),
                self.run.problem.timeline.waveform,
                states=states[row, step],
                parameters=list(parameters[:, row]),
                phase=segment.phase(step),
                span=part / (2 * segment.resolution),
                time=part * segment.step[row],
            )
