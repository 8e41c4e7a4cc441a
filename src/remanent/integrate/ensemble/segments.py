"""Cuts a run into segments: calls of a kernel that are short enough to be cancelled between."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from remanent._load_schedule import LoadSchedule
from remanent._typing import FloatArray, IntArray
from remanent.integrate.kernel.layout import PAST_DIFFERENCE_COUNT, PAST_RATE_COUNT

#: Double steps that start a piece.  After them the newest rate is known, all that its backward
#: difference takes and one more, for the difference a step ago; and the past differences of the
#: two solutions.
START_DOUBLE_STEPS = max(-(-(PAST_RATE_COUNT + 1) // 2), PAST_DIFFERENCE_COUNT - 1)


@dataclass(frozen=True)
class Segment:
    """A run of equal cycles, or a part of one: one call of a kernel.

    Attributes
    ----------
    cycle_length : array (trajectory,)
        Of one cycle, tau.
    piece_start : array (trajectory,)
        When the piece begins that the segment is cut from, tau.
    cycle_count, first_cycle : int
        How many cycles; how many of the piece came before them.
    resolution : int
        Double steps in a whole cycle.
    double_step_slice : slice
        Those double steps of the cycle that are taken: all of them if ``cycles > 1``.
    has_past_rates : bool
        Whether rates of enough earlier steps are available.
    parameters : mapping of name to array (trajectory,)
        That hold during this segment.
    is_periodic : bool
        Whether the end of a cycle is the start of the next one.
    """

    cycle_length: FloatArray
    piece_start: FloatArray
    cycle_count: int
    first_cycle: int
    resolution: int
    double_step_slice: slice
    has_past_rates: bool
    parameters: Mapping[str, FloatArray]
    is_periodic: bool

    @property
    def begins_piece(self) -> bool:
        """Whether nothing of the piece comes before."""
        return self.first_cycle == 0 and self.double_step_slice.start == 0

    @property
    def cycles_completed_at_end(self) -> int:
        """Whole cycles that are over when the segment ends; -1 within a cycle."""
        return (
            self.first_cycle + self.cycle_count
            if self.double_step_slice.stop == self.resolution
            else -1
        )

    @property
    def double_steps_per_cycle(self) -> int:
        """Double steps taken in each cycle."""
        return int(self.double_step_slice.stop - self.double_step_slice.start)

    @property
    def fine_step_count(self) -> int:
        """Fine steps of the segment."""
        return 2 * self.double_steps_per_cycle * self.cycle_count

    @property
    def fine_steps_before(self) -> int:
        """Fine steps of the piece before the segment."""
        return int(2 * (self.first_cycle * self.resolution + self.double_step_slice.start))

    @property
    def fine_step_length(self) -> FloatArray:
        """Length of a fine step, tau, array (trajectory,)."""
        return self.cycle_length / (2 * self.resolution)

    @property
    def phase_change_per_fine_step(self) -> float:
        """Change of the phase in a fine step."""
        return 1.0 / (2 * self.resolution)

    def phase_after(self, steps: IntArray | int) -> FloatArray:
        """Phase of the cycle after so many fine steps of the segment."""
        within = np.asarray(2 * self.double_step_slice.start + steps)
        if self.is_periodic:
            within = np.remainder(within, 2 * self.resolution)
        return np.asarray(within / (2 * self.resolution))

    def time_after(
        self,
        steps: IntArray | int,
        part: FloatArray | float = 0.0,
        rows: IntArray | slice = slice(None),
    ) -> FloatArray:
        """Time, tau, of some trajectories at a fraction of fine steps of the segment.

        It is counted from the start of the cycle, as kernels count it, and not from that of
        the segment: where a run is cut must not change a digit.

        Parameters
        ----------
        steps : array (n,)
            Fine steps of the segment before.
        part : array (n,) or float
            Fraction of the next step.
        rows : array (n,) or slice
            Trajectories.
        """
        cycle, within = np.divmod(self.fine_steps_before + steps, 2 * self.resolution)
        start = self.piece_start[rows] + cycle * self.cycle_length[rows]
        return np.asarray(start + (within + part) * self.fine_step_length[rows])


def cut_into_segments(
    load_schedule: LoadSchedule,
    indices: IntArray,
    double_steps: IntArray,
    cycles: int,
    strobe: int,
    most_steps: int,
) -> Iterator[Segment]:
    """Cut the run of some trajectories into segments of at most `most_steps` fine steps.

    The cuts change nothing in what a trajectory undergoes, nor in the times and phases that
    are told of it.

    Parameters
    ----------
    load_schedule : LoadSchedule
        Of all trajectories.
    indices : array (trajectory,)
        Those that run.
    double_steps : array (piece,)
        In a cycle of each piece.
    cycles : int
        Of the longest run, where the load is periodic.
    strobe : int
        If positive, whole segments end after multiples of so many cycles.
    most_steps : int
        Of one trajectory in a segment.
    """
    start = np.zeros(indices.size)
    for k, lengths in enumerate(load_schedule.piece_lengths[:, indices]):
        parameters = {name: v[k, indices] for name, v in load_schedule.piece_parameters.items()}
        total = cycles if load_schedule.periodic else 1
        resolution = int(double_steps[k])
        for first, count, part, has_past in _cut_piece(
            total, resolution, strobe, most_steps, single=not load_schedule.periodic
        ):
            yield Segment(
                lengths,
                start,
                count,
                first,
                resolution,
                part,
                has_past,
                parameters,
                load_schedule.periodic,
            )
        start = start + lengths


#: Cycles before a segment, cycles in it, the part of the cycle that is taken, and whether
#: rates of enough earlier steps are available.
_SegmentCut = tuple[int, int, slice, bool]


def _cut_piece(
    cycles: int, resolution: int, strobe: int, most_steps: int, *, single: bool
) -> Iterator[_SegmentCut]:
    """The segments of one piece: a start, the rest of the cycle it ends in, whole cycles.

    How a step is made must not depend on how many cycles follow, which other
    trajectories decide; a `single` piece is the same for all.
    """
    full_cycle = slice(0, resolution)
    started = -(-START_DOUBLE_STEPS // resolution)  # cycles that the start takes part in
    if single and resolution < 3 * START_DOUBLE_STEPS:
        # So few steps that those of the start are most of them: none is worth another method.
        yield 0, 1, full_cycle, False
        return
    if started > 1:
        yield 0, min(started, cycles), full_cycle, False
    else:
        yield 0, 1, slice(0, START_DOUBLE_STEPS), False
        yield from (
            (0, 1, part, True) for part in _cut_cycle(START_DOUBLE_STEPS, resolution, most_steps)
        )
    per_segment = max(1, most_steps // (2 * resolution))
    if strobe and started % strobe and started < cycles:
        # Segments with a whole number of strobes are recorded by the kernel; come there first.
        aligned = min(strobe - started % strobe, cycles - started)
        yield started, aligned, full_cycle, True
        started += aligned
    if strobe:
        per_segment = strobe * max(1, per_segment // strobe)
    for first in range(started, cycles, per_segment):
        if 2 * resolution <= most_steps or strobe:
            yield first, min(per_segment, cycles - first), full_cycle, True
        else:
            yield from ((first, 1, part, True) for part in _cut_cycle(0, resolution, most_steps))


def _cut_cycle(first: int, resolution: int, most_steps: int) -> Iterator[slice]:
    """Parts of a cycle, from its double step `first` on, that are short enough."""
    size = most_steps // 2
    for begin in range(first, resolution, size):
        yield slice(begin, min(begin + size, resolution))
