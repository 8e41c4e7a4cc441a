"""Spectra: lines of a series, with their frequencies refined beyond the grid.

Reference
---------
J. Laskar, Physica D 67 (1993) 257 (numerical analysis of fundamental frequencies).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.fft

from remanent._typing import ComplexArray, FloatArray

#: Ternary steps: each narrows a bracket by a third.
_STEPS = 90


@dataclass(frozen=True)
class Lines:
    """Spectral lines, the strongest first.

    Attributes
    ----------
    frequency : array (line,)
        Cycles per sample, in [0, 1/2].
    amplitude : array (line,)
        Of the cosine; for frequency 0 the mean.
    phase : array (line,)
        Of the cosine at the first sample, radians.
    residual : float
        Standard deviation of what the lines leave, relative to that of the series.
    """

    frequency: FloatArray
    amplitude: FloatArray
    phase: FloatArray
    residual: float


def spectrum(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Amplitude spectrum under a Hann window, less the mean.

    Parameters
    ----------
    values : array (..., sample)

    Returns
    -------
    frequency : array (frequency,)
        Cycles per sample.
    amplitude : array (..., frequency)
        Of a cosine in the middle of a bin.
    """
    count = values.shape[-1]
    weight = _hann(count)
    moved = values - values.mean(axis=-1, keepdims=True)
    transform = scipy.fft.rfft(moved * weight, axis=-1)
    return np.asarray(scipy.fft.rfftfreq(count)), np.asarray(2.0 * np.abs(transform))


def lines(values: FloatArray, count: int) -> Lines:
    """Find the strongest lines of a series one after another.

    The largest value of the windowed transform is located between its grid points, the
    line is taken out by least squares together with those before it, and so on.

    Parameters
    ----------
    values : array (sample,)
    count
        How many lines.
    """
    n = np.arange(values.size)
    left: FloatArray = values - values.mean()
    found: FloatArray = np.empty(0)
    fit: FloatArray = np.empty(0)
    for _ in range(count):
        found = np.append(found, _peak(left))
        turn = 2.0 * np.pi * np.outer(n, found)
        columns = np.concatenate([np.ones((n.size, 1)), np.cos(turn), np.sin(turn)], axis=1)
        fit = np.linalg.lstsq(columns, values, rcond=None)[0]
        left = values - columns @ fit
    cosine, sine = fit[1 : 1 + count], fit[1 + count :]
    size = np.hypot(cosine, sine)
    order = np.argsort(-size, kind="stable")
    whole = float(np.std(values))
    residual = float(np.std(left)) / whole if whole > 0.0 else 0.0
    phase = np.arctan2(-sine, cosine)
    return Lines(found[order], size[order], phase[order], residual)


def _hann(count: int) -> FloatArray:
    """Weights that add up to 1."""
    weight = 1.0 - np.cos(2.0 * np.pi * (np.arange(count) + 0.5) / count)
    return np.asarray(weight / weight.sum())


def _peak(values: FloatArray) -> float:
    """Frequency of the largest value of the windowed transform."""
    frequency, size = spectrum(values)
    k = int(np.argmax(size[1:])) + 1 if size.size > 1 else 0
    step = 1.0 / values.size
    low, high = max(frequency[k] - step, 0.0), min(frequency[k] + step, 0.5)
    weighted, n = _hann(values.size) * values, np.arange(values.size)

    def strength(f: float) -> float:
        transform: ComplexArray = weighted @ np.exp(-2j * np.pi * f * n)
        return float(np.abs(transform))

    for _ in range(_STEPS):
        a, b = low + (high - low) / 3.0, high - (high - low) / 3.0
        low, high = (a, high) if strength(a) < strength(b) else (low, b)
    return float(0.5 * (low + high))
