"""Every periodic orbit of a system with one stretch: by cells in the plane of states at phase 0.

The zeros of P^n(z) - z are wanted, where P is the period map and n the period of the orbits.  With
them vanishes the change of the energy at phase 0, which tells more of damped and slow motion: the
image of a cell may be wound up many times, but its energy is not.  The search is complete as far as
second derivatives at neighbouring points tell those in between, see
:mod:`remanent.analysis.orbits.cells`.

There is a second, independent test: the indices of the fixed points of P^n in a region add up to
the number of times that P^n(z) - z winds around zero along its edge.  With dissipation the map
shrinks a disk into itself, along whose edge that is one.

Without dissipation, P^n(z) - z may almost vanish along whole curves, at resonances too weak for
the precision of numbers.  The orbits on them that are symmetric under reversal of time are zeros of
a function of one variable, and found by that.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.cell_samples import Sample
from remanent.analysis.orbits.cells import CellSearchOutcome, zeros_by_cells
from remanent.analysis.orbits.periodic_orbits import (
    concatenate_orbits,
    distinct_fixed_points,
    distinct_orbits_of_least_period,
)
from remanent.integrate.ensemble.resolution import MAX_RESOLUTION
from remanent.studies.orbits._flat_curves import with_orbits_on_flat_curves
from remanent.studies.orbits._orbit_search import (
    ConfirmedPoints,
    OrbitSearch,
    OrbitSearchOutcome,
    confirmed_fixed_points,
    is_inside_box,
)
from remanent.studies.orbits._period_map import StroboscopicMap
from remanent.studies.orbits._planar_indices import (
    FirstGrid,
    indices_in_box,
    winding_around_grid,
)
from remanent.studies.orbits._search_region import (
    EnergyAtSection,
    EnergyLevels,
    SearchRegion,
    region_of_orbits,
)

#: Errors of a period that maps are made for: a cell takes the largest that serves it.
_PERIOD_TOLERANCES = (1e-3, 1e-5, 1e-7, 1e-9, 1e-11)
#: Most double steps per unit of time in a first, second ... attempt: a large motion is excluded
#: with few digits.
_MOST_STEPS_PER_TIME = (32.0, 256.0, 1024.0, np.inf)
#: Shares of the displacement that are accuracy enough, for the first cells and for parts of them.
_ERROR_SHARES_OF_DISPLACEMENT = (0.05, 1e-3)
#: Double steps that are taken for points without an image before it is looked whether finer steps
#: give any of them one, and how many of them are then tried, about.
_LARGEST_UNTESTED_EFFORT = 1e6
_TRIAL_COUNT = 128
#: Double steps per unit of time to begin with.
_FIRST_STEPS_PER_TIME = 4.0
#: Fewest and most double steps per period to begin with.
_FIRST_RESOLUTION_LIMITS = (8, 2048)
#: Size of the first cells along the logarithm of the stretch and along its rate, at most.
_FIRST_CELL_SIZES = (0.09, 0.7)
#: How many first cells there are along each of them, at least and at most.
_FIRST_CELL_COUNT_LIMITS = ((20, 12), (72, 96))
#: How many times finer the first cells are in a second search, if the indices contradict the first.
_SECOND_SEARCH_REFINEMENT = 2
#: How long energies are followed, at least, to bound where orbits of damped motion are.
_SETTLING_TIME = 15.0
#: But no more than so many times the period of the orbits.
_MAX_SETTLING_MULTIPLE = 16
#: Points along each side of a first cell at which its energy is compared with the bound.
_ENERGY_POINTS_ON_SIDE = 5
#: Double steps of the integrator in one search, all together: slow undamped motion of period 5
#: passes dozens of resonances, and takes 1e8.
_MAX_EFFORT = 2e8
#: The same where orbits are looked for at many values of a parameter.
MAX_EFFORT_OF_EACH_OF_MANY = 1.8e7
#: Share of it that the displacement along the edge of the grid may take.
_WINDING_EFFORT_SHARE = 0.1
#: Where |P^n(z) - z| is smaller than this on a curve, of undamped motion, only symmetric orbits are
#: looked for on it: a resonance so weak has the two that its first harmonic gives.
_FLATNESS = 1e-4
#: The same where there is no symmetry to tell orbits.
LEAST_FLATNESS = 1e-8


@dataclass(frozen=True)
class Displacement:
    """P^n(z) - z and the change of the energy, with their derivatives.

    Attributes
    ----------
    search : OrbitSearch
    row : array (parameter,)
        Of the map.
    energy : EnergyAtSection or None
        None where the change of the energy is left out.
    maps : dict of (float, int) to StroboscopicMap
        Of each tolerance and finest resolution, as they are needed.
    """

    search: OrbitSearch
    row: FloatArray
    energy: EnergyAtSection | None
    maps: dict[tuple[float, int], StroboscopicMap] = field(default_factory=dict)

    def map_of_tolerance(self, tolerance: float, finest: int = MAX_RESOLUTION) -> StroboscopicMap:
        """The map with the largest error of a period that serves a tolerance."""
        n = self.search.orbit_period
        chosen = next((t for t in _PERIOD_TOLERANCES if t * n <= tolerance), _PERIOD_TOLERANCES[-1])
        if (chosen, finest) not in self.maps:
            self.maps[chosen, finest] = replace(
                self.search.map, period_tolerance=chosen, finest_resolution=finest
            )
        return self.maps[chosen, finest]

    def __call__(self, points: FloatArray, tolerance: float, effort: IntArray | None) -> Sample:
        """See :class:`remanent.analysis.orbits.cells.SampledFunction`."""
        low, high = _FIRST_RESOLUTION_LIMITS
        period = self.period
        error_share = _ERROR_SHARES_OF_DISPLACEMENT[0 if effort is None else 1]
        if effort is None:
            first = np.clip(_FIRST_STEPS_PER_TIME * period, low, high)
            effort = np.full(len(points), int(first))
        d = points.shape[1]
        sample = Sample.unknown(len(points), d + (self.energy is not None), d)
        pending = np.arange(len(points))
        for steps in _MOST_STEPS_PER_TIME:
            finest = int(np.clip(steps * period, low, MAX_RESOLUTION))
            for tried in groups_to_try(sample, pending, finest):
                part = self._sample(points[tried], tolerance, finest, effort[tried])
                sample.update(tried, part)
            with np.errstate(all="ignore"):
                size = np.abs(sample.value[pending, :d]).max(axis=1)
                share = error_share * np.minimum(size, 1.0)
                enough = sample.error[pending] <= np.maximum(tolerance, share)
            effort = np.where(sample.effort > 0, sample.effort, effort)
            pending = pending[~enough]
            if not pending.size or finest == MAX_RESOLUTION:
                break
        return sample

    def _sample(
        self, points: FloatArray, tolerance: float, finest: int, effort: IntArray
    ) -> Sample:
        rows = np.tile(self.row, (len(points), 1))
        image, effort = self.map_of_tolerance(tolerance, finest).run_at_resolution(
            np.minimum(effort, finest), points, rows, self.search.orbit_period
        )
        value, derivative = image.state - points, image.jacobian - np.eye(points.shape[1])
        if self.energy is None:
            return Sample(value, derivative, image.error, effort)
        with np.errstate(all="ignore"):
            energy, gradient = self.energy.with_gradient(np.concatenate([image.state, points]))
            gain = energy[: len(points)] - energy[len(points) :]
            slope = np.einsum("pi,pij->pj", gradient[: len(points)], image.jacobian)
            slope = slope - gradient[len(points) :]
        return Sample(
            np.column_stack([value, gain]),
            np.concatenate([derivative, slope[:, None, :]], axis=1),
            image.error,
            effort,
        )

    @property
    def settling_periods(self) -> int:
        """A multiple of the orbit's period in which the phase of the load averages out."""
        n = self.search.orbit_period
        return n * int(np.ceil(min(_SETTLING_TIME / (n * self.period), _MAX_SETTLING_MULTIPLE)))

    @cached_property
    def period(self) -> float:
        """Of the load."""
        return self.search.drive_period(self.row)


