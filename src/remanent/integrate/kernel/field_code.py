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
from remanent.integrate.kernel.options import Method, Options
from remanent.integrate.kernel.outline import LONG, Outlined
from remanent.integrate.methods.runge_kutta import RungeKutta

#: Phase and waveforms at an instant.
Load = list[Lanes]
#: How a program divides: by a division, or by reciprocals that are known already.
Divide = Callable[[Any, Any], Any]


@dataclass(frozen=True)
class LoadTable:
    """The table of the load at every node of every step of a cycle.

    Attributes
    ----------
    memory : ir.Value
        Pointer to the array (step, node, 1 + waveform).
    nodes, columns : int
        Nodes of a step; phase and waveforms.
    """

    writer: Writer
    memory: ir.Value
    nodes: int
    columns: int

    def row(self, step: ir.Value) -> Callable[[int], Load]:
        """The load in a step, as a function of the node."""
        b, w = self.writer.builder, self.writer
        base = b.mul(step, w.integer(self.nodes * self.columns))

        def at(node: int) -> Load:
            # The load is the same for all trajectories: a scalar, copied to every lane.
            index = (w.integer(node * self.columns + k) for k in range(self.columns))
            return [w.spread(w.load_scalar(self.memory, b.add(base, k))) for k in index]

        return at


def outlined_rates(
    field: Field, method: Method, options: Options, writer: Writer
) -> dict[int, Outlined]:
    """The rates as functions of their own, by how many variables they are for.

    Empty where the rates are short, or where a method evaluates them so rarely that writing
    them out costs the compiler little.
    """
    if len(field.rates.instructions) <= LONG or not isinstance(method, RungeKutta):
        return {}
    states = len(field.state_names)
    sizes = {states, options.coarse_variables or states}
    return {size: Outlined(field, writer, size) for size in sorted(sizes)}


@dataclass(frozen=True)
class FieldCode:
    """Evaluates a field for one group of trajectories.

    Attributes
    ----------
    parameters : sequence of Lanes
        Of the trajectories of the group.
    outlined : mapping of int to Outlined
        Functions for the rates, see :func:`outlined_rates`; written out in place if empty.
    """

    field: Field
    writer: Writer
    parameters: Sequence[Lanes]
    outlined: Mapping[int, Outlined]

    @classmethod
    def load(cls, field: Field, slots: GroupSlots, outlined: Mapping[int, Outlined]) -> Self:
        """Read the parameters of a group."""
        parameters = slots.parameters()
        for function in outlined.values():
            function.prepare(parameters)
        return cls(field, slots.writer, parameters, outlined)

    def rates(
        self, y: Sequence[Lanes], load: Load, divide: Divide = reciprocal_quotient
    ) -> list[Lanes]:
        """The rates of all state variables, or of the first ones, on which no others act."""
        if self.outlined:
            return self.outlined[len(y)](load[0], y, load[1:])
        absent = [self.writer.constant(0.0)] * (len(self.field.state_names) - len(y))
        return self._run(self.field.rates, [*y, *absent], load, divide)[: len(y)]

    def watched(self, y: Sequence[Lanes], load: Load) -> TimeDerivatives:
        """The watched observable and its time derivatives."""
        value, rate, acceleration, _ = self._run(self.field.observable_and_rates, y, load)
        return TimeDerivatives(value, rate, acceleration)

    def direction(self, y: Sequence[Lanes], load: Load) -> Lanes:
        """A cheaper quantity with the sign of the watched observable's rate."""
        # The instructions of the other three outputs are written too; as nothing uses them,
        # the optimiser leaves them out.
        return self._run(self.field.observable_and_rates, y, load)[3]

    def _run(
        self, program: Program, y: Sequence[Lanes], load: Load, divide: Divide = reciprocal_quotient
    ) -> list[Lanes]:
        return program(
            [load[0], *y, *self.parameters, *load[1:]],
            functions=LaneFunctions(self.writer),
            constant=self.writer.constant,
            divide=divide,
        )
