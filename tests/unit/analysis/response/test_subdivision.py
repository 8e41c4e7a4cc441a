"""Largest values of functions that jump."""

from __future__ import annotations

import numpy as np
import pytest

from remanent._typing import FloatArray, IntArray
from remanent.analysis.response.subdivision import refine_maxima


@pytest.mark.parametrize("width", [1e-3, 1e-9])
def test_largest_of_a_function_that_jumps(width: float) -> None:
    """exp(-|x - a|) for x below a, 0 above: the maximum sits at the jump."""
    jump = np.array([0.3217, 0.7071])

    def measure(case: IntArray, x: FloatArray) -> FloatArray:
        return np.where(x < jump[case], np.exp(x - jump[case]), 0.0)

    x = np.linspace(0.0, 1.0, 11)
    table = np.stack([measure(np.full(11, k), x) for k in range(2)])
    found = refine_maxima(x, table, measure, width=width)
    assert (found.bracket_upper - found.bracket_lower <= width).all()
    assert (found.bracket_lower <= jump).all()
    assert (jump <= found.bracket_upper).all()
    np.testing.assert_allclose(found.position, jump, rtol=0, atol=width)


def test_largest_is_never_below_the_table() -> None:
    """What was tabulated is not forgotten, and NaN is never the largest."""
    x = np.linspace(0.0, 1.0, 5)
    table = np.array([[0.1, np.nan, 0.9, np.nan, 0.2], [np.nan] * 5])

    def unknown(case: IntArray, at: FloatArray) -> FloatArray:
        return np.full(np.broadcast(case, at).shape, np.nan)

    found = refine_maxima(x, table, unknown, width=1e-3)
    assert (found.position[0], found.value[0]) == (0.5, 0.9)
    assert np.isnan(found.value[1])
