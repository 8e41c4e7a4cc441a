"""Normal forms: quotients of polynomials in the state, with one division in all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from remanent.derivation.symbols import Expression, Symbol


@dataclass(frozen=True)
class Quotient:
    """numerator / (static * product of factors to their powers), in lowest terms.

    Numerator and factors are polynomials; every factor depends on the state, `static_denominator`
    does not.
    """

    numerator: Expression
    static_denominator: Expression
    denominator_powers: Mapping[Expression, int]


def as_quotient(expression: Expression, dynamic: frozenset[Symbol]) -> Quotient:
    """`expression`, a rational function, in lowest terms; `dynamic` symbols vary with state."""
    numerator, denominator = sp.fraction(sp.cancel(sp.together(expression)))
    content, pairs = sp.factor_list(denominator)
    factors = {base: k for base, k in pairs if base.free_symbols & dynamic}
    static = sp.Mul(content, *(base**k for base, k in pairs if base not in factors))
    return Quotient(numerator, static, factors)


def least_common_multiple(quotients: Sequence[Quotient]) -> dict[Expression, int]:
    """Least common multiple of the factors, in a definite order."""
    powers: dict[Expression, int] = {}
    for item in quotients:
        for base, k in item.denominator_powers.items():
            powers[base] = max(k, powers.get(base, 0))
    return {base: powers[base] for base in sorted(powers, key=sp.default_sort_key)}


def rationalised(expression: Expression, generators: dict[Expression, Symbol]) -> Expression:
    """`expression` with a symbol for each function in it, so that it is rational.

    Symbols are added to `generators`, keyed by the function they stand for: square
    roots, exponentials, logarithms ... and powers b^a as exp(a log(b)).
    """
    if expression.is_Atom:
        return expression
    if expression.is_Pow and not expression.exp.is_Integer:
        return sp.Mul(
            *(
                _rationalised_power(expression.base, term, generators)
                for term in sp.Add.make_args(expression.exp)
            )
        )
    if expression.is_Function:
        return _generator_symbol(expression, generators)
    return expression.func(*(rationalised(a, generators) for a in expression.args))


def _rationalised_power(
    base: Expression, exponent: Expression, generators: dict[Expression, Symbol]
) -> Expression:
    """base^exponent as an integer power of a generator, base^(p r/q) = (base^(r/q))^p."""
    coefficient, rest = exponent.as_coeff_Mul()
    root = rest / coefficient.q
    if root == 1:
        return rationalised(base, generators) ** coefficient.p
    if root == sp.Rational(1, 2):
        return _generator_symbol(sp.sqrt(base), generators) ** coefficient.p
    return (
        _generator_symbol(sp.exp(root * sp.log(base), evaluate=False), generators) ** coefficient.p
    )


def _generator_symbol(function: Expression, generators: dict[Expression, Symbol]) -> Symbol:
    if function not in generators:
        generators[function] = sp.Symbol(f"generator_{len(generators)}", real=True)
    return generators[function]
