"""Expressions of straight-line code as trees, and their text by a table of operations.

The order of operations in the text is that of the code: where a language would read a sum or a
product in another order, there are parentheses.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final, TypeAlias

from remanent.codegen.languages.language import Language

#: The name of a value, a number, or an operation before its operands.
Expression: TypeAlias = "str | float | tuple[Expression, ...]"

#: How tightly the parts of a text hold together: a sign, a sum, a product, a name or a call.
_SIGNED, _SUM, _PRODUCT, _ATOM = range(4)
#: For each operation how tightly its text holds, and how tightly its operands have to.
_TIGHTNESS: Final[Mapping[str, tuple[int, tuple[int, ...]]]] = {
    "add": (_SUM, (_SUM, _PRODUCT)),
    "sub": (_SUM, (_SUM, _PRODUCT)),
    "mul": (_PRODUCT, (_PRODUCT, _ATOM)),
    "div": (_PRODUCT, (_PRODUCT, _ATOM)),
    "neg": (_SIGNED, (_ATOM,)),
}
#: Of every other operation, a function of one value.
_TIGHTNESS_OF_CALL: Final = (_ATOM, (_SIGNED,))


def expression_text(
    expression: Expression, language: Language, identifiers: Mapping[str, str]
) -> str:
    """An expression in a language.

    Parameters
    ----------
    expression
        A tree.
    language
        Whose text it becomes.
    identifiers
        The text of each name.
    """
    return _text_and_tightness(expression, language, identifiers)[0]


def names_in(expression: Expression) -> Iterator[str]:
    """The names of the values that an expression needs."""
    if isinstance(expression, str):
        yield expression
    elif isinstance(expression, tuple):
        for operand in expression[1:]:
            yield from names_in(operand)


def operations_in(expression: Expression) -> Iterator[str]:
    """The operations of an expression."""
    if isinstance(expression, tuple):
        yield str(expression[0])
        for operand in expression[1:]:
            yield from operations_in(operand)


def leaf_count(expression: Expression) -> int:
    """How many names and numbers an expression has."""
    if isinstance(expression, tuple):
        return sum(map(leaf_count, expression[1:]))
    return 1


def _text_and_tightness(
    expression: Expression, language: Language, identifiers: Mapping[str, str]
) -> tuple[str, int]:
    if isinstance(expression, str):
        return identifiers[expression], _ATOM
    if isinstance(expression, float):
        text = language.number(expression)
        return text, _SIGNED if text.startswith("-") else _ATOM
    operation = str(expression[0])
    tightness, needed = _TIGHTNESS.get(operation, _TIGHTNESS_OF_CALL)
    operands = []
    for operand, least in zip(expression[1:], needed, strict=True):
        text, own = _text_and_tightness(operand, language, identifiers)
        operands.append(text if own >= least else f"({text})")
    return language.operations[operation].format(*operands), tightness
