"""What a chart of regimes refuses."""

from __future__ import annotations

import pytest

import remanent as rm

DRIVE = rm.SineSquared(0.4, 1.25)
DAMPED = rm.Actuator(dissipation=rm.Rayleigh(0.2))


def test_bad_arguments_say_what_to_do() -> None:
    """Bad input: the message names the argument that was passed."""
    with pytest.raises(rm.InputError, match="two axes"):
        rm.regime_chart(DAMPED, DRIVE, {"omega": [1.0, 2.0]}, periods=200)
