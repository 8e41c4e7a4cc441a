"""A field and a method become one function over groups of trajectories.

The kernel advances two solutions in lockstep, of which the second has larger errors.  Their
difference after each double step estimates the error of the first at that instant, so the
bound costs half as much as the solution, needs no memory, and gives the time up to which the
tolerance was met.

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
from remanent.integrate.kernel.field_code import FieldCode, LoadTable, build_outlined_fields
from remanent.integrate.kernel.group import Cycle, GroupSlots, RunConstants, TrajectoryCells
from remanent.integrate.kernel.lanes import Lanes, Writer, begin_function
from remanent.integrate.kernel.lockstep import Lockstep
from remanent.integrate.kernel.options import KernelOptions, Method, build_slot_layout
from remanent.integrate.kernel.own_steps import OwnClocks, OwnSteps, own_steps_of_group
from remanent.integrate.kernel.recorder import Recorder
from remanent.integrate.kernel.stepping import create_stepper

#: Name of the function in the object code.
KERNEL_FUNCTION_NAME = "kernel"


@dataclass(frozen=True)
class KernelArguments:
    """The arguments of a kernel, in order.

    Attributes
    ----------
    slots_pointer : pointer to double
        ``(group, slot, lane)``, see :class:`~remanent.integrate.kernel.layout.SlotLayout`.
    fine_table, coarse_table : pointer to double
        See :func:`~remanent.integrate.kernel.tables.build_waveform_tables`.
    record_pointer : pointer to double
        ``(record, group, state, lane)``.
    group_count, cycle_count, double_step_count, record_interval_in_fine_steps : integer
        Number of groups, of cycles, of double steps per cycle, and of fine steps between
        records (0: none).
    cycles_before, fine_steps_before : integer
        Cycles of the piece before this call, and fine steps of each cycle before those that
        are taken.
    """

    slots_pointer: ir.Value
    fine_table: ir.Value
    coarse_table: ir.Value
    record_pointer: ir.Value
    group_count: ir.Value
    cycle_count: ir.Value
    double_step_count: ir.Value
    record_interval_in_fine_steps: ir.Value
    cycles_before: ir.Value
    fine_steps_before: ir.Value


def kernel_source(
    field: Field,
    method: Method,
    options: KernelOptions,
    lane_count: int,
    *,
    estimates: bool = False,
) -> str:
    """LLVM assembly of the kernel ``void kernel(...)`` with these :class:`KernelArguments`.

    Parameters
    ----------
    field : Field
        What moves.
    method : RungeKuttaMethod or AdamsMethod
        What it is integrated with.
    options : KernelOptions
        What is followed.
    lane_count : int
        Trajectories per group.
    estimates : bool
        The code is for a processor that estimates reciprocals of eight numbers at once.
    """
    writer, arguments = begin_function(KERNEL_FUNCTION_NAME, 4, 6, lane_count, estimates=estimates)
    _write_group_loop(field, method, options, writer, KernelArguments(*arguments))
    writer.builder.ret_void()
    return str(writer.builder.module)


def _write_group_loop(
    field: Field,
    method: Method,
    options: KernelOptions,
    writer: Writer,
    argument_values: KernelArguments,
) -> None:
    """Write the loop over groups."""
    outlined = build_outlined_fields(field, method, options, writer)
    with writer.loop(argument_values.group_count) as (group, _):
        slots = GroupSlots(
            writer, argument_values.slots_pointer, build_slot_layout(field, options), group
        )
        run = RunConstants.read(slots)
        code = FieldCode.with_parameters_of(field, slots, outlined)
        kernel = GroupKernel.from_slots(method, options, slots, argument_values, run, code)
        kernel.write_loops()
        kernel.lockstep.write_to_slots(slots, argument_values.double_step_count)


@dataclass(frozen=True)
class GroupKernel:
    """Everything that the code for one group consists of.

    Attributes
    ----------
    extreme_tracker : ExtremeTracker, optional
        Where extremes are followed.
    own_steps : OwnSteps, optional
        Where lanes have their own.
    """

    options: KernelOptions
    writer: Writer
    argument_values: KernelArguments
    run_constants: RunConstants
    lockstep: Lockstep
    error_monitor: ErrorMonitor
    extreme_tracker: ExtremeTracker | None
    recorder: Recorder
    own_steps: OwnSteps | None

    @classmethod
    def from_slots(
        cls,
        method: Method,
        options: KernelOptions,
        slots: GroupSlots,
        argument_values: KernelArguments,
        run: RunConstants,
        code: FieldCode,
    ) -> GroupKernel:
        """Read the numbers of a group."""
        w = slots.writer
        cells = TrajectoryCells.read_from_slots(slots)
        nodes, columns = len(method.nodes), 1 + len(code.field.waveform_names)
        b, args = w.builder, argument_values
        before = b.add(
            b.mul(args.cycles_before, args.double_step_count),
            b.sdiv(args.fine_steps_before, w.integer_constant(2)),
        )
        own = own_steps_of_group(options.own_steps, run, before)
        fine, coarse = (
            LoadTable(w, table, nodes, columns, times, own)
            for table, times in (
                (argument_values.fine_table, 2),
                (argument_values.coarse_table, 1),
            )
        )
        stepper = create_stepper(method, options, code, slots)
        count = options.coarse_variable_count or len(code.field.state_names)
        monitor = ErrorMonitor.for_method(method, options, w, run, cells)
        tracker = None
        if options.follows_extremes:
            with_coarse = options.has_coarse_solution
            tracker = ExtremeTracker.at_call_begin(
                method, code, run, cells, fine, monitor, coarse_solution=with_coarse
            )
        return cls(
            options,
            w,
            argument_values,
            run,
            Lockstep(method, stepper, cells, run.fine_step_length, fine, coarse, count),
            monitor,
            tracker,
            Recorder(
                w,
                argument_values.record_pointer,
                argument_values.group_count,
                slots.group_number,
                argument_values.record_interval_in_fine_steps,
            ),
            own,
        )

    def write_loops(self) -> None:
        """Write the loops over cycles and over the double steps of a cycle.

        Where lanes go on by clocks of their own a cycle is a number of double steps, which is no
        larger than that of any of their cycles.
        """
        w, run = self.writer, self.run_constants
        with w.loop(self.argument_values.cycle_count) as (number, leave_if):
            # Counted from the start of the piece, so that no digit depends on where calls begin.
            count = w.broadcast_integer(w.builder.add(self.argument_values.cycles_before, number))
            start = run.piece_start + count * run.cycle_length
            cycle = Cycle(
                number, start, run.fine_step_length, self.argument_values.fine_steps_before
            )
            now = self._start_time(cycle, w.integer_constant(0), has_begun=False)
            leave_if(w.builder.not_(self.error_monitor.is_followed_from(now).any_lane()))
            if self.options.estimates_error_per_cycle:
                self.lockstep.restart_coarse()
            near_an_end = (
                self.extreme_tracker.any_lane_near_tracking_limit(now)
                if self.extreme_tracker
                else None
            )
            with w.loop(self.argument_values.double_step_count) as (double_step, _):
                self._write_double_step(cycle, double_step, near_an_end)
            if self.options.own_steps == "waiting":
                fine_steps = self._fine_steps_of(w.builder.add(number, w.integer_constant(1)))
                self.recorder.record_if_due(fine_steps, self.lockstep.fine_state())
        if self.extreme_tracker:
            self.extreme_tracker.resolve_kept_step()

    def _write_double_step(
        self, cycle: Cycle, number: ir.Value, near_an_end: ir.Value | None
    ) -> None:
        """Write two fine steps and a coarse one, and what is learnt from them."""
        b, w, own = self.writer.builder, self.writer, self.own_steps
        left, coarse_left = self.lockstep.fine_state(), self.lockstep.coarse_state()
        moving = None if own is None else own.moving(number)
        loads = self.lockstep.loads_in(number, coarse=self.options.has_coarse_solution)
        middle = self.lockstep.fine_step(loads.first, moving)
        right = self.lockstep.fine_step(loads.second, moving)
        states = StepStates(left, middle, right, None, None)
        if self.options.has_coarse_solution:
            coarse_right = self.lockstep.coarse_step((left, right), loads.coarse, moving)
            states = StepStates(left, middle, right, coarse_left, coarse_right)

        def start_time() -> Lanes:
            return self._start_time(cycle, number)

        if self.extreme_tracker and near_an_end is not None:
            self.extreme_tracker.keep_eventful_step(states, number, loads, start_time, near_an_end)
        elif states.coarse_right is not None:
            self.error_monitor.compare_states(left, right, states.coarse_right, start_time())
        if self.options.own_steps != "waiting":
            first = b.mul(number, w.integer_constant(2))
            count = b.add(self._fine_steps_of(cycle.cycles_before_in_call), first)
            self.recorder.record_if_due(b.add(count, w.integer_constant(1)), middle)
            self.recorder.record_if_due(b.add(count, w.integer_constant(2)), right)

    def _start_time(self, cycle: Cycle, number: ir.Value, *, has_begun: bool = True) -> Lanes:
        """Time, tau, at the beginning of a double step."""
        w, own = self.writer, self.own_steps
        first = w.builder.mul(number, w.integer_constant(2))
        if not isinstance(own, OwnClocks):
            return cycle.step_time(first)
        (time,) = w.either(
            own.differ,
            lambda: [own.time(of_next=not has_begun)],
            lambda: [cycle.step_time(first)],
        )
        return time

    def _fine_steps_of(self, cycles: ir.Value) -> ir.Value:
        """Fine steps of so many cycles of the call."""
        b, w = self.writer.builder, self.writer
        return b.mul(cycles, b.mul(self.argument_values.double_step_count, w.integer_constant(2)))
