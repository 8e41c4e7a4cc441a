"""Frequency response: windows, resonances, brackets."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import remanent as rm
from remanent._typing import FloatArray

DRIVE = rm.SineSquared(0.4, 1.0)


def test_amplitude_is_half_the_excursion() -> None:
    """(maximum - minimum)/2, of the thickness stretch, from a dense history."""
    ds = rm.frequency_response(rm.Actuator(), DRIVE, [0.9], duration=30.0)
    history = rm.simulate(
        rm.Actuator(), DRIVE.replace(omega=0.9), times=np.linspace(0.0, 30.0, 6001)
    ).thickness_stretch
    assert float(ds.maximum[0]) == pytest.approx(float(history.max()), abs=1e-5)
    assert float(ds.minimum[0]) == pytest.approx(float(history.min()), abs=1e-5)
    assert float(ds.maximum[0]) >= float(history.max()) - 1e-9
    np.testing.assert_array_equal(ds.amplitude, 0.5 * (ds.maximum - ds.minimum))


def test_discard_shortens_the_window() -> None:
    """Extremes count from `discard` on, its instant included."""
    body = rm.Actuator(dissipation=rm.Rayleigh(0.5))
    ds = rm.frequency_response(body, DRIVE, [0.9], duration=30.0, discard=20.0)
    times = np.linspace(20.0, 30.0, 4001)
    late = rm.simulate(body, DRIVE.replace(omega=0.9), times=times).thickness_stretch
    assert float(ds.maximum[0]) == pytest.approx(float(late.max()), abs=1e-5)
    assert float(ds.minimum[0]) == pytest.approx(float(late.min()), abs=1e-5)


def test_resonance_is_the_largest_of_all_amplitudes() -> None:
    """At least as large as any on the grid; narrower than `resonance_width`.

    Asked for alone, its frequency has that amplitude, but for the error of either.
    """
    ds = rm.frequency_response(
        rm.Actuator(), DRIVE, np.linspace(0.8, 1.4, 25), over={"temperature": [250.0, 350.0]},
        duration=40.0, resonance_width=1e-4, tolerance=1e-8,
    )  # fmt: skip
    assert ds.amplitude.dims == ("temperature", "omega")
    assert (ds.resonance_amplitude >= ds.amplitude.max("omega")).all()
    assert (ds.resonance_error <= 1e-4).all()
    again = rm.frequency_response(
        rm.Actuator(temperature=250.0), DRIVE, [float(ds.resonance[0])],
        duration=40.0, tolerance=1e-8,
    )  # fmt: skip
    difference = abs(float(again.amplitude[0]) - float(ds.resonance_amplitude[0]))
    assert difference <= float(again.amplitude_error[0]) + 1e-8


def test_where_the_bound_is_not_met_there_is_no_amplitude() -> None:
    """NaN, not the extremes of a part of the window."""
    ds = rm.frequency_response(
        rm.Actuator(c=0.05, prestress=2.0),
        rm.Sine(1.5, 1.0),
        [1.0, 2.0, 2.5, 3.5],
        duration=200.0,
        resonance_width=10.0,
    )
    assert ds.status.values.tolist() == [1, 1, 2, 2]
    assert np.isfinite(ds.amplitude.values).tolist() == [True, True, False, False]


@pytest.mark.parametrize(
    ("b", "omega"),
    [(0.0, np.linspace(0.5, 2.0, 7)), (0.4, np.array([1.0])), (0.4, np.linspace(1.3, 1.5, 5))],
)
def test_without_a_peak_inside_there_is_no_resonance(b: float, omega: FloatArray) -> None:
    """Law: a largest amplitude at an end of the range, or of equals, is no resonance."""
    ds = rm.frequency_response(rm.Actuator(), rm.SineSquared(b, 1.0), omega)
    assert np.isnan([float(ds[f"resonance{s}"]) for s in ("", "_error", "_amplitude")]).all()
    assert int(ds.resonance_status) == rm.Status.INCOMPLETE
    assert str(ds.reason.values)


def test_extremes_are_told_with_their_times() -> None:
    """Law: the motion at the time of an extreme is the extreme."""
    body, drive = rm.Actuator(dissipation=rm.Rayleigh(0.1)), rm.SineSquared(0.4, 1.0)
    ds = rm.frequency_response(body, drive, [1.0], discard=20.0).isel(omega=0)
    times = np.sort([float(ds.maximum_time), float(ds.minimum_time)])
    assert (times >= 20.0).all()
    x = rm.simulate(body, drive, times=np.append(0.0, times)).thickness_stretch.values[1:]
    assert sorted(x) == pytest.approx([float(ds.minimum), float(ds.maximum)], abs=1e-8)


def test_runs_that_end_early_in_a_slow_period() -> None:
    """Law: m = (b omega tau)^2 for omega -> 0, and the motion follows it: 2.6667e-8 at 1e-5.

    The amplitude falls with the square of the frequency.
    """
    omega = np.array([1e-12, 1e-7, 1e-6, 1e-5, 1e-3, 1.0])
    ds = rm.frequency_response(rm.Actuator(), rm.SineSquared(0.4, 1.0), omega)
    assert (ds.status == rm.Status.OK).all()
    np.testing.assert_allclose(ds.amplitude[1:4], 266.667 * omega[1:4] ** 2, rtol=1e-3)
    slow = rm.simulate(
        rm.Actuator(), rm.SineSquared(0.4, 1e-5, phase=1.0), times=[0.0, 50.0, 100.0]
    )

    def rates(t: float, y: FloatArray) -> list[float]:
        x, v = y
        force = x**8 - x**2 + (0.4 * np.sin(1e-5 * t + 1.0)) ** 2 * x**4
        return [v, (6.0 * v * v - 3.0 * force) / (x**7 + 2.0 * x)]

    way = solve_ivp(
        rates, (0.0, 100.0), [1.0, 0.0], "DOP853", [50.0, 100.0], rtol=1e-11, atol=1e-11
    )
    np.testing.assert_allclose(slow.stretch[1:], way.y[0], atol=1e-7)
    times = rm.crossings(
        rm.Actuator(), rm.SineSquared(0.4, 1.0, phase=1.0), "thickness_stretch", 1.02,
        duration=20.0, over={"omega": [1e-9, 1e-5, 1.0]},
    ).crossing_time  # fmt: skip
    constant = rm.crossings(
        rm.Actuator(), rm.Constant((0.4 * np.sin(1.0)) ** 2), "thickness_stretch", 1.02,
        duration=20.0,
    ).crossing_time  # fmt: skip
    np.testing.assert_allclose(times[0], constant, atol=1e-6)


def test_what_is_left_of_the_window_is_asked_of_valid_points_only() -> None:
    """Invariant: an invalid point beside others is a status, however short its run would be."""
    ds = rm.frequency_response(
        rm.Actuator(), rm.SineSquared(0.4, 1.0), [-5.0, 0.5], periods=10, discard=15.0
    )
    assert ds.status.values.tolist() == [rm.Status.INVALID, rm.Status.OK]
