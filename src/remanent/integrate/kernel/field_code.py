"""A field and its load as instructions of a kernel."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

from llvmlite import ir

from remanent._field import Field, Program
from remanent.integrate.kernel.extrema import TimeDerivatives
from remanent.integrate.kernel.group import GroupSlots, RunConstants
from remanent.integrate.kernel.lanes import (
    LaneFunctions,
    Lanes,
    Mask,
    Writer,
    reciprocal_quotient,
    smaller,
)
from remanent.integrate.kernel.options import KernelOptions, Method
from remanent.integrate.kernel.outline import MAX_INLINED_INSTRUCTIONS, OutlinedRates
from remanent.integrate.methods.runge_kutta import RungeKuttaMethod

#: Phase and waveforms at an instant.
PhaseAndWaveforms = list[Lanes]
#: How a program divides: by a division, or by reciprocals that are known already.
DivideFunction = Callable[[Any, Any], Any]


@dataclass(frozen=True)
class OwnSteps:
    """The steps of a group whose lanes may differ in how many they take in a cycle.

    Attributes
    ----------
    differ : ir.Value
        Whether those of this group do.
    double_steps : Lanes
        In a cycle.
    first_row : Lanes
        Of the table of the coarse steps where those of the lane begin.
    """

    differ: ir.Value
    double_steps: Lanes
    first_row: Lanes

    @classmethod
    def of_group(cls, run: RunConstants, double_step_count: ir.Value) -> Self:
        """Those that the slots of a group tell of."""
        w = run.double_steps.writer
        most = w.broadcast_integer(double_step_count)
        return cls((run.double_steps < most).any_lane(), run.double_steps, run.first_row)

    def last_until(self, number: ir.Value) -> Mask:
        """Lanes whose cycle has a double step with this number."""
        return self.double_steps > self.double_steps.writer.broadcast_integer(number)


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

    def load_at_nodes_of_step(self, step: ir.Value) -> Callable[[int], PhaseAndWaveforms]:
        """The load in a step, as a function of the node."""
        own = self.own_steps
        if own is None:
            return lambda node: self._same_for_all(step, node)
        nodes = range(self.node_count)
        values = self.writer.either(
            own.differ,
            lambda: self._of_each(own, step),
            lambda: [value for node in nodes for value in self._same_for_all(step, node)],
        )
        size = self.column_count
        return lambda node: values[node * size : (node + 1) * size]

    def _same_for_all(self, step: ir.Value, node: int) -> PhaseAndWaveforms:
        """The load of trajectories that take the same steps: a scalar, copied to every lane."""
        b, w = self.writer.builder, self.writer
        base = b.mul(step, w.integer_constant(self._row_size))
        index = (w.integer_constant(node * self.column_count + k) for k in range(self.column_count))
        return [w.broadcast(w.load_scalar(self.table_pointer, b.add(base, k))) for k in index]

    def _of_each(self, own: OwnSteps, step: ir.Value) -> list[Lanes]:
        """The load of trajectories with steps of their own, node by node; anything after them."""
        w, times = self.writer, float(self.steps_per_double_step)
        row = smaller(w.broadcast_integer(step), own.double_steps * times - 1.0)
        first = (own.first_row * times + row) * float(self._row_size)
        return w.load_rows(self.table_pointer, first, self._row_size)

    @property
    def _row_size(self) -> int:
        """Numbers of one step."""
        return self.node_count * self.column_count


def build_outlined_rates(
    field: Field, method: Method, options: KernelOptions, writer: Writer
) -> dict[int, OutlinedRates]:
    """The rates as functions of their own, by how many variables they are for.

    Empty where the rates are short, or where a method evaluates them so rarely that writing
    them out costs the compiler little.
    """
    if len(field.rates.instructions) <= MAX_INLINED_INSTRUCTIONS or not isinstance(
        method, RungeKuttaMethod
    ):
        return {}
    states = len(field.state_names)
    sizes = {states, options.coarse_variable_count or states}
    return {size: OutlinedRates(field, writer, size) for size in sorted(sizes)}


@dataclass(frozen=True)
class FieldCode:
    """Evaluates a field for one group of trajectories.

    Attributes
    ----------
    parameters : sequence of Lanes
        Of the trajectories of the group.
    outlined_rates : mapping of int to OutlinedRates
        Functions for the rates, see :func:`build_outlined_rates`; written out in place if empty.
    """

    field: Field
    writer: Writer
    parameters: Sequence[Lanes]
    outlined_rates: Mapping[int, OutlinedRates]

    @classmethod
    def with_parameters_of(
        cls, field: Field, slots: GroupSlots, outlined: Mapping[int, OutlinedRates]
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
        if self.outlined_rates:
            return self.outlined_rates[len(y)](load[0], y, load[1:])
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
