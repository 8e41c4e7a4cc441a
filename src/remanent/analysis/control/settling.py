"""When a sampled answer to a step rises and settles: instants at which levels are passed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from remanent._typing import FloatArray, IntArray

#: ``measure(t)`` with times (case, instant) gives the answer and its rate there.
Response = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
#: Newton steps from a bracket between samples, many to a period.
_ROUNDS = 5


@dataclass(frozen=True)
class LevelCrossings:
    """Instants (case, instant), NaN where there is none, and the rates there."""

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
    measure: Response, times: FloatArray, before: IntArray, levels: FloatArray
) -> LevelCrossings:
    """Where an answer passes levels between a sample and the next, by Newton's method.

    Parameters
    ----------
    times : array (case, sample)
    before : array (case, instant)
        Number of the sample before the passage; out of range where there is none.
    levels : array (case, instant)
    """
    known = (before >= 0) & (before < times.shape[1] - 1)
    k = np.where(known, before, 0)
    row = np.arange(len(times))[:, None]
    low, high = times[row, k], times[row, k + 1]
    t = 0.5 * (low + high)
    rate = np.ones_like(t)
    for _ in range(_ROUNDS):
        answer, rate = measure(t)
        with np.errstate(all="ignore"):
            moved = t - (answer - levels) / rate
        t = np.where(np.isfinite(moved), moved, t).clip(low, high)
    return LevelCrossings(np.where(known, t, np.nan), np.where(known, rate, np.nan))
