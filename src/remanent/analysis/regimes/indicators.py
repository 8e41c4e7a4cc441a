"""Indicators that tell order from chaos: alignment of tangents, the 0-1 test.

References
----------
C. Skokos, J. Phys. A 34 (2001) 10029 (smaller alignment index).
G. A. Gottwald and I. Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129 (0-1 test).
"""

from __future__ import annotations

import numpy as np
from scipy import fft

from remanent._threads import raise_if_stopped
from remanent._typing import FloatArray

#: Lowest frequency of the 0-1 test: near 0 it resonates with slow drifts.
_MIN_TEST_FREQUENCY = np.pi / 5.0
#: Highest frequency of the 0-1 test: near pi it resonates with drifts that alternate.
_MAX_TEST_FREQUENCY = 4.0 * np.pi / 5.0
#: Longest lag of the mean-square displacement, as a share of the series.
_MAX_LAG_SHARE = 0.1
#: Products phi(j + a) phi(j + b) in memory at once.
_MAX_PRODUCTS_IN_MEMORY = 2**17
#: Longest lag up to which products are faster than Fourier transforms, and fit into memory.
_MAX_LAG_OF_PRODUCTS = 512
#: Smallest index that is returned: the angle between tangents that lined up is rounding.
_MIN_ALIGNMENT_INDEX = 1e-300


def smaller_alignment_index(factors: FloatArray) -> FloatArray:
    """Smaller alignment index of two tangents after each block.

    The index is min(|u - w|, |u + w|) of the unit tangents u, w.  It needs tangents that were
    never made orthogonal; those that are carried along for the exponents were.  But the
    triangular factors that made them so say how u and w would stand: u stays along the first
    row, and the components of w along both rows follow from the factors.  The index falls as
    exp(-(difference of the two largest exponents) n) in chaos, and as a power of n, or not at
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
    parallel, perpendicular = np.zeros(factors.shape[0]), np.ones(factors.shape[0])
    index = np.empty(factors.shape[:2])
    with np.errstate(all="ignore"):
        for k in range(factors.shape[1]):
            raise_if_stopped()
            r = factors[:, k]
            parallel = r[:, 0, 0] * parallel + r[:, 0, 1] * perpendicular
            perpendicular = r[:, 1, 1] * perpendicular
            size = np.hypot(parallel, perpendicular)
            parallel, perpendicular = (
                parallel / size,
                np.maximum(perpendicular / size, _MIN_ALIGNMENT_INDEX),
            )
            # 2 sin(angle/2) = sin(angle)/cos(angle/2)
            index[:, k] = perpendicular / np.sqrt(0.5 * (1.0 + np.abs(parallel)))
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
    rng : numpy.random.Generator
        Draws the frequencies.
    frequencies : int
        How many.

    Returns
    -------
    array (orbit,)
        NaN where values are constant or not numbers.
    """
    c = rng.uniform(_MIN_TEST_FREQUENCY, _MAX_TEST_FREQUENCY, frequencies)
    lags = max(int(_MAX_LAG_SHARE * values.shape[1]), 2)
    n = np.arange(1.0, lags + 1)
    oscillation = (1.0 - np.cos(np.outer(n, c))) / (1.0 - np.cos(c))
    batch = max(_MAX_PRODUCTS_IN_MEMORY // lags**2, 1)
    is_long = lags > _MAX_LAG_OF_PRODUCTS
    displacement_of = (
        mean_square_displacement_by_transforms if is_long else mean_square_displacement
    )
    result = np.empty(values.shape[0])
    for first in range(0, values.shape[0], batch):
        series = np.ascontiguousarray(values[first : first + batch])
        mean = np.mean(series, axis=1)[:, None, None]
        displacement = displacement_of(series, c, lags) - mean**2 * oscillation
        result[first : first + batch] = np.median(_correlation_with_time(n, displacement), axis=1)
    return result


def mean_square_displacement(series: FloatArray, c: FloatArray, lags: int) -> FloatArray:
    """Mean over j = 1 ... N - lags of |p(j + n) - p(j)|^2, array (orbit, n, frequency).

    It is the sum over a, b <= n of cos(c (a - b)) R[a, b], where R[a, b] is the average over j of
    phi(j + a) phi(j + b).  R does not depend on c, so it serves all frequencies.  And R[a + 1,
    b + 1] is R[a, b] but for the first and the last term of the average, so an average is made
    only once for each difference d = a - b, and the rest is a running sum of these two terms.
    Work and memory grow as the square of the number of lags.
    """
    count = series.shape[1] - lags
    d = np.arange(lags)
    start, phi = series[:, 1 : count + 1], np.ascontiguousarray(series.T)
    averages = np.zeros((lags, lags, len(series)))  # of a = k + 1 and b = k + 1 - d, at k and d
    for k in range(lags):
        # The first entry of its difference, from which the running sum starts.
        averages[k, k] = np.einsum("pj,pj->p", start, series[:, 1 + k : count + 1 + k]) / count
        if k > 0:
            others = averages[k, :k]
            np.multiply(phi[count + k], phi[count + k : count : -1], out=others)
            others -= phi[k] * phi[k:0:-1]
            others /= count
            others += averages[k - 1, :k]
    turned = np.where(d > 0, 2.0, 1.0)[:, None] * np.cos(np.outer(d, c))
    # Orbits first, so that each is multiplied by itself, in the same order in any company.
    displacement = np.ascontiguousarray(np.moveaxis(averages, 2, 0)) @ turned
    return np.cumsum(displacement, axis=1, out=displacement)


def mean_square_displacement_by_transforms(
    series: FloatArray, c: FloatArray, lags: int
) -> FloatArray:
    """The same for long series, array (orbit, n, frequency).

    With the square multiplied out, the mixed term is a correlation of p with its first part,
    which Fourier transforms give for all n at once.
    """
    samples = series.shape[1]
    count = samples - lags
    length = fft.next_fast_len(samples + count)
    j = np.arange(1.0, samples + 1)
    displacement = np.empty((len(series), lags, c.size))
    for row, values in enumerate(series):
        for column, frequency in enumerate(c):
            raise_if_stopped()
            p = np.cumsum(values * np.exp(1j * frequency * j))
            spectrum = fft.fft(p, length) * np.conj(fft.fft(p[:count], length))
            mixed = fft.ifft(spectrum)[1 : lags + 1].real
            squares = np.concatenate([[0.0], np.cumsum(np.abs(p) ** 2)])
            sums = squares[count:] - squares[: lags + 1]  # over j + n, for n = 0 to the longest lag
            displacement[row, :, column] = (sums[1:] + sums[0] - 2.0 * mixed) / count
    return displacement


def _correlation_with_time(n: FloatArray, displacement: FloatArray) -> FloatArray:
    """Correlation of displacements (orbit, n, frequency) with n, array (orbit, frequency)."""
    a = n - n.mean()
    b = np.moveaxis(displacement - displacement.mean(axis=1, keepdims=True), 1, 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(b @ a / np.sqrt((a @ a) * np.einsum("pcn,pcn->pc", b, b)))
