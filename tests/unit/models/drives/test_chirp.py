"""A chirp sweeps its frequency, and refuses what is no sweep."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from remanent._errors import InputError
from remanent.models.drives.chirp import Chirp

TAU = np.linspace(0.0, 6.0, 61)


def test_chirp_sweeps_the_frequency() -> None:
    """Its angle has the slope start at 0, stop at the end of the sweep and after it."""
    drive = Chirp(1.0, 0.5, 2.0, 4.0)
    swept = 0.5 * TAU + 1.5 * TAU**2 / 8.0
    held = 0.5 * 4.0 + 1.5 * 2.0 + 2.0 * (TAU - 4.0)
    np.testing.assert_allclose(drive(TAU), np.sin(np.where(TAU < 4.0, swept, held)), atol=1e-15)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Chirp(0.1, -1.0, 1.0, 1.0), "`start` must be a finite number, at least 0"),
        (lambda: Chirp(0.1, 1.0, 1.0, 0.0), "`duration` must be a finite number greater than 0"),
    ],
)
def test_sweeps_are_checked(make: Any, message: str) -> None:
    """A negative first frequency and a sweep of no length are refused by name."""
    with pytest.raises(InputError, match=message):
        make()
