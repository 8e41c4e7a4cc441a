"""Lyapunov exponents from the growth of tangents, with their statistical error.

References
----------
G. Benettin, L. Galgani, A. Giorgilli and J.-M. Strelcyn, Meccanica 15 (1980) 9.
C. J. Geyer, Statistical Science 7 (1992) 473 (batch means).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import FloatArray, IntArray

#: Share of a run that is left out: tangents are still turning to the direction that grows.
DEFAULT_TRANSIENT_SHARE = 0.1
#: Standard error of the end of a random walk over the scatter of its swing about the line
#: through both ends; measured, so that 68 % are covered.
_ERROR_PER_SWING = 3.9
#: Numbers of batches from whose scatter the error is estimated.
_BATCH_COUNTS_FOR_ERROR = (10, 20)


@dataclass(frozen=True)
class LyapunovExponents:
    """Exponents of many orbits, per period.

    Attributes
    ----------
    mean : array (orbit, direction)
        Largest first.
    error : array (orbit, direction)
        Standard error of the mean, by the swings of the growth about its trend.
    batch_error : array (orbit, direction)
        The same by means of batches.
    finite_time_error : array (orbit, direction)
        How much of the mean may be growth in proportion to time, as on a torus, which no
        exponent is left of in the end.
    running_mean : array (orbit, block, direction)
        The mean over the blocks so far, the transient included.
    """

    mean: FloatArray
    error: FloatArray
    batch_error: FloatArray
    finite_time_error: FloatArray
    running_mean: FloatArray


def lyapunov_exponents(
    growth: FloatArray, lengths: IntArray, *, transient: float = DEFAULT_TRANSIENT_SHARE
) -> LyapunovExponents:
    """Average the growth of tangents.

    Equation: the exponent of direction j is the mean over blocks of ln R[j, j], divided by
    the periods of a block, R the triangular factor of the tangents after the block.

    Parameters
    ----------
    growth : array (orbit, block, direction)
        Logarithms of growth in each block.
    lengths : array (block,) of int
        Periods of each block.
    transient : float
        Share of the blocks at the beginning that are left out of the mean.
    """
    first = int(transient * lengths.size)
    settled, periods = growth[:, first:], lengths[first:]
    # Contiguous, so that the order of summation does not depend on how many orbits there are.
    series = np.ascontiguousarray(np.moveaxis(settled, 1, -1))
    mean = series.sum(axis=-1) / periods.sum()
    complete = periods == periods[0]  # the last block may be shorter
    batches = batch_means_error(np.ascontiguousarray(series[..., complete])) / periods[0]
    swings = _standard_error_of_swings(series, periods)
    error = np.where(np.isfinite(batches), swings, batches)
    history = np.cumsum(growth, axis=1) / np.cumsum(lengths)[:, None]
    begin, end = lengths[: max(first, 1)].sum(), lengths.sum()
    finite_time = np.minimum(np.abs(mean), np.log(end / begin) / max(end - begin, 1))
    return LyapunovExponents(mean, error, batches, finite_time, history)


def _standard_error_of_swings(series: FloatArray, periods: IntArray) -> FloatArray:
    """Standard error of a mean growth, from how the growth swings about its trend.

    The mean is the change of the logarithm of a tangent's size over the run, divided by its
    length.  That logarithm swings about a straight line through its ends: to and fro with a
    rotation of the tangent, wherever the ends of the run cut it off, or at random.  Batches in
    step with a rotation do not see it.  For growth at random the swing is a Brownian bridge,
    and the factor makes the error cover 68 % of the means.

    Parameters
    ----------
    series : array (orbit, direction, block)
        Logarithms of growth in each block.
    periods : array (block,)
        Periods of each block.
    """
    logs, times = np.cumsum(series, axis=-1), np.cumsum(periods)
    with np.errstate(invalid="ignore"):
        swing = logs - logs[..., -1:] * (times / times[-1])
        return np.asarray(_ERROR_PER_SWING * np.std(swing, axis=-1) / times[-1])


def batch_means_error(values: FloatArray) -> FloatArray:
    """Standard error of the mean along the last axis, by means of batches.

    Neighbouring values are correlated, and so are those of a torus, whose growth swings to
    and fro; means over batches that outlast this are not.  The largest of the errors from
    10 and 20 batches is returned: more batches measure the scatter better, fewer outlast
    longer correlations.

    Parameters
    ----------
    values : array (..., sample)

    Returns
    -------
    array (...)
        Infinite with fewer than ten samples.
    """
    largest = np.zeros(values.shape[:-1])
    for batches in _BATCH_COUNTS_FOR_ERROR:
        length = values.shape[-1] // batches
        if length == 0:
            return (
                largest
                if batches > _BATCH_COUNTS_FOR_ERROR[0]
                else np.full(values.shape[:-1], np.inf)
            )
        latest = values[..., values.shape[-1] - batches * length :]
        means = latest.reshape(*latest.shape[:-1], batches, length).mean(axis=-1)
        with np.errstate(invalid="ignore"):  # growth that was lost has no scatter
            error = np.std(means, axis=-1, ddof=1) / np.sqrt(batches)
        largest = np.where(np.isnan(error), error, np.maximum(largest, error))
    return largest
