"""Long rates as a function of their own, which a kernel calls instead of repeating them.

A Runge-Kutta step of order 8 evaluates the rates eleven times, and a kernel holds three
steps.  Written out in place, a field with many states and tangents takes the compiler half
a minute; called, seconds, and the call costs little beside so long a computation.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from llvmlite import ir

from remanent._field import Field, Program
from remanent.integrate.kernel.lanes import (
    DOUBLE_TYPE,
    LaneFunctions,
    Lanes,
    Writer,
    reciprocal_quotient,
)

#: Rates with more instructions than this are called.
MAX_INLINED_INSTRUCTIONS = 200


class OutlinedRates:
    """The rates of a field's first `count` variables as a function in the module of a kernel.

    What depends on parameters alone is computed by :meth:`prepare_parameters`, once for a group.
    """

    def __init__(self, field: Field, writer: Writer, count: int) -> None:
        self._writer = writer
        self._zeros_for_absent = [writer.constant(0.0)] * (len(field.state_names) - count)
        rates = replace(field.rates, output_slots=field.rates.output_slots[:count])
        self._fixed_program, self._moving_program = split_program(rates, field.parameter_names)
        with writer.builder.goto_entry_block():
            self._input_array = self._allocate_array(len(self._moving_program.input_names))
            self._output_array = self._allocate_array(count)
        self._ir_function = _write_function(self._moving_program, writer, f"rates_{count}")

    def _allocate_array(self, count: int) -> ir.Value:
        return self._writer.builder.alloca(
            DOUBLE_TYPE, self._writer.integer_constant(count * self._writer.lane_count)
        )

    def prepare_parameters(self, parameters: Sequence[Lanes]) -> None:
        """Take over the parameters of a group."""
        w = self._writer
        values = self._fixed_program(
            list(parameters), functions=LaneFunctions(w), constant=w.constant
        )
        first = len(self._moving_program.input_names) - len(values)
        _store_vectors(w, values, self._input_array, first)

    def __call__(self, phase: Lanes, y: Sequence[Lanes], waves: Sequence[Lanes]) -> list[Lanes]:
        """The rates."""
        w = self._writer
        _store_vectors(w, [phase, *y, *self._zeros_for_absent, *waves], self._input_array, 0)
        w.builder.call(self._ir_function, [self._input_array, self._output_array])
        return [
            w.load_lanes(self._output_array, w.integer_constant(i * w.lane_count))
            for i in range(len(y))
        ]


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


def _write_function(program: Program, kernel: Writer, name: str) -> ir.Function:
    """``void name(double *inputs, double *outputs)``, both of one vector after the other."""
    pointer = DOUBLE_TYPE.as_pointer()
    signature = ir.FunctionType(ir.VoidType(), [pointer, pointer])
    function = ir.Function(kernel.builder.module, signature, name)
    function.linkage = "internal"
    function.attributes.add("noinline")
    for argument in function.args:
        argument.add_attribute("noalias")
    w = replace(kernel, builder=ir.IRBuilder(function.append_basic_block("entry")))
    values = [
        w.load_lanes(function.args[0], w.integer_constant(i * w.lane_count))
        for i in range(len(program.input_names))
    ]
    outputs = program(
        values, functions=LaneFunctions(w), constant=w.constant, divide=reciprocal_quotient
    )
    _store_vectors(w, outputs, function.args[1], 0)
    w.builder.ret_void()
    return function


def _store_vectors(w: Writer, values: Sequence[Lanes], pointer: ir.Value, first: int) -> None:
    for i, value in enumerate(values, start=first):
        w.store_lanes(value, pointer, w.integer_constant(i * w.lane_count))
