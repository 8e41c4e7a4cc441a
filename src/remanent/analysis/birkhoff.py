"""Weighted Birkhoff averages: how fast time averages settle tells order from chaos.

References
----------
S. Das, Y. Saiki, E. Sander and J. A. Yorke, Nonlinearity 30 (2017) 4111.
"""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray


def weighted_average(values: FloatArray) -> FloatArray:
    """Average along the last axis with the smooth weight exp(-1/(s(1 - s))).

    Along a quasi-periodic orbit its error falls faster than any power of the number of
    values; along a chaotic one as its inverse square root.

    Parameters
    ----------
    values : array (..., sample)

    Returns
    -------
    array (...)
    """
    s = np.arange(1, values.shape[-1] + 1) / (values.shape[-1] + 1)
    weight = np.exp(-1.0 / (s * (1.0 - s)))
    return np.asarray(np.sum(values * (weight / weight.sum()), axis=-1))


def converged_digits(values: FloatArray) -> FloatArray:
    """Decimal digits on which the averages of the two halves agree.

    Parameters
    ----------
    values : array (..., sample)
        Of one observable along an orbit, at equal intervals.

    Returns
    -------
    array (...)
        -log10 of the difference of the averages over the first and the second half,
        relative to the standard deviation of the values; at most 16; NaN where a value
        is.
    """
    half = values.shape[-1] // 2
    first, second = weighted_average(values[..., :half]), weighted_average(values[..., half:])
    spread = np.std(values, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        digits = -np.log10(np.abs(first - second) / spread)
    return np.asarray(np.where(spread == 0.0, 16.0, np.minimum(digits, 16.0)))
