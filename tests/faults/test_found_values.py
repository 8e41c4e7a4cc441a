"""Kinds of values that random calls found to be misunderstood, each by an example.

Law: Any values.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pint
import pytest
import xarray as xr

import remanent as rm
from remanent.studies.orbits._search import is_reversible
from tests.contracts.sound_calls import BODY, DAMPED, DRIVE, SOUND, branch, decaying, measure
from tests.faults.own_systems import DUFFING, FORCE, FREE, PAIR, own_sound_calls
from tests.faults.subjects import equilibria_over_loads
from tests.faults.value_pool import Unspeakable, Unusable
from tests.unit.plots.synthetic import basins_of_two

#: The package without its types, for calls that they forbid.
LOOSE: Any = rm
HUGE = np.broadcast_to(1.0, 10**11)
ENDLESS: list[Any] = []
ENDLESS.append(ENDLESS)
STIFF = (
    rm.Actuator(c=1e300),
    rm.Actuator(reference_temperature=1e300),
    rm.Actuator(material=rm.Gent(1e-300)),
)


@pytest.fixture(autouse=True)
def loud() -> Any:
    """A warning of a library is a failure."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", rm.InputWarning)
        yield
    plt.close("all")


def motion() -> xr.Dataset:
    return rm.simulate(BODY, DRIVE, duration=1.0)


