"""How a kernel advances one of its two solutions by one step."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from llvmlite import ir

from remanent.integrate.kernel.lanes import INTEGER, Lanes, Variable, Writer
from remanent.integrate.kernel.layout import PAST, past
from remanent.integrate.methods.adams import Adams, combination
from remanent.integrate.methods.runge_kutta import RungeKutta

#: Phase and waveforms at a node of the step.
Loads = Callable[[int], list[Lanes]]
#: ``evaluate(state, load, divide)``: the rates, with divisions done by `divide`.
Evaluate = Callable[..., list[Lanes]]


class Stepper(Protocol):
    """Advances the solution called `kind` from `y` by a step of length `h`."""

    def load(self, read: Callable[[str], Lanes]) -> None:
        """Take over what earlier steps left."""

    def save(self, write: Callable[[str, Lanes], None], ends: Mapping[str, Loads]) -> None:
        """Leave what later steps need; `ends` are the loads of the last steps."""

    def increment(self, kind: str, y: Sequence[Lanes], h: Lanes, loads: Loads) -> list[Lanes]:
        """What the step adds to the state."""

    def settle(self, kind: str, y: Sequence[Lanes], loads: Loads) -> None:
        """Take note of the state at the end of the step."""


@dataclass
class RungeKuttaSteps:
    """Steps that need no past, but leave one."""

    method: RungeKutta
    evaluate: Evaluate
    histories: Sequence[int]
    solutions: Sequence[str]
    writer: Writer
    rings: dict[str, _Ring] = field(default_factory=dict)
    ends: dict[str, list[Variable]] = field(default_factory=dict)

    def load(self, read: Callable[[str], Lanes]) -> None:
        for kind in self.solutions:
            self.rings[kind] = _Ring.allocate(self.writer, PAST, self.histories)

    def save(self, write: Callable[[str, Lanes], None], ends: Mapping[str, Loads]) -> None:
        for kind, ring in self.rings.items():
            last = [cell.get() for cell in self.ends[kind]]
            rates = self.evaluate(last, ends[kind](len(self.method.nodes) - 1))
            for i in self.histories:
                for age, rate in enumerate([rates[i], *ring.newest_first(i)[: PAST - 1]]):
                    write(past(kind, age, i), rate)

    def increment(self, kind: str, y: Sequence[Lanes], h: Lanes, loads: Loads) -> list[Lanes]:
        found = [loads(node) for node in range(len(self.method.nodes))]
        first: list[list[Lanes]] = []

        def rates(node: int, z: Sequence[Lanes]) -> list[Lanes]:
            slopes = self.evaluate(z, found[node])
            first.append(slopes)
            return slopes

        change = self.method.increment(rates, y, h)
        self.rings[kind].push({i: first[0][i] for i in self.histories})
        return change

    def settle(self, kind: str, y: Sequence[Lanes], loads: Loads) -> None:
        if kind not in self.ends:
            self.ends[kind] = [self.writer.cell() for _ in y]
        for cell, value in zip(self.ends[kind], y, strict=True):
            cell.set(value)


@dataclass
class AdamsSteps:
    """Steps with a history of rates for every variable that has no partner.

    The rates at the corrected state differ so little from those at the predicted one
    that their divisions are one Newton step each from the reciprocals at hand.
    """

    method: Adams
    evaluate: Evaluate
    partners: tuple[int | None, ...]
    solutions: Sequence[str]
    writer: Writer
    rings: dict[str, _Ring] = field(default_factory=dict)
    reciprocals: list[Lanes] = field(default_factory=list)

    def load(self, read: Callable[[str], Lanes]) -> None:
        for kind in self.solutions:
            ring = _Ring.allocate(self.writer, self.method.steps, self._histories())
            for i in self._histories():
                ring.fill(i, [read(past(kind, j, i)) for j in range(self.method.steps)])
            self.rings[kind] = ring

    def save(self, write: Callable[[str, Lanes], None], ends: Mapping[str, Loads]) -> None:
        for kind, ring in self.rings.items():
            for i in self._histories():
                for j, value in enumerate(ring.newest_first(i)):
                    write(past(kind, j, i), value)

    def increment(self, kind: str, y: Sequence[Lanes], h: Lanes, loads: Loads) -> list[Lanes]:
        m, rates_before = self.method, self.rings[kind].all_newest_first()
        sums = {
            i: combination(
                m.single if partner is None else m.double,
                rates_before[i if partner is None else partner],
            )
            for i, partner in enumerate(self.partners)
        }
        predicted = [
            a + h * sums[i] if partner is None else (a + h * y[partner]) + (h * h) * sums[i]
            for i, (a, partner) in enumerate(zip(y, self.partners, strict=True))
        ]
        change = [
            h * sums[i] if partner is None else h * (y[partner] + h * sums[i])
            for i, partner in enumerate(self.partners)
        ]
        self.reciprocals.clear()
        rates = self.evaluate(predicted, loads(1), self._divide)
        surprise = {
            i: rates[i] + combination(m.difference, before) for i, before in rates_before.items()
        }
        for i, partner in enumerate(self.partners):
            if partner is None:
                change[i] = change[i] + h * (surprise[i] * m.single_correction)
            elif partner in surprise:
                change[i] = change[i] + (h * h) * (surprise[partner] * m.double_correction)
        return change

    def settle(self, kind: str, y: Sequence[Lanes], loads: Loads) -> None:
        known = iter(self.reciprocals)
        rates = self.evaluate(y, loads(1), lambda a, b: refined(a, next(known), b))
        self.rings[kind].push({i: rates[i] for i in self._histories()})

    def _histories(self) -> list[int]:
        return [i for i, partner in enumerate(self.partners) if partner is None]

    def _predicted(
        self, i: int, y: Sequence[Lanes], h: Lanes, before: dict[int, list[Lanes]]
    ) -> Lanes:
        partner = self.partners[i]
        if partner is None:
            change: Lanes = h * combination(self.method.single, before[i])
        else:
            change = h * (y[partner] + h * combination(self.method.double, before[partner]))
        return change

    def _divide(self, a: Any, b: Any) -> Any:
        reciprocal = self.writer.reciprocal(b)
        self.reciprocals.append(reciprocal)
        return a * reciprocal


def refined(a: Lanes, reciprocal: Lanes, b: Lanes) -> Lanes:
    """a/b from the reciprocal of a number close to b, by a Newton step.

    The two factors do not wait for each other.
    """
    return (a * reciprocal) * (2.0 - b * reciprocal)


@dataclass
class _Ring:
    """Past rates in a memory in which each stands twice, so that any window is in order."""

    writer: Writer
    steps: int
    memory: dict[int, ir.Value]
    position: ir.Value

    @classmethod
    def allocate(cls, writer: Writer, steps: int, variables: Sequence[int]) -> _Ring:
        size = ir.ArrayType(writer.vector, 2 * steps)
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
