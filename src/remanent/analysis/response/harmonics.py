"""Which harmonic of an orbit resonates, and what such a resonance is called."""

from __future__ import annotations

from dataclasses import dataclass
from math import gcd

import numpy as np

from remanent._typing import ComplexArray, FloatArray, IntArray

#: Distance of a resonant harmonic from the free frequency, relative to that, at most.
_MAX_RELATIVE_DETUNING = 0.1
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
    power = np.abs(amplitudes) ** 2
    power[:, 0] = 0.0
    row = np.arange(len(power))
    share = power[row, number] / np.maximum(power.sum(axis=1), np.finfo(float).tiny)
    return ResonantHarmonic(number, number * orbit_frequency / free_frequency - 1.0, share)


def resonance_kind_and_order(
    resonance: ResonantHarmonic, k: int, period: int, *, doubled: bool
) -> tuple[str, int, int]:
    """Name a resonance, and give its order p:q in lowest terms.

    p oscillations in q drive periods: 1:1 is ``primary``, p:1 ``superharmonic``, 1:q
    ``subharmonic``, others ``ultrasubharmonic``.  A 1:2 response that grows out of another
    orbit where that one loses stability by period doubling is ``parametric``.

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
    if q == 1:
        return ("primary" if p == 1 else "superharmonic"), p, q
    if p > 1:
        return "ultrasubharmonic", p, q
    return ("parametric" if q == 2 and doubled else "subharmonic"), p, q
