"""The evidence of which resonance each peak of forced response is."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from remanent._typing import ComplexArray, FloatArray, IntArray
from remanent.analysis.response.harmonics import (
    find_resonant_harmonic,
    fourier_amplitudes,
    phase_lag_behind_load,
    power_share,
    resonance_kind_and_order,
)
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import ERROR_SHARE_IN_FUNCTIONS, Request
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.observables import (
    blank_beyond_horizon,
    evaluate_observable,
    largest_observable_error,
)
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.orbits._branch_tables import ColumnTable
from remanent.studies.response._mean_rest import MeanRest, free_frequency
from remanent.studies.response._peak_search import Peak

#: Harmonics of the orbit that are told, beside its mean.
HARMONIC_COUNT = 12
#: Samples of the orbit, and of the load, in one period.
_FOURIER_SAMPLES_PER_PERIOD = 256
#: Harmonics of the load that are looked at.
_LOAD_HARMONIC_COUNT = 64
#: Errors of the samples: the next is taken where one cannot be met.
_SAMPLE_TOLERANCES = (1e-13, 1e-11, 1e-9, 1e-7)
#: Part of the bound of a share that counts as its error: bounds of samples and orbits are some
#: fifty times their errors, most of which move the place along the orbit, and leave its shares
#: as they are.  Measured.
_SHARE_WEIGHT = 0.15


def empty_peak_table() -> ColumnTable:
    """The columns of :func:`describe_peaks` without any peak."""
    numbers = ("omega", "amplitude", "phase_lag", "share", "free_frequency", "detuning")
    return {
        **dict.fromkeys((*numbers, *(f"{name}_error" for name in numbers)), np.empty(0)),
        "harmonics_error": np.empty(0),
        **dict.fromkeys(("order_p", "order_q", "orbit_period"), np.empty(0, dtype=np.int64)),
        "unbounded": np.empty(0, dtype=bool),
        "resonance_kind": np.empty(0, dtype="<U16"),
        "stability": np.empty(0, dtype="<U9"),
        "harmonics": np.empty((0, HARMONIC_COUNT + 1), dtype=complex),
    }


def describe_peaks(
    member: Ensemble, drive: Drive, rest: MeanRest, peaks: Sequence[Peak]
) -> ColumnTable:
    """Columns about the peaks of one system, each an array (peak, ...).

    Parameters
    ----------
    member : Ensemble
        Of one trajectory.
    drive : Drive
        With the member's values, but for its frequency.
    rest : MeanRest
        The system at rest under the mean of its load.
    peaks : sequence of Peak
    """
    if not peaks:
        return empty_peak_table()
    omega, omega_error, amplitude, amplitude_error, state_error = (
        np.array([getattr(peak, name) for peak in peaks])
        for name in ("omega", "omega_error", "amplitude", "amplitude_error", "state_error")
    )
    period = np.array([peak.orbit_period for peak in peaks], dtype=np.int64)
    states = np.array([peak.state for peak in peaks])
    harmonics, sample_error = _orbit_harmonics(member, states, omega, period)
    known_to = sample_error + 2.0 * state_error  # at the place itself
    nearby = _harmonics_nearby(member, peaks)
    change = _change_nearby(peaks, nearby, lambda k, c: np.abs(c - harmonics[k]).max(axis=1))
    harmonics_error = known_to + change
    _, load = load_harmonics(drive)
    free, free_error = free_frequency(rest, amplitude, amplitude_error)
    on_orbits = member.with_initial_states(states, {"omega": omega})
    base = 2.0 * np.pi / (require_drive_periods(on_orbits) * period)
    evidence = find_resonant_harmonic(harmonics, base, free)
    resonant = harmonics[np.arange(len(peaks)), evidence.harmonic_number]
    lags = [
        phase_lag_behind_load(float(np.angle(resonant[k])), int(number), int(period[k]), load)
        for k, number in enumerate(np.maximum(evidence.harmonic_number, 1))
    ]
    names = [
        resonance_kind_and_order(
            evidence,
            k,
            peak.orbit_period,
            doubled=peak.is_from_period_doubling,
            in_load=lags[k].in_load,
        )
        for k, peak in enumerate(peaks)
    ]
    has_harmonic = evidence.harmonic_number > 0
    with np.errstate(all="ignore"):
        relative = known_to / np.abs(resonant)
        lag_error = np.where(relative < 1.0, np.arcsin(np.minimum(relative, 1.0)), np.pi)
        number = evidence.harmonic_number
        lag_error += _change_nearby(
            peaks, nearby, lambda k, c: np.abs(np.angle(c[:, number[k]] / resonant[k]))
        )
        share_error = _share_error(harmonics, number, known_to)
        share_error += _change_nearby(
            peaks,
            nearby,
            lambda k, c: np.abs(
                power_share(c, np.full(len(c), number[k])) - evidence.power_share[k]
            ),
        )
        detuning_error = (1.0 + evidence.relative_detuning) * (
            omega_error / omega + free_error / free
        )
    columns: dict[str, Any] = {
        "omega": omega,
        "omega_error": omega_error,
        "amplitude": amplitude,
        "amplitude_error": amplitude_error,
        "phase_lag": np.where(has_harmonic, [lag.angle for lag in lags], np.nan),
        "phase_lag_error": np.where(has_harmonic, lag_error, np.nan),
        "share": evidence.power_share,
        "share_error": share_error,
        "free_frequency": free,
        "free_frequency_error": free_error,
        "detuning": evidence.relative_detuning,
        "detuning_error": detuning_error,
        "order_p": [p for _, p, _ in names],
        "order_q": [q for _, _, q in names],
        "orbit_period": period,
        "unbounded": [peak.is_unbounded for peak in peaks],
        "resonance_kind": [name for name, _, _ in names],
        "stability": [peak.stability for peak in peaks],
        "harmonics": harmonics,
        "harmonics_error": harmonics_error,
    }
    kinds = empty_peak_table()
    return {name: np.asarray(column, dtype=kinds[name].dtype) for name, column in columns.items()}


def system_and_drive_of_member(member: Ensemble, varied: Iterable[str]) -> tuple[System, Drive]:
    """System and drive with the values of a member of an ensemble."""
    system, drive = member.system, member.drive
    for name in varied:
        if name in drive.parameter_values():
            drive = drive.replace(**{name: float(member.parameter_values[name][0])})
        elif name in system.parameter_values():
            system = system.with_parameter(name, float(member.parameter_values[name][0]))
    return system, drive


def _orbit_harmonics(
    member: Ensemble, states: FloatArray, omega: FloatArray, period: IntArray
) -> tuple[ComplexArray, FloatArray]:
    """Harmonics of the observable along orbits (peak, harmonic), and errors (peak,).

    Parameters
    ----------
    member : Ensemble
        Of one trajectory.
    states : array (peak, state)
        On the orbits, at phase 0.
    omega : array (peak,)
    period : array (peak,) of int
        Of each orbit, in drive periods.
    """
    on_orbits = member.with_initial_states(states, {"omega": omega})
    lengths = period * require_drive_periods(on_orbits)
    times = np.arange(_FOURIER_SAMPLES_PER_PERIOD) / _FOURIER_SAMPLES_PER_PERIOD * lengths[:, None]
    problem = initial_value_problem(on_orbits, times[:, -1])
    for tolerance in _SAMPLE_TOLERANCES:
        outcome = integrate(problem, Request(times=times), tolerance=tolerance)
        assert outcome.states is not None
        states = blank_beyond_horizon(outcome.states, times, outcome)
        if np.isfinite(states).all():
            break
    name = problem.field.observable_name
    samples = evaluate_observable(problem, name, times, states)
    # An error e of the state makes one of e times the slope of the observable, and of no more than
    # twice that of a harmonic, which is twice a mean.
    slope = largest_observable_error(problem, name, times, states, np.ones(len(times)))
    slope = slope / ERROR_SHARE_IN_FUNCTIONS
    return fourier_amplitudes(samples, HARMONIC_COUNT), 2.0 * slope * outcome.error


def _share_error(harmonics: ComplexArray, number: IntArray, error: FloatArray) -> FloatArray:
    """What an error of the samples makes of the share of one harmonic in the mean square, (peak,).

    With s = r_n^2/R and R the sum of all r_j^2, the gradient of s by all harmonics is
    2 sqrt(s (1 - s)/R) long; by Parseval's theorem the changes of all are together no more
    than the root of two times the largest of the samples.

    Parameters
    ----------
    error : array (peak,)
        Bound of one harmonic, twice that of a sample.
    """
    share, total = power_share(harmonics, number), (np.abs(harmonics[:, 1:]) ** 2).sum(axis=1)
    moved = np.sqrt(0.5) * error
    rounding = 4.0 * np.finfo(float).eps
    first_order = 2.0 * np.sqrt(share * (1.0 - share) / total) * moved
    return np.asarray(_SHARE_WEIGHT * first_order + 2.0 * moved**2 / total + rounding)


def _harmonics_nearby(member: Ensemble, peaks: Sequence[Peak]) -> dict[int, ComplexArray]:
    """Harmonics (node, harmonic) of orbits on both sides of peaks, by number of the peak."""
    rows = [k for k, peak in enumerate(peaks) if len(peak.nearby_omega) > 1]
    if not rows:
        return {}
    near = [peaks[k] for k in rows]
    counts = [len(peak.nearby_omega) for peak in near]
    states = np.concatenate([peak.nearby_states for peak in near])
    omega = np.concatenate([peak.nearby_omega for peak in near])
    period = np.repeat([peak.orbit_period for peak in near], counts)
    around, _ = _orbit_harmonics(member, states, omega, period)
    return dict(zip(rows, np.split(around, np.cumsum(counts)[:-1]), strict=True))


def _change_nearby(
    peaks: Sequence[Peak],
    nearby: Mapping[int, ComplexArray],
    change_at: Callable[[int, ComplexArray], FloatArray],
) -> FloatArray:
    """How much a number changes within the error of the place of each peak, array (peak,).

    Parameters
    ----------
    peaks : sequence of Peak
    nearby : mapping of int to array
        From :func:`_harmonics_nearby`.
    change_at : callable
        Of the number of a peak and harmonics (node, harmonic): changes (node,).
    """
    change = np.zeros(len(peaks))
    for k, block in nearby.items():
        distance = np.abs(peaks[k].nearby_omega - peaks[k].omega).max()
        share = min(1.0, peaks[k].omega_error / distance) if distance > 0.0 else 1.0
        change[k] = float(change_at(k, block).max()) * share
    return change


def load_harmonics(drive: Drive) -> tuple[float, ComplexArray]:
    """Mean of the load, and its harmonics."""
    assert drive.period is not None
    values = drive(
        np.arange(_FOURIER_SAMPLES_PER_PERIOD) / _FOURIER_SAMPLES_PER_PERIOD * drive.period
    )
    amplitudes = fourier_amplitudes(np.asarray(values)[None], _LOAD_HARMONIC_COUNT)[0]
    return float(amplitudes[0].real), amplitudes
