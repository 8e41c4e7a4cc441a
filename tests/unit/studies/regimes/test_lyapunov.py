"""Exponents of actuators that are known."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from remanent.studies.ensemble.checks import DriveArgument
from remanent.studies.regimes._exponent_estimator import with_total_error

DRIVE = rm.SineSquared(0.4, 1.25)
DAMPED = rm.Actuator(dissipation=rm.Rayleigh(0.2))


def test_exponents_of_an_undamped_actuator_are_a_pair() -> None:
    """Their sum is what M(start)/M(end) leaves over, and tends to 0 as the run grows."""
    ds = rm.lyapunov(rm.Actuator(), rm.SineSquared(2.0, 0.85), periods=400, count=2)
    assert ds.exponent.dims == ("exponent_number",)
    length = 0.9 * 400 * float(ds.drive_period)
    assert abs(float(ds.exponent.sum())) < np.log(3.0) / length
    assert ds.exponent_history.dims == ("period", "exponent_number")


def test_exponents_at_rest_are_those_of_the_equilibrium() -> None:
    """A load of nothing: -3 eta/(2 M) and the pair's real part; M = 3 at c = 1."""
    eta = 0.2
    ds = rm.lyapunov(
        rm.Actuator(dissipation=rm.Rayleigh(eta)), rm.SineSquared(0.0, 1.0), periods=400, count=2
    )
    exact = -3.0 * eta / (2.0 * 3.0)
    np.testing.assert_allclose(ds.exponent, exact, atol=3e-3)
    assert float(ds.exponent.mean()) == pytest.approx(exact, abs=1e-8)


def test_an_overdamped_equilibrium_has_two_exponents() -> None:
    """M s^2 + 3 eta s + 18 = 0 at rest, with real roots: 1 % and better."""
    eta = 8.0
    body = rm.Actuator(dissipation=rm.Rayleigh(eta))
    ds = rm.lyapunov(body, rm.SineSquared(0.0, 2.0), periods=200, count=2)
    np.testing.assert_allclose(ds.exponent, np.sort(np.roots([3.0, 3.0 * eta, 18.0]))[::-1],
                               rtol=1e-6)  # fmt: skip


def test_one_exponent_at_rest_is_known_although_the_state_needs_no_steps() -> None:
    """The state stands still at any step; the tangent, judged where steps matter, does not."""
    eta = 8.0
    body = rm.Actuator(dissipation=rm.Rayleigh(eta))
    ds = rm.lyapunov(body, rm.SineSquared(0.0, 2.0), periods=400)
    exact = float(np.roots([3.0, 3.0 * eta, 18.0]).max())
    assert abs(float(ds.exponent) - exact) <= float(ds.exponent_error) + 1e-12
    assert float(ds.exponent_error) < 1e-6


def test_an_invalid_point_does_not_stop_the_rest() -> None:
    """A failure is a status, then NaN, at its own point only."""
    over = {"omega": xr.DataArray([-1.0, 1.25], dims="case")}
    ds = rm.lyapunov(DAMPED, DRIVE, periods=120, over=over)
    assert ds.status.values.tolist() == [4, 1]
    assert np.isnan(ds.exponent[0])
    assert np.isfinite(ds.exponent[1])


def test_bad_arguments_say_what_to_do() -> None:
    """Bad input: the message names the argument that was passed."""
    with pytest.raises(rm.InputError, match="`periods`"):
        rm.lyapunov(DAMPED, DRIVE, periods=0)
    with pytest.raises(rm.InputError, match="at most 2"):
        rm.lyapunov(DAMPED, DRIVE, periods=10, count=3)


def test_the_error_of_a_mean_on_a_torus_is_a_bound() -> None:
    """Law: exponents of undamped tori are 0, within the error every time, not 68 % of them."""
    rng = np.random.default_rng(4)
    over = {
        "c": xr.DataArray(10.0 ** rng.uniform(-1.0, 0.0, 40), dims="case"),
        "b": xr.DataArray(rng.uniform(0.1, 0.6, 40), dims="case"),
    }
    ds = rm.lyapunov(rm.Actuator(), DRIVE, periods=200, over=over, tolerance=1e-6)
    assert bool((np.abs(ds.exponent) <= ds.exponent_error).all())
    assert float((ds.exponent_error / np.abs(ds.exponent)).median()) < 100.0


def test_errors_of_chaos_add_in_squares() -> None:
    """Law: independent chances add in squares, and chaos has no growth in proportion to time.

    What is not seen to be chaos keeps the sum of all three, as a bound.
    """
    unknown = {"of_orbit": np.full((2, 1), np.nan), "of_orbit_error": np.full((2, 1), np.nan)}
    found = with_total_error(
        {
            "exponent": np.array([[0.5], [0.01]]),
            "scatter": np.full((2, 1), 0.03),
            "difference": np.full((2, 1), 0.04),
            "finite_time": np.full((2, 1), 0.01),
            "status": np.full(2, int(rm.Status.OK)),
            **unknown,
        }
    )
    np.testing.assert_allclose(found["exponent_error"][:, 0], [0.05, 0.08])


@pytest.mark.parametrize(
    "loads", [{"push": rm.Constant(0.3)}, rm.Loads({"push": rm.Constant(0.3)})]
)
def test_constant_loads_by_name_have_exponents_over_a_duration(loads: DriveArgument) -> None:
    """x' = -x + push has the exponent -1, whatever its constant load is called."""
    linear = rm.FirstOrderSystem(rates={"x": "-x + push"}, loads=("push",))
    ds = rm.lyapunov(linear, loads, duration=40.0)
    assert float(ds.exponent) == pytest.approx(-1.0, abs=1e-8)
    assert ds.exponent_history.dims == ("time",)
    assert float(ds.time[-1]) == 40.0
    with pytest.raises(rm.InputError, match="be left out where the load changes"):
        rm.lyapunov(linear, {"push": rm.Sine(0.1, 1.0)}, duration=40.0)


@pytest.mark.parametrize("count", [1, 2, 3, 4])
def test_memory_is_asked_for_all_factors_of_the_tangents(count: int) -> None:
    """Law: k exponents take k^2 numbers of 8 bytes in each period of both runs, at least."""
    with pytest.raises(rm.InputError, match="about") as refusal:
        rm.lyapunov(rm.Actuator(prestress=(0.1, 0.1)), DRIVE, periods=2**40, count=count)
    needed = float(str(refusal.value).split("about ")[1].split()[0])
    least = 2 * 8 * count**2 * 2**40 / 2**30
    assert least <= needed <= 2 * least
