"""A mark in an expression: what is inside is computed as it is written."""

from __future__ import annotations

from typing import Any

import sympy as sp


class Kept(sp.Function):  # type: ignore[misc]
    """An expression that is not expanded with what surrounds it.

    Rates are brought to quotients of polynomials.  That is not wanted of long formulas with
    roots and logarithms, nor of a user's, whose expansion may have no end.  The derivative
    of a kept expression is the kept derivative.

    Examples
    --------
    >>> x = sp.Symbol("x", real=True)
    >>> Kept(sp.sin(x)).diff(x)
    Kept(cos(x))
    """

    nargs = 1
    is_extended_real = True

    @classmethod
    def eval(cls, inside: Any) -> Any:
        """Numbers and symbols need no mark."""
        inside = sp.sympify(inside)
        return inside if inside.is_Number or inside.is_Symbol else None

    def _eval_derivative(self, symbol: Any) -> Any:
        return Kept(self.args[0].diff(symbol))

    def doit(self, **_hints: Any) -> Any:
        """What is inside."""
        return self.args[0]

    def _latex(self, printer: Any, **_options: Any) -> str:
        return str(printer.parenthesize(self.args[0], 50))
