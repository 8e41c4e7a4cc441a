"""The resonances of forced response, named by their order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._typing import ArrayLike, ComplexArray, FloatArray, IntArray
from remanent.analysis.response.harmonics import (
    fourier_amplitudes,
    resonance_kind,
    resonant_harmonic,
)
from remanent.codegen.field import field_for
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.drives.waves import Constant
from remanent.models.system import System
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_actuator
from remanent.studies.ensemble.durations import require_count
from remanent.studies.ensemble.layout import lay_out
from remanent.studies.motion.simulate import simulate
from remanent.studies.orbits.continue_orbit import response_diagram
from remanent.studies.response.backbone import backbone
from remanent.studies.statics._static_state import StaticState
from remanent.studies.statics.equilibria import equilibria

#: Harmonics of the orbit that are told; samples of the orbit and of the load.
_HARMONICS, _SAMPLES = 12, 256
#: Free oscillations that are compared, and the largest stretch they start from.
_FREE, _WIDEST = 80, 6.0
#: Error asked of the samples.
_TOLERANCE = 1e-7


def resonances(
    system: System,
    drive: Drive,
    omega_range: ArrayLike,
    *,
    orbit_periods: Sequence[int] = (1,),
    state_box: Mapping[str, Any] | None = None,
    slices: int = 9,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """Find the peaks of forced response and say which resonance each of them is.

    Parameters
    ----------
    system, drive
        What moves, with one coordinate, and a drive with a field ``omega``, whose value is
        not used.
    omega_range
        Lowest and highest frequency.
    orbit_periods
        Of the orbits, in drive periods: 1 for primary and superharmonic resonances, 2, 3 ...
        for subharmonic and parametric ones.
    state_box, slices, tolerance
        As for :func:`remanent.response_diagram`.

    Returns
    -------
    xarray.Dataset
        Along ``peak``, by frequency: ``omega`` with ``omega_error``, the distance between
        the neighbouring points of the branch; ``amplitude``; ``unbounded``, whether the
        branch rises to the end of `state_box` instead of turning back; ``resonance_kind``
        (``primary``, ``superharmonic``, ``subharmonic``, ``parametric``,
        ``ultrasubharmonic``, ``undecided``), with ``order_p``:``order_q``, oscillations in
        drive periods, 0:0 where undecided; ``orbit_period``; ``stability``; the ``phase_lag``
        behind the load of the harmonic that resonates, in [0, 2π).  Evidence:
        ``harmonics`` (peak, harmonic), complex; ``share``, of that harmonic in the mean
        square; ``free_frequency`` of the free oscillation as large as the orbit, under the
        mean load, without dissipation and at the surroundings' temperature; ``detuning`` of
        the harmonic from it.

    Raises
    ------
    InputError
        A bad argument, or an actuator of two coordinates.

    Notes
    -----
    A peak is a local maximum of the amplitude along a branch of
    :func:`remanent.response_diagram`.  Undamped branches have none; where they rise to the
    end of the bounds that end stands for it.  The harmonic whose frequency is nearest to the
    free oscillation names the resonance if it is within 10 % of it and holds 5 % of the
    mean square; else the peak is ``undecided``.  Branches that relax make free oscillations
    faster: in the ratio of the modulus of the eigenvalue of small oscillations to the natural
    frequency, at every amplitude; dashpots leave that modulus as it is.  A 1:2 response is
    ``parametric`` where its branch springs from one of period 1, which loses stability there
    (A. H. Nayfeh and D. T. Mook, Nonlinear Oscillations (Wiley, 1979), chapters 4 and 5).

    Examples
    --------
    >>> import remanent as rm
    >>> damped = rm.Actuator(dissipation=rm.Rayleigh(0.05))
    >>> ds = rm.resonances(damped, rm.SineSquared(0.3, 1.0), (0.55, 1.5))
    >>> ds.resonance_kind.values.tolist()
    ['superharmonic', 'primary']
    """
    for one in orbit_periods:
        require_count("orbit_periods", one, "Orbits close after whole drive periods.")
    actuator = _require_one_coordinate(system)
    peaks = [
        peak
        for period in orbit_periods
        for peak in _peaks(
            response_diagram(
                system, drive, omega_range, state_box=state_box, orbit_period=period, slices=slices,
                tolerance=tolerance,
            ),
            period,
            field_for(system, drive).state,
        )
    ]  # fmt: skip
    peaks.sort(key=lambda peak: peak.omega)
    described = _described(actuator, drive, peaks)
    attributes = provenance.attributes(
        system, drive, tolerance, over=("omega",),
        parameter_range=tuple(np.asarray(omega_range, dtype=float).tolist()), slices=slices,
    )  # fmt: skip
    coords: dict[str, Labelled] = {
        "peak": (("peak",), np.arange(len(peaks))),
        "harmonic": (("harmonic",), np.arange(_HARMONICS + 1)),
    }
    return build.dataset(described, coords, attributes)


@dataclass(frozen=True)
class _Peak:
    """A peak of a branch: where it is, and the orbit there."""

    omega: float
    error: float
    amplitude: float
    state: tuple[float, ...]
    period: int
    stability: str
    unbounded: bool
    doubled: bool


def _require_one_coordinate(system: System) -> Actuator:
    """The actuator, refused where it has no backbone."""
    actuator = require_actuator("system", system)
    if actuator.coordinates > 1:
        raise InputError(
            "system",
            must="have one coordinate",
            got=actuator,
            why="Resonances are named by free oscillations of the same amplitude, which two "
            "coordinates have of more than one kind.",
            fix="Pass one number as prestress and no edges, or read the peaks of response_diagram.",
        )
    return actuator


def _peaks(diagram: xr.Dataset, period: int, state: Sequence[str]) -> list[_Peak]:
    """Local maxima of the amplitude along every branch, and ends that run off."""
    low, high = diagram.attrs["parameter_range"]
    found = []
    for b in range(diagram.sizes["branch"]):
        row = diagram.isel(branch=b)
        count = int(np.isfinite(row["omega"].values).sum())
        size, omega = row["amplitude"].values[:count], row["omega"].values[:count]
        marks = diagram["special_kind"].values[diagram["special_branch"].values == b]
        doubled = period % 2 == 0 and "branch point" in marks.tolist()
        for k in _maxima(size):
            inner = 0 < k < count - 1
            if not inner and not low < omega[k] < high:
                continue  # the end of the range of frequencies
            beside = omega[max(k - 1, 0) : k + 2]
            found.append(
                _Peak(
                    float(omega[k]), float(np.ptp(beside)), float(size[k]),
                    tuple(float(row[name].values[k]) for name in state),
                    period, str(row["stability"].values[k]), not inner, doubled,
                )
            )  # fmt: skip
    return found


def _maxima(size: FloatArray) -> IntArray:
    """Local maxima, ends included."""
    padded = np.concatenate([[-np.inf], size, [-np.inf]])
    return np.flatnonzero((padded[1:-1] > padded[:-2]) & (padded[1:-1] >= padded[2:]))


def _described(actuator: Actuator, drive: Drive, peaks: Sequence[_Peak]) -> dict[str, Labelled]:
    along = ("peak",)
    omega = np.array([peak.omega for peak in peaks])
    size = np.array([peak.amplitude for peak in peaks])
    period = np.array([peak.period for peak in peaks], dtype=np.int64)
    amplitudes = _harmonics(actuator, drive, peaks)
    mean, load = _load(drive)
    free = _free_frequency(actuator, mean, size)
    found = resonant_harmonic(amplitudes, 2.0 * np.pi / (_lengths(drive, omega) * period), free)
    names = [
        resonance_kind(found, k, peak.period, doubled=peak.doubled) for k, peak in enumerate(peaks)
    ]
    angle = np.angle(amplitudes[np.arange(len(peaks)), found.harmonic])
    lag = np.mod(found.harmonic / period * np.angle(load) - angle, 2.0 * np.pi)
    return {
        "omega": (along, omega),
        "omega_error": (along, np.array([peak.error for peak in peaks])),
        "amplitude": (along, size),
        "unbounded": (along, np.array([peak.unbounded for peak in peaks], dtype=bool)),
        "resonance_kind": (along, np.array([name for name, _, _ in names], dtype="<U16")),
        "order_p": (along, np.array([p for _, p, _ in names], dtype=np.int64)),
        "order_q": (along, np.array([q for _, _, q in names], dtype=np.int64)),
        "orbit_period": (along, period),
        "stability": (along, np.array([peak.stability for peak in peaks], dtype="<U9")),
        "phase_lag": (along, lag),
        "harmonics": ((*along, "harmonic"), amplitudes),
        "share": (along, found.share),
        "free_frequency": (along, free),
        "detuning": (along, found.detuning),
    }


def _harmonics(actuator: Actuator, drive: Drive, peaks: Sequence[_Peak]) -> ComplexArray:
    """Harmonics of the thickness stretch along each orbit, array (peak, harmonic)."""
    found = [
        fourier_amplitudes(_samples(actuator, drive, peak)[None], _HARMONICS)[0] for peak in peaks
    ]
    return np.array(found).reshape(len(peaks), _HARMONICS + 1)


def _samples(actuator: Actuator, drive: Drive, peak: _Peak) -> FloatArray:
    """The thickness stretch along an orbit, evenly in time."""
    omega = np.array([peak.omega])
    times = np.arange(_SAMPLES) / _SAMPLES * peak.period * float(_lengths(drive, omega)[0])
    run = simulate(
        actuator, drive, times=times, initial=peak.state, over={"omega": omega},
        tolerance=_TOLERANCE,
    )  # fmt: skip
    return np.asarray(run["thickness_stretch"].values).ravel()


def _lengths(drive: Drive, omega: FloatArray) -> FloatArray:
    """Drive periods at some frequencies."""
    values = {name: np.full(omega.shape, value) for name, value in drive.parameters().items()}
    found = drive.periods(values | {"omega": omega})
    assert found is not None
    return np.asarray(found)


def _load(drive: Drive) -> tuple[float, complex]:
    """Mean of the load, and its first harmonic."""
    assert drive.period is not None
    values = drive(np.arange(_SAMPLES) / _SAMPLES * drive.period)
    found = fourier_amplitudes(np.asarray(values)[None], 1)[0]
    return float(found[0].real), complex(found[1])


def _free_frequency(actuator: Actuator, mean: float, size: FloatArray) -> FloatArray:
    """Frequency of the free oscillation of each amplitude, under the mean load."""
    if not size.size:
        return np.empty(0)
    rest = equilibria(actuator, mean)
    stable = rest["stretch"].values[rest["stability"].values == "stable"]
    if stable.size != 1:
        raise InputError(
            "drive",
            must="have a mean load with one stable equilibrium",
            got=mean,
            why="Resonances are named by the free oscillations about it.",
            fix="Pass another load or prestress.",
        )
    starts = float(stable[0]) * np.geomspace(1.001, _WIDEST / float(stable[0]), _FREE)
    elastic = actuator.replace(dissipation=(), heat=None)
    free = backbone(elastic, starts, m=mean, tolerance=1e-6)
    known = np.isfinite(free["amplitude"].values) & np.isfinite(free["frequency"].values)
    reached, frequency = (free[n].values[known] for n in ("amplitude", "frequency"))
    small = _small_oscillations(actuator, mean) / _small_oscillations(elastic, mean)
    return np.asarray(small * np.interp(size, reached, frequency, right=np.nan))


def _small_oscillations(actuator: Actuator, mean: float) -> float:
    """Modulus of the eigenvalue of small oscillations about rest; NaN where there are none."""
    ens = lay_out(actuator, Constant(mean))
    row = np.array([ens.values[name][0] for name in ens.field.parameters])
    body = StaticState(ens.field, row, ens.initial[0]).relax()
    if body is None:
        return np.nan
    values = np.linalg.eigvals(body.linearised()[0])
    return max((abs(complex(s)) for s in values if s.imag > 0.0), default=np.nan)
