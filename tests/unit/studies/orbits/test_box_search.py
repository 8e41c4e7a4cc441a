"""How often the boxes of systems that users write are searched."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent.analysis.orbits.cells import CellSearchOutcome, zeros_by_cells
from remanent.studies.orbits import _box_search
from remanent.studies.orbits._orbit_search import ConfirmedPoints
from remanent.studies.orbits._planar_search import fixed_points

DAMPED = rm.FirstOrderSystem(rates={"x": "v", "v": "load - x - v/2"}, rest={"x": 0.0})
DRIVE, BOX = rm.Sine(0.3, 1.5), {"x": (-2.0, 2.0), "v": (-2.0, 2.0)}


@pytest.mark.parametrize("is_dropped", [False, True])
def test_a_box_is_searched_again_only_where_the_winding_number_contradicts(
    is_dropped: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Law: a linear oscillator has one orbit, around which P(z) - z winds once; none is not one."""
    finest: list[int] = []

    def search_and_count(displacement: Any, edges: Any, **options: Any) -> CellSearchOutcome:
        finest.append(len(edges[0]))
        return zeros_by_cells(displacement, edges, **options)

    def find_none(*arguments: Any) -> ConfirmedPoints:
        found = fixed_points(*arguments)
        return ConfirmedPoints(found.orbits.subset(np.arange(0)), np.empty(0), found.unconfirmed)

    monkeypatch.setattr(_box_search, "zeros_by_cells", search_and_count)
    if is_dropped:
        monkeypatch.setattr(_box_search, "fixed_points", find_none)
    ds = rm.periodic_orbits(DAMPED, DRIVE, state_box=BOX)
    if is_dropped:
        assert len(finest) == 2
        assert finest[0] < finest[1]
        assert int(ds.status) == rm.Status.INCOMPLETE
        assert "add up to 0, not to 1" in str(ds.reason.values)
    else:
        assert len(finest) == 1
        assert (int(ds.status), int(ds.orbits)) == (rm.Status.OK, 1)
