"""Kinds of values that random calls found to be misunderstood, each by an example.

Law: Any values.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pint
import pytest
import xarray as xr
from tests.contracts.sound_calls import BODY, DAMPED, DRIVE, SOUND, branch, measure
from tests.faults.value_pool import Unspeakable, Unusable

import remanent as rm
from remanent.studies.orbits._search import is_reversible

#: The package without its types, for calls that they forbid.
LOOSE: Any = rm
HUGE = np.broadcast_to(1.0, 10**11)
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
    "a branch of words": (lambda: rm.plot.branch(branch(), "reason"), "variable"),
    "a field that was not followed": (
        lambda: rm.switch_branch(branch(), parameter="prestress"), "parameter"
    ),
    "a curve through a point": (lambda: rm.plot.phase(motion(), "status"), "x"),
    "a chart of one value": (
        lambda: rm.plot.map(rm.classify(**SOUND["classify"]())), "dataset"
    ),
    "a line so many milliseconds wide": (
        lambda: rm.plot.history(motion(), linewidth=pint.Quantity(1.0, "ms")), "linewidth"
    ),
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
    assert rm.read_system(along).parameters() == rm.read_system(alone).parameters()


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


def test_a_body_without_an_energy_is_not_searched() -> None:
    """Its chains are as long as they can be at rest."""
    found = rm.periodic_orbits(rm.Actuator(material=rm.Gent(1e-300)), DRIVE)
    assert int(found.status) == rm.Status.INCOMPLETE
    assert "energy" in str(found.reason.values)


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


def test_a_seed_that_was_used_is_written_down() -> None:
    """It is the first number that the generator would give."""
    given = SOUND["uncertainty"]() | {"rng": np.random.default_rng(5)}
    assert rm.uncertainty(**given).attrs["rng"] == np.random.default_rng(5).integers(2**31)


def test_a_time_beyond_integers_of_files_can_be_saved(tmp_path: Path) -> None:
    """It is a float, as all times are."""
    run = rm.energy_balance(BODY, DRIVE, duration=2**63)
    assert rm.load(rm.save(run, tmp_path / "it.nc")).attrs["duration"] == 2.0**63
