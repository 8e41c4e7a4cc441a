"""The numbers of one group of trajectories while the code for it is written.

Each object here stands for values that the *kernel* reads, keeps in registers and writes back;
in Python it is built whole and never changes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from llvmlite import ir

from remanent.integrate.kernel.lanes import Cell, Lanes, Mask, Writer
from remanent.integrate.kernel.layout import (
    CHANGING_SCALAR_NAMES,
    CONSTANT_SCALAR_NAMES,
    STATE_VECTOR_NAMES,
    SlotLayout,
)


@dataclass(frozen=True)
class GroupSlots:
    """The slots of one group in the array ``(group, slot, lane)``.

    Attributes
    ----------
    writer : Writer
        Where the instructions go.
    slots_pointer : ir.Value
        Pointer to the array.
    layout : SlotLayout
        The slot of each number, by its name.
    group_number : ir.Value
        Number of the group.
    """

    writer: Writer
    slots_pointer: ir.Value
    layout: SlotLayout
    group_number: ir.Value

    def read(self, name: str) -> Lanes:
        """The number called `name` of every trajectory of the group."""
        return self.writer.load_lanes(self.slots_pointer, self._slot_index(name))

    def write(self, name: str, value: Lanes) -> None:
        """Put back the number called `name`."""
        self.writer.store_lanes(value, self.slots_pointer, self._slot_index(name))

    def parameters(self) -> list[Lanes]:
        """The parameters of every trajectory of the group."""
        return [self.read(f"parameter.{i}") for i in range(self.layout.parameter_count)]

    def _slot_index(self, name: str) -> ir.Value:
        b, w = self.writer.builder, self.writer
        base = b.mul(self.group_number, w.integer_constant(self.layout.slot_count * w.lane_count))
        return b.add(base, w.integer_constant(self.layout.slot_of_name[name] * w.lane_count))


@dataclass(frozen=True)
class RunConstants:
    """What does not change while a kernel runs; see :data:`~.layout.CONSTANT_SCALAR_NAMES`."""

    fine_step_length: Lanes
    cycle_length: Lanes
    piece_start: Lanes
    extremes_begin: Lanes
    run_end: Lanes
    tolerance: Lanes
    error_ceiling: Lanes
    own_double_steps: Lanes
    first_row: Lanes

    @classmethod
    def read(cls, slots: GroupSlots) -> Self:
        """Read them from the slots of a group."""
        return cls(**{name: slots.read(name) for name in CONSTANT_SCALAR_NAMES})


@dataclass(frozen=True)
class Cycle:
    """The cycle whose steps are being written.

    Attributes
    ----------
    cycles_before_in_call : ir.Value
        How many cycles of this call came before.
    start_time, fine_step_length : Lanes
        Time of its beginning, and length of a fine step, tau.
    fine_steps_before : ir.Value
        Fine steps of the cycle that come before those of this call.
    """

    cycles_before_in_call: ir.Value
    start_time: Lanes
    fine_step_length: Lanes
    fine_steps_before: ir.Value

    def step_time(self, step: ir.Value) -> Lanes:
        """Time, tau, at the beginning of a fine step of the call in the cycle."""
        w = self.start_time.writer
        return self.time_after(w.broadcast_integer(w.builder.add(self.fine_steps_before, step)))

    def time_after(self, fine_steps: Lanes) -> Lanes:
        """Time, tau, after so many fine steps of the cycle."""
        # Counted from the start of the cycle, so that no digit depends on where calls begin.
        return self.start_time + fine_steps * self.fine_step_length


@dataclass(frozen=True)
class VectorCells:
    """One mutable cell for each component of a vector."""

    cells: tuple[Cell, ...]

    @classmethod
    def with_values(cls, writer: Writer, values: Sequence[Lanes]) -> Self:
        """New cells with these values."""
        return cls(tuple(writer.new_cell_with(value) for value in values))

    def get(self, count: int | None = None) -> list[Lanes]:
        """The vector, or its first `count` components."""
        return [cell.get() for cell in self.cells[:count]]

    def set(self, values: Sequence[Lanes]) -> None:
        """Replace the first components."""
        for cell, value in zip(self.cells, values, strict=False):
            cell.set(value)

    def set_where(self, where: Mask, values: Sequence[Lanes]) -> None:
        """Replace the first components of some trajectories."""
        for cell, value in zip(self.cells, values, strict=False):
            cell.set_where(where, value)


@dataclass(frozen=True)
class TrajectoryCells:
    """What changes while a kernel runs.

    The names are those of :data:`~.layout.STATE_VECTOR_NAMES` and `CHANGING_SCALAR_NAMES`.
    Cells, which the optimiser turns into registers, are read from the slots of a group once
    and written back once.
    """

    fine: VectorCells
    compensation: VectorCells
    coarse: VectorCells
    at_horizon: VectorCells
    fading_difference: VectorCells
    within_tolerance: Cell
    horizon: Cell
    error_to_horizon: Cell
    largest_error: Cell
    maximum: Cell
    minimum: Cell
    maximum_time: Cell
    minimum_time: Cell
    watched_rate_sign: Cell

    @classmethod
    def read_from_slots(cls, slots: GroupSlots) -> Self:
        """Read the cells from the slots of a group."""

        def cell(name: str) -> Cell:
            return slots.writer.new_cell_with(slots.read(name))

        def vector(kind: str) -> VectorCells:
            return VectorCells(tuple(cell(f"{kind}.{i}") for i in range(slots.layout.state_count)))

        return cls(
            fine=vector("fine"),
            compensation=vector("compensation"),
            coarse=vector("coarse"),
            at_horizon=vector("at_horizon"),
            fading_difference=vector("fading_difference"),
            within_tolerance=cell("within_tolerance"),
            horizon=cell("horizon"),
            error_to_horizon=cell("error_to_horizon"),
            largest_error=cell("largest_error"),
            maximum=cell("maximum"),
            minimum=cell("minimum"),
            maximum_time=cell("maximum_time"),
            minimum_time=cell("minimum_time"),
            watched_rate_sign=cell("watched_rate_sign"),
        )

    def write_to_slots(self, slots: GroupSlots) -> None:
        """Write the cells back."""
        for kind in STATE_VECTOR_NAMES:
            for i, cell in enumerate(getattr(self, kind).cells):
                slots.write(f"{kind}.{i}", cell.get())
        for name in CHANGING_SCALAR_NAMES:
            slots.write(name, getattr(self, name).get())
