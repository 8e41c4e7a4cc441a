"""A field and a method become one function over groups of trajectories.

The kernel advances two solutions in lockstep, one with steps of length h and one
with steps of length 2h.  Their difference after each double step, divided by
2**(counted order) - 1 and multiplied by a safety factor, estimates the error of the finer
one at that instant, so the bound costs half as much as the solution, needs no
memory, and gives the time up to which the tolerance was met.

Its parts are written by objects of their own: the field by
:class:`~.field_code.FieldCode`, the steps by :class:`~.lockstep.Lockstep`, error control by
:class:`~.error_monitor.ErrorMonitor`, extremes by :class:`~.extreme_tracker.ExtremeTracker`
and records by :class:`~.recorder.Recorder`.  Code is written by running Python once, so that
the order of the calls below is the order of the instructions.
"""

from __future__ import annotations

from dataclasses import dataclass

from llvmlite import ir

from remanent._field import Field
from remanent.integrate.kernel.error_monitor import ErrorMonitor
from remanent.integrate.kernel.extreme_tracker import ExtremeTracker, StepStates
from remanent.integrate.kernel.field_code import FieldCode, LoadTable, outlined_rates
from remanent.integrate.kernel.group import Cycle, GroupSlots, RunConstants, TrajectoryCells
from remanent.integrate.kernel.lanes import DOUBLE, INTEGER, Writer
from remanent.integrate.kernel.lockstep import Lockstep
from remanent.integrate.kernel.options import Method, Options, layout_of
from remanent.integrate.kernel.recorder import Recorder
from remanent.integrate.kernel.stepping import stepper_for

#: Name of the function in the object code.
NAME = "kernel"


@dataclass(frozen=True)
class Arguments:
    """The arguments of a kernel, in order.

    Attributes
    ----------
    lanes : pointer to double
        ``(group, slot, lane)``, see :class:`~remanent.integrate.kernel.layout.Layout`.
    fine, coarse : pointer to double
        See :func:`~remanent.integrate.kernel.tables.waveform_tables`.
    record : pointer to double
        ``(record, group, state, lane)``.
    groups, cycles, double_steps, every : integer
        Number of groups, of cycles, of double steps per cycle, and of fine steps between
        records (0: none).
    first_cycle, first_step : integer
        Cycles of the piece before this call, and fine steps of each cycle before those that
        are taken.
    """

    lanes: ir.Value
    fine: ir.Value
    coarse: ir.Value
    record: ir.Value
    groups: ir.Value
    cycles: ir.Value
    double_steps: ir.Value
    every: ir.Value
    first_cycle: ir.Value
    first_step: ir.Value


def kernel_source(
    field: Field, method: Method, options: Options, width: int, *, estimates: bool = False
) -> str:
    """LLVM assembly of the kernel ``void kernel(...)`` with these :class:`Arguments`.

    Parameters
    ----------
    field : Field
        What moves.
    method : RungeKutta or Adams
        What it is integrated with.
    options : Options
        What is followed.
    width : int
        Trajectories per group.
    estimates : bool
        The code is for a processor that estimates reciprocals of eight numbers at once.
    """
    module = ir.Module(name="remanent")
    pointer = DOUBLE.as_pointer()
    signature = ir.FunctionType(ir.VoidType(), [pointer] * 4 + [INTEGER] * 6)
    function = ir.Function(module, signature, NAME)
    # Cells are allocated in a block of their own, which is run once.
    builder = ir.IRBuilder(function.append_basic_block("entry"))
    begin = function.append_basic_block("begin")
    builder.branch(begin)
    builder.position_at_end(begin)
    writer = Writer(builder, width, estimates)
    _write(field, method, options, writer, Arguments(*function.args))
    builder.ret_void()
    return str(module)


