"""Indicators that tell order from chaos: alignment of tangents, the 0-1 test.

References
----------
C. Skokos, J. Phys. A 34 (2001) 10029 (smaller alignment index).
G. A. Gottwald and I. Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129 (0-1 test).
"""

from __future__ import annotations

import numpy as np
import scipy.fft

from remanent._typing import FloatArray

#: Frequencies are drawn away from 0 and pi, where the test resonates with slow drifts.
_LOWEST, _HIGHEST = np.pi / 5.0, 4.0 * np.pi / 5.0
#: The mean-square displacement is followed over this share of the series.
_LAGS = 0.1


def alignment(factors: FloatArray) -> FloatArray:
    """Smaller alignment index of two tangents after each block.

    min(|u - w|, |u + w|) of the unit tangents u, w, which were never made orthogonal: the
    triangular factors that did so for the exponents say how they would stand.  It falls as
    exp(-(difference of the two largest exponents) n) in chaos, as a power of n, or not at
    all, on a torus.

    Parameters
    ----------
    factors : array (orbit, block, direction, direction)
        Upper triangles, two directions at least.

    Returns
    -------
    array (orbit, block)
        Not below 1e-300; NaN where the factors are.
    """
    along, across = np.zeros(factors.shape[0]), np.ones(factors.shape[0])
    index = np.empty(factors.shape[:2])
    with np.errstate(all="ignore"):
        for k in range(factors.shape[1]):
            r = factors[:, k]
            along = r[:, 0, 0] * along + r[:, 0, 1] * across
            across = r[:, 1, 1] * across
            size = np.hypot(along, across)
            along, across = along / size, np.maximum(across / size, 1e-300)
            # 2 sin(angle/2) = sin(angle)/cos(angle/2)
            index[:, k] = across / np.sqrt(0.5 * (1.0 + np.abs(along)))
    return index


def zero_one(values: FloatArray, *, rng: np.random.Generator, frequencies: int = 50) -> FloatArray:
    """The 0-1 test for chaos: about 0 for regular motion, about 1 for chaotic motion.

    With phi the values and c a random frequency, the path p(n) = sum phi(j) e^{icj},
    j <= n, stays bounded for regular motion and wanders like Brownian motion for chaotic.
    Its mean-square displacement M(n) less the oscillation (mean phi)^2 (1 - cos cn)/(1 - cos c)
    is correlated with n; the median over c is returned.

    Parameters
    ----------
    values : array (orbit, sample)
        An observable at equal intervals, neither much shorter nor much longer than the
        time over which the motion forgets.
    rng
        Draws the frequencies.
    frequencies
        How many.

    Returns
    -------
    array (orbit,)
        NaN where values are constant or not numbers.
    """
    c = rng.uniform(_LOWEST, _HIGHEST, frequencies)
    count = values.shape[1]
    lags = max(int(_LAGS * count), 2)
    n = np.arange(1.0, lags + 1)
    turn = np.exp(1j * c[:, None] * np.arange(1, count + 1))
    oscillation = (1.0 - np.cos(c[:, None] * n)) / (1.0 - np.cos(c[:, None]))
    result = np.empty(values.shape[0])
    for k, series in enumerate(values):
        path = np.cumsum(series * turn, axis=1)
        moved = _displacement(path, lags) - np.mean(series) ** 2 * oscillation
        result[k] = np.median(_correlation(n, moved))
    return result


def _displacement(path: FloatArray, lags: int) -> FloatArray:
    """Mean over j < N - lags of |p(j + n) - p(j)|^2 for n = 1 ... lags, by convolution."""
    count = path.shape[1] - lags
    path = path - path.mean(axis=1, keepdims=True)
    size = scipy.fft.next_fast_len(path.shape[1] + count)
    spectrum = scipy.fft.fft(path, size, axis=1)
    start = scipy.fft.fft(path[:, :count], size, axis=1)
    mixed = scipy.fft.ifft(spectrum * np.conj(start), axis=1)[:, 1 : lags + 1].real
    square = np.cumsum(np.abs(path) ** 2, axis=1)
    whole = np.concatenate([np.zeros((len(path), 1)), square], axis=1)
    ends = np.arange(1, lags + 1)
    later = whole[:, ends + count] - whole[:, ends]
    return np.asarray((later + square[:, count - 1 : count] - 2.0 * mixed) / count)


def _correlation(n: FloatArray, moved: FloatArray) -> FloatArray:
    a = n - n.mean()
    b = moved - moved.mean(axis=1, keepdims=True)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(b @ a / np.sqrt((a @ a) * np.einsum("cn,cn->c", b, b)))
