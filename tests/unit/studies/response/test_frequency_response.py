"""Frequency response: windows, resonances, brackets."""

from __future__ import annotations

import numpy as np
import pytest

import remanent as rm

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
    """At least as large as any on the grid; narrower than `resonance_width`."""
    ds = rm.frequency_response(
        rm.Actuator(), DRIVE, np.linspace(0.8, 1.4, 25), over={"temperature": [250.0, 350.0]},
        duration=40.0, resonance_width=1e-4,
    )  # fmt: skip
    assert ds.amplitude.dims == ("temperature", "omega")
    assert (ds.resonance_amplitude >= ds.amplitude.max("omega")).all()
    assert (ds.resonance_error <= 1e-4).all()
    again = rm.frequency_response(
        rm.Actuator(temperature=250.0), DRIVE, [float(ds.resonance[0])], duration=40.0
    )
    assert float(again.amplitude[0]) == float(ds.resonance_amplitude[0])


def test_where_the_bound_is_not_met_there_is_no_amplitude() -> None:
    """NaN, not the extremes of a part of the window."""
    ds = rm.frequency_response(
        rm.Actuator(c=0.05, prestress=2.0),
        rm.Sine(1.5, 1.0),
        [1.0, 2.25, 2.5, 3.5],
        duration=200.0,
        resonance_width=10.0,
    )
    assert ds.status.values.tolist() == [1, 1, 2, 2]
    assert np.isfinite(ds.amplitude.values).tolist() == [True, True, False, False]
