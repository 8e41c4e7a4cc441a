"""How long rational functions become when they are written out."""

from __future__ import annotations

from math import comb, prod
from typing import Final

from remanent.derivation.symbols import Expression

#: Terms up to which it is tried whether an expression is shorter when it is written out.
_MAX_TERMS: Final = 200


def may_be_expanded(*expressions: Expression) -> bool:
    """Whether all have so few terms when they are written out that this takes no long time.

    Examples
    --------
    >>> import sympy as sp
    >>> x, y, z = sp.symbols("x y z")
    >>> may_be_expanded((x + y + z) ** 4), may_be_expanded((x + y + z) ** 40)
    (True, False)
    """
    return all(max(expanded_sizes(e)) <= _MAX_TERMS for e in expressions)


def expanded_sizes(expression: Expression) -> tuple[int, int]:
    """Terms of numerator and denominator of a rational function, written out, at most.

    Products of sums with m and n terms have m n; the k-th power of n terms has as many as there
    are ways to choose k of n with repetition.  Denominators are taken to have no common factor.

    Examples
    --------
    >>> import sympy as sp
    >>> x, y = sp.symbols("x y")
    >>> expanded_sizes((x + y) ** 2 / (1 + x) + 1)
    (5, 2)
    """
    if expression.is_Add or expression.is_Mul:
        above, below = zip(*map(expanded_sizes, expression.args), strict=True)
        whole = prod(below)
        if expression.is_Mul:
            return prod(above), whole
        return sum(n * (whole // d) for n, d in zip(above, below, strict=True)), whole
    if expression.is_Pow and expression.exp.is_Integer:
        power = abs(int(expression.exp))
        top, bottom = (comb(n + power - 1, power) for n in expanded_sizes(expression.base))
        return (top, bottom) if expression.exp > 0 else (bottom, top)
    return 1, 1
