"""Where a force vanishes, for many cases at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from remanent._roots import find_roots
from remanent._typing import FloatArray, IntArray

#: Step of a complex difference: it loses no digits however small it is.
_COMPLEX_STEP = 1e-100

#: At how many points a force is evaluated at once, so that its intermediate arrays stay in the
#: cache of a core: those of a large ensemble would fill the memory.
_POINTS_AT_ONCE = 32_768

#: ``force(case, x)`` with arrays (point,) gives the force (point,).
ForceFunction = Callable[[IntArray, Any], Any]
#: ``force(case, x, p)`` gives the same for values (point,) of a parameter, such as the load.
LoadedForceFunction = Callable[[IntArray, Any, Any], Any]


def find_force_zeros(force: ForceFunction, cases: int, grid: FloatArray) -> FloatArray:
    """All sign changes of a force that a grid resolves.

    Parameters
    ----------
    force : callable
        Of arrays (point,) of cases and positions.
    cases : int
        How many cases there are.
    grid : array (point,) or (case, point)
        Increasing positions.  Two zeros between neighbours are not seen, nor any beside a
        place where the force is NaN.  A pole is no zero.

    Returns
    -------
    array (case, zero)
        Ascending in every row; NaN after the last.
    """
    grid = np.broadcast_to(grid, (cases, np.shape(grid)[-1]))
    values = _values_on_grid(force, grid)
    case, k = np.nonzero(np.sign(values[:, 1:]) * np.sign(values[:, :-1]) < 0)
    exact_case, exact_k = np.nonzero(values == 0.0)
    roots = np.empty(0)
    if case.size:
        ends = grid[case, k], grid[case, k + 1]
        with np.errstate(all="ignore"):  # forces may have poles
            solved = find_roots(lambda x, i: force(i, x), ends, args=(case,))
        # A force falls towards a zero and grows towards a pole.
        at_ends = np.minimum(np.abs(values[case, k]), np.abs(values[case, k + 1]))
        is_zero = np.abs(solved.f_x) <= at_ends
        case, roots = case[is_zero], np.asarray(solved.x)[is_zero]
    exact = grid[exact_case, exact_k]
    return _sort_into_rows(
        np.concatenate([case, exact_case]), np.concatenate([roots, exact]), cases
    )


def balancing_parameter(
    force: LoadedForceFunction, bounds: tuple[FloatArray, FloatArray], case: IntArray, x: FloatArray
) -> FloatArray:
    """The parameter within bounds at which a force vanishes at `x`; NaN where there is none.

    Parameters
    ----------
    force : callable
        Of arrays (point,) of cases, positions and the parameter; monotonic in the parameter
        between the bounds.
    bounds : two arrays (case,)
        Least and largest value of the parameter.
    case, x : array (point,)
        Where the force is to vanish.

    Returns
    -------
    array (point,)
    """
    low, high = (np.broadcast_to(end[case], np.shape(x)) for end in bounds)
    ends = np.asarray(force(case, x, low)), np.asarray(force(case, x, high))
    parameter = np.full(np.shape(x), np.nan)
    with np.errstate(invalid="ignore"):
        bracketed = np.nonzero((np.sign(ends[0]) * np.sign(ends[1]) <= 0) & (ends[0] != ends[1]))
    if bracketed[0].size:
        with np.errstate(all="ignore"):  # forces may have poles
            solved = find_roots(
                lambda p, i, y: force(i, y, p),
                (low[bracketed], high[bracketed]),
                args=(case[bracketed], x[bracketed]),
            )
        parameter[bracketed] = solved.x
    return parameter


def force_slope(force: ForceFunction, case: IntArray, x: FloatArray) -> FloatArray:
    """Derivative of a force by x: exact to round-off, by a complex step.

    Equation: f'(x) = Im f(x + ih)/h + O(h^2), without a difference of nearly equal numbers.

    Parameters
    ----------
    force : callable
        Analytic, and computed with complex numbers.
    case, x : array (point,)

    Returns
    -------
    array (point,)
        Infinite where it is beyond floats.
    """
    with np.errstate(over="ignore"):
        return np.asarray(np.imag(force(case, x + 1j * _COMPLEX_STEP)) / _COMPLEX_STEP)


def _values_on_grid(force: ForceFunction, grid: FloatArray) -> FloatArray:
    """The force of each case at its positions, array (case, point), some cases at a time."""
    cases, points = grid.shape
    values = np.empty(grid.shape)
    at_once = max(_POINTS_AT_ONCE // points, 1)
    for first in range(0, cases, at_once):
        block = np.arange(first, min(first + at_once, cases))
        found = np.asarray(force(np.repeat(block, points), grid[block].ravel()))
        values[block] = found.reshape(-1, points)
    return values


def _sort_into_rows(case: IntArray, x: FloatArray, cases: int) -> FloatArray:
    """Positions sorted into one row for each case, filled up with NaN."""
    order = np.lexsort((x, case))
    case, x = case[order], x[order]
    count = np.bincount(case, minlength=cases)
    rank = np.arange(case.size) - np.repeat(np.cumsum(count) - count, count)
    rows = np.full((cases, int(count.max(initial=0))), np.nan)
    rows[case, rank] = x
    return rows
