"""From SymPy expressions to straight-line code with few operations.

Three levels of dependence are kept apart, so that a compiler can move work out of the
loop: values of parameters alone, values that also depend on the drive's phase and
waveforms, and values that depend on the state.  Rates are computed millions of times:
what depends on the state is brought to quotients of polynomials, with one division for
all of them, and evaluated by nested multiplication.  Everything else is computed as it
is written, so that a formula that avoids cancellation keeps doing so.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import IntEnum
from functools import reduce
from itertools import accumulate
from typing import Any, Final

import sympy as sp

from remanent._field import Program
from remanent._instructions import InstructionBuilder, SignedValue, program_cost
from remanent.codegen.rational import Quotient, as_quotient, least_common_multiple, rationalised
from remanent.derivation.expansion import may_be_expanded
from remanent.derivation.symbols import Expression, Symbol, substitute_definitions
from remanent.derivation.unexpanded import Unexpanded

#: Exponents of a product of powers of state variables.
MonomialExponents = tuple[int, ...]


class DependenceLevel(IntEnum):
    """What a value varies with; the highest level in an expression is that of its value."""

    #: Nothing within a piece of time: numeric fields.
    PARAMETER = 0
    #: Time: phase and waveforms of the drive.
    DRIVE = 1
    #: The state.
    STATE = 2


#: Up to so many state variables, normal forms of all rates may be shorter than their
#: structure, and both are tried.
_MAX_STATES_FOR_NORMAL_FORM: Final = 2

#: Largest numerator or denominator of a number that is computed as a quotient.
_LARGEST_PART_OF_QUOTIENT: Final = 10**300

#: The instruction for each function of SymPy.
_INSTRUCTION_OF_FUNCTION: Final = {
    sp.exp: "exp",
    sp.log: "log",
    sp.sin: "sin",
    sp.cos: "cos",
    sp.atan: "atan",
}


def lower_to_program(
    outputs: Sequence[Expression],
    *,
    inputs: Sequence[str],
    levels: Mapping[Symbol, DependenceLevel],
    definitions: Mapping[Symbol, Expression],
    as_written: bool = False,
    admissibility_conditions: Sequence[Expression] = (),
) -> Program:
    """The program that computes `outputs`.

    Parameters
    ----------
    outputs
        Expressions in the symbols of `levels` and of `definitions`.
    inputs
        Names of the program's inputs, in order.
    levels
        For each input symbol what it varies with.
    definitions
        Symbols that stand for expressions in input symbols and earlier definitions.
    as_written
        Compute the expressions as they are written instead of bringing what depends
        on the state to quotients of expanded polynomials.
    admissibility_conditions
        Where one of these is negative, every output that is not just an input is NaN.
    """
    translator = _Translator(InstructionBuilder(inputs), levels, definitions)
    plain = [sp.sympify(output) for output in outputs]
    if as_written:
        return translator.instructions.build_program(
            [translator.value_as_written(e) for e in plain]
        )
    limits = [sp.sympify(e) for e in admissibility_conditions]
    values = translator.values_with_shared_divisions([*plain, *limits])[: len(plain)]
    structured = translator.instructions.build_program(
        translator.nan_where_inadmissible(limits, plain, values)
    )
    # Of few state variables the normal form may be cheaper: everything is written out as
    # quotients of polynomials.  Of more it is not, and cancelling takes SymPy very long.
    if (
        sum(level == DependenceLevel.STATE for level in levels.values())
        > _MAX_STATES_FOR_NORMAL_FORM
    ):
        return structured
    inner = {
        s: e for s, e in definitions.items() if translator.highest_level(s) == DependenceLevel.STATE
    }
    generators: dict[Expression, Symbol] = {}
    rational = [rationalised(substitute_definitions(e, inner), generators) for e in plain]
    if not may_be_expanded(*rational):
        return structured
    meanings = {s: e for s, e in definitions.items() if s not in inner}
    meanings |= {symbol: e for e, symbol in generators.items()}
    translator = _Translator(InstructionBuilder(inputs), levels, meanings)
    limits = [substitute_definitions(e, inner) for e in limits]
    values = translator.nan_where_inadmissible(limits, plain, translator.rational_values(rational))
    return min(translator.instructions.build_program(values), structured, key=program_cost)


class _Translator:
    """Expressions in, values of one set of instructions out.

    A builder: `instructions` grows with every value that is asked for, and reciprocals that
    exist already are remembered, so that each division is made once.
    """

    def __init__(
        self,
        instructions: InstructionBuilder,
        levels: Mapping[Symbol, DependenceLevel],
        definitions: Mapping[Symbol, Expression],
    ) -> None:
        self.instructions = instructions
        self._inverses: dict[int, SignedValue] = {}
        self._level_of_symbol = dict(levels)
        self._definitions = definitions
        for symbol, meaning in definitions.items():
            self._level_of_symbol[symbol] = self.highest_level(meaning)

    def highest_level(self, expression: Expression) -> DependenceLevel:
        """The highest level of any symbol in `expression`."""
        levels = (self._level_of_symbol[s] for s in expression.free_symbols)
        return max(levels, default=DependenceLevel.PARAMETER)

    def _state_dependent_symbols(self, expression: Expression) -> list[Symbol]:
        """Symbols in `expression` that vary with the state, in a definite order."""
        symbols = [
            s for s in expression.free_symbols if self._level_of_symbol[s] == DependenceLevel.STATE
        ]
        return sorted(symbols, key=list(self._level_of_symbol).index)

    def nan_where_inadmissible(
        self,
        admissibility_conditions: Sequence[Expression],
        expressions: Sequence[Expression],
        values: Sequence[SignedValue],
    ) -> list[SignedValue]:
        """Values of expressions, NaN where not all of `admissibility_conditions` is positive.

        The root of a negative number is NaN, and so is its difference from itself.
        """
        roots = [
            self.instructions.apply_function("sqrt", self.value_as_written(e))
            for e in admissibility_conditions
        ]
        if not roots:
            return list(values)
        zero_or_nan = self._sum(self.instructions.add(r, (-r[0], r[1])) for r in roots)
        return [
            value if e.is_Symbol else self.instructions.add(value, zero_or_nan)
            for e, value in zip(expressions, values, strict=True)
        ]

    # As it is structured --------------------------------------------------------------

    def values_with_shared_divisions(self, expressions: Sequence[Expression]) -> list[SignedValue]:
        """Values as they are written, with one division for all that are divided by.

        Of n values the reciprocals cost one division and 3 (n - 1) multiplications; those
        that depend on reciprocals themselves come after these.
        """
        ranks: dict[int, list[Expression]] = {}
        for expression in expressions:
            self._division_depth(expression, ranks)
        for rank in sorted(ranks):
            values = dict.fromkeys(self.value_as_written(base) for base in ranks[rank])
            self._invert_together([(1, value) for _, value in values])
        return [self.value_as_written(e) for e in expressions]

    def _division_depth(self, expression: Expression, ranks: dict[int, list[Expression]]) -> int:
        """How many divisions by the state in a row it takes; divisors go into `ranks`."""
        if self.highest_level(expression) < DependenceLevel.STATE or expression.is_Atom:
            meaning = self._definitions.get(expression)
            return 0 if meaning is None else self._division_depth(meaning, ranks)
        rank = max(self._division_depth(argument, ranks) for argument in expression.args)
        if not _is_reciprocal(expression) or not expression.exp.is_Integer:
            return rank
        base = expression.base
        if base not in ranks.setdefault(rank, []):
            ranks[rank].append(base)
        return rank + 1

    def _invert_together(self, values: Sequence[SignedValue]) -> None:
        """Reciprocals of several values by one division."""
        mul = self.instructions.mul
        products = list(accumulate(values, mul))
        inverse = self.instructions.div(self.instructions.constant(1.0), products[-1])
        for value, before in zip(values[:0:-1], products[-2::-1], strict=True):
            self._inverses[value[1]] = mul(inverse, before)
            inverse = mul(inverse, value)
        self._inverses[values[0][1]] = inverse

    # Rational functions of the state --------------------------------------------------

    def rational_values(self, expressions: Sequence[Expression]) -> list[SignedValue]:
        """Values of rational functions, with one division by the state for all of them."""
        normal = [self._as_quotient(e) for e in expressions]
        divided = [item for item in normal if item is not None and item.denominator_powers]
        shared = self._product_of_powers(least_common_multiple(divided))
        if len(divided) > 1:
            shared = self.instructions.div(self.instructions.constant(1.0), shared)
        return [
            self.value_as_written(e)
            if item is None
            else self._quotient_value(item, shared, least_common_multiple(divided), len(divided))
            for e, item in zip(expressions, normal, strict=True)
        ]

    def _as_quotient(self, expression: Expression) -> Quotient | None:
        dynamic = self._state_dependent_symbols(expression)
        return as_quotient(expression, frozenset(dynamic)) if dynamic else None

    def _quotient_value(
        self, item: Quotient, shared: SignedValue, multiple: Mapping[Expression, int], users: int
    ) -> SignedValue:
        if not item.denominator_powers:
            return self.polynomial_value(sp.expand(item.numerator / item.static_denominator))
        numerator = self.polynomial_value(item.numerator)
        static = self.value_as_written(item.static_denominator)
        if users == 1:
            return self.instructions.div(numerator, self.instructions.mul(static, shared))
        missing = {base: k - item.denominator_powers.get(base, 0) for base, k in multiple.items()}
        scale = self.instructions.div(self.instructions.constant(1.0), static)
        extended = self.instructions.mul(numerator, self._product_of_powers(missing))
        return self.instructions.mul(self.instructions.mul(scale, extended), shared)

    def _product_of_powers(self, powers: Mapping[Expression, int]) -> SignedValue:
        values = [
            self.instructions.power(self.polynomial_value(base), k)
            for base, k in powers.items()
            if k
        ]
        return reduce(self.instructions.mul, values, self.instructions.constant(1.0))

    def polynomial_value(self, expression: Expression) -> SignedValue:
        """A polynomial in the state by nested multiplication."""
        symbols = self._state_dependent_symbols(expression)
        if not symbols:
            return self.value_as_written(expression)
        terms = sp.Poly(expression, *symbols).as_dict()
        values = [self.value_as_written(symbol) for symbol in symbols]
        return self._horner_value(
            values, {m: self.value_as_written(terms[m]) for m in sorted(terms)}
        )

    def _horner_value(
        self, values: Sequence[SignedValue], terms: Mapping[MonomialExponents, SignedValue]
    ) -> SignedValue:
        """x^k (inner) + rest, for the x that most terms have, and so on inside."""
        shared = [sum(m[i] > 0 for m in terms) for i in range(len(values))]
        x = shared.index(max(shared))
        if shared[x] < 2:
            return self._sum(self._monomial_value(values, m, c) for m, c in terms.items())
        k = min(m[x] for m in terms if m[x] > 0)
        inner = {(*m[:x], m[x] - k, *m[x + 1 :]): c for m, c in terms.items() if m[x] > 0}
        rest = {m: c for m, c in terms.items() if m[x] == 0}
        power = self.instructions.power(values[x], k)
        value = self.instructions.mul(power, self._horner_value(values, inner))
        return self.instructions.add(value, self._horner_value(values, rest)) if rest else value

    def _monomial_value(
        self, values: Sequence[SignedValue], exponents: MonomialExponents, c: SignedValue
    ) -> SignedValue:
        powers = [
            self.instructions.power(x, k) for x, k in zip(values, exponents, strict=True) if k
        ]
        return self.instructions.mul(c, reduce(self.instructions.mul, powers)) if powers else c

    def _sum(self, values: Iterable[SignedValue]) -> SignedValue:
        return reduce(self.instructions.add, values)

    # Anything else, as it is written --------------------------------------------------

    def value_as_written(self, expression: Expression) -> SignedValue:
        """Value of an expression, term by term; parts of lower level are combined first."""
        if expression.is_Symbol:
            return self._symbol_value(expression)
        if expression.is_Number:
            return self._number_value(expression)
        if expression.is_Add:
            return self._sum(
                self._join_by_level(_simplest_first(expression.args), self.instructions.add)
            )
        if expression.is_Mul:
            return self._product_value(expression)
        if expression.is_Pow:
            return self._power_value(expression)
        return self._function_value(expression)

    def _function_value(self, expression: Expression) -> SignedValue:
        if expression is sp.pi:  # as 4 atan(1), which any kind of numbers can do
            quarter = self.instructions.apply_function("atan", self.instructions.constant(1.0))
            return self.instructions.mul(self.instructions.constant(4.0), quarter)
        if expression is sp.E:  # as exp(1), for the same reason
            return self.instructions.apply_function("exp", self.instructions.constant(1.0))
        inside = expression.args[-1]
        if isinstance(expression, Unexpanded):
            return self.value_as_written(inside)
        if expression.func is sp.log and inside.as_coeff_Add()[0] == 1:
            return self._log_near_one(inside - 1)
        return self.instructions.apply_function(
            _INSTRUCTION_OF_FUNCTION[expression.func], self.value_as_written(inside)
        )

    def _log_near_one(self, excess: Expression) -> SignedValue:
        """log(1 + y) = log(u) + (y - (u - 1))/u with u = 1 + y in floating point.

        The second term is what rounding takes from u: to first order, all of it.
        """
        unity, y = self.instructions.constant(1.0), self.value_as_written(excess)
        u = self.instructions.add(unity, y)
        rounded_y = self.instructions.add(u, (-1, unity[1]))
        rounding = self.instructions.add(y, (-rounded_y[0], rounded_y[1]))
        correction = self.instructions.div(rounding, u)
        return self.instructions.add(self.instructions.apply_function("log", u), correction)

    def _symbol_value(self, symbol: Symbol) -> SignedValue:
        if symbol in self._definitions:
            return self.value_as_written(self._definitions[symbol])
        return self.instructions.input(symbol.name)

    def _number_value(self, number: Expression) -> SignedValue:
        if not number.is_Rational or max(abs(number.p), number.q) > _LARGEST_PART_OF_QUOTIENT:
            return self.instructions.constant(_nearest_float(number))
        numerator = self.instructions.constant(float(number.p))
        return self.instructions.div(numerator, self.instructions.constant(float(number.q)))

    def _join_by_level(self, expressions: Iterable[Expression], join: Any) -> list[SignedValue]:
        """Values joined within each level, lowest level first."""
        groups: dict[DependenceLevel, list[SignedValue]] = {}
        for e in expressions:
            groups.setdefault(self.highest_level(e), []).append(self.value_as_written(e))
        return [reduce(join, groups[level]) for level in sorted(groups)]

    def _product_value(self, product: Expression) -> SignedValue:
        """A product; negative powers are divided by, at most once on each level."""
        factors = list(self._factors_of_product(product))
        levels = sorted({self.highest_level(f) for f in factors})
        return reduce(
            self.instructions.mul,
            (
                self._product_of_factors([f for f in factors if self.highest_level(f) == level])
                for level in levels
            ),
        )

    def _factors_of_product(self, product: Expression) -> Iterator[Expression]:
        """Factors of a product, also of products that stand for symbols in it.

        Only what changes within a run is looked into: its constant factors then join
        those of the product, and can be multiplied in advance.
        """
        for factor in product.as_ordered_factors():
            meaning = self._definitions.get(factor)
            if (
                meaning is not None
                and meaning.is_Mul
                and self.highest_level(factor) == DependenceLevel.DRIVE
            ):
                yield from self._factors_of_product(meaning)
            else:
                yield factor

    def _product_of_factors(self, factors: Sequence[Expression]) -> SignedValue:
        """A product of one level; reciprocals of state variables are shared by all terms."""
        below = [1 / f for f in factors if _is_reciprocal(f)]
        above = [self.value_as_written(f) for f in factors if not _is_reciprocal(f)]
        unity = self.instructions.constant(1.0)
        top = reduce(self.instructions.mul, above, unity)
        if below and self.highest_level(factors[0]) == DependenceLevel.STATE:
            return reduce(self.instructions.mul, map(self._reciprocal_value, below), top)
        bottom = reduce(self.instructions.mul, map(self.value_as_written, below), unity)
        return self.instructions.div(top, bottom)

    def _reciprocal_value(self, expression: Expression) -> SignedValue:
        """1/expression as a power of 1/base, so that all powers share the division."""
        base, exponent = expression.as_base_exp()
        if not exponent.is_Integer:
            base, exponent = expression, 1
        value = self.value_as_written(base)
        inverse = self._inverses.get(value[1])
        if inverse is None:
            inverse = self.instructions.div(self.instructions.constant(1.0), (1, value[1]))
        return self.instructions.power((value[0] * inverse[0], inverse[1]), int(exponent))

    def _power_value(self, power: Expression) -> SignedValue:
        base, exponent = power.base, power.exp
        if _is_reciprocal(power):
            return self._product_of_factors([power])
        if exponent.is_Integer:
            return self.instructions.power(self.value_as_written(base), int(exponent))
        if (2 * exponent).is_Integer:
            root = self.instructions.apply_function("sqrt", self.value_as_written(base))
            return self.instructions.power(root, int(2 * exponent))
        return self.value_as_written(sp.exp(exponent * sp.log(base), evaluate=False))


def _simplest_first(terms: Iterable[Expression]) -> list[Expression]:
    """Terms with few symbols first, so that (1 - f) + f x is computed as that."""
    return sorted(terms, key=lambda e: (len(e.free_symbols), sp.default_sort_key(e)))


def _nearest_float(number: Expression) -> float:
    """A number as a float, infinite where it is larger than floats can be."""
    try:
        return float(number)
    except OverflowError:
        return float("inf") if number.is_positive else float("-inf")


def _is_reciprocal(factor: Expression) -> bool:
    return bool(factor.is_Pow and factor.exp.could_extract_minus_sign())
