"""Periodic orbits that motion is still approaching: where they are, and whether it does.

Where damping is slight a run ends long before motion has settled.  Newton's method finds the
periodic orbit ahead.  That alone proves nothing, since such an orbit exists near most motions:
the motion also has to come nearer at the rate that the multiplier of the orbit says.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.periodic_orbits import fixed_point_newton_step

#: Newton steps from the last state of a run.
_NEWTON_STEP_COUNT = 6
#: Distance of a point of a periodic orbit from its image, at most.
_MAX_ORBIT_RESIDUAL = 1e-8
#: From a point that is nearer to its image than this, the next step ends within rounding.
_LAST_STEP_RESIDUAL = 1e-11
#: Newton's method may leave the region that motion visits by so many times its extent.
_REACH_IN_EXTENTS = 2.0
#: Fewest distances from the orbit that show a rate of approach.
_MIN_DISTANCES_FOR_APPROACH_RATE = 6
#: Difference of the rate seen from that of the multiplier, relative to the latter, at most.
_MAX_RELATIVE_RATE_DIFFERENCE = 0.15
#: e-folds by which the distance must have fallen.
_MIN_APPROACH_IN_E_FOLDS = 1.2

#: ``iterate(orbits, states, periods)`` gives the images (orbit, state) and Jacobians (orbit,
#: state, state) of the maps of some orbits, given by number, after a number of periods.
IterateWithJacobian = Callable[[IntArray, FloatArray, int], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True)
class LimitOrbits:
    """The periodic orbit that motions tend to.

    Attributes
    ----------
    state : array (orbit, state)
        A point of it; NaN where Newton's method did not get there.
    residual : array (orbit,)
        Distance of the point from its image.
    largest_multiplier_modulus : array (orbit,)
        Size of the largest multiplier over the whole period.
    """

    state: FloatArray
    residual: FloatArray
    largest_multiplier_modulus: FloatArray

    @property
    def has_converged(self) -> BoolArray:
        """Whether Newton's method reached the orbit, array (orbit,)."""
        return self.residual <= _MAX_ORBIT_RESIDUAL


def find_limit_orbits(
    iterate: IterateWithJacobian,
    orbits: IntArray,
    states: FloatArray,
    period: int,
    extent: FloatArray | float = np.inf,
) -> LimitOrbits:
    """Periodic orbits near some states, by a few steps of Newton's method.

    Parameters
    ----------
    iterate : callable
        Images and Jacobians of the orbits' maps.
    orbits : array (orbit,) of int
        Their numbers.
    states : array (orbit, state)
        Near the periodic orbits.
    period : int
        The same for all.
    extent : array (orbit,) or float
        Of the region that each motion visits.  Newton's method is given up far from it, where
        nothing lies that the motion approaches, and a period may take thousands of steps.
    """
    x = states.copy()
    residual, largest = np.full((2, len(x)), np.inf)
    reach = np.broadcast_to(_REACH_IN_EXTENTS * np.asarray(extent), len(x))
    active = np.arange(len(x))
    for _ in range(_NEWTON_STEP_COUNT):
        if not active.size:
            break
        image, jacobian = iterate(orbits[active], x[active], period)
        move, residual[active] = fixed_point_newton_step(x[active], image, jacobian)
        finite = np.isfinite(jacobian).all(axis=(1, 2)) & np.isfinite(residual[active])
        safe = np.where(finite[:, None, None], jacobian, 0.0)
        largest[active] = np.where(finite, np.abs(np.linalg.eigvals(safe)).max(axis=1), np.inf)
        x[active] += move
        near = np.abs(x[active] - states[active]).max(axis=1) <= reach[active]  # not where NaN
        lost = active[~near]
        x[lost], residual[lost], largest[lost] = np.nan, np.inf, np.inf
        active = active[near & (residual[active] > _LAST_STEP_RESIDUAL)]
    return LimitOrbits(x, residual, largest)


def approaches_at_multiplier_rate(
    points: FloatArray, end: FloatArray, period: int, rate: FloatArray
) -> BoolArray:
    """Whether orbits come nearer to a limit at the rate that its multiplier says.

    The logarithm of the distance is fitted by a straight line over every `period`-th point.

    Parameters
    ----------
    points : array (orbit, iterate, state)
        The last part of a run.
    end : array (orbit, state)
        The point of the limit that belongs to the last iterate.
    period : int
        Of the limit.
    rate : array (orbit,)
        Logarithm of the multiplier, per period of the map.

    Returns
    -------
    array (orbit,) of bool
    """
    distance = np.sqrt(((points[:, ::-1][:, ::period] - end[:, None]) ** 2).sum(axis=2))
    count = distance.shape[1]
    if count < _MIN_DISTANCES_FOR_APPROACH_RATE:
        return np.zeros(len(points), dtype=np.bool_)
    with np.errstate(all="ignore"):
        size = np.log(distance[:, ::-1])
        n = period * np.arange(count)
        slope = ((n - n.mean()) * (size - size.mean(axis=1, keepdims=True))).sum(axis=1)
        slope = slope / ((n - n.mean()) ** 2).sum()
        approach = -slope * n[-1]
        agrees = np.abs(slope - rate) <= _MAX_RELATIVE_RATE_DIFFERENCE * np.abs(rate)
        # Distances run backwards in time: motion must end nearer than its first quarter was.
        nearer = distance[:, 0] <= distance[:, -max(count // 4, 1) :].min(axis=1)
    return np.asarray((approach >= _MIN_APPROACH_IN_E_FOLDS) & agrees & nearer)


def find_approached_orbit_periods(
    visited: FloatArray, orbits: IntArray, candidates: IntArray, iterate: IterateWithJacobian
) -> IntArray:
    """Periods of the stable orbits that motions are seen to approach.

    Parameters
    ----------
    visited : array (orbit, period + 1, state)
        All states of the run, of these orbits only.
    orbits : array (orbit,) of int
        Their numbers, for `iterate`.
    candidates : array (orbit,) of int
        Periods after which the orbits return best.  The period is one of their divisors,
        since a multiple of it returns as well.
    iterate : callable
        Images and Jacobians of the orbits' maps.

    Returns
    -------
    array (orbit,) of int
        0 where no orbit is approached.
    """
    period = np.zeros(orbits.size, dtype=np.int64)
    half = (visited.shape[1] - 1) // 2
    for q in range(1, int(candidates.max(initial=0)) + 1):
        subset = np.flatnonzero((candidates % q == 0) & (period == 0))
        if not subset.size:
            continue
        states = visited[subset]
        # Where motion approaches an orbit, it has come from farther away than it still is.
        extent = np.ptp(states, axis=1).max(axis=1)
        ahead = find_limit_orbits(iterate, orbits[subset], states[:, -1], q, extent)
        with np.errstate(invalid="ignore"):
            rate = np.log(np.maximum(ahead.largest_multiplier_modulus, 1e-300)) / q
            stable = ahead.has_converged & (rate < 0.0)
        approached = approaches_at_multiplier_rate(states[:, half:], ahead.state, q, rate)
        period[subset[stable & approached]] = q
    return period
