"""Labels and indicators of the motions of actuators."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import remanent as rm

DRIVE = rm.SineSquared(0.4, 1.25)
DAMPED = rm.Actuator(dissipation=rm.Rayleigh(0.2))


def test_a_sea_is_chaotic_and_an_island_is_not() -> None:
    """A strong load: the exponent is told with its errors; by the same rules, a torus is not.

    What a single chaotic run shows depends on its rounding; eight of them together do not.
    """
    body = rm.Actuator(c=0.2, prestress=1.0)
    starts = np.array([1.0, *np.linspace(0.99, 1.01, 8)])
    over = {
        "b": xr.DataArray([0.3] + [1.9] * 8, dims="case"),
        "initial.stretch": xr.DataArray(starts, dims="case"),
    }
    found = rm.classify(body, rm.SineSquared(0.4, 1.0), periods=600, over=over)
    torus, sea = found.isel(case=0), found.isel(case=slice(1, None))
    assert found.regime.dims == ("case",)
    assert torus.regime.item() == "quasi-periodic"
    assert set(sea.regime.values.tolist()) <= {"chaotic", "undecided"}
    assert (sea.regime == "chaotic").sum() >= 5
    assert float(sea.exponent.mean()) > 3.0 * float((sea.exponent_error**2).mean() ** 0.5) / 8**0.5
    assert abs(float(torus.zero_one)) < 0.2
    assert float(sea.zero_one.median()) > 0.3
    assert float(torus.digits) > 3.4 > float(sea.digits.median())
    assert (sea.horizon < 600 * sea.drive_period).all()


def test_the_rotation_number_of_small_motion_is_a_ratio_of_frequencies() -> None:
    """omega_n over the load's 2 omega, of an undriven actuator near rest; modulo 1."""
    ds = rm.classify(rm.Actuator(), rm.SineSquared(0.0, 1.7), periods=400, initial=(1.001, 0.0))
    assert ds.regime.item() == "quasi-periodic"
    assert float(ds.rotation_number) == pytest.approx(np.sqrt(6.0) / 3.4, abs=1e-5)


def test_labels_do_not_depend_on_company() -> None:
    """Determinism: alone and among others, equal to the bit."""
    omega = np.linspace(0.8, 2.0, 9)
    body = rm.Actuator(dissipation=rm.Rayleigh(0.02))
    whole = rm.classify(body, DRIVE, periods=150, over={"omega": omega})
    alone = rm.classify(body, DRIVE.replace(omega=omega[4]), periods=150)
    assert {"regime", "exponent"} <= set(alone.data_vars)
    for name in alone.data_vars:
        np.testing.assert_array_equal(whole[name][4], alone[name])


def test_random_frequencies_follow_from_the_seed_alone() -> None:
    """Determinism: None is one seed, a generator is not advanced, and no other number moves."""
    generator = np.random.default_rng(5)
    before = generator.bit_generator.state
    runs = [
        rm.classify(rm.Actuator(), DRIVE, periods=150, rng=rng) for rng in (None, 0, generator, 1)
    ]
    assert generator.bit_generator.state == before
    xr.testing.assert_identical(runs[0], runs[1])
    xr.testing.assert_identical(
        runs[2], rm.classify(rm.Actuator(), DRIVE, periods=150, rng=generator)
    )
    assert len({float(run.zero_one) for run in runs}) == 3
    rest = [run.drop_vars("zero_one") for run in runs]
    assert all(run.equals(rest[0]) for run in rest)


def test_an_invalid_point_does_not_stop_the_rest() -> None:
    """A failure is a status, then NaN, at its own point only."""
    over = {"omega": xr.DataArray([-1.0, 1.25], dims="case")}
    ds = rm.classify(DAMPED, DRIVE, periods=120, over=over)
    assert ds.status.values.tolist() == [4, 1]
    assert np.isnan(ds.exponent[0])
    assert np.isfinite(ds.exponent[1])
    ds = rm.classify(DAMPED, DRIVE, periods=120, over={"omega": xr.DataArray([-1.0], dims="case")})
    assert ds.status.values.tolist() == [4]


def test_bad_arguments_say_what_to_do() -> None:
    """Bad input: the message names the argument that was passed."""
    with pytest.raises(rm.InputError, match="`drive` must have a period"):
        rm.classify(DAMPED, rm.Constant(0.1), periods=200)
    with pytest.raises(rm.InputError, match="at least 100"):
        rm.classify(DAMPED, DRIVE, periods=10)
    with pytest.raises(rm.InputError, match="`rng` must"):
        rm.classify(DAMPED, DRIVE, periods=200, rng=-1)
    with pytest.raises(rm.InputError, match="rng"):
        rm.classify(DAMPED, DRIVE, periods=200, rng=2**53)
    assert rm.classify(DAMPED, DRIVE, periods=200, rng=2**53 - 1).attrs["rng"] == 2**53 - 1
