"""The formulas of the Adams method: published coefficients, and their order.

Law: Order of the methods.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest

from remanent.integrate.methods.adams import adams_method
from tests.unit.integrate.observed_order import WITHIN, order


def test_coefficients_of_adams_are_the_published_ones() -> None:
    """The Adams-Bashforth formula of order 8 and the next term of its series.

    Law: Order of the methods.
    """
    numerators = [434241, -1152169, 2183877, -2664477, 2102243, -1041723, 295767, -36799]
    published = [float(Fraction(n, 120960)) for n in numerators]
    np.testing.assert_allclose(adams_method(8).single_integral_weights, published, rtol=1e-15)
    assert adams_method(8).single_integral_correction == float(Fraction(1070017, 3628800))


def test_the_next_terms_are_integrals_of_newtons_polynomial() -> None:
    """The integral of s (s + 1) ... (s + 7)/8! over a step, and its double integral.

    Law: Order of the methods.
    """

    def newton(s: Any) -> Any:
        return mpmath.rf(s, 8) / mpmath.factorial(8)

    single = mpmath.quad(newton, [0, 1])
    double = mpmath.quad(lambda s: (1 - s) * newton(s), [0, 1])
    assert adams_method(8).single_integral_correction == pytest.approx(float(single), rel=1e-14)
    assert adams_method(8).double_integral_correction == pytest.approx(float(double), rel=1e-14)


def test_the_error_is_that_of_the_moulton_formula() -> None:
    """With the new rate the next weights are those of Adams and Moulton: -1/12, -1/24, -19/720.

    The integrals of (s - 1) s (s + 1) ... (s + 7)/9! and of the next polynomial over a step.

    Law: Order of the methods.
    """
    method = adams_method(8)
    for k, count in enumerate((9, 10)):

        def newton(s: Any, count: int = count) -> Any:
            return mpmath.rf(s - 1, count) / mpmath.factorial(count)

        single = mpmath.quad(newton, [0, 1])
        double = mpmath.quad(lambda s, newton=newton: (1 - s) * newton(s), [0, 1])
        assert method.single_integral_errors[k] == pytest.approx(float(single), rel=1e-13)
        assert method.double_integral_errors[k] == pytest.approx(float(double), rel=1e-13)
    assert adams_method(1).single_integral_errors[0] == pytest.approx(-1 / 12, rel=1e-15)
    assert adams_method(2).single_integral_errors[0] == pytest.approx(-1 / 24, rel=1e-15)
    assert adams_method(3).single_integral_errors[0] == pytest.approx(-19 / 720, rel=1e-15)


def adams_march(steps: int) -> Any:
    """Error of the limit cycle after 2 units of time, in fifty digits, from exact past rates.

    The formulas of the kernel are written out once more; its rounded weights are quotients
    of integers below 10**8, which are found again.
    """
    method, number = adams_method(8), mpmath.mpf

    def exact(weights: Any) -> list[Any]:
        parts = [Fraction(w).limit_denominator(10**8) for w in weights]
        return [number(p.numerator) / p.denominator for p in parts]

    single, double, difference = map(
        exact,
        (
            method.single_integral_weights,
            method.double_integral_weights,
            method.backward_difference_weights,
        ),
    )
    correction = exact([method.double_integral_correction, method.single_integral_correction])
    h = number(2) / steps
    q, v = mpmath.cos(7 * h), -mpmath.sin(7 * h)
    past = [-mpmath.cos(j * h) for j in range(7, -1, -1)]
    for _ in range(steps - 7):
        guess = q + h * (v + h * mpmath.fdot(double, past)), v + h * mpmath.fdot(single, past)
        surprise = acceleration(*guess) + mpmath.fdot(difference, past)
        q, v = guess[0] + h * h * surprise * correction[0], guess[1] + h * surprise * correction[1]
        past = [acceleration(q, v), *past[:-1]]
    return max(abs(q - mpmath.cos(2)), abs(v + mpmath.sin(2)))


def acceleration(q: Any, v: Any) -> Any:
    """Of the limit cycle."""
    return -q + (1 - q * q - v * v) * v / 2


def test_order_of_adams_in_fifty_digits() -> None:
    """Order of the methods: the formulas of the kernel are of order 9, with exact weights."""
    levels = [100, 200, 400]
    with mpmath.workdps(50):
        errors = [adams_march(n) for n in levels]
    assert max(errors) < 1e-12
    assert order(levels, errors) == pytest.approx(9.0, abs=WITHIN)
