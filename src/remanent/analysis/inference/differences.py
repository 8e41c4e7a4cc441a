"""Derivatives by differences, with an error for each: Richardson's extrapolation."""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray


def richardson_offsets(step: float, levels: int) -> FloatArray:
    """Where a function has to be evaluated: +h, -h, +h/2, -h/2 ..., array (2 levels,).

    Parameters
    ----------
    step : float
        The largest, h.
    levels : int
        How often it is halved, and once more.
    """
    sizes = step * 0.5 ** np.arange(levels)
    return np.stack([sizes, -sizes], axis=1).ravel()


def richardson_derivative(
    values: FloatArray, noise: FloatArray, step: float
) -> tuple[FloatArray, FloatArray]:
    """Derivative at 0 of functions known at :func:`richardson_offsets`, and its error.

    Central differences D(h) have errors in even powers of h, so T[i, j] = (4^j T[i, j-1] -
    T[i-1, j-1])/(4^j - 1) removes one after the other (Richardson 1911).  The entry is taken
    whose difference from its two neighbours, with what the noise makes of it, is least
    (Ridders 1982); that sum is the error.

    Parameters
    ----------
    values, noise : array (2 levels, function)
        Values, and their errors.
    step : float
        Size of the first two offsets.

    Returns
    -------
    derivative, error : array (function,)
        NaN and infinite where no entry could be formed.
    """
    levels = len(values) // 2
    sizes = step * 0.5 ** np.arange(levels)[:, None]
    table = [(values[::2] - values[1::2]) / (2.0 * sizes)]
    wrong = [(noise[::2] + noise[1::2]) / (2.0 * sizes)]  # what the noise makes of each entry
    best, error = np.full(values.shape[1], np.nan), np.full(values.shape[1], np.inf)
    for j in range(1, levels):
        power = 4.0**j
        fine, coarse = table[-1][1:], table[-1][:-1]
        table.append((power * fine - coarse) / (power - 1.0))
        wrong.append((power * wrong[-1][1:] + wrong[-1][:-1]) / (power - 1.0))
        difference = np.maximum(np.abs(table[-1] - fine), np.abs(table[-1] - coarse))
        for row, doubt in zip(table[-1], difference + wrong[-1], strict=True):
            better = doubt < error
            best, error = np.where(better, row, best), np.where(better, doubt, error)
    return best, error