REFUSED: dict[str, tuple[Callable[[], Any], str]] = {
    "sets of parameters that are none": (lambda: LOOSE_MEASURE.at([1.0]), "values"),
    "no set of parameters": (lambda: LOOSE_MEASURE.at({}), "values"),
    "sets of two lengths": (
        lambda: measure().at({"temperature": [290.0], "c": [1.0, 0.5]}), "values"
    ),
    "sets in two dimensions": (lambda: measure().values_at({"c": [[1.0]]}), "values['c']"),
    "times beyond memory": (lambda: DRIVE(HUGE), "tau"),
    "many of them": (lambda: LOOSE.simulate(BODY, DRIVE, times=[HUGE, HUGE]), "times"),
    "a long float beyond floats": (lambda: DRIVE(np.longdouble("1e400")), "tau"),
    "what cannot be written": (lambda: LOOSE.SineSquared(Unspeakable(), 1.0), "b"),
    "a choice that cannot be written": (
        lambda: LOOSE.crossings(BODY, DRIVE, "stretch", 1.0, direction=Unspeakable(), periods=1),
        "direction",
    ),
    "what says that it is an array": (
        lambda: LOOSE.simulate(BODY, DRIVE, duration=1.0, initial=Unusable()), "initial"
    ),
    "an array for a name": (
        lambda: LOOSE.Actuator().with_parameter(np.array(["c", "c"]), 1.0), "name"
    ),
    "a temperature that no ratio reaches": (
        lambda: rm.rescale(motion(), temperature=5e-324), "temperature"
    ),
    "a stacked result": (
        lambda: rm.rescale(motion().stack(every=["time"]), temperature=300.0), "dataset"
    ),
    "a stacked result in SI": (lambda: rm.to_si(motion().stack(every=["time"])), "dataset"),
    "a box without end": (
        lambda: rm.periodic_orbits(DAMPED, DRIVE, state_box={"stretch_rate": (-1e308, 1e308)}),
        "state_box",
    ),
    "a range without end": (
        lambda: rm.snap_through(rm.Actuator(prestress=2.2), "m", (-1e308, 1e308)),
        "parameter_range",
    ),
    "a decay of words": (
        lambda: rm.logarithmic_decrement(motion().astype(str)), "history['thickness_stretch']"
    ),
    "a branch at infinity": (
        lambda: rm.switch_branch(branch().map(lambda x: x * np.inf if x.dtype == float else x)),
        "branch",
    ),
    "a branch of complex numbers": (
        lambda: rm.switch_branch(branch().map(lambda x: x * 1j if x.dtype == float else x)),
        "branch",
    ),
    "a fold of an infinite drive": (
        lambda: rm.locate_bifurcation(
            **SOUND["locate_bifurcation"]() | {"drive": rm.SineSquared(1e150, 1.25)}
        ), "initial",
    ),
    "a branch of words": (lambda: rm.plot.branch(branch(), "reason"), "variable"),
    "a field that was not followed": (
        lambda: rm.switch_branch(branch(), parameter="prestress"), "parameter"
    ),
    "ranges in an array without dimensions": (
        lambda: rm.continue_bifurcation(
            **SOUND["continue_bifurcation"]() | {"parameter_ranges": np.array(None)}
        ), "parameter_ranges",
    ),
    "a dimension without a name": (
        lambda: rm.simulate(
            DAMPED, DRIVE, periods=1, over={"b": xr.DataArray([0.3, 0.4], dims="")}
        ), "over['b']",
    ),
    "a curve through a point": (lambda: rm.plot.phase(motion(), "status"), "x"),
    "a chart of one value": (
        lambda: rm.plot.map(rm.classify(**SOUND["classify"]())), "dataset"
    ),
    "an orbit without end": (
        lambda: rm.periodic_orbits(DAMPED, DRIVE, orbit_period=2**31), "orbit_period"
    ),
    "a saddle of a period that has none near": (
        lambda: rm.manifold_crossing(**SOUND["manifold_crossing"]() | {"orbit_period": 16}),
        "saddle",
    ),
    "a range of no width": (
        lambda: rm.response_diagram(DAMPED, DRIVE, (1.0, 1.0 + 2e-16)), "omega_range"
    ),
    "an interval wider than floats": (
        lambda: rm.uncertainty(measure(), parameter_ranges={"temperature": (-1e308, 1e308)}),
        "parameter_ranges['temperature']",
    ),
    "more names than memory holds": (
        lambda: LOOSE.design(measure(), 1.1, HUGE), "parameters"
    ),
    "a table of targets": (
        lambda: LOOSE.design(measure(), [[1.0, 2.0]], "temperature"), "targets"
    ),
    "a system of other states": (
        lambda: rm.switch_branch(branch(), system=rm.Actuator(prestress=(0.0, 0.1))), "system"
    ),
    "equilibria against what they do not vary along": (
        lambda: rm.plot.equilibria(equilibria_over_loads(), parameter="thickness_stretch"),
        "parameter",
    ),
    "what equilibria have no values of": (
        lambda: rm.plot.equilibria(equilibria_over_loads(), "thickness_stretch"), "variable"
    ),
    "a branch against complex numbers": (
        lambda: rm.plot.multipliers(branch().assign_coords(omega=1j * branch().omega)), "dataset"
    ),
    "a branch against what was not followed": (
        lambda: rm.plot.branch(branch(), parameter="maximum"), "parameter"
    ),
    "axes in space": (
        lambda: rm.plot.history(motion(), ax=plt.figure().add_subplot(projection="3d")), "ax"
    ),
    "a masked width": (lambda: rm.plot.history(motion(), linewidth=np.ma.masked), "linewidth"),
    "a complex width": (
        lambda: rm.plot.history(motion(), linewidth=xr.DataArray(1j)), "linewidth"
    ),
    "a colour within itself": (lambda: rm.plot.history(motion(), color=ENDLESS), "color"),
    "a width beyond memory": (lambda: rm.plot.history(motion(), linewidth=HUGE), "linewidth"),
    "bars of complex numbers": (
        lambda: rm.plot.bars(rm.sensitivity(**SOUND["sensitivity"]()) * 1j), "dataset"
    ),
    "regimes of objects": (
        lambda: rm.plot.map(
            rm.basins(**SOUND["basins"]()).astype(object), "stretch"
        ), "dataset",
    ),
    "basins of no cells": (
        lambda: rm.plot.basins(basins_of_two().isel(stretch=slice(0))), "dataset"
    ),
    "basins of words": (lambda: rm.plot.basins(basins_of_two().astype(str)), "dataset"),
    "basins without numbers": (
        lambda: rm.plot.basins(basins_of_two().where(False)), "dataset"
    ),
    "attractors of half a state": (
        lambda: rm.plot.basins(basins_of_two().isel(state=slice(1))), "dataset"
    ),
    "complex dashes": (lambda: rm.plot.history(motion(), dashes=[1, 1j]), "dashes"),
    "a line so many milliseconds wide": (
        lambda: rm.plot.history(motion(), linewidth=pint.Quantity(1.0, "ms")), "linewidth"
    ),
    "a section of numbers in words": (
        lambda: rm.plot.section(rm.poincare_section(BODY, DRIVE, periods=2).astype(str)), "dataset"
    ),
    "a setting that is no number": (
        lambda: rm.rescale(motion().assign_attrs(tolerance="x"), temperature=300.0), "dataset"
    ),
    "ranges of another number of fields": (
        lambda: rm.rescale(
            motion().assign_attrs(parameter_ranges=(0.1, 0.2, 0.3), parameters="omega b"),
            temperature=300.0,
        ), "dataset",
    ),
    "scales that are none": (lambda: rm.to_si(motion().assign_attrs(scales="[")), "dataset"),
    "loads that are none": (lambda: LOOSE.Loads(Unusable()), "drives"),
    "other loads that are none": (lambda: LOOSE.Loads.example().replace(drives=1.25), "drives"),
    "a load of no drive": (
        lambda: LOOSE.simulate(DUFFING, {"load": 1.0}, duration=1.0), "drive"
    ),
    "names in an array": (lambda: DUFFING.replace(loads=[HUGE]), "loads"),
    "a product beyond floats": (
        lambda: rm.FirstOrderSystem(rates={"x": "1e200*1e200*x"}), "rates['x']"
    ),
    "frequencies without end": (
        lambda: rm.response_diagram(**SOUND["response_diagram"]() | {"slices": 2**31}), "slices"
    ),
    "frequencies of resonances without end": (
        lambda: rm.resonances(**SOUND["resonances"]() | {"slices": 2**31}), "slices"
    ),
    "a file of names that are no text": (
        lambda: rm.save(xr.Dataset({1: ((2,), [1.0])}), "none.nc"), "dataset"
    ),
    "a sweep without end": (
        lambda: rm.bifurcation_diagram(**SOUND["bifurcation_diagram"]() | {"discard": 2**31}),
        "discard",
    ),
    "a branch of a body that nothing moves": (
        lambda: rm.switch_branch(
            **SOUND["switch_branch"]() | {"system": rm.Actuator(prestress=1e300)}
        ), "special_point",
    ),
    "a picture of a stacked result": (
        lambda: rm.plot.phase(motion().stack(every=["time"])), "dataset"
    ),
    "rates of no formula": (lambda: LOOSE.FirstOrderSystem(rates=Unusable()), "rates"),
    "units of nothing": (lambda: DUFFING.replace(units=Unusable()), "units"),
    "a line wider than floats": (lambda: rm.plot.history(motion(), linewidth=10**400), "linewidth"),
}  # fmt: skip
LOOSE_MEASURE: Any = measure()


