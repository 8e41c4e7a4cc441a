"""Bad input: one message that names the field, the rule, the value, and what to do.

Law: Bad input.
"""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm

BODY = rm.Actuator()
DRIVE = rm.SineSquared(0.4, 1.25)
NAN, INF = float("nan"), float("inf")


def simulate(**settings: Any) -> Any:
    return rm.simulate(settings.pop("body", BODY), settings.pop("drive", DRIVE), **settings)


def si(**changes: Any) -> Any:
    sound = {
        "shear_modulus": "100 kPa",
        "density": "2000 kg/m^3",
        "half_length": "5 mm",
        "half_thickness": "0.5 mm",
    }
    return rm.Actuator.from_si(**{**sound, **changes})


#: A call, and what its message must say: field, rule, value, remedy.
CASES: dict[str, tuple[Callable[[], Any], tuple[str, ...]]] = {
    # numbers of the actuator
    "T = 0": (
        lambda: rm.Actuator(temperature=0),
        ("`temperature`", "greater than 0", "0", "273.15"),
    ),
    "T < 0": (lambda: rm.Actuator(temperature=-5), ("`temperature`", "-5", "kelvin")),
    "T NaN": (lambda: rm.Actuator(temperature=NAN), ("`temperature`", "finite", "nan")),
    "T inf": (lambda: rm.Actuator(temperature=INF), ("`temperature`", "finite", "inf")),
    "T0 = 0": (lambda: rm.Actuator(reference_temperature=0), ("`reference_temperature`",)),
    "c = 0": (lambda: rm.Actuator(c=0), ("`c`", "greater than 0", "H^2/L^2", "Pass 1")),
    "c < 0": (lambda: rm.Actuator(c=-1.0), ("`c`", "-1.0")),
    "c text": (lambda: rm.Actuator(c="1"), ("`c`", "one real number", "'1'")),  # type: ignore[arg-type]
    "c list": (lambda: rm.Actuator(c=[1, 2]), ("`c`", "over=")),  # type: ignore[arg-type]
    "c complex": (lambda: rm.Actuator(c=1j), ("`c`", "real")),  # type: ignore[arg-type]
    "c bool": (lambda: rm.Actuator(c=True), ("`c`", "True")),
    "S NaN": (lambda: rm.Actuator(prestress=NAN), ("`prestress`", "finite", "nan")),
    "eta < 0": (lambda: rm.Rayleigh(-0.1), ("eta", "at least 0", "-0.1")),
    "unknown field": (lambda: BODY.replace(temprature=300), ("temprature", "temperature")),
    "material": (lambda: rm.Actuator(material="rubber"), ("`material`", "NeoHookean")),  # type: ignore[arg-type]
    # quantities with units
    "mu = 0": (
        lambda: si(shear_modulus="0 Pa"),
        ("`shear_modulus`", "greater than 0", "0 Pa", "Check"),
    ),
    "rho < 0": (lambda: si(density="-2000 kg/m^3"), ("`density`", "-2000", "kg/m^3")),
    "L = 0": (lambda: si(half_length="0 mm"), ("`half_length`", "0 mm")),
    "H NaN": (lambda: si(half_thickness="nan mm"), ("`half_thickness`",)),
    "unit missing": (lambda: si(density=2000.0), ("`density`", "unit", "2000.0", "kg/m^3")),
    "unit wrong": (lambda: si(density="2000 Pa"), ("`density`", "kg/m^3", "2000 Pa")),
    "unit unknown": (lambda: si(density="2000 foo"), ("`density`", "2000 foo")),
    "unit of T": (lambda: si(temperature=300.0), ("`temperature`", "300.0")),
    # drives
    "b NaN": (lambda: rm.SineSquared(NAN, 1.0), ("`b`", "finite", "nan")),
    "omega = 0": (lambda: rm.SineSquared(0.4, 0.0), ("`omega`", "greater than 0", "Constant")),
    "omega < 0": (lambda: rm.Sine(0.4, -1.0), ("`omega`", "-1.0")),
    "m inf": (lambda: rm.Constant(INF), ("`m`", "inf")),
    "steps unsorted": (lambda: rm.Steps([0, 2, 1], [1, 2, 3]), ("`times`", "increase", "Sort")),
    "steps repeated": (lambda: rm.Steps([0, 1, 1], [1, 2, 3]), ("`times`", "duplicates")),
    "steps empty": (lambda: rm.Steps([], []), ("`times`", "at least one")),
    "steps late": (lambda: rm.Steps([1, 2], [1, 2]), ("`times`", "start at 0", "1.0")),
    "steps unequal": (lambda: rm.Steps([0, 1], [1]), ("`loads`", "2", "1")),
    "ramp NaN": (lambda: rm.Ramp([0, 1], [1, NAN]), ("`loads`", "finite", "nan")),
    "samples few": (lambda: rm.Sampled([0], [1]), ("`times`", "2 entries", "Constant")),
    "samples end": (
        lambda: simulate(drive=rm.Sampled([0, 1, 2], [0, 1, 0]), duration=5),
        ("`duration`", "2.0", "5.0", "Shorten"),
    ),
    "samples wild": (
        lambda: rm.Sampled([0, 1e-308, 9], [-1e308, 1e308, 0]),
        ("`loads`", "ordinary size"),
    ),
    "ramp steep": (lambda: rm.Ramp([0, 1e-309], [0, 1]), ("`loads`", "rates", "ordinary size")),
    "chirp": (lambda: rm.Chirp(1.0, 1.0, 2.0, 0.0), ("`duration`", "greater than 0", "Sine")),
    "drive": (lambda: simulate(drive=0.4, duration=5), ("`drive`", "SineSquared", "0.4")),
    "system": (lambda: simulate(body=1.0, duration=5), ("`system`", "rm.Actuator()")),
    # how long
    "no length": (simulate, ("`duration`", "`periods`", "`times`", "exactly one")),
    "two lengths": (
        lambda: simulate(duration=1, periods=1),
        ("exactly one", "duration and periods"),
    ),
    "duration 0": (lambda: simulate(duration=0), ("`duration`", "greater than 0", "0")),
    "duration too short for steps": (
        lambda: rm.frequency_response(rm.Actuator(), rm.Sine(0.3, 1.0), [1.0], duration=5e-324),
        ("`duration`", "at least 2.2e-308", "5e-324"),
    ),
    "duration NaN": (lambda: simulate(duration=NAN), ("`duration`", "nan")),
    "periods 0": (
        lambda: simulate(periods=0),
        ("`periods`", "positive integer", "0", "at least 1"),
    ),
    "periods 1.5": (lambda: simulate(periods=1.5), ("`periods`", "positive integer", "1.5")),
    "periods True": (lambda: simulate(periods=True), ("`periods`", "True")),
    "periods huge": (lambda: simulate(periods=10**400), ("`periods`", "at most")),
    "no period": (
        lambda: simulate(drive=rm.Constant(0.1), periods=5),
        ("`periods`", "Constant", "duration"),
    ),
    "times < 0": (lambda: simulate(times=[-1, 1]), ("`times`", "negative", "-1.0")),
    "times sorted": (lambda: simulate(times=[0, 2, 1]), ("`times`", "increase")),
    "times twice": (lambda: simulate(times=[0, 1, 1]), ("`times`", "duplicates")),
    "times empty": (lambda: simulate(times=[]), ("`times`", "at least one")),
    "times NaN": (lambda: simulate(times=[0, NAN]), ("`times`", "finite")),
    "tolerance 0": (lambda: simulate(duration=1, tolerance=0), ("`tolerance`", "1e-13", "0.1")),
    "tolerance NaN": (lambda: simulate(duration=1, tolerance=NAN), ("`tolerance`", "nan")),
    # where from
    "stretch 0": (lambda: simulate(duration=1, initial=(0, 0)), ("`initial`", "stretch", "0.0")),
    "stretch < 0": (lambda: simulate(duration=1, initial=(-1, 0)), ("`initial`", "-1.0")),
    "stretch far": (lambda: simulate(duration=1, initial=(1e9, 0)), ("`initial`", "1e+06")),
    "initial NaN": (lambda: simulate(duration=1, initial=(1, NAN)), ("`initial`", "finite")),
    "initial short": (lambda: simulate(duration=1, initial=[1]), ("`initial`", "stretch_rate")),
    "initial text": (lambda: simulate(duration=1, initial="rest"), ("`initial`", "'rest'")),
    # over
    "over unknown": (
        lambda: simulate(duration=1, over={"temprature": [1]}),
        ("temprature", "numeric field", "temperature, "),
    ),
    "over dotted": (
        lambda: simulate(duration=1, over={"dissipation.0.eta": [0.1]}),
        ("dissipation.0.eta", "numeric field"),
    ),
    "over empty": (lambda: simulate(duration=1, over={"c": []}), ("over['c']", "at least one")),
    "over unsorted": (lambda: simulate(duration=1, over={"c": [2, 1]}), ("over['c']", "sorted")),
    "over twice": (lambda: simulate(duration=1, over={"c": [1, 1]}), ("over['c']", "repeated")),
    "over 2-d": (lambda: simulate(duration=1, over={"c": [[1, 2]]}), ("over['c']", "DataArray")),
    "over text": (lambda: simulate(duration=1, over={"c": ["a"]}), ("over['c']", "real numbers")),
    "over complex": (lambda: simulate(duration=1, over={"c": [1j]}), ("over['c']", "real")),
    "over list": (lambda: simulate(duration=1, over=["c"]), ("`over`", "mapping", "['c']")),
    "over dim": (
        lambda: simulate(duration=1, over={"c": xr.DataArray([1, 2], dims="time")}),
        ("over['c']", "'time'", "Rename"),
    ),
    "over sizes": (
        lambda: simulate(
            duration=1,
            over={"c": xr.DataArray([1, 2], dims="k"), "b": xr.DataArray([1, 2, 3], dims="k")},
        ),
        ("over['b']", "length 2", "'k'", "3"),
    ),
    # other verbs
    "every 0": (lambda: rm.poincare_section(BODY, DRIVE, periods=5, every=0), ("`every`", "0")),
    "phase 1": (
        lambda: rm.poincare_section(BODY, DRIVE, periods=5, section_phase=1),
        ("`section_phase`", "[0, 1)"),
    ),
    "section": (
        lambda: rm.poincare_section(BODY, rm.Steps([0], [1]), periods=5),
        ("`drive`", "Steps", "rm.Sine"),
    ),
    "response drive": (
        lambda: rm.frequency_response(BODY, rm.Constant(0.1), [1.0]),
        ("`drive`", "`omega`", "Constant"),
    ),
    "response omega": (
        lambda: rm.frequency_response(BODY, DRIVE, [1.0, 0.5]),
        ("`omega`", "increase"),
    ),
    "response over": (
        lambda: rm.frequency_response(BODY, DRIVE, [1.0], over={"omega": [1]}),
        ("`over`", "omega", "third argument"),
    ),
    "response window": (
        lambda: rm.frequency_response(BODY, DRIVE, [1.0], duration=5, discard=5),
        ("`discard`", "shorter", "5"),
    ),
    "response width": (
        lambda: rm.frequency_response(BODY, DRIVE, [1.0], resonance_width=0),
        ("`resonance_width`", "greater than 0"),
    ),
    "equilibria": (lambda: rm.equilibria(BODY, NAN), ("`m`", "finite", "nan")),
}


