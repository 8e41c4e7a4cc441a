"""Which nodes of a response lie outside a band."""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.control.settling import last_node_outside, locate_level_crossings


def test_the_ends_of_a_band_belong_to_it() -> None:
    """A response that is last outside before it turns at both ends; one within; one that leaves."""
    nodes = np.array([[0.0, 1.5, 0.5, 1.0], [1.0, 1.5, 0.5, np.nan], [1.0, 0.5, 1.0, 2.0]])
    low, high = np.full((3, 1), 0.5), np.full((3, 1), 1.5)
    assert last_node_outside(nodes, low, high)[:, 0].tolist() == [0, -1, 3]


def test_passages_close_to_a_turning_point_are_as_far_off_as_they_say_at_most() -> None:
    """Law: 1 - (1 - t)^2 = 1 - d^2 at t = 1 - d, where Newton's steps halve the distance to go."""

    def parabola(t: FloatArray) -> tuple[FloatArray, FloatArray]:
        return t * (2.0 - t), 2.0 - 2.0 * t

    distance = 10.0 ** np.linspace(-7.0, -1.0, 601)[None]
    ones, levels = np.ones(distance.shape), (1.0 - distance) * (1.0 + distance)
    found = locate_level_crossings(parabola, 0.0 * ones, ones, levels, ones)
    rounding = 2.0**-50 / distance
    assert (np.abs(found.time - (1.0 - distance)) <= found.miss + rounding).all()
    assert (found.miss < 2e-4).all()
    assert (found.miss[distance > 1e-2] < 1e-9).all()
