"""When a step response rises and settles: instants at which it passes levels.

A response is monotonic between one turning point and the next.  What it does between them is
therefore decided at the turning points, and nothing is missed between samples.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from remanent._typing import FloatArray, IntArray

#: ``response(t)`` with times (case, instant) gives the response and its rate there.
ResponseAndRateFunction = Callable[[FloatArray], tuple[FloatArray, FloatArray]]
#: Parts into which the way between two turning points is cut at first.
_FIRST_PARTS = 24
#: Steps of Newton's method, kept within the bracket, that follow.
_NEWTON_STEP_COUNT = 8


@dataclass(frozen=True)
class LevelCrossings:
    """Instants at which a response passes levels.

    Attributes
    ----------
    time, miss : array (case, instant)
        The instant, NaN where there is no passage, and by how much it may be off, since the
        response there is not quite the level.
    value, rate : array (case, instant)
        The response there, and its rate.
    """

    time: FloatArray
    miss: FloatArray
    value: FloatArray
    rate: FloatArray


def way_to_level(nodes: FloatArray, levels: FloatArray) -> IntArray:
    """Number of the turning point from which a response first comes to a level or above.

    Parameters
    ----------
    nodes : array (case, node)
        The response at its start, its turning points and its end; NaN after the last.
    levels : array (case, level)

    Returns
    -------
    array (case, level) of int
        -1 where it never comes there, or is there from the start.
    """
    above = nodes[:, :, None] >= levels[:, None, :]
    first = above.argmax(axis=1)
    return np.where(above.any(axis=1), first - 1, -1)


def last_node_outside(nodes: FloatArray, low: FloatArray, high: FloatArray) -> IntArray:
    """Number of the last node outside a band.

    Parameters
    ----------
    nodes : array (case, node)
        The response at its start, its turning points and its end; NaN after the last.
    low, high : array (case, level)
        Ends of the band, which belong to it.

    Returns
    -------
    array (case, level) of int
        -1 where there is none.
    """
    node = nodes[:, :, None]
    outside = (node < low[:, None, :]) | (node > high[:, None, :])
    last = nodes.shape[1] - 1 - outside[:, ::-1].argmax(axis=1)
    return np.where(outside.any(axis=1), last, -1)


def locate_level_crossings(
    response: ResponseAndRateFunction,
    start: FloatArray,
    end: FloatArray,
    levels: FloatArray,
    rising: FloatArray,
) -> LevelCrossings:
    """Where a response passes levels, each within a bracket in which it is monotonic.

    Parameters
    ----------
    response : callable
        Of times (case, instant): its values and its rates.
    start, end : array (case, instant)
        The brackets; NaN where there is none.
    levels : array (case, instant)
    rising : array (case, instant)
        1 where the response rises through the bracket, -1 where it falls.
    """
    known = np.isfinite(start + end)
    low, high = np.where(known, start, 0.0), np.where(known, end, 0.0)
    part = np.linspace(0.0, 1.0, _FIRST_PARTS + 1)[1:-1]
    times = low[..., None] + (high - low)[..., None] * part
    cases, count, inner = times.shape
    values = response(times.reshape(cases, count * inner))[0].reshape(times.shape)
    before = rising[..., None] * (values - levels[..., None]) < 0.0
    passed = before.sum(axis=-1)[..., None]
    nodes = np.concatenate([low[..., None], times, high[..., None]], axis=-1)
    low, high = (np.take_along_axis(nodes, passed + k, axis=-1)[..., 0] for k in (0, 1))
    t = 0.5 * (low + high)
    for _ in range(_NEWTON_STEP_COUNT):
        value, rate = response(t)
        left = value - levels
        low, high = np.where(rising * left < 0.0, t, low), np.where(rising * left < 0.0, high, t)
        with np.errstate(all="ignore"):
            moved = t - left / rate
        inside = (moved >= low) & (moved <= high)
        t = np.where(inside, moved, 0.5 * (low + high))
    value, rate = response(t)
    with np.errstate(all="ignore"):
        miss = np.fmin(2.0 * np.abs((value - levels) / rate), high - low)  # half the way at a turn
    return LevelCrossings(*(np.where(known, column, np.nan) for column in (t, miss, value, rate)))
