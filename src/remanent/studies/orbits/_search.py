"""Every periodic orbit of one system at some values of a parameter: guesses, then Newton."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from remanent._field import Role
from remanent._roots import find_roots
from remanent._typing import FloatArray, IntArray
from remanent.analysis.orbits.maps import MapImage
from remanent.analysis.orbits.periodic_orbits import (
    PeriodicOrbits,
    distinct_orbits_of_least_period,
    newton_fixed_points,
)
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.initial import default_initial_values
from remanent.studies.orbits._period_map import StroboscopicMap
from remanent.studies.orbits._pilot_resolution import FIRST_RESOLUTION

#: Error of a period in the first search.
_ROUGH_PERIOD_TOLERANCE = 1e-6
#: Largest resolution of the first search: guesses that need more lead nowhere.
_ROUGH_FINEST_RESOLUTION = 128
#: Binary digits that tell the cells of the first search: guesses lie far apart in the box.
_ROUGH_STATE_CELL_BITS = 1
#: Residual of the orbits of the first search, and largest error of the image of a guess.
_ROUGH_RESIDUAL = 10.0 * _ROUGH_PERIOD_TOLERANCE
#: Largest resolution on the symmetry line, where every sign has to be right.
_SYMMETRY_LINE_FINEST_RESOLUTION = 512
#: Guesses along the symmetry line.
_SYMMETRY_LINE_GUESS_COUNT = 600
#: Tolerance of a stretch on the symmetry line.
_SYMMETRY_LINE_STRETCH_TOLERANCE = 1e-7
#: Guesses in the box along each stretch and rate, by their number, where orbits are looked for
#: at one value of the parameter only.
_DENSE_GUESS_COUNTS = MappingProxyType({2: (36, 25), 4: (7, 5, 7, 5)})
#: The same where they are looked for at many values, or most are on the symmetry line.
_SPARSE_GUESS_COUNTS = MappingProxyType({2: (14, 9), 4: (5, 3, 5, 3)})


@dataclass(frozen=True)
class OrbitSearch:
    """Where and how orbits are looked for.

    Attributes
    ----------
    map : StroboscopicMap
        Its parameters are the columns of `parameters` in :func:`find_all_orbits`.
    state_box : array (state, 2)
        Bounds of the state at phase 0.
    orbit_period : int
        In drive periods.
    residual_tolerance : float
        Of the residual.
    is_reversible : bool
        Undamped, with a load that is even in time: symmetric orbits start at zero rate.
    is_dense : bool
        Whether to spend many guesses.
    """

    map: StroboscopicMap
    state_box: FloatArray
    orbit_period: int
    residual_tolerance: float
    is_reversible: bool
    is_dense: bool = True


def is_reversible(system: System, drive: Drive) -> bool:
    """Whether reversing time leaves the equation of motion as it is."""
    period = drive.period
    if period is None or not system.conservative:
        return False
    times = np.linspace(0.0, 0.5, 33) * period
    ahead, back = drive(times), drive(period - times)
    return bool(np.allclose(ahead, back, rtol=0.0, atol=1e-13 * (1.0 + np.abs(ahead).max())))


def find_all_orbits(search: OrbitSearch, parameters: FloatArray) -> list[PeriodicOrbits]:
    """The orbits in the box, for each of some values of the map's parameters.

    Parameters
    ----------
    search : Search
    parameters : array (case, parameter)

    Returns
    -------
    list of Orbits
        One entry for each case.
    """
    grid = _box_guesses(search)
    line = [np.empty((0, search.map.dimension))] * len(parameters)
    if search.is_reversible and search.map.dimension == 2:
        line = _symmetry_line_guesses(search, parameters)
    rough_map = replace(
        search.map,
        period_tolerance=_ROUGH_PERIOD_TOLERANCE,
        finest_resolution=_ROUGH_FINEST_RESOLUTION,
        state_cell_bits=_ROUGH_STATE_CELL_BITS,
    )
    outcome = []
    for row, symmetric in zip(parameters, line, strict=True):
        guesses = np.concatenate([symmetric, grid])
        rough = _orbits_from_guesses(search, rough_map, guesses, row, _ROUGH_RESIDUAL)
        outcome.append(
            _orbits_from_guesses(search, search.map, rough.state, row, search.residual_tolerance)
        )
    return outcome


def _orbits_from_guesses(
    search: OrbitSearch,
    map_: StroboscopicMap,
    guesses: FloatArray,
    row: FloatArray,
    tolerance: float,
) -> PeriodicOrbits:
    """Different orbits that Newton's method reaches from guesses."""
    guess_map = _GuessMap(map_, np.full(len(guesses), FIRST_RESOLUTION))
    numbered = np.column_stack([np.tile(row, (len(guesses), 1)), np.arange(len(guesses))])
    orbits = newton_fixed_points(
        guess_map, guesses, numbered, iterate=search.orbit_period, tolerance=tolerance,
        box=search.state_box, max_error=_ROUGH_RESIDUAL,
    )  # fmt: skip
    return distinct_orbits_of_least_period(map_, orbits, row, iterate=search.orbit_period)


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
    counts = (_DENSE_GUESS_COUNTS if search.is_dense else _SPARSE_GUESS_COUNTS)[len(moving)]
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