@pytest.mark.parametrize("case", REFUSED)
def test_it_is_refused_by_name(case: str) -> None:
    """The message is about the argument that was misunderstood."""
    call, name = REFUSED[case]
    with pytest.raises(rm.InputError) as refused:
        call()
    assert refused.value.name == name


@pytest.mark.parametrize("body", STIFF, ids=repr)
def test_a_command_of_an_impossible_body_is_refused(body: rm.Actuator) -> None:
    """Nothing that could move it is a number."""
    with pytest.raises(rm.InputError, match="target"):
        rm.shape_command(body, 1.1)


def test_a_dimension_of_one_temperature_is_one_temperature() -> None:
    """Scaling and adding a dimension of length 1 commute."""
    run = motion()
    alone = rm.rescale(run, temperature=350.0)
    along = rm.rescale(run.expand_dims(temperature=[293.0]), temperature=350.0)
    assert along.temperature.values.tolist() == [350.0]
    xr.testing.assert_equal(along.isel(temperature=0, drop=True), alone)
    assert rm.read_system(along).parameter_values() == rm.read_system(alone).parameter_values()


def test_a_free_oscillation_beyond_the_finest_steps_says_so() -> None:
    """A point alone has what it has beside one that is reached."""
    both = rm.backbone(BODY, [290.0, 300.0], tolerance=1e-9)
    assert both.status.values.tolist() == [rm.Status.MAX_STEPS, rm.Status.OK]
    assert np.isnan(both.frequency.values).tolist() == [True, False]


def test_there_are_no_orbits_where_no_state_is() -> None:
    """Chains of this material end at a stretch below the box."""
    found = rm.periodic_orbits(
        rm.Actuator(material=rm.Gent(1.0)), DRIVE, state_box={"stretch": (3.0, 4.0)}
    )
    assert (int(found.orbits), int(found.status)) == (0, rm.Status.OK)


def test_a_point_without_a_period_has_no_losses() -> None:
    """It is invalid, beside one that is not."""
    found = rm.cycle_losses(DAMPED, DRIVE, periods=2, over={"omega": [0.0, 1.0]})
    assert found.status.values.tolist() == [rm.Status.INVALID, rm.Status.OK]


def test_a_picture_of_what_arithmetic_took_says_that_nothing_is_there() -> None:
    """Its status is NaN too, and says nothing."""
    axes = plt.figure().subplots()
    rm.plot.history(motion().where(False), ax=axes)
    assert "no result" in [text.get_text() for text in axes.texts]


