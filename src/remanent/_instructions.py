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
SignedValue = tuple[int, int]

#: Operations that cost about as much as an addition.
_CHEAP_OPERATIONS = frozenset({"add", "sub", "mul", "neg"})


def program_cost(program: Program) -> int:
    """Rough cost in additions."""
    return sum(_operation_cost(operation) for operation, *_ in program.instructions)


def _operation_cost(operation: str) -> int:
    """A division or a function is worth about ten additions."""
    return 1 if operation in _CHEAP_OPERATIONS else 10


class InstructionBuilder:
    """Instructions collected so far, numbered by value.

    Asking twice for the same operation on the same operands gives the same value:
    common subexpressions appear once.  This is a builder: values are added to it by each
    call, and it lives as long as the call that writes one program.
    """

    def __init__(self, inputs: Sequence[str]) -> None:
        self._input_names = tuple(inputs)
        self._number_of_key: dict[tuple[Any, ...], int] = {}
        self._keys: list[tuple[Any, ...]] = []
        for name in self._input_names:
            self._value_number("input", name)
        self._powers_of_value: dict[int, dict[int, int]] = {}

    def _value_number(self, *key: Any) -> int:
        if key not in self._number_of_key:
            self._number_of_key[key] = len(self._keys)
            self._keys.append(key)
        return self._number_of_key[key]

    def input(self, name: str) -> SignedValue:
        """An input of the program."""
        return 1, self._number_of_key["input", name]

    def constant(self, value: float) -> SignedValue:
        """A number, given with its sign apart."""
        return (-1 if value < 0 else 1), self._value_number("constant", abs(float(value)))

    def _is_constant(self, value: int, number: float) -> bool:
        return self._keys[value] == ("constant", number)

    def add(self, a: SignedValue, b: SignedValue) -> SignedValue:
        """a + b."""
        if a[0] == b[0]:
            return a[0], self._value_number("add", *sorted((a[1], b[1])))
        positive, negative = (a, b) if a[0] > 0 else (b, a)
        return 1, self._value_number("sub", positive[1], negative[1])

    def mul(self, a: SignedValue, b: SignedValue) -> SignedValue:
        """a b."""
        sign = a[0] * b[0]
        for factor, cofactor in ((a, b), (b, a)):
            if self._is_constant(factor[1], 1.0):
                return sign, cofactor[1]
        return sign, self._value_number("mul", *sorted((a[1], b[1])))

    def div(self, a: SignedValue, b: SignedValue) -> SignedValue:
        """a / b."""
        sign = a[0] * b[0]
        if self._is_constant(b[1], 1.0):
            return sign, a[1]
        return sign, self._value_number("div", a[1], b[1])

    def apply_function(self, function: str, a: SignedValue) -> SignedValue:
        """A function of one value."""
        return 1, self._value_number(function, self.with_sign_applied(a))

    def power(self, a: SignedValue, exponent: int) -> SignedValue:
        """a to a positive integer power, through powers that exist already."""
        powers = self._powers_of_value.setdefault(a[1], {1: a[1]})
        if exponent not in powers:
            low = self._split_exponent(powers, exponent)
            factors = self.power((1, a[1]), low), self.power((1, a[1]), exponent - low)
            powers[exponent] = self.mul(*factors)[1]
        return a[0] ** exponent, powers[exponent]

    @staticmethod
    def _split_exponent(powers: Mapping[int, int], exponent: int) -> int:
        """The lower of two exponents whose sum it is, of powers that exist where possible."""
        for low in sorted(powers, reverse=True):
            if exponent - low in powers:
                return low
        return exponent // 2 if exponent % 2 == 0 else exponent - 1

    def with_sign_applied(self, a: SignedValue) -> int:
        """The value itself, with its sign applied."""
        return a[1] if a[0] > 0 else self._value_number("neg", a[1])

    def _with_sign_absorbed(self, a: SignedValue) -> int:
        """The value itself, with its sign moved into a constant or a difference."""
        return a[1] if a[0] > 0 else (self._negated(a[1]) or self._value_number("neg", a[1]))

    def _negated(self, value: int) -> int | None:
        """Minus a value without an instruction ``neg``, where there is a way; else None."""
        operation, *operands = self._keys[value]
        if operation == "constant":
            return self._value_number("constant", -operands[0])
        if operation == "sub":
            return self._value_number("sub", *reversed(operands))
        if operation not in ("mul", "div"):
            return None
        # A numerator is tried before a denominator, which other values may share.
        for position in sorted((0, 1), key=lambda k: self._keys[operands[k]][0] == "div"):
            negated = self._negated(operands[position])
            if negated is not None:
                operands[position] = negated
                return self._value_number(operation, *operands)
        return None

    def build_program(self, outputs: Sequence[SignedValue]) -> Program:
        """The finished program, without values that no output needs."""
        choices = [
            [sign(output) for output in outputs]
            for sign in (self._with_sign_absorbed, self.with_sign_applied)
        ]
        cheapest = min(choices, key=lambda values: self._cost_of_steps(self._needed_steps(values)))
        steps = self._needed_steps(cheapest)
        used = {operand for k in steps for operand in self._keys[k][1:]} | set(cheapest)
        constants = sorted(k for k in used if self._keys[k][0] == "constant")
        order = [*range(len(self._input_names)), *constants, *steps]
        slot = dict(zip(order, count()))
        return Program(
            input_names=self._input_names,
            constants=tuple(float(self._keys[k][1]) for k in constants),
            instructions=tuple(
                (self._keys[k][0], *(slot[operand] for operand in self._keys[k][1:])) for k in steps
            ),
            output_slots=tuple(slot[k] for k in cheapest),
        )

    def _cost_of_steps(self, steps: Sequence[int]) -> int:
        return sum(_operation_cost(self._keys[k][0]) for k in steps)

    def _needed_steps(self, outputs: Sequence[int]) -> list[int]:
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
