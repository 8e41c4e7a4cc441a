"""Branches, their special points and curves of them, against Newton's method on heyoka's map."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from benchmarks.errors.period_map import PeriodMap
from benchmarks.errors.rows import branches as rows
from benchmarks.errors.special_points import at, special_point

BODY = rm.Actuator(prestress=2.1, dissipation=rm.Rayleigh(0.1))
DRIVE = rm.Sine(0.25, 0.714, mean=2.2)
MAP = PeriodMap(
    DRIVE,
    {
        "c": 1.0, "temperature": 293.0, "prestress": 2.1, "dissipation.0.eta": 0.1, "m": 0.25,
        "omega": 0.714, "mean": 2.2,
    },
)  # fmt: skip


def last_doubling(branch: xr.Dataset) -> int:
    return int(np.flatnonzero(branch.special_kind.values == "period doubling")[-1])


@pytest.fixture(scope="module")
def cascade() -> list[xr.Dataset]:
    """A branch, and those of periods 2, 4 and 8 that start one from the other."""
    found = [rm.continue_orbit(BODY, DRIVE, "m", (0.05, 0.5), initial=(1.722, -0.1157))]
    for _ in range(3):
        found.append(rm.switch_branch(found[-1], last_doubling(found[-1])))
    return found


def test_special_points_of_a_cascade_are_right_to_their_errors(cascade: list[xr.Dataset]) -> None:
    """Independent engines: folds and doublings of periods 1 to 8, state and parameter."""
    judged = 0
    for branch in cascade:
        for k in range(branch.sizes["special"]):
            one = branch.isel(special=k)
            place = [float(one[f"special_{n}"]) for n in ("stretch", "stretch_rate", "m")]
            exact = special_point(
                MAP, str(one.special_kind.values), "m", place, int(one.special_orbit_period)
            )
            assert exact is not None
            off = np.abs(np.array(place) - exact)
            assert off[2] <= float(one.special_error) < 1e-9
            assert off[:2].max() <= float(one.special_state_error) < 1e-6
            judged += 1
    assert judged == 13


def test_a_doubled_branch_starts_at_its_doubling(cascade: list[xr.Dataset]) -> None:
    """It is there neither a fold nor a branch point, and is passed once.

    Published numbers: the doublings to period 8 and 16, to the digits of another calculation.
    """
    for n, (before, branch) in enumerate(itertools.pairwise(cascade), start=1):
        assert branch.attrs["orbit_period"] == 2**n
        assert branch.end_reason.values[0] == "period doubling"
        start = before.isel(special=last_doubling(before))
        near = np.abs(branch.special_m - start.special_m) < 1e-5
        assert branch.special_kind.values[near].tolist() == ["period doubling"]
        assert branch.special_orbit_period.values[near].tolist() == [2 ** (n - 1)]
        assert float(branch.m[0]) == pytest.approx(float(start.special_m), abs=1e-10)
        side = np.sign(np.diff(branch.m.values[:20]))
        assert (side == side[0]).all()
    doublings = [float(one.special_m[last_doubling(one)]) for one in cascade]
    assert doublings[1] == pytest.approx(0.2835229084, abs=5e-11)
    assert doublings[2] == pytest.approx(0.294169028999, abs=2e-12)


@pytest.mark.slow
def test_the_cascade_goes_on(cascade: list[xr.Dataset]) -> None:
    """From period 8 to 16 to 32: distances of doublings shrink by about Feigenbaum's 4.669."""
    found = list(cascade)
    for _ in range(2):
        found.append(rm.switch_branch(found[-1], last_doubling(found[-1])))
    assert found[-1].attrs["orbit_period"] == 32
    doublings = np.array([float(one.special_m[last_doubling(one)]) for one in found])
    ratios = np.diff(doublings)[:-1] / np.diff(doublings)[1:]
    assert abs(ratios[-1] - 4.669) < 0.1


def test_the_way_back_leads_to_the_first_branch(cascade: list[xr.Dataset]) -> None:
    """Where a doubled branch starts, the other branch is that of half its period."""
    back = rm.switch_branch(cascade[1], 0)
    assert back.attrs["orbit_period"] == 1
    assert back.special_m.values == pytest.approx(cascade[0].special_m.values, abs=1e-9)


def test_a_branch_lies_over_the_section_of_its_orbits(cascade: list[xr.Dataset]) -> None:
    """Along ``period`` are the thickness stretches that a section has, all phases of each orbit."""
    one = cascade[2].isel(point=30)
    initial = (float(one.stretch), float(one.stretch_rate))
    section = rm.poincare_section(BODY, DRIVE.replace(m=float(one.m)), periods=3, initial=initial)
    assert one.thickness_stretch.shape == (4,)
    np.testing.assert_allclose(one.thickness_stretch, section.thickness_stretch[:4], atol=1e-6)


def test_points_of_branches_are_right_to_their_errors() -> None:
    """Coverage of errors: states, multipliers and extremes of random branches, near folds too."""
    judged = [one for seed in range(4) for one in rows._points(np.random.default_rng([7, seed]))]
    states = [one.reported for what, one in judged if what == "state"]
    assert len(states) > 20
    assert all(one.covered for _, one in judged)
    assert max(states) < 0.1


