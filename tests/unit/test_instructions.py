"""Straight-line code under construction: signs, powers and repeated values."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from remanent._instructions import InstructionBuilder, SignedValue

A, B, C = 3.0, 5.0, 7.0
Make = Callable[[InstructionBuilder, list[SignedValue]], SignedValue]
NEGATED: dict[str, tuple[Make, float, int]] = {
    "a difference": (lambda i, x: i.add(x[0], minus(x[1])), B - A, 1),
    "a product with a difference": (lambda i, x: i.mul(x[2], i.add(x[0], minus(x[1]))), C * 2, 2),
    "a product with a constant": (lambda i, x: i.mul(x[2], i.constant(2.0)), -2 * C, 1),
    "a quotient of a difference": (lambda i, x: i.div(i.add(x[0], minus(x[1])), x[2]), 2 / C, 2),
    "a sum": (lambda i, x: i.add(x[0], x[1]), -A - B, 2),
    "an input": (lambda i, x: i.mul(x[0], i.constant(1.0)), -A, 1),
}


def minus(value: SignedValue) -> SignedValue:
    return -value[0], value[1]


@pytest.mark.parametrize("name", NEGATED)
def test_negative_outputs(name: str) -> None:
    """A sign is moved into a difference or a constant where there is one."""
    make, expected, length = NEGATED[name]
    instructions = InstructionBuilder(["a", "b", "c"])
    value = make(instructions, [instructions.input(letter) for letter in "abc"])
    program = instructions.build_program([minus(value)])
    assert program([A, B, C], functions=np) == [expected]
    assert len(program.instructions) == length


def test_a_division_is_not_done_twice_for_a_sign() -> None:
    """Negating 1/a anew for a second output would cost more than a negation."""
    instructions = InstructionBuilder(["a", "b"])
    inverse = instructions.div(instructions.constant(1.0), instructions.input("a"))
    program = instructions.build_program([inverse, minus(inverse)])
    assert [step[0] for step in program.instructions] == ["div", "neg"]


@pytest.mark.parametrize("signs", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_signs_in_sums_products_and_powers(signs: tuple[int, int]) -> None:
    """Sums, products, quotients and powers of signed values have the right sign."""
    instructions = InstructionBuilder(["a", "b"])
    a, b = ((sign, instructions.input(letter)[1]) for sign, letter in zip(signs, "ab", strict=True))
    results = [instructions.add(a, b), instructions.mul(a, b), instructions.div(a, b)]
    results += [instructions.power(a, 2), instructions.power(a, 3)]
    x, y = signs[0] * A, signs[1] * B
    expected = [x + y, x * y, x / y, x**2, x**3]
    assert instructions.build_program(results)([A, B], functions=np) == expected


@pytest.mark.parametrize("exponent", range(1, 20))
def test_powers(exponent: int) -> None:
    """A power has its value, with at most two multiplications for each bit of the exponent."""
    instructions = InstructionBuilder(["a"])
    program = instructions.build_program([instructions.power(instructions.input("a"), exponent)])
    assert program([A], functions=np) == [A**exponent]
    assert len(program.instructions) <= 2 * exponent.bit_length() - 2


def test_values_that_no_output_needs_are_left_out() -> None:
    """A program holds only what its outputs need, and an output twice costs nothing."""
    instructions = InstructionBuilder(["a", "b"])
    instructions.mul(instructions.input("a"), instructions.constant(3.0))
    kept = instructions.add(instructions.input("a"), instructions.input("b"))
    program = instructions.build_program([kept, kept])
    assert (len(program.instructions), program.constants) == (1, ())
    assert program([A, B], functions=np) == [A + B] * 2
