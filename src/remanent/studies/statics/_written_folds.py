"""Where equilibria of a system of one's own meet while a parameter is varied, all in a box.

At a fold the balance F(x, p) vanishes with the determinant of dF/dx; both together have simple
zeros there, which are found by cells.  Where branches cross, as in the buckling of a symmetric
structure, the zero is not simple: cells cannot be solved, and the crossing is located by the
extended system for it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.cell_samples import Sample
from remanent.analysis.orbits.cells import zeros_by_cells
from remanent.analysis.orbits.extended_systems import LocatedPoint, locate_special_points
from remanent.analysis.orbits.maps import MapImage
from remanent.analysis.orbits.orbit_equations import build_orbit_equations
from remanent.studies.statics._written_body import WrittenBody

#: First cells along each unknown, the parameter among them, by how many unknowns there are.
_FIRST_CELL_COUNTS = (64, 24, 10, 6, 4, 3, 3, 2)
#: A curve along which balance and determinant are no larger than this, over what they usually
#: are, is one of folds.
_FLATNESS = 1e-12
#: Evaluations of the balance and its determinant in one search.
_MAX_EVALUATIONS = 3e5
#: Half the step of a difference of the determinant, as a share of the box.
_HALF_STEP = 1e-5
#: Rounding of a number near 1.
_ROUNDING = float(np.finfo(float).eps)
#: Newton steps from a start.
_MAX_NEWTON_STEPS = 12
#: How far from its start, as a share of the box, a fold or a crossing may be.
_REACHES = {"fold": 0.05, "branch point": 0.2}
#: A point whose place is known no better than this share of the box is none.
_LARGEST_ERROR = 1e-4
#: Points nearer to each other than this share of the box are one.
_SAME_PLACE = 1e-7
#: Folds are not told apart from a crossing within this share of the box.
_NEAR_CROSSING = 2.0**-6
#: Cells count as thin below this share of that distance.
_THIN = 2.0**-4
#: Places at which balance and determinant are smallest, from which crossings are looked for.
_CROSSING_STARTS = 64
#: Points of the box by which the usual size of the functions is told.
_SIZE_SAMPLES = 256
#: Share of the largest eigenvalue below which the sign of a real part is not told.
_UNDECIDED_SHARE = 1e-5


@dataclass(frozen=True)
class MeetingPoints:
    """Where equilibria meet: places and values of the parameter, with errors.

    Attributes
    ----------
    places, place_errors : array (point, unknown)
    values, value_errors : array (point,)
        Of the parameter, rising.
    stability : array (point,) of str
        ``stable`` where one of those that meet is stable, ``unstable`` where none is,
        ``undecided`` where that is not told.
    """

    places: FloatArray
    place_errors: FloatArray
    values: FloatArray
    value_errors: FloatArray
    stability: NDArray[np.str_]


@dataclass(frozen=True)
class _Search:
    """Folds of one body over a parameter, in the unit box of unknowns and parameter.

    Attributes
    ----------
    body : WrittenBody
    name : str
        The parameter.
    corner, width : array (unknown + 1,)
        Of the box.
    size : array (unknown + 1,)
        Usual size of each component of the balance, and of the determinant.
    """

    body: WrittenBody
    name: str
    corner: FloatArray
    width: FloatArray
    size: FloatArray

    @property
    def dimension(self) -> int:
        """Unknowns that rest determines: what the map of :meth:`__call__` moves."""
        return self.width.size - 1

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        """Points plus their balance over its size: a map whose fixed points are the equilibria.

        States and the parameter are those of the unit box, in which derivatives are near 1.
        """
        points = np.column_stack([states, parameters])
        places, changed = self._unscaled(points)
        n = self.dimension
        derivative = self._balance_derivative(places, changed)
        _, bound = self.body.balance_rounding(places, changed)
        return MapImage(
            states + self.functions(points)[:, :n], derivative[:, :, :n] + np.eye(n),
            derivative[:, :, n:], np.maximum((bound / self.size[:n]).max(axis=1), _ROUNDING),
        )  # fmt: skip

    @np.errstate(all="ignore")  # of energies that are infinite
    def functions(self, points: FloatArray) -> FloatArray:
        """Balance and determinant over their sizes at points of the unit box, (point, n + 1)."""
        places, changed = self._unscaled(points)
        balance = self.body.balance(places, changed)
        determinant = np.linalg.det(self.body.stiffness(places, changed))
        return np.asarray(np.column_stack([balance, determinant]) / self.size)

    def _unscaled(self, points: FloatArray) -> tuple[FloatArray, dict[str, FloatArray]]:
        unknown = self.corner + self.width * points
        return unknown[:, :-1], {self.name: unknown[:, -1]}

    def _balance_derivative(self, places: FloatArray, changed: dict[str, FloatArray]) -> FloatArray:
        """Derivatives of the balance over its size, by the unit box, (point, n, n + 1)."""
        slope = self.body.balance_slope(places, self.name, changed[self.name])
        both = np.concatenate([self.body.stiffness(places, changed), slope[:, :, None]], axis=2)
        return np.asarray(both * self.width / self.size[: self.dimension, None])

    def sample(self, points: FloatArray, tolerance: float, effort: IntArray | None) -> Sample:
        """See :class:`remanent.analysis.orbits.cell_samples.SampledFunction`."""
        places, changed = self._unscaled(points)
        n = self.dimension
        with np.errstate(all="ignore"):
            value = self.functions(points)
            derivative = np.empty((len(points), n + 1, n + 1))
            derivative[:, :n] = self._balance_derivative(places, changed)
            for k, step in enumerate(_HALF_STEP * np.eye(n + 1)):
                ends = [self.functions(points + side * step)[:, n] for side in (1.0, -1.0)]
                derivative[:, n, k] = (ends[0] - ends[1]) / (2.0 * _HALF_STEP)
            error = 8.0 * np.finfo(float).eps * (1.0 + np.abs(derivative).max(axis=(1, 2)))
        return Sample(value, derivative, error, np.ones(len(points), dtype=np.int64))

    def small_places(self, edges: list[FloatArray]) -> FloatArray:
        """Centres of cells between edges at which balance and determinant are smallest."""
        middles = [0.5 * (e[1:] + e[:-1]) for e in edges]
        points = np.stack(np.meshgrid(*middles, indexing="ij"), axis=-1).reshape(-1, len(edges))
        size = np.abs(self.functions(points)).max(axis=1)
        order = np.argsort(size, kind="stable")[:_CROSSING_STARTS]  # NaN last
        return np.asarray(points[order[np.isfinite(size[order])]])

    def polished(self, starts: FloatArray) -> FloatArray:
        """Points of the unit box after some Newton steps."""
        points = starts.copy()
        for _ in range(_MAX_NEWTON_STEPS if len(starts) else 0):
            sample = self.sample(points, 0.0, None)
            known = np.isfinite(sample.derivative).all(axis=(1, 2))
            step = np.linalg.pinv(sample.derivative[known]) @ sample.value[known][..., None]
            points[known] -= step[..., 0]
        return points

    def located(self, kind: str, starts: FloatArray) -> list[LocatedPoint]:
        """Special points of a kind near starts in the unit box, each once, within the box.

        Unknowns and errors are those of the unit box.
        """
        if not len(starts):
            return []
        found = locate_special_points(
            build_orbit_equations(self, 1), [kind] * len(starts), starts,
            np.full(len(starts), _REACHES[kind]), np.ones(self.width.size),
        )  # fmt: skip
        kept: list[LocatedPoint] = []
        for one in found:
            if one is None:
                continue
            inside = ((one.unknown >= -one.error) & (one.unknown <= 1.0 + one.error)).all()
            known = (one.error <= _LARGEST_ERROR).all()
            others = [np.abs(one.unknown - k.unknown).max() for k in kept]
            if known and inside and all(distance > _SAME_PLACE for distance in others):
                kept.append(one)
        return sorted(kept, key=lambda one: float(one.unknown[-1]))


def folds_and_crossings(
    body: WrittenBody, name: str, limits: tuple[float, float], box: FloatArray
) -> tuple[MeetingPoints, MeetingPoints, str]:
    """Folds of equilibria, points at which branches of them cross, and what may be missing.

    Parameters
    ----------
    body : WrittenBody
    name : str
        The parameter.
    limits : (float, float)
        Its least and largest value.
    box : array (unknown, 2)
        Where equilibria may be.

    Returns
    -------
    folds, crossings : MeetingPoints
    reason : str
        Empty where every fold in the box is listed.
    """
    search = _search(body, name, limits, box)
    n = search.dimension + 1
    count = _FIRST_CELL_COUNTS[min(n, len(_FIRST_CELL_COUNTS)) - 1]
    edges = [np.linspace(0.0, 1.0, count + 1)] * n
    crossings = search.located("branch point", search.small_places(edges))
    known = np.array([one.unknown for one in crossings]).reshape(-1, 1, n)

    def is_near_crossing(centre: FloatArray, half_width: FloatArray) -> BoolArray:
        # Cells are divided where the functions are curved: what is thin and still not solved
        # is so by the crossing that it touches, however wide it is where they are straight.
        gap = (np.abs(centre - known) - half_width).max(axis=2)
        thin = half_width.min(axis=1) <= _THIN * _NEAR_CROSSING
        return np.asarray((gap <= _NEAR_CROSSING).any(axis=0) & thin)

    cells = zeros_by_cells(
        search.sample, edges, flatness=_FLATNESS, max_effort=_MAX_EVALUATIONS,
        is_settled=is_near_crossing,
    )  # fmt: skip
    folds = search.located("fold", search.polished(cells.starts))
    reason = ""
    flat_places = np.abs(cells.flat - known).max(axis=2)
    if not (flat_places <= _NEAR_CROSSING).any(axis=0).all():
        reason = "equilibria meet along a curve, of which single points cannot be listed"
    elif len(cells.unresolved):
        reason = "in parts of the box it could not be told whether equilibria meet"
    return _described(search, folds), _described(search, crossings), reason


def _search(body: WrittenBody, name: str, limits: tuple[float, float], box: FloatArray) -> _Search:
    """The search, with the usual size of its functions in the box."""
    corner = np.append(box[:, 0], limits[0])
    width = np.append(box[:, 1], limits[1]) - corner
    search = _Search(body, name, corner, width, np.ones(width.size))
    points = np.random.default_rng(0).random((_SIZE_SAMPLES, width.size))
    with np.errstate(all="ignore"):
        sizes = np.abs(search.functions(points))
        sizes = np.where(np.isfinite(sizes), sizes, np.nan)
        known = np.isfinite(sizes).any(axis=0)
        size = np.where(known, np.nanmedian(np.where(known, sizes, 1.0), axis=0), 1.0)
    return replace(search, size=np.where(size > 0.0, size, 1.0))


def _described(search: _Search, located: list[LocatedPoint]) -> MeetingPoints:
    """Places, values, errors and the stability of those that meet."""
    n = search.dimension
    points = np.array([one.unknown for one in located]).reshape(-1, n + 1)
    errors = np.array([one.error for one in located]).reshape(-1, n + 1) * search.width
    unknown = search.corner + search.width * points
    errors = errors + _ROUNDING * np.abs(search.corner)
    changed = {search.name: unknown[:, n]}
    states = search.body.states(unknown[:, :n])
    words = [_stability(matrix, search.body.ens.system.conservative)
             for matrix in search.body.rate_derivatives(states, changed)]  # fmt: skip
    return MeetingPoints(
        unknown[:, :n], errors[:, :n], unknown[:, n], errors[:, n], np.array(words, dtype="<U9")
    )


def _stability(matrix: FloatArray, conservative: bool) -> str:
    """Whether a stable equilibrium takes part, by the eigenvalues that do not vanish there."""
    values = np.linalg.eigvals(matrix)
    values = values[np.argsort(np.abs(values))][2 if conservative else 1 :]
    slack = _UNDECIDED_SHARE * float(np.abs(values).max(initial=0.0))
    growth = float(values.real.max(initial=-np.inf))
    if growth > slack:
        return "unstable"
    return "stable" if growth < -slack or conservative else "undecided"
