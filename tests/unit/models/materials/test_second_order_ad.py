"""Dual numbers of the second order differentiate formulas."""

from __future__ import annotations

import numpy as np
import pytest
import sympy as sp

from remanent.models.formula import parse_formula
from remanent.models.materials.second_order_ad import DualFunctions, SecondOrderDual


@pytest.mark.parametrize(
    "text", ["x**3/(1 + x) - 2*x", "exp(-x)*sin(x) + cos(2*x)", "log(x)**2/sqrt(x)", "x**-1.5 + 4"]
)
def test_dual_numbers_carry_two_derivatives(text: str) -> None:
    """Value and two derivatives are those of the symbolic expression."""
    x, at = sp.Symbol("x"), 1.3
    dual = parse_formula(text)({"x": SecondOrderDual(np.float64(at), 1.0, 0.0)}, DualFunctions(np))
    exact = parse_formula(text)({"x": x}, sp)
    for k, value in enumerate((dual.value, dual.first_derivative, dual.second_derivative)):
        assert value == pytest.approx(float(sp.diff(exact, x, k).subs(x, at)), rel=1e-13)


@pytest.mark.parametrize("x", [1.3, 0.0])
@pytest.mark.parametrize("power", [0, 1, 2, 3])
def test_powers_with_whole_exponents_have_derivatives_at_zero_too(x: float, power: int) -> None:
    """n x^(n-1) and n (n-1) x^(n-2), which vanish where a factor before the power does."""
    found = SecondOrderDual(np.float64(x), 1.0, 0.0) ** power
    slope = power * x ** max(power - 1, 0)
    bend = power * (power - 1) * x ** max(power - 2, 0)
    assert (found.first_derivative, found.second_derivative) == pytest.approx((slope, bend))
