"""Every periodic orbit of one system at some values of a parameter.

Actuators with one stretch and its rate are searched by cells, see
:mod:`remanent.studies.orbits._planar_search`, other systems of one or two state variables by cells
in a box, see :mod:`remanent.studies.orbits._box_search`, and what has more from a grid of guesses,
see :mod:`remanent.studies.orbits._grid_search`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.orbits.periodic_orbits import PeriodicOrbits
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.initial import default_initial_values
from remanent.studies.orbits._box_search import search_box
from remanent.studies.orbits._grid_search import search_from_grid
from remanent.studies.orbits._orbit_search import OrbitSearch, OrbitSearchOutcome
from remanent.studies.orbits._period_map import StroboscopicMap
from remanent.studies.orbits._planar_search import search_plane
from remanent.studies.orbits._search_region import has_energy

#: Systems with more state variables are searched from a grid of guesses.
_MAX_STATES_OF_CELLS = 2
#: Change of a field of the drive at which it is looked whether a symmetry stays.
_OTHER_VALUE = 0.37


def is_reversible(system: System, drive: Drive, varied: Sequence[str] = ()) -> bool:
    """Whether reversing time leaves the equation of motion as it is.

    Parameters
    ----------
    system : System
    drive : Drive
    varied : sequence of str
        Fields whose values are not those of the drive: it has to hold for others too.
    """
    if not system.is_time_reversible:
        return False
    own = drive.parameter_values()
    shaping = [name for name in varied if name in own and name != drive.frequency_field_name]
    changed = [drive.replace(**{name: own[name] + _OTHER_VALUE}) for name in shaping]
    return all(_has_mirrored_load(one) for one in (drive, *changed))


def _has_mirrored_load(drive: Drive) -> bool:
    """Whether the load is the same forwards and backwards from phase 0."""
    if drive.period is None:
        return False
    times = np.linspace(0.0, 0.5, 33) * drive.period
    ahead, back = drive(times), drive(drive.period - times)
    return bool(np.allclose(ahead, back, rtol=0.0, atol=1e-13 * (1.0 + np.abs(ahead).max())))


def is_planar(map_: StroboscopicMap) -> bool:
    """Whether the orbits of a map are searched by cells in the plane of one stretch."""
    return map_.dimension == 2 and isinstance(map_.ensemble.system, Actuator) and has_energy(map_)


def search_orbits(search: OrbitSearch, parameters: FloatArray) -> list[OrbitSearchOutcome]:
    """The orbits of a search for each of some values of the map's parameters, and what is missing.

    Parameters
    ----------
    search : OrbitSearch
    parameters : array (case, parameter)

    Returns
    -------
    list of OrbitSearchOutcome
        One for each case.
    """
    if is_planar(search.map):
        one = search_plane
    else:
        one = search_from_grid if search.map.dimension > _MAX_STATES_OF_CELLS else search_box
    return [one(search, row) for row in parameters]


def nearest_to_rest(orbits: PeriodicOrbits, ens: Ensemble) -> PeriodicOrbits:
    """The orbit whose point is nearest to rest, alone."""
    rest = [
        float(default_initial_values(v, ens.parameter_values, ens.trajectory_count)[0])
        for v in ens.vector_field.variables
    ]
    k = int(np.argmin(np.linalg.norm(orbits.state - rest, axis=1)))
    return orbits.subset(np.array([k]))


__all__ = [
    "OrbitSearch",
    "OrbitSearchOutcome",
    "is_planar",
    "is_reversible",
    "nearest_to_rest",
    "search_orbits",
]
