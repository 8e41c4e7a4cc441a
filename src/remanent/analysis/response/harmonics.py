"""Which harmonic of an orbit resonates, and what such a resonance is called."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import gcd

import numpy as np

from remanent._typing import ComplexArray, FloatArray, IntArray

#: Distance of a resonant harmonic from the free frequency, relative to that, at most.
_MAX_RELATIVE_DETUNING = 0.1
#: Smallest harmonic of a load, relative to its largest, that is more than rounding.
_MIN_RELATIVE_LOAD_HARMONIC = 1e-9
#: Share of a resonant harmonic in the mean square of the oscillation, at least.
_MIN_POWER_SHARE = 0.05


@dataclass(frozen=True)
class ResonantHarmonic:
    """The harmonic of each orbit that is nearest to the free oscillation.

    Attributes
    ----------
    harmonic_number : array (orbit,)
        Its number, in units of the orbit's own frequency; at least 1.
    relative_detuning : array (orbit,)
        Its frequency over the free one, less 1.
    power_share : array (orbit,)
        Its part of the mean square of the oscillation.
    """

    harmonic_number: IntArray
    relative_detuning: FloatArray
    power_share: FloatArray


def fourier_amplitudes(samples: FloatArray, count: int) -> ComplexArray:
    """Complex amplitudes c_k, k = 0 ... count, of periodic samples, array (orbit, harmonic).

    The mean is c_0 and the oscillation Re Σ c_k exp(2πi k t), t in orbit periods.

    Parameters
    ----------
    samples : array (orbit, sample)
        Evenly over one period, its end left out.
    """
    spectrum = np.fft.rfft(samples, axis=1)[:, : count + 1] / samples.shape[1]
    spectrum[:, 1:] *= 2.0
    return np.asarray(spectrum)


def find_resonant_harmonic(
    amplitudes: ComplexArray, orbit_frequency: FloatArray, free_frequency: FloatArray
) -> ResonantHarmonic:
    """Find the harmonic whose frequency is nearest to that of the free oscillation.

    Parameters
    ----------
    amplitudes : array (orbit, harmonic)
        From :func:`fourier_amplitudes`.
    orbit_frequency : array (orbit,)
    free_frequency : array (orbit,)
        Of the free oscillation that is as large; NaN where there is none.

    Returns
    -------
    ResonantHarmonic
        Harmonic 0, with detuning NaN, where there is no free oscillation.
    """
    highest = amplitudes.shape[1] - 1
    has_free_frequency = np.isfinite(free_frequency)
    ratio = np.where(has_free_frequency, free_frequency, orbit_frequency) / orbit_frequency
    number = np.where(has_free_frequency, np.clip(np.rint(ratio), 1, highest), 0)
    number = number.astype(np.int64)
    share = power_share(amplitudes, number)
    return ResonantHarmonic(number, number * orbit_frequency / free_frequency - 1.0, share)


def power_share(amplitudes: ComplexArray, number: IntArray) -> FloatArray:
    """Part of harmonics `number` in the mean square of oscillations (orbit, harmonic), (orbit,).

    0 for harmonic 0, the mean.
    """
    power = np.abs(amplitudes) ** 2
    power[:, 0] = 0.0
    of_one = power[np.arange(len(power)), number]
    return np.asarray(of_one / np.maximum(power.sum(axis=1), np.finfo(float).tiny))


@dataclass(frozen=True)
class PhaseLag:
    """How far a harmonic of a response is behind the load.

    Attributes
    ----------
    angle : float
        In [0, `modulus`), radians.
    modulus : float
        What it is told up to: 2 pi/q where the response takes q turns of the load's term back to
        the same phases of both.
    in_load : bool
        Whether the load has a term of that frequency, behind which it is; else it is behind its
        first harmonic, times the ratio of the frequencies.
    """

    angle: float
    modulus: float
    in_load: bool


def phase_lag_behind_load(
    response_angle: float, number: int, period: int, load: ComplexArray
) -> PhaseLag:
    """The lag of harmonic `number` of an orbit behind a term of the load.

    Equation: with a load Re sum_j F_j exp(i j w t) and a response Re X exp(i (h/q) w t), the lag
    is arg F_j - arg X for j = h/q, where F_j is not zero.  Otherwise it is (h/q)/j arg F_j -
    arg X with the load's first harmonic j.  An angle of F_j counts only up to 2 pi, so that
    the lag counts up to 2 pi times the ratio (h/q)/j, and up to 2 pi.

    Parameters
    ----------
    response_angle : float
        Of the response's harmonic, radians.
    number : int
        The harmonic h of the orbit.
    period : int
        The drive periods q of the orbit.
    load : array (harmonic,) of complex
        The load's amplitudes F_j, j = 0, 1 ...
    """
    size = np.abs(load)
    size[0] = 0.0
    present = np.flatnonzero(size > _MIN_RELATIVE_LOAD_HARMONIC * size.max())
    if not present.size or size.max() == 0.0:
        return PhaseLag(np.nan, 2.0 * np.pi, False)
    in_load = number % period == 0 and number // period in present
    term = number // period if in_load else int(present[0])
    ratio = Fraction(number, period * term)
    modulus = 2.0 * np.pi / ratio.denominator
    angle = float(ratio) * float(np.angle(load[term])) - response_angle
    return PhaseLag(float(np.mod(angle, modulus)), modulus, bool(in_load))


def resonance_kind_and_order(
    resonance: ResonantHarmonic, k: int, period: int, *, doubled: bool, in_load: bool = False
) -> tuple[str, int, int]:
    """Name a resonance, and give its order p:q in lowest terms.

    p oscillations in q drive periods: 1:1 is ``primary``, p:1 ``superharmonic``, 1:q
    ``subharmonic``, others ``ultrasubharmonic``.  A 1:2 response that grows out of another
    orbit where that one loses stability by period doubling is ``parametric``.  A load that has
    the harmonic itself drives it directly: that is ``primary`` too (A. H. Nayfeh and D. T. Mook,
    Nonlinear Oscillations (Wiley, 1979), section 4.1).

    Parameters
    ----------
    resonance : ResonantHarmonic
        Of all orbits.
    k : int
        Number of the orbit.
    period : int
        Of the orbit, in drive periods.
    doubled : bool
        Whether its branch meets one of half the period.
    in_load : bool
        Whether the load has a term of the frequency of the harmonic.

    Returns
    -------
    kind : str
        ``undecided`` where no harmonic is near the free frequency.
    p, q : int
    """
    number = int(resonance.harmonic_number[k])
    if (
        not abs(resonance.relative_detuning[k]) <= _MAX_RELATIVE_DETUNING
        or resonance.power_share[k] < _MIN_POWER_SHARE
    ):
        return "undecided", 0, 0
    common = gcd(number, period)
    p, q = number // common, period // common
    if in_load:
        return "primary", p, q
    if q == 1:
        return ("primary" if p == 1 else "superharmonic"), p, q
    if p > 1:
        return "ultrasubharmonic", p, q
    return ("parametric" if q == 2 and doubled else "subharmonic"), p, q
