"""Zeros of forces that are known exactly."""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.analysis.statics.equilibria import balancing_parameter, find_force_zeros, force_slope

GRID = np.linspace(-3.0, 3.0, 101)


def cubic(case: IntArray, x: FloatArray) -> FloatArray:
    """x**3 - case x: one zero for case 0 and -1, three for positive cases."""
    return x**3 - case * x + 0.1


def test_every_sign_change_is_found_for_every_case() -> None:
    """Zeros of x**3 - k x + 0.1, ascending, NaN after the last."""
    found = find_force_zeros(cubic, 3, GRID)
    for k in range(3):
        roots = np.roots([1.0, 0.0, -k, 0.1])
        exact = np.sort(roots[abs(roots.imag) < 1e-12].real)
        np.testing.assert_allclose(found[k, : exact.size], exact, rtol=0, atol=1e-13)
        assert np.isnan(found[k, exact.size :]).all()


def test_a_zero_on_the_grid_is_found_once() -> None:
    """x - 1 vanishes exactly at a point of the grid."""
    found = find_force_zeros(lambda case, x: x - 1.0 + 0.0 * case, 1, np.array([0.0, 1.0, 2.0]))
    assert found.tolist() == [[1.0]]


def test_each_of_many_cases_has_the_zeros_that_it_has_alone() -> None:
    """A thousand cases, evaluated some at a time, bit for bit; and none at all."""
    scale = np.linspace(0.0, 3.0, 1000)
    together = find_force_zeros(lambda case, x: x**3 - scale[case] * x + 0.1, 1000, GRID)
    for k in (0, 323, 324, 999):

        def alone(case: IntArray, x: FloatArray, k: int = k) -> FloatArray:
            return x**3 - scale[case + k] * x + 0.1

        (zeros,) = find_force_zeros(alone, 1, GRID)
        assert together[k, : zeros.size].tolist() == zeros.tolist()
        assert np.isnan(together[k, zeros.size :]).all()
    assert find_force_zeros(cubic, 0, GRID).shape == (0, 0)


def test_no_zero_no_column() -> None:
    """A force that never vanishes."""
    assert find_force_zeros(lambda case, x: x**2 + 1.0 + case, 2, GRID).shape == (2, 0)


def test_slope_by_a_complex_step_is_exact() -> None:
    """3 x**2 - k to round-off."""
    x = np.linspace(-2.0, 2.0, 7)
    case = np.arange(7)
    np.testing.assert_allclose(force_slope(cubic, case, x), 3 * x**2 - case, rtol=0, atol=4e-15)


def test_the_balancing_load_is_that_of_the_formula() -> None:
    """x**3 - p x vanishes at x for p = x**2; beyond the bounds, and at 0, there is no such p."""

    def force(case: IntArray, x: FloatArray, p: FloatArray) -> FloatArray:
        return x**3 - p * x + 0.0 * case

    x = np.array([0.5, 1.0, 1.9, 2.1, 0.0])
    bounds = np.zeros(1), np.full(1, 4.0)
    found = balancing_parameter(force, bounds, np.zeros(5, dtype=np.int64), x)
    np.testing.assert_allclose(found[:3], x[:3] ** 2, rtol=1e-12)
    assert np.isnan(found[3:]).all()
