"""Exponents of motion that ends on a periodic orbit, and of motion that does not."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import remanent as rm


def test_exponents_of_settled_motion_are_those_of_the_orbit() -> None:
    """Exponents times the period are the logarithms of the multipliers, within errors.

    Started on the orbit or from rest; complex multipliers turn the tangent, in step with any
    batches that one could lay.
    """
    body = rm.Actuator(
        c=0.112145, temperature=274.4384, prestress=0.571685, dissipation=rm.Rayleigh(0.01735)
    )
    drive = rm.SineSquared(0.543787, 2.187299)
    orbit = rm.periodic_orbits(body, drive)
    exact = float(np.log(np.abs(orbit.multipliers[0])).max()) / (np.pi / 2.187299)
    assert exact == pytest.approx(-0.02316278, abs=1e-8)
    for start, periods in ((orbit.initial.values[0], 100), (None, 400)):
        ds = rm.lyapunov(body, drive, periods=periods, initial=start)
        assert int(ds.settled_period) == 1
        assert abs(float(ds.exponent) - exact) <= float(ds.exponent_error) + 1e-9
        assert float(ds.exponent_error) < 1e-8
    early = rm.lyapunov(body, drive, periods=100)
    assert abs(float(early.exponent) - exact) <= 3.0 * float(early.exponent_error)


def test_strong_contraction_is_no_minus_infinity() -> None:
    """A slow load: differences shrink by e^-157 in every period; the exponent is a number.

    Linear about rest: s^2 + 2 s + 6 = 0 has the real part -1, and the load is small.
    """
    body, drive = rm.Actuator(dissipation=rm.Rayleigh(2.0)), rm.SineSquared(0.05, 0.02)
    label = rm.classify(body, drive, periods=100)
    mean = rm.lyapunov(body, drive, periods=100)
    assert float(label.exponent) == pytest.approx(-0.999, abs=1e-3)
    error = float(label.exponent_error + mean.exponent_error)
    assert abs(float(label.exponent - mean.exponent)) <= error
    assert error < 1e-6


def test_a_contraction_beyond_all_numbers_is_incomplete() -> None:
    """e^-1570 within a period: nothing is left of a difference, and the status says so."""
    body, drive = rm.Actuator(dissipation=rm.Rayleigh(2.0)), rm.SineSquared(0.05, 0.002)
    ds = rm.lyapunov(body, drive, periods=40)
    assert int(ds.status) == rm.Status.INCOMPLETE
    label = rm.classify(body, drive, periods=100)
    assert str(label.regime.values) == "periodic"
    for found in (ds, label):
        assert np.isnan(found.exponent)
        assert "shrink within one period" in str(found.reason.values)
    known = rm.lyapunov(body, drive, periods=20, over={"omega": [0.002, 1.0]})
    assert [bool(reason) for reason in known.reason.values] == [True, False]


def test_exponents_about_rest_for_random_bodies() -> None:
    """A load of nothing: real parts of (1 + 2c) s^2 + 3 eta s + 18 theta = 0, within errors."""
    rng = np.random.default_rng(5)
    count = 40
    c, eta = 10.0 ** rng.uniform(-2.0, 0.0, count), 10.0 ** rng.uniform(-1.3, 1.0, count)
    theta, omega = rng.uniform(0.8, 1.3, count), rng.uniform(0.3, 3.0, count)
    over = {"c": c, "dissipation.0.eta": eta, "temperature": 293.0 * theta, "omega": omega}
    ds = rm.lyapunov(
        rm.Actuator(dissipation=rm.Rayleigh(0.1)), rm.SineSquared(0.0, 1.0), periods=200, count=2,
        over={name: xr.DataArray(values, dims="case") for name, values in over.items()},
    )  # fmt: skip
    for k in range(count):
        exact = np.sort(np.roots([1.0 + 2.0 * c[k], 3.0 * eta[k], 18.0 * theta[k]]).real)[::-1]
        assert (abs(ds.exponent[k] - exact) <= ds.exponent_error[k] + 1e-12).all(), k


def test_mean_exponents_of_regular_motion_cover_zero() -> None:
    """Undamped tori have exponent 0: covered by one standard error for 68 % and more."""
    rng = np.random.default_rng(7)
    over = {
        "b": xr.DataArray(rng.uniform(0.1, 0.6, 32), dims="case"),
        "omega": xr.DataArray(rng.uniform(1.6, 2.5, 32), dims="case"),
    }
    ds = rm.lyapunov(rm.Actuator(), rm.SineSquared(0.4, 1.25), periods=150, over=over)
    covered = np.abs(ds.exponent) <= ds.exponent_error
    assert float(covered.mean()) >= 0.68


def test_the_transverse_exponent_is_half_the_damping() -> None:
    """A difference whose multipliers are complex decays at 3 eta/2, whatever the load does."""
    body = rm.Actuator(c=1.0, temperature=320.0, dissipation=rm.Rayleigh(0.02))
    drive = rm.SineSquared(1.2, 2.4)
    start = rm.periodic_orbits(body, drive).initial.values[0]
    ds = rm.symmetry_check(body, drive, initial=start)
    assert int(ds.settled_period) == 1
    assert abs(float(ds.transverse_exponent) + 0.03) <= float(ds.transverse_exponent_error)
    assert float(ds.transverse_exponent_error) < 1e-7
    product = np.prod(ds.transverse_multipliers.values)
    assert abs(product - np.exp(-0.06 * np.pi / 2.4)) <= 3.0 * ds.transverse_multipliers_error.max()
    from_rest = rm.symmetry_check(body, drive)
    off = abs(float(from_rest.transverse_exponent) + 0.03)
    assert off <= 3.0 * float(from_rest.transverse_exponent_error)


def test_the_seed_is_told_and_makes_the_result_again() -> None:
    """Equal seeds, equal numbers: the attribute `rng` may be passed as `rng`."""
    drive = rm.SineSquared(0.4, 1.25)
    ds = rm.classify(rm.Actuator(), drive, periods=100, rng=np.random.default_rng(3))
    again = rm.classify(rm.Actuator(), drive, periods=100, rng=ds.attrs["rng"])
    xr.testing.assert_identical(ds, again)
