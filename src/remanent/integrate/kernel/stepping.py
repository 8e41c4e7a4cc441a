"""How a kernel advances one of its two solutions by one step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, Self

from llvmlite import ir

from remanent.integrate.kernel.field_code import FieldCode, PhaseAndWaveforms
from remanent.integrate.kernel.group import GroupSlots
from remanent.integrate.kernel.lanes import INTEGER_TYPE, Lanes, Writer
from remanent.integrate.kernel.layout import PAST_RATE_COUNT, SOLUTION_NAMES, past_rate_name
from remanent.integrate.kernel.options import KernelOptions, Method
from remanent.integrate.methods.adams import (
    AdamsMethod,
    rate_variable_indices,
    weighted_sum_oldest_first,
)
from remanent.integrate.methods.runge_kutta import RungeKuttaMethod

#: Phase and waveforms at a node of the step.
LoadAtNode = Callable[[int], PhaseAndWaveforms]
#: Makes the new state from what a step adds, and keeps it.
UpdateFunction = Callable[[list[Lanes]], list[Lanes]]


@dataclass(frozen=True)
class StepEnd:
    """Reads the state at the end of a step, and the load there."""

    read_state: Callable[[], list[Lanes]]
    load: PhaseAndWaveforms


class Stepper(Protocol):
    """Advances the two solutions of a group, called `fine` and `coarse`."""

    def advance(
        self, solution: str, y: Sequence[Lanes], h: Lanes, loads: LoadAtNode, update: UpdateFunction
    ) -> list[Lanes]:
        """Take one step of length `h` from `y`; the new state is what `update` makes of it."""

    def save_past_rates(self, slots: GroupSlots, ends: Mapping[str, StepEnd]) -> None:
        """Leave the past rates that later steps need; `ends` are the ends of the last steps."""


def create_stepper(
    method: Method, options: KernelOptions, code: FieldCode, slots: GroupSlots
) -> Stepper:
    """The stepper of a method, with the past rates of a group where it needs them."""
    solutions = SOLUTION_NAMES if options.has_coarse_solution else SOLUTION_NAMES[:1]
    if isinstance(method, RungeKuttaMethod):
        return RungeKuttaStepper.without_past(method, code, solutions, slots)
    return AdamsStepper.with_past_rates_of(method, code, solutions, slots)


@dataclass(frozen=True)
class RungeKuttaStepper:
    """Steps that need no past, but leave one for the Adams steps that follow.

    Attributes
    ----------
    history_variables : sequence of int
        Variables whose past rates are kept.
    ring_of_solution : mapping of str to _PastRateRing
        The past rates of each solution.
    """

    method: RungeKuttaMethod
    field_code: FieldCode
    history_variables: Sequence[int]
    ring_of_solution: Mapping[str, _PastRateRing]

    @classmethod
    def without_past(
        cls, method: RungeKuttaMethod, code: FieldCode, solutions: Sequence[str], slots: GroupSlots
    ) -> Self:
        """Steps without a past."""
        histories = slots.layout.history_variables
        rings = {
            name: _PastRateRing.allocate(slots.writer, PAST_RATE_COUNT, histories)
            for name in solutions
        }
        return cls(method, code, histories, rings)

    def advance(
        self, solution: str, y: Sequence[Lanes], h: Lanes, loads: LoadAtNode, update: UpdateFunction
    ) -> list[Lanes]:
        load = [loads(node) for node in range(len(self.method.nodes))]
        rates, change = self._rates_and_change(y, h, load)
        self.ring_of_solution[solution].push({i: rates[i] for i in self.history_variables})
        return update(change)

    def _rates_and_change(
        self, y: Sequence[Lanes], h: Lanes, load: Sequence[PhaseAndWaveforms]
    ) -> tuple[list[Lanes], list[Lanes]]:
        """The rates at the beginning of a step, and what it adds to the state."""
        if self.field_code.outlined:
            return self.field_code.outlined[len(y)].step(y, h, load)
        slopes = self.method.stage_slopes(
            lambda node, z: self.field_code.rates(z, load[node]), y, h
        )
        # The first stage is at the beginning of the step.
        return slopes[0], self.method.increment_from_slopes(slopes, h)

    def save_past_rates(self, slots: GroupSlots, ends: Mapping[str, StepEnd]) -> None:
        if not self.history_variables:
            return
        # The rings hold rates at the beginnings of steps; those at the very end are new.
        for solution, ring in self.ring_of_solution.items():
            end = ends[solution]
            rates = self.field_code.rates(end.read_state(), end.load)
            for i in self.history_variables:
                for age, rate in enumerate(
                    [rates[i], *ring.newest_first(i)[: PAST_RATE_COUNT - 1]]
                ):
                    slots.write(past_rate_name(solution, age, i), rate)


@dataclass(frozen=True)
class AdamsStepper:
    """Steps with a history of rates for every variable that has no partner.

    The rates at the corrected state differ so little from those at the predicted one
    that their divisions are one Newton step each from the reciprocals at hand.

    Attributes
    ----------
    rate_variables : tuple of int or None
        See :func:`~remanent.integrate.methods.adams.rate_variable_indices`.
    ring_of_solution : mapping of str to _PastRateRing
        The past rates of each solution.
    """

    method: AdamsMethod
    field_code: FieldCode
    rate_variables: tuple[int | None, ...]
    ring_of_solution: Mapping[str, _PastRateRing]

    @classmethod
    def with_past_rates_of(
        cls, method: AdamsMethod, code: FieldCode, solutions: Sequence[str], slots: GroupSlots
    ) -> Self:
        """Read the past rates of a group."""

        def ring(solution: str) -> _PastRateRing:
            past = _PastRateRing.allocate(
                slots.writer, method.past_rate_count, slots.layout.history_variables
            )
            for i in slots.layout.history_variables:
                names = (past_rate_name(solution, age, i) for age in range(method.past_rate_count))
                past.fill(i, [slots.read(name) for name in names])
            return past

        rings = {solution: ring(solution) for solution in solutions}
        return cls(method, code, rate_variable_indices(code.field), rings)

    def save_past_rates(self, slots: GroupSlots, ends: Mapping[str, StepEnd]) -> None:
        for solution, ring in self.ring_of_solution.items():
            for i in ring.memory_of_variable:
                for age, rate in enumerate(ring.newest_first(i)):
                    slots.write(past_rate_name(solution, age, i), rate)

    def advance(
        self, solution: str, y: Sequence[Lanes], h: Lanes, loads: LoadAtNode, update: UpdateFunction
    ) -> list[Lanes]:
        """Predict, evaluate, correct, evaluate."""
        ring = self.ring_of_solution[solution]
        past = ring.all_newest_first()
        sums = self._past_rate_sums(past)
        predicted = self._predicted_state(y, h, sums)
        change = self._predicted_change(y, h, sums)
        reciprocals: list[Lanes] = []

        def divide(a: Lanes, b: Lanes) -> Lanes:
            reciprocals.append(b.writer.reciprocal(b))
            return a * reciprocals[-1]

        rates = self.field_code.rates(predicted, loads(1), divide)
        corrected = update(self._corrected_change(change, h, past, rates))
        # Both evaluations run the same program, so that the divisions come in the same order.
        nearby = iter(reciprocals)
        rates = self.field_code.rates(
            corrected, loads(1), lambda a, b: refined_quotient(a, next(nearby), b)
        )
        ring.push({i: rates[i] for i in ring.memory_of_variable})
        return corrected

    def _past_rate_sums(self, past: Mapping[int, list[Lanes]]) -> list[Lanes]:
        """For every variable the weighted sum of past rates, or of its partner's."""
        return [
            weighted_sum_oldest_first(self.method.single_integral_weights, past[i])
            if partner is None
            else weighted_sum_oldest_first(self.method.double_integral_weights, past[partner])
            for i, partner in enumerate(self.rate_variables)
        ]

    def _predicted_state(self, y: Sequence[Lanes], h: Lanes, sums: Sequence[Lanes]) -> list[Lanes]:
        """The state at the end of the step as the past rates foretell it."""
        return [
            a + h * sums[i] if partner is None else (a + h * y[partner]) + (h * h) * sums[i]
            for i, (a, partner) in enumerate(zip(y, self.rate_variables, strict=True))
        ]

    def _predicted_change(self, y: Sequence[Lanes], h: Lanes, sums: Sequence[Lanes]) -> list[Lanes]:
        """What the prediction adds to the state.

        It is summed apart from the state, so that the correction is added to the small change
        and not to the large sum, which would cut off its last digits.
        """
        return [
            h * sums[i] if partner is None else h * (y[partner] + h * sums[i])
            for i, partner in enumerate(self.rate_variables)
        ]

    def _corrected_change(
        self,
        change: list[Lanes],
        h: Lanes,
        past: Mapping[int, list[Lanes]],
        rates: Sequence[Lanes],
    ) -> list[Lanes]:
        """The change with the correction by the rates at the predicted state."""
        m = self.method
        surprise = {
            i: rates[i] + weighted_sum_oldest_first(m.backward_difference_weights, before)
            for i, before in past.items()
        }
        corrected = list(change)
        for i, partner in enumerate(self.rate_variables):
            if partner is None:
                corrected[i] = change[i] + h * (surprise[i] * m.single_integral_correction)
            elif partner in surprise:
                corrected[i] = change[i] + (h * h) * (
                    surprise[partner] * m.double_integral_correction
                )
        return corrected


