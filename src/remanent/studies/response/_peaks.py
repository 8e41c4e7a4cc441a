"""Peaks of branches of forced response, and the evidence of which resonance each is."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from remanent._errors import InputError
from remanent._typing import ComplexArray, FloatArray, IntArray
from remanent.analysis.response.harmonics import (
    find_resonant_harmonic,
    fourier_amplitudes,
    resonance_kind_and_order,
)
from remanent.analysis.statics.equilibria import find_force_zeros, force_slope
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.drives.waves import Constant
from remanent.studies.ensemble.checks import require_actuator
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.observables import blank_beyond_horizon, evaluate_observable
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.orbits._branch_tables import BranchTablesOfSystem, ColumnTable
from remanent.studies.orbits._tracing import TracingOptions
from remanent.studies.response._free_oscillations import free_oscillations
from remanent.studies.statics._static_ensemble import StaticEnsemble
from remanent.studies.statics._static_state import StaticState

#: Harmonics of the orbit that are told, beside its mean.
HARMONIC_COUNT = 12
#: Samples of the orbit, and of the load, in one period.
_FOURIER_SAMPLES_PER_PERIOD = 256
#: Error of the samples.
_SAMPLE_TOLERANCE = 1e-7
#: Free oscillations that are compared.
_FREE_OSCILLATION_COUNT = 80
#: Smallest turning point they start from, relative to rest.
_SMALLEST_RELATIVE_TURNING_POINT = 1.001
#: Largest turning point they start from.
_LARGEST_RELATIVE_TURNING_POINT = 6.0
#: Error of the free oscillations.
_FREE_OSCILLATION_TOLERANCE = 1e-6


@dataclass(frozen=True)
class Peak:
    """A peak of a branch: where it is, and the orbit there.

    Attributes
    ----------
    omega, omega_error : float
        Frequency of the drive, and the distance between the neighbouring points.
    amplitude : float
    state : array (state,)
        At phase 0.
    orbit_period : int
        Of the orbit, in drive periods.
    stability : str
    is_unbounded : bool
        Whether the branch ends here, still rising.
    is_from_period_doubling : bool
        Whether the branch springs from one of another period.
    """

    omega: float
    omega_error: float
    amplitude: float
    state: FloatArray
    orbit_period: int
    stability: str
    is_unbounded: bool
    is_from_period_doubling: bool


def find_peaks(branches: BranchTablesOfSystem, options: TracingOptions) -> list[Peak]:
    """Local maxima of the amplitude along every branch, and ends that run off."""
    low, high = options.parameter_range
    period = options.orbit_period
    peaks = []
    for number, points in enumerate(branches.point_tables):
        size, omega = points["amplitude"], points["parameter"]
        special = branches.special_point_table
        springs = bool((special["orbit_period"][special["branch"] == number] < period).any())
        for k in _local_maximum_indices(size):
            inner = 0 < k < len(size) - 1
            if not inner and not low < omega[k] < high:
                continue  # the end of the range of frequencies
            peaks.append(
                Peak(
                    omega=float(omega[k]),
                    omega_error=float(np.ptp(omega[max(k - 1, 0) : k + 2])),
                    amplitude=float(size[k]),
                    state=points["initial"][k],
                    orbit_period=period,
                    stability=str(points["stability"][k]),
                    is_unbounded=not inner,
                    is_from_period_doubling=springs,
                )
            )
    return peaks


def _local_maximum_indices(values: FloatArray) -> IntArray:
    """Where an array is larger than its neighbours, ends included."""
    padded = np.concatenate([[-np.inf], values, [-np.inf]])
    return np.flatnonzero((padded[1:-1] > padded[:-2]) & (padded[1:-1] >= padded[2:]))


def empty_peak_table() -> ColumnTable:
    """The columns of :func:`describe_peaks` without any peak."""
    numbers = ("omega", "omega_error", "amplitude", "phase_lag", "share", "free_frequency",
               "detuning")  # fmt: skip
    return {
        **dict.fromkeys(numbers, np.empty(0)),
        **dict.fromkeys(("order_p", "order_q", "orbit_period"), np.empty(0, dtype=np.int64)),
        "unbounded": np.empty(0, dtype=bool),
        "resonance_kind": np.empty(0, dtype="<U16"),
        "stability": np.empty(0, dtype="<U9"),
        "harmonics": np.empty((0, HARMONIC_COUNT + 1), dtype=complex),
    }


def describe_peaks(member: Ensemble, varied: Iterable[str], peaks: Sequence[Peak]) -> ColumnTable:
    """Columns about the peaks of one system, each an array (peak, ...).

    Parameters
    ----------
    member : Ensemble
        Of one trajectory.
    varied : iterable of str
        Fields whose values are not those of its system and drive.
    peaks : sequence of Peak
    """
    if not peaks:
        return empty_peak_table()
    system, drive = _actuator_and_drive_of_member(member, varied)
    omega = np.array([peak.omega for peak in peaks])
    amplitude = np.array([peak.amplitude for peak in peaks])
    period = np.array([peak.orbit_period for peak in peaks], dtype=np.int64)
    on_orbits = member.with_initial_states(
        np.array([peak.state for peak in peaks]), {"omega": omega}
    )
    harmonics = _orbit_harmonics(on_orbits, period)
    mean, first = _load_mean_and_first_harmonic(drive)
    free = _free_frequency(system, mean, amplitude)
    base = 2.0 * np.pi / (require_drive_periods(on_orbits) * period)
    evidence = find_resonant_harmonic(harmonics, base, free)
    names = [
        resonance_kind_and_order(
            evidence, k, peak.orbit_period, doubled=peak.is_from_period_doubling
        )
        for k, peak in enumerate(peaks)
    ]
    angle = np.angle(harmonics[np.arange(len(peaks)), evidence.harmonic_number])
    columns: dict[str, Any] = {
        "omega": omega,
        "omega_error": [peak.omega_error for peak in peaks],
        "amplitude": amplitude,
        "phase_lag": np.mod(
            evidence.harmonic_number / period * np.angle(first) - angle, 2.0 * np.pi
        ),
        "share": evidence.power_share,
        "free_frequency": free,
        "detuning": evidence.relative_detuning,
        "order_p": [p for _, p, _ in names],
        "order_q": [q for _, _, q in names],
        "orbit_period": period,
        "unbounded": [peak.is_unbounded for peak in peaks],
        "resonance_kind": [name for name, _, _ in names],
        "stability": [peak.stability for peak in peaks],
        "harmonics": harmonics,
    }
    kinds = empty_peak_table()
    return {name: np.asarray(column, dtype=kinds[name].dtype) for name, column in columns.items()}


def _actuator_and_drive_of_member(
    member: Ensemble, varied: Iterable[str]
) -> tuple[Actuator, Drive]:
    """System and drive with the values of a member of an ensemble."""
    system, drive = require_actuator("system", member.system), member.drive
    for name in varied:
        if name in drive.parameters():
            drive = drive.replace(**{name: float(member.parameter_values[name][0])})
        elif name in system.parameters():
            system = system.with_parameter(name, float(member.parameter_values[name][0]))
    return system, drive


def _orbit_harmonics(on_orbits: Ensemble, period: IntArray) -> ComplexArray:
    """Harmonics of the thickness stretch along each orbit, array (peak, harmonic).

    Parameters
    ----------
    on_orbits : Ensemble
        Starts on the orbits.
    period : array (peak,) of int
        Of each orbit, in drive periods.
    """
    lengths = period * require_drive_periods(on_orbits)
    times = np.arange(_FOURIER_SAMPLES_PER_PERIOD) / _FOURIER_SAMPLES_PER_PERIOD * lengths[:, None]
    problem = initial_value_problem(on_orbits, times[:, -1])
    outcome = integrate(problem, Request(times=times), tolerance=_SAMPLE_TOLERANCE)
    assert outcome.states is not None
    states = blank_beyond_horizon(outcome.states, times, outcome)
    return fourier_amplitudes(
        evaluate_observable(problem, "thickness_stretch", times, states), HARMONIC_COUNT
    )


def _load_mean_and_first_harmonic(drive: Drive) -> tuple[float, complex]:
    """Mean of the load, and its first harmonic."""
    assert drive.period is not None
    values = drive(
        np.arange(_FOURIER_SAMPLES_PER_PERIOD) / _FOURIER_SAMPLES_PER_PERIOD * drive.period
    )
    amplitudes = fourier_amplitudes(np.asarray(values)[None], 1)[0]
    return float(amplitudes[0].real), complex(amplitudes[1])


def _free_frequency(system: Actuator, mean: float, amplitude: FloatArray) -> FloatArray:
    """Frequency of the free oscillation of each amplitude, under the mean load.

    Branches that relax make all of them faster, by as much as they do small oscillations.
    """
    rest = _stable_stretch(system, mean)
    starts = rest * np.geomspace(
        _SMALLEST_RELATIVE_TURNING_POINT,
        _LARGEST_RELATIVE_TURNING_POINT / rest,
        _FREE_OSCILLATION_COUNT,
    )
    elastic = system.replace(dissipation=(), heat=None)
    free = free_oscillations(
        lay_out_ensemble(elastic, Constant(mean), {"initial.stretch": starts}),
        _FREE_OSCILLATION_TOLERANCE,
    )
    is_finite = np.isfinite(free.amplitude) & np.isfinite(free.frequency)
    stiffening = _small_oscillation_frequency(system, mean) / _small_oscillation_frequency(
        elastic, mean
    )
    frequency = np.interp(
        amplitude, free.amplitude[is_finite], free.frequency[is_finite], right=np.nan
    )
    return np.asarray(stiffening * frequency)


def _stable_stretch(system: Actuator, mean: float) -> float:
    """The stretch at the one stable equilibrium under a load."""
    at_rest = StaticEnsemble(lay_out_ensemble(system, Constant(mean)))
    roots = find_force_zeros(at_rest.first_acceleration, 1, at_rest.stretch_grid)[0]
    stable = roots[
        force_slope(at_rest.first_acceleration, np.zeros(roots.size, dtype=np.int64), roots) < 0.0
    ]
    if stable.size != 1:
        raise InputError(
            "drive",
            must="have a mean load with one stable equilibrium",
            got=mean,
            why="Resonances are named by the free oscillations about it.",
            fix="Pass another load or prestress.",
        )
    return float(stable[0])


def _small_oscillation_frequency(system: Actuator, mean: float) -> float:
    """Modulus of the eigenvalue of small oscillations about rest; NaN where there are none."""
    ens = lay_out_ensemble(system, Constant(mean))
    row = np.array([ens.parameter_values[name][0] for name in ens.vector_field.parameter_names])
    rest = StaticState(ens.vector_field, row, ens.initial_states[0]).rest_nearby()
    if rest is None:
        return np.nan
    values = np.linalg.eigvals(rest.rate_derivatives()[0])
    return max((abs(complex(s)) for s in values if s.imag > 0.0), default=np.nan)