def test_errors_near_a_fold_are_those_of_the_state_there() -> None:
    """At the frequency as it is, beside a fold too, where they grow: not the map's alone."""
    body = rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.02))
    branch = rm.continue_orbit(
        body, rm.SineSquared(0.4, 1.4), "omega", (1.0, 1.5), initial=(1.0, 0.0)
    )
    values = {
        "c": 1.0, "temperature": 350.0, "prestress": 0.0, "dissipation.0.eta": 0.02, "b": 0.4
    }  # fmt: skip
    folds = branch.special_omega.values[branch.special_kind.values == "fold"]
    distance = np.abs(branch.omega.values[:, None] - folds).min(axis=1)
    distance[distance < 1e-6] = np.inf  # Newton's method is slow at the fold itself
    judged = 0
    for k in np.argsort(distance)[:12]:
        one = branch.isel(point=int(k))
        motion = PeriodMap(rm.SineSquared(0.4, 1.0), values | {"omega": float(one.omega)})
        state = np.array([float(one.stretch), float(one.stretch_rate)])
        exact = motion.orbit(state, 1)
        if exact is not None:
            off = float(np.abs(state - exact.state).max())
            assert off <= float(one.error) < 1e-5
            judged += 1
    assert judged >= 3
    assert float(branch.residual.max()) <= 1e-9


def test_curves_of_doublings_are_right_to_their_errors() -> None:
    """Independent engines: both fields, each at the other one as it is, and the state."""
    body, drive = rm.Actuator(dissipation=rm.Rayleigh(0.01)), rm.SineSquared(0.8, 2.3013739)
    curve = rm.continue_bifurcation(
        body, drive, "period doubling", ("omega", "b"), [(2.1, 2.6), (0.5, 1.0)],
        initial=rm.periodic_orbits(body, drive).initial.values[0],
    )  # fmt: skip
    assert int(curve.status) == rm.Status.OK
    assert curve.end_bound.values.tolist() == ["b", "b"]
    values = {"c": 1.0, "temperature": 293.0, "prestress": 0.0, "dissipation.0.eta": 0.01}
    motion = PeriodMap(drive, values)
    for k in np.linspace(0, curve.sizes["point"] - 1, 6).astype(int):
        one = curve.isel(point=int(k))
        x, v, omega, b = (float(one[n]) for n in ("stretch", "stretch_rate", "omega", "b"))
        for fixed, value, free, guess in (("b", b, "omega", omega), ("omega", omega, "b", b)):
            exact = special_point(
                at(motion, fixed, value), "period doubling", free, [x, v, guess], 1
            )
            assert exact is not None
            off = np.abs(exact - [x, v, guess])
            assert off[2] <= float(one[f"{free}_error"]) < 1e-4
            assert off[:2].max() <= float(one.error)
    assert float(curve.residual.max()) <= 1e-8


def test_a_curve_that_leaves_the_box_says_so() -> None:
    """Incomplete, with the reason, unless that box was asked for."""
    arguments = (
        rm.Actuator(temperature=350), rm.SineSquared(0.4, 1.2668), "fold", ("omega", "b"),
        [(0.3, 1.45), (0.2, 2.0)],
    )  # fmt: skip
    curve = rm.continue_bifurcation(*arguments, initial=(1.2268, 0.0))
    assert int(curve.status) == rm.Status.INCOMPLETE
    (bound,) = set(curve.end_bound.values) - {"b"}
    assert f"{bound} has its bound" in str(curve.reason.values)
    asked = rm.continue_bifurcation(
        *arguments, initial=(1.2268, 0.0),
        state_box={"stretch": (0.3, 4.0), "stretch_rate": (-8.0, 8.0)},
    )  # fmt: skip
    assert int(asked.status) == rm.Status.OK
    assert str(asked.reason.values) == ""


@pytest.mark.slow
def test_an_isola_is_one_branch_whatever_the_phase() -> None:
    """Its arm that came home is the whole curve; its folds are those of another calculation."""
    diagram = rm.response_diagram(
        rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.002)), rm.SineSquared(0.8, 1.2),
        (1.8, 4.5), orbit_period=3, slices=25,
    )  # fmt: skip
    assert diagram.sizes["branch"] == 2
    assert ["closed", "closed"] in diagram.end_reason.values.tolist()
    exact = np.array([2.981730502923, 3.833403816561])
    folds, error = diagram.special_omega.values, diagram.special_error.values
    for one in exact:
        k = int(np.abs(folds - one).argmin())
        assert abs(folds[k] - one) <= error[k] + 1e-12 < 1e-9


def test_a_curve_of_doublings_goes_on_where_motions_part_fast(cascade: list[xr.Dataset]) -> None:
    """Independent engine, where the Jacobian is in the thousands and varies over 1e-4.

    The curve goes on to the ends of the range, and its points are right to their errors.
    """
    branch = cascade[0].isel(special=last_doubling(cascade[0]))
    curve = rm.continue_bifurcation(
        BODY, replace(DRIVE, m=float(branch.special_m)), "period doubling", ("m", "omega"),
        [(0.05, 0.4), (0.37, 0.8)],
        initial=(float(branch.special_stretch), float(branch.special_stretch_rate)),
    )  # fmt: skip
    assert int(curve.status) == rm.Status.OK
    ends = curve.isel(point=[0, -1])
    assert float(ends.omega.min()) == pytest.approx(0.37, abs=1e-3)
    one = ends.isel(point=int(ends.omega.values.argmin()))
    x, v, omega, m = (float(one[n]) for n in ("stretch", "stretch_rate", "omega", "m"))
    exact = special_point(at(MAP, "omega", omega), "period doubling", "m", [x, v, m], 1)
    assert exact is not None
    off = np.abs(exact - [x, v, m])
    assert off[2] <= float(one.m_error) < 1e-4
    assert off[:2].max() <= float(one.error)
