"""Exponents of motion that settles on a periodic orbit, from the multipliers of the orbit.

An average over a run has an error that falls slowly with its length.  Once motion is known to
end on a stable periodic orbit, its exponents are the logarithms of that orbit's Floquet
multipliers, which one period of the orbit gives to many digits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.periodic_orbits import fixed_point_newton_step
from remanent.analysis.orbits.stability import floquet_multipliers
from remanent.analysis.regimes.limit_orbits import (
    IterateWithJacobian,
    find_approached_orbit_periods,
    find_limit_orbits,
)
from remanent.analysis.regimes.long_runs import SMALLEST_GROWTH
from remanent.analysis.regimes.returns import find_best_returns
from remanent.analysis.regimes.thresholds import MAX_CLOSED_RETURN_DEFECT

#: An orbit that returns worse than this, relative to its extent, is not settling yet.
_MAX_SETTLING_RETURN_DEFECT = 0.5
#: Distance of settled motion from its orbit, relative to the motion's extent, at most.
_MAX_SETTLED_DISTANCE = 1e-5
#: Multipliers of settled motion lie in the unit circle, or so near to it.
_MAX_UNIT_CIRCLE_EXCESS = 1e-7

#: Rounding relative to the size of a multiplier, from which on nothing is known of it.
_MAX_RELATIVE_ROUNDING = 0.1

#: ``iterate(orbits, states, periods)`` with images and Jacobians on steps of equal length in
#: every call, and on steps twice as long.
MapsOfTwoResolutions = tuple[IterateWithJacobian, IterateWithJacobian]


@dataclass(frozen=True)
class OrbitExponents:
    """Periodic orbits that motions settle on, with what their multipliers say.

    Attributes
    ----------
    period : array (orbit,) of int
        In periods of the map; 0 where there is none.
    state : array (orbit, state)
        A point of each; NaN where there is none.
    state_error : array (orbit,)
        Estimated error of the point, the largest over its components.
    exponents : array (orbit, direction)
        Logarithms of the sizes of the multipliers, per period of the map, largest first.
    exponents_error : array (orbit, direction)
        Their estimated errors.
    """

    period: IntArray
    state: FloatArray
    state_error: FloatArray
    exponents: FloatArray
    exponents_error: FloatArray


def find_settled_orbit_periods(
    visited: FloatArray, orbits: IntArray, iterate: IterateWithJacobian, contracts: BoolArray
) -> IntArray:
    """Periods of the orbits that motions have settled on, or are seen to settle on.

    Motion has settled where it closes throughout the last quarter and lies on a periodic orbit
    that Newton's method finds, which is not unstable; motion that still settles has to approach
    a stable orbit at the rate of its multiplier.

    Parameters
    ----------
    visited : array (orbit, iterate, state)
        The last states of the runs, of these orbits only.
    orbits : array (orbit,) of int
        Their numbers, for `iterate`.
    iterate : callable
        Images and Jacobians of the orbits' maps.
    contracts : array (orbit,) of bool
        Where neighbours of the motion approach it, so that it may be settling.

    Returns
    -------
    array (orbit,) of int
        0 where no orbit is known.
    """
    period = np.zeros(orbits.size, dtype=np.int64)
    if not orbits.size:
        return period
    best = find_best_returns(visited, closed=MAX_CLOSED_RETURN_DEFECT)
    closes = best.late_return_defect <= MAX_CLOSED_RETURN_DEFECT
    for q in np.unique(best.period[closes]).tolist():
        some = np.flatnonzero(closes & (best.period == q))
        ahead = find_limit_orbits(iterate, orbits[some], visited[some, -1], q, best.extent[some])
        with np.errstate(invalid="ignore"):
            distance = np.abs(ahead.state - visited[some, -1]).max(axis=1)
            settled = (
                ahead.has_converged
                & (ahead.largest_multiplier_modulus <= 1.0 + _MAX_UNIT_CIRCLE_EXCESS)
                & (distance <= _MAX_SETTLED_DISTANCE * best.extent[some])
            )
        period[some[settled]] = q
    settling = np.flatnonzero(
        (period == 0) & contracts & (best.late_return_defect < _MAX_SETTLING_RETURN_DEFECT)
    )
    period[settling] = find_approached_orbit_periods(
        visited[settling], orbits[settling], best.period[settling], iterate
    )
    return period


def orbit_exponents(
    iterate: IterateWithJacobian,
    maps_of_orbits: Callable[[IntArray, FloatArray, int], MapsOfTwoResolutions],
    orbits: IntArray,
    states: FloatArray,
    period: IntArray,
    error_per_difference: float,
) -> OrbitExponents:
    """Exponents of the periodic orbits near some states, with their errors.

    The orbit and its multipliers are computed with steps of two lengths.  Their difference
    says what steps matter; two steps of Newton's method say what rounding does.

    Parameters
    ----------
    iterate : callable
        Images and Jacobians, with steps that suit each state.
    maps_of_orbits : callable
        Of some orbits, states near them and their period, the two maps.
    orbits : array (orbit,) of int
        Numbers of the orbits, for the maps.
    states : array (orbit, state)
        Near the periodic orbits.
    period : array (orbit,) of int
        Of each; 0 where nothing is known.
    error_per_difference : float
        Error of the finer result over its difference from the coarser.
    """
    count, d = states.shape
    state, exponents, error = (np.full((count, d), np.nan) for _ in range(3))
    state_error = np.full(count, np.nan)
    for q in np.unique(period[period > 0]).tolist():
        some = np.flatnonzero(period == q)
        ahead = find_limit_orbits(iterate, orbits[some], states[some], q)
        fine, coarse = maps_of_orbits(orbits[some], ahead.state, q)
        first, logs_before, _ = _newton_step(fine, orbits[some], ahead.state, q)
        point, logs, rounding = _newton_step(fine, orbits[some], first, q)
        beside, _, _ = _newton_step(coarse, orbits[some], first, q)
        _, coarse_logs, _ = _newton_step(coarse, orbits[some], beside, q)
        state[some] = point
        state_error[some] = np.abs(point - first).max(axis=1) + error_per_difference * np.abs(
            beside - point
        ).max(axis=1)
        exponents[some] = logs / q
        error[some] = (
            np.abs(logs - logs_before)
            + error_per_difference * np.abs(coarse_logs - logs)
            + rounding
        ) / q
    return OrbitExponents(period, state, state_error, exponents, error)


def _newton_step(
    iterate: IterateWithJacobian, orbits: IntArray, states: FloatArray, period: int
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The next states, the logarithms of multipliers at these, and what rounding makes of them."""
    image, jacobian = iterate(orbits, states, period)
    move, _ = fixed_point_newton_step(states, image, jacobian)
    known = np.asarray(np.isfinite(jacobian).all(axis=(1, 2)))
    safe = np.where(known[:, None, None], jacobian, 0.0)
    multipliers, error = floquet_multipliers(safe, np.zeros(len(states)))
    with np.errstate(all="ignore"):
        size = np.abs(multipliers)
        logs, rounding = np.log(size), error / size
    logs[~known[:, None] | (size < SMALLEST_GROWTH)] = np.nan
    return states + move, logs, np.where(rounding <= _MAX_RELATIVE_ROUNDING, rounding, np.inf)
