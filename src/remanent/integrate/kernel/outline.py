"""Long rates, and steps with them, as functions of their own, which a kernel calls.

A Runge-Kutta step of order 8 evaluates the rates eleven times, and a kernel holds three
steps.  Written out in place, a field with many states and tangents takes the compiler half
a minute.  Here the rates are one function, and a step is another, in which what is done for
every variable is a loop: the calls and loops cost little beside so long a computation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Self

from llvmlite import ir

from remanent._field import Field, Program
from remanent.integrate.kernel.lanes import (
    DOUBLE_TYPE,
    LaneFunctions,
    Lanes,
    Writer,
    reciprocal_quotient,
)
from remanent.integrate.methods.runge_kutta import RungeKuttaMethod

#: Rates with more instructions than this are called.
MAX_INLINED_INSTRUCTIONS = 200
#: Where arrays begin: a vector that lies in two lines of the cache is read twice.
_CACHE_LINE_BYTES = 64


@dataclass(frozen=True)
class LaneArray:
    """Vectors of lanes in memory, one after the other.

    Attributes
    ----------
    writer : Writer
        Of the function that reads and writes them.
    pointer : ir.Value
        To the first.
    """

    writer: Writer
    pointer: ir.Value

    @classmethod
    def allocate(cls, writer: Writer, count: int) -> Self:
        """Room for so many, as long as the function of the writer runs."""
        with writer.builder.goto_entry_block():
            pointer = writer.builder.alloca(
                DOUBLE_TYPE, writer.integer_constant(count * writer.lane_count)
            )
        pointer.align = _CACHE_LINE_BYTES
        return cls(writer, pointer)

    def part_from(self, first: int) -> LaneArray:
        """Those from number `first` on."""
        return replace(self, pointer=self.writer.builder.gep(self.pointer, [self._place(first)]))

    def load(self, count: int) -> list[Lanes]:
        """The first `count`."""
        return [self.writer.load_lanes(self.pointer, self._place(i)) for i in range(count)]

    def store(self, values: Sequence[Lanes]) -> None:
        """Replace the first."""
        for i, value in enumerate(values):
            self.writer.store_lanes(value, self.pointer, self._place(i))

    def load_at(self, number: ir.Value) -> Lanes:
        """One of them, whose number is known when the code runs."""
        return self.writer.load_lanes(self.pointer, self._place_at(number))

    def store_of_every(self, count: int, value_of: Callable[[ir.Value], Lanes]) -> None:
        """Replace the first `count` in a loop, by what is computed from the number of each."""
        with self.writer.loop(self.writer.integer_constant(count)) as (number, _):
            self.writer.store_lanes(value_of(number), self.pointer, self._place_at(number))

    def _place(self, number: int) -> ir.Value:
        return self.writer.integer_constant(number * self.writer.lane_count)

    def _place_at(self, number: ir.Value) -> ir.Value:
        return self.writer.builder.mul(number, self._place(1))


@dataclass(frozen=True)
class OfEveryVariable:
    """A number that every state variable has: written down once, computed in a loop over them.

    Attributes
    ----------
    value_of : callable
        Writes the instructions for one variable, from its number.
    """

    value_of: Callable[[ir.Value], Lanes]

    def __add__(self, other: OfEveryVariable) -> OfEveryVariable:
        return OfEveryVariable(lambda number: self.value_of(number) + other.value_of(number))

    def __mul__(self, other: OfEveryVariable | float) -> OfEveryVariable:
        def product(number: ir.Value) -> Lanes:
            factor = other.value_of(number) if isinstance(other, OfEveryVariable) else other
            return self.value_of(number) * factor

        return OfEveryVariable(product)


class OutlinedField:
    """The rates of a field's first `count` variables, and a step with them, as functions.

    What depends on parameters alone is computed by :meth:`prepare_parameters`, once for a group.
    """

    def __init__(self, field: Field, method: RungeKuttaMethod, writer: Writer, count: int) -> None:
        self._writer = writer
        self._count = count
        self._first_waveform = 1 + len(field.state_names)  # among the inputs of the rates
        rates = replace(field.rates, output_slots=field.rates.output_slots[:count])
        self._fixed_program, self._moving_program = split_program(rates, field.parameter_names)
        load_size = (1 + len(field.waveform_names)) * len(method.nodes)
        self._inputs = LaneArray.allocate(writer, len(self._moving_program.input_names))
        self._start = LaneArray.allocate(writer, 1 + load_size + count)
        self._slopes = LaneArray.allocate(writer, method.evaluations_per_step * count)
        self._change = LaneArray.allocate(writer, count)
        self._rates_function = _write_rates_function(self._moving_program, writer, count)
        self._step_function = _write_step_function(
            self._rates_function, field, method, writer, count
        )

    def prepare_parameters(self, parameters: Sequence[Lanes]) -> None:
        """Take over the parameters of a group."""
        w = self._writer
        values = self._fixed_program(
            list(parameters), functions=LaneFunctions(w), constant=w.constant
        )
        self._inputs.part_from(len(self._moving_program.input_names) - len(values)).store(values)
        absent = [w.constant(0.0)] * (self._first_waveform - 1 - self._count)
        self._inputs.part_from(1 + self._count).store(absent)

    def rates(self, y: Sequence[Lanes], load: Sequence[Lanes]) -> list[Lanes]:
        """The rates under a load, which is the phase and the waveforms."""
        self._inputs.store([load[0], *y])
        self._inputs.part_from(self._first_waveform).store(load[1:])
        self._call(self._rates_function, self._inputs, self._slopes)
        return self._slopes.load(self._count)

    def step(
        self, y: Sequence[Lanes], h: Lanes, loads: Sequence[Sequence[Lanes]]
    ) -> tuple[list[Lanes], list[Lanes]]:
        """The rates at the beginning of a step, and what the step adds to the state.

        Parameters
        ----------
        y : sequence of Lanes
            State at the beginning.
        h : Lanes
            Length of the step, tau.
        loads : sequence (node,) of sequence of Lanes
            The load at every node: the phase and the waveforms.
        """
        self._start.store([h, *(value for load in loads for value in load), *y])
        self._call(self._step_function, self._start, self._inputs, self._slopes, self._change)
        return self._slopes.load(self._count), self._change.load(self._count)

    def _call(self, function: ir.Function, *arrays: LaneArray) -> None:
        self._writer.builder.call(function, [array.pointer for array in arrays])


def split_program(program: Program, fixed: Iterable[str]) -> tuple[Program, Program]:
    """A program in two: what depends on the inputs `fixed` alone, and the rest.

    Returns
    -------
    first : Program
        Of the inputs `fixed`; its outputs are what the rest needs of them.
    rest : Program
        Of the other inputs and the outputs of `first`.
    """
    names = tuple(fixed)
    count, base = len(program.input_names), len(program.input_names) + len(program.constants)
    fixed_slots = {i for i, name in enumerate(program.input_names) if name in names}
    available = fixed_slots | set(range(count, base))
    early, late = [], []
    for slot, (operation, *operands) in enumerate(program.instructions, start=base):
        if fixed_slots.intersection(operands) and available.issuperset(operands):
            fixed_slots.add(slot)
            available.add(slot)
            early.append((slot, operation, operands))
        else:
            late.append((slot, operation, operands))
    used = [*(k for _, _, operands in late for k in operands), *program.output_slots]
    passed_on = tuple(dict.fromkeys(k for k in used if k in fixed_slots))
    moving_slots = tuple(i for i in range(count) if i not in fixed_slots)
    first = _renumbered_program(
        program, names, tuple(map(program.input_names.index, names)), early, passed_on
    )
    moving = (program.input_names[i] for i in moving_slots)
    inputs = (*moving, *(f"fixed.{k}" for k in range(len(passed_on))))
    return first, _renumbered_program(
        program, inputs, (*moving_slots, *passed_on), late, program.output_slots
    )


def _renumbered_program(
    program: Program,
    inputs: tuple[str, ...],
    slots: tuple[int, ...],
    code: Sequence[tuple[int, str, list[int]]],
    outputs: tuple[int, ...],
) -> Program:
    """A part of a program, whose inputs have these slots in the program itself."""
    constants = range(len(program.input_names), len(program.input_names) + len(program.constants))
    order = [*slots, *constants, *(slot for slot, _, _ in code)]
    at = {slot: k for k, slot in enumerate(order)}
    return Program(
        input_names=inputs,
        constants=program.constants,
        instructions=tuple(  # each with one or two operands
            (operation, *map(at.__getitem__, operands))  # type: ignore[misc]
            for _, operation, operands in code
        ),
        output_slots=tuple(at[slot] for slot in outputs),
    )


def _write_rates_function(program: Program, kernel: Writer, count: int) -> ir.Function:
    """``void rates(double *inputs, double *rates)``."""
    function, (inputs, rates) = _begin_function(kernel, f"rates_{count}", 2)
    w = inputs.writer
    rates.store(
        program(
            inputs.load(len(program.input_names)),
            functions=LaneFunctions(w),
            constant=w.constant,
            divide=reciprocal_quotient,
        )
    )
    w.builder.ret_void()
    return function


def _write_step_function(
    rates: ir.Function, field: Field, method: RungeKuttaMethod, kernel: Writer, count: int
) -> ir.Function:
    """``void step(double *start, double *inputs, double *slopes, double *change)``.

    The start is the length of the step, the load at every node and the state; the inputs are
    those of the rates, whose parameters are there already; slopes are those of every stage.
    """
    function, (start, inputs, slopes, change) = _begin_function(kernel, f"step_{count}", 4)
    w = start.writer
    load_size = 1 + len(field.waveform_names)
    state = start.part_from(1 + load_size * len(method.nodes))
    slopes_of_stage = (slopes.part_from(k * count) for k in range(method.evaluations_per_step))

    def slopes_at(node: int, stage_state: list[OfEveryVariable]) -> list[OfEveryVariable]:
        phase, *waves = start.part_from(1 + load_size * node).load(load_size)
        inputs.store([phase])
        inputs.part_from(1).store_of_every(count, stage_state[0].value_of)
        inputs.part_from(1 + len(field.state_names)).store(waves)
        found = next(slopes_of_stage)
        w.builder.call(rates, [inputs.pointer, found.pointer])
        return [OfEveryVariable(found.load_at)]

    (h,) = start.load(1)
    (added,) = method.increment(
        slopes_at, [OfEveryVariable(state.load_at)], OfEveryVariable(lambda _: h)
    )
    change.store_of_every(count, added.value_of)
    w.builder.ret_void()
    return function


def _begin_function(kernel: Writer, name: str, arrays: int) -> tuple[ir.Function, list[LaneArray]]:
    """A function of some arrays that do not overlap, and these."""
    signature = ir.FunctionType(ir.VoidType(), [DOUBLE_TYPE.as_pointer()] * arrays)
    function = ir.Function(kernel.builder.module, signature, name)
    function.linkage = "internal"
    function.attributes.add("noinline")
    for argument in function.args:
        argument.add_attribute("noalias")
    builder = ir.IRBuilder(function.append_basic_block("entry"))
    writer = replace(kernel, builder=builder)
    return function, [LaneArray(writer, argument) for argument in function.args]
