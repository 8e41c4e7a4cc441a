"""What `over` means: outer products, shared dimensions, dotted names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st

import remanent as rm
from remanent import _threads
from remanent.studies.ensemble.layout import lay_out_ensemble

DRIVE = rm.SineSquared(0.4, 1.25)
TIMES = np.linspace(0.0, 5.0, 11)


def simulated(actuator: rm.Actuator | None = None, **settings: Any) -> xr.Dataset:
    return rm.simulate(actuator or rm.Actuator(), DRIVE, times=TIMES, **settings)


def assert_bits(a: xr.Dataset, b: xr.Dataset) -> None:
    for name in ("stretch", "stretch_rate", "thickness_stretch", "energy", "error", "status"):
        np.testing.assert_array_equal(a[name].values, b[name].values)


def test_values_of_two_fields_make_an_outer_product() -> None:
    """Dimensions in the order given, and every element the single run, bit for bit."""
    temperatures, omegas = [250.0, 350.0, 400.0], [0.7, 1.1]
    ds = simulated(over={"temperature": temperatures, "omega": omegas})
    assert ds.stretch.dims == ("temperature", "omega", "time")
    assert ds.error.dims == ("temperature", "omega")
    assert ds.temperature.values.tolist() == temperatures
    for T in temperatures:
        for w in omegas:
            single = rm.simulate(rm.Actuator(temperature=T), DRIVE.replace(omega=w), times=TIMES)
            assert_bits(ds.sel(temperature=T, omega=w), single)


def test_dataarrays_that_share_a_dimension_go_together() -> None:
    """One with one along `case`, which is the only dimension."""
    omega = xr.DataArray([0.7, 1.1, 0.7], dims="case")
    b = xr.DataArray([0.2, 0.3, 0.4], dims="case")
    ds = simulated(over={"omega": omega, "b": b})
    assert ds.stretch.dims == ("case", "time")
    for k in range(3):
        drive = rm.SineSquared(float(b[k]), float(omega[k]))
        assert_bits(ds.isel(case=k), rm.simulate(rm.Actuator(), drive, times=TIMES))


def test_shared_and_own_dimensions_mix() -> None:
    """A field on two dimensions, a field on one of them, and a third by itself."""
    c = xr.DataArray([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]], dims=("row", "column"))
    b = xr.DataArray([0.1, 0.2, 0.3], dims="column")
    ds = simulated(over={"c": c, "temperature": [280.0, 320.0], "b": b})
    assert ds.error.dims == ("row", "column", "temperature")
    single = rm.simulate(
        rm.Actuator(c=0.6, temperature=280.0), rm.SineSquared(0.3, 1.25), times=TIMES
    )
    assert_bits(ds.isel(row=1, column=2, temperature=0), single)


def test_dimensions_are_matched_by_name_not_by_position() -> None:
    """The same two dimensions in the other order."""
    c = xr.DataArray([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]], dims=("row", "column"))
    b = xr.DataArray([[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]], dims=("column", "row"))
    ds = simulated(over={"c": c, "b": b})
    single = rm.simulate(rm.Actuator(c=0.5), rm.SineSquared(0.4, 1.25), times=TIMES)
    assert_bits(ds.isel(row=1, column=1), single)
    assert_bits(
        ds.isel(row=1, column=0),
        rm.simulate(rm.Actuator(c=0.4), rm.SineSquared(0.2, 1.25), times=TIMES),
    )


def test_dotted_names_reach_into_parts() -> None:
    """`dissipation.0.eta` and `magnet.temperature_coefficient`."""
    body = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    ds = simulated(body, over={"dissipation.0.eta": [0.0, 0.2]})
    for k, eta in enumerate((0.0, 0.2)):
        single = simulated(rm.Actuator(dissipation=rm.Rayleigh(eta)))
        assert_bits(ds.isel({"dissipation.0.eta": k}), single)
    hot = rm.Actuator(temperature=350.0)
    ds = simulated(hot, over={"magnet.temperature_coefficient": [-0.001, 0.0]})
    assert_bits(ds.isel({"magnet.temperature_coefficient": 1}), simulated(hot))


def test_initial_states_can_be_varied() -> None:
    """`initial.stretch` and `initial.stretch_rate` replace what `initial` says."""
    ds = simulated(initial=(1.1, 0.5), over={"initial.stretch": [0.9, 1.0]})
    assert_bits(ds.isel({"initial.stretch": 0}), simulated(initial=(0.9, 0.5)))
    ds = simulated(over={"initial.stretch_rate": [-0.5, 0.5]})
    assert_bits(ds.isel({"initial.stretch_rate": 1}), simulated(initial=(1.0, 0.5)))


def test_a_given_temperature_of_the_body_is_that_at_every_surrounding_temperature() -> None:
    """A whole initial state is that of all trajectories; what it leaves out is at rest."""
    body = rm.Actuator(heat=rm.Heat(2e-4, 0.3))
    over = {"temperature": [293.0, 310.0]}
    whole = lay_out_ensemble(body, DRIVE, over, (1.1, 0.5, 340.0))
    np.testing.assert_array_equal(whole.initial_states, [[1.1, 0.5, 340.0]] * 2)
    part = lay_out_ensemble(body, DRIVE, over, (1.1, 0.5))
    np.testing.assert_array_equal(part.initial_states, [[1.1, 0.5, 293.0], [1.1, 0.5, 310.0]])


def test_a_single_value_keeps_its_dimension() -> None:
    """A number or a list of one is a dimension of length one; no `over`, no dimension."""
    assert simulated(over={"c": 0.5}).error.dims == ("c",)
    assert simulated(over={"c": [0.5]}).error.shape == (1,)
    assert simulated(over={}).error.dims == simulated().error.dims == ()


def test_runs_of_different_length_have_their_own_times() -> None:
    """`periods` with several frequencies: the dimension is `cycle`, `time` a table."""
    ds = rm.simulate(rm.Actuator(), DRIVE, periods=3, over={"omega": [0.7, 1.1]})
    assert ds.stretch.dims == ("omega", "cycle")
    assert ds.time.dims == ("omega", "cycle")
    assert ds.time.values[:, -1] == pytest.approx(3 * np.pi / np.array([0.7, 1.1]), rel=1e-15)


@pytest.mark.parametrize("workers", [1, 2])
def test_bits_do_not_depend_on_the_processors(
    workers: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One processor or two: the same bits, through the public verb (law: Determinism)."""
    over = {"omega": np.linspace(0.6, 2.0, 30), "temperature": [250.0, 400.0]}
    reference = simulated(over=over)
    monkeypatch.setattr(_threads, "available_processor_count", lambda: workers)
    assert_bits(simulated(over=over), reference)


