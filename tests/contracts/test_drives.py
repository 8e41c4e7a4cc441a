"""What every drive must satisfy; a new one joins by its example."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.codegen import reference
from remanent.codegen.field import vector_field_for
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.drives.chirp import Chirp
from remanent.models.drives.piecewise import Sampled, Steps
from remanent.models.drives.sines import Sines
from tests.contracts.public import examples

DRIVES: dict[str, Drive] = {
    # Several loads at once have their own laws, in tests/unit/models/drives/test_loads.py.
    **{name: one for name, one in examples(Drive).items() if name != "Loads"},  # type: ignore[type-abstract]
    "even harmonics": Sines([0.2, -0.1], [2, 4], 0.7),
    "two frequencies": Sines([0.2, 0.1], [1.0, 2.0**0.5], 0.9, phases=[0.0, 0.4], mean=-0.1),
    "one step": Steps((0.0,), (0.1,)),
    "falling chirp": Chirp(0.2, 3.0, 0.0, 20.0),
    "two samples": Sampled([0.0, 10.0], [1.0, 2.0]),
}
PERIODIC = {name: drive for name, drive in DRIVES.items() if drive.period is not None}
DURATION = 8.0

every = pytest.mark.parametrize("drive", DRIVES.values(), ids=DRIVES.keys())
periodic = pytest.mark.parametrize("drive", PERIODIC.values(), ids=PERIODIC.keys())


def through_load_schedule(
    drive: Drive, values: dict[str, FloatArray], duration: FloatArray, *, law: str = "load"
) -> tuple[FloatArray, FloatArray]:
    """Times and loads, or their rates, (sample, trajectory), as the numeric column meets them.

    In pieces without length both are NaN: no trajectory is ever there.
    """
    line = drive.load_schedule(values, duration)
    times, loads = [], []
    starts = np.cumsum(line.piece_lengths, axis=0) - line.piece_lengths
    for piece, (start, length) in enumerate(zip(starts, line.piece_lengths, strict=True)):
        own = {k: np.broadcast_to(v, duration.shape) for k, v in drive.parameter_values().items()}
        p = own | values | {name: rows[piece] for name, rows in line.piece_parameters.items()}
        for s in np.linspace(0.0, 0.999, 23):
            u = dict(zip(drive.waveform_names, line.waveforms_at_phase(np.asarray(s)), strict=True))
            times.append(np.where(length > 0.0, start + s * length, np.nan))
            loads.append(np.where(length > 0.0, getattr(drive, law)(p, u, s, np), np.nan))
    return np.array(times), np.array(loads)


@every
def test_load_along_the_load_schedule_is_the_load_in_time(drive: Drive) -> None:
    """The pieces and phases of a load schedule carry the load that the drive has at that time."""
    times, loads = through_load_schedule(drive, {}, np.array([DURATION]))
    np.testing.assert_allclose(loads, drive(times), rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("name", [name for name, one in DRIVES.items() if one.has_load_rate])
def test_the_rate_of_a_load_is_its_slope_in_time(name: str) -> None:
    """dm/dtau, in closed form in the equations of motion, against a central difference."""
    drive, half = DRIVES[name], 1e-5
    times, rates = through_load_schedule(drive, {}, np.array([DURATION]), law="load_rate")
    within = np.arange(len(times)) % 23 > 0  # at the ends of pieces a load may bend
    slope = (drive(times + half) - drive(times - half)) / (2.0 * half)
    np.testing.assert_allclose(rates[within], slope[within], rtol=1e-7, atol=1e-8)


@every
def test_a_drive_has_a_rate_where_it_writes_one(drive: Drive) -> None:
    """A rate that is written and not told of would never be used."""
    assert np.isfinite(drive(0.5))
    assert drive.has_load_rate == (type(drive).load_rate is not Drive.load_rate)


@every
def test_each_of_a_batch_of_parameters_gives_its_own_load(drive: Drive) -> None:
    """Every member of a batch has the load of a drive with its parameters alone."""
    factors = np.array([1.0, 1.1, 1.3])
    values = {name: value * factors for name, value in drive.parameter_values().items()}
    duration = np.array([DURATION, 3.0, 0.5])
    times, loads = through_load_schedule(drive, values, duration)
    for i in range(3):
        single = drive.replace(**{name: array[i] for name, array in values.items()})
        met = np.isfinite(times[:, i])
        assert np.any(met)
        np.testing.assert_allclose(loads[met, i], single(times[met, i]), rtol=0.0, atol=1e-12)


@every
def test_pieces_cover_the_run_exactly(drive: Drive) -> None:
    """Pieces have no negative length and add up to the run; those of a periodic drive are
    periods."""
    duration = np.array([DURATION, 3.0, 0.5])
    line = drive.load_schedule({}, duration)
    assert line.periodic == (drive.period is not None)
    assert line.piece_lengths.shape[1:] == (3,)
    assert np.all(line.piece_lengths >= 0.0)
    if line.periodic:
        assert line.piece_lengths.tolist() == [[drive.period] * 3]
    else:
        np.testing.assert_allclose(line.piece_lengths.sum(axis=0), duration, rtol=1e-15)
        assert np.all(line.piece_lengths.max(axis=1) > 0.0)
    assert set(line.piece_parameters) == set(drive.piece_parameter_names)
    assert all(rows.shape == line.piece_lengths.shape for rows in line.piece_parameters.values())


@every
def test_waveforms_keep_the_shape_of_the_phase(drive: Drive) -> None:
    """Waveforms of an array of phases are arrays of its shape, one for each waveform."""
    line = drive.load_schedule({}, np.array([DURATION]))
    for shape in ((), (5,), (2, 3)):
        assert line.waveforms_at_phase(np.zeros(shape)).shape == (len(drive.waveform_names), *shape)


@every
def test_waveforms_as_data_are_those_of_the_schedule(drive: Drive) -> None:
    """What a waveform is said to be is what it is, at every phase before the end.

    A drive need not say it; `rm.export` refuses it then.
    """
    if not drive.waveforms:
        return
    line = drive.load_schedule({}, np.array([DURATION]))
    phases = np.linspace(0.0, 0.999, 23)
    said = [
        getattr(np, one.function)(one.span * np.mod(one.repeats * phases, 1.0))
        for one in drive.waveforms
    ]
    assert len(said) == len(drive.waveform_names)
    np.testing.assert_allclose(said, line.waveforms_at_phase(phases), rtol=0.0, atol=1e-14)


@every
def test_the_last_piece_begins_at_the_last_change(drive: Drive) -> None:
    """A run that goes on beyond it has as many pieces as a longer one; of periods there is one."""
    end = min(drive.last_change + 1.0, drive.known_until)
    later = min(2.0 * drive.last_change + 50.0, drive.known_until)
    counts = [len(drive.load_schedule({}, np.array([x])).piece_lengths) for x in (end, later)]
    assert counts[0] == counts[1]
    if drive.last_change > 0.0:
        before = drive.load_schedule({}, np.array([drive.last_change]))
        assert len(before.piece_lengths) == counts[0] - 1


@periodic
def test_the_period_is_inversely_proportional_to_its_field(drive: Drive) -> None:
    """Twice the frequency is half the period."""
    name = drive.period_field_name
    assert name is not None
    faster = drive.replace(**{name: 2.0 * drive.parameter_values()[name]})
    assert period_of(faster) == pytest.approx(0.5 * period_of(drive), rel=1e-15)


@every
def test_field_reports_the_load(drive: Drive) -> None:
    """The observable `load` of a compiled field is the load of the drive."""
    actuator = Actuator()
    field = vector_field_for(actuator, drive)
    line = drive.load_schedule({}, np.array([DURATION]))
    hidden = {name: rows[0, 0] for name, rows in line.piece_parameters.items()}
    values = {**actuator.parameter_values(), **drive.parameter_values(), **hidden}
    assert list(values) == list(field.parameter_names)
    phase = 0.37
    seen = reference.evaluate_observables(
        field,
        phase,
        np.array([[1.0, 0.0]]),
        np.array([list(values.values())]),
        line.waveforms_at_phase(np.asarray(phase)),
    )
    assert seen["load"][0] == pytest.approx(
        float(drive(phase * line.piece_lengths[0, 0])), abs=1e-14
    )


@periodic
def test_period_is_a_period(drive: Drive) -> None:
    """The load repeats itself after one period."""
    times = np.linspace(0.0, 5.0, 101)
    np.testing.assert_allclose(drive(times + period_of(drive)), drive(times), atol=1e-14)


@periodic
@pytest.mark.parametrize("parts", [2, 3, 4, 5, 6, 7])
def test_period_is_the_smallest(drive: Drive, parts: int) -> None:
    """No n-th part of the period is a period too, for n up to 7."""
    times = np.linspace(0.0, 5.0, 101)
    assert np.max(np.abs(drive(times + period_of(drive) / parts) - drive(times))) > 1e-2


@periodic
def test_periods_of_a_batch(drive: Drive) -> None:
    """Periods of many frequencies are those of the single drives."""
    omega = np.array([0.5, 2.0])
    expected = [drive.replace(omega=w).period for w in omega]
    periods = drive.periods({"omega": omega})
    assert periods is not None
    assert periods.tolist() == expected


def period_of(drive: Drive) -> float:
    assert drive.period is not None
    return drive.period


@every
def test_drives_are_values(drive: Drive) -> None:
    """Equal drives have equal hashes; other numbers make another drive of the same structure."""
    assert drive.replace() == drive
    assert hash(drive.replace()) == hash(drive)
    changed = drive.replace(**changes(drive))
    assert changed != drive
    assert changed.equation_structure() == drive.equation_structure()


@every
def test_structure_holds_no_number(drive: Drive) -> None:
    """The structure, by which equations are cached, does not depend on numbers."""
    other = drive.replace(
        **{name: value + 0.125 for name, value in drive.parameter_values().items()}
    )
    assert other.equation_structure() == drive.equation_structure()


@every
def test_unknown_fields_are_refused(drive: Drive) -> None:
    """A field that the drive does not have is refused by its name."""
    with pytest.raises(InputError, match="`amplitude` must be a field of"):
        drive.replace(amplitude=1.0)


@every
@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, "1", None, True, [1.0], 1j])
def test_every_number_is_checked(drive: Drive, bad: Any) -> None:
    """Whatever is not a finite number is refused, in each parameter, by its name."""
    assert drive.parameter_values() or drive.piece_parameter_names
    for name in drive.parameter_values():
        with pytest.raises(InputError, match=f"^`{name}` must be"):
            drive.replace(**{name: bad})


@every
def test_batch_check_agrees_with_single_check(drive: Drive) -> None:
    """A batch marks as invalid exactly the values that a single drive refuses."""
    assert drive.parameter_values() or drive.piece_parameter_names
    values = np.array([np.nan, np.inf, -1.0, -0.0, 0.0, 5e-324, 1.0, 1e308])
    for name in drive.parameter_values():
        expected = [refused(drive, name, value) for value in values]
        assert drive.where_invalid({name: values}).tolist() == expected


def refused(drive: Drive, name: str, value: float) -> bool:
    try:
        drive.replace(**{name: value})
    except InputError:
        return True
    return False


def changes(drive: Drive) -> dict[str, Any]:
    for name, value in drive.parameter_values().items():
        return {name: value + 0.5}
    return {"loads": [x + 0.5 for x in getattr(drive, "loads")]}  # noqa: B009
