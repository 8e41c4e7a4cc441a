"""Every periodic orbit in a box, of systems with one or two state variables, by cells.

Of systems that users write nothing is known of where orbits can be: the box is theirs, and the
search is complete within it, as far as second derivatives at neighbouring points tell those in
between, see :mod:`remanent.analysis.orbits.cells`.  In the plane the winding number along the edge
of the box is a second test.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.orbits.cells import CellSearchOutcome, zeros_by_cells
from remanent.analysis.orbits.periodic_orbits import distinct_orbits_of_least_period
from remanent.studies.orbits._orbit_search import OrbitSearch, OrbitSearchOutcome
from remanent.studies.orbits._planar_indices import FirstGrid
from remanent.studies.orbits._planar_search import (
    LEAST_FLATNESS,
    MAX_EFFORT_OF_EACH_OF_MANY,
    Displacement,
    contradiction_in_grid,
    fixed_points,
    reason_of_points,
)
from remanent.studies.orbits._search_region import EnergyAtSection, has_energy

#: First cells along each state variable, by how many there are.
_FIRST_CELL_COUNTS = {1: 128, 2: 80}
#: Guesses in parts that the search could not tell anything of, about.
_MAX_GUESSES = 1000
#: How many times finer they are in a second search, if the winding number contradicts the first.
_SECOND_SEARCH_REFINEMENT = 2


def search_box(search: OrbitSearch, row: FloatArray) -> OrbitSearchOutcome:
    """The orbits with a point in the box at phase 0, for one row of the map's parameters."""
    energy = EnergyAtSection(search.map, row) if has_energy(search.map) else None
    displacement, box = Displacement(search, row, energy), search.state_box
    contradiction = ""
    for refinement in (1, _SECOND_SEARCH_REFINEMENT):
        count = refinement * _FIRST_CELL_COUNTS[len(box)]
        grid = FirstGrid([np.linspace(low, high, count + 1) for low, high in box], False)
        cells = zeros_by_cells(
            displacement, grid.edges, flatness=LEAST_FLATNESS,
            max_effort=MAX_EFFORT_OF_EACH_OF_MANY,
        )  # fmt: skip
        points = fixed_points(search, _with_guesses(cells), row, box)
        if len(box) == 2:
            contradiction = contradiction_in_grid(displacement, grid, cells, points)
        if not contradiction:
            break
    orbits = distinct_orbits_of_least_period(
        search.map, points.orbits, row, iterate=search.orbit_period, errors=points.error
    )
    reason = (
        reason_of_points(points, cells) or contradiction or _reason_of_curves(search, row, cells)
    )
    return OrbitSearchOutcome(orbits, reason)


def _with_guesses(cells: CellSearchOutcome) -> CellSearchOutcome:
    """With guesses from parts of which nothing is known: some orbits there may be found yet."""
    step = max(1, len(cells.unresolved) // _MAX_GUESSES)
    return replace(cells, starts=np.concatenate([cells.starts, cells.unresolved[::step]]))


def _reason_of_curves(search: OrbitSearch, row: FloatArray, cells: CellSearchOutcome) -> str:
    """Why orbits on curves of points that come back to themselves are not listed."""
    if not len(cells.flat):
        return ""
    if search.has_constant_load(row):
        return "no load changes: orbits form families, of which only isolated ones are listed"
    return (
        "there are curves of points that come back to themselves within rounding, and orbits on "
        "them cannot be told apart"
    )