def test_invalid_points_leave_the_others_alone() -> None:
    """Status invalid and NaN there; every other point keeps its bits."""
    good = [250.0, 300.0, 350.0]
    reference = simulated(over={"temperature": good})
    mixed = xr.DataArray([250.0, -5.0, 300.0, np.nan, 350.0, np.inf], dims="case")
    ds = simulated(over={"temperature": mixed})
    assert ds.status.values.tolist() == [1, 4, 1, 4, 1, 4]
    assert np.isnan(ds.stretch.values[[1, 3, 5]]).all()
    assert np.isnan(ds.error.values[[1, 3, 5]]).all()
    assert np.isnan(ds.energy.values[[1, 3, 5]]).all()
    for name in ("stretch", "energy", "error"):
        np.testing.assert_array_equal(ds[name].values[[0, 2, 4]], reference[name].values)


def labelled(values: list[float], labels: list[Any], dim: str = "specimen") -> xr.DataArray:
    return xr.DataArray(values, dims=dim, coords={dim: labels})


@given(order=st.permutations(["p", "q", "r"]))
def test_values_are_paired_by_their_labels(order: list[str]) -> None:
    """Whatever the order of the second, the result is in that of the first, with its labels."""
    b, omega = {"p": 0.2, "q": 0.3, "r": 0.4}, {"p": 0.7, "q": 1.1, "r": 0.9}
    ds = simulated(over={
        "b": labelled([b[x] for x in "pqr"], list("pqr")),
        "omega": labelled([omega[x] for x in order], order),
    })  # fmt: skip
    assert ds.specimen.values.tolist() == list("pqr")
    for name in "pqr":
        drive = rm.SineSquared(b[name], omega[name])
        assert_bits(ds.sel(specimen=name), rm.simulate(rm.Actuator(), drive, times=TIMES))


