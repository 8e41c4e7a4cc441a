"""The array that kernels work on."""

from __future__ import annotations

import numpy as np

from remanent.integrate.kernel.layout import SlotLayout
from remanent.integrate.kernel.memory import LaneMemory


def test_lanes_without_a_trajectory_repeat_the_last_one() -> None:
    """Of three trajectories in lanes of four, the fourth is a copy of the third.

    Law: what no trajectory needs is computed on numbers that one of them has, so that it can
    neither fail nor take longer.
    """
    states = np.array([[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]])
    memory = LaneMemory.with_values(
        SlotLayout(state_count=2, parameter_count=1),
        4,
        {"parameter": np.array([[0.1], [0.2], [0.3]]), "fine": states},
        {"tolerance": np.array([7.0, 8.0, 9.0])},
    )
    assert memory.slots.shape[::2] == (1, 4)
    np.testing.assert_array_equal(memory.slots[:, :, 3], memory.slots[:, :, 2])
    np.testing.assert_array_equal(memory.state_vectors("fine"), states)
    np.testing.assert_array_equal(memory.column("tolerance"), [7.0, 8.0, 9.0])
    np.testing.assert_array_equal(memory.parameters(), [[0.1, 0.2, 0.3]])

    memory.set_column("tolerance", np.array([1.0, 2.0, 3.0]))
    np.testing.assert_array_equal(memory.slots[:, :, 3], memory.slots[:, :, 2])
    np.testing.assert_array_equal(memory.column("tolerance"), [1.0, 2.0, 3.0])
