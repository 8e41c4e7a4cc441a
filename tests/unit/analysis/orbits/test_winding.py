"""How often a function winds around zero is the number of its zeros inside, each with its sign."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from remanent._typing import FloatArray, IntArray
from remanent.analysis.orbits.cell_samples import Sample, SampledFunction
from remanent.analysis.orbits.winding import winding_number

#: A square around zero, in order.
SQUARE = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def sampled(roots: np.ndarray, *, conjugate: bool = False) -> SampledFunction:
    """A polynomial of z = x + i y with these roots; or its conjugate, whose zeros count as -1."""
    polynomial = Polynomial.fromroots(roots)

    def sample(points: FloatArray, _: float, __: IntArray | None) -> Sample:
        z = points[:, 0] + 1j * points[:, 1]
        value, slope = polynomial(z), polynomial.deriv()(z)
        derivative = np.stack([slope, 1j * slope], axis=1)
        sign = -1.0 if conjugate else 1.0
        return Sample(
            np.column_stack([value.real, sign * value.imag]),
            np.stack([derivative.real, sign * derivative.imag], axis=1),
            np.full(len(points), 1e-14),
            np.ones(len(points), dtype=np.int64),
        )

    return sample


def winding(of: SampledFunction, corners: FloatArray = SQUARE) -> int | None:
    return winding_number(of, corners, of(corners, 1e-3, None), max_effort=5_000)


@pytest.mark.parametrize("seed", range(40))
def test_it_counts_the_roots_of_polynomials_inside(seed: int) -> None:
    """The argument principle: as often as there are roots inside, less often the other way."""
    rng = np.random.default_rng(seed)
    roots = rng.uniform(-2.0, 2.0, (int(rng.integers(1, 12)), 2))
    inside = int((np.abs(roots) < 1.0).all(axis=1).sum())
    z = roots @ [1.0, 1j]
    assert winding(sampled(z)) == inside
    assert winding(sampled(z, conjugate=True)) == -inside
    assert winding(sampled(z), SQUARE[::-1]) == -inside


def test_nothing_is_said_of_a_zero_on_the_edge() -> None:
    """Where the function vanishes on the polygon the number has no meaning."""
    assert winding(sampled(np.array([1.0 + 0.3j]))) is None


def test_no_turn_between_two_points_is_overlooked() -> None:
    """z^n turns n/4 times along each side, whose ends may have equal values."""
    for degree in range(1, 33):
        assert winding(sampled(np.zeros(degree) * 1j)) == degree


def test_turns_that_both_ends_of_a_side_hide_are_seen() -> None:
    """exp(y + i pi x (1 - y)) vanishes nowhere; it turns twice along the lowest side.

    There it is 1/e at both ends, with a rate along the imaginary axis alone.
    """

    def sample(points: FloatArray, _: float, __: IntArray | None) -> Sample:
        x, y = points.T
        value = np.exp(y + 1j * np.pi * x * (1.0 - y))
        slope = np.stack([1j * np.pi * (1.0 - y) * value, (1.0 - 1j * np.pi * x) * value], axis=1)
        return Sample(
            np.column_stack([value.real, value.imag]),
            np.stack([slope.real, slope.imag], axis=1),
            np.full(len(points), 1e-14),
            np.ones(len(points), dtype=np.int64),
        )

    assert winding(sample) == 0
