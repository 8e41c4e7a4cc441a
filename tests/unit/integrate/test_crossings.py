"""What lies between the crossings of a window of steps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from remanent._typing import IntArray
from remanent.integrate.crossings import (
    NO_CROSSING,
    Crossings,
    merge_within_error,
    with_distances,
)


def listed(rows: IntArray, steps: IntArray, direction: int) -> Crossings:
    """Crossings in some steps of some rows; all else is nothing."""
    nothing = np.zeros(rows.size)
    return Crossings(
        trajectory=rows, time=steps.astype(float), states=np.zeros((rows.size, 1)),
        direction=np.full(rows.size, direction), rate=nothing, curvature=nothing,
        sensitivity=nothing, speed=nothing, largest_before=np.full(rows.size, -1.0), step=steps,
    )  # fmt: skip


def test_distances_are_the_largest_between_one_crossing_and_the_next() -> None:
    """Random windows of four rows, against a loop; the second of two in a step keeps its own."""
    rng = np.random.default_rng(0)
    for _ in range(50):
        distance = rng.uniform(size=(4, 9))
        where = rng.integers(0, 3, (4, 8))  # crossings in each step
        rows, steps = (np.repeat(part, where.ravel()) for part in np.indices((4, 8)).reshape(2, -1))
        ends = listed(np.arange(4), np.full(4, 8), NO_CROSSING)
        joined = with_distances(listed(rows, steps, 1), distance, rows, ends)
        expected = []
        for k, (row, step) in enumerate(zip(rows, steps, strict=True)):
            same_row = k > 0 and rows[k - 1] == row
            first = steps[k - 1] + 1 if same_row else 0
            expected.append(-1.0 if first > step else distance[row, first : step + 1].max())
        for end in range(4):
            expected.append(distance[end, max(steps[rows == end], default=-1) + 1 :].max())
        np.testing.assert_array_equal(joined.largest_before, expected)


@pytest.mark.parametrize(
    ("directions", "expected"),
    [((1, -1, 1), 1), ((1, -1), 0), ((-1, 1, -1), -1), ((-1, 0, 1), 0), ((0, -1), -1), ((0, 0), 0)],
)
def test_passages_within_the_error_are_one(directions: tuple[int, ...], expected: int) -> None:
    """The value is passed if the last passage goes as the first does, and touched otherwise."""
    count = len(directions)
    found = listed(np.zeros(count + 1, dtype=np.int64), np.arange(count + 1), 0)
    nearby = np.full(count + 1, 1e-3)
    nearby[[0, -1]] = 1.0  # the motion comes from afar, and leaves again
    found = replace(
        found,
        direction=np.array([*directions, NO_CROSSING]),
        sensitivity=np.ones(count + 1),
        largest_before=nearby,
    )
    merged = merge_within_error(found, np.array([0.1]))
    assert merged.direction.tolist() == [expected]
    assert merge_within_error(found, np.array([1e-4])).direction.tolist() == list(directions)
