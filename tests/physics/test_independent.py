"""Our states and bounds against an independent engine, at random parameters.

Laws: Coverage, Independent engines.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import remanent as rm
from remanent._typing import BoolArray, FloatArray
from remanent.models.drives.base import Drive
from tests.physics.independent import DRIVES, Case, corners, dop853, random_case


@dataclass(frozen=True)
class Comparison:
    """Largest differences from the reference, bounds, and the reference's own error."""

    true: FloatArray
    reported: FloatArray
    reference: FloatArray
    ok: BoolArray

    @property
    def covered(self) -> BoolArray:
        return np.asarray(self.true <= self.reported + self.reference)[self.ok]

    @property
    def looseness(self) -> FloatArray:
        """Reported over true error, where the reference is good enough to tell."""
        good = self.ok & (self.reference < 0.1 * self.reported)
        return np.asarray(self.reported[good] / np.maximum(self.true[good], 1e-300))


def simulated(case: Case, times: FloatArray, tolerance: float) -> xr.Dataset:
    values = {"c": case.c, "temperature": 300.0 * case.theta, "prestress": case.prestress}
    over = {name: xr.DataArray(v, dims="case") for name, v in values.items()}
    actuator = rm.Actuator(temperature=300.0, reference_temperature=300.0)
    return rm.simulate(actuator, case.drive, times=times, over=over, tolerance=tolerance)


def compared(case: Case, times: FloatArray, tolerance: float) -> Comparison:
    ds = simulated(case, times, tolerance)
    ours = np.stack([ds.stretch.values, ds.stretch_rate.values], axis=-1)
    good, rough = (dop853(case, times, rtol) for rtol in (3e-14, 1e-12))
    largest = [np.nanmax(np.abs(a - good), axis=(1, 2)) for a in (ours, rough)]
    return Comparison(largest[0], ds.error.values, largest[1], ds.status.values == 1)


def gathered(count: int, duration: float, seed: int, decades: tuple[int, ...]) -> Comparison:
    times = np.linspace(0.0, duration, 41)
    parts = [
        compared(random_case(kind, decade, count, duration, seed), times, 1e-9)
        for kind in DRIVES
        for decade in decades
    ]
    names = ("true", "reported", "reference", "ok")
    return Comparison(*(np.concatenate([getattr(p, n) for p in parts]) for n in names))


def test_states_agree_with_dop853() -> None:
    """Every difference is within our bound and the reference's own error."""
    found = gathered(count=3, duration=6.0, seed=1, decades=(-2, -1))
    assert found.ok.sum() >= 36
    assert found.covered.all()
    assert np.median(found.looseness) <= 100.0


@pytest.mark.slow
def test_bounds_cover_the_error_of_hundreds_of_trajectories() -> None:
    """At least 99.5 % are covered, and the median bound is within 100 times the error."""
    found = gathered(count=24, duration=40.0, seed=2, decades=(-3, -2, -1))
    assert found.ok.sum() >= 400
    assert found.covered.mean() >= 0.995
    assert np.median(found.looseness) <= 100.0


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-11])
def test_bounds_hold_at_every_tolerance(tolerance: float) -> None:
    """Asked for three digits or for eleven, the reported error is above the true one."""
    times = np.linspace(0.0, 10.0, 21)
    for kind in (rm.Constant, rm.SineSquared, rm.Ramp):
        found = compared(random_case(kind, -1, 6, 10.0, seed=3), times, tolerance)
        assert found.covered.all()
        assert (found.reported[found.ok] <= tolerance).all()


def extremes(case: Case, end: float) -> tuple[FloatArray, FloatArray]:
    """Largest and smallest thickness stretch of single cases, by event detection."""
    found = []
    for k in range(case.c.size):
        one = Case(case.c[k : k + 1], case.theta[k : k + 1], case.prestress[k : k + 1], case.drive)

        def rates(t: float, y: FloatArray, one: Case = one) -> list[float]:
            return [y[1], float(one.acceleration(float(one.drive(t)), y[0], y[1])[0])]

        def turns(_t: float, y: FloatArray) -> float:
            return float(y[1])

        path = solve_ivp(
            rates, (0.0, end), [1.0, 0.0], method="DOP853", rtol=1e-13, atol=1e-15, events=turns
        )
        assert path.y_events is not None
        seen = np.concatenate([path.y_events[0][:, 0], path.y[0, [0, -1]]]) ** -2.0
        found.append((seen.max(), seen.min()))
    high, low = np.array(found).T
    return high, low


@pytest.mark.parametrize("decade", [-2, -1])
@pytest.mark.parametrize("kind", [rm.SineSquared, rm.Sine])
def test_extremes_agree_with_event_detection(kind: type[Drive], decade: int) -> None:
    """Maximum and minimum between steps are within ``amplitude_error``."""
    case = random_case(kind, decade, 4, 15.0, seed=4)
    high, low = extremes(case, 15.0)
    for k in range(4):
        actuator = rm.Actuator(
            c=case.c[k],
            temperature=300.0 * case.theta[k],
            reference_temperature=300.0,
            prestress=case.prestress[k],
        )
        omega = case.drive.parameter_values()["omega"]
        ds = rm.frequency_response(actuator, case.drive, [omega], duration=15.0).squeeze()
        if int(ds.status) != 1:
            continue
        bound = float(ds.amplitude_error) + 1e-11 * max(1.0, high[k])
        assert abs(float(ds.maximum) - high[k]) <= bound
        assert abs(float(ds.minimum) - low[k]) <= bound


@pytest.mark.slow
def test_states_agree_with_taylor_series() -> None:
    """heyoka in extended precision: every trajectory of a few dozen is covered."""
    heyoka = pytest.importorskip("heyoka")
    x, v = heyoka.make_vars("x", "v")
    c, theta, s, m0, m1, w, angle = (heyoka.par[i] for i in range(7))
    force = theta * (x - x**-5.0) - s + (m0 + m1 * heyoka.sin(w * heyoka.time + angle)) * x**-3.0
    rate = (6.0 * c * x**-7.0 * v * v - 3.0 * force) / (1.0 + 2.0 * c * x**-6.0)
    engine = heyoka.taylor_adaptive([(x, v), (v, rate)], [1.0, 0.0], tol=1e-17)
    times = np.linspace(0.0, 60.0, 61)
    for decade in (-3, -2, -1):
        case = random_case(rm.Sine, decade, 12, 60.0, seed=5)
        ds = simulated(case, times, 1e-9)
        p = case.drive.parameter_values()
        assert (ds.status.values == 1).all()
        for k in range(ds.status.size):
            engine.time, engine.state[:] = 0.0, [1.0, 0.0]
            numbers = [case.c[k], case.theta[k], case.prestress[k]]
            engine.pars[:] = [*numbers, p["mean"], p["m"], p["omega"], p["phase"]]
            states = np.asarray(engine.propagate_grid(times)[-1])
            ours = np.stack([ds.stretch.values[k], ds.stretch_rate.values[k]], axis=-1)
            assert np.abs(ours - states).max() <= 1e-8  # ten times the tolerance


def test_the_reference_knows_where_loads_have_corners() -> None:
    """The independent engine stops at jumps, kinks and the end of a sweep."""
    assert corners(rm.Steps([0.0, 2.0, 5.0], [1.0, 2.0, 3.0]), 4.0) == [0.0, 2.0, 4.0]
    assert corners(rm.Chirp(1.0, 1.0, 2.0, 3.0), 4.0) == [0.0, 3.0, 4.0]
    assert corners(rm.Sine(1.0, 1.0), 4.0) == [0.0, 4.0]