def _write(
    field: Field, method: Method, options: Options, writer: Writer, arguments: Arguments
) -> None:
    """Write the loop over groups."""
    outlined = outlined_rates(field, method, options, writer)
    with writer.loop(arguments.groups) as (group, _):
        slots = GroupSlots(writer, arguments.lanes, layout_of(field, options), group)
        run = RunConstants.read(slots)
        code = FieldCode.load(field, slots, outlined)
        kernel = GroupKernel.load(method, options, slots, arguments, run, code)
        kernel.write()
        kernel.solutions.save(slots, arguments.double_steps)


@dataclass(frozen=True)
class GroupKernel:
    """Everything that the code for one group consists of.

    Attributes
    ----------
    tracker : ExtremeTracker, optional
        Where extremes are followed.
    """

    options: Options
    writer: Writer
    arguments: Arguments
    run: RunConstants
    solutions: Lockstep
    monitor: ErrorMonitor
    tracker: ExtremeTracker | None
    recorder: Recorder

    @classmethod
    def load(
        cls,
        method: Method,
        options: Options,
        slots: GroupSlots,
        arguments: Arguments,
        run: RunConstants,
        code: FieldCode,
    ) -> GroupKernel:
        """Read the numbers of a group."""
        w = slots.writer
        cells = TrajectoryCells.load(slots)
        nodes, columns = len(method.nodes), 1 + len(code.field.waveforms)
        fine, coarse = (
            LoadTable(w, table, nodes, columns) for table in (arguments.fine, arguments.coarse)
        )
        stepper = stepper_for(method, options, code, slots)
        count = options.coarse_variables or len(code.field.state_names)
        monitor = ErrorMonitor.of(method, options, w, run, cells)
        tracker = None
        if options.extremes:
            with_coarse = options.coarse_solution
            tracker = ExtremeTracker.begin(
                code, run, cells, fine, monitor, coarse_solution=with_coarse
            )
        return cls(
            options,
            w,
            arguments,
            run,
            Lockstep(method, stepper, cells, run.step, fine, coarse, count),
            monitor,
            tracker,
            Recorder(w, arguments.record, arguments.groups, slots.group, arguments.every),
        )

    def write(self) -> None:
        """Write the loops over cycles and over the double steps of a cycle."""
        w, run = self.writer, self.run
        with w.loop(self.arguments.cycles) as (number, leave_if):
            # Counted from the start of the piece, so that no digit depends on where calls begin.
            count = w.spread_integer(w.builder.add(self.arguments.first_cycle, number))
            start = run.start + count * run.cycle
            cycle = Cycle(number, start, run.step, self.arguments.first_step)
            leave_if(w.builder.not_(self.monitor.active(cycle).any()))
            if self.options.error_per_cycle:
                self.solutions.restart_coarse()
            near_an_end = self.tracker.near_an_end(cycle) if self.tracker else None
            with w.loop(self.arguments.double_steps) as (double_step, _):
                self._double_step(cycle, double_step, near_an_end)
        if self.tracker:
            self.tracker.resolve()

    def _double_step(self, cycle: Cycle, number: ir.Value, near_an_end: ir.Value | None) -> None:
        """Write two fine steps and a coarse one, and what is learnt from them."""
        b, w = self.writer.builder, self.writer
        first = b.mul(number, w.integer(2))
        second = b.add(first, w.integer(1))
        left, coarse_left = self.solutions.fine_state(), self.solutions.coarse_state()
        middle = self.solutions.fine_step(first)
        right = self.solutions.fine_step(second)
        states = StepStates(left, middle, right, None, None)
        if self.options.coarse_solution:
            coarse_right = self.solutions.coarse_step(number)
            states = StepStates(left, middle, right, coarse_left, coarse_right)
        if self.tracker and near_an_end is not None:
            self.tracker.note(states, cycle, first, second, near_an_end)
        elif states.coarse_right is not None:
            self.monitor.compare_states(left, right, states.coarse_right, cycle.time(first))
        count = b.mul(cycle.number, b.mul(self.arguments.double_steps, w.integer(2)))
        count = b.add(count, first)
        self.recorder.note(b.add(count, w.integer(1)), middle)
        self.recorder.note(b.add(count, w.integer(2)), right)
