"""Which nodes of a response lie outside a band."""

from __future__ import annotations

import numpy as np

from remanent.analysis.control.settling import last_node_outside


def test_the_ends_of_a_band_belong_to_it() -> None:
    """A response that is last outside before it turns at both ends; one within; one that leaves."""
    nodes = np.array([[0.0, 1.5, 0.5, 1.0], [1.0, 1.5, 0.5, np.nan], [1.0, 0.5, 1.0, 2.0]])
    low, high = np.full((3, 1), 0.5), np.full((3, 1), 1.5)
    assert last_node_outside(nodes, low, high)[:, 0].tolist() == [0, -1, 3]
