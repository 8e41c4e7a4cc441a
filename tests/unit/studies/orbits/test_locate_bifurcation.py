"""Bifurcations over a grid are those of the branches."""

from __future__ import annotations

import pytest

import remanent as rm

HOT = rm.Actuator(temperature=350.0)
FOLD = rm.SineSquared(0.4, 1.2668)
START = (1.2268, 0.0)


def test_special_points_over_a_grid_are_those_of_branches() -> None:
    """Moved from one temperature to others, each is the fold of its own branch."""
    over = {"temperature": [345.0, 355.0]}
    ds = rm.locate_bifurcation(HOT, FOLD, "fold", "omega", initial=START, over=over)
    branch = rm.continue_orbit(
        HOT.replace(temperature=355.0), FOLD, "omega", (1.0, 1.6), initial=START
    )
    fold = branch.special_omega[branch.special_kind == "fold"]
    assert float(ds.omega[1]) == pytest.approx(float(fold[0]), abs=1e-8)
    assert (ds.omega_error < 1e-8).all()
