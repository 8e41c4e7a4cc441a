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
