"""Constant and sinusoidal loads: their formulas, their periods, and what they refuse."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from remanent._errors import InputError
from remanent.models.drives.sines import Sines
from remanent.models.drives.waves import Constant, Sine, SineSquared

TAU = np.linspace(0.0, 6.0, 61)


def test_loads_have_the_values_of_their_formulas() -> None:
    """Loads are b0, (b sin omega tau)^2 and mean + b sin(omega tau + phase)."""
    np.testing.assert_array_equal(Constant(0.2)(TAU), 0.2)
    np.testing.assert_allclose(SineSquared(0.4, 1.25)(TAU), (0.4 * np.sin(1.25 * TAU)) ** 2)
    np.testing.assert_allclose(Sine(0.4, 1.2, 0.1, 0.3)(TAU), 0.1 + 0.4 * np.sin(1.2 * TAU + 0.3))


def test_periods_are_those_of_the_load() -> None:
    """pi/omega for the square of the sine, 2 pi/omega for the sine."""
    assert SineSquared(0.4, 2.0).period == pytest.approx(np.pi / 2.0)
    assert Sine(0.4, 2.0).period == pytest.approx(np.pi)
    assert Constant(0.1).period is None


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SineSquared(0.4, 0.0), "`omega` must be a finite number greater than 0; got 0.0"),
        (lambda: Sine(0.4, -1.0), "`omega` must be a finite number greater than 0; got -1.0"),
    ],
)
def test_frequencies_are_checked(make: Any, message: str) -> None:
    """A frequency that is not greater than 0 is refused."""
    with pytest.raises(InputError, match=message):
        make()


def test_terms_without_a_load_count_for_the_period_where_theirs_is_varied() -> None:
    """At 1 and 1/2 of omega: the second doubles the period once its load may differ from 0."""
    drive = Sines([0.3, 0.0], [1.0, 0.5], 2.0)
    assert drive.period == pytest.approx(np.pi)
    assert drive.with_varied(["omega"]) is drive
    assert drive.with_varied(["loads.1"]).period == pytest.approx(2.0 * np.pi)