def _symmetry_line_guesses(search: OrbitSearch, parameters: FloatArray) -> list[FloatArray]:
    """Starts of symmetric orbits: at rest at phase 0 and half their period later.

    An orbit of even period may instead be at rest at phase 1/2 twice.
    """
    late = (False, True) if search.orbit_period % 2 == 0 else (False,)
    parts = [_symmetric_orbit_states(search, parameters, half) for half in late]
    return [np.concatenate(states) for states in zip(*parts, strict=True)]


def _symmetric_orbit_states(
    search: OrbitSearch, parameters: FloatArray, late: bool
) -> list[FloatArray]:
    """States at phase 0 of those that are at rest at phase 0, or at phase 1/2 where `late`."""
    map_ = replace(
        search.map, section_phase=0.5 if late else 0.0, period_tolerance=_ROUGH_PERIOD_TOLERANCE,
        finest_resolution=_SYMMETRY_LINE_FINEST_RESOLUTION, state_cell_bits=_ROUGH_STATE_CELL_BITS,
    )  # fmt: skip
    q = search.orbit_period

    def rate(stretch: FloatArray, case: FloatArray) -> FloatArray:
        states = np.column_stack([stretch, np.zeros(stretch.size)])
        rows = parameters[case.astype(np.int64)]
        return map_.run(states, rows, q // 2, half=q % 2 == 1).state[:, 1]

    grid = np.geomspace(search.state_box[0, 0], search.state_box[0, 1], _SYMMETRY_LINE_GUESS_COUNT)
    case = np.repeat(np.arange(len(parameters), dtype=float), grid.size)
    values = rate(np.tile(grid, len(parameters)), case).reshape(-1, grid.size)
    with np.errstate(invalid="ignore"):
        row, k = np.nonzero(values[:, :-1] * values[:, 1:] <= 0.0)
    if not row.size:
        return [np.empty((0, 2))] * len(parameters)
    root = find_roots(
        rate, (grid[k], grid[k + 1]), args=(row.astype(float),),
        tolerances={
            "xatol": _SYMMETRY_LINE_STRETCH_TOLERANCE, "xrtol": _SYMMETRY_LINE_STRETCH_TOLERANCE,
            "fatol": 0.0, "frtol": 0.0,
        },
    )  # fmt: skip
    states = np.column_stack([root.x, np.zeros(row.size)])
    if late:  # from phase 1/2 to phase 0
        states = map_.run(states, parameters[row], 0, half=True).state
    return [states[root.success & (row == k)] for k in range(len(parameters))]


def nearest_to_rest(orbits: PeriodicOrbits, ens: Ensemble) -> PeriodicOrbits:
    """The orbit whose point is nearest to rest, alone."""
    rest = [
        float(default_initial_values(v, ens.parameter_values, ens.trajectory_count)[0])
        for v in ens.vector_field.variables
    ]
    k = int(np.argmin(np.linalg.norm(orbits.state - rest, axis=1)))
    return orbits.subset(np.array([k]))