@pytest.mark.parametrize("name", CASES)
def test_message_names_field_rule_value_and_remedy(name: str) -> None:
    """InputError, which is a ValueError, with every fragment in its message."""
    call, fragments = CASES[name]
    with pytest.raises(rm.InputError) as caught:
        call()
    message = str(caught.value)
    for fragment in fragments:
        assert fragment in message
    assert re.fullmatch(r"(?s)`.*` must .+; got .+\. .+\.", message)
    assert isinstance(caught.value, ValueError)


@pytest.mark.parametrize("name", ["temperature", "reference_temperature"])
def test_a_temperature_below_100_kelvin_warns(name: str) -> None:
    """It may have been meant in degrees Celsius."""
    with pytest.warns(rm.InputWarning, match=f"`{name}`.*kelvin.*273.15"):
        BODY.replace(**{name: 25.0})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        BODY.replace(**{name: 100.0})


def test_a_grid_too_large_for_memory_is_refused_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """With an estimate, and before anything of its size is allocated."""
    monkeypatch.setattr(np, "full", forbidden)
    with pytest.raises(rm.InputError, match=r"at most .* GiB; got 100000000 trajectories, about"):
        simulate(duration=1, over={"c": np.linspace(1, 2, 10**4), "b": np.linspace(0, 1, 10**4)})


