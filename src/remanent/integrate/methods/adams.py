"""Predictor-corrector steps that learn from the past: Adams, and Falkner for coordinates.

A Runge-Kutta step of order 8 spends eleven evaluations; these spend two, the second
without a division.  For a variable whose rate is itself a state variable (a stretch
and its rate) the double integral of the acceleration is used, which has a smaller
error and needs no history of its own.  Coefficients are integrals of Lagrange
polynomials, computed exactly.

References
----------
E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, III.1
(Adams) and III.10 (Falkner's and other methods for second-order equations).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from math import comb
from typing import Any

from remanent._field import Field

_PolynomialCoefficients = tuple[Fraction, ...]
#: Error of the second solution over the one reported: so large that rounding does not hide it,
#: so small that it obeys linear equations.
_ERROR_AMPLIFICATION = 32.0
#: Error reported over the one that is followed.
_SAFETY_FACTOR = 1.9


@dataclass(frozen=True)
class AdamsMethod:
    """A predictor with `past_rate_count` past rates, and a corrector with one more.

    Attributes
    ----------
    past_rate_count
        Past rates used.  The order of the global error is one more.
    single_integral_weights, double_integral_weights
        Weights of the past rates, newest first: of the rate in an increment of its
        integral, and of the acceleration in an increment of the double integral, for a
        step of length 1.
    backward_difference_weights
        Weights, newest first after the predicted rate (whose weight is 1), in the
        backward difference of order `past_rate_count`.
    single_integral_correction, double_integral_correction
        What that difference adds to either increment.
    single_integral_errors, double_integral_errors
        What either corrected increment lacks of the exact one: the weights of the backward
        differences of the next two orders.
    """

    past_rate_count: int
    single_integral_weights: tuple[float, ...]
    double_integral_weights: tuple[float, ...]
    backward_difference_weights: tuple[float, ...]
    single_integral_correction: float
    double_integral_correction: float
    single_integral_errors: tuple[float, float]
    double_integral_errors: tuple[float, float]

    def __post_init__(self) -> None:
        for power in range(self.past_rate_count):
            past = [float(-j) ** power for j in range(self.past_rate_count)]
            exact = 1.0 / (power + 1), 1.0 / ((power + 1) * (power + 2))
            for weights, integral in zip(
                (self.single_integral_weights, self.double_integral_weights), exact, strict=True
            ):
                terms = [w * x for w, x in zip(weights, past, strict=True)]
                if abs(sum(terms) - integral) > 1e-13 * sum(map(abs, terms)):
                    raise ValueError(f"weights do not integrate the power {power}")

    @property
    def name(self) -> str:
        return f"adams-{self.past_rate_count}"

    @property
    def order(self) -> int:
        """Order of the global error."""
        return self.past_rate_count + 1

    @property
    def evaluations_per_step(self) -> int:
        """Of the rates, in every step: one predicted, one corrected."""
        return 2

    @property
    def error_per_solution_difference(self) -> float:
        """Error that is reported, over the difference of the solution and the one amplified."""
        return 1.0 / _ERROR_AMPLIFICATION

    @property
    def error_amplification(self) -> float:
        """Error of the second solution over that of the first."""
        return _SAFETY_FACTOR * _ERROR_AMPLIFICATION

    @property
    def rate_steps_at_extremes(self) -> float:
        """Steps by which a difference of rates counts in the error of an extremum.

        The error of a value may pass through zero there.
        """
        return 2.0

    @property
    def recent_share_at_extremes(self) -> float:
        """Share of recent differences of two solutions in the error of an extremum.

        The error is followed to a part of what it was shortly before, often a few hundredths, and
        may have become as small as that at the only extremum that there is.
        """
        return 0.25

    @property
    def has_compensated_sum(self) -> bool:
        """Whether what rounding cuts off from the state is carried on.

        It is not: rounding of the past rates costs more digits, and the sums half as much
        time again.
        """
        return False

    @property
    def coarse_solution_lost_bits(self) -> int:
        """Digits that the solution with the amplified error does without.

        Sums of past rates round by more than the state does.  With fewer digits cut off, bounds
        of motions whose rounding grows were below the true errors by up to a factor of 20; with
        these the bound of a calm run of 5000 units of time is 5 to 7 times its error of 1e-12.
        """
        return self.order + 1

    @property
    def load_node_indices(self) -> tuple[int, ...]:
        """Nodes at which the load is needed in every step: the end."""
        return (1,)

    @property
    def nodes(self) -> tuple[float, float]:
        """Where in a step the load is needed: its ends."""
        return 0.0, 1.0


@cache
def adams_method(steps: int) -> AdamsMethod:
    """The method with `steps` past rates."""
    lagrange = [_lagrange_polynomial(j, steps) for j in range(steps)]
    newton = _polynomial_product([(Fraction(i, i + 1), Fraction(1, i + 1)) for i in range(steps)])
    # The next of Newton's polynomials, through the new rate too.
    following, after_that = (
        _polynomial_product([(Fraction(i - 1, i + 1), Fraction(1, i + 1)) for i in range(count)])
        for count in (steps + 1, steps + 2)
    )
    return AdamsMethod(
        past_rate_count=steps,
        single_integral_weights=tuple(float(_integral_over_unit_step(p)) for p in lagrange),
        double_integral_weights=tuple(float(_double_integral_over_unit_step(p)) for p in lagrange),
        backward_difference_weights=tuple(
            float((-1) ** j * comb(steps, j)) for j in range(1, steps + 1)
        ),
        single_integral_correction=float(_integral_over_unit_step(newton)),
        double_integral_correction=float(_double_integral_over_unit_step(newton)),
        single_integral_errors=(
            float(_integral_over_unit_step(following)),
            float(_integral_over_unit_step(after_that)),
        ),
        double_integral_errors=(
            float(_double_integral_over_unit_step(following)),
            float(_double_integral_over_unit_step(after_that)),
        ),
    )


def rate_variable_indices(field: Field) -> tuple[int | None, ...]:
    """For every coordinate the index of the variable that is its rate; else None.

    Only rates that are not coordinates themselves count, so that every partner has a
    history of its own.
    """
    rate_of = [
        slot - 1 if 1 <= slot <= len(field.state_names) else None
        for slot in field.rates.output_slots
    ]
    return tuple(None if j is None or rate_of[j] is not None else j for j in rate_of)


def _lagrange_polynomial(j: int, count: int) -> _PolynomialCoefficients:
    """The polynomial in s that is 1 at s = -j and 0 at the other -i, i < count."""
    distances = [i for i in range(count) if i != j]
    return _polynomial_product([(Fraction(i, i - j), Fraction(1, i - j)) for i in distances])


def _polynomial_product(factors: Sequence[Sequence[Fraction]]) -> _PolynomialCoefficients:
    result = [Fraction(1)]
    for constant, slope in factors:
        shifted = [Fraction(0), *(slope * c for c in result)]
        scaled = [*(constant * c for c in result), Fraction(0)]
        result = [a + b for a, b in zip(scaled, shifted, strict=True)]
    return tuple(result)


def _integral_over_unit_step(p: _PolynomialCoefficients) -> Fraction:
    """Integral over [0, 1]."""
    return sum((c / (k + 1) for k, c in enumerate(p)), Fraction(0))


def _double_integral_over_unit_step(p: _PolynomialCoefficients) -> Fraction:
    """Integral of (1 - s) p(s) over [0, 1]."""
    return sum((c / ((k + 1) * (k + 2)) for k, c in enumerate(p)), Fraction(0))


def weighted_sum_oldest_first(weights: Sequence[float], values: Sequence[Any]) -> Any:
    """Sum of weights times values, oldest (smallest) terms first.

    All but the newest in two halves that do not wait for each other: the newest is what
    everything else waits for.
    """
    terms = list(zip(reversed(weights), reversed(values), strict=True))
    earlier = _weighted_sum(terms[:-1:2]) + _weighted_sum(terms[1:-1:2])
    return earlier + terms[-1][1] * terms[-1][0]


def _weighted_sum(terms: Sequence[tuple[float, Any]]) -> Any:
    w, v = terms[0]
    total = v * w
    for w, v in terms[1:]:
        total = total + v * w
    return total
