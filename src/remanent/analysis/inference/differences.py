"""Derivatives by differences, with an error for each: Richardson's extrapolation."""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray

#: Degree of the polynomial that counts as smooth.
_SMOOTH_DEGREE = 7
#: Of the scatter that is counted over that which few values show.
_SCATTER_FACTOR = 3.0


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
    values: FloatArray, errors: FloatArray, step: float, scale: float
) -> tuple[FloatArray, FloatArray]:
    """Derivative at 0 of functions known at :func:`richardson_offsets`, and its error.

    Central differences D(h) have errors in even powers of h, so T[i, j] = (4^j T[i, j-1] -
    T[i-1, j-1])/(4^j - 1) removes one after the other (Richardson 1911).  The entry is taken
    whose difference from its two neighbours, with what the scatter of the values makes of it, is
    least (Ridders 1982).

    What is wrong with the values is of two kinds.  Their scatter about a smooth function, which
    a polynomial through all of them shows, is divided by the step of a difference.  The rest is
    a smooth function of its own, whose derivative it adds: this is as large as the stated errors
    are over `scale`, or as their own differences, whichever is larger.

    Parameters
    ----------
    values, errors : array (2 levels, function)
        Values, and their stated errors.
    step : float
        Size of the first two offsets.
    scale : float
        Change of the argument over which an error becomes another.

    Returns
    -------
    derivative, error : array (function,)
        NaN and infinite where no entry could be formed.
    """
    levels = len(values) // 2
    sizes = step * 0.5 ** np.arange(levels)[:, None]
    rounding = np.finfo(float).eps * np.abs(values).max(axis=0)
    # No scatter is larger than the stated errors: what is left beyond them is not smooth.
    scatter = np.maximum(np.minimum(_scatter(values, step), errors.max(axis=0)), rounding)
    table = [(values[::2] - values[1::2]) / (2.0 * sizes)]
    wrong = [scatter / sizes]  # what the scatter makes of each entry
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
    largest_slope = (np.abs(errors[::2] - errors[1::2]) / (2.0 * sizes)).max(axis=0)
    return best, error + np.maximum(largest_slope, errors.max(axis=0) / scale)


def _scatter(values: FloatArray, step: float) -> FloatArray:
    """Standard deviation of values about a smooth function, array (function,).

    From what a polynomial through :func:`richardson_offsets` leaves, three times as large, as
    there are few degrees of freedom.
    """
    places = richardson_offsets(step, len(values) // 2) / step
    basis = np.linalg.qr(np.polynomial.legendre.legvander(places, _SMOOTH_DEGREE))[0]
    rest = values - basis @ (basis.T @ values)
    freedom = len(values) - basis.shape[1]
    return np.asarray(_SCATTER_FACTOR * np.sqrt((rest**2).sum(axis=0) / max(freedom, 1)))
