"""Points on branches: which lie on one, and what is known between those that were sampled."""

from __future__ import annotations

import numpy as np
import pytest

from remanent.studies.orbits._branch_points import _between_samples
from remanent.studies.orbits._curve_ends import curve_contains
from tests.unit.analysis.orbits.test_continuation import plane, traced


@pytest.mark.parametrize(("off", "is_on"), [(0.0, True), (1e-5, True), (2e-3, False)])
def test_a_circle_contains_the_points_at_its_radius(off: float, is_on: bool) -> None:
    """Law: of the circle of radius 1 are all points at this distance, and no others.

    The chords between the points of the curve lie further inside than what is told apart here.
    """
    curve = traced(plane("circle"), [1.0, 0.0], [[-2, 2], [-2, 2]])
    angles = np.linspace(0.0, 2.0 * np.pi, 97)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    for point in (1.0 + off) * circle:
        assert curve_contains(curve, point, np.ones(2)) == is_on


def test_between_samples_the_larger_one_counts_and_beside_the_first_the_first() -> None:
    """Invariant: what bounds a slope is that of a neighbour, the larger of two."""
    slopes, sampled = np.array([1.0, 3.0, 2.0]), np.array([0, 4, 8])
    between = _between_samples(slopes, sampled, 10)
    assert between[0] < between[1]
    np.testing.assert_allclose(between / between[0], [1, 3, 3, 3, 3, 3, 3, 3, 3, 3])
    np.testing.assert_array_equal(_between_samples(slopes, np.arange(3), 3), slopes)
