"""Straight-line code under construction: each distinct value is computed once.

Both columns write code this way: the symbolic one from expressions, the numeric one from
code that exists already (its derivatives).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import count
from typing import Any

from remanent._field import Program

#: A sign, +1 or -1, and the value it multiplies.  Signs are carried along and merged
#: into additions, so that almost no negation is ever executed.
Signed = tuple[int, int]

_CHEAP = frozenset({"add", "sub", "mul", "neg"})


def cost(program: Program) -> int:
    """Rough cost in additions."""
    return sum(_weight(operation) for operation, *_ in program.code)


def _weight(operation: str) -> int:
    """A division or a function is worth about ten additions."""
    return 1 if operation in _CHEAP else 10


class Instructions:
    """Instructions collected so far, numbered by value.

    Asking twice for the same operation on the same operands gives the same value:
    common subexpressions appear once.  (A mutable object, which lives
    as long as the call that writes one program.)
    """

    def __init__(self, inputs: Sequence[str]) -> None:
        self._inputs = tuple(inputs)
        self._values: dict[tuple[Any, ...], int] = {}
        self._keys: list[tuple[Any, ...]] = []
        for name in self._inputs:
            self._value("input", name)
        self._powers: dict[int, dict[int, int]] = {}

    def _value(self, *key: Any) -> int:
        if key not in self._values:
            self._values[key] = len(self._keys)
            self._keys.append(key)
        return self._values[key]

    def input(self, name: str) -> Signed:
        """An input of the program."""
        return 1, self._values["input", name]

    def constant(self, value: float) -> Signed:
        """A number, given with its sign apart."""
        return (-1 if value < 0 else 1), self._value("constant", abs(float(value)))

    def _is_constant(self, value: int, number: float) -> bool:
        return self._keys[value] == ("constant", number)

    def add(self, a: Signed, b: Signed) -> Signed:
        """a + b."""
        if a[0] == b[0]:
            return a[0], self._value("add", *sorted((a[1], b[1])))
        positive, negative = (a, b) if a[0] > 0 else (b, a)
        return 1, self._value("sub", positive[1], negative[1])

    def mul(self, a: Signed, b: Signed) -> Signed:
        """a b."""
        sign = a[0] * b[0]
        for one, other in ((a, b), (b, a)):
            if self._is_constant(one[1], 1.0):
                return sign, other[1]
        return sign, self._value("mul", *sorted((a[1], b[1])))

    def div(self, a: Signed, b: Signed) -> Signed:
        """a / b."""
        sign = a[0] * b[0]
        if self._is_constant(b[1], 1.0):
            return sign, a[1]
        return sign, self._value("div", a[1], b[1])

    def call(self, function: str, a: Signed) -> Signed:
        """A function of one value."""
        return 1, self._value(function, self.plain(a))

    def power(self, a: Signed, exponent: int) -> Signed:
        """a to a positive integer power, through powers that exist already."""
        known = self._powers.setdefault(a[1], {1: a[1]})
        if exponent not in known:
            low = self._split(known, exponent)
            left, right = self.power((1, a[1]), low), self.power((1, a[1]), exponent - low)
            known[exponent] = self.mul(left, right)[1]
        return a[0] ** exponent, known[exponent]

    @staticmethod
    def _split(known: Mapping[int, int], exponent: int) -> int:
        for low in sorted(known, reverse=True):
            if exponent - low in known:
                return low
        return exponent // 2 if exponent % 2 == 0 else exponent - 1

    def plain(self, a: Signed) -> int:
        """The value itself, with its sign applied."""
        return a[1] if a[0] > 0 else self._value("neg", a[1])

    def _absorbed(self, a: Signed) -> int:
        """The value itself, with its sign moved into a constant or a difference."""
        return a[1] if a[0] > 0 else (self._negated(a[1]) or self._value("neg", a[1]))

    def _negated(self, value: int) -> int | None:
        operation, *operands = self._keys[value]
        if operation == "constant":
            return self._value("constant", -operands[0])
        if operation == "sub":
            return self._value("sub", *reversed(operands))
        if operation not in ("mul", "div"):
            return None
        for position in sorted((0, 1), key=lambda k: self._keys[operands[k]][0] == "div"):
            other = self._negated(operands[position])
            if other is not None:
                operands[position] = other
                return self._value(operation, *operands)
        return None

    def program(self, outputs: Sequence[Signed]) -> Program:
        """The finished program, without values that no output needs."""
        choices = [[sign(output) for output in outputs] for sign in (self._absorbed, self.plain)]
        wanted = min(choices, key=lambda values: self._cost(self._steps(values)))
        steps = self._steps(wanted)
        used = {operand for k in steps for operand in self._keys[k][1:]} | set(wanted)
        constants = sorted(k for k in used if self._keys[k][0] == "constant")
        order = [*range(len(self._inputs)), *constants, *steps]
        slot = dict(zip(order, count()))
        return Program(
            inputs=self._inputs,
            constants=tuple(float(self._keys[k][1]) for k in constants),
            code=tuple(
                (self._keys[k][0], *(slot[operand] for operand in self._keys[k][1:])) for k in steps
            ),
            outputs=tuple(slot[k] for k in wanted),
        )

    def _cost(self, steps: Sequence[int]) -> int:
        return sum(_weight(self._keys[k][0]) for k in steps)

    def _steps(self, outputs: Sequence[int]) -> list[int]:
        """Operations that the outputs need, in the order in which they were recorded."""
        needed: set[int] = set()
        stack = list(outputs)
        while stack:
            value = stack.pop()
            operation, *operands = self._keys[value]
            if value not in needed and operation not in ("constant", "input"):
                needed.add(value)
                stack.extend(operands)
        return sorted(needed)
