"""What is put into synthetic measurements is found in them, within the errors stated."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from scipy.io import savemat
from scipy.stats import binom

import remanent as rm
from remanent.studies.inference.fit import _admissible_range

TRUE = rm.Actuator(dissipation=rm.Rayleigh(0.2), prestress=0.2)
GUESS = rm.Actuator(dissipation=rm.Rayleigh(0.1), prestress=0.2)
TIMES = np.linspace(0.0, 10.0, 60)
STEP = rm.Constant(0.3)


def record(sigma: float, seed: int = 0) -> xr.Dataset:
    run = rm.simulate(TRUE, STEP, times=TIMES)[["thickness_stretch"]]
    return run + np.random.default_rng(seed).normal(0.0, sigma, TIMES.size)


def test_without_noise_the_truth_is_found() -> None:
    """To the accuracy of the motion, from a guess half as large."""
    found = rm.fit(GUESS, STEP, record(0.0), {"dissipation.0.eta": 0.1, "prestress": 0.25})
    np.testing.assert_allclose(found.estimate, [0.2, 0.2], atol=1e-7)
    assert float(found.noise) < 1e-7


def test_with_noise_it_is_within_three_standard_errors() -> None:
    """And the noise is found too; the profile agrees with the standard error here."""
    found = rm.fit(GUESS, STEP, record(0.003), ["dissipation.0.eta", "m"], profile=True)
    assert (abs(found.estimate - [0.2, 0.3]) < 3.0 * found.estimate_error).all()
    assert float(found.noise) == pytest.approx(0.003, rel=0.3)
    np.testing.assert_allclose(found.profile_interval, found.interval, rtol=0.05)


@pytest.mark.slow
def test_intervals_of_fits_cover_the_truth() -> None:
    """100 seeds: 95 % intervals of both parameters hold it within binomial bounds."""
    inside = np.zeros(2, dtype=int)
    for seed in range(100):
        found = rm.fit(GUESS, STEP, record(0.01, seed), ["dissipation.0.eta", "shear_modulus"])
        low, high = found.interval.values.T
        inside += (low < [0.2, 1.0]) & (high > [0.2, 1.0])
    low, high = binom.interval(0.9999, 100, 0.95)
    assert ((inside >= low) & (inside <= high)).all(), inside


def test_a_response_gives_damping_and_field() -> None:
    """Amplitudes in a window, with known deviations."""
    drive, omega = rm.SineSquared(0.4, 1.0), np.linspace(0.9, 1.5, 15)
    sweep = rm.frequency_response(TRUE, drive, omega, duration=60, discard=30)[["amplitude"]]
    rng = np.random.default_rng(5)
    measured = (sweep + rng.normal(0, 0.002, 15)).assign(amplitude_error=("omega", [0.002] * 15))
    found = rm.fit(
        GUESS, drive.replace(b=0.45), measured, ["dissipation.0.eta", "b"], duration=60, discard=30
    )
    assert (abs(found.estimate - [0.2, 0.4]) < 3.0 * found.estimate_error).all()
    assert float(found.chi_square) < 40.0


def sizes(shear_modulus: str, remanence: str, eta: float) -> rm.Actuator:
    return rm.Actuator.from_si(
        shear_modulus=shear_modulus, density="2000 kg/m^3", half_length="5 mm",
        half_thickness="5 mm", remanence=remanence, force="3 N",
        dissipation=rm.Rayleigh(eta),
    )  # fmt: skip


@pytest.mark.parametrize("kind", ["csv", "mat", "frame"])
def test_physical_sizes_from_files_with_units(kind: str, tmp_path: Path) -> None:
    """A block of 110 kPa and 150 mT, measured in ms and 1/s, fitted from 100 kPa and 143 mT.

    A table drive, whose times and loads are those of the laboratory.
    """
    true, guess = sizes("110 kPa", "150 mT", 0.2), sizes("100 kPa", "143 mT", 0.2 * 1.1**0.5)
    field, switch = "300 mT", "3 ms"

    def drive(block: rm.Actuator) -> rm.Steps:
        return rm.Steps([0.0, float(block.time(switch))], [0.0, float(block.load(field))])

    assert true.scales is not None
    run = rm.to_si(rm.simulate(true, drive(true), duration=12.0))
    columns = {
        "time [ms]": run.time.values,
        "thickness stretch": run.thickness_stretch.values,
        "speed [1/s]": run.thickness_stretch_rate.values,
    }
    names = {"speed": "thickness_stretch_rate"}
    if kind == "csv":
        pd.DataFrame(columns).to_csv(tmp_path / "run.csv", index=False)
        data = rm.read_measurements(tmp_path / "run.csv", guess, names=names)
    elif kind == "mat":
        plain = dict(zip(("time", "thickness_stretch", "speed"), columns.values(), strict=True))
        savemat(tmp_path / "run.mat", plain)
        units = {"time": "ms", "thickness_stretch_rate": "1/s"}
        data = rm.read_measurements(tmp_path / "run.mat", guess, names=names, units=units)
    else:
        data = rm.read_measurements(pd.DataFrame(columns), guess, names=names)
    found = rm.fit(guess, drive(guess), data, ["shear_modulus", "remanence"])
    np.testing.assert_allclose(found.estimate, [1.1, 150.0 / 143.0], rtol=1e-6)


def test_bad_data_are_refused() -> None:
    """The message says what is too few, unknown, or outside of its range."""
    short = rm.read_measurements({"time": [0.0, 1.0], "stretch": [1.0, 1.0]})
    with pytest.raises(rm.InputError, match="more than 2"):
        rm.fit(GUESS, STEP, short, ["dissipation.0.eta", "m"])
    with pytest.raises(rm.InputError, match="field"):
        rm.fit(GUESS, STEP, record(0.0), ["viscosity"])
    with pytest.raises(rm.InputError, match="guess"):
        rm.fit(GUESS, STEP, record(0.0), ["m"], parameter_ranges={"m": (0.4, 0.5)})


def test_a_fit_gives_its_system_and_its_drive_back() -> None:
    """The motion of what it gives back is the fitted one; the guess stays beside it."""
    found = rm.fit(GUESS, STEP, record(0.01), ["dissipation.0.eta", "m", "shear_modulus"])
    body, drive = rm.read_system(found), rm.read_drive(found)
    run = rm.simulate(body, drive, times=found.time.values)
    np.testing.assert_allclose(run.thickness_stretch, found.predicted, atol=1e-8)
    assert found.guess.values.tolist() == [0.1, STEP.m, 1.0]
    assert int(found.status) == rm.Status.OK


def test_a_fit_hands_its_covariance_on() -> None:
    """Of a prediction: J C J', its derivatives J by the parameters, to first order."""
    names = ["dissipation.0.eta", "m"]
    found = rm.fit(GUESS, STEP, record(0.01), names)
    body, drive = rm.read_system(found), rm.read_drive(found)
    asked: dict[str, Any] = {"times": [2.0, 6.0], "of": "thickness_stretch"}
    spread = rm.uncertainty(rm.simulate, body, drive, fit=found, **asked)
    slopes = rm.sensitivity(rm.simulate, body, drive, parameters=names, **asked).derivative.values
    expected = np.sqrt(np.einsum("it,ij,jt->t", slopes, found.covariance.values, slopes))
    np.testing.assert_allclose(spread.deviation, expected, rtol=0.02)
    with pytest.raises(rm.InputError, match="depend on each other"):
        rm.uncertainty(rm.simulate, body, drive, fit=found, sobol=True, **asked)
    with pytest.raises(rm.InputError, match="again"):
        rm.uncertainty(
            rm.simulate, body, drive, fit=found, parameter_ranges={"m": (0.1, 0.2)}, **asked
        )
    with pytest.raises(rm.InputError, match=r"a result of rm\.fit"):
        rm.uncertainty(rm.simulate, body, drive, fit=spread, **asked)


