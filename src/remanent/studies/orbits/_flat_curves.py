"""Orbits of undamped motion on curves where P^n(z) - z almost vanishes: weak resonances.

Numbers do not tell which of the points of such a curve are on orbits.  Those orbits that are
symmetric under reversal of time are zeros of a function of one variable, and found by that.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.periodic_orbits import (
    PeriodicOrbits,
    concatenate_orbits,
    position_errors,
)
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.orbits._orbit_search import OrbitSearch, OrbitSearchOutcome, is_inside_box
from remanent.studies.orbits._search_region import EnergyAtSection, EnergyLevels
from remanent.studies.orbits._symmetry_line import (
    SymmetricOrbits,
    refined_states,
    symmetric_orbits,
)

#: Symmetric orbits on flat curves are looked for up to this many times the energy of motions there.
_ENERGY_REACH = 1.2
#: Error of a period of the map by which this energy is told.
_ROUGH_TOLERANCE = 1e-3
#: A symmetric orbit closes up to this, relative to its size.
_SYMMETRIC_RESIDUAL = 1e-6
#: Samples of a motion per unit of time, by which its oscillations are counted.
_SAMPLES_PER_TIME = 40.0
#: Tolerance of these samples.
_SAMPLE_TOLERANCE = 1e-3
#: Share of the box within which points lie on the same flat curve.
_FLAT_NEIGHBOUR_SHARE_OF_BOX = 2.0**-5


def with_orbits_on_flat_curves(
    search: OrbitSearch,
    orbits: PeriodicOrbits,
    flat: FloatArray,
    row: FloatArray,
    box: FloatArray,
    energy: EnergyAtSection,
) -> OrbitSearchOutcome:
    """Orbits together with the symmetric ones on curves where P^n(z) - z nearly vanishes.

    The reason is empty where each curve has its symmetric orbits.
    """
    if search.has_constant_load(row):
        return OrbitSearchOutcome(
            orbits,
            "the load is constant and nothing damps the motion: its orbits form families, of "
            "which only isolated ones are listed",
        )
    if not search.is_reversible:
        return OrbitSearchOutcome(
            orbits,
            "there are curves of points that come back to themselves within rounding, and "
            "orbits on them cannot be told apart",
        )
    levels = EnergyLevels.of(energy)
    highest = _highest_energy(search, energy, flat, row)
    highest = levels.least + _ENERGY_REACH * (highest - levels.least)
    symmetric = symmetric_orbits(search, row, levels.stretch_range(highest))
    inside = np.stack([is_inside_box(states, box) for states in symmetric.path])
    chosen = np.flatnonzero(inside.any(axis=0) & symmetric.is_of_least_period)
    outcome = OrbitSearchOutcome(orbits)
    if chosen.size:
        known = position_errors(orbits)
        new = [k for k in chosen if not _is_listed(symmetric.path[:, k], orbits.state, known)]
        outcome = _with_symmetric(search, row, orbits, symmetric, np.array(new, np.int64), inside)
    # A curve and the orbits on it wind around as many times in the orbit's period.
    tree = cKDTree(flat / ((box[:, 1] - box[:, 0]) * _FLAT_NEIGHBOUR_SHARE_OF_BOX))
    near = tree.sparse_distance_matrix(tree, 1.0, p=np.inf)
    _, first = np.unique(connected_components(near, directed=False)[1], return_index=True)
    turns = _oscillation_counts(search, row, flat[first])
    told = _oscillation_counts(search, row, symmetric.path[0])
    missing = np.setdiff1d(turns, told).size
    if not missing:
        return outcome
    return replace(
        outcome,
        reason=f"on {missing} curves of points that come back to themselves within rounding no "
        "orbit could be told",
    )


def _highest_energy(
    search: OrbitSearch, energy: EnergyAtSection, states: FloatArray, row: FloatArray
) -> float:
    """The highest energy of motions from some states, whenever an orbit may be at rest.

    Only one of the places where an orbit passes phase 0 need be in the box.
    """
    rough = replace(search.map, period_tolerance=_ROUGH_TOLERANCE)
    rows = np.tile(row, (len(states), 1))
    parts = [energy(states)]
    for k in range(search.orbit_period):
        if search.orbit_period % 2 == 0:
            parts.append(energy(rough.run(states, rows, 0, half=True).state))
        if k + 1 < search.orbit_period:
            states = rough.run(states, rows, 1).state
            parts.append(energy(states))
    return float(np.nanmax(np.stack(parts)))


def _with_symmetric(
    search: OrbitSearch,
    row: FloatArray,
    orbits: PeriodicOrbits,
    symmetric: SymmetricOrbits,
    new: IntArray,
    inside: BoolArray,
) -> OrbitSearchOutcome:
    """Orbits together with some of the symmetric ones, each by a point in the box."""
    if not new.size:
        return OrbitSearchOutcome(orbits)
    states = refined_states(search, row, symmetric.subset(new), inside[:, new].argmax(axis=0))
    path = [states]
    for _ in range(search.orbit_period - 1):
        path.append(search.map.run(path[-1], np.tile(row, (new.size, 1)), 1).state)
    points = np.stack(path)
    path.append(search.map.run(path[-1], np.tile(row, (new.size, 1)), 1).state)
    away = [np.abs(later - states).max(axis=1) for later in path[1:]]
    closes = away[-1] <= _SYMMETRIC_RESIDUAL * (1.0 + np.abs(states).max(axis=1))
    closes &= (np.array(away[:-1]) > _SYMMETRIC_RESIDUAL).all(axis=0)
    kept: list[int] = []
    for k in np.flatnonzero(closes):
        if not _is_listed(points[:, k], states[kept], np.zeros(len(kept))):
            kept.append(int(k))
    states = states[kept]
    image = search.map.run(states, np.tile(row, (len(kept), 1)), search.orbit_period)
    residual = np.abs(image.state - states).max(axis=1)
    added = PeriodicOrbits(states, image.jacobian, residual, image.error)
    joined = concatenate_orbits([orbits, added], 2)
    order = np.lexsort(np.round(joined.state, 6).T[::-1])
    return OrbitSearchOutcome(
        joined.subset(order), symmetric=np.flatnonzero(order >= len(orbits.state))
    )


def _oscillation_counts(search: OrbitSearch, row: FloatArray, states: FloatArray) -> IntArray:
    """How many times motions turn back in one period of an orbit, array (point,)."""
    if not len(states):
        return np.empty(0, dtype=np.int64)
    ens = search.member(row).with_initial_states(
        states, {name: row[k] for k, name in enumerate(search.map.parameter_names)}
    )
    duration = search.orbit_period * search.drive_period(row)
    count = int(np.ceil(_SAMPLES_PER_TIME * duration))
    times = np.tile(duration * (np.arange(count) + 0.5) / count, (len(states), 1))
    problem = initial_value_problem(ens, np.full(len(states), duration))
    outcome = integrate(problem, Request(times=times), tolerance=_SAMPLE_TOLERANCE)
    assert outcome.states is not None
    up = outcome.states[:, :, 1] > 0.0
    return np.asarray((up & ~np.roll(up, -1, axis=1)).sum(axis=1))


def _is_listed(path: FloatArray, states: FloatArray, errors: FloatArray) -> bool:
    """Whether one of the points (period, state) of an orbit is among some states."""
    if not len(states):
        return False
    distance = np.abs(path[:, None] - states).max(axis=2)
    return bool((distance <= 1e-6 + 2.0 * np.minimum(errors, 1e-3)).any())
