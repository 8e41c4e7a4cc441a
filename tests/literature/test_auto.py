"""Branches and special points against AUTO-07p, refined in extended precision.

What the reference is and how it was made: tests/literature/auto/README.md.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent._typing import FloatArray
from tests.literature.oscillators import COSINE, OSCILLATOR

HERE = Path(__file__).parent / "auto" / "reference"
KINDS = {"LP": "fold", "PD": "period doubling", "TR": "Neimark-Sacker", "BP": "branch point"}


def reference(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((HERE / f"{name}.json").read_text())
    return found


def actuator(eta: float) -> rm.Actuator:
    return rm.Actuator(temperature=350.0, dissipation=(rm.Rayleigh(eta),) if eta else ())


@pytest.fixture(scope="module", params=["actuator", "actuator_damped"])
def diagram(request: pytest.FixtureRequest) -> tuple[dict[str, Any], xr.Dataset]:
    """The reference and the response diagram of the same actuator."""
    known = reference(request.param) | {"name": request.param}
    drive = rm.SineSquared(known["parameters"]["b"], 1.0)
    return known, rm.response_diagram(actuator(known["parameters"]["eta"]), drive, (0.6, 1.6))


#: How many special points of each kind the references of actuators hold.
MARKS = {"actuator": {"LP": 2, "PD": 2}, "actuator_damped": {"LP": 2, "PD": 0}}


@pytest.mark.parametrize("kind", ["LP", "PD"])
def test_special_points_are_those_of_auto(
    diagram: tuple[dict[str, Any], xr.Dataset], kind: str
) -> None:
    """Folds and doublings to 1e-8, and to the error reported; no other, and none missing.

    AUTO cannot see the doublings of an undamped orbit, 1.3e-5 apart: they come from the map
    over half a period in extended precision.
    """
    known, ds = diagram
    expected = np.sort([mark["omega"] for mark in known["special"] if mark["kind"] == kind])
    assert expected.size == MARKS[known["name"]][kind]
    rows = np.flatnonzero(ds.special_kind.values == KINDS[kind])
    rows = rows[np.argsort(ds.special_omega.values[rows])]
    omega, error = ds.special_omega.values[rows], ds.special_error.values[rows]
    np.testing.assert_allclose(omega, expected, rtol=0.0, atol=1e-8)
    assert (np.abs(omega - expected) <= error + 1e-15).all()


def test_no_special_point_is_of_another_kind(diagram: tuple[dict[str, Any], xr.Dataset]) -> None:
    """Nothing is marked that AUTO's branches do not hold."""
    known, ds = diagram
    assert ds.special.size == len(known["special"]) == sum(MARKS[known["name"]].values())


def distance_to_chain(points: FloatArray, chain: FloatArray) -> FloatArray:
    """Distance of each point from the polygon through the points of a chain."""
    start, chord = chain[:-1], np.diff(chain, axis=0)
    away = points[:, None] - start
    part = np.einsum("pij,ij->pi", away, chord) / np.einsum("ij,ij->i", chord, chord)
    foot = part.clip(0.0, 1.0)[..., None] * chord
    return np.asarray(np.linalg.norm(away - foot, axis=2).min(axis=1))


def test_no_branch_is_missing(diagram: tuple[dict[str, Any], xr.Dataset]) -> None:
    """Every point of AUTO's branches lies on one of ours, up to the sag of chords of 0.02.

    A chord of length h of a curve of curvature k sags by k h²/8: 5e-4 for k = 10.
    """
    known, ds = diagram
    assert len(known["branches"]) == {"actuator": 3, "actuator_damped": 1}[known["name"]]
    assert ds.branch.size == len(known["branches"])
    columns = np.stack([ds.omega, ds.stretch, ds.stretch_rate], axis=-1)
    chains = [rows[np.isfinite(rows).all(axis=1)] for rows in columns]
    for branch in known["branches"]:
        points = np.column_stack([branch["points"][name] for name in ("omega", "x", "v")])
        assert len(points) > 70
        # All of its points lie on the same one of ours.
        assert min(distance_to_chain(points, chain).max() for chain in chains) < 5e-4


def test_multipliers_along_branches(diagram: tuple[dict[str, Any], xr.Dataset]) -> None:
    """Liouville's formula: the product is exp of the integral of the trace, 1 undamped."""
    known, ds = diagram
    product = ds.multipliers.prod("multiplier", skipna=False).values
    product = product[np.isfinite(product)]
    assert np.abs(product.imag).max() < 1e-8
    if known["parameters"]["eta"] == 0.0:
        np.testing.assert_allclose(product, 1.0, rtol=0.0, atol=1e-8)
    else:
        assert ((product.real > 0.0) & (product.real < 1.0)).all()


def test_all_orbits_are_found(diagram: tuple[dict[str, Any], xr.Dataset]) -> None:
    """Complete searches: what a search of 80 x 80 cells found, at five frequencies."""
    known, _ = diagram
    assert len(known["search"]) == 5
    for omega, orbits in known["search"].items():
        body = actuator(known["parameters"]["eta"])
        drive = rm.SineSquared(known["parameters"]["b"], float(omega))
        ds = rm.periodic_orbits(body, drive, state_box={"stretch_rate": (-3.0, 3.0)})
        found = ds.initial.values[np.argsort(ds.initial.values[:, 0])]
        expected = np.array(sorted(orbits))
        assert found.shape == expected.shape
        np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-7)