def test_a_derivative_beyond_floats_is_refused() -> None:
    """Of x' = 1e200 x the second derivative is 1e400 x."""
    huge = rm.FirstOrderSystem(rates={"x": "1e200*x", "y": "load"})
    with pytest.raises(rm.InputError, match="numbers that a float can hold"):
        rm.simulate(huge, rm.Constant(0.0), duration=1.0, initial=[1.0, 0.0])


def test_a_field_of_which_one_value_is_sound_has_no_range_for_folds() -> None:
    """There are equilibria at that value, and none at infinity."""
    box = {"x": (-2.0, 2.0)}
    found = rm.equilibria(DUFFING, 0.1, over={"delta": [1.0, np.inf]}, state_box=box)
    assert found.status.values.tolist() == [rm.Status.OK, rm.Status.INVALID]
    assert "fold" not in found.dims


def test_equilibria_at_infinite_stiffness_are_none() -> None:
    """They end in a status, and change nothing beside them."""
    box = {"x": (-2.0, 2.0)}
    both = rm.equilibria(FREE, 0.1, over={"k": [1.0, 1e308]}, state_box=box)
    alone = rm.equilibria(FREE, 0.1, state_box=box)
    assert int(alone.status) == rm.Status.OK
    np.testing.assert_array_equal(both.x[0, : alone.sizes["equilibrium"]], alone.x)


@pytest.mark.parametrize("verb", ["manifold_crossing", "continue_orbit", "locate_bifurcation"])
def test_a_short_integer_counts_as_any_other(verb: str) -> None:
    """The number of one byte is that number, and what is reckoned with it does not overflow."""
    sound = own_sound_calls()[verb]()
    plain = getattr(rm, verb)(**sound | {"orbit_period": 1})
    xr.testing.assert_identical(getattr(rm, verb)(**sound | {"orbit_period": np.int8(1)}), plain)


def test_a_rate_near_the_largest_number_is_followed_without_a_warning() -> None:
    """The absolute error of x' = 1e300 meets no tolerance, and no crossing is told."""
    fast = rm.FirstOrderSystem(rates={"x": "1e300 + load"})
    found = rm.crossings(fast, rm.Constant(0.0), "x", 1e299, duration=1.0)
    assert (int(found.status), found.sizes["crossing"]) == (rm.Status.MAX_STEPS, 0)


def test_a_fraction_is_the_number_that_it_is(tmp_path: Path) -> None:
    """As a duration and as a tolerance; the result can be saved."""
    exact: dict[str, Any] = {"duration": Fraction(1, 2), "tolerance": Fraction(1, 2**30)}
    run = LOOSE.simulate(BODY, DRIVE, **exact)
    xr.testing.assert_identical(run, rm.simulate(BODY, DRIVE, duration=0.5, tolerance=2.0**-30))
    xr.testing.assert_identical(rm.load(rm.save(run, tmp_path / "it.nc")), run)


@pytest.mark.parametrize("delta", [1e200, 1e308])
def test_a_huge_dashpot_moves_no_equilibrium(delta: float) -> None:
    """Places do not depend on it; eigenvalues, which overflow, say what is known of them."""
    box = {"x": (-2.0, 2.0)}
    damped = rm.equilibria(DUFFING, 0.1, state_box=box)
    stiff = rm.equilibria(DUFFING.with_parameter("delta", delta), 0.1, state_box=box)
    np.testing.assert_array_equal(stiff.x, damped.x)


def test_a_box_as_wide_as_floats_ends_in_a_status() -> None:
    """Nothing of it is known but that it cannot be told."""
    wide = {"x": (-1e300, 1e300), "y": (-1e300, 1e300)}
    assert int(rm.equilibria(PAIR, 0.1, state_box=wide).status) == rm.Status.INCOMPLETE


def test_a_free_oscillation_that_is_too_fast_says_so() -> None:
    """From x = 300 the quartic well has an error above the tolerance."""
    found = rm.backbone(FREE, [1.0, 300.0])
    assert int(found.status[0]) == rm.Status.OK
    assert np.isfinite(found.frequency.values[0])


