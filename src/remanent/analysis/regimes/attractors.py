"""Which attractors motions end on: ends of orbits sorted into kinds that are the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.analysis.regimes.birkhoff import weighted_average
from remanent.analysis.regimes.decision import Regime
from remanent.analysis.regimes.returns import IterateMap, find_limit_orbit

#: Points of periodic orbits nearer than this, relative to the extent of all motion, are one.
_SAME = 1e-4
#: Newton's residual at a periodic orbit.
_RESIDUAL = 1e-8
#: Averages of other attractors: within this share of their scatter.
_SAME_AVERAGE = 0.25


@dataclass(frozen=True)
class AttractorAssignment:
    """Attractors and who ends there.

    Attributes
    ----------
    which : array (orbit,)
        Number of the attractor of each orbit, -1 where its regime is none.
    first : array (attractor,)
        An orbit that ends on each; the most visited attractor first.
    """

    which: IntArray
    first: IntArray


def assign_attractors(tails: FloatArray, regime: IntArray, period: IntArray) -> AttractorAssignment:
    """Sort orbits by the attractor they end on.

    Periodic orbits are the same if they have the same period and one comes through a point
    of the other.  Tori and chaotic sets are the same if averages of the coordinates and
    their squares agree to within a share of the scatter, which tells apart sets that lie
    in different places and nothing finer.

    Parameters
    ----------
    tails : array (orbit, iterate, state)
        Ends of the orbits.
    regime : array (orbit,)
        Values of :class:`~remanent.analysis.regimes.decision.Regime`.
    period : array (orbit,)
        Where periodic.
    """
    known = np.isfinite(tails).all(axis=(1, 2))
    named = np.isin(regime, (Regime.PERIODIC, Regime.QUASI_PERIODIC, Regime.CHAOTIC)) & known
    which = np.full(regime.size, -1, dtype=np.int64)
    first: list[int] = []
    if named.any():
        extent = max(float(np.ptp(tails[named].reshape(-1, tails.shape[2]), axis=0).max()), 1e-3)
        features = _features(tails)
    while (left := np.flatnonzero(named & (which < 0))).size:
        k = int(left[0])
        alike = left[(regime[left] == regime[k]) & (period[left] == period[k])]
        if regime[k] == Regime.PERIODIC:
            q = int(period[k])
            distance = np.abs(tails[alike, None, -1] - tails[k, None, -q:]).max(axis=2)
            same = distance.min(axis=1) <= _SAME * extent
        else:
            mean, scatter = features
            apart = np.abs(mean[alike] - mean[k]) / np.maximum(scatter[k], _SAME * extent)
            same = apart.max(axis=1) <= _SAME_AVERAGE
        which[alike[same]] = len(first)
        which[k] = len(first)
        first.append(k)
    order = np.argsort([-(which == n).sum() for n in range(len(first))], kind="stable")
    place = np.empty(len(first) + 1, dtype=np.int64)
    place[order], place[-1] = np.arange(len(first)), -1
    return AttractorAssignment(place[which], np.array(first, dtype=np.int64)[order])


def extrapolate_tails(
    iterate: IterateMap, tails: FloatArray, regime: IntArray, period: IntArray
) -> FloatArray:
    """The ends of orbits with the periodic orbits that they approach as their last points.

    Where damping is slight motion is still far from its attractor when it is known to be
    on the way there; by the places it has reached alone, each would have an attractor of
    its own.

    Parameters
    ----------
    iterate
        Image and Jacobian of some orbits' maps.
    tails, regime, period
        As for :func:`assign_attractors`.
    """
    ends = tails.copy()
    periodic = regime == Regime.PERIODIC
    for q in np.unique(period[periodic]).tolist():
        which = np.flatnonzero(periodic & (period == q))
        ahead = find_limit_orbit(iterate, which, tails[which, -1], q)
        there = (ahead.residual <= _RESIDUAL) & (ahead.multiplier < 1.0)
        some, point = which[there], ahead.state[there]
        for k in range(q):
            ends[some, -1 - k] = point
            if k < q - 1:
                point = iterate(some, point, 1)[0]
    return ends


def _features(tails: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Averages of coordinates and squares, and the scatter of what is averaged."""
    values = np.concatenate([tails, tails**2], axis=2)
    return weighted_average(np.moveaxis(values, 1, 2)), np.std(values, axis=1)
