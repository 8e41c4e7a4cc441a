"""Shared checks: what passes comes back as it should be used, what does not is named."""

from __future__ import annotations

import pickle
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import xarray as xr

from remanent._checks import as_float_array, require_field_names, require_increasing
from remanent._errors import InputError


def gate(value: Any, *, ndim: int | None = None, least: int = 0, finite: bool = False) -> Any:
    return as_float_array(
        "x",
        value,
        what="numbers of a test",
        why="It is tested.",
        fix="Pass 1.",
        ndim=ndim,
        least=least,
        finite=finite,
    )


@pytest.mark.parametrize(
    "value",
    [
        [1, 2],
        (1.0, 2.0),
        np.array([1, 2], dtype=np.int8),
        np.array([1.0, 2.0], dtype=np.float32),
        [True, 2],
        xr.DataArray([1.0, 2.0], dims="case"),
    ],
)
def test_real_numbers_pass_the_gate(value: Any) -> None:
    """Whatever holds them, they come out as an array of floats of its own."""
    array = gate(value)
    np.testing.assert_array_equal(array, [1.0, 2.0])
    assert array.dtype == np.float64
    assert not np.shares_memory(array, np.asarray(value))


@pytest.mark.parametrize(
    "value",
    [
        "1",
        ["1", "2"],
        [None, 1.0],
        [1j],
        [[1.0], [1.0, 2.0]],
        {1.0},
        {"x": 1.0},
        [Fraction(1, 2)],
        [10**400],
        np.array(["2020-01-01"], "datetime64[D]"),
        np.array([5], "timedelta64[s]"),
        np.array([(1.0,)], dtype=[("a", float)]),
    ],
)
def test_what_numpy_would_turn_into_numbers_in_silence_is_refused(value: Any) -> None:
    """Text, dates, None and objects, though ``float64`` arrays could be made of them."""
    with pytest.raises(InputError, match=r"^`x` must be real numbers \(numbers of a test\); got"):
        gate(value)


def test_the_gate_says_what_form_it_wants() -> None:
    """Dimensions, least number and finiteness are part of the rule."""
    message = r"a sequence of finite numbers \(numbers of a test\), at least two; got"
    for value in ([1.0], [[1.0, 2.0]], [1.0, np.nan], 1.0):
        with pytest.raises(InputError, match=message):
            gate(value, ndim=1, least=2, finite=True)


def test_increasing_numbers_increase() -> None:
    """Repeated or falling entries are told apart from what is no number."""
    np.testing.assert_array_equal(
        require_increasing("t", (0, 1, 2), what="instants", why="It is tested."), [0.0, 1.0, 2.0]
    )
    for values in ([0.0, 0.0], [1.0, 0.0]):
        with pytest.raises(InputError, match="`t` must increase"):
            require_increasing("t", values, what="instants", why="It is tested.")


def test_names_may_stand_alone_or_together() -> None:
    """One name, several, or the keys of a mapping; none at all is refused."""
    known = ["c", "temperature"]
    assert require_field_names("parameters", "c", known, "the system") == ["c"]
    assert require_field_names("parameters", {"c": 1.0}, known, "the system") == ["c"]
    for value in ("x", [], ["c", "x"], 1, None, [1]):
        with pytest.raises(InputError, match=r"`parameters` must name fields of the system"):
            require_field_names("parameters", value, known, "the system")


def test_an_input_error_survives_the_way_to_another_process() -> None:
    """Workers of a pool hand their errors over as bytes."""
    error = InputError("c", must="be positive", got=-1.0, why="It is a size.", fix="Pass 1.")
    again = pickle.loads(pickle.dumps(error))  # noqa: S301 - of this test's own making
    assert str(again) == str(error)
    assert (again.name, again.must, again.why, again.fix) == ("c", *MESSAGE_PARTS)


MESSAGE_PARTS = ("be positive", "It is a size.", "Pass 1.")
