"""Every periodic orbit is listed, and nothing that is none; or the search says what stopped it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import remanent as rm
from benchmarks.orbit_search import Case, compare
from remanent.analysis.orbits.cell_samples import Sample
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.orbits import _planar_search
from remanent.studies.orbits._orbit_search import ConfirmedPoints
from remanent.studies.orbits._period_map import StroboscopicMap
from remanent.studies.orbits._planar_indices import FirstGrid, winding_around_grid

HOT = rm.Actuator(temperature=350)


def points(ds: object) -> np.ndarray:
    return np.asarray(ds.initial.values)  # type: ignore[attr-defined]


@pytest.mark.parametrize("omega", [0.02, 0.05, 0.08, 1.0])
def test_slow_drives_have_their_one_orbit(omega: float) -> None:
    """Damped motion near rest follows a slow load, once per period: one stable orbit."""
    body = rm.Actuator(dissipation=rm.Rayleigh(0.5))
    ds = rm.periodic_orbits(body, rm.SineSquared(0.4, omega))
    assert (int(ds.status), ds.stability.values.tolist()) == (rm.Status.OK, ["stable"])
    if omega == 0.05:
        assert points(ds)[0] == pytest.approx([1.00002132, 1.1145e-5], abs=5e-9)


def test_the_only_orbit_is_found_wherever_it_is() -> None:
    """A linearly damped block has an orbit of period 1; at phase 0 this one moves fast."""
    body = rm.Actuator(temperature=340, prestress=0.584, dissipation=rm.Rayleigh(0.122))
    ds = rm.periodic_orbits(body, rm.SineSquared(1.623, 0.925))
    assert int(ds.status) == rm.Status.OK
    assert points(ds) == pytest.approx(np.array([[2.9471333, 9.3115395]]), abs=1e-6)


@pytest.mark.parametrize("below", [1e-7, 1e-6, 3e-6])
def test_both_orbits_of_a_pair_below_its_fold(below: float) -> None:
    """Two orbits are born at a fold, and part as the root of the distance from it.

    Their indices are opposite, and those of all orbits of this map add up to 1.
    """
    ds = rm.periodic_orbits(HOT, rm.SineSquared(0.4, 1.2667952918445309 - below))
    assert ds.stability.values.tolist() == ["elliptic", "elliptic", "saddle"]
    apart = points(ds)[2, 0] - points(ds)[1, 0]
    assert apart == pytest.approx(7.453e-4 * np.sqrt(below / 1e-7), rel=0.01)


def test_points_of_a_torus_that_nearly_close_are_no_orbits() -> None:
    """On the line of symmetry just two orbits have period 7; their traces are 2 within 1e-10.

    So near to a parabolic orbit the errors are not known, which the status says.
    """
    ds = rm.periodic_orbits(HOT, rm.SineSquared(0.4, 1.25), orbit_period=7)
    assert int(ds.status) == rm.Status.MAX_STEPS
    assert np.isnan(ds.error).all()
    assert set(ds.stability.values) == {"undecided"}
    assert points(ds)[:, 0] == pytest.approx([0.43204, 3.62774], abs=1e-4)


def test_families_of_free_motion_are_said_to_be_families() -> None:
    """Under a constant load every free motion whose period fits is an orbit: they are no list."""
    ds = rm.periodic_orbits(HOT, rm.SineSquared(0.4, 1.25), over={"b": [0.0, 0.4]})
    assert ds.status.values.tolist() == [rm.Status.INCOMPLETE, rm.Status.OK]
    assert "families" in str(ds.reason.values[0])
    assert ds.orbits.values[1] == 3


def test_combinations_that_break_a_rule_are_invalid() -> None:
    """A status for each combination, even if none is valid."""
    ds = rm.periodic_orbits(HOT, rm.SineSquared(0.4, 1.25), over={"c": [-1.0]})
    assert ds.status.values.tolist() == [rm.Status.INVALID]


@pytest.mark.parametrize("seed", [6])
def test_orbits_are_those_of_brute_force(seed: int) -> None:
    """Newton's method from a dense grid on heyoka's period map finds the same orbits."""
    pytest.importorskip("heyoka")
    found = compare(Case.random(seed))
    assert not found.not_orbits
    assert not found.missed or found.incomplete


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(300, 330))
def test_orbits_are_those_of_brute_force_widely(seed: int) -> None:
    """The same for more actuators, damped and undamped."""
    test_orbits_are_those_of_brute_force(seed)


@pytest.mark.parametrize("dropped", [0, 1, 2])
def test_an_orbit_that_is_dropped_is_noticed(dropped: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Indices of all fixed points add up to how often z - P(z) winds around zero on the edge."""
    find = _planar_search.fixed_points

    def find_all_but_one(*arguments: Any) -> ConfirmedPoints:
        found = find(*arguments)
        kept = np.delete(np.arange(len(found.error)), dropped)
        return ConfirmedPoints(found.orbits.subset(kept), found.error[kept], found.unconfirmed)

    monkeypatch.setattr(_planar_search, "fixed_points", find_all_but_one)
    ds = rm.periodic_orbits(HOT, rm.SineSquared(0.4, 1.25))
    assert ds.orbits == 2
    assert int(ds.status) == rm.Status.INCOMPLETE
    assert "add up to" in str(ds.reason.values)


