"""Folds and period doublings of orbits in extended precision, by Newton's method.

Unknowns are the state and one parameter, equations P^n(x) = x and det(J - 1) = 0 at a fold,
det(J + 1) = 0 at a doubling.  Derivatives that the variational equations do not give are
differences in extended precision.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.errors.period_map import CONVERGED, LONG, MAX_NEWTON_STEPS, PeriodMap
from remanent._typing import FloatArray

#: Half the distance over which determinants are differenced.
DIFFERENCE = LONG(1e-6)
#: Derivatives are taken anew after steps longer than this.
FRESH_DERIVATIVES_BEYOND = 1e-3
#: Largest Newton step.
LARGEST_STEP = 0.02
#: det(J + sign 1) vanishes.
SIGN = {"fold": -1, "period doubling": 1}


def special_point(
    map_: PeriodMap, kind: str, parameter: str, start: Any, periods: int
) -> FloatArray | None:
    """Stretch, rate and parameter of the special point near `start`; None if none is found."""
    z, derivative, size = np.asarray(start, dtype=LONG), None, np.inf
    for _ in range(MAX_NEWTON_STEPS):
        # Near the solution the derivatives that are known do as well.
        fresh = size > FRESH_DERIVATIVES_BEYOND
        value, new = _system(map_, kind, parameter, z, periods, differentiate=fresh)
        derivative = new if fresh else derivative
        if not np.isfinite(value.astype(float)).all():
            return None
        step = solve(derivative, -value)
        size = float(np.abs(step).max())
        if not np.isfinite(size):
            return None
        z = z + step * min(1.0, LARGEST_STEP / max(size, 1e-300))
        if not z[0] > 0:
            return None
        if size < CONVERGED:
            return np.asarray(z)
    return None


def at(map_: PeriodMap, parameter: str, value: Any) -> PeriodMap:
    """The same map with another value of a parameter, in extended precision."""
    return replace(map_, values={**map_.values, parameter: value})


def _system(
    map_: PeriodMap, kind: str, parameter: str, z: Any, periods: int, *, differentiate: bool
) -> tuple[Any, Any]:
    """The three equations, and their derivatives where these are wanted."""

    def parts(place: Any) -> tuple[Any, Any, Any]:
        image, jacobian = at(map_, parameter, place[2]).image(place[:2], periods)
        moved = jacobian + SIGN[kind] * np.eye(2, dtype=LONG)
        return image - place[:2], jacobian, moved[0, 0] * moved[1, 1] - moved[0, 1] * moved[1, 0]

    defect, jacobian, determinant = parts(z)
    value = np.array([*defect, determinant], dtype=LONG)
    if not differentiate:
        return value, None
    derivative = np.zeros((3, 3), dtype=LONG)
    derivative[:2, :2] = jacobian - np.eye(2, dtype=LONG)
    for k in range(3):
        step = DIFFERENCE * np.eye(3, dtype=LONG)[k]
        after, before = parts(z + step), parts(z - step)
        derivative[2, k] = (after[2] - before[2]) / (2 * DIFFERENCE)
        if k == 2:
            derivative[:2, 2] = (after[0] - before[0]) / (2 * DIFFERENCE)
    return value, derivative


def solve(matrix: Any, vector: Any) -> Any:
    """Gauss's elimination with pivots: NumPy's solver knows no extended precision."""
    rows = np.concatenate([matrix, vector[:, None]], axis=1)
    size = len(rows)
    for k in range(size):
        pivot = k + int(np.argmax(np.abs(rows[k:, k]).astype(float)))
        rows[[k, pivot]] = rows[[pivot, k]]
        if rows[k, k] == 0:
            return np.full(size, np.nan, dtype=LONG)
        rows[k] = rows[k] / rows[k, k]
        others = np.arange(size) != k
        rows[others] = rows[others] - rows[others, k][:, None] * rows[k]
    return rows[:, -1]
