"""Every periodic orbit is listed, and nothing that is none; or the search says what stopped it."""

from __future__ import annotations

import numpy as np
import pytest
from benchmarks.orbit_search import Case, compare

import remanent as rm

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
