"""How a kernel advances one of its two solutions by one step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, Self

from llvmlite import ir

from remanent.integrate.kernel.field_code import FieldCode, Load
from remanent.integrate.kernel.group import GroupSlots
from remanent.integrate.kernel.lanes import INTEGER, Lanes, Writer
from remanent.integrate.kernel.layout import PAST, SOLUTIONS, past_rate
from remanent.integrate.kernel.options import Method, Options
from remanent.integrate.methods.adams import Adams, combination, partners
from remanent.integrate.methods.runge_kutta import RungeKutta

#: Phase and waveforms at a node of the step.
Loads = Callable[[int], Load]
#: Makes the new state from what a step adds, and keeps it.
Update = Callable[[list[Lanes]], list[Lanes]]


@dataclass(frozen=True)
class StepEnd:
    """Reads the state at the end of a step, and the load in that step."""

    state: Callable[[], list[Lanes]]
    loads: Loads


class Stepper(Protocol):
    """Advances the two solutions of a group, called `fine` and `coarse`."""

    def advance(
        self, solution: str, y: Sequence[Lanes], h: Lanes, loads: Loads, update: Update
    ) -> list[Lanes]:
        """Take one step of length `h` from `y`; the new state is what `update` makes of it."""

    def save(self, slots: GroupSlots, ends: Mapping[str, StepEnd]) -> None:
        """Leave the past rates that later steps need; `ends` are the ends of the last steps."""


def stepper_for(method: Method, options: Options, code: FieldCode, slots: GroupSlots) -> Stepper:
    """The stepper of a method, with the past rates of a group where it needs them."""
    solutions = SOLUTIONS if options.coarse_solution else SOLUTIONS[:1]
    if isinstance(method, RungeKutta):
        return RungeKuttaSteps.begin(method, code, solutions, slots)
    return AdamsSteps.load(method, code, solutions, slots)


@dataclass(frozen=True)
class RungeKuttaSteps:
    """Steps that need no past, but leave one for the Adams steps that follow.

    Attributes
    ----------
    histories : sequence of int
        Variables whose past rates are kept.
    rings : mapping of str to _Ring
        The past rates of each solution.
    """

    method: RungeKutta
    code: FieldCode
    histories: Sequence[int]
    rings: Mapping[str, _Ring]

    @classmethod
    def begin(
        cls, method: RungeKutta, code: FieldCode, solutions: Sequence[str], slots: GroupSlots
    ) -> Self:
        """Steps without a past."""
        histories = slots.layout.histories
        rings = {name: _Ring.allocate(slots.writer, PAST, histories) for name in solutions}
        return cls(method, code, histories, rings)

    def advance(
        self, solution: str, y: Sequence[Lanes], h: Lanes, loads: Loads, update: Update
    ) -> list[Lanes]:
        load = [loads(node) for node in range(len(self.method.nodes))]
        slopes = self.method.slopes(lambda node, z: self.code.rates(z, load[node]), y, h)
        change = self.method.weighted_sum(slopes, h)
        # The first stage is at the beginning of the step: its slopes are the rates there.
        self.rings[solution].push({i: slopes[0][i] for i in self.histories})
        return update(change)

    def save(self, slots: GroupSlots, ends: Mapping[str, StepEnd]) -> None:
        # The rings hold rates at the beginnings of steps; those at the very end are new.
        for solution, ring in self.rings.items():
            end = ends[solution]
            rates = self.code.rates(end.state(), end.loads(len(self.method.nodes) - 1))
            for i in self.histories:
                for age, rate in enumerate([rates[i], *ring.newest_first(i)[: PAST - 1]]):
                    slots.write(past_rate(solution, age, i), rate)


@dataclass(frozen=True)
class AdamsSteps:
    """Steps with a history of rates for every variable that has no partner.

    The rates at the corrected state differ so little from those at the predicted one
    that their divisions are one Newton step each from the reciprocals at hand.

    Attributes
    ----------
    partners : tuple of int or None
        See :func:`~remanent.integrate.methods.adams.partners`.
    rings : mapping of str to _Ring
        The past rates of each solution.
    """

    method: Adams
    code: FieldCode
    partners: tuple[int | None, ...]
    rings: Mapping[str, _Ring]

    @classmethod
    def load(
        cls, method: Adams, code: FieldCode, solutions: Sequence[str], slots: GroupSlots
    ) -> Self:
        """Read the past rates of a group."""

        def ring(solution: str) -> _Ring:
            past = _Ring.allocate(slots.writer, method.steps, slots.layout.histories)
            for i in slots.layout.histories:
                names = (past_rate(solution, age, i) for age in range(method.steps))
                past.fill(i, [slots.read(name) for name in names])
            return past

        rings = {solution: ring(solution) for solution in solutions}
        return cls(method, code, partners(code.field), rings)

    def save(self, slots: GroupSlots, ends: Mapping[str, StepEnd]) -> None:
        for solution, ring in self.rings.items():
            for i in ring.memory:
                for age, rate in enumerate(ring.newest_first(i)):
                    slots.write(past_rate(solution, age, i), rate)

    def advance(
        self, solution: str, y: Sequence[Lanes], h: Lanes, loads: Loads, update: Update
    ) -> list[Lanes]:
        """Predict, evaluate, correct, evaluate."""
        ring = self.rings[solution]
        past = ring.all_newest_first()
        sums = self._sums(past)
        predicted = self._predicted(y, h, sums)
        change = self._change(y, h, sums)
        reciprocals: list[Lanes] = []

        def divide(a: Lanes, b: Lanes) -> Lanes:
            reciprocals.append(b.writer.reciprocal(b))
            return a * reciprocals[-1]

        rates = self.code.rates(predicted, loads(1), divide)
        corrected = update(self._corrected(change, h, past, rates))
        # Both evaluations run the same program, so that the divisions come in the same order.
        nearby = iter(reciprocals)
        rates = self.code.rates(corrected, loads(1), lambda a, b: refined(a, next(nearby), b))
        ring.push({i: rates[i] for i in ring.memory})
        return corrected

    def _sums(self, past: Mapping[int, list[Lanes]]) -> list[Lanes]:
        """For every variable the weighted sum of past rates, or of its partner's."""
        return [
            combination(self.method.single, past[i])
            if partner is None
            else combination(self.method.double, past[partner])
            for i, partner in enumerate(self.partners)
        ]

    def _predicted(self, y: Sequence[Lanes], h: Lanes, sums: Sequence[Lanes]) -> list[Lanes]:
        """The state at the end of the step as the past rates foretell it."""
        return [
            a + h * sums[i] if partner is None else (a + h * y[partner]) + (h * h) * sums[i]
            for i, (a, partner) in enumerate(zip(y, self.partners, strict=True))
        ]

    def _change(self, y: Sequence[Lanes], h: Lanes, sums: Sequence[Lanes]) -> list[Lanes]:
        """What the prediction adds to the state.

        It is summed apart from the state, so that the correction is added to the small change
        and not to the large sum, which would cut off its last digits.
        """
        return [
            h * sums[i] if partner is None else h * (y[partner] + h * sums[i])
            for i, partner in enumerate(self.partners)
        ]

    def _corrected(
        self,
        change: list[Lanes],
        h: Lanes,
        past: Mapping[int, list[Lanes]],
        rates: Sequence[Lanes],
    ) -> list[Lanes]:
        """The change with the correction by the rates at the predicted state."""
        m = self.method
        surprise = {i: rates[i] + combination(m.difference, before) for i, before in past.items()}
        corrected = list(change)
        for i, partner in enumerate(self.partners):
            if partner is None:
                corrected[i] = change[i] + h * (surprise[i] * m.single_correction)
            elif partner in surprise:
                corrected[i] = change[i] + (h * h) * (surprise[partner] * m.double_correction)
        return corrected


