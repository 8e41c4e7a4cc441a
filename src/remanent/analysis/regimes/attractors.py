"""Which attractors motions end on: ends of orbits sorted into kinds that are the same."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.birkhoff import weighted_birkhoff_average
from remanent.analysis.regimes.labels import Regime
from remanent.analysis.regimes.limit_orbits import IterateWithJacobian
from remanent.analysis.regimes.orbit_exponents import OrbitExponents

#: Distance between two points of one periodic orbit, relative to the extent of all motion.
_MAX_RELATIVE_DISTANCE_FROM_SAME_ORBIT = 1e-4
#: Difference of averages over one attractor of another kind, relative to their scatter.
_MAX_RELATIVE_AVERAGE_DIFFERENCE = 0.25
#: Motion smaller than this counts as this large.
_MIN_MOTION_EXTENT = 1e-3
#: Number of no attractor.
NO_ATTRACTOR = -1


@dataclass(frozen=True)
class AttractorAssignment:
    """Attractors, and which orbit ends on which of them.

    Attributes
    ----------
    attractor_number : array (orbit,) of int
        Number of the attractor of each orbit, :data:`NO_ATTRACTOR` where its regime has none.
    representative_orbit : array (attractor,) of int
        An orbit that ends on each; the most visited attractor first.
    """

    attractor_number: IntArray
    representative_orbit: IntArray


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
    regime : array (orbit,) of int
        Values of :class:`~remanent.analysis.regimes.labels.Regime`.
    period : array (orbit,) of int
        Where periodic.
    """
    finite = np.isfinite(tails).all(axis=(1, 2))
    bound = np.isin(regime, (Regime.PERIODIC, Regime.QUASI_PERIODIC, Regime.CHAOTIC)) & finite
    number = np.full(regime.size, NO_ATTRACTOR, dtype=np.int64)
    representative: list[int] = []
    if bound.any():
        width = float(np.ptp(tails[bound].reshape(-1, tails.shape[2]), axis=0).max())
        features = _averages_and_scatter(tails)
    while (unassigned := np.flatnonzero(bound & (number < 0))).size:
        k = int(unassigned[0])
        alike = (regime[unassigned] == regime[k]) & (period[unassigned] == period[k])
        candidates = unassigned[alike]
        distance = _MAX_RELATIVE_DISTANCE_FROM_SAME_ORBIT * max(width, _MIN_MOTION_EXTENT)
        if regime[k] == Regime.PERIODIC:
            same = _ends_on_orbit(tails[candidates], tails[k, -int(period[k]) :], distance)
        else:
            same = _have_equal_averages(features, candidates, k, distance)
        number[candidates[same]] = number[k] = len(representative)
        representative.append(k)
    return _renumber_most_visited_first(number, representative)


def _ends_on_orbit(tails: FloatArray, orbit: FloatArray, max_distance: float) -> BoolArray:
    """Whether motions (motion, iterate, state) end on a point of an orbit (point, state)."""
    distance = np.abs(tails[:, None, -1] - orbit[None]).max(axis=2)
    return np.asarray(distance.min(axis=1) <= max_distance)


def _have_equal_averages(
    features: tuple[FloatArray, FloatArray], candidates: IntArray, k: int, min_scatter: float
) -> BoolArray:
    """Whether averages agree with those of motion k."""
    mean, scatter = features
    difference = np.abs(mean[candidates] - mean[k]) / np.maximum(scatter[k], min_scatter)
    return np.asarray(difference.max(axis=1) <= _MAX_RELATIVE_AVERAGE_DIFFERENCE)


def _averages_and_scatter(tails: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Averages of coordinates and squares, and the scatter of what is averaged."""
    values = np.concatenate([tails, tails**2], axis=2)
    return weighted_birkhoff_average(np.moveaxis(values, 1, 2)), np.std(values, axis=1)


def _renumber_most_visited_first(
    number: IntArray, representative: list[int]
) -> AttractorAssignment:
    count = len(representative)
    order = np.argsort([-(number == n).sum() for n in range(count)], kind="stable")
    rank = np.empty(count + 1, dtype=np.int64)
    # The last entry is that of number -1: what has no attractor keeps none.
    rank[order], rank[-1] = np.arange(count), NO_ATTRACTOR
    return AttractorAssignment(rank[number], np.array(representative, dtype=np.int64)[order])


def replace_tails_by_limit_orbits(
    iterate: IterateWithJacobian, tails: FloatArray, settled: OrbitExponents
) -> FloatArray:
    """The ends of orbits with the periodic orbits that they approach as their last points.

    Where damping is slight, motion is still far from its attractor when it is known to be
    on the way there; by the places it has reached alone, each would have an attractor of
    its own.

    Parameters
    ----------
    iterate : callable
        Images and Jacobians of some orbits' maps.
    tails : array (orbit, iterate, state)
        Ends of the orbits.
    settled : OrbitExponents
        The periodic orbits that they end on.

    Returns
    -------
    array (orbit, iterate, state)
    """
    ends = tails.copy()
    with np.errstate(invalid="ignore"):
        stable = settled.exponents[:, 0] < 0.0
    for q in np.unique(settled.period[stable]).tolist():
        settling = np.flatnonzero(stable & (settled.period == q))
        point = settled.state[settling]
        ends[settling, -1] = point
        for k in range(1, q):
            point = iterate(settling, point, 1)[0]
            ends[settling, -1 - k] = point
    return ends
