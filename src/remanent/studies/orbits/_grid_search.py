"""Periodic orbits of systems with several stretches or internal variables: guesses, then Newton.

A grid of guesses cannot show that no orbit is missing.  With dissipation the map takes a large
ball into itself, so that the indices of all fixed points of an iterate add up to one: where those
that were found do not, the search says so.  Elsewhere it says that nothing shows it complete.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from remanent._field import Role
from remanent._typing import FloatArray, IntArray
from remanent.analysis.orbits.maps import MapImage
from remanent.analysis.orbits.periodic_orbits import (
    distinct_fixed_points,
    distinct_orbits_of_least_period,
    newton_fixed_points,
)
from remanent.studies.orbits._orbit_search import (
    OrbitSearch,
    OrbitSearchOutcome,
    confirmed_fixed_points,
    is_inside_box,
)
from remanent.studies.orbits._period_map import StroboscopicMap
from remanent.studies.orbits._pilot_resolution import FIRST_RESOLUTION

#: Error of a period in the first search.
_ROUGH_PERIOD_TOLERANCE = 1e-5
#: Largest resolution of the first search per unit of time, and at least: guesses that need more
#: lead nowhere.
_ROUGH_FINEST_RESOLUTION_PER_TIME = 37.5
#: Least value of that.
_ROUGH_FINEST_RESOLUTION = 96
#: Residual of the orbits of the first search, and largest error of the image of a guess.
_ROUGH_RESIDUAL = 10.0 * _ROUGH_PERIOD_TOLERANCE
#: Steps without progress after which a guess of the first search is given up: most wander for
#: ever, and those that arrive rarely pause for so long.
_ROUGH_PATIENCE = 5
#: Binary digits that tell the cells of the first search: guesses lie far apart in the box.
_ROUGH_STATE_CELL_BITS = 1
#: Guesses in the box along each stretch and rate, by their number, where orbits are looked for
#: at one value of the parameter only.
_DENSE_GUESS_COUNTS = MappingProxyType({2: (36, 25), 4: (7, 5, 7, 5)})
#: The same where they are looked for at many values.
_SPARSE_GUESS_COUNTS = MappingProxyType({2: (14, 9), 4: (5, 3, 5, 3)})
#: About so many guesses, dense and sparse, where there is another number of variables.
_GUESS_TOTALS = (1200, 240)
#: Guesses that are followed until they settle, where motion is damped.
_FOLLOWED_GUESS_COUNT = 32
#: For so many periods of the orbit.
_FOLLOWED_PERIODS = 12
#: What is said where nothing tells whether the list is complete.
_NO_CERTIFICATE = (
    "orbits were looked for from a grid of guesses, and nothing shows that none is missing"
)


def search_from_grid(search: OrbitSearch, row: FloatArray) -> OrbitSearchOutcome:
    """The orbits that Newton's method finds, for one row of the map's parameters."""
    finest = max(
        _ROUGH_FINEST_RESOLUTION,
        int(_ROUGH_FINEST_RESOLUTION_PER_TIME * search.drive_period(row)),
    )
    rough_map = replace(
        search.map,
        period_tolerance=_ROUGH_PERIOD_TOLERANCE,
        finest_resolution=min(finest, search.map.finest_resolution),
        state_cell_bits=_ROUGH_STATE_CELL_BITS,
    )
    guesses = _box_guesses(search)
    if search.is_dissipative(row):
        guesses = np.concatenate([guesses, _settled(search, rough_map, guesses, row)])
    guess_map = _GuessMap(rough_map, np.full(len(guesses), FIRST_RESOLUTION))
    numbered = np.column_stack([np.tile(row, (len(guesses), 1)), np.arange(len(guesses))])
    rough = newton_fixed_points(
        guess_map, guesses, numbered, iterate=search.orbit_period, tolerance=_ROUGH_RESIDUAL,
        box=search.state_box, max_error=_ROUGH_RESIDUAL, patience=_ROUGH_PATIENCE,
    )  # fmt: skip
    # Many guesses lead to one point: near each only one is refined.
    _, first = np.unique(np.round(rough.state, 4), axis=0, return_index=True)
    found = confirmed_fixed_points(search, rough.state[first], row, search.state_box)
    inside = np.flatnonzero(is_inside_box(found.orbits.state, search.state_box))
    chosen = inside[distinct_fixed_points(found.orbits.subset(inside), found.error[inside])]
    points = found.orbits.subset(chosen)
    orbits = distinct_orbits_of_least_period(
        search.map, points, row, iterate=search.orbit_period, errors=found.error[chosen]
    )
    return OrbitSearchOutcome(orbits, _reason(search, row, int(points.index.sum())))


def _reason(search: OrbitSearch, row: FloatArray, index_sum: int) -> str:
    """Why orbits may be missing; empty where the sum of the indices shows none."""
    if not (search.box_is_free and search.is_dissipative(row)):
        why = "only a part of the states was asked for"
        if search.box_is_free:
            why = "nothing damps the motion"
        return f"{_NO_CERTIFICATE}, as {why}"
    if index_sum == 1:
        return ""
    return f"the indices of the fixed points that were found add up to {index_sum}, not to 1"


def _settled(
    search: OrbitSearch, map_: StroboscopicMap, guesses: FloatArray, row: FloatArray
) -> FloatArray:
    """Where some of the guesses are after some periods of the orbit: near attractors."""
    step = max(1, len(guesses) // _FOLLOWED_GUESS_COUNT)
    states = guesses[::step]
    rows = np.tile(row, (len(states), 1))
    for _ in range(_FOLLOWED_PERIODS):
        states = map_.run(states, rows, search.orbit_period).state
    return np.asarray(states[np.isfinite(states).all(axis=1)])


@dataclass(frozen=True)
class _GuessMap:
    """The map of one search, whose points are Newton's steps from numbered guesses.

    Each step begins with the resolution that was enough for the one before it from the same
    guess.  That is the only thing that changes, and one guess does not see another.

    Attributes
    ----------
    map : StroboscopicMap
    resolution_of_guess : array (guess,) of int
        Changed in place.
    """

    map: StroboscopicMap
    resolution_of_guess: IntArray

    @property
    def dimension(self) -> int:
        """Number of state variables."""
        return self.map.dimension

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        """Apply the map; the last parameter is the number of the guess."""
        guess = parameters[:, -1].astype(np.int64)
        image, self.resolution_of_guess[guess] = self.map.run_at_resolution(
            self.resolution_of_guess[guess], states, parameters[:, :-1], iterate
        )
        return image


def _box_guesses(search: OrbitSearch) -> FloatArray:
    """A grid of guesses, array (guess, state), denser in stretch where stretch is small.

    What is internal is guessed from the stretches: relaxed, at the temperature outside.
    """
    field = search.map.ensemble.vector_field
    moving = field.indices_of_roles(Role.COORDINATE, Role.RATE)
    table = _DENSE_GUESS_COUNTS if search.is_dense else _SPARSE_GUESS_COUNTS
    even = max(2, round(_GUESS_TOTALS[0 if search.is_dense else 1] ** (1.0 / len(moving))))
    counts = table.get(len(moving), (even,) * len(moving))
    axes = [
        np.geomspace(low, high, n) if low > 0.0 else np.linspace(low, high, n)
        for (low, high), n in zip(search.state_box[moving], counts, strict=True)
    ]
    grid = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
    guesses = np.tile(search.state_box.mean(axis=1), (len(grid), 1))
    guesses[:, moving] = grid
    for k, variable in enumerate(field.variables):
        if variable.role is Role.INTERNAL and variable.belongs_to in field.state_names:
            guesses[:, k] = guesses[:, field.state_names.index(variable.belongs_to)]
    return guesses
