"""A field and its load as instructions of a kernel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

from llvmlite import ir

from remanent._field import Field, Program
from remanent.integrate.kernel.extrema import TimeDerivatives
from remanent.integrate.kernel.group import GroupSlots
from remanent.integrate.kernel.lanes import LaneFunctions, Lanes, Writer, reciprocal_quotient
from remanent.integrate.kernel.options import KernelOptions, Method
from remanent.integrate.kernel.outline import MAX_INLINED_INSTRUCTIONS, OutlinedField
from remanent.integrate.kernel.own_steps import OwnSteps
from remanent.integrate.methods.runge_kutta import RungeKuttaMethod

#: Phase and waveforms at an instant.
PhaseAndWaveforms = list[Lanes]
#: How a program divides: by a division, or by reciprocals that are known already.
DivideFunction = Callable[[Any, Any], Any]


@dataclass(frozen=True)
class LoadTable:
    """The table of the load at every node of every step of a cycle.

    Attributes
    ----------
    table_pointer : ir.Value
        Pointer to the array (step, node, 1 + waveform).
    node_count, column_count : int
        Nodes of a step; phase and waveforms.
    steps_per_double_step : int
        2 for fine steps, 1 for coarse ones.
    own_steps : OwnSteps, optional
        Where lanes have their own: the table is then that of each number of steps in turn.
    """

    writer: Writer
    table_pointer: ir.Value
    node_count: int
    column_count: int
    steps_per_double_step: int
    own_steps: OwnSteps | None = None

    def load_at(self, double_step: ir.Value, part: int, node: int) -> PhaseAndWaveforms:
        """The load at a node of a step, of a double step that has begun.

        Parameters
        ----------
        double_step : ir.Value
            Number of the double step that the step belongs to.
        part : int
            0 for the first fine step of it, or the coarse step, and 1 for the second.
        node : int
        """
        own = self.own_steps
        if own is None:
            return self.same_for_all(double_step, part, node)
        return self.writer.either(
            own.differ,
            lambda: self.of_each(own.row(double_step), part, [node]),
            lambda: self.same_for_all(double_step, part, node),
        )

    def same_for_all(self, double_step: ir.Value, part: int, node: int) -> PhaseAndWaveforms:
        """The load of trajectories that take the same steps: a scalar, copied to every lane."""
        b, w = self.writer.builder, self.writer
        step = b.mul(double_step, w.integer_constant(self.steps_per_double_step))
        step = b.add(step, w.integer_constant(part))
        base = b.mul(step, w.integer_constant(self._row_size))
        index = (w.integer_constant(node * self.column_count + k) for k in range(self.column_count))
        return [w.broadcast(w.load_scalar(self.table_pointer, b.add(base, k))) for k in index]

    def of_each(self, row: Lanes, part: int, nodes: Sequence[int]) -> list[Lanes]:
        """The load of trajectories with steps of their own, node by node."""
        first = (row * float(self.steps_per_double_step) + float(part)) * float(self._row_size)
        size = self.column_count
        columns = [node * size + k for node in nodes for k in range(size)]
        return self.writer.load_rows(self.table_pointer, first, columns)

    @property
    def _row_size(self) -> int:
        """Numbers of one step."""
        return self.node_count * self.column_count


def build_outlined_fields(
    field: Field, method: Method, options: KernelOptions, writer: Writer
) -> dict[int, OutlinedField]:
    """Rates and steps as functions of their own, by how many variables they are for.

    Empty where the rates are short, or where a method evaluates them so rarely that writing
    them out costs the compiler little.
    """
    if len(field.rates.instructions) <= MAX_INLINED_INSTRUCTIONS or not isinstance(
        method, RungeKuttaMethod
    ):
        return {}
    states = len(field.state_names)
    sizes = {states, options.coarse_variable_count or states}
    return {size: OutlinedField(field, method, writer, size) for size in sorted(sizes)}


@dataclass(frozen=True)
class FieldCode:
    """Evaluates a field for one group of trajectories.

    Attributes
    ----------
    parameters : sequence of Lanes
        Of the trajectories of the group.
    outlined : mapping of int to OutlinedField
        Functions for rates and steps, see :func:`build_outlined_fields`; written out in place if
        empty.
    """

    field: Field
    writer: Writer
    parameters: Sequence[Lanes]
    outlined: Mapping[int, OutlinedField]

    @classmethod
    def with_parameters_of(
        cls, field: Field, slots: GroupSlots, outlined: Mapping[int, OutlinedField]
    ) -> Self:
        """Read the parameters of a group."""
        parameters = slots.parameters()
        for function in outlined.values():
            function.prepare_parameters(parameters)
        return cls(field, slots.writer, parameters, outlined)

    def rates(
        self,
        y: Sequence[Lanes],
        load: PhaseAndWaveforms,
        divide: DivideFunction = reciprocal_quotient,
    ) -> list[Lanes]:
        """The rates of all state variables, or of the first ones, on which no others act."""
        if self.outlined:
            return self.outlined[len(y)].rates(y, load)
        absent = [self.writer.constant(0.0)] * (len(self.field.state_names) - len(y))
        return self._run_program(self.field.rates, [*y, *absent], load, divide)[: len(y)]

    def watched_derivatives(self, y: Sequence[Lanes], load: PhaseAndWaveforms) -> TimeDerivatives:
        """The watched observable and its time derivatives."""
        value, rate, acceleration, _ = self._run_program(self.field.observable_and_rates, y, load)
        return TimeDerivatives(value, rate, acceleration)

    def watched_rate_sign(self, y: Sequence[Lanes], load: PhaseAndWaveforms) -> Lanes:
        """A cheaper quantity with the sign of the watched observable's rate."""
        # The instructions of the other three outputs are written too; as nothing uses them,
        # the optimiser leaves them out.
        return self._run_program(self.field.observable_and_rates, y, load)[3]

    def _run_program(
        self,
        program: Program,
        y: Sequence[Lanes],
        load: PhaseAndWaveforms,
        divide: DivideFunction = reciprocal_quotient,
    ) -> list[Lanes]:
        return program(
            [load[0], *y, *self.parameters, *load[1:]],
            functions=LaneFunctions(self.writer),
            constant=self.writer.constant,
            divide=divide,
        )
