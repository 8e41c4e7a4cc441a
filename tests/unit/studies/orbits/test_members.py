"""Members of an ensemble one by one: padding, and what fails."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.orbits._members import map_members_in_threads, stack_padded, stack_tables

DRIVE = rm.SineSquared(0.4, 1.25)


def test_padding_keeps_kinds_and_leaves_no_number() -> None:
    """NaN after the last number, -1 after the last index, nothing after the last word."""
    numbers = stack_padded([np.ones((2, 2)), np.ones((1, 2))], np.empty((0, 2)))
    assert np.isnan(numbers).sum() == 2
    assert np.isnan(numbers[1, 1]).all()
    assert stack_padded([np.array([3, 4]), np.array([5])], np.empty(0, int)).tolist() == [
        [3, 4],
        [5, -1],
    ]
    assert stack_padded([np.array(["a"]), np.empty(0, "<U3")], np.empty(0, "<U3")).tolist() == [
        ["a"],
        [""],
    ]
    assert stack_padded([], np.empty((0, 2), complex)).shape == (0, 0, 2)


def test_a_missing_table_is_all_padding() -> None:
    """A member without a table has NaN in its place, and the others keep theirs."""
    stacked = stack_tables([None, {"x": np.array([1.0])}], {"x": np.empty(0)})
    np.testing.assert_array_equal(stacked["x"], [[np.nan], [1.0]])


def test_a_single_member_says_why_it_failed_and_many_do_not() -> None:
    """An InputError is for who asked for one thing; among others it is a missing result."""

    def fail(_member: object) -> None:
        raise rm.InputError("x", must="be", got=0, why="It is not.", fix="Pass 1.")

    with pytest.raises(rm.InputError):
        map_members_in_threads(lay_out_ensemble(rm.Actuator(), DRIVE), fail)
    assert map_members_in_threads(
        lay_out_ensemble(rm.Actuator(), DRIVE, {"b": [0.1, 0.2]}), fail
    ) == [
        None,
        None,
    ]
