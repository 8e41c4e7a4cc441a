"""A result depends on its arguments alone: not on its companions, nor on earlier calls."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.analysis.orbits.maps import MapImage
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.orbits._period_map import StroboscopicMap
from tests.repetitions import fast_and_slow

HOT, DRIVE = rm.Actuator(temperature=350), rm.SineSquared(0.4, 1.25)
DAMPED = rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.05))
LOADS = [0.398, 0.4, 0.402]
#: Starts that need from few to very many steps, and some that run off.
STATES = np.column_stack([np.geomspace(0.35, 3.8, 45), np.resize(np.linspace(-7.0, 7.0, 13), 45)])
OMEGA = np.resize(np.linspace(0.7, 1.5, 7), 45)[:, None]


def fresh_map() -> StroboscopicMap:
    return StroboscopicMap(lay_out_ensemble(HOT, DRIVE), ("omega",), 1e-10)


def assert_same_image(one: MapImage, many: MapImage, rows: slice) -> None:
    for name, values in vars(one).items():
        if values is None:  # of one period only
            assert getattr(many, name) is None
            continue
        np.testing.assert_array_equal(values, getattr(many, name)[rows], err_msg=name)


@pytest.mark.slow
@pytest.mark.parametrize("iterate", [1, 3])
def test_the_image_of_a_point_is_its_own(iterate: int) -> None:
    """Alone, among others in any order, and after other calls: the same bits."""
    together = fresh_map()(STATES, OMEGA, iterate)
    backwards = fresh_map()(STATES[::-1], OMEGA[::-1], iterate)
    used = fresh_map()
    for k in np.random.default_rng(1).permutation(len(STATES)):
        row = slice(k, k + 1)
        alone = fresh_map()(STATES[row], OMEGA[row], iterate)
        assert_same_image(alone, together, row)
        assert_same_image(alone, backwards, slice(len(STATES) - 1 - k, len(STATES) - k))
        assert_same_image(used(STATES[row], OMEGA[row], iterate), together, row)


def test_points_differ_in_the_resolution_they_need() -> None:
    """The test above would say nothing if all points began alike."""
    map_ = fresh_map()
    map_(STATES, OMEGA, 1)
    assert len(set(map_._pilot_resolution.resolution_of_cell.values())) > 5


def same(one: xr.Dataset, other: xr.Dataset) -> None:
    """Equal bits up to padding, which `other` may have more of."""
    for name, variable in one.variables.items():
        rows = {dim: slice(size) for dim, size in variable.sizes.items()}
        np.testing.assert_array_equal(variable, other[name].isel(rows), err_msg=str(name))


VERBS: dict[str, Any] = {
    "periodic_orbits": lambda over: rm.periodic_orbits(HOT, DRIVE, over=over),
    "continue_orbit": lambda over: rm.continue_orbit(
        DAMPED, DRIVE, "omega", (1.2, 1.3), over=over
    ),
    "response_diagram": lambda over: rm.response_diagram(DAMPED, DRIVE, (1.2, 1.3), over=over,
                                                         slices=3),
    "locate_bifurcation": lambda over: rm.locate_bifurcation(
        HOT, rm.SineSquared(0.4, 1.2668), "fold", "omega", initial=(1.2268, 0.0), over=over
    ),
    "continue_bifurcation": lambda over: rm.continue_bifurcation(
        HOT, rm.SineSquared(0.4, 1.2668), "fold", ("omega", "temperature"),
        [(1.2, 1.35), (340.0, 360.0)], initial=(1.2268, 0.0), over=over,
    ),
    "manifold_crossing": lambda over: rm.manifold_crossing(
        HOT, DRIVE, "omega", (1.25, 1.26), over=over, width=1e-3
    ),
    "resonances": lambda over: rm.resonances(
        rm.Actuator(dissipation=rm.Rayleigh(0.1)), DRIVE, (1.1, 1.4), over=over, slices=2
    ),
}  # fmt: skip


@pytest.mark.parametrize("verb", fast_and_slow(VERBS, ("continue_orbit", "manifold_crossing")))
def test_a_member_alone_is_the_same_member_among_others(verb: Any) -> None:
    """Each value of `over` alone, after all of them together: the same bits."""
    together = verb({"b": LOADS})
    for k, value in enumerate(LOADS):
        same(verb({"b": [value]}).isel(b=0), together.isel(b=k))


@pytest.mark.parametrize("verb", VERBS.values(), ids=VERBS.keys())
def test_without_over_a_result_is_that_of_its_one_member(verb: Any) -> None:
    """`over` with the drive's own value adds a dimension, and changes no more than an error."""
    single, member = verb(None), verb({"b": [0.4]}).isel(b=0)
    assert set(single.variables) == set(member.variables) - {"b"}
    assert single.sizes == member.sizes
    for name, variable in single.data_vars.items():
        if variable.dtype.kind in "USb":
            np.testing.assert_array_equal(variable, member[name])
        elif name not in ("error", "residual", "multipliers_error"):
            np.testing.assert_allclose(variable, member[name], rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("verb", VERBS.values(), ids=VERBS.keys())
def test_a_member_that_breaks_a_rule_is_invalid_and_spoils_no_other(verb: Any) -> None:
    """Status 4 and no numbers, also where no member is valid."""
    ds = verb({"c": [-1.0, 1.0]})
    assert ds.status.values.tolist()[0] == rm.Status.INVALID
    assert ds.status.values.tolist()[1] == rm.Status.OK
    nothing = verb({"c": [-1.0]})
    assert nothing.status.values.tolist() == [rm.Status.INVALID]
    for variable in nothing.data_vars.values():
        if variable.dtype.kind in "fc":
            assert np.isnan(variable.values).all()


def test_a_varied_field_cannot_be_the_parameter() -> None:
    """A verb that follows a parameter refuses to vary the same one by `over`."""
    for verb in ("continue_orbit", "response_diagram", "locate_bifurcation", "manifold_crossing"):
        with pytest.raises(rm.InputError, match=r"^`over` must not name omega"):
            VERBS[verb]({"omega": [1.25]})


def test_ends_say_why_they_end() -> None:
    """At the range of the parameter, at the box of states, after the number of points."""
    ranged = rm.continue_orbit(DAMPED, DRIVE, "omega", (1.2, 1.3))
    assert ranged.end_reason.values.tolist() == ["bounds", "bounds"]
    assert ranged.end.values.tolist() == ["first", "last"]
    assert ranged.status == rm.Status.OK
    cut = rm.continue_orbit(DAMPED, DRIVE, "omega", (1.0, 1.6), max_points=20)
    assert cut.end_reason.values.tolist() == ["max_points", "max_points"]
    assert cut.status == rm.Status.INCOMPLETE


def test_members_without_an_orbit_say_so() -> None:
    """Where a state is given that leads nowhere for one member, the other is still there."""
    ds = rm.manifold_crossing(
        HOT, DRIVE, "omega", (1.25, 1.26), saddle=(1.433, 0.0), over={"b": [0.1, 0.4]}, width=1e-3
    )
    assert ds.status.values.tolist() == [rm.Status.INCOMPLETE, rm.Status.OK]
    assert "saddle" in str(ds.reason.values[0])
    assert np.isnan(ds.omega[0])
    assert 1.25 < float(ds.omega[1]) < 1.26


def test_progress_is_told() -> None:
    """Each member that is done adds its share, and the last share is 1."""
    told: list[float] = []
    rm.continue_orbit(DAMPED, DRIVE, "omega", (1.24, 1.26), over={"b": LOADS}, progress=told.append)
    assert sorted(told) == pytest.approx([1 / 3, 2 / 3, 1.0])
