"""Poincaré sections are the same alone and in a sweep."""

from __future__ import annotations

import numpy as np

import remanent as rm


def test_sections_do_not_depend_on_their_neighbours() -> None:
    """A sweep of sections equals its own parts and its mirror image."""
    omega = np.linspace(0.6, 2.2, 24)
    drive = rm.SineSquared(0.9, 1.0)
    body = rm.Actuator(c=0.1, temperature=350.0)
    whole = rm.poincare_section(body, drive, periods=40, over={"omega": omega})
    assert (whole.status == rm.Status.OK).all()
    for part in (slice(0, 5), slice(7, 8), slice(9, 24)):
        some = rm.poincare_section(body, drive, periods=40, over={"omega": omega[part]})
        for name in ("stretch", "stretch_rate", "error", "horizon", "status"):
            np.testing.assert_array_equal(some[name].values, whole[name].values[part])


def test_passages_in_both_directions_are_those_that_rise_and_those_that_fall() -> None:
    """Law: direction 1 takes passages with a growing formula, -1 with a falling one, 0 both."""
    body, start = rm.Actuator(), (1.05, 0.0)
    rising, falling, both = (
        rm.poincare_section(
            body, rm.Constant(0.0), where="stretch - 1", direction=direction,
            duration=9.0, initial=start,
        )
        for direction in (1, -1, 0)
    )  # fmt: skip
    assert (rising.stretch_rate > 0.1).all()
    assert (falling.stretch_rate < -0.1).all()
    together = np.concatenate([rising.crossing_time, falling.crossing_time])
    np.testing.assert_array_equal(both.crossing_time, np.sort(together))
    assert (rising.sizes["crossing"], falling.sizes["crossing"]) == (3, 4)
