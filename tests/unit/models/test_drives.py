"""Each drive's own law, and what it refuses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from remanent._errors import InputError
from remanent.models.drives.chirp import Chirp
from remanent.models.drives.piecewise import Ramp, Sampled, Steps
from remanent.models.drives.waves import Constant, Sine, SineSquared

TAU = np.linspace(0.0, 6.0, 61)


def test_laws() -> None:
    np.testing.assert_array_equal(Constant(0.2)(TAU), 0.2)
    np.testing.assert_allclose(SineSquared(0.4, 1.25)(TAU), (0.4 * np.sin(1.25 * TAU)) ** 2)
    np.testing.assert_allclose(Sine(0.4, 1.2, 0.1, 0.3)(TAU), 0.1 + 0.4 * np.sin(1.2 * TAU + 0.3))


def test_periods_are_those_of_the_load() -> None:
    """pi/omega for the square of the sine, 2 pi/omega for the sine."""
    assert SineSquared(0.4, 2.0).period == pytest.approx(np.pi / 2.0)
    assert Sine(0.4, 2.0).period == pytest.approx(np.pi)
    assert Constant(0.1).period is None


def test_steps_hold_from_their_time_on() -> None:
    drive = Steps([0.0, 1.0, 3.0], [0.1, 0.2, 0.3])
    assert drive([0.0, 0.999, 1.0, 2.9, 3.0, 100.0]).tolist() == [0.1, 0.1, 0.2, 0.2, 0.3, 0.3]


def test_steps_are_cut_at_the_end_of_the_run() -> None:
    line = Steps([0.0, 1.0, 3.0], [0.1, 0.2, 0.3]).timeline({}, np.array([2.5, 0.5]))
    assert line.lengths.tolist() == [[1.0, 0.5], [1.5, 0.0]]
    assert line.parameters["piece.0"][:, 0].tolist() == [0.1, 0.2]


def test_ramp_is_straight_and_then_held() -> None:
    drive = Ramp([0.0, 2.0, 3.0], [0.0, 1.0, -1.0])
    expected = np.interp(TAU, [0.0, 2.0, 3.0], [0.0, 1.0, -1.0])
    np.testing.assert_allclose(drive(TAU), expected, atol=1e-15)


def test_samples_of_a_cubic_give_the_cubic() -> None:
    times = np.array([0.0, 1.0, 2.5, 4.0, 6.0])
    drive = Sampled(times, times**3 - 2.0 * times)
    np.testing.assert_allclose(drive(TAU), np.asarray(TAU**3 - 2.0 * TAU), atol=1e-12)


def test_samples_are_met() -> None:
    times, loads = np.arange(6.0), np.array([0.1, -0.3, 0.2, 0.9, 0.0, 0.4])
    np.testing.assert_allclose(Sampled(times, loads)(times), loads, atol=1e-15)


def test_samples_do_not_reach_beyond_the_last() -> None:
    drive = Sampled([0.0, 1.0, 2.0], [0.0, 1.0, 0.0])
    with pytest.raises(InputError, match="`tau` must not go beyond the last entry"):
        drive(2.1)
    with pytest.raises(InputError, match="`duration` must not go beyond the last entry"):
        drive.timeline({}, np.array([2.1]))
    assert drive.timeline({}, np.array([2.0])).lengths.tolist() == [[1.0], [1.0]]


def test_chirp_sweeps_the_frequency() -> None:
    """Its angle has the slope start at 0, stop at the end of the sweep and after it."""
    drive = Chirp(1.0, 0.5, 2.0, 4.0)
    swept = 0.5 * TAU + 1.5 * TAU**2 / 8.0
    held = 0.5 * 4.0 + 1.5 * 2.0 + 2.0 * (TAU - 4.0)
    np.testing.assert_allclose(drive(TAU), np.sin(np.where(TAU < 4.0, swept, held)), atol=1e-15)


TABLE = [
    ([0.0, 2.0, 1.0], [1.0, 2.0, 3.0], "`times` must increase"),
    ([0.0, 1.0, 1.0], [1.0, 2.0, 3.0], "`times` must increase"),
    ([1.0, 2.0], [1.0, 2.0], "`times` must start at 0"),
    ([], [], "`times` must be a sequence of finite numbers"),
    ([0.0, np.nan], [1.0, 2.0], "`times` must be a sequence of finite numbers"),
    ([0.0, 1.0], [1.0, np.inf], "`loads` must be a sequence of finite numbers"),
    ([0.0, 1.0], [1.0], "`loads` must have as many entries as `times`, 2; got 1"),
    (0.0, 1.0, "`times` must be a sequence of finite numbers"),
    ("ab", [1.0, 2.0], "`times` must be a sequence of finite numbers"),
    ([0.0, 10**400], [1.0, 2.0], "`times` must be a sequence of finite numbers"),
    ([[0.0, 1.0]], [[1.0, 2.0]], "`times` must be a sequence of finite numbers"),
]


@pytest.mark.parametrize("kind", [Steps, Ramp, Sampled])
@pytest.mark.parametrize(("times", "loads", "message"), TABLE)
def test_tables_are_checked(kind: Any, times: Any, loads: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        kind(times, loads)


def test_one_sample_is_too_few() -> None:
    with pytest.raises(InputError, match="`times` must have at least 2 entries; got 1"):
        Sampled([0.0], [1.0])


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: SineSquared(0.4, 0.0), "`omega` must be a finite number greater than 0; got 0.0"),
        (lambda: Sine(0.4, -1.0), "`omega` must be a finite number greater than 0; got -1.0"),
        (lambda: Chirp(0.1, -1.0, 1.0, 1.0), "`start` must be a finite number, at least 0"),
        (lambda: Chirp(0.1, 1.0, 1.0, 0.0), "`duration` must be a finite number greater than 0"),
    ],
)
def test_frequencies_are_checked(make: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()
