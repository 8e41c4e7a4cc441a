"""What a search for orbits missed is said by every result that rests on it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.plots.missing import incomplete_note
from remanent.studies.orbits import (
    _grid_search,
    _search,
    _tracing,
    continue_orbit,
    manifold_crossing,
)
from remanent.studies.orbits._branch_ends import CurveEnds, _what_stopped

HOT, DRIVE = rm.Actuator(temperature=350), rm.SineSquared(0.4, 1.25)
WHY = "a part of the box is dark"
#: Verbs that look for orbits, with few points.
VERBS: dict[str, Callable[[], xr.Dataset]] = {
    "response_diagram": lambda: rm.response_diagram(
        rm.Actuator(dissipation=rm.Rayleigh(0.3)), DRIVE, (1.2, 1.3), slices=2
    ),
    "resonances": lambda: rm.resonances(
        rm.Actuator(dissipation=rm.Rayleigh(0.3)), DRIVE, (1.2, 1.3), slices=2
    ),
    "continue_orbit": lambda: rm.continue_orbit(HOT, DRIVE, "b", (0.399, 0.401)),
    "manifold_crossing": lambda: rm.manifold_crossing(
        HOT, DRIVE, "omega", (1.25, 1.26), width=1e-3
    ),
}


@pytest.mark.parametrize("verb", VERBS)
def test_the_reason_reaches_the_result_and_its_figure(
    verb: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Complete with a complete search; incomplete, and why, with one that is not."""
    complete = VERBS[verb]()
    assert int(complete.status) == rm.Status.OK
    assert not str(complete.reason.values)
    assert not incomplete_note(complete)

    def search(*arguments: Any) -> list[Any]:
        return [replace(one, reason=WHY) for one in _search.search_orbits(*arguments)]

    for module in (_tracing, continue_orbit, manifold_crossing):
        monkeypatch.setattr(module, "search_orbits", search)
    ds = VERBS[verb]()
    assert int(ds.status) == rm.Status.INCOMPLETE
    assert WHY in str(ds.reason.values)
    assert WHY in incomplete_note(ds)


def test_a_start_that_was_given_needs_no_search() -> None:
    """Nothing can be missed by a search that was not made."""
    ds = rm.continue_orbit(HOT, rm.SineSquared(0.0, 1.25), "b", (0.0, 0.02), initial=(1.0, 0.0))
    assert int(ds.status) == rm.Status.OK


def test_a_family_of_orbits_at_the_start_is_said() -> None:
    """Without load every free motion of the right period is an orbit: which one is nearest?"""
    ds = rm.continue_orbit(HOT, rm.SineSquared(0.0, 1.25), "b", (0.0, 0.02))
    assert int(ds.status) == rm.Status.INCOMPLETE
    assert "families" in str(ds.reason.values)


def test_a_grid_of_guesses_is_no_certificate(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two stretches without dissipation nothing shows the list to be complete."""
    monkeypatch.setattr(_grid_search, "_DENSE_GUESS_COUNTS", {4: (2, 1, 2, 1)})
    ds = rm.periodic_orbits(rm.Actuator(prestress=(0.1, 0.1)), DRIVE)
    assert int(ds.status) == rm.Status.INCOMPLETE
    assert "nothing damps the motion" in str(ds.reason.values)


@pytest.mark.parametrize(
    ("count", "names"), [(1, ["the curve"] * 2), (2, ["branch 0", "branch 1"])]
)
def test_a_branch_is_numbered_where_there_are_several(count: int, names: list[str]) -> None:
    """Each end that stopped early has its clause: of the only curve, or of one by its number."""
    ends = {1: [["lost", "max_points"]], 2: [["lost", "closed"], ["bounds", "max_points"]]}
    reasons = np.array(ends[count])
    bounds = np.full(reasons.shape, "")
    found = _what_stopped(CurveEnds(reasons, bounds), ())
    assert len(found) == 2
    assert found[0].startswith(f"{names[0]} at its first point was lost")
    assert found[1].startswith(f"{names[1]} at its last point has as many points as max_points")


def test_damping_too_weak_to_bound_the_orbits_is_said() -> None:
    """Within its error the energy does not fall over a period: orbits may be outside the box."""
    body = rm.Actuator(dissipation=rm.Rayleigh(1e-9))
    box = {"stretch": (0.8, 1.25), "stretch_rate": (-1.0, 1.0)}
    ds = rm.periodic_orbits(body, rm.SineSquared(0.4, 30.0), state_box=box)
    assert int(ds.orbits) == 1
    assert int(ds.status) == rm.Status.INCOMPLETE
    assert str(ds.reason.values) == "no bound of the energy of its orbits was found"
