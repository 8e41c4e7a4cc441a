"""Errors of periodic orbits of the actuator, against Newton's method on heyoka's map."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import xarray as xr

import remanent as rm
from benchmarks.errors.period_map import PeriodMap  # needs heyoka
from remanent.studies.orbits.periodic_orbits import _why_errors_are_large

#: Fields of the actuators below that :class:`PeriodMap` takes.
PLAIN = {"c": 1.0, "temperature": 350.0, "prestress": 0.0, "dissipation.0.eta": 0.0}


def judged(found: xr.Dataset, reference: PeriodMap, period: int) -> list[tuple[float, ...]]:
    """Of each orbit: reported and true error of position, multipliers, and extremes."""
    rows: list[tuple[float, ...]] = []
    for k in range(int(found.orbits)):
        one = found.isel(orbit=k)
        exact = reference.orbit(one.initial.values, period)
        assert exact is not None
        pairs = np.abs(one.multipliers.values[:, None] - exact.multipliers)
        off = min(max(pairs[0, 0], pairs[1, 1]), max(pairs[0, 1], pairs[1, 0]))
        low, high = reference.extremes(exact.state, period)
        rows.append(
            (
                float(one.error), float(np.abs(one.initial.values - exact.state).max()),
                float(one.multipliers_error.max()), float(off),
                float(one.minimum_error), abs(float(one.minimum) - low),
                float(one.maximum_error), abs(float(one.maximum) - high),
                float(one.amplitude_error), abs(float(one.amplitude) - 0.5 * (high - low)),
            )
        )  # fmt: skip
    return rows


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-11])
def test_errors_of_damped_orbits_cover(tolerance: float) -> None:
    """Law: Coverage.  Two stable orbits and a saddle; the errors asked for are met."""
    actuator = rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.02))
    drive = rm.SineSquared(0.4, 1.2)
    found = rm.periodic_orbits(actuator, drive, tolerance=tolerance)
    reference = PeriodMap(drive, {**PLAIN, "dissipation.0.eta": 0.02, "b": 0.4, "omega": 1.2})
    assert sorted(found.stability.values) == ["saddle", "stable", "stable"]
    assert int(found.status) == rm.Status.OK
    for row in judged(found, reference, 1):
        reported, true = np.array(row[::2]), np.array(row[1::2])
        assert (true <= reported).all()
        assert reported[0] <= tolerance


def test_a_nearly_parabolic_orbit_is_told_within_its_error() -> None:
    """Law: Coverage.  A saddle of period 3 with multipliers 1.0022 and 1/1.0022."""
    numbers: dict[str, Any] = {"c": 0.398478, "temperature": 350.546, "prestress": -0.087136}
    drive = rm.SineSquared(0.345894, 1.257126)
    found = rm.periodic_orbits(rm.Actuator(**numbers), drive, orbit_period=3)
    k = int(np.flatnonzero(found.stability == "saddle")[0])
    one = found.isel(orbit=k)
    reference = PeriodMap(drive, {**PLAIN, **numbers, "b": 0.345894, "omega": 1.257126})
    exact = reference.orbit(one.initial.values, 3)
    assert exact is not None
    assert exact.multipliers.real.max() == pytest.approx(1.00224, abs=1e-5)
    assert np.abs(one.initial.values - exact.state).max() <= float(one.error) < 1e-6
    # The part through (1 - J)^-1 makes the error larger than asked for, and that is said.
    assert int(found.status) == rm.Status.MAX_STEPS


@pytest.mark.parametrize("tolerance", [1e-9, 1e-12, 1e-13])
def test_the_status_says_whether_the_tolerance_was_met(tolerance: float) -> None:
    """Errors are at most the tolerance where the status is ok, and only there."""
    actuator = rm.Actuator(temperature=350, dissipation=rm.Rayleigh(0.02))
    found = rm.periodic_orbits(actuator, rm.SineSquared(0.4, 1.2), tolerance=tolerance)
    met = float(found.error.max()) <= tolerance
    assert int(found.status) == (rm.Status.OK if met else rm.Status.MAX_STEPS)
    assert ("above the tolerance" in str(found.reason.values)) is not met
    assert float(found.error.max()) < 2e-12


def test_an_error_that_is_not_told_has_a_reason() -> None:
    """An orbit without an error, one above the tolerance, and one that meets it."""
    assert not _why_errors_are_large(np.array([1e-12, 1e-10]), 1e-9)
    words = _why_errors_are_large(np.array([np.nan, 3e-9, 1e-12]), 1e-9)
    assert "1 of 3 orbits is known to 3e-09 at best" in words
    assert "1 of 3 orbits has no error" in words


def test_multipliers_that_underflow_have_an_error() -> None:
    """Law: Coverage.  Over a period of 785 motion with damping 2 forgets where it began."""
    ds = rm.periodic_orbits(rm.Actuator(dissipation=rm.Rayleigh(2.0)), rm.SineSquared(0.4, 0.004))
    assert (np.abs(ds.multipliers.values) <= ds.multipliers_error.values).all()
    assert (ds.multipliers_error.values > 0.0).all()


@pytest.mark.parametrize("eta", [0.0, 0.1])
def test_errors_of_random_orbits_cover(eta: float) -> None:
    """Law: Coverage.  Random actuators, tolerances from 1e-3 to 1e-11."""
    rng = np.random.default_rng(7)
    count = 6
    values = {
        "c": 10.0 ** rng.uniform(-1.0, 0.0, count),
        "temperature": 293.0 * rng.uniform(0.8, 1.3, count),
        "prestress": rng.uniform(-0.5, 1.0, count),
        "b": rng.uniform(0.1, 1.0, count),
        "omega": rng.uniform(0.5, 2.5, count),
    }
    actuator = rm.Actuator(dissipation=rm.Rayleigh(eta) if eta else ())
    drive, tolerance = rm.SineSquared(0.4, 1.0), 10.0 ** rng.uniform(-11.0, -3.0)
    over: Any = {name: xr.DataArray(column, dims="actuator") for name, column in values.items()}
    found = rm.periodic_orbits(actuator, drive, tolerance=tolerance, over=over)
    rows = []
    for a in range(count):
        own = {name: float(column[a]) for name, column in values.items()}
        reference = PeriodMap(drive, {"dissipation.0.eta": eta, **own})
        rows += judged(found.isel(actuator=a), reference, 1)
    table = np.array(rows)
    assert len(table) >= count
    told = np.isfinite(table[:, ::2]).all(axis=1)
    assert told.mean() > 0.9
    assert (table[told, 1::2] <= table[told, ::2]).all()


def test_a_large_orbit_has_the_extremes_that_its_digits_allow() -> None:
    """x'' = -x - d x' + f sin(w t): amplitude f/|1 - w^2 + i d w|, with f = 1e5 near 33 041."""
    force, omega, damping = 1e5, 2.0, 0.2
    linear = rm.LagrangianSystem(
        coordinates="x", kinetic="x_rate**2/2", potential="x**2/2 - load*x",
        dissipation="damping*x_rate**2/2", parameters={"damping": damping},
    )  # fmt: skip
    box = dict.fromkeys(("x", "x_rate"), (-2.0 * force, 2.0 * force))
    found = rm.periodic_orbits(linear, rm.Sine(force, omega), state_box=box)
    exact = force / abs(1.0 - omega**2 + 1j * damping * omega)
    assert found.sizes["orbit"] == 1
    for name, value in (("maximum", exact), ("minimum", -exact), ("amplitude", exact)):
        assert abs(float(found[name][0]) - value) <= float(found[f"{name}_error"][0]) < 1e-5