@pytest.mark.parametrize(("b", "omega", "count"), [(0.3, 1.2, 3), (0.3, 1.32, 1)])
def test_each_orbit_is_counted_once_at_any_tolerance(b: float, omega: float, count: int) -> None:
    """Complete searches: Newton's method stops short of one orbit in different places."""
    for tolerance in (1e-6, 1e-7, 1e-9):
        ds = rm.periodic_orbits(actuator(0.0), rm.SineSquared(b, omega), tolerance=tolerance)
        assert int(ds.orbits) == ds.orbit.size == count


BOX = {"x": (-9.0, 9.0), "x_rate": (-9.0, 9.0)}


def oscillator(
    known: dict[str, Any], free: str, value: float
) -> tuple[rm.LagrangianSystem, rm.Sine]:
    """The oscillator of a reference, and its load, at one value of the free parameter."""
    values = {**known["parameters"], free: value}
    drive = COSINE.replace(omega=values.pop("omega"))
    return OSCILLATOR.replace(parameters=values), drive


@pytest.mark.parametrize(
    ("name", "marked"),
    [
        ("duffing", {"response": 2}),
        ("van_der_pol", {"up": 1, "down": 1}),
        ("double_well", {"period 1": 3, "period 2": 1, "period 4": 1}),
    ],
)
def test_special_points_of_forced_oscillators(name: str, marked: dict[str, int]) -> None:
    """Independent engines: folds, doublings, torus points, to 1e-8 and the reported error."""
    known = reference(name)
    free = known["free"]
    branches = {branch["name"]: branch for branch in known["branches"]}
    assert branches.keys() == marked.keys()
    for label, branch in branches.items():
        marks = [m for m in known["special"] if m.get("branch", label) == label]
        assert len(marks) == marked[label]
        points = {name: np.array(branch["points"][name]) for name in ("x", "v", free)}
        k = len(points["x"]) // 2
        system, drive = oscillator(known, free, points[free][k])
        found = rm.continue_orbit(
            system, drive, free, (points[free].min() - 1e-3, points[free].max() + 1e-3),
            initial=(points["x"][k], points["v"][k]), orbit_period=branch["period"],
            state_box=BOX,
        )  # fmt: skip
        for mark in marks:
            away = np.abs(found[f"special_{free}"] - mark[free])
            near = (found.special_kind == KINDS[mark["kind"]]) & (away < 1e-8)
            assert int(near.sum()) == 1, (label, mark["kind"], mark[free], found)
            assert bool((away <= found.special_error + 1e-15)[near].all())


def test_doublings_lead_to_the_next_branch() -> None:
    """AUTO's branches of period 2 and 4 of the double well, each from the doubling before it."""
    known = reference("double_well")
    branches = {one["period"]: one["points"] for one in known["branches"]}
    marks = [one for one in known["special"] if one["kind"] == "PD"]
    assert len(marks) == 3
    first = marks[0]
    system, drive = oscillator(known, "F", first["F"] - 1e-4)
    branch = rm.continue_orbit(
        system, drive, "F", (0.15, 0.2), initial=(first["x"], first["v"]), state_box=BOX
    )
    for mark, following, period in zip(marks[:2], marks[1:], (2, 4), strict=True):
        k = int(np.abs(branch.special_F.values - mark["F"]).argmin())
        low, high = min(branches[period]["F"]) - 1e-4, max(branches[period]["F"]) + 1e-4
        branch = rm.switch_branch(branch, k, parameter_range=(low, high), state_box=BOX)
        assert branch.attrs["orbit_period"] == period
        scale = np.array([1.0, 1.0, 0.05])
        columns = np.column_stack([branches[period][name] for name in ("x", "v", "F")]) / scale
        assert len(columns) > 20
        # All of its points lie on the same phase of ours, up to the sag of chords of 0.02.
        starts = {"initial.x": branch.x, "initial.x_rate": branch.x_rate, "F": branch.F}
        over = {name: xr.DataArray(one.values, dims="place") for name, one in starts.items()}
        section = rm.poincare_section(system, drive, periods=period, over=over)
        chains = [
            np.column_stack([here.x, here.x_rate, branch.F]) / scale
            for here in (section.isel(period=n) for n in range(period))
        ]
        away = [distance_to_chain(columns, chain).max() for chain in chains]
        assert min(away) < 2e-4
        assert float(np.abs(branch.special_F - following["F"]).min()) < 1e-8


def test_a_doubled_branch_is_that_of_a_direct_search() -> None:
    """At a frequency inside the tongue the search without a guess finds the same orbit."""
    body, drive = rm.Actuator(dissipation=rm.Rayleigh(0.01)), rm.SineSquared(0.8, 2.4)
    forced = rm.continue_orbit(body, drive, "omega", (2.31, 2.45))
    doubled = rm.switch_branch(forced)
    assert doubled.attrs["orbit_period"] == 2
    k = int(np.abs(doubled.omega.values - 2.32).argmin())
    found = rm.periodic_orbits(body, drive.replace(omega=float(doubled.omega[k])), orbit_period=2)
    own = np.array([float(doubled.stretch[k]), float(doubled.stretch_rate[k])])
    section = rm.poincare_section(
        body, drive.replace(omega=float(doubled.omega[k])), periods=1, initial=own
    )
    phases = np.column_stack([section.stretch.values, section.stretch_rate.values])
    stable = found.initial.values[found.stability.values == "stable"]
    assert stable.shape == (1, 2)
    assert np.abs(phases - stable).max(axis=1).min() < 1e-6


def test_a_fold_is_no_place_to_switch() -> None:
    """A branch with a fold and no period doubling has no other branch to switch to."""
    body, drive = rm.Actuator(temperature=350), rm.SineSquared(0.4, 1.25)
    branch = rm.continue_orbit(body, drive, "omega", (1.2, 1.3), initial=(1.433, 0.0))
    with pytest.raises(rm.InputError, match="period doubling"):
        rm.switch_branch(branch)
