"""How a kernel advances one of its two solutions by one step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, Self

from llvmlite import ir

from remanent.integrate.kernel.field_code import FieldCode, PhaseAndWaveforms
from remanent.integrate.kernel.group import GroupSlots
from remanent.integrate.kernel.lanes import INTEGER_TYPE, Cell, Lanes, Writer
from remanent.integrate.kernel.layout import (
    PAST_DIFFERENCE_COUNT,
    PAST_RATE_COUNT,
    SOLUTION_NAMES,
    backward_difference_name,
    past_difference_name,
    past_rate_name,
)
from remanent.integrate.kernel.options import KernelOptions, Method
from remanent.integrate.methods.adams import (
    AdamsMethod,
    adams_method,
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
        self, y: Sequence[Lanes], h: Lanes, loads: LoadAtNode, update: UpdateFunction
    ) -> list[Lanes]:
        """The fine solution after a step of length `h`: what `update` makes of its change."""

    def advance_coarse(
        self,
        y: Sequence[Lanes],
        fine: tuple[Sequence[Lanes], Sequence[Lanes]],
        h: Lanes,
        loads: LoadAtNode,
    ) -> list[Lanes]:
        """The coarse solution after a double step from `y`.

        Parameters
        ----------
        y : sequence of Lanes
        fine : pair of sequence of Lanes
            The fine solution at the beginning and at the end of the same double step.
        h : Lanes
            Length of its steps, tau.
        loads : callable
            The load at the nodes of the double step.
        """

    def save_past_rates(self, slots: GroupSlots, ends: Mapping[str, StepEnd]) -> None:
        """Leave the past rates that later steps need; `ends` are the ends of the last steps."""


def create_stepper(
    method: Method, options: KernelOptions, code: FieldCode, slots: GroupSlots
) -> Stepper:
    """The stepper of a method, with the past rates of a group where it needs them."""
    solutions = SOLUTION_NAMES if options.has_coarse_solution else SOLUTION_NAMES[:1]
    if isinstance(method, RungeKuttaMethod):
        return RungeKuttaStepper.without_past(method, code, solutions, slots)
    return AdamsStepper.with_past_rates_of(method, code, slots)


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
        # Beside the rates at the end of the start.
        counts = {"fine": PAST_RATE_COUNT + 1, "coarse": PAST_DIFFERENCE_COUNT - 1}
        rings = {
            name: _PastRateRing.allocate(slots.writer, counts[name], histories)
            for name in solutions
        }
        return cls(method, code, histories, rings)

    def advance(
        self, y: Sequence[Lanes], h: Lanes, loads: LoadAtNode, update: UpdateFunction
    ) -> list[Lanes]:
        return update(self._change("fine", y, h, loads))

    def advance_coarse(
        self,
        y: Sequence[Lanes],
        fine: tuple[Sequence[Lanes], Sequence[Lanes]],
        h: Lanes,
        loads: LoadAtNode,
    ) -> list[Lanes]:
        change = self._change("coarse", y, h + h, loads)
        return [a + b for a, b in zip(y, change, strict=True)]

    def _change(
        self, solution: str, y: Sequence[Lanes], h: Lanes, loads: LoadAtNode
    ) -> list[Lanes]:
        """What a step adds to a solution, whose rates at the beginning are kept."""
        load = [loads(node) for node in range(len(self.method.nodes))]
        rates, change = self._rates_and_change(y, h, load)
        self.ring_of_solution[solution].push({i: rates[i] for i in self.history_variables})
        return change

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
        weights = adams_method(PAST_RATE_COUNT).backward_difference_weights
        past_of = {}
        for solution, ring in self.ring_of_solution.items():
            rates = self.field_code.rates(ends[solution].read_state(), ends[solution].load)
            past_of[solution] = {
                i: [rates[i], *ring.newest_first(i)] for i in self.history_variables
            }
        for i, fine in past_of["fine"].items():
            for age, rate in enumerate(fine[:PAST_RATE_COUNT]):
                slots.write(past_rate_name(age, i), rate)
            for age in range(2):
                past = fine[age + 1 : age + 1 + PAST_RATE_COUNT]
                difference = fine[age] + weighted_sum_oldest_first(weights, past)
                slots.write(backward_difference_name(age, i), difference)
        for i, coarse in past_of.get("coarse", {}).items():
            for age, rate in enumerate(coarse[:PAST_DIFFERENCE_COUNT]):
                slots.write(past_difference_name(age, i), rate - past_of["fine"][i][2 * age])


@dataclass(frozen=True)
class _FineStep:
    """What a step leaves for the error.

    Attributes
    ----------
    rates, reciprocals : list of Lanes
        Rates at its end, and the reciprocals of their divisions.
    rate_changes : dict of int to Lanes
        By how much they differ from those at the predicted state.
    differences : dict of int to Lanes
        Backward differences with them, as often as there are past rates.
    """

    rates: list[Lanes]
    reciprocals: list[Lanes]
    rate_changes: dict[int, Lanes]
    differences: dict[int, Lanes]


@dataclass(frozen=True)
class AdamsStepper:
    """Steps with a history of rates for every variable that has no partner.

    The rates at the corrected state differ so little from those at the predicted one
    that their divisions are one Newton step each from the reciprocals at hand.

    What a step does wrong is known: the next term of the series that the corrector breaks off, and
    the change of the rates from the predicted to the corrected state, at which they were not
    evaluated again.  The coarse solution is the fine one with these errors, amplified, added in
    every double step.  How its distance from the fine one goes on follows from the difference of
    their rates by a method of low order, with one evaluation.

    What changes, while a double step is written: `fine_steps`.

    Attributes
    ----------
    rate_variables : tuple of int or None
        See :func:`~remanent.integrate.methods.adams.rate_variable_indices`.
    past_rates : _PastRateRing
        Of the fine solution.
    past_differences : _PastRateRing
        Of the rates of the two solutions, one for each double step.
    last_differences : dict of int to pair of Cell
        Backward differences of the rates at the beginning of the double step, and a step before.
    fine_steps : list of _FineStep
        Those of the double step.
    """

    method: AdamsMethod
    field_code: FieldCode
    rate_variables: tuple[int | None, ...]
    past_rates: _PastRateRing
    past_differences: _PastRateRing
    last_differences: dict[int, tuple[Cell, Cell]]
    fine_steps: list[_FineStep]

    @classmethod
    def with_past_rates_of(cls, method: AdamsMethod, code: FieldCode, slots: GroupSlots) -> Self:
        """Read the past rates of a group."""
        histories = slots.layout.history_variables

        def ring(count: int, name: Callable[[int, int], str]) -> _PastRateRing:
            past = _PastRateRing.allocate(slots.writer, count, histories)
            for i in histories:
                past.fill(i, [slots.read(name(age, i)) for age in range(count)])
            return past

        def cell(name: str) -> Cell:
            return slots.writer.new_cell_with(slots.read(name))

        return cls(
            method,
            code,
            rate_variable_indices(code.field),
            ring(method.past_rate_count, past_rate_name),
            ring(PAST_DIFFERENCE_COUNT, past_difference_name),
            {
                i: (cell(backward_difference_name(0, i)), cell(backward_difference_name(1, i)))
                for i in histories
            },
            [],
        )

    def save_past_rates(self, slots: GroupSlots, ends: Mapping[str, StepEnd]) -> None:
        rings = ((self.past_rates, past_rate_name), (self.past_differences, past_difference_name))
        for ring, name in rings:
            for i, past in ring.all_newest_first().items():
                for age, rate in enumerate(past):
                    slots.write(name(age, i), rate)
        for i, cells in self.last_differences.items():
            for age, cell in enumerate(cells):
                slots.write(backward_difference_name(age, i), cell.get())

    def advance(
        self, y: Sequence[Lanes], h: Lanes, loads: LoadAtNode, update: UpdateFunction
    ) -> list[Lanes]:
        """Predict, evaluate, correct, evaluate."""
        past = self.past_rates.all_newest_first()
        sums = self._past_rate_sums(self.method, past)
        predicted = self._predicted_state(y, h, sums)
        change = self._predicted_change(y, h, sums)
        reciprocals: list[Lanes] = []

        def divide(a: Lanes, b: Lanes) -> Lanes:
            reciprocals.append(b.writer.reciprocal(b))
            return a * reciprocals[-1]

        at_predicted = self.field_code.rates(predicted, loads(1), divide)
        differences = self._backward_differences(self.method, past, at_predicted)
        corrected = update(self._corrected(self.method, change, h, differences))
        rates = self._rates_nearby(corrected, loads(1), reciprocals)
        rate_changes = {i: rates[i] - at_predicted[i] for i in past}
        differences = self._backward_differences(self.method, past, rates)
        self.fine_steps.append(_FineStep(rates, reciprocals, rate_changes, differences))
        self.past_rates.push({i: rates[i] for i in past})
        return corrected

    def advance_coarse(
        self,
        y: Sequence[Lanes],
        fine: tuple[Sequence[Lanes], Sequence[Lanes]],
        h: Lanes,
        loads: LoadAtNode,
    ) -> list[Lanes]:
        left, right = fine
        distance = [a - b for a, b in zip(y, left, strict=True)]
        follower = adams_method(PAST_DIFFERENCE_COUNT)
        past = self.past_differences.all_newest_first()
        sums = self._past_rate_sums(follower, past)
        local_errors = self._local_errors(h)
        last = self.fine_steps[-1]
        self.fine_steps.clear()
        distance = [
            a + b
            for a, b in zip(self._predicted_state(distance, h + h, sums), local_errors, strict=True)
        ]
        near = [a + b for a, b in zip(right, distance, strict=True)]
        rates = self._rates_nearby(near, loads(1), last.reciprocals)
        new = {i: rates[i] - last.rates[i] for i in past}
        differences = self._backward_differences(follower, past, new)
        self.past_differences.push(new)
        distance = self._corrected(follower, distance, h + h, differences)
        return [a + b for a, b in zip(right, distance, strict=True)]

    def _local_errors(self, h: Lanes) -> list[Lanes]:
        """What the two fine steps of a double step do wrong, amplified."""
        m, (first, second) = self.method, self.fine_steps
        once = h * m.error_amplification
        twice = h * once
        errors: list[Lanes] = []
        for i, partner in enumerate(self.rate_variables):
            k = i if partner is None else partner
            begun, before = (cell.get() for cell in self.last_differences[k])
            changes = first.rate_changes[k] + second.rate_changes[k]
            # The differences of one order add up to those of the order below at the ends.
            following = second.differences[k] - begun
            after_that = (second.differences[k] - first.differences[k]) - (begun - before)
            if partner is None:
                first_weight, second_weight = m.single_integral_errors
                error = following * first_weight + changes * m.single_integral_correction
                errors.append(once * (error + after_that * second_weight))
                continue
            # What the first step does wrong in the rate moves the variable in the second.
            in_rate = (first.differences[k] - begun) * m.single_integral_errors[0]
            in_rate = in_rate + first.rate_changes[k] * m.single_integral_correction
            first_weight, second_weight = m.double_integral_errors
            error = following * first_weight + changes * m.double_integral_correction
            errors.append(twice * ((error + in_rate) + after_that * second_weight))
        for k, (newest, older) in self.last_differences.items():
            newest.set(second.differences[k])
            older.set(first.differences[k])
        return errors

    def _rates_nearby(
        self, y: Sequence[Lanes], load: PhaseAndWaveforms, reciprocals: Sequence[Lanes]
    ) -> list[Lanes]:
        """Rates at a state close to one whose divisions had these reciprocals."""
        # All evaluations run the same program, so that the divisions come in the same order.
        nearby = iter(reciprocals)
        return self.field_code.rates(y, load, lambda a, b: refined_quotient(a, next(nearby), b))

    @staticmethod
    def _backward_differences(
        method: AdamsMethod,
        past: Mapping[int, list[Lanes]],
        rates: Sequence[Lanes] | Mapping[int, Lanes],
    ) -> dict[int, Lanes]:
        """Of new rates, as often as there are past ones."""
        weights = method.backward_difference_weights
        return {i: rates[i] + weighted_sum_oldest_first(weights, p) for i, p in past.items()}

    def _past_rate_sums(self, method: AdamsMethod, past: Mapping[int, list[Lanes]]) -> list[Lanes]:
        """For every variable the weighted sum of past rates, or of its partner's."""
        return [
            weighted_sum_oldest_first(method.single_integral_weights, past[i])
            if partner is None
            else weighted_sum_oldest_first(method.double_integral_weights, past[partner])
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

    def _corrected(
        self,
        method: AdamsMethod,
        predicted: Sequence[Lanes],
        h: Lanes,
        differences: Mapping[int, Lanes],
    ) -> list[Lanes]:
        """A predicted change, or state, with what the backward differences add to it."""
        corrected = list(predicted)
        for i, partner in enumerate(self.rate_variables):
            if partner is None:
                corrected[i] = predicted[i] + h * (
                    differences[i] * method.single_integral_correction
                )
            elif partner in differences:
                corrected[i] = predicted[i] + (h * h) * (
                    differences[partner] * method.double_integral_correction
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
