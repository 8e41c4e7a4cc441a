"""A SymPy function that stops the expansion of its argument."""

from __future__ import annotations

from typing import Any

import sympy as sp


class Unexpanded(sp.Function):  # type: ignore[misc]
    """An expression that is not expanded with what surrounds it.

    Rates are brought to quotients of polynomials.  Long formulas with roots and logarithms
    are left out of that, and so are a user's, whose expansion may have no end.  The
    derivative of an unexpanded expression is the derivative, unexpanded.

    Examples
    --------
    >>> x = sp.Symbol("x", real=True)
    >>> Unexpanded(sp.sin(x)).diff(x)
    Unexpanded(cos(x))
    """

    nargs = 1
    is_extended_real = True

    @classmethod
    def eval(cls, inside: Any) -> Any:
        """Numbers and symbols need no mark."""
        inside = sp.sympify(inside)
        return inside if inside.is_Number or inside.is_Symbol else None

    def _eval_derivative(self, symbol: Any) -> Any:
        return Unexpanded(self.args[0].diff(symbol))

    def doit(self, **_hints: Any) -> Any:
        """The argument itself."""
        return self.args[0]

    def _latex(self, printer: Any, **_options: Any) -> str:
        return str(printer.parenthesize(self.args[0], 50))


def without_mark(expression: Any) -> Any:
    """What is in the mark, where all of an expression is in one; else the expression."""
    return expression.args[0] if isinstance(expression, Unexpanded) else expression
