"""Orbits that are symmetric under reversal of time, of undamped systems with an even load.

Such an orbit is at rest at phase 0 and again half its period later; one of even period may instead
be at rest at phase 1/2 twice.  So its stretch is a zero of a function of one variable: the rate
half a period of the orbit after a start at rest.  The zeros are regular even where the orbit's
multipliers are both 1.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.cell_samples import Sample
from remanent.analysis.orbits.cells import zeros_by_cells
from remanent.studies.orbits._orbit_search import OrbitSearch
from remanent.studies.orbits._period_map import StroboscopicMap

#: First cells on the line.
_FIRST_CELL_COUNT = 64
#: Times that the map may be applied to a point.
_MAX_EVALUATIONS = 10_000
#: Newton steps that refine a zero.
_NEWTON_STEPS = 5
#: Error of the map at first.
_ROUGH_TOLERANCE = 1e-7
#: Error of the map for orbits that are listed.
_FINE_TOLERANCE = 1e-11
#: Points nearer to each other than this are one.
_MIN_SEPARATION = 1e-4


@dataclass(frozen=True)
class _RateHalfAnOrbitLater:
    """The rate half an orbit's period after a start at rest at phase 0 or 1/2.

    Attributes
    ----------
    search : OrbitSearch
    row : array (parameter,)
    is_late : bool
        At phase 1/2.
    maps : dict of float to StroboscopicMap
        Of each tolerance, as they are needed.
    """

    search: OrbitSearch
    row: FloatArray
    is_late: bool
    maps: dict[float, StroboscopicMap] = field(default_factory=dict)

    def __call__(self, points: FloatArray, tolerance: float, effort: IntArray | None) -> Sample:
        """See :class:`remanent.analysis.orbits.cells.SampledFunction`."""
        exponent = np.floor(np.log10(tolerance / self.search.orbit_period))
        chosen = float(10.0 ** max(exponent, -11.0))
        if chosen not in self.maps:
            self.maps[chosen] = replace(
                self.search.map, period_tolerance=chosen, state_cell_bits=2,
                section_phase=0.5 if self.is_late else 0.0,
            )  # fmt: skip
        states = np.column_stack([points[:, 0], np.zeros(len(points))])
        q = self.search.orbit_period
        image = self.maps[chosen].run(
            states, np.tile(self.row, (len(points), 1)), q // 2, half=q % 2 == 1
        )
        return Sample(
            image.state[:, 1:], image.jacobian[:, 1:, :1], image.error,
            np.zeros(len(points), dtype=np.int64),
        )  # fmt: skip


@dataclass(frozen=True)
class SymmetricOrbits:
    """Orbits that are symmetric under reversal of time.

    Attributes
    ----------
    stretch : array (orbit,)
        At which they are at rest.
    is_late : array (orbit,) of bool
        At phase 1/2; else at phase 0.
    path : array (period, orbit, state)
        Points at phase 0, one period after the other, to a few digits.
    is_of_least_period : array (orbit,) of bool
        False where the orbit closes earlier.
    """

    stretch: FloatArray
    is_late: BoolArray
    path: FloatArray
    is_of_least_period: BoolArray

    def subset(self, indices: IntArray) -> SymmetricOrbits:
        """Some of the orbits."""
        return SymmetricOrbits(
            self.stretch[indices], self.is_late[indices], self.path[:, indices],
            self.is_of_least_period[indices],
        )  # fmt: skip


def symmetric_orbits(
    search: OrbitSearch, row: FloatArray, stretches: tuple[float, float]
) -> SymmetricOrbits:
    """Every symmetric orbit, those of shorter periods too.

    Parameters
    ----------
    search : OrbitSearch
    row : array (parameter,)
        Of the map.
    stretches : (float, float)
        Between which the orbits are at rest.
    """
    edges = np.geomspace(*stretches, _FIRST_CELL_COUNT + 1)
    parts, states = [], []
    rough = replace(search.map, period_tolerance=_ROUGH_TOLERANCE)
    for late in (False, True) if search.orbit_period % 2 == 0 else (False,):
        rate = _RateHalfAnOrbitLater(search, row, late)
        found = zeros_by_cells(rate, [edges], flatness=0.0, max_effort=_MAX_EVALUATIONS)
        x = _refined(rate, found.starts[:, 0], _ROUGH_TOLERANCE)
        parts.append(x)
        states.append(_states_at_phase_zero(rough, row, x, late))
    stretch, is_late = (
        np.concatenate(parts),
        np.repeat([False, True][: len(parts)], list(map(len, parts))),
    )
    points = [np.concatenate(states)]
    for _ in range(search.orbit_period - 1):
        rows = np.tile(row, (len(points[0]), 1))
        points.append(rough.run(points[-1], rows, 1).state)
    path = np.stack(points)
    returns = np.abs(path[1:] - path[0]).max(axis=2)  # (period, orbit)
    kept: list[int] = []
    for k in range(path.shape[1]):
        distances = [np.abs(path[:, i] - path[0, k]).max(axis=1).min() for i in kept]
        if min(distances, default=np.inf) > _MIN_SEPARATION:
            kept.append(k)
    is_least = (returns > _MIN_SEPARATION).all(axis=0)
    return SymmetricOrbits(stretch[kept], is_late[kept], path[:, kept], is_least[kept])


def refined_states(
    search: OrbitSearch, row: FloatArray, orbits: SymmetricOrbits, place: IntArray
) -> FloatArray:
    """Points at phase 0 of some orbits with the accuracy of the map, array (orbit, state).

    Parameters
    ----------
    search : OrbitSearch
    row : array (parameter,)
    orbits : SymmetricOrbits
    place : array (orbit,) of int
        Which of the points of its path is wanted of each orbit.
    """
    result = np.empty((len(orbits.stretch), 2))
    for late in (False, True):
        mine = orbits.is_late == late
        if mine.any():
            rate = _RateHalfAnOrbitLater(search, row, late)
            x = _refined(rate, orbits.stretch[mine], _FINE_TOLERANCE)
            result[mine] = _states_at_phase_zero(search.map, row, x, late)
    for k in range(1, search.orbit_period):
        later = place >= k
        if later.any():
            rows = np.tile(row, (int(later.sum()), 1))
            result[later] = search.map.run(result[later], rows, 1).state
    return result


def _refined(rate: _RateHalfAnOrbitLater, stretch: FloatArray, tolerance: float) -> FloatArray:
    """Zeros of the rate, by Newton's method, array (zero,)."""
    x = stretch[:, None]
    if not x.size:
        return stretch
    for _ in range(_NEWTON_STEPS):
        sample = rate(x, tolerance, None)
        with np.errstate(all="ignore"):
            step = sample.value / sample.derivative[:, :, 0]
        x = x - np.where(np.isfinite(step), step, 0.0)
    return np.asarray(x[:, 0])


def _states_at_phase_zero(
    map_: StroboscopicMap, row: FloatArray, stretch: FloatArray, late: bool
) -> FloatArray:
    """States at phase 0 of motions at rest at phase 0, or at phase 1/2 where `late`."""
    states = np.column_stack([stretch, np.zeros_like(stretch)])
    if late and len(states):
        to_phase_zero = replace(map_, section_phase=0.5)
        states = to_phase_zero.run(states, np.tile(row, (len(states), 1)), 0, half=True).state
    return states
