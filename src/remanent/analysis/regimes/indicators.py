"""Indicators that tell order from chaos: alignment of tangents, the 0-1 test.

References
----------
C. Skokos, J. Phys. A 34 (2001) 10029 (smaller alignment index).
G. A. Gottwald and I. Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129 (0-1 test).
"""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray

#: Frequencies are drawn away from 0 and pi, where the test resonates with slow drifts.
_LOWEST, _HIGHEST = np.pi / 5.0, 4.0 * np.pi / 5.0
#: The mean-square displacement is followed over this share of the series.
_LAGS = 0.1
#: Products in memory at once.
_TOGETHER = 2**17


def smaller_alignment_index(factors: FloatArray) -> FloatArray:
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


def zero_one_test(
    values: FloatArray, *, rng: np.random.Generator, frequencies: int = 50
) -> FloatArray:
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
    lags = max(int(_LAGS * values.shape[1]), 2)
    n = np.arange(1.0, lags + 1)
    oscillation = (1.0 - np.cos(np.outer(n, c))) / (1.0 - np.cos(c))
    each = max(_TOGETHER // lags**2, 1)
    result = np.empty(values.shape[0])
    for first in range(0, values.shape[0], each):
        series = np.ascontiguousarray(values[first : first + each])
        mean = np.mean(series, axis=1)[:, None, None]
        moved = _displacement(series, c, lags) - mean**2 * oscillation
        result[first : first + each] = np.median(_correlation(n, moved), axis=1)
    return result


def _displacement(series: FloatArray, c: FloatArray, lags: int) -> FloatArray:
    """Mean over j = 1 ... N - lags of |p(j + n) - p(j)|^2, array (orbit, n, frequency).

    It is the sum over a, b <= n of cos(c (a - b)) R[a, b], R the products phi(j + a) phi(j + b)
    averaged over j, which know nothing of c; and R[a + 1, b + 1] is R[a, b] but for the ends
    of the average.  So the averages are made once for each difference a - b.
    """
    count = series.shape[1] - lags
    n, d = np.arange(1, lags + 1)[:, None], np.arange(lags)
    start = series[:, 1 : count + 1]
    products = np.empty((len(series), lags, lags))  # of a = n and b = n - d
    last, first = n - 1, np.maximum(n - 1 - d, 0)
    ends = series[:, count + last] * series[:, count + first] - series[:, last] * series[:, first]
    products[:] = np.where(n > d + 1, ends / count, 0.0)
    for k in d:
        products[:, k, k] = np.einsum("pj,pj->p", start, series[:, 1 + k : count + 1 + k]) / count
    products = np.cumsum(products, axis=1)
    turned = np.where(d > 0, 2.0, 1.0)[:, None] * np.cos(np.outer(d, c))
    return np.cumsum(products @ turned, axis=1)


def _correlation(n: FloatArray, moved: FloatArray) -> FloatArray:
    a = n - n.mean()
    b = np.moveaxis(moved - moved.mean(axis=1, keepdims=True), 1, 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(b @ a / np.sqrt((a @ a) * np.einsum("pcn,pcn->pc", b, b)))
