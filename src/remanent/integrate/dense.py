"""States between steps: the Hermite polynomial through five steps' ends.

The ends of steps carry the state and its rate; the polynomial of degree 9 through
five of them has an error of order 10 in the step, two more than the method's.
"""

from __future__ import annotations

from functools import cache

import numpy as np

from remanent._typing import FloatArray, IntArray

#: Ends of steps that a polynomial passes through.
NODES = 5


@cache
def _slopes() -> FloatArray:
    """Slope at its own node of each Lagrange polynomial on the nodes 0, 1 ... 4."""
    nodes = range(NODES)
    return np.array([sum(1.0 / (i - j) for j in nodes if j != i) for i in nodes])


def _hermite(position: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The Hermite basis (..., node) of values and of slopes, in product form."""
    away = position[..., None] - np.arange(NODES)
    lagrange = np.empty_like(away)
    for i in range(NODES):
        others = [j for j in range(NODES) if j != i]
        lagrange[..., i] = np.prod(away[..., others] / (i - np.array(others)), axis=-1)
    square = lagrange**2
    return square * (1.0 - 2.0 * _slopes() * away), square * away


def first_nodes(position: FloatArray, steps: int) -> IntArray:
    """Which five step ends surround a position best.

    Parameters
    ----------
    position
        Time in steps from the first stored end.
    steps
        Number of steps stored; at least ``NODES - 1``.

    Returns
    -------
    array
        Index of the first of the five ends.
    """
    nearest = np.rint(np.nan_to_num(position)).astype(np.int64)
    return np.clip(nearest - NODES // 2, 0, steps - NODES + 1)


def interpolate(
    states: FloatArray, rates: FloatArray, step: FloatArray, position: FloatArray
) -> FloatArray:
    """The state at any position among five step ends.

    Parameters
    ----------
    states, rates : array (..., 5, state)
        At the five ends.
    step : array (...)
        Length of a step.
    position : array (...)
        Time from the first of the five, in steps; an integer gives that state exactly.

    Returns
    -------
    array (..., state)
    """
    values, slopes = _hermite(position)
    result = np.einsum("...n,...ns->...s", values, states)
    result += step[..., None] * np.einsum("...n,...ns->...s", slopes, rates)
    return np.asarray(result)
