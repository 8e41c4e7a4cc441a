"""Periodic orbits moved until their errors are within a tolerance, as far as numbers allow."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.errors import OrbitErrors, orbit_errors
from remanent.analysis.orbits.maps import Map
from remanent.analysis.orbits.periodic_orbits import fixed_point_newton_step
from remanent.analysis.orbits.point_rows import replace_rows, subset_of_rows

#: Newton steps at most with one map.
_MAX_NEWTON_STEPS = 6
#: Newton's method ends where its step is below this share of the tolerance.
_STEP_OVER_TOLERANCE = 0.1
#: So does it where the step is below what the map's error makes of it: it cannot become smaller.
_STEP_OVER_ERROR_OF_MAP = 0.5
#: A finer map is to leave this share of the tolerance to the errors of its steps.
_SHARE_OF_MAP = 0.3
#: Finer maps help where their steps make more than this multiple of what rounding makes.
_MIN_MAP_OVER_ROUNDING = 2.0
#: Most levels at once.
_MAX_LEVELS_AT_ONCE = 16.0
#: Longest Newton step: farther away is another orbit.
_MAX_STEP = 1e-2


def refine_orbits(
    map_of_level: Callable[[int], Map],
    finest_level: int,
    states: FloatArray,
    parameters: FloatArray,
    iterate: int,
    tolerance: float,
) -> OrbitErrors:
    """Move points onto periodic orbits, until the error of each is within the tolerance.

    Where it is not, the map with the finest steps that help was used.  What becomes of a point
    depends on the point alone.

    Parameters
    ----------
    map_of_level : callable
        ``map_of_level(k)``: the map with errors 10**k times smaller than at level 0.
    finest_level : int
        Last level there is.
    states : array (orbit, state)
        Near orbits.
    parameters : array (orbit, parameter)
    iterate : int
        Periods after which the orbits close.
    tolerance : float
        Of the error of each variable of the state.
    """
    level = np.zeros(len(states), dtype=np.int64)
    best = _converged(map_of_level(0), states, parameters, iterate, tolerance)
    pending = np.flatnonzero(~(best.error <= tolerance))
    while pending.size:
        level[pending] = _next_levels(subset_of_rows(best, pending), level[pending], tolerance)
        pending = pending[level[pending] <= finest_level]
        for k in np.unique(level[pending]):
            members = pending[level[pending] == k]
            finer = _converged(
                map_of_level(int(k)), best.state[members], parameters[members], iterate, tolerance
            )
            better = _is_better(finer, subset_of_rows(best, members))
            best = replace_rows(best, members[better], subset_of_rows(finer, better))
            # Where a finer map has not helped, a still finer one will not.
            stuck = members[~better & best.is_confirmed[members]]
            level[stuck] = finest_level
        pending = pending[~(best.error[pending] <= tolerance)]
    return best


def _converged(
    map_: Map, states: FloatArray, parameters: FloatArray, iterate: int, tolerance: float
) -> OrbitErrors:
    """Newton's method with one map, and the errors of where it ends."""
    x = states.copy()
    if len(x):
        image = map_(x, parameters, iterate)
        move, _ = fixed_point_newton_step(x, image.state, image.jacobian)
        near = _is_near(move)
        x[near] += move[near]
    errors = orbit_errors(map_, x, parameters, iterate)
    for _ in range(_MAX_NEWTON_STEPS):
        step = np.abs(errors.newton_step).max(axis=1)
        enough = np.maximum(
            _STEP_OVER_TOLERANCE * tolerance, _STEP_OVER_ERROR_OF_MAP * errors.map_share
        )
        going_on = np.flatnonzero(_is_near(errors.newton_step) & (step > enough))
        if not going_on.size:
            break
        moved = errors.state[going_on] + errors.newton_step[going_on]
        further = orbit_errors(map_, moved, parameters[going_on], iterate)
        better = _is_better(further, subset_of_rows(errors, going_on))
        if not better.any():
            break
        errors = replace_rows(errors, going_on[better], subset_of_rows(further, better))
    return errors


def _is_near(move: FloatArray) -> BoolArray:
    return np.asarray((np.abs(move) <= _MAX_STEP).all(axis=1))


def _is_better(new: OrbitErrors, old: OrbitErrors) -> BoolArray:
    """Whether a smaller error is told, or the residual fell where none is."""
    with np.errstate(invalid="ignore"):
        unknown = np.isnan(new.error) & np.isnan(old.error)
        smaller = (new.error < old.error) | (np.isfinite(new.error) & np.isnan(old.error))
        return np.asarray(np.where(unknown, new.residual < old.residual, smaller))


def _next_levels(errors: OrbitErrors, level: IntArray, tolerance: float) -> IntArray:
    """The level of the map to try next: far beyond any where finer steps do not help."""
    with np.errstate(all="ignore"):
        wanted = np.ceil(np.log10(errors.map_share / (_SHARE_OF_MAP * tolerance)))
        wanted = np.where(np.isfinite(wanted), wanted, 1.0)
        helps = ~(errors.map_share < _MIN_MAP_OVER_ROUNDING * errors.rounding_share)
    jump = np.where(errors.is_confirmed, np.maximum(wanted, 1.0), np.maximum(wanted, 2.0))
    further = level + np.minimum(jump, _MAX_LEVELS_AT_ONCE).astype(np.int64)
    return np.where(helps, further, np.iinfo(np.int64).max)
