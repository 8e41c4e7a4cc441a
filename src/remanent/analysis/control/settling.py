"""When a sampled answer to a step rises and settles: instants at which levels are passed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from remanent._typing import FloatArray, IntArray

#: ``response(t)`` with times (case, instant) gives the answer and its rate there.
Response = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
#: Newton steps from the middle between two samples, of which a period has many.
_NEWTON_STEPS = 5


@dataclass(frozen=True)
class LevelCrossings:
    """Instants at which an answer passes levels.

    Attributes
    ----------
    time, rate : array (case, instant)
        NaN where there is no passage.
    """

    time: FloatArray
    rate: FloatArray


def first_above(answer: FloatArray, level: float) -> IntArray:
    """Number of the first sample at or above a level, -1 without one; array (case,)."""
    above = answer >= level
    return np.where(above.any(axis=1), above.argmax(axis=1), -1)


def last_outside(answer: FloatArray, low: float, high: float) -> IntArray:
    """Number of the last sample outside a band, -1 without one; array (case,)."""
    outside = ~((answer >= low) & (answer <= high))
    last = answer.shape[1] - 1 - outside[:, ::-1].argmax(axis=1)
    return np.where(outside.any(axis=1), last, -1)


def level_crossings(
    response: Response, times: FloatArray, before: IntArray, levels: FloatArray
) -> LevelCrossings:
    """Where an answer passes levels between a sample and the next, by Newton's method.

    Parameters
    ----------
    response : callable
        Of times (case, instant): the answer and its rate.
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
    for _ in range(_NEWTON_STEPS):
        answer, rate = response(t)
        with np.errstate(all="ignore"):
            moved = t - (answer - levels) / rate
        t = np.where(np.isfinite(moved), moved, t).clip(low, high)
    return LevelCrossings(np.where(bracketed, t, np.nan), np.where(bracketed, rate, np.nan))
