"""Steps, ramps and samples: what holds between their entries, and what they refuse."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent._errors import InputError
from remanent.models.drives.piecewise import Ramp, Sampled, Steps

TAU = np.linspace(0.0, 6.0, 61)


def test_steps_hold_from_their_time_on() -> None:
    """A load holds from its time, that instant included, to the next."""
    drive = Steps([0.0, 1.0, 3.0], [0.1, 0.2, 0.3])
    assert drive([0.0, 0.999, 1.0, 2.9, 3.0, 100.0]).tolist() == [0.1, 0.1, 0.2, 0.2, 0.3, 0.3]


def test_steps_are_cut_at_the_end_of_the_run() -> None:
    """Pieces end with the run; those after its end have no length."""
    line = Steps([0.0, 1.0, 3.0], [0.1, 0.2, 0.3]).load_schedule({}, np.array([2.5, 0.5]))
    assert line.piece_lengths.tolist() == [[1.0, 0.5], [1.5, 0.0]]
    assert line.piece_parameters["piece.0"][:, 0].tolist() == [0.1, 0.2]


def test_ramp_is_straight_and_then_held() -> None:
    """A ramp is linear between its entries, and constant after the last."""
    drive = Ramp([0.0, 2.0, 3.0], [0.0, 1.0, -1.0])
    expected = np.interp(TAU, [0.0, 2.0, 3.0], [0.0, 1.0, -1.0])
    np.testing.assert_allclose(drive(TAU), expected, atol=1e-15)


def test_samples_of_a_cubic_give_the_cubic() -> None:
    """Interpolation is exact for a cubic."""
    times = np.array([0.0, 1.0, 2.5, 4.0, 6.0])
    drive = Sampled(times, times**3 - 2.0 * times)
    np.testing.assert_allclose(drive(TAU), np.asarray(TAU**3 - 2.0 * TAU), atol=1e-12)


def test_samples_are_met() -> None:
    """The interpolation passes through its samples."""
    times, loads = np.arange(6.0), np.array([0.1, -0.3, 0.2, 0.9, 0.0, 0.4])
    np.testing.assert_allclose(Sampled(times, loads)(times), loads, atol=1e-15)


def test_samples_do_not_reach_beyond_the_last() -> None:
    """Samples are not extrapolated, neither in a value nor in a run."""
    drive = Sampled([0.0, 1.0, 2.0], [0.0, 1.0, 0.0])
    with pytest.raises(InputError, match="`tau` must not go beyond the last entry"):
        drive(2.1)
    with pytest.raises(InputError, match="`duration` must not go beyond the last entry"):
        drive.load_schedule({}, np.array([2.1]))
    assert drive.load_schedule({}, np.array([2.0])).piece_lengths.tolist() == [[1.0], [1.0]]


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


@pytest.mark.parametrize("exponent", [-300, 7, 301])
@pytest.mark.parametrize("count", [2, 3, 4, 9])
def test_a_spline_knows_no_unit_of_time(exponent: int, count: int) -> None:
    """Time in units of another power of 2 changes no digit of the load, and warns of nothing."""
    times, loads = np.linspace(0.0, 3.0, count), np.sin(np.arange(count))
    between = np.linspace(0.0, 3.0, 17)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        other = Sampled(np.ldexp(times, exponent), loads)
    np.testing.assert_array_equal(
        other(np.ldexp(between, exponent)), Sampled(times, loads)(between)
    )


@pytest.mark.parametrize("kind", [Steps, Ramp, Sampled])
@pytest.mark.parametrize(("times", "loads", "message"), TABLE)
def test_tables_are_checked(kind: Any, times: Any, loads: Any, message: str) -> None:
    """The message names the column, and says what it must be."""
    with pytest.raises(InputError, match=message):
        kind(times, loads)


def test_one_sample_is_too_few() -> None:
    """One sample defines no interpolation."""
    with pytest.raises(InputError, match="`times` must have at least 2 entries; got 1"):
        Sampled([0.0], [1.0])


def test_a_spline_that_swings_beyond_its_samples_warns() -> None:
    """Law: a jump within a short time makes a spline of evenly spaced others swing."""
    with pytest.warns(rm.InputWarning, match="beyond them"):
        Sampled([0, 1, 2, 3 - 1e-8, 3 + 1e-8, 4, 5, 6], [0, 0, 0, 0, 0.3, 0.3, 0.3, 0.3])


@pytest.mark.parametrize("kind", [Steps, Ramp, Sampled])
def test_tables_begin_at_zero(kind: type[Steps]) -> None:
    """Law: a table says nothing of times before its first."""
    with pytest.raises(rm.InputError, match="before 0"):
        kind([0.0, 1.0, 2.0, 3.0], [0.0, 1.0, 0.0, 1.0])(-1.0)


def test_a_record_with_summed_times_runs_to_its_end() -> None:
    """Law: a run may be as long as the multiple that the times were summed up to."""
    times = np.cumsum(np.append(0.0, np.full(111, 0.1)))
    assert times[-1] < 111 * 0.1
    drive = Sampled(times, np.sin(times))
    run = rm.simulate(rm.Actuator(), drive, duration=111 * 0.1)
    assert int(run.status) == rm.Status.OK
    assert np.isfinite(run.thickness_stretch).all()


@pytest.mark.parametrize(
    ("loads", "multiples", "period"),
    [
        ([0.1, 0.1], [0.5, 1.5], 2.0 * np.pi),
        ([0.1, 0.0], [2, 3], 0.5 * np.pi),
        ([0.1, 0.1], [1, 1 / 3], 3.0 * np.pi),
    ],
)
def test_sums_of_sines_repeat_after_their_period(
    loads: list[float], multiples: list[float], period: float
) -> None:
    """Law: m(tau + T) = m(tau), for the smallest T."""
    drive = rm.Sines(loads, multiples, 2.0)
    assert drive.period is not None
    assert drive.period == pytest.approx(period)
    times = np.linspace(0.0, 9.0, 19)
    np.testing.assert_allclose(drive(times + drive.period), drive(times), atol=1e-14)
    run = rm.simulate(rm.Actuator(), drive, times=times)
    np.testing.assert_allclose(run["load"], drive(times), atol=1e-14)
