"""Results as plain data: the numbers are those of the verbs, and what is missing says why."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import xarray as xr
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

import remanent as rm
from remanent.web import views

DAMPED = rm.Actuator(temperature=350.0, dissipation=rm.Rayleigh(0.1))
DRIVE = rm.SineSquared(0.4, 1.25)


def numbers(quantity: dict[str, Any]) -> np.ndarray[Any, Any]:
    """The values of a quantity as an array, NaN for null."""
    return np.array(quantity["values"], dtype=np.float64)


def strict(view: dict[str, Any]) -> dict[str, Any]:
    """A view after its way through JSON, in which there is no NaN."""
    read: dict[str, Any] = json.loads(json.dumps(view, allow_nan=False))
    return read


@given(arrays.arrays(np.float64, arrays.array_shapes(max_dims=3, max_side=4)))
def test_numbers_come_through_as_they_are(values: np.ndarray[Any, Any]) -> None:
    """Law: every finite number comes through JSON bit for bit, every other one is null."""
    read = np.array(json.loads(json.dumps(views.plain(values), allow_nan=False)), dtype=np.float64)
    finite = np.isfinite(values)
    assert read.shape == values.shape
    assert np.array_equal(read[finite], values[finite])
    assert np.isnan(read[~finite]).all()


def test_other_values_come_through() -> None:
    """Law: words, integers and complex numbers are told, the last by their parts."""
    assert views.plain(np.array(["a", "<b>"])) == ["a", "<b>"]
    assert views.plain(np.array([1, 2], dtype=np.int8)) == [1, 2]
    assert views.plain(np.array([1 + 2j, np.nan])) == {
        "real": [1.0, None], "imaginary": [2.0, 0.0],
    }  # fmt: skip


@given(st.lists(st.sampled_from(list(rm.Status)), min_size=1, max_size=20))
def test_every_status_is_a_word(codes: list[rm.Status]) -> None:
    """Law: the words are those of the public list."""
    words = views.status_words(np.array(codes, dtype=np.int8))
    assert words == [code.meaning for code in codes]


def test_a_response_is_told_as_it_is() -> None:
    """Law: amplitudes, extremes, their error and the resonance are those of the verb."""
    omega = np.linspace(1.0, 1.5, 21)
    response = rm.frequency_response(DAMPED, DRIVE, omega)
    view = strict(views.frequency_response_view({"rest": response}, {"count": 21}))
    (series,) = view["series"]
    assert np.array_equal(numbers(view["x"]), omega)
    for name in ("amplitude", "maximum", "minimum"):
        assert np.array_equal(numbers(series[name]), response[name].values)
    assert np.array_equal(numbers(series["error"]), response.amplitude_error.values)
    assert view["resonance"]["resonance"]["values"] == float(response.resonance)
    assert series["status"] == ["ok"] * 21
    assert view["statuses"] == {"ok": rm.Status.OK.explanation}
    assert view["settings"] == {"count": 21}


def test_a_missing_resonance_says_why() -> None:
    """Law: where there is no number there is a reason."""
    response = rm.frequency_response(DAMPED, DRIVE, np.linspace(0.9, 1.0, 3))
    view = strict(views.frequency_response_view({"rest": response}, {}))
    assert view["resonance"]["resonance"]["values"] is None
    assert view["resonance"]["status"] == "incomplete"
    assert "no peak" in view["reason"]


def test_branches_are_told_apart() -> None:
    """Law: every branch has its points and their stability, none of the padding, and its ends."""
    diagram = rm.response_diagram(
        rm.Actuator(temperature=350.0, dissipation=rm.Rayleigh(0.05)), DRIVE, (1.0, 1.5)
    )
    view = strict(views.response_diagram_view(diagram, {}))
    assert len(view["series"]) == len(view["ends"]) == diagram.sizes["branch"]
    for number, series in enumerate(view["series"]):
        branch = diagram.isel(branch=number)
        known = np.isfinite(branch.omega.values)
        assert np.array_equal(numbers(series["omega"]), branch.omega.values[known])
        assert np.array_equal(numbers(series["amplitude"]), branch.amplitude.values[known])
        assert np.array_equal(numbers(series["error"]), branch.amplitude_error.values[known])
        assert series["stability"]["values"] == branch.stability.values[known].tolist()
    assert view["special"]["special_kind"]["values"] == diagram.special_kind.values.tolist()


def test_a_regime_comes_with_its_evidence() -> None:
    """Law: label, margin and exponent are those of the verb."""
    regime = rm.classify(DAMPED, DRIVE, periods=100)
    (series,) = strict(views.classify_view(regime, {}))["series"]
    assert series["regime"]["values"] == str(regime.regime.values)
    assert series["exponent"]["values"] == float(regime.exponent)
    assert series["exponent_error"]["values"] == float(regime.exponent_error)
    assert series["status"] == "ok"


@pytest.mark.parametrize("axes", [("stretch", "stretch_rate"), ("stretch_rate", "stretch")])
def test_charts_have_rows_along_y(axes: tuple[str, str]) -> None:
    """Law: the value at row j and column i is that at the j-th y and the i-th x."""
    grid = {"stretch": np.array([0.9, 1.0, 1.1]), "stretch_rate": np.array([0.0, 0.1])}
    basins = rm.basins(DAMPED, DRIVE, grid, periods=100)
    view = strict(views.basins_view(basins, {}, axes))
    (series,) = view["series"]
    x, y = axes
    assert np.array_equal(numbers(view["x"]), grid[x])
    for j, row in enumerate(series["basin"]["values"]):
        for i, value in enumerate(row):
            assert value == int(basins.basin.sel({x: grid[x][i], y: grid[y][j]}))
    shares = view["attractors"]["fraction"]["values"]
    assert shares == basins.fraction.values.tolist()


def test_basins_of_what_loses_nothing_have_no_attractors() -> None:
    """Law: without dissipation there is no attractor, and none is told."""
    grid = {"stretch": [1.0, 1.1], "stretch_rate": [0.0, 0.1]}
    basins = rm.basins(rm.Actuator(), DRIVE, grid, periods=100)
    assert views.basins_view(basins, {}, ("stretch", "stretch_rate"))["attractors"] == {}


def test_a_chart_of_regimes_is_told() -> None:
    """Law: labels lie along (y, x)."""
    chart = rm.regime_chart(DAMPED, DRIVE, {"b": [0.2, 0.3, 0.4], "omega": [1.7, 2.0]}, periods=100)
    view = strict(views.regime_chart_view(chart, {}, ("omega", "b")))
    (series,) = view["series"]
    assert view["x"]["name"] == "omega"
    assert series["regime"]["values"] == chart.regime.transpose("b", "omega").values.tolist()
    assert series["status"] == [["ok", "ok"]] * 3


@pytest.mark.parametrize(
    "system",
    [
        rm.Actuator(prestress=2.2),
        rm.Actuator(prestress=(0.5, 0.2)),
        rm.LagrangianSystem(
            coordinates=("x",),
            kinetic="x_rate**2/2",
            potential="-x**2/2 + x**4/4 - load*x",
            dissipation="delta*x_rate**2/2",
            parameters={"delta": 0.15},
        ),
    ],
    ids=["one coordinate", "two coordinates", "own"],
)
def test_equilibria_are_told(system: Any) -> None:
    """Law: places and their stability are those of the verb, for every kind of system."""
    options = {"state_box": {"x": (-2.0, 2.0)}} if isinstance(system, rm.LagrangianSystem) else {}
    rest = rm.equilibria(system, 0.1, **options)
    view = strict(views.equilibria_view(rest, {}))
    assert view["equilibria"]["stability"]["values"] == rest.stability.values.tolist()
    assert bool(view["series"]) == ("potential" in rest)
    if view["series"]:
        assert np.array_equal(numbers(view["series"][0]["potential"]), rest.potential.values)


def test_text_is_left_as_it_is() -> None:
    """Law: names that look like markup come through as data, letter by letter."""
    hostile = '<img src=x onerror="alert(1)">&amp;\u2028</script>'
    variable = xr.DataArray([1.0], name="x", attrs={"long_name": hostile, "units": hostile})
    told = strict(views.quantity(variable))
    assert told["text"] == told["unit"] == hostile