def forbidden(*_: object, **__: object) -> None:
    raise AssertionError("allocated")


@pytest.mark.parametrize(
    "call",
    [
        lambda: simulate(times=np.arange(10.0**6), over={"c": np.linspace(0.1, 1.0, 10**5)}),
        lambda: rm.poincare_section(BODY, DRIVE, periods=2**50),
    ],
    ids=["times", "section"],
)
def test_results_too_large_for_memory_are_refused(call: Callable[[], Any]) -> None:
    """However few trajectories they belong to."""
    with pytest.raises(rm.InputError, match="GiB"):
        call()


@pytest.mark.parametrize("duration", [1e12, 1e300])
@pytest.mark.parametrize("drive", [rm.Constant(0.1), DRIVE, rm.Steps([0, 1], [0, 0.1])])
def test_runs_that_never_end_are_not_begun(drive: Any, duration: float) -> None:
    """Status max-steps, NaN, at once."""
    ds = rm.simulate(BODY, drive, times=[0.0, duration])
    assert int(ds.status) == 7
    assert np.isnan(ds.stretch.values).all()


def test_a_load_that_never_changes_within_the_run_is_not_mistaken() -> None:
    """A period of any length has its beginning; one beyond floating point, a message."""
    ds = rm.simulate(BODY, rm.SineSquared(0.4, 1e-300), duration=10)
    assert int(ds.status) == rm.Status.OK
    np.testing.assert_allclose(ds.thickness_stretch, 1.0, atol=1e-12)
    with pytest.raises(rm.InputError, match=r"finite period.*Constant"):
        rm.simulate(BODY, rm.SineSquared(0.4, 1e-308), duration=10)
    ds = rm.simulate(BODY, DRIVE, duration=10, over={"omega": [1e-308, 1.0]})
    assert ds.status.values.tolist() == [4, 1]


def test_invalid_values_inside_a_sweep_have_a_status() -> None:
    """Every kind of invalid value, one point each; the sound point is computed."""
    values = {
        "c": [1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1e-320],
        "temperature": [300.0, 300.0, NAN, 300.0, 300.0, 300.0, -INF],
        "omega": [1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0],
        "initial.stretch": [1.0, 1.0, 1.0, 1.0, -1.0, 1e200, 1.0],
    }
    over = {name: xr.DataArray(v, dims="case") for name, v in values.items()}
    ds = simulate(duration=2, over=over)
    assert ds.status.values.tolist() == [1, 4, 4, 4, 4, 4, 4]
    assert np.isfinite(ds.stretch.values[0]).all()
    assert np.isnan(ds.thickness_stretch.values[1:]).all()
