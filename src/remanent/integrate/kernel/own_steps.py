"""Groups whose lanes differ in how many double steps they take in a cycle.

Sixteen trajectories are advanced in the time of one, so that a group should be full even where
few trajectories need steps as short as some do.  All lanes take their double steps together, each
of its own length.  So they come to the ends of their cycles at different times: they *wait* there
for each other, or each *goes on* by a clock of its own.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from llvmlite import ir

from remanent.integrate.kernel.group import Cycle, RunConstants
from remanent.integrate.kernel.lanes import Cell, Lanes, Mask, Writer, smaller
from remanent.integrate.kernel.options import OwnStepsKind


class OwnSteps(Protocol):
    """Where the lanes of a group are, each in its own cycle."""

    @property
    def differ(self) -> ir.Value:
        """Whether the lanes of this group differ; nothing else counts where they do not."""

    def begin(self) -> None:
        """Note that a double step begins, where lanes differ."""

    def row(self, number: ir.Value) -> Lanes:
        """Rows of the table of the coarse steps, at a double step that has begun."""

    def moving(self, number: ir.Value) -> Mask | None:
        """Lanes that take the double step with this number, if not all do."""


@dataclass(frozen=True)
class WaitingLanes:
    """Lanes that wait for each other at the ends of their cycles.

    Attributes
    ----------
    differ : ir.Value
    double_steps, moving_until : Lanes
        In a cycle of each lane; the second is infinite where lanes do not differ.
    first_row : Lanes
        Of the table of the coarse steps where those of the lane begin.
    """

    differ: ir.Value
    double_steps: Lanes
    moving_until: Lanes
    first_row: Lanes

    def begin(self) -> None:
        pass

    def row(self, number: ir.Value) -> Lanes:
        steps = self.double_steps.writer.broadcast_integer(number)
        return self.first_row + smaller(steps, self.double_steps - 1.0)

    def moving(self, number: ir.Value) -> Mask:
        return self.moving_until > self.moving_until.writer.broadcast_integer(number)


@dataclass(frozen=True)
class OwnClocks:
    """Lanes that go on into their next cycles.

    Attributes
    ----------
    differ : ir.Value
    run_constants : RunConstants
    cycle, within : Cell
        Cycles of the piece that are over, and double steps of this one, before the double step
        that began last.
    next_cycle, next_within : Cell
        The same before the next double step.
    """

    differ: ir.Value
    run_constants: RunConstants
    cycle: Cell
    within: Cell
    next_cycle: Cell
    next_within: Cell

    def row(self, _number: ir.Value) -> Lanes:
        return self.run_constants.first_row + self.within.get()

    def moving(self, _number: ir.Value) -> None:
        return None

    def begin(self) -> None:
        now, cycle = self.next_within.get(), self.next_cycle.get()
        self.within.set(now)
        self.cycle.set(cycle)
        after = now + 1.0
        ends = after >= self.run_constants.own_double_steps
        self.next_within.set(ends.select(now.writer.constant(0.0), after))
        self.next_cycle.set(ends.select(cycle + 1.0, cycle))

    def time(self, *, of_next: bool = False) -> Lanes:
        """Time, tau, at the beginning of the double step that began last, or of the next."""
        run, nothing = self.run_constants, self.within.writer.integer_constant(0)
        number, within = (
            (self.next_cycle, self.next_within) if of_next else (self.cycle, self.within)
        )
        start = run.piece_start + number.get() * run.cycle_length
        cycle = Cycle(nothing, start, run.fine_step_length, nothing)
        return cycle.time_after(within.get() * 2.0)


def own_steps_of_group(
    kind: OwnStepsKind, run: RunConstants, double_steps_before: ir.Value
) -> OwnSteps | None:
    """The steps of a group; None where all lanes of all groups take the same.

    Parameters
    ----------
    kind : {"none", "waiting", "going on"}
    run : RunConstants
        Of the group.
    double_steps_before : ir.Value
        Of the piece, before this call.
    """
    own = run.own_double_steps
    w: Writer = own.writer
    differ = (own > 0.0).any_lane()
    if kind == "waiting":
        always = w.constant(float("inf"))
        return WaitingLanes(differ, own, (own > 0.0).select(own, always), run.first_row)
    if kind == "going on":
        before = w.broadcast_integer(double_steps_before)
        cycle = w.call_math_function("floor", before / own)
        within = before - cycle * own
        cells = [w.new_cell_with(value) for value in (cycle, within, cycle, within)]
        return OwnClocks(differ, run, *cells)
    return None
