"""Crossings of actuators: at extremes, and a period apart."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm


def test_rates_of_the_motion_cross_zero_at_its_extremes() -> None:
    """The largest stretch at a zero of its rate is the maximum of the response."""
    drive = rm.SineSquared(0.4, 1.25)
    extremes = rm.crossings(rm.Actuator(), drive, "thickness_stretch_rate", 0.0, duration=100.0)
    largest = (extremes.stretch**-2).max()
    response = rm.frequency_response(rm.Actuator(), drive, [1.0, 1.25])
    assert float(largest) == pytest.approx(float(response.maximum[1]), abs=1e-9)


def test_periods_between_crossings_are_those_of_the_orbit() -> None:
    """A constant load: successive crossings in one direction are one period apart."""
    ds = rm.crossings(rm.Actuator(c=0.1), rm.Constant(0.5), "thickness_stretch", 1.1,
                      direction="up", duration=60.0, over={"prestress": [-0.2, 0.0]})  # fmt: skip
    for p in range(2):
        times = ds.crossing_time[p].values
        gaps = np.diff(times[np.isfinite(times)])
        assert gaps.size > 5
        assert np.ptp(gaps) < 1e-8