def refined(a: Lanes, reciprocal: Lanes, b: Lanes) -> Lanes:
    """a/b from the reciprocal of a number close to b, by a Newton step.

    The two factors do not wait for each other.
    """
    return (a * reciprocal) * (2.0 - b * reciprocal)


@dataclass(frozen=True)
class _Ring:
    """Past rates in a memory in which each stands twice, so that any window is in order."""

    writer: Writer
    steps: int
    memory: dict[int, ir.Value]
    position: ir.Value

    @classmethod
    def allocate(cls, writer: Writer, steps: int, variables: Sequence[int]) -> _Ring:
        size = ir.ArrayType(writer.vector_type, 2 * steps)
        with writer.builder.goto_entry_block():
            memory = {i: writer.builder.alloca(size) for i in variables}
            position = writer.builder.alloca(INTEGER)
        writer.builder.store(writer.integer(0), position)
        return cls(writer, steps, memory, position)

    def fill(self, variable: int, newest_first: Sequence[Lanes]) -> None:
        for j, value in enumerate(newest_first):
            for copy in (0, self.steps):
                index = self.writer.integer(self.steps - 1 - j + copy)
                self.writer.builder.store(value.value, self._address(variable, index))

    def newest_first(self, variable: int) -> list[Lanes]:
        b, w = self.writer.builder, self.writer
        oldest = b.load(self.position)
        index = [b.add(oldest, w.integer(self.steps - 1 - j)) for j in range(self.steps)]
        return [Lanes(w, b.load(self._address(variable, k))) for k in index]

    def all_newest_first(self) -> dict[int, list[Lanes]]:
        return {i: self.newest_first(i) for i in self.memory}

    def push(self, rates: dict[int, Lanes]) -> None:
        """Put new rates in the place of the oldest ones, in both copies."""
        b, w = self.writer.builder, self.writer
        oldest = b.load(self.position)
        for variable, value in rates.items():
            b.store(value.value, self._address(variable, oldest))
            mirror = b.add(oldest, w.integer(self.steps))
            b.store(value.value, self._address(variable, mirror))
        following = b.add(oldest, w.integer(1))
        wrapped = b.icmp_signed("==", following, w.integer(self.steps))
        b.store(b.select(wrapped, w.integer(0), following), self.position)

    def _address(self, variable: int, index: ir.Value) -> ir.Value:
        return self.writer.builder.gep(self.memory[variable], [self.writer.integer(0), index])
