"""The two solutions of a group, which advance in lockstep."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from llvmlite import ir

from remanent.integrate.kernel.field_code import LoadTable
from remanent.integrate.kernel.group import GroupSlots, TrajectoryCells
from remanent.integrate.kernel.lanes import Lanes, Mask
from remanent.integrate.kernel.options import Method
from remanent.integrate.kernel.stepping import LoadAtNode, StepEnd, Stepper
from remanent.integrate.methods.runge_kutta import compensated_sum


@dataclass(frozen=True)
class DoubleStepLoads:
    """The load at the nodes of the two fine steps and of the coarse one."""

    first: LoadAtNode
    second: LoadAtNode
    coarse: LoadAtNode


@dataclass(frozen=True)
class Lockstep:
    """The fine solution, which is returned, and the coarse one, whose errors are larger.

    Attributes
    ----------
    fine_step_length : Lanes
        Length of a fine step, tau.
    fine_loads, coarse_loads : LoadTable
        The load at the nodes of the steps of either solution.
    coarse_variable_count : int
        How many of the first state variables the coarse solution has.
    """

    method: Method
    stepper: Stepper
    trajectory_cells: TrajectoryCells
    fine_step_length: Lanes
    fine_loads: LoadTable
    coarse_loads: LoadTable
    coarse_variable_count: int

    def fine_state(self) -> list[Lanes]:
        """State of the fine solution."""
        return self.trajectory_cells.fine.get()

    def coarse_state(self) -> list[Lanes]:
        """State of the coarse solution."""
        return self.trajectory_cells.coarse.get(self.coarse_variable_count)

    def restart_coarse(self) -> None:
        """Start the coarse solution anew from the fine one."""
        self.trajectory_cells.coarse.set(self.fine_state()[: self.coarse_variable_count])

    def loads_in(self, double_step: ir.Value, *, coarse: bool) -> DoubleStepLoads:
        """The load in a double step, at the nodes at which the method needs it.

        Parameters
        ----------
        double_step : ir.Value
            Its number in the cycle.
        coarse : bool
            Whether there is a coarse step too.
        """
        own, nodes = self.fine_loads.own_steps, self.method.load_node_indices
        steps = [(self.fine_loads, 0), (self.fine_loads, 1)]
        # At the end alone the coarse step sees what the second fine step sees.
        shared = nodes == (self.fine_loads.node_count - 1,)
        steps += [(self.coarse_loads, 0)] * (coarse and not shared)

        def of_each() -> list[Lanes]:
            assert own is not None
            own.begin()
            row = own.row(double_step)
            return [v for table, part in steps for v in table.of_each(row, part, nodes)]

        def same_for_all() -> list[Lanes]:
            return [
                value
                for table, part in steps
                for node in nodes
                for value in table.same_for_all(double_step, part, node)
            ]

        w, size = self.fine_loads.writer, self.fine_loads.column_count
        found = iter(same_for_all() if own is None else w.either(own.differ, of_each, same_for_all))
        loads = [{node: [next(found) for _ in range(size)] for node in nodes} for _ in steps]
        first, second, *others = (at.__getitem__ for at in loads)
        return DoubleStepLoads(first, second, others[0] if others else second)

    def fine_step(self, loads: LoadAtNode, moving: Mask | None = None) -> list[Lanes]:
        """A step of h; rounding is compensated where the method says so.

        Parameters
        ----------
        loads : callable
            The load in the step at a node.
        moving : Mask, optional
            Trajectories that take it, if not all do.
        """
        y = self.fine_state()

        def update(change: list[Lanes]) -> list[Lanes]:
            if self.method.has_compensated_sum:
                before = self.trajectory_cells.compensation.get()
                moved, compensation = compensated_sum(y, change, before)
                self.trajectory_cells.compensation.set(_moved(moving, compensation, before))
            else:
                moved = [a + b for a, b in zip(y, change, strict=True)]
            moved = _moved(moving, moved, y)
            self.trajectory_cells.fine.set(moved)
            return moved

        return self.stepper.advance(y, self.fine_step_length, loads, update)

    def coarse_step(
        self,
        fine: tuple[Sequence[Lanes], Sequence[Lanes]],
        loads: LoadAtNode,
        moving: Mask | None = None,
    ) -> list[Lanes]:
        """A double step of the coarse solution, rounded to fewer digits.

        Errors of rounding grow along the motion like any other.  Those of the coarse
        solution are made as much larger as its truncation error is, so that their
        share in the difference of the solutions is what the fine one makes.
        """
        y = self.coarse_state()
        bits = self.method.coarse_solution_lost_bits
        after = self.stepper.advance_coarse(y, fine, self.fine_step_length, loads)
        moved = _moved(moving, [_without_last_bits(x, bits) for x in after], y)
        self.trajectory_cells.coarse.set(moved)
        return moved

    def write_to_slots(self, slots: GroupSlots, double_steps: ir.Value) -> None:
        """Write back both solutions, and the past rates at their ends."""
        b, w = slots.writer.builder, slots.writer
        self.trajectory_cells.write_to_slots(slots)
        last = b.sub(double_steps, w.integer_constant(1))
        end = self.fine_loads.node_count - 1
        fine = self.fine_loads.load_at(last, 1, end)
        coarse = self.coarse_loads.load_at(last, 0, end)
        ends = {
            "fine": StepEnd(self.fine_state, fine),
            "coarse": StepEnd(self.coarse_state, coarse),
        }
        self.stepper.save_past_rates(slots, ends)


def _moved(moving: Mask | None, after: Sequence[Lanes], before: Sequence[Lanes]) -> list[Lanes]:
    """What holds after a step, and of trajectories that do not take it before."""
    if moving is None:
        return list(after)
    return [moving.select(a, b) for a, b in zip(after, before, strict=True)]


def _without_last_bits(x: Lanes, bits: int) -> Lanes:
    """`x` without its last `bits` bits, to the nearest.

    Adding a number 2**bits times as large pushes the last bits out of the mantissa.
    """
    large = x * 2.0**bits
    return (x + large) - large
