"""Where a force vanishes, for many cases at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import elementwise

from remanent._typing import FloatArray, IntArray

#: ``force(case, x)`` with arrays (point,) gives the force (point,).
Force = Callable[[IntArray, Any], Any]


def zeros(force: Force, cases: int, grid: FloatArray) -> FloatArray:
    """All sign changes of a force that a grid resolves.

    Parameters
    ----------
    force
        Vectorised over cases and positions.
    cases
        How many cases there are.
    grid : array (point,)
        Increasing positions.  Two zeros between neighbours are not seen.

    Returns
    -------
    array (case, zero)
        Ascending in every row; NaN after the last.
    """
    index, x = np.repeat(np.arange(cases), grid.size), np.tile(grid, cases)
    values = np.asarray(force(index, x)).reshape(cases, grid.size)
    case, k = np.nonzero(np.sign(values[:, 1:]) * np.sign(values[:, :-1]) < 0)
    exact_case, exact_k = np.nonzero(values == 0.0)
    roots = np.empty(0)
    if case.size:
        find_root: Any = elementwise.find_root  # its stubs do not know `args`
        solved = find_root(lambda x, i: force(i, x), (grid[k], grid[k + 1]), args=(case,))
        roots = np.asarray(solved.x)
    return _rows(np.concatenate([case, exact_case]), np.concatenate([roots, grid[exact_k]]), cases)


def slope(force: Force, case: IntArray, x: FloatArray) -> FloatArray:
    """Derivative of a force by a complex step: exact to round-off."""
    step = 1e-100
    return np.asarray(np.imag(force(case, x + 1j * step)) / step)


def _rows(case: IntArray, x: FloatArray, cases: int) -> FloatArray:
    order = np.lexsort((x, case))
    case, x = case[order], x[order]
    count = np.bincount(case, minlength=cases)
    rank = np.arange(case.size) - np.repeat(np.cumsum(count) - count, count)
    rows = np.full((cases, int(count.max(initial=0))), np.nan)
    rows[case, rank] = x
    return rows
