"""Linear equations for accelerations, solved in symbols."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from math import gcd, lcm
from typing import Any

import sympy as sp

from remanent.derivation.symbols import Expression, Symbol


def _pair_symbol(name: str) -> Symbol:
    return sp.Symbol(f"pair.{name}", real=True)


#: The product of two coordinates, and one over it.
_PRODUCT, _INVERSE = _pair_symbol("product"), _pair_symbol("inverse_product")
#: Exponents of factors that vary, without those that are 0.
Monomial = tuple[tuple[Expression, int], ...]


def solve_symmetric(
    matrix: Any, right: Sequence[Expression], name: str
) -> tuple[dict[Symbol, Expression], list[Expression]]:
    """Solve A x = b for a symmetric positive matrix, in definitions: A = L D L^T.

    Elimination needs no exchange of rows where A is positive.

    Parameters
    ----------
    matrix : Matrix (n, n)
    right : sequence of Expression (n,)
    name : str
        What symbols of intermediate results begin with.

    Returns
    -------
    definitions : dict of Symbol to Expression
        What the intermediate symbols stand for, in order.
    solution : list of Expression (n,)
    """
    n = len(right)
    definitions: dict[Symbol, Expression] = {}
    if n == 1:  # the plain quotient, whose form stays that of the energies
        return definitions, [right[0] / matrix[0, 0]]

    def define(kind: str, value: Expression) -> Expression:
        if value.is_Number or value.is_Symbol:
            return value
        symbol = sp.Symbol(f"{name}.{kind}", real=True)
        definitions[symbol] = value
        return symbol

    pivots: list[Expression] = []
    lower = sp.eye(n)
    for j in range(n):
        left_out = sum((lower[j, k] ** 2 * pivots[k] for k in range(j)), start=sp.Integer(0))
        pivots.append(define(f"pivot_{j}", matrix[j, j] - left_out))
        for i in range(j + 1, n):
            left_out = sum(
                (lower[i, k] * lower[j, k] * pivots[k] for k in range(j)), start=sp.Integer(0)
            )
            lower[i, j] = define(f"factor_{i}_{j}", (matrix[i, j] - left_out) / pivots[j])
    forward: list[Expression] = []
    for i in range(n):
        known = sum((lower[i, k] * forward[k] for k in range(i)), start=sp.Integer(0))
        forward.append(define(f"force_{i}", sp.sympify(right[i]) - known))
    solution: list[Expression] = [sp.Integer(0)] * n
    for i in reversed(range(n)):
        known = sum((lower[k, i] * solution[k] for k in range(i + 1, n)), start=sp.Integer(0))
        solution[i] = define(f"solution_{i}", forward[i] / pivots[i] - known)
    return definitions, solution


def solve_pair_expanded(
    matrix: Any, right: Sequence[Expression], moving: Sequence[Symbol]
) -> tuple[dict[Symbol, Expression], list[Expression]]:
    """Solve A x = b for two unknowns by Cramer's rule, everything written out and nested.

    Negative powers of the coordinates become powers of one over their product, the only
    quotient beside that by the determinant.  Common factors of terms are taken out of them
    again and again, and the number that most terms of b have out of b.

    Parameters
    ----------
    matrix : Matrix (2, 2)
    right : sequence of Expression (2,)
    moving : sequence of Symbol
        What varies with the state: first the two coordinates.

    Returns
    -------
    definitions, solution
        As of :func:`solve_symmetric`.
    """
    names = ("mass_1", "mass_12", "mass_2", "force_1", "force_2", "over_determinant")
    m_1, m_12, m_2, f_1, f_2, over_determinant = (_pair_symbol(name) for name in names)
    accelerations = [_pair_symbol("acceleration_1"), _pair_symbol("acceleration_2")]
    entries = [matrix[0, 0], matrix[0, 1], matrix[1, 1], *right]
    scale = lcm(*(int(number.q) for entry in entries for number in _numbers_of_terms(entry)))
    often = Counter(abs(scale * number) for entry in right for number in _numbers_of_terms(entry))
    content = max(sorted(often), key=often.__getitem__, default=sp.Integer(1))
    determinant = sp.expand(scale**2 * (matrix[0, 0] * matrix[1, 1] - matrix[0, 1] ** 2))
    numerator, denominator = (
        nested_in_pair(part, moving) for part in sp.fraction(sp.together(determinant))
    )
    product = moving[0] * moving[1]
    definitions: dict[Symbol, Expression] = {_PRODUCT: product, _INVERSE: 1 / _PRODUCT}
    for symbol, entry in zip((m_1, m_12, m_2), entries[:3], strict=True):
        definitions[symbol] = nested_in_pair(scale * entry, moving)
    for symbol, entry in zip((f_1, f_2), right, strict=True):
        definitions[symbol] = nested_in_pair(scale * entry / content, moving)
    definitions[over_determinant] = content * denominator / numerator
    definitions[accelerations[0]] = over_determinant * (m_2 * f_1 - m_12 * f_2)
    definitions[accelerations[1]] = over_determinant * (m_1 * f_2 - m_12 * f_1)
    return definitions, accelerations


def nested_in_pair(expression: Expression, moving: Sequence[Symbol]) -> Expression:
    """An expression with common factors taken out, in the symbols of :func:`solve_pair_expanded`.

    Parameters
    ----------
    moving : sequence of Symbol
        What varies with the state: first the two coordinates.
    """
    pair = (*moving[:2], _PRODUCT, _INVERSE)
    return _nested(_terms(expression, pair, moving), pair)


def _numbers_of_terms(expression: Expression) -> list[Any]:
    """The rational numbers in front of the terms of an expression."""
    factors = (term.as_coeff_Mul()[0] for term in sp.Add.make_args(sp.expand(expression)))
    return [factor for factor in factors if factor.is_Rational and factor]


def _terms(
    expression: Expression, pair: Sequence[Symbol], moving: Sequence[Symbol]
) -> dict[Monomial, Expression]:
    """Terms of a sum: the number in front of each, by the exponents of its factors.

    What is constant in a term, its number apart, is one factor.

    Parameters
    ----------
    pair : (first, second, product, inverse)
        Two coordinates, and the symbols of their product and of one over it: negative powers
        become powers of the latter, and where all terms with the same constant have some, the
        same power, which shows more common factors.
    """
    first, second, _, inverse = pair
    groups: dict[Expression, list[tuple[Expression, Counter[Expression]]]] = {}
    for term in sp.Add.make_args(sp.expand(expression)):
        fixed, varying = term.as_independent(*moving, as_Add=False)
        number, constant = fixed.as_coeff_Mul()
        exponents: Counter[Expression] = Counter()
        for factor in sp.Mul.make_args(varying):
            base, power = factor.as_base_exp()
            whole = power.is_Integer and (power > 0 or base in (first, second))
            exponents[base if whole else factor] += int(power) if whole else 1
        groups.setdefault(constant, []).append((number, exponents))
    terms: Counter[Monomial] = Counter()
    for constant, group in groups.items():
        below = [max(0, -e[first], -e[second]) for _, e in group]
        for (number, exponents), own in zip(group, below, strict=True):
            power = max(below) if min(below) > 0 else own
            exponents.update({first: power, second: power, inverse: power, constant: 1})
            terms[_monomial(exponents)] += number
    return dict(terms)


def _monomial(exponents: Mapping[Expression, int]) -> Monomial:
    return tuple((factor, n) for factor, n in exponents.items() if n and factor != 1)


def _nested(terms: Mapping[Monomial, Expression], pair: Sequence[Symbol]) -> Expression:
    """A sum with the factor that most terms have taken out of them, and so on inside."""
    if not terms:
        return sp.Integer(0)
    number = _common_number(terms)
    if len(terms) > 1 and number != 1:
        inner = _nested({m: n / number for m, n in terms.items()}, pair)
        return _times(number, inner, pair[3])
    shared = Counter(factor for monomial in terms for factor, _ in monomial)
    # Of equals one over the product last: what it multiplies is often the same for both.
    first, second, _, inverse = pair
    rank = {first: 1, second: 1, inverse: 2}
    in_order = sorted(shared, key=lambda f: (rank.get(f, 0), sp.default_sort_key(f)))
    most = max(in_order, key=shared.__getitem__, default=None)
    if most is None or shared[most] < 2:
        return sp.Add(*(n * _product(m, pair) for m, n in terms.items()))
    power = min(n for monomial in terms for factor, n in monomial if factor == most)
    inside: dict[Monomial, Expression] = {}
    beside: dict[Monomial, Expression] = {}
    for monomial, n in terms.items():
        exponents = dict(monomial)
        if most in exponents:
            inside[_monomial({**exponents, most: exponents[most] - power})] = n
        else:
            beside[monomial] = n
    taken_out = _times(most**power, _nested(inside, pair), inverse)
    return sp.Add(taken_out, _nested(beside, pair)) if beside else taken_out


def _common_number(terms: Mapping[Monomial, Expression]) -> Expression:
    """A number that divides those of all terms: where they are no integers, their own size."""
    numbers = [abs(n) for n in terms.values()]
    if all(n.is_Integer for n in numbers):
        return sp.Integer(gcd(*map(int, numbers)))
    return numbers[0] if len({*numbers}) == 1 else sp.Integer(1)


def _times(factor: Expression, inner: Expression, apart: Symbol) -> Expression:
    """A product as it stands: SymPy would multiply a number into a sum.

    An inner product with the symbol `apart` stays one factor.
    """
    if factor == 1:
        return inner
    joined = sp.Mul.make_args(inner)
    if any(part.as_base_exp()[0] == apart for part in joined):
        joined = (inner,)
    return sp.Mul(factor, *joined, evaluate=False)


def _product(monomial: Monomial, pair: Sequence[Symbol]) -> Expression:
    """Factors to their powers, squares of products as such, with the product of the pair."""
    first, second, product, _ = pair
    exponents = Counter(dict(monomial))
    both = min(exponents[first], exponents[second])
    exponents.update({first: -both, second: -both, product: both})
    left = _monomial(exponents)
    power = gcd(*(n for _, n in left)) or 1
    base = sp.Mul(*(factor ** (n // power) for factor, n in left))
    return sp.Pow(base, power, evaluate=False) if power > 1 and len(left) > 1 else base**power
