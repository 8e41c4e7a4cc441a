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
from remanent.integrate.kernel.layout import CONSTANTS, RESULTS, STATES, Layout


@dataclass(frozen=True)
class GroupSlots:
    """The slots of one group in the array ``(group, slot, lane)``.

    Attributes
    ----------
    writer : Writer
        Where the instructions go.
    memory : ir.Value
        Pointer to the array.
    layout : Layout
        The slot of each number, by its name.
    group : ir.Value
        Number of the group.
    """

    writer: Writer
    memory: ir.Value
    layout: Layout
    group: ir.Value

    def read(self, name: str) -> Lanes:
        """The number called `name` of every trajectory of the group."""
        return self.writer.load(self.memory, self._index(name))

    def write(self, name: str, value: Lanes) -> None:
        """Put back the number called `name`."""
        self.writer.store(value, self.memory, self._index(name))

    def parameters(self) -> list[Lanes]:
        """The parameters of every trajectory of the group."""
        return [self.read(f"parameter.{i}") for i in range(self.layout.parameters)]

    def _index(self, name: str) -> ir.Value:
        b, w = self.writer.builder, self.writer
        base = b.mul(self.group, w.integer(self.layout.size * w.width))
        return b.add(base, w.integer(self.layout.slots[name] * w.width))


@dataclass(frozen=True)
class RunConstants:
    """What does not change while a kernel runs; see :data:`~.layout.CONSTANTS`."""

    step: Lanes
    cycle: Lanes
    start: Lanes
    begin: Lanes
    end: Lanes
    tolerance: Lanes
    error_ceiling: Lanes

    @classmethod
    def read(cls, slots: GroupSlots) -> Self:
        """Read them from the slots of a group."""
        return cls(**{name: slots.read(name) for name in CONSTANTS})


@dataclass(frozen=True)
class Cycle:
    """The cycle whose steps are being written.

    Attributes
    ----------
    number : ir.Value
        How many cycles of this call came before.
    start, step : Lanes
        Time of its beginning, and length of a fine step, tau.
    first_step : ir.Value
        Fine steps of the cycle that come before those of this call.
    """

    number: ir.Value
    start: Lanes
    step: Lanes
    first_step: ir.Value

    def time(self, step: ir.Value) -> Lanes:
        """Time, tau, at the beginning of a fine step of the call in the cycle."""
        # Counted from the start of the cycle, so that no digit depends on where calls begin.
        w = self.start.writer
        return self.start + w.spread_integer(w.builder.add(self.first_step, step)) * self.step


@dataclass(frozen=True)
class VectorCells:
    """One mutable cell for each component of a vector."""

    cells: tuple[Cell, ...]

    @classmethod
    def holding(cls, writer: Writer, values: Sequence[Lanes]) -> Self:
        """New cells with these values."""
        return cls(tuple(writer.variable(value) for value in values))

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
    """What changes while a kernel runs; see :data:`~.layout.STATES` and `RESULTS` there.

    Cells, which the optimiser turns into registers, are read from the slots of a group once
    and written back once.
    """

    fine: VectorCells
    compensation: VectorCells
    coarse: VectorCells
    at_horizon: VectorCells
    within_tolerance: Cell
    horizon: Cell
    error_to_horizon: Cell
    largest_error: Cell
    maximum: Cell
    minimum: Cell
    direction: Cell

    @classmethod
    def load(cls, slots: GroupSlots) -> Self:
        """Read the cells from the slots of a group."""

        def cell(name: str) -> Cell:
            return slots.writer.variable(slots.read(name))

        def vector(kind: str) -> VectorCells:
            return VectorCells(tuple(cell(f"{kind}.{i}") for i in range(slots.layout.states)))

        return cls(
            fine=vector("fine"),
            compensation=vector("compensation"),
            coarse=vector("coarse"),
            at_horizon=vector("at_horizon"),
            within_tolerance=cell("within_tolerance"),
            horizon=cell("horizon"),
            error_to_horizon=cell("error_to_horizon"),
            largest_error=cell("largest_error"),
            maximum=cell("maximum"),
            minimum=cell("minimum"),
            direction=cell("direction"),
        )

    def save(self, slots: GroupSlots) -> None:
        """Write the cells back."""
        for kind in STATES:
            for i, cell in enumerate(getattr(self, kind).cells):
                slots.write(f"{kind}.{i}", cell.get())
        for name in RESULTS:
            slots.write(name, getattr(self, name).get())
