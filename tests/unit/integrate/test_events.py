"""Crossings: every one once, at the right time, in the awkward places too."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ellipk

from remanent.integrate.crossings import Crossings
from remanent.integrate.events import find_crossings
from tests.unit.integrate.handmade import SINE, Oscillator, Q, V, problem

HARMONIC = Oscillator(-Q, {})


def of_cosine(value: float, end: float = 50.0) -> Crossings:
    """Crossings of cos tau."""
    found, _ = find_crossings(
        problem(HARMONIC, (1.0, 0.0), end), "position", value, tolerance=1e-10
    )
    return found


@pytest.mark.parametrize("value", [0.0, 0.5, -0.99, 0.999999])
def test_crossings_of_a_cosine(value: float) -> None:
    """Every crossing is found once, at its time, with its direction."""
    found = of_cosine(value)
    angle, turns = np.arccos(value), 2.0 * np.pi * np.arange(9)
    expected = np.sort(np.concatenate([turns + angle, turns - angle]))
    expected = expected[(expected > 0.0) & (expected < 50.0)]
    steepness = np.sqrt(1.0 - value**2)
    np.testing.assert_allclose(found.time, expected, rtol=0.0, atol=1e-10 / steepness)
    assert found.direction.tolist() == np.where(np.sin(expected) > 0.0, -1, 1).tolist()


def test_two_crossings_within_one_step() -> None:
    """cos tau is above 0.99999 for 0.009 only: a small part of any step."""
    found = of_cosine(0.99999)
    assert np.diff(found.time[1:3])[0] == pytest.approx(2.0 * np.arccos(0.99999), rel=1e-4)


@pytest.mark.parametrize("value", [-1.0, -1.0 - 1e-12])
def test_a_touch_is_found_once(value: float) -> None:
    """A touch is one crossing without a direction, also where rounding parts it from the value."""
    found = of_cosine(value)
    np.testing.assert_allclose(found.time, np.pi * np.arange(1, 16, 2), rtol=0.0, atol=1e-5)
    assert not found.direction.any()


def test_a_miss_is_a_miss() -> None:
    """A value a little beyond the extreme is not crossed."""
    assert of_cosine(-1.0 - 1e-9).time.size == 0


def test_a_start_on_the_value_is_no_crossing() -> None:
    """sin tau from 0: the first crossing is at pi, also for a start that moves at once."""
    asked = problem(HARMONIC, [(0.0, 1.0), (0.0, -1.0)], 4.0)
    found, _ = find_crossings(asked, "position", 0.0, tolerance=1e-10)
    np.testing.assert_allclose(found.time, [np.pi, np.pi], rtol=0.0, atol=1e-10)
    assert found.direction.tolist() == [-1, 1]


@pytest.mark.parametrize("speed", [1e-6, 1e-3, 1e-2, 0.3])
def test_what_starts_on_the_value_comes_back_to_it(speed: float) -> None:
    """q'' = -1 from 0 upwards: back at twice the speed, however short a part of a step that is."""
    asked = problem(Oscillator(0.0 * Q - 1.0, {}), [(0.0, speed), (0.0, -speed)], 1.0)
    found, _ = find_crossings(asked, "position", 0.0, tolerance=1e-10)
    assert (found.trajectory.tolist(), found.direction.tolist()) == ([0], [-1])
    np.testing.assert_allclose(found.time, [2.0 * speed], rtol=1e-9)


def test_crossings_at_ends_of_steps_are_found_once() -> None:
    """q'' = 0 passes whole numbers exactly at ends of steps of a load with period 1."""
    asked = problem(Oscillator(0.0 * Q, {}), (-3.0, 1.0), 8.0, period=1.0)
    for value in (-2.0, 0.0, 4.0):
        found, _ = find_crossings(asked, "position", value, tolerance=1e-10)
        np.testing.assert_allclose(found.time, [value + 3.0], rtol=0.0, atol=1e-14)


def test_no_crossing_beyond_the_end() -> None:
    """A crossing after the end of a trajectory, within its last step, is not told."""
    found, _ = find_crossings(problem(HARMONIC, [(1.0, 0.0)] * 3, [1.5, 1.6, 5.0], period=0.7),
                         "position", 0.0, tolerance=1e-10)  # fmt: skip
    assert found.trajectory.tolist() == [1, 2, 2]


def test_runs_that_end_early_in_a_period_of_the_load_have_their_crossings_too() -> None:
    """cos tau under a load of period 20, which is followed in periods where it is long enough."""
    asked = problem(HARMONIC, [(1.0, 0.0)] * 3, [5.0, 1.6, 1.5], period=20.0)
    found, outcome = find_crossings(asked, "position", 0.0, tolerance=1e-10)
    order = np.lexsort((found.time, found.trajectory))
    assert found.trajectory[order].tolist() == [0, 0, 1]
    assert found.direction[order].tolist() == [-1, 1, -1]
    np.testing.assert_allclose(
        found.time[order], np.array([0.5, 1.5, 0.5]) * np.pi, rtol=0.0, atol=1e-10
    )
    assert outcome.horizon.tolist() == [5.0, 1.6, 1.5]


def test_an_observable_may_depend_on_the_load_itself() -> None:
    """q'' = -q + sin 2 pi tau from (1, 0): every zero of q'' by its exact solution, once."""
    asked = problem(Oscillator(-Q + SINE, {}), (1.0, 0.0), 12.0, period=1.0)
    found, _ = find_crossings(asked, "acceleration", 0.0, tolerance=1e-11)
    share = 1.0 / (1.0 - 4.0 * np.pi**2)

    def acceleration(t: np.ndarray) -> np.ndarray:
        turn = 2.0 * np.pi
        swing = turn * share * (turn * np.sin(turn * t) - np.sin(t))
        return np.asarray(-np.cos(t) - swing)

    dense = acceleration(np.linspace(1e-3, 12.0, 20001))
    assert found.time.size == np.count_nonzero(dense[1:] * dense[:-1] < 0.0)
    np.testing.assert_allclose(acceleration(found.time), 0.0, atol=1e-9)
    rate = (acceleration(found.time + 1e-5) - acceleration(found.time - 1e-5)) / 2e-5
    np.testing.assert_allclose(found.rate, rate, rtol=0.0, atol=1e-6)
    assert found.direction.tolist() == np.sign(rate).tolist()


@pytest.mark.parametrize("value", [0.0, 0.3, -0.99, 0.99999])
def test_the_load_alone_passes_a_value_upwards_and_downwards(value: float) -> None:
    """sin 2 pi tau passes a value twice in each period, also where it turns beyond it at once."""
    asked = problem(Oscillator(SINE, {}), (1.0, 0.0), 2.9, period=1.0)
    found, _ = find_crossings(asked, "acceleration", value, tolerance=1e-11)
    first = np.arcsin(value) / (2.0 * np.pi)
    both = np.concatenate([np.arange(-1, 4) + first, np.arange(-1, 4) + 0.5 - first])
    expected = np.sort(both[(both > 0.0) & (both < 2.9)])
    steepness = 2.0 * np.pi * np.sqrt(1.0 - value**2)
    np.testing.assert_allclose(found.time, expected, rtol=0.0, atol=1e-11 / steepness)
    upwards = np.cos(2.0 * np.pi * expected) > 0.0
    assert found.direction.tolist() == np.where(upwards, 1, -1).tolist()


@pytest.mark.parametrize("value", [0.0, 0.3, 0.999, 0.99999999])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
def test_errors_of_times_cover(value: float, tolerance: float) -> None:
    """cos tau: the true error of every time is below the one that is told."""
    asked = problem(HARMONIC, (1.0, 0.0), 50.0)
    found, outcome = find_crossings(asked, "position", value, tolerance=tolerance)
    angle, turns = np.arccos(value), 2.0 * np.pi * np.arange(9)
    exact = np.concatenate([turns + angle, turns - angle, turns])
    nearest = np.abs(found.time[:, None] - exact).min(axis=1)
    assert (nearest <= found.time_error(outcome.error[found.trajectory])).all()


@pytest.mark.parametrize("tolerance", [1e-5, 1e-8])
def test_motion_within_its_error_passes_nothing(tolerance: float) -> None:
    """q'' = -q' - q: passages of 0, every 2 pi/sqrt 3, end where the motion is below its error."""
    asked = problem(Oscillator(-Q - V, {}), (1.0, 0.0), 400.0)
    found, _ = find_crossings(asked, "position", 0.0, tolerance=tolerance)
    spacing = 2.0 * np.pi / np.sqrt(3.0)
    np.testing.assert_allclose(np.diff(found.time[:-2]), spacing, rtol=1e-2)
    last = -2.0 * np.log(tolerance)  # where exp(-tau/2) is the tolerance
    assert abs(found.time[-1] - last) < 2.0 * spacing + 4.0


def test_the_backbone_of_duffings_oscillator() -> None:
    """Half a period from rest at A is 2 K(m)/w, with w^2 = 1 + e A^2 and m = e A^2/(2 w^2)."""
    e, amplitude = 2.0, np.linspace(0.01, 3.0, 16)
    starts = np.column_stack([amplitude, np.zeros(16)])
    duffing = Oscillator(-Q - e * Q**3, {})
    found, outcome = find_crossings(problem(duffing, starts, 4.0), "v", 0.0, tolerance=1e-10)
    _, first = np.unique(found.trajectory, return_index=True)
    w = np.sqrt(1.0 + e * amplitude**2)
    half = 2.0 * ellipk(e * amplitude**2 / (2.0 * w**2)) / w
    steepness = amplitude + e * amplitude**3
    assert (np.abs(found.time[first] - half) <= outcome.error / steepness + 1e-14).all()
