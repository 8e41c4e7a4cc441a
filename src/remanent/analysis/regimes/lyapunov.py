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
        Standard error of the mean.
    running_mean : array (orbit, block, direction)
        The mean over the blocks so far, the transient included.
    """

    mean: FloatArray
    error: FloatArray
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
    error = batch_means_error(np.ascontiguousarray(series[..., complete])) / periods[0]
    history = np.cumsum(growth, axis=1) / np.cumsum(lengths)[:, None]
    return LyapunovExponents(mean, error, history)


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
        error = np.std(means, axis=-1, ddof=1) / np.sqrt(batches)
        largest = np.where(np.isnan(error), error, np.maximum(largest, error))
    return largest
