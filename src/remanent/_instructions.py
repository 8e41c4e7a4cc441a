"""Straight-line code under construction: each distinct value is computed once.

Both columns write code this way: the symbolic one from expressions, the numeric one from
code that exists already (its derivatives).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import count
from typing import Any

from remanent._field import Program

#: A sign, +1 or -1, and the value it multiplies.  Signs are kept with values and merged
#: into additions, so that almost no negation is ever executed.
Signed = tuple[int, int]

#: Operations that cost about as much as an addition.
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
    common subexpressions appear once.  This is a builder: values are added to it by each
    call, and it lives as long as the call that writes one program.
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
        for factor, cofactor in ((a, b), (b, a)):
            if self._is_constant(factor[1], 1.0):
                return sign, cofactor[1]
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
        powers = self._powers.setdefault(a[1], {1: a[1]})
        if exponent not in powers:
            low = self._split(powers, exponent)
            factors = self.power((1, a[1]), low), self.power((1, a[1]), exponent - low)
            powers[exponent] = self.mul(*factors)[1]
        return a[0] ** exponent, powers[exponent]

    @staticmethod
    def _split(powers: Mapping[int, int], exponent: int) -> int:
        """The lower of two exponents whose sum it is, of powers that exist where possible."""
        for low in sorted(powers, reverse=True):
            if exponent - low in powers:
                return low
        return exponent // 2 if exponent % 2 == 0 else exponent - 1

    def plain(self, a: Signed) -> int:
        """The value itself, with its sign applied."""
        return a[1] if a[0] > 0 else self._value("neg", a[1])

    def _absorbed(self, a: Signed) -> int:
        """The value itself, with its sign moved into a constant or a difference."""
        return a[1] if a[0] > 0 else (self._negated(a[1]) or self._value("neg", a[1]))

    def _negated(self, value: int) -> int | None:
        """Minus a value without an instruction ``neg``, where there is a way; else None."""
        operation, *operands = self._keys[value]
        if operation == "constant":
            return self._value("constant", -operands[0])
        if operation == "sub":
            return self._value("sub", *reversed(operands))
        if operation not in ("mul", "div"):
            return None
        # A numerator is tried before a denominator, which other values may share.
        for position in sorted((0, 1), key=lambda k: self._keys[operands[k]][0] == "div"):
            negated = self._negated(operands[position])
            if negated is not None:
                operands[position] = negated
                return self._value(operation, *operands)
        return None

    def program(self, outputs: Sequence[Signed]) -> Program:
        """The finished program, without values that no output needs."""
        choices = [[sign(output) for output in outputs] for sign in (self._absorbed, self.plain)]
        cheapest = min(choices, key=lambda values: self._cost(self._steps(values)))
        steps = self._steps(cheapest)
        used = {operand for k in steps for operand in self._keys[k][1:]} | set(cheapest)
        constants = sorted(k for k in used if self._keys[k][0] == "constant")
        order = [*range(len(self._inputs)), *constants, *steps]
        slot = dict(zip(order, count()))
        return Program(
            inputs=self._inputs,
            constants=tuple(float(self._keys[k][1]) for k in constants),
            code=tuple(
                (self._keys[k][0], *(slot[operand] for operand in self._keys[k][1:])) for k in steps
            ),
            outputs=tuple(slot[k] for k in cheapest),
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