def test_a_search_for_a_resonance_that_takes_too_long_says_how_far_it_came(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """With so many steps as were made its bracket holds the resonance that more would find."""
    omega = np.linspace(1.0, 1.5, 11)
    whole = rm.frequency_response(DAMPED, DRIVE, omega, duration=30.0)
    monkeypatch.setattr("remanent.studies.response.frequency_response._MOST_STEPS_OF_SEARCH", 1.0)
    short = rm.frequency_response(DAMPED, DRIVE, omega, duration=30.0)
    assert int(whole.resonance_status) == rm.Status.OK
    assert int(short.resonance_status) == rm.Status.INCOMPLETE
    assert "steps" in str(short.reason.values)
    assert abs(short.resonance - whole.resonance) <= short.resonance_error <= 0.05 + 1e-9
    xr.testing.assert_equal(short.amplitude, whole.amplitude)


def test_a_step_without_a_start_has_no_metrics() -> None:
    """NaN beside a start that is a number."""
    start = {"initial.stretch": [0.9, np.nan]}
    found = rm.step_response(**SOUND["step_response"]() | {"over": start})
    assert np.isnan(found.farthest.values).tolist() == [False, True]


def test_exponents_of_a_single_period_have_no_error() -> None:
    """One period has no batches to compare: the error is infinite, and nothing fails."""
    found = rm.lyapunov(DAMPED, DRIVE, periods=1)
    assert np.isinf(found.exponent_error)


def test_a_box_that_motion_leaves_at_once_holds_no_orbit() -> None:
    """Rates of 290 to 300 are outrun by no damped orbit, and the list is empty."""
    found = rm.periodic_orbits(DAMPED, DRIVE, state_box={"stretch_rate": (290.0, 300.0)})
    assert found.sizes["orbit"] == 0


def test_a_body_without_an_energy_is_not_searched() -> None:
    """Its chains are as long as they can be at rest."""
    found = rm.periodic_orbits(rm.Actuator(material=rm.Gent(1e-300)), DRIVE)
    assert int(found.status) == rm.Status.INCOMPLETE
    assert "energy" in str(found.reason.values)


@pytest.mark.slow
def test_a_load_that_grows_from_nothing_keeps_the_period() -> None:
    """A branch in a load from 0 ends on the orbit of a drive that has this load."""
    grown = rm.Sines([0.1, 0.1], [1, 3], 1.0)
    curve = rm.continue_orbit(DAMPED, rm.Sines([0.0, 0.1], [1, 3], 1.0), "loads.0", (0.0, 0.1))
    assert curve.end_reason.values.tolist() == ["bounds", "bounds"]
    last = curve.isel(point=int(np.argmax(curve["loads.0"].values)))
    (orbit,) = rm.periodic_orbits(DAMPED, grown).initial.values
    np.testing.assert_allclose([last.stretch, last.stretch_rate], orbit, rtol=0.0, atol=1e-9)
    assert rm.read_drive(curve) == rm.Sines([0.0, 0.1], [1, 3], 1.0)


def test_a_symmetry_in_time_must_outlast_what_varies() -> None:
    """A cosine is even in time, and a phase takes that from it; a larger load does not."""
    cosine = rm.Sine(0.1, 1.0, phase=np.pi / 2)
    assert is_reversible(BODY, cosine, ["m", "omega", "mean"])
    assert not is_reversible(BODY, cosine, ["phase"])


def test_a_point_has_the_reason_that_a_single_call_states() -> None:
    """The rule of the field, in the same words."""
    with pytest.raises(rm.InputError) as refused:
        rm.Actuator(temperature=-1.0)
    run = rm.simulate(BODY, DRIVE, duration=1.0, over={"temperature": [-1.0, 300.0]})
    assert run.reason.values.tolist() == [f"temperature must {refused.value.must}", ""]
    assert run.status.values.tolist() == [rm.Status.INVALID, rm.Status.OK]
    assert "reason" not in motion()


def test_fields_of_an_outer_product_are_looked_at_together() -> None:
    """A magnet beyond its rating is told of wherever a coefficient meets a temperature."""
    hot = {"temperature": [290.0, 400.0], "magnet.temperature_coefficient": [0.0, 1e-4, 1e-3]}
    with pytest.warns(rm.InputWarning, match="rating"):
        run = rm.simulate(BODY, DRIVE, duration=1.0, over=hot)
    assert run.sizes["temperature"] == 2
    cold = {"temperature": [290.0, 300.0], "magnet.temperature_coefficient": [0.0, 1e-4, 1e-3]}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rm.simulate(BODY, DRIVE, duration=1.0, over=cold)


def test_no_motions_have_no_decays() -> None:
    """As many as there are."""
    runs = rm.simulate(BODY, DRIVE, duration=1.0, over={"temperature": [290.0, 300.0]})
    none = runs.isel(time=slice(0), temperature=slice(0))
    assert rm.logarithmic_decrement(none).sizes["temperature"] == 0


def test_a_decay_does_not_depend_on_the_order_of_its_record() -> None:
    """Reversing a record changes nothing, and an instant twice has two values."""
    run = decaying()
    told = rm.logarithmic_decrement(run)
    xr.testing.assert_equal(rm.logarithmic_decrement(run.isel(time=slice(None, None, -1))), told)
    with pytest.raises(rm.InputError, match="once"):
        rm.logarithmic_decrement(run.isel(time=[0, 1, 1, 2]))


def test_a_seed_that_was_used_is_written_down() -> None:
    """It is the first number that the generator would give."""
    few: dict[str, Any] = {"samples": 16, "quantiles": (0.5,), "rng": np.random.default_rng(5)}
    given = SOUND["uncertainty"]() | few
    assert rm.uncertainty(**given).attrs["rng"] == np.random.default_rng(5).integers(2**31)


@pytest.mark.parametrize("duration", [2**63, np.uint64(2**63)])
def test_a_time_beyond_integers_of_files_can_be_saved(duration: Any, tmp_path: Path) -> None:
    """It is a float, as all times are."""
    for run in (
        rm.energy_balance(BODY, DRIVE, duration=duration),
        rm.simulate(DUFFING, FORCE, duration=duration),
    ):
        assert rm.load(rm.save(run, tmp_path / "it.nc")).attrs["duration"] == 2.0**63


@pytest.mark.parametrize("variable", ["multipliers", "special_omega"])
def test_what_the_points_of_a_branch_have_not_is_not_drawn(variable: str) -> None:
    """Complex numbers, and values at special points, are no curve."""
    with pytest.raises(rm.InputError, match="a real value at each point"):
        rm.plot.branch(branch(), variable)


@pytest.mark.parametrize("name", ["x" * 300, "x" * 300 + ".nc"])
def test_a_name_that_no_file_can_have_is_refused(name: str, tmp_path: Path) -> None:
    """By all that take paths."""
    path = tmp_path / name
    with pytest.raises(rm.InputError, match="`path` must"):
        rm.load(path)
    with pytest.raises(rm.InputError, match="File name too long"):
        rm.sweep(BODY, DRIVE, {"b": [0.3]}, "cycle_losses", periods=1, store=path)


def test_orbits_without_points_have_no_start() -> None:
    """The frame is there, and is empty."""
    none = rm.simulate(BODY, DRIVE, duration=1.0).isel(time=slice(0))
    (line,) = rm.plot.phase(none)
    assert np.size(line.get_xdata()) == 0


@pytest.mark.slow
def test_determinants_of_infinite_stiffness_warn_of_nothing() -> None:
    """As powers of e at the end of a state box are."""
    steep = rm.LagrangianSystem(
        coordinates="x", kinetic="x_rate**2/x**2", potential="exp(700*x)", dissipation="0",
        rest={"x": 1.0},
    )  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        rm.snap_through(steep, "m", (-1.0, 1.0), state_box={"x": (-2.0, 2.0)})


def test_a_measure_may_be_a_function_that_hides_its_arguments() -> None:
    """As int does; it has no `over`, then."""
    assert isinstance(rm.Measure(int), rm.Measure)


def test_one_end_of_a_branch_is_no_mark() -> None:
    """It is not known which of the two it is."""
    assert len(np.ravel(rm.plot.overview(branch().isel(end=slice(1))))) > 0


def test_an_array_without_dimensions_is_no_sequence() -> None:
    """Of orbit periods, as one number is none."""
    with pytest.raises(rm.InputError, match="`orbit_periods` must be a sequence"):
        LOOSE.resonances(**{**SOUND["resonances"](), "orbit_periods": np.array(1)})


def test_an_option_of_a_study_fits_into_its_description(tmp_path: Path) -> None:
    """It is kept with the store, and is not unfolded before."""
    with pytest.raises(rm.InputError, match="at most 1000000 entries"):
        rm.sweep(
            BODY, DRIVE, {"b": [0.3]}, "cycle_losses", store=tmp_path / "s.zarr", periods=1,
            tolerance=HUGE,
        )  # fmt: skip


def test_values_may_lie_as_far_apart_as_floats_do() -> None:
    """Their difference is no float."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = rm.sweep(BODY, DRIVE, {"b": [-1e308, 1e308]}, "cycle_losses", periods=1)
    assert made.sizes["b"] == 2