@pytest.mark.parametrize("load", [0.1, 0.5, 1.5])
def test_steps_beyond_the_range_of_the_model_are_taken_back(load: float) -> None:
    """A Gent solid whose limiting extension is tried below what the motion reaches."""
    body = rm.Actuator(material=rm.Gent(3.0), dissipation=rm.Rayleigh(0.1))
    run = rm.simulate(body, rm.Constant(0.9), times=np.linspace(0.0, 10.0, 40))
    data = run[["thickness_stretch"]]
    guess = body.replace(material=rm.Gent(5.0))
    found = rm.fit(guess, rm.Constant(load), data, ["material.jm", "m"])
    np.testing.assert_allclose(found.estimate, [3.0, 0.9], rtol=1e-6)


#: Fields with rules of every kind: any number, above 0, at least 0, from 0 to 1.
WITH_RULES = (
    rm.Actuator(dissipation=(rm.Rayleigh(0.1), rm.Zener(0.5, 1.0)), heat=rm.Heat(exchange=0.1)),
    rm.Actuator(material=rm.Gent(50.0)),
    rm.SineSquared(0.4, 1.25),
)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_a_search_goes_as_far_as_the_rule_of_a_field_and_no_farther(scale: float) -> None:
    """The rule holds on the range and, where that ends, not beyond the end."""
    kinds = set()
    for part in WITH_RULES:
        for rule in part.parameter_rules().values():
            lower, upper = _admissible_range(rule, scale)
            kinds.add((lower, upper))
            beyond = 1e-5 * scale
            for end, outwards in ((lower, -1.0), (upper, 1.0)):
                is_open = bool(np.isinf(end))
                inside = outwards * 1e5 * scale if is_open else end
                assert rule.is_satisfied_by(inside)
                assert is_open or not rule.is_satisfied_by(end + outwards * beyond)
    assert len(kinds) == 4
    assert _admissible_range(None, scale) == (-np.inf, np.inf)
