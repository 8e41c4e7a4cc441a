"""Zeros, largest values and averages of functions that are known exactly."""

from __future__ import annotations

import numpy as np
import pytest

from remanent._typing import FloatArray, IntArray
from remanent.analysis.regimes.birkhoff import overlapping_digits, weighted_average
from remanent.analysis.response.subdivision import refine_maximum
from remanent.analysis.statics.equilibria import find_zeros, force_slope

GRID = np.linspace(-3.0, 3.0, 101)


def cubic(case: IntArray, x: FloatArray) -> FloatArray:
    """x**3 - case x: one zero for case 0 and -1, three for positive cases."""
    return x**3 - case * x + 0.1


def test_every_sign_change_is_found_for_every_case() -> None:
    """Zeros of x**3 - k x + 0.1, ascending, NaN after the last."""
    found = find_zeros(cubic, 3, GRID)
    for k in range(3):
        roots = np.roots([1.0, 0.0, -k, 0.1])
        exact = np.sort(roots[abs(roots.imag) < 1e-12].real)
        np.testing.assert_allclose(found[k, : exact.size], exact, rtol=0, atol=1e-13)
        assert np.isnan(found[k, exact.size :]).all()


def test_a_zero_on_the_grid_is_found_once() -> None:
    """x - 1 vanishes exactly at a point of the grid."""
    found = find_zeros(lambda case, x: x - 1.0 + 0.0 * case, 1, np.array([0.0, 1.0, 2.0]))
    assert found.tolist() == [[1.0]]


def test_no_zero_no_column() -> None:
    """A force that never vanishes."""
    assert find_zeros(lambda case, x: x**2 + 1.0 + case, 2, GRID).shape == (2, 0)


def test_slope_by_a_complex_step_is_exact() -> None:
    """3 x**2 - k to round-off."""
    x = np.linspace(-2.0, 2.0, 7)
    case = np.arange(7)
    np.testing.assert_allclose(force_slope(cubic, case, x), 3 * x**2 - case, rtol=0, atol=4e-15)


@pytest.mark.parametrize("width", [1e-3, 1e-9])
def test_largest_of_a_function_that_jumps(width: float) -> None:
    """exp(-|x - a|) for x below a, 0 above: the maximum sits at the jump."""
    jump = np.array([0.3217, 0.7071])

    def measure(case: IntArray, x: FloatArray) -> FloatArray:
        return np.where(x < jump[case], np.exp(x - jump[case]), 0.0)

    x = np.linspace(0.0, 1.0, 11)
    table = np.stack([measure(np.full(11, k), x) for k in range(2)])
    found = refine_maximum(x, table, measure, width=width)
    assert (found.upper - found.lower <= width).all()
    assert (found.lower <= jump).all()
    assert (jump <= found.upper).all()
    np.testing.assert_allclose(found.position, jump, rtol=0, atol=width)


def test_largest_is_never_below_the_table() -> None:
    """What was tabulated is not forgotten, and NaN is never the largest."""
    x = np.linspace(0.0, 1.0, 5)
    table = np.array([[0.1, np.nan, 0.9, np.nan, 0.2], [np.nan] * 5])

    def unknown(case: IntArray, at: FloatArray) -> FloatArray:
        return np.full(np.broadcast(case, at).shape, np.nan)

    found = refine_maximum(x, table, unknown, width=1e-3)
    assert (found.position[0], found.value[0]) == (0.5, 0.9)
    assert np.isnan(found.value[1])


def test_weighted_averages_of_a_rotation_converge_beyond_any_power() -> None:
    """Of cos along a rotation by the golden mean: 0, to 12 digits after 2000 steps."""
    angle = 2.0 * np.pi * 0.5 * (np.sqrt(5.0) - 1.0) * np.arange(4000)
    average = weighted_average(np.cos(angle))
    assert abs(float(average)) < 1e-12
    assert float(overlapping_digits(np.cos(angle))) > 10.0


def test_weighted_averages_along_chaos_converge_slowly() -> None:
    """Of the logistic map at 4: mean 1/2, a few digits only."""
    x = np.empty(4000)
    x[0] = 0.1234
    for k in range(x.size - 1):
        x[k + 1] = 4.0 * x[k] * (1.0 - x[k])
    assert float(weighted_average(x)) == pytest.approx(0.5, abs=0.03)
    assert float(overlapping_digits(x)) < 4.0


def test_a_constant_has_all_digits() -> None:
    """Its spread is zero."""
    assert float(overlapping_digits(np.full(100, 0.3))) == 16.0