def test_displacements_of_a_damped_block_wind_once_around_a_large_box() -> None:
    """Its map takes a large disk into itself, as that of any linearly damped block does."""
    body = rm.Actuator(prestress=0.3, dissipation=rm.Rayleigh(0.5))
    ens = lay_out_ensemble(body, rm.SineSquared(0.4, 0.925), None, reserved=frozenset())
    map_ = StroboscopicMap(ens, (), 1e-4)
    grid = FirstGrid([np.geomspace(0.3, 4.0, 13), np.linspace(-8.0, 8.0, 13)], False)

    def displacement(points: Any, _: float, __: Any) -> Sample:
        image = map_.run(points, np.empty((len(points), 0)), 1)
        return Sample(
            image.state - points, image.jacobian - np.eye(2), image.error,
            np.ones(len(points), dtype=np.int64),
        )  # fmt: skip

    unknown = Sample.unknown(144, 2, 2)
    assert winding_around_grid(displacement, grid, unknown, max_effort=2_000) == 1


@pytest.mark.parametrize(
    ("state_box", "count"),
    [({"stretch": (0.3, 4.0)}, 1), ({"stretch": (0.02, 50.0), "stretch_rate": (-99, 99)}, 1)],
)
def test_a_box_that_holds_the_only_orbit_has_it(state_box: dict[str, Any], count: int) -> None:
    """The orbit of damped motion is found in a box that cuts or holds the region of all orbits."""
    body = rm.Actuator(temperature=340, dissipation=rm.Rayleigh(0.122))
    ds = rm.periodic_orbits(body, rm.SineSquared(0.623, 0.925), state_box=state_box)
    assert (int(ds.status), int(ds.orbits)) == (rm.Status.OK, count)


def test_a_steep_fixed_point_is_not_passed_over() -> None:
    """The orbit of period 1 repels fast: P^5 bends strongly between points near it.

    All fixed points of P^5 in the box have indices that add up to 1, so it has to be found.
    """
    body = rm.Actuator(
        c=0.10222824122972375, temperature=267.7472364672859, prestress=0.11886779775589051
    )
    drive = rm.SineSquared(1.4917559981256368, 2.8213266336140093)
    assert rm.periodic_orbits(body, drive).orbits == 1
    ds = rm.periodic_orbits(body, drive, orbit_period=5)
    assert (int(ds.status), int(ds.orbits)) == (rm.Status.OK, 0)


@pytest.mark.parametrize(("seed", "count"), [(20_009, 4), (20_019, 6)])
def test_weak_resonances_leave_orbits_in_pairs(seed: int, count: int) -> None:
    """Of two orbits at a weak resonance, det(1 - DP^n) is opposite to first order in its strength.

    An orbit of the first pair is at rest outside of the box only.
    """
    case = Case.random(seed)
    ds = rm.periodic_orbits(case.actuator, case.drive, orbit_period=case.orbit_period)
    assert int(ds.status) != rm.Status.INCOMPLETE
    assert ds.orbits == count
    index = np.sort((1.0 - ds.multipliers.values).prod(axis=1).real)
    assert index[: count // 2] == pytest.approx(-index[: count // 2 - 1 : -1], rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [10_001, 10_021, 10_031, 10_033, 10_043])
def test_slow_undamped_motion_is_searched_to_the_end(seed: int) -> None:
    """Dozens of resonances lie in the box; no part of it is left unknown.

    The orbits at resonances are so nearly parabolic that some have no error.
    """
    case = Case.random(seed)
    ds = rm.periodic_orbits(case.actuator, case.drive, orbit_period=case.orbit_period)
    assert int(ds.status) != rm.Status.INCOMPLETE
    assert ds.orbits > 0