def groups_to_try(sample: Sample, pending: IntArray, finest: int) -> Iterator[IntArray]:
    """Points to compute with steps of a finest resolution, in turn.

    Where many points have no image so far, a few of them are tried first: if these still have
    none, the others are left as they are.
    """
    lost = ~np.isfinite(sample.error[pending])
    if not lost.all():
        yield pending[~lost]
    unknown = pending[lost]
    if unknown.size * finest > _LARGEST_UNTESTED_EFFORT:
        few = unknown[:: 1 + unknown.size // _TRIAL_COUNT]
        yield few
        if not np.isfinite(sample.error[few]).any():
            return
        unknown = np.setdiff1d(unknown, few)
    if unknown.size:
        yield unknown


def search_plane(search: OrbitSearch, row: FloatArray) -> OrbitSearchOutcome:
    """The orbits of a system with one stretch, for one row of the map's parameters."""
    energy = EnergyAtSection(search.map, row)
    displacement = Displacement(search, row, energy)
    region = None
    if search.is_dissipative(row):
        region = region_of_orbits(
            displacement.map_of_tolerance(np.inf), energy, displacement.settling_periods
        )
    possible = EnergyLevels.of(energy).possible_stretches
    box, is_whole = _searched_box(search, region, possible)
    if box[0, 0] == box[0, 1]:
        reason = "" if possible[0] < possible[1] else "no stretch has a finite energy"
        return OrbitSearchOutcome(concatenate_orbits([], search.map.dimension), reason)
    for refinement in (1, _SECOND_SEARCH_REFINEMENT):
        grid = _first_grid(search, box, refinement)
        cells = _search_cells(displacement, grid, region)
        points = fixed_points(search, cells, row, box)
        if is_whole:
            contradiction = _contradiction(int(points.orbits.index.sum()), 1)
        else:
            contradiction = contradiction_in_grid(displacement, grid, cells, points)
        if not contradiction:
            break
    reason = reason_of_points(points, cells) or contradiction
    if search.is_dissipative(row) and region is None:
        reason = reason or "no bound of the energy of its orbits was found"
    orbits = distinct_orbits_of_least_period(
        search.map, points.orbits, row, iterate=search.orbit_period, errors=points.error
    )
    if not len(cells.flat):
        return OrbitSearchOutcome(orbits, reason)
    outcome = with_orbits_on_flat_curves(search, orbits, cells.flat, row, box, energy)
    return replace(outcome, reason=reason or outcome.reason)


def _searched_box(
    search: OrbitSearch, region: SearchRegion | None, stretches: tuple[float, float]
) -> tuple[FloatArray, bool]:
    """The box to be searched, array (2, 2), and whether it holds all fixed points."""
    box = search.state_box.copy()
    box[0] = np.clip(box[0], *stretches)
    if region is None:
        return box, False
    whole = region.box.copy()
    whole[0] = np.clip(whole[0], *stretches)
    if search.box_is_free:
        return whole, True
    common = np.column_stack([
        np.maximum(box[:, 0], whole[:, 0]), np.minimum(box[:, 1], whole[:, 1])
    ])  # fmt: skip
    if (common[:, 0] >= common[:, 1]).any():
        return box, False
    return common, bool((common == whole).all())


def _first_grid(search: OrbitSearch, box: FloatArray, refinement: int) -> FirstGrid:
    (low, high), (slowest, fastest) = box
    wanted = np.array([np.log(high / low), fastest - slowest]) / _FIRST_CELL_SIZES
    even = 2 * np.ceil(0.5 * np.clip(wanted, *_FIRST_CELL_COUNT_LIMITS)).astype(np.int64)
    counts = [int(refinement * n) for n in even]
    stretches = np.geomspace(low, high, counts[0] + 1)
    rates = np.linspace(slowest, fastest, counts[1] + 1)
    is_mirrored = search.is_reversible and bool(slowest == -fastest)
    return FirstGrid([stretches, rates[counts[1] // 2 :] if is_mirrored else rates], is_mirrored)


def _search_cells(
    displacement: Displacement, grid: FirstGrid, region: SearchRegion | None
) -> CellSearchOutcome:
    excluded = None
    if region is not None:
        assert displacement.energy is not None
        excluded = _is_beyond_energy(displacement.energy, grid.edges, region.energy)
    search = displacement.search
    most = _MAX_EFFORT if search.is_dense else MAX_EFFORT_OF_EACH_OF_MANY
    found = zeros_by_cells(
        displacement, grid.edges, is_excluded=excluded,
        max_effort=most / search.orbit_period,
        flatness=_FLATNESS if search.is_reversible else LEAST_FLATNESS,
    )  # fmt: skip
    if not grid.is_mirrored:
        return found
    mirror = np.array([1.0, -1.0])
    return replace(
        found,
        starts=np.concatenate([found.starts, found.starts * mirror]),
        flat=np.concatenate([found.flat, found.flat * mirror]),
    )


def _is_beyond_energy(energy: EnergyAtSection, edges: list[FloatArray], bound: float) -> BoolArray:
    """First cells all of whose states have a larger energy, array (*first cells)."""
    part = np.linspace(0.0, 1.0, _ENERGY_POINTS_ON_SIDE)
    places = [(e[:-1, None] + part * np.diff(e)[:, None]).ravel() for e in edges]
    x, v = np.meshgrid(*places, indexing="ij")
    with np.errstate(all="ignore"):
        values = energy(np.column_stack([x.ravel(), v.ravel()]))
    k = _ENERGY_POINTS_ON_SIDE
    blocks = values.reshape(len(edges[0]) - 1, k, len(edges[1]) - 1, k)
    return np.asarray(np.fmin.reduce(blocks, axis=(1, 3)) > bound)


def fixed_points(
    search: OrbitSearch, cells: CellSearchOutcome, row: FloatArray, box: FloatArray
) -> ConfirmedPoints:
    """Each fixed point of the iterate in the box once."""
    width = box[:, 1] - box[:, 0]
    wide = np.column_stack([box[:, 0] - 0.5 * width, box[:, 1] + 0.5 * width])
    if search.map.ensemble.vector_field.variables[0].positive:
        wide[0, 0] = 0.5 * box[0, 0]
    found = confirmed_fixed_points(search, cells.starts, row, wide)
    inside = np.flatnonzero(is_inside_box(found.orbits.state, box))
    chosen = inside[distinct_fixed_points(found.orbits.subset(inside), found.error[inside])]
    return ConfirmedPoints(found.orbits.subset(chosen), found.error[chosen], found.unconfirmed)


def contradiction_in_grid(
    displacement: Displacement, grid: FirstGrid, cells: CellSearchOutcome, points: ConfirmedPoints
) -> str:
    """What the displacement along the edge of a grid says against the points that were found.

    On curves of points that nearly come back the indices are not known, nor where nothing is.
    """
    if len(cells.flat) or len(cells.unresolved) or len(points.unconfirmed):
        return ""
    expected = winding_around_grid(
        displacement, grid, cells.first_sample, _WINDING_EFFORT_SHARE * cells.effort
    )
    if expected is None:
        return ""
    found = indices_in_box(points.orbits.state, points.orbits.index, grid.inner_box)
    return _contradiction(found, expected)


def _contradiction(index_sum: int, expected: int) -> str:
    """What the sum of the indices says against the points that were found."""
    if index_sum == expected:
        return ""
    return (
        f"the indices of the fixed points that were found add up to {index_sum}, not to {expected}"
    )


def reason_of_points(points: ConfirmedPoints, cells: CellSearchOutcome) -> str:
    """Why orbits may be missing; empty where none is."""
    if len(cells.unresolved):
        return (
            f"in {len(cells.unresolved)} parts of the box the map is too steep, or takes too many "
            "steps, to tell whether there are orbits"
        )
    if len(points.unconfirmed):
        place = ", ".join(f"{x:.6g}" for x in points.unconfirmed[0])
        return f"the point ({place}) may or may not be on an orbit: it is too near a bifurcation"
    return ""