def refined_quotient(a: Lanes, reciprocal: Lanes, b: Lanes) -> Lanes:
    """a/b from the reciprocal of a number close to b, by a Newton step.

    The two factors do not wait for each other.
    """
    return (a * reciprocal) * (2.0 - b * reciprocal)


@dataclass(frozen=True)
class _PastRateRing:
    """Past rates in a memory in which each stands twice, so that any window is in order."""

    writer: Writer
    capacity: int
    memory_of_variable: dict[int, ir.Value]
    oldest_position: ir.Value

    @classmethod
    def allocate(cls, writer: Writer, steps: int, variables: Sequence[int]) -> _PastRateRing:
        size = ir.ArrayType(writer.vector_type, 2 * steps)
        with writer.builder.goto_entry_block():
            memory = {i: writer.builder.alloca(size) for i in variables}
            position = writer.builder.alloca(INTEGER_TYPE)
        writer.builder.store(writer.integer_constant(0), position)
        return cls(writer, steps, memory, position)

    def fill(self, variable: int, newest_first: Sequence[Lanes]) -> None:
        for j, value in enumerate(newest_first):
            for copy in (0, self.capacity):
                index = self.writer.integer_constant(self.capacity - 1 - j + copy)
                self.writer.builder.store(value.ir_value, self._address(variable, index))

    def newest_first(self, variable: int) -> list[Lanes]:
        b, w = self.writer.builder, self.writer
        oldest = b.load(self.oldest_position)
        index = [
            b.add(oldest, w.integer_constant(self.capacity - 1 - j)) for j in range(self.capacity)
        ]
        return [Lanes(w, b.load(self._address(variable, k))) for k in index]

    def all_newest_first(self) -> dict[int, list[Lanes]]:
        return {i: self.newest_first(i) for i in self.memory_of_variable}

    def push(self, rates: dict[int, Lanes]) -> None:
        """Put new rates in the place of the oldest ones, in both copies."""
        b, w = self.writer.builder, self.writer
        oldest = b.load(self.oldest_position)
        for variable, value in rates.items():
            b.store(value.ir_value, self._address(variable, oldest))
            mirror = b.add(oldest, w.integer_constant(self.capacity))
            b.store(value.ir_value, self._address(variable, mirror))
        following = b.add(oldest, w.integer_constant(1))
        wrapped = b.icmp_signed("==", following, w.integer_constant(self.capacity))
        b.store(b.select(wrapped, w.integer_constant(0), following), self.oldest_position)

    def _address(self, variable: int, index: ir.Value) -> ir.Value:
        return self.writer.builder.gep(
            self.memory_of_variable[variable], [self.writer.integer_constant(0), index]
        )
