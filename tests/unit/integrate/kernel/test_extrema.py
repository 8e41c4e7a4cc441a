"""The polynomial between steps, on which extremes are sought.

Law: Order of the methods.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest

from remanent._typing import FloatArray
from remanent.integrate.kernel.extrema import (
    TimeDerivatives,
    horner,
    three_node_hermite_coefficients,
)
from tests.unit.integrate.observed_order import WITHIN, order


def hermite_error(function: Callable[[Any], Any], centre: float, h: Any) -> Any:
    """Largest error between the nodes of the polynomial through three instants."""
    left, middle, right = [
        TimeDerivatives(function(t), mpmath.diff(function, t), mpmath.diff(function, t, 2))
        for t in (centre - h, mpmath.mpf(centre), centre + h)
    ]
    polynomial = three_node_hermite_coefficients(left, middle, right, h)
    places = [mpmath.mpf(s) for s in (-0.71, -0.3, 0.52, 0.9)]
    return max(abs(horner(polynomial, s) - function(centre + s * h)) for s in places)


def test_order_of_the_polynomial_between_steps() -> None:
    """Order of the methods: extremes between steps err by O(h**9), in fifty digits."""
    with mpmath.workdps(50):
        steps = [mpmath.mpf(2) ** -k for k in range(3, 8)]
        errors = [hermite_error(lambda t: mpmath.exp(mpmath.sin(t)), 0.4, h) for h in steps]
    assert order([1 / float(h) for h in steps], errors) == pytest.approx(9.0, abs=WITHIN)


def test_the_polynomial_is_exact_for_its_degree() -> None:
    """Every power up to 8 is reproduced, so the error begins with the ninth.

    Law: Order of the methods.
    """
    h = 0.5
    for power in range(10):
        left, middle, right = [
            TimeDerivatives(
                s**power,
                power * s ** max(power - 1, 0),
                power * (power - 1) * s ** max(power - 2, 0),
            )
            for s in (-h, 0.0, h)
        ]
        found: FloatArray = np.array(three_node_hermite_coefficients(left, middle, right, h))
        exact = np.zeros(9)
        if power < 9:
            exact[power] = h**power
            np.testing.assert_allclose(found, exact, rtol=0, atol=1e-13)
        else:
            assert np.abs(found).max() > 1e-4
