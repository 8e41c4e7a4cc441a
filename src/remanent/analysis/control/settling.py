"""When a sampled step response rises and settles: instants at which it passes levels."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from remanent._typing import FloatArray, IntArray

#: ``response(t)`` with times (case, instant) gives the response and its rate there.
ResponseAndRateFunction = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
#: Newton steps from the middle between two samples, of which a period has many.
_NEWTON_STEP_COUNT = 5


@dataclass(frozen=True)
class LevelCrossings:
    """Instants at which a response passes levels.

    Attributes
    ----------
    time, rate : array (case, instant)
        NaN where there is no passage.
    """

    time: FloatArray
    rate: FloatArray


def first_index_at_or_above(response: FloatArray, level: float) -> IntArray:
    """Number of the first sample at or above a level.

    Parameters
    ----------
    response : array (case, sample)
    level : float

    Returns
    -------
    array (case,) of int
        -1 where there is none.
    """
    above = response >= level
    return np.where(above.any(axis=1), above.argmax(axis=1), -1)


def last_index_outside_band(response: FloatArray, low: float, high: float) -> IntArray:
    """Number of the last sample outside a band.

    Parameters
    ----------
    response : array (case, sample)
    low, high : float
        Ends of the band, which belong to it.

    Returns
    -------
    array (case,) of int
        -1 where there is none.
    """
    outside = ~((response >= low) & (response <= high))
    last = response.shape[1] - 1 - outside[:, ::-1].argmax(axis=1)
    return np.where(outside.any(axis=1), last, -1)


def locate_level_crossings(
    response: ResponseAndRateFunction, times: FloatArray, before: IntArray, levels: FloatArray
) -> LevelCrossings:
    """Where a response passes levels between a sample and the next, by Newton's method.

    Parameters
    ----------
    response : callable
        Of times (case, instant): its values and its rates.
    times : array (case, sample)
    before : array (case, instant) of int
        Number of the sample before the passage; out of range where there is none.
    levels : array (case, instant)
    """
    bracketed = (before >= 0) & (before < times.shape[1] - 1)
    k = np.where(bracketed, before, 0)
    row = np.arange(len(times))[:, None]
    low, high = times[row, k], times[row, k + 1]
    t = 0.5 * (low + high)
    rate = np.ones_like(t)
    for _ in range(_NEWTON_STEP_COUNT):
        value, rate = response(t)
        with np.errstate(all="ignore"):
            moved = t - (value - levels) / rate
        t = np.where(np.isfinite(moved), moved, t).clip(low, high)
    return LevelCrossings(np.where(bracketed, t, np.nan), np.where(bracketed, rate, np.nan))
