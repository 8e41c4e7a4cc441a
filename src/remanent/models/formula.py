"""A formula that somebody wrote, read without running any of it.

Python's own parser turns the text into a tree; nothing of the tree is ever executed.  Only
numbers, names, arithmetic, powers and a few functions of one argument are let through, of
bounded size, and their values are worked out by walking the tree.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from types import MappingProxyType
from typing import Any, Final

import numpy as np

from remanent._errors import InputError

#: Functions of one argument.
FUNCTION_NAMES: Final = ("sqrt", "exp", "log", "sin", "cos")
#: A name with a value of its own.
PI_NAME: Final = "pi"
#: Largest number of characters of a formula.
MAX_CHARACTERS: Final = 2000
#: Largest number of nodes of its tree.
MAX_NODES: Final = 500
#: Largest depth of its tree.
MAX_DEPTH: Final = 60
#: Largest product of integer exponents that stand upon each other.
MAX_EXPONENT_PRODUCT: Final = 64

#: What a formula is written with.
_ALLOWED_CHARACTERS: Final = re.compile(r"[A-Za-z0-9_+*/(). \t\n-]*")
#: What each node of arithmetic does.
_OPERATORS: Final[Mapping[type, Callable[[Any, Any], Any]]] = MappingProxyType(
    {
        ast.Add: operator.add,
        ast.Sub: operator.sub,
        ast.Mult: operator.mul,
        ast.Div: operator.truediv,
    }
)
#: The remedy in every message about a formula.
_SYNTAX_REMEDY: Final = (
    "Write for example 'a*(I1 - 3) + b*log(I1/3)', with ** for powers and "
    f"{', '.join(FUNCTION_NAMES)} for functions."
)


@dataclass(frozen=True)
class Formula:
    """A formula in names.

    Attributes
    ----------
    text
        As it was understood; parsing it again gives the same formula.
    variable_names
        Names of the variables in it.
    """

    text: str
    variable_names: frozenset[str]
    _tree: ast.expr

    def __call__(self, values: Mapping[str, Any], fn: Any) -> Any:
        """The value for numbers of any kind.

        Parameters
        ----------
        values
            A value for every name.
        fn
            Where functions are found: the module numpy or sympy, for example.
        """
        return _evaluate(self._tree, values, fn)

    def sign_sensitive_parts(
        self, variables: frozenset[str], positive: frozenset[str]
    ) -> list[Formula]:
        """Parts whose sign must not change: of logarithms, roots, powers, denominators.

        Only those in which one of `variables` occurs, and which are not sums and products of
        `positive` names and numbers, positive by themselves.
        """
        nodes = {ast.unparse(node): node for node in _sign_sensitive_nodes(self._tree)}
        return [
            Formula(text, _variable_names(node), node)
            for text, node in nodes.items()
            if _variable_names(node) & variables and not _is_positive(node, positive)
        ]

    def factors(self) -> list[Formula]:
        """What the formula is a product of, up to whole powers and numbers."""
        return [Formula(ast.unparse(n), _variable_names(n), n) for n in _factors(self._tree)]


@lru_cache(maxsize=256)
def parse_formula(text: str, name: str = "expression") -> Formula:
    """Read a formula.

    Parameters
    ----------
    text
        Python's notation for arithmetic: ``+ - * / **``, parentheses, the functions of
        :data:`FUNCTION_NAMES`, numbers, ``pi``, and names.
    name
        Of the argument, for messages.

    Raises
    ------
    InputError
        If it is anything else, or too large.

    Examples
    --------
    >>> import math
    >>> float(parse_formula("a*x**2 + sqrt(x)")({"a": 0.5, "x": 4.0}, math))
    10.0
    """
    if len(text) > MAX_CHARACTERS:
        raise _refusal_error(
            name, f"have at most {MAX_CHARACTERS} characters", f"{len(text)} of them"
        )
    if not _ALLOWED_CHARACTERS.fullmatch(text):
        raise _refusal_error(
            name, "hold letters, digits and + - * / ( ) . only", _shortened_repr(text)
        )
    try:
        tree = ast.parse(" ".join(text.split()), mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        raise _refusal_error(name, "be a formula", _shortened_repr(text)) from error
    _require_size(name, tree)
    for node, _ in _walk_with_depth(tree):
        _require_allowed_node(name, node)
    for node, _ in _walk_with_depth(tree):
        number = _exact_constant(node)
        if number is not None:
            _require_float(name, number, ast.unparse(node))
    if _largest_exponent_product(tree) > MAX_EXPONENT_PRODUCT:
        raise _refusal_error(
            name, f"have powers up to {MAX_EXPONENT_PRODUCT}, also of powers", _shortened_repr(text)
        )
    return Formula(ast.unparse(tree), _variable_names(tree), tree)


def is_sympy_expression(value: object) -> bool:
    """Whether it is one, or a like object of SymPy; its symbols are not looked for."""
    return not isinstance(value, type) and hasattr(type(value), "free_symbols")


def sympy_as_formula_text(expression: Any, name: str = "expression") -> str:
    """A SymPy expression as text, its decimal fractions exact.

    Parameters
    ----------
    expression
        Arithmetic and powers of plain symbols and numbers, and the functions of formulas.
    name
        Of the argument, for messages.

    Raises
    ------
    InputError
        If anything else is in it, whose text could mean another thing: a symbol called ``pi`` or
        ``a + b``, a function of the user's own called ``sin``; or if it is too large.
    """
    import sympy as sp

    parts = _sympy_parts(name, expression)
    known = (sp.Add, sp.Mul, sp.Pow, sp.exp, sp.log, sp.sin, sp.cos)
    for part in parts:
        if isinstance(part, sp.Symbol):
            sound = part.name.isidentifier() and part.name != PI_NAME
        elif isinstance(part, sp.Number):
            sound = part.is_finite and all(map(_fits_float, sp.fraction(part)))
        else:
            sound = part in (sp.pi, sp.E) or (isinstance(part, sp.Expr) and part.func in known)
        if not sound:
            rule = "hold plain symbols, real numbers and the functions of formulas only"
            raise _refusal_error(name, rule, _shortened_repr(_short_text(part)))
    exact = {x: sp.Rational(repr(float(x))) for x in parts if isinstance(x, sp.Float)}
    exact[sp.E] = sp.Symbol("exp(1)")
    return str(sp.sstr(expression.xreplace(exact)))


def _sympy_parts(name: str, expression: Any) -> list[Any]:
    """Every part of a SymPy expression, which is walked without recursion."""
    parts, stack = [], [(expression, 1)]
    while stack:
        part, depth = stack.pop()
        parts.append(part)
        if len(parts) > MAX_NODES or depth > MAX_DEPTH:
            raise _size_error(name, len(parts), depth)
        stack += [(inner, depth + 1) for inner in getattr(part, "args", ())]
    return parts


def _short_text(part: Any) -> str:
    """What a part of a SymPy expression is: a number may have too many digits to write."""
    try:
        return str(part)
    except ValueError:
        return f"a number of the class {type(part).__name__}"


# What is let through --------------------------------------------------------------------


def _require_size(name: str, tree: ast.expr) -> None:
    for count, (_, depth) in enumerate(_walk_with_depth(tree), start=1):
        if count > MAX_NODES or depth > MAX_DEPTH:
            raise _size_error(name, count, depth)


def _size_error(name: str, count: int, depth: int) -> InputError:
    rule = f"have at most {MAX_NODES} parts, nested {MAX_DEPTH} deep"
    return _refusal_error(name, rule, f"part {count} at depth {depth}")


def _require_allowed_node(name: str, node: ast.expr) -> None:
    match node:
        case ast.Constant(value=int() | float() as number) if not isinstance(number, bool):
            _require_float(name, number, str(number))
        case ast.Name(id=word):
            if word.startswith("_") or word in FUNCTION_NAMES:
                raise _refusal_error(name, "use names as such, functions with (...)", word)
        case ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div()):
            pass
        case ast.UnaryOp(op=ast.USub() | ast.UAdd()):
            pass
        case ast.BinOp(op=ast.Pow(), right=exponent):
            if any(isinstance(n, ast.BinOp) and isinstance(n.op, ast.Pow)
                   for n, _ in _walk_with_depth(exponent)):  # fmt: skip
                raise _refusal_error(
                    name, "have no powers in exponents", _shortened_repr(ast.unparse(node))
                )
        case ast.Call(func=ast.Name(id=word), args=[_], keywords=[]) if word in FUNCTION_NAMES:
            pass
        case _:
            raise _refusal_error(name, "hold arithmetic only", _shortened_repr(ast.unparse(node)))


def _refusal_error(name: str, rule: str, value: str) -> InputError:
    return InputError(
        name, must=rule, got=value, why="A formula is read, never run.", fix=_SYNTAX_REMEDY
    )


def _shortened_repr(text: str) -> str:
    return repr(text if len(text) <= 60 else f"{text[:57]}...")


def _require_float(name: str, number: int | float | Fraction, text: str) -> None:
    if not _fits_float(number):
        raise _refusal_error(name, "have numbers that a float can hold", _shortened_repr(text))


def _fits_float(number: int | float | Fraction) -> bool:
    try:
        return abs(float(number)) <= 1e300
    except OverflowError:
        return False


# Walking the tree -----------------------------------------------------------------------


def _child_expressions(node: ast.expr) -> list[ast.expr]:
    """Parts of an expression; of a call its argument, not the name of the function."""
    if isinstance(node, ast.Call):
        return list(node.args)
    return [child for child in ast.iter_child_nodes(node) if isinstance(child, ast.expr)]


def _walk_with_depth(tree: ast.expr) -> Iterator[tuple[ast.expr, int]]:
    """Every part with its depth, without recursion."""
    stack = [(tree, 1)]
    while stack:
        node, depth = stack.pop()
        yield node, depth
        stack += [(child, depth + 1) for child in _child_expressions(node)]


def _variable_names(tree: ast.expr) -> frozenset[str]:
    return frozenset(
        n.id for n, _ in _walk_with_depth(tree) if isinstance(n, ast.Name) and n.id != PI_NAME
    )


def _largest_exponent_product(node: ast.expr) -> int:
    """The largest product of integer exponents that stand upon each other."""
    below = max((_largest_exponent_product(child) for child in _child_expressions(node)), default=1)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        exponent = _exact_constant(node.right)
        if exponent is not None and exponent.denominator == 1:
            return below * min(max(1, abs(exponent.numerator)), MAX_EXPONENT_PRODUCT + 1)
    return below


def _exact_constant(node: ast.expr) -> Fraction | None:
    """The exact value of arithmetic of numbers alone, as it was written in decimals."""
    match node:
        case ast.Constant(value=int() | float() as number):
            return Fraction(repr(number))
        case ast.UnaryOp(op=op, operand=inside):
            value = _exact_constant(inside)
            negative = isinstance(op, ast.USub)
            return None if value is None else -value if negative else value
        case ast.BinOp(op=op, left=left, right=right) if type(op) in _OPERATORS:
            a, b = _exact_constant(left), _exact_constant(right)
            if a is None or b is None or (isinstance(op, ast.Div) and b == 0):
                return None
            return Fraction(_OPERATORS[type(op)](a, b))
    return None


def _evaluate(node: ast.expr, values: Mapping[str, Any], fn: Any) -> Any:
    number = _exact_constant(node)
    if number is not None:
        return as_exact_number(number, fn)
    match node:
        case ast.Name(id=name):
            return fn.pi if name == PI_NAME else values[name]
        case ast.UnaryOp(op=op, operand=inside):
            value = _evaluate(inside, values, fn)
            return -value if isinstance(op, ast.USub) else value
        case ast.BinOp(op=ast.Pow(), left=base, right=exponent):
            return _evaluate(base, values, fn) ** _evaluate_exponent(exponent, values, fn)
        case ast.BinOp(op=op, left=left, right=right):
            return _OPERATORS[type(op)](_evaluate(left, values, fn), _evaluate(right, values, fn))
        case ast.Call(func=ast.Name(id=name), args=[argument]):
            return getattr(fn, name)(_evaluate(argument, values, fn))
    raise TypeError(f"not a formula: {ast.dump(node)}")  # refused by parse


def _evaluate_exponent(node: ast.expr, values: Mapping[str, Any], fn: Any) -> Any:
    number = _exact_constant(node)
    if number is not None and number.denominator == 1:
        return number.numerator
    return _evaluate(node, values, fn)


def as_exact_number(number: Fraction, fn: Any) -> Any:
    """A number as `fn` computes with it: an exact quotient where it has those, else a float."""
    rational = getattr(fn, "Rational", None)
    return (
        np.float64(number) if rational is None else rational(number.numerator, number.denominator)
    )


def _sign_sensitive_nodes(tree: ast.expr) -> Iterator[ast.expr]:
    for node, _ in _walk_with_depth(tree):
        match node:
            case ast.BinOp(op=ast.Div(), right=below):
                yield below
            case ast.BinOp(op=ast.Pow(), left=base, right=exponent):
                power = _exact_constant(exponent)
                if power is None or power.denominator != 1 or power < 0:
                    yield base
            case ast.Call(func=ast.Name(id="log" | "sqrt"), args=[argument]):
                yield argument


def _factors(node: ast.expr) -> Iterator[ast.expr]:
    """Factors of a product, a quotient or a whole power, but numbers."""
    match node:
        case ast.UnaryOp(operand=inside):
            yield from _factors(inside)
        case ast.BinOp(op=ast.Mult() | ast.Div(), left=left, right=right):
            yield from _factors(left)
            yield from _factors(right)
        case ast.BinOp(op=ast.Pow(), left=base, right=exponent):
            power = _exact_constant(exponent)
            if power is not None and power.denominator == 1:
                yield from _factors(base)
            else:
                yield node
        case _:
            if _exact_constant(node) is None:
                yield node


def _is_positive(node: ast.expr, positive: frozenset[str]) -> bool:
    number = _exact_constant(node)
    if number is not None:
        return number > 0
    match node:
        case ast.Name(id=name):
            return name in positive or name == PI_NAME
        case ast.BinOp(op=ast.Add() | ast.Mult() | ast.Div(), left=left, right=right):
            return _is_positive(left, positive) and _is_positive(right, positive)
        case ast.BinOp(op=ast.Pow(), left=base):
            return _is_positive(base, positive)
        case ast.Call(func=ast.Name(id="exp")):
            return True
    return False
