"""What every verb's result becomes in other units: in SI, and at another temperature.

A block of 110 kPa, 2100 kg/m³ and 150 mT is built as such, or as one of other sizes whose sizes
are then varied: all dimensionless numbers differ, and everything in SI is the same.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from tests.repetitions import fast_and_slow

HOT = 350.0
#: Sizes that the block has, over those that the second one was built with.
RATIOS = {"shear_modulus": 1.1, "density": 1.05, "remanence": 1.2}
#: Settings and variables that compare dimensionless states.
OF_STATES = frozenset({"error", "local_error", "residual", "tolerance", "balance"})


def block(**parts: Any) -> rm.Actuator:
    """The block itself, with viscosities in SI."""
    return rm.Actuator.from_si(
        shear_modulus="110 kPa", density="2100 kg/m^3", half_length="5 mm",
        half_thickness="2 mm", force="0.4 N", remanence="150 mT", **parts,
    )  # fmt: skip


def same_block(**parts: Any) -> rm.Actuator:
    """One of smaller sizes, that are then made those of the block."""
    modulus, density, remanence = (1.0 / RATIOS[name] for name in RATIOS)
    built = rm.Actuator.from_si(
        shear_modulus=f"{110 * modulus!r} kPa", density=f"{2100 * density!r} kg/m^3",
        half_length="5 mm", half_thickness="2 mm", force="0.4 N",
        remanence=f"{150 * remanence!r} mT", **parts,
    )  # fmt: skip
    for name, ratio in RATIOS.items():
        built = built.with_parameter(name, ratio)
    return built


def damped(make: Callable[..., rm.Actuator]) -> rm.Actuator:
    eta = make().viscosity("14 Pa s")
    return make(dissipation=rm.Rayleigh(float(eta)))


def drive(a: rm.Actuator) -> rm.SineSquared:
    return rm.SineSquared(float(a.load("140 mT")) ** 0.5, float(a.frequency("270 Hz")))


def tau(a: rm.Actuator, text: str) -> float:
    return float(a.time(text))


def frequencies(a: rm.Actuator, *hertz: int) -> Any:
    return np.array([a.frequency(f"{f} Hz") for f in hertz])


def history(a: rm.Actuator) -> xr.Dataset:
    """A record of thickness and rate, with a little of a wave that no model has."""
    times = np.array([a.time(f"{t} ms") for t in np.linspace(0.0, 6.0, 40)])
    run = rm.simulate(a, drive(a), times=times)[["thickness_stretch", "thickness_stretch_rate"]]
    wave = 0.01 * np.sin(np.arange(40.0))
    return run.assign(
        thickness_stretch=run.thickness_stretch + wave,
        thickness_stretch_error=("time", np.full(40, 0.01)),
        thickness_stretch_rate_error=("time", np.full(40, 3.0 / tau(a, "1 s"))),
    )


STILL, LOSSY = "free", "damped"
#: Every verb whose numbers have units, and whether its block loses energy.
VERBS: dict[str, tuple[Callable[[rm.Actuator], xr.Dataset], str]] = {
    "simulate": (lambda a: rm.simulate(a, drive(a), duration=tau(a, "5 ms")), LOSSY),
    "poincare_section": (lambda a: rm.poincare_section(a, drive(a), periods=3), LOSSY),
    "crossings": (
        lambda a: rm.crossings(
            a, drive(a), "stretch_rate", 20.0 / tau(a, "1 s"),
            duration=tau(a, "5 ms"),
        ), LOSSY,
    ),
    "energy_balance": (
        lambda a: rm.energy_balance(a, drive(a), duration=tau(a, "5 ms")), LOSSY,
    ),
    "cycle_losses": (lambda a: rm.cycle_losses(a, drive(a), periods=2), LOSSY),
    "frequency_response": (
        lambda a: rm.frequency_response(
            a, drive(a), frequencies(a, 300, 350, 400, 450, 500), duration=tau(a, "20 ms"),
            discard=tau(a, "2 ms"), resonance_width=float(a.frequency("0.01 Hz")),
        ), LOSSY,
    ),
    "equilibria": (
        lambda a: rm.equilibria(a, over={"m": [0.0, float(a.load("60 mT"))]}), STILL,
    ),
    "snap_through": (
        lambda a: rm.snap_through(a.replace(prestress=float(a.stress("240 kPa"))), "m",
                                  (0.0, float(a.load("3 T")))), STILL,
    ),
    "backbone": (lambda a: rm.backbone(a, [1.1, 1.2]), STILL),
    "shape_commands": (lambda a: rm.shape_commands(a, 0.8), STILL),
    "step_response": (
        lambda a: rm.step_response(
            a, rm.Constant(float(a.load("100 mT"))), duration=tau(a, "20 ms")
        ), LOSSY,
    ),
    "periodic_orbits": (lambda a: rm.periodic_orbits(a, drive(a)), LOSSY),
    "lyapunov": (lambda a: rm.lyapunov(a, drive(a), periods=100), LOSSY),
    "logarithmic_decrement": (
        lambda a: rm.logarithmic_decrement(
            rm.simulate(a, rm.Constant(0.0), duration=tau(a, "15 ms"), initial=(1.05, 0.0))
        ), LOSSY,
    ),
    "fit": (
        lambda a: rm.fit(a, drive(a), history(a), ["dissipation.0.eta", "b", "prestress"],
                         tolerance=1e-11), LOSSY,
    ),
    "sensitivity": (
        lambda a: rm.sensitivity(
            rm.simulate, a, drive(a), times=[tau(a, "3 ms")], of="thickness_stretch_rate",
            parameters=["b", "c", "temperature", "dissipation.0.eta"],
        ), LOSSY,
    ),
    "design": (
        lambda a: rm.design(
            rm.Measure(rm.equilibria, a, 0.0, of="equilibrium_potential"),
            -0.5e3 / float(a.in_unit(1.0, "Pa")), {"prestress": float(a.stress("20 kPa"))},
        ), STILL,
    ),
    "uncertainty": (
        lambda a: rm.uncertainty(
            rm.simulate, a, drive(a), times=[tau(a, "3 ms")], of="energy",
            parameter_ranges={"c": (0.1, 0.2)}, samples=64, quantiles=(0.25, 0.5, 0.75),
        ), LOSSY,
    ),
}  # fmt: skip
#: Those that are tried each time.
QUICK = ("simulate", "equilibria", "fit", "sensitivity", "uncertainty", "periodic_orbits")
every = pytest.mark.parametrize("name", fast_and_slow(list(VERBS), QUICK))


@cache
def result(name: str, make: Callable[..., rm.Actuator] = block) -> xr.Dataset:
    verb, kind = VERBS[name]
    return verb(make() if kind == STILL else damped(make))


def numbers(ds: xr.Dataset) -> dict[str, Any]:
    """Every number of a result by its name, attributes among them."""
    settings = {
        str(name): np.asarray(value)
        for name, value in ds.attrs.items()
        if np.asarray(value).dtype.kind == "f"
    }
    variables = {str(k): v.values for k, v in ds.variables.items() if v.dtype.kind in "fc"}
    return settings | variables


def stated(name: str) -> bool:
    """Whether a number is an error or compares dimensionless states."""
    return name in OF_STATES or name.endswith("_error")


@every
def test_what_a_result_is_in_si_does_not_depend_on_the_units_within(name: str) -> None:
    """Law: Reversal and scaling.  The same block in other units: other numbers, the same in SI."""
    one, other = (rm.to_si(result(name, make)) for make in (block, same_block))
    ours, theirs = numbers(one), numbers(other)
    assert set(ours) == set(theirs)
    differ = numbers(result(name, same_block))
    compared = 0
    for key, values in ours.items():
        # The first tangents of a mean growth have a direction in the units within.
        if key == "exponent_history" or (stated(key) and key != "estimate_error"):
            continue
        atol = 2e-6 * np.nanmax(np.abs(values), initial=1e-30)
        if key == "exponent":  # statistical
            atol = float(one.exponent_error)
        np.testing.assert_allclose(theirs[key], values, rtol=2e-5, atol=atol, err_msg=key)
        compared += not np.allclose(differ[key], numbers(result(name))[key], rtol=1e-3)
    assert compared  # numbers that were different before
    for label, variable in one.variables.items():
        assert variable.attrs.get("units") == other[label].attrs.get("units")


@every
def test_another_temperature_and_back_changes_nothing(name: str) -> None:
    """Law: Reversal and scaling.  Every number of every result, attributes too."""
    start = result(name)
    there = rm.rescale(start, temperature=HOT)
    back = rm.rescale(there, temperature=293.0)
    before, after = numbers(start), numbers(back)
    assert set(before) == set(after)
    for key, values in before.items():
        if key not in OF_STATES:
            np.testing.assert_allclose(after[key], values, rtol=1e-12, atol=1e-300, err_msg=key)
    for attribute in ("system", "drive"):
        if attribute in start.attrs:
            ours, theirs = (rm_numbers(ds.attrs[attribute]) for ds in (start, back))
            np.testing.assert_allclose(theirs, ours, rtol=1e-12)
    assert rm.read_system(there).parameter_values()["temperature"] == HOT


def rm_numbers(text: str) -> list[float]:
    """Every number in plain data."""
    found: list[float] = []

    def walk(content: Any) -> None:
        if isinstance(content, dict):
            for item in content.values():
                walk(item)
        elif isinstance(content, list):
            for item in content:
                walk(item)
        elif isinstance(content, int | float):
            found.append(float(content))

    walk(json.loads(text))
    return found


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["simulate", "frequency_response", "fit", "sensitivity", "design", "uncertainty"]
)
def test_a_rescaled_result_is_that_of_the_rescaled_system(name: str) -> None:
    """Law: Reversal and scaling.  The verb itself at the other temperature."""
    verb, kind = VERBS[name]
    hot = rm.read_system(rm.rescale(result("simulate"), temperature=HOT))
    assert isinstance(hot, rm.Actuator)
    assert hot.scales is not None
    # What the hot block moves under are loads, times and stresses of a softer one, by the ratio.
    softer = replace(hot.scales, shear_modulus=hot.scales.shear_modulus * 293.0 / HOT)
    body = hot.replace(scales=softer, **({"dissipation": ()} if kind == STILL else {}))
    cold = rm.rescale(result(name), temperature=HOT)
    ours, theirs = numbers(cold), numbers(verb(body))
    for key in ours.keys() & theirs.keys():
        if not stated(key):
            scale = np.nanmax(np.abs(ours[key]), initial=1e-30)
            np.testing.assert_allclose(
                theirs[key], ours[key], rtol=2e-5, atol=2e-6 * scale, err_msg=key
            )


def test_measures_of_functions_are_refused_with_the_reason() -> None:
    """What a function makes of a result has no unit that could be known."""
    ds = rm.sensitivity(
        rm.equilibria, block(), 0.1, parameters="c",
        of=lambda found: found.natural_frequency.isel(equilibrium=0),
    )  # fmt: skip
    for change in (rm.to_si, lambda ds: rm.rescale(ds, temperature=HOT)):
        with pytest.raises(rm.InputError, match="what quantity a function gives"):
            change(ds)


def test_ranges_that_would_change_are_refused() -> None:
    """Statistics over a range of viscosities are of other viscosities at another temperature."""
    ds = rm.uncertainty(
        rm.equilibria, block(), 0.1, of="natural_frequency", samples=32,
        parameter_ranges={"prestress": (0.1, 0.2)}, quantiles=(0.25, 0.5, 0.75),
    )  # fmt: skip
    with pytest.raises(rm.InputError, match="over prestress"):
        rm.rescale(ds, temperature=HOT)


def test_labels_say_the_unit_of_each_entry() -> None:
    """Rates of an orbit are in 1/s beside stretches; estimates have their own units."""
    orbit = rm.to_si(result("periodic_orbits"))
    plain = result("periodic_orbits")
    assert orbit.state_unit.values.tolist() == ["1", "s-1"]
    speed = 1.0 / float(block().in_unit(1.0, "s"))
    np.testing.assert_allclose(orbit.initial[:, 1], plain.initial[:, 1] * speed, rtol=1e-14)
    assert orbit.initial.attrs["units"] == "mixed"
    fit = rm.to_si(result("fit"))
    assert fit.parameter_unit.values.tolist() == ["Pa s", "mT", "kPa"]


def test_a_load_that_is_a_square_has_errors_of_its_own() -> None:
    """B = b² B₁: its error is 2 b δb B₁, and its elasticity half that by b."""
    fit, inside = rm.to_si(result("fit")), result("fit")
    one = float(block().in_unit(1.0, "mT"))
    b, error = float(inside.estimate[1]), float(inside.estimate_error[1])
    assert float(fit.estimate[1]) == pytest.approx(b**2 * one, rel=1e-12)
    assert float(fit.estimate_error[1]) == pytest.approx(2.0 * b * error * one, rel=1e-12)
    variance = float(fit.covariance[1, 1])
    assert variance == pytest.approx(float(fit.estimate_error[1]) ** 2, rel=1e-12)
    slopes, by_b = rm.to_si(result("sensitivity")), result("sensitivity")
    np.testing.assert_allclose(slopes.elasticity[0], 0.5 * by_b.elasticity[0], rtol=1e-14)
    product = slopes.derivative[0] * drive(block()).b ** 2 * one / slopes.value
    np.testing.assert_allclose(slopes.elasticity[0], product, rtol=1e-10)


def test_lengths_are_those_of_the_block() -> None:
    """2 L λ and 2 H λ₃ in mm, so that l² h is the block's volume at all times."""
    run = rm.to_si(result("simulate"), lengths=True)
    assert run.stretch.attrs["units"] == run.thickness_stretch.attrs["units"] == "mm"
    np.testing.assert_allclose(run.stretch**2 * run.thickness_stretch, 10.0 * 10.0 * 4.0, rtol=1e-8)
    assert (run.stretch.attrs["symbol"], run.stretch.attrs["long_name"]) == ("l", "edge")


def test_names_say_what_a_variable_now_is() -> None:
    """No root of a load is in mT, and no omega in Hz, wherever it stands."""
    swept = rm.to_si(rm.periodic_orbits(damped(block), drive(block()), over={"b": [0.3, 0.4]}))
    assert swept.b.attrs["long_name"] == "peak flux density"
    for name in QUICK:
        for key, variable in rm.to_si(result(name)).variables.items():
            attrs = variable.attrs
            if attrs.get("units") == "mT":
                assert "load" not in attrs["long_name"], (name, key)
                assert not attrs["symbol"].startswith(("b", "m")), (name, key)
            if attrs.get("units") == "Hz":
                assert "omega" not in attrs["symbol"], (name, key)
            if attrs.get("units") == "ms":
                assert "tau" not in attrs["symbol"], (name, key)