def test_labels_that_do_not_match_are_refused() -> None:
    """Other labels, repeated labels, and the values of a field as labels of another."""
    b = labelled([0.2, 0.3], ["p", "q"])
    with pytest.raises(rm.InputError, match=r"labels along 'specimen' that b has"):
        simulated(over={"b": b, "omega": labelled([0.7, 1.1], ["p", "s"])})
    with pytest.raises(rm.InputError, match="each once"):
        simulated(over={"b": labelled([0.2, 0.3], ["p", "p"])})
    with pytest.raises(rm.InputError, match="labels along 'omega'"):
        simulated(over={"omega": [0.7, 1.1], "b": labelled([0.2, 0.3], [0.7, 1.2], "omega")})
    ds = simulated(over={"omega": [0.7, 1.1], "b": labelled([0.2, 0.3], [1.1, 0.7], "omega")})
    assert ds.b.values.tolist() == [0.3, 0.2]


def test_labels_survive_units_and_files(tmp_path: Path) -> None:
    """Text labels of the caller's own come through SI and netCDF."""
    film = rm.Actuator.from_si(
        shear_modulus="100 kPa", density="2000 kg/m3", half_length="5 mm", half_thickness="5 mm"
    )
    ds = simulated(film, over={"b": labelled([0.2, 0.3], ["p", "q"])})
    assert rm.to_si(ds).specimen.values.tolist() == ["p", "q"]
    assert rm.load(rm.save(ds, tmp_path / "x.nc")).specimen.values.tolist() == ["p", "q"]


@pytest.mark.parametrize(
    "dim", ["stretch", "energy", "error", "status", "time", "stretch_error", "b", "horizon"]
)
def test_dimensions_named_like_variables_are_refused(dim: str) -> None:
    """Else the variable would vanish from the result."""
    with pytest.raises(rm.InputError, match="Rename the dimension"):
        simulated(over={"c": xr.DataArray([1.0, 2.0], dims=dim)})


def test_values_that_break_a_rule_draw_one_warning() -> None:
    """It names the field, the values, the rule and how many points are left out."""
    expected = r"1 of 3 points .*over\['temperature'\] must be .* greater than 0; got -20"
    with pytest.warns(rm.InputWarning, match=expected) as caught:
        simulated(over={"temperature": [-20.0, 280.0, 300.0]})
    assert len(caught) == 1
    assert caught[0].filename == __file__
    with pytest.warns(rm.InputWarning, match="`temperature` is below 100 K: 25 K"):
        simulated(over={"temperature": [25.0, 300.0]})
    with pytest.warns(rm.InputWarning, match=r"got nan"):
        simulated(over={"c": xr.DataArray([1.0, np.nan], dims="case")})


def test_starts_outside_of_what_the_message_states_are_none() -> None:
    """Stretches from 1e-6 to 1e6 and rates up to 1e6, both ends included, are states."""
    stretches, rates = [-1.0, 0.0, 9e-7, 1e-6, 1e6, 1.1e6], [-1.1e6, -1e6, 0.0, 1e6, 1.1e6]
    over = {"initial.stretch": stretches, "initial.stretch_rate": rates}
    with pytest.warns(rm.InputWarning, match="24 of 30 points"):
        ens = lay_out_ensemble(rm.Actuator(), DRIVE, over)
    valid = np.outer([0, 0, 0, 1, 1, 0], [0, 1, 1, 1, 0])
    assert (ens.is_invalid == (valid.ravel() == 0)).all()
