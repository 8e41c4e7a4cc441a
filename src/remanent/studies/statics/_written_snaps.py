"""From which value of a parameter on a motion from rest passes an unstable equilibrium.

With V the potential energy and x0 the start, a threshold is where the force vanishes at some x
with V(x) = V(x0) and nothing higher on the way.  The start itself would solve these equations for
every value; in place of V(x) - V(x0) its quotient by x - x0 is taken, which is the mean slope of
V on the way and vanishes at the start where that is an equilibrium.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.cell_samples import Sample
from remanent.analysis.orbits.cells import zeros_by_cells
from remanent.studies.statics._written_body import WrittenBody

#: First cells along the coordinate and along the parameter.
_FIRST_CELL_COUNT = 32
#: A curve along which both functions are no larger than this, over what they usually are.
_FLATNESS = 1e-12
#: Evaluations of both functions in one search.
_MAX_EVALUATIONS = 2e5
#: Half the step of a difference, as a share of the box.
_HALF_STEP = 1e-5
#: Within this share of the box the mean slope is an integral: a difference would lose digits.
_INTEGRAL_REACH = 0.05
_GAUSS_RULE = np.polynomial.legendre.leggauss(16)
#: Nodes on [0, 1] and weights.
_NODES, _WEIGHTS = 0.5 * (1.0 + _GAUSS_RULE[0]), 0.5 * _GAUSS_RULE[1]
#: Newton steps from a start.
_MAX_NEWTON_STEPS = 12
#: Points nearer to each other than this share of the box are one.
_SAME_PLACE = 1e-7
#: Points between start and saddle at which the energy is compared.
_WAY_SAMPLES = 256
#: How much higher than at the start the energy on the way may seem, by rounding.
_ENERGY_ROUNDING = 1e-9
#: A small change of the parameter, as a share of its range.
_PARAMETER_STEP = 1e-6


@dataclass(frozen=True)
class Thresholds:
    """Dynamic thresholds, by rising value of the parameter, each an array (threshold,).

    Attributes
    ----------
    values, value_errors : array
        Of the parameter.
    places, place_errors : array
        Of the coordinate, at the unstable equilibrium.
    directions : array
        1 where a larger value takes the motion to larger values of the coordinate, else -1.
    """

    values: FloatArray
    value_errors: FloatArray
    places: FloatArray
    place_errors: FloatArray
    directions: FloatArray


@dataclass(frozen=True)
class _Search:
    """Thresholds of one body with one coordinate.

    Attributes
    ----------
    body : WrittenBody
    name : str
        The parameter.
    start : float
        Value of the coordinate from which motions start at rest.
    corner, width : array (2,)
        Of the box of coordinate and parameter.
    """

    body: WrittenBody
    name: str
    start: float
    corner: FloatArray
    width: FloatArray

    def energy(self, places: FloatArray, values: FloatArray) -> FloatArray:
        """The potential energy, array (point,)."""
        (energy,) = self.body.ens.vector_field.energy_names
        states = self.body.states(places[:, None])
        return np.asarray(self.body.observable(energy, states, {self.name: values}))

    def slope(self, places: FloatArray, values: FloatArray) -> FloatArray:
        """Its slope, array (point,)."""
        (energy,) = self.body.ens.vector_field.energy_names
        states = self.body.states(places[:, None])
        return self.body.observable_slopes(energy, states, {self.name: values})[:, 0]

    def mean_slope(self, places: FloatArray, values: FloatArray) -> FloatArray:
        """Mean slope of the energy from the start to places, array (point,)."""
        way = places - self.start
        with np.errstate(all="ignore"):
            rise = self.energy(places, values) - self.energy(0.0 * way + self.start, values)
            mean = rise / way
        near = np.abs(way) <= _INTEGRAL_REACH * self.width[0]
        inner = (self.start + way[near, None] * _NODES).ravel()
        slopes = self.slope(inner, np.repeat(values[near], _NODES.size))
        mean[near] = slopes.reshape(-1, _NODES.size) @ _WEIGHTS
        return np.asarray(mean)

    def functions(self, points: FloatArray) -> FloatArray:
        """Acceleration and mean slope of the energy at points of the unit box, array (point, 2)."""
        places, values = (self.corner + self.width * points).T
        force = self.body.balance(places[:, None], {self.name: values})[:, 0]
        return np.column_stack([force, self.mean_slope(places, values)])

    def derivatives(self, points: FloatArray) -> FloatArray:
        """Their derivatives by the coordinates of the unit box, array (point, 2, 2)."""
        ends = [
            (self.functions(points + step) - self.functions(points - step)) / (2.0 * _HALF_STEP)
            for step in _HALF_STEP * np.eye(2)
        ]
        return np.stack(ends, axis=2)

    def sample(self, points: FloatArray, tolerance: float, effort: IntArray | None) -> Sample:
        """See :class:`remanent.analysis.orbits.cell_samples.SampledFunction`."""
        with np.errstate(all="ignore"):
            value, derivative = self.functions(points), self.derivatives(points)
            size = 1.0 + np.abs(derivative).max(axis=(1, 2))
        error = 8.0 * np.finfo(float).eps * size
        return Sample(value, derivative, error, np.ones(len(points), dtype=np.int64))

    def polished(self, starts: FloatArray) -> FloatArray:
        """Zeros in the unit box by Newton's method from starts, each once, array (zero, 2)."""
        points = starts.copy()
        for _ in range(_MAX_NEWTON_STEPS if len(starts) else 0):
            sample = self.sample(points, 0.0, None)
            known = np.isfinite(sample.derivative).all(axis=(1, 2))
            step = np.linalg.pinv(sample.derivative[known]) @ sample.value[known][..., None]
            points[known] -= step[..., 0]
        kept: list[FloatArray] = []
        for point in points:
            inside = ((point >= -_SAME_PLACE) & (point <= 1.0 + _SAME_PLACE)).all()
            if inside and all(np.abs(point - other).max() > _SAME_PLACE for other in kept):
                kept.append(point)
        return np.array(kept).reshape(-1, 2)

    def is_reached_saddle(self, places: FloatArray, values: FloatArray) -> BoolArray:
        """Whether a place is unstable, with nothing higher on the way from the start."""
        share = np.linspace(0.0, 1.0, _WAY_SAMPLES)[1:-1]
        way = self.start + (places - self.start)[:, None] * share
        many = np.repeat(values, share.size)
        begin = self.energy(np.full(many.size, self.start), many).reshape(way.shape)
        rise = self.energy(way.ravel(), many).reshape(way.shape) - begin
        below = (rise <= _ENERGY_ROUNDING * (1.0 + np.abs(begin))).all(axis=1)
        steepness = self.body.stiffness(places[:, None], {self.name: values})[:, 0, 0]
        return np.asarray(below & (steepness > 0.0))

    def errors(self, points: FloatArray) -> FloatArray:
        """Errors of zeros in the unit box: what rounding leaves, by the inverse, (point, 2)."""
        places, values = (self.corner + self.width * points).T
        changed = {self.name: values}
        left, _ = self.body.balance_rounding(places[:, None], changed)
        (energy,) = self.body.ens.vector_field.energy_names
        here, there = (
            self.body.observable_with_rounding(energy, at[:, None], changed)
            for at in (places, np.full(places.size, self.start))
        )
        way = np.abs(places - self.start)
        near = way <= _INTEGRAL_REACH * self.width[0]
        with np.errstate(all="ignore"):
            of_rise = (here.value.bound + there.value.bound) / way
            of_mean = np.where(near, here.slope.bound + there.slope.bound, of_rise)
            of_mean = of_mean + np.abs(self.functions(points)[:, 1])
            inverse = np.abs(np.linalg.pinv(self.derivatives(points)))
            moved = (inverse @ np.column_stack([left[:, 0], of_mean])[..., None])[..., 0]
        return np.asarray(moved * self.width + np.finfo(float).eps * np.abs([places, values]).T)

    def directions(self, places: FloatArray, values: FloatArray) -> FloatArray:
        """1 where a larger parameter takes the motion to larger places, -1 to smaller."""
        small = _PARAMETER_STEP * self.width[1]
        begin = np.full(places.size, self.start)

        def rise(value: FloatArray) -> FloatArray:
            return self.energy(places, value) - self.energy(begin, value)

        def acceleration(value: FloatArray) -> FloatArray:
            return self.body.balance(places[:, None], {self.name: value})[:, 0]

        barrier, force = (
            np.asarray(of(values + small)) - np.asarray(of(values - small))
            for of in (rise, acceleration)
        )
        beyond = places - self.start
        at_start = np.abs(beyond) <= _SAME_PLACE * self.width[0]
        return np.asarray(np.sign(np.where(at_start, force, -barrier * beyond)))


def snap_thresholds(
    body: WrittenBody, name: str, limits: tuple[float, float], box: FloatArray, start: float
) -> tuple[Thresholds, str]:
    """Thresholds of a conservative body of one coordinate, and what may be missing.

    Parameters
    ----------
    body : WrittenBody
    name : str
        The parameter.
    limits : (float, float)
        Its least and largest value.
    box : array (1, 2)
        Where the unstable equilibrium may be.
    start : float
        Value of the coordinate from which motions start at rest.
    """
    corner = np.array([box[0, 0], limits[0]])
    search = _Search(body, name, start, corner, np.array([box[0, 1], limits[1]]) - corner)
    values = np.linspace(*limits, 5)
    if not body.balance(np.full((values.size, 1), start), {name: values}).any():
        return _described(search, np.empty((0, 2))), ""  # it is at rest there, and stays
    cells = zeros_by_cells(
        search.sample, [np.linspace(0.0, 1.0, _FIRST_CELL_COUNT + 1)] * 2,
        flatness=_FLATNESS, max_effort=_MAX_EVALUATIONS,
    )  # fmt: skip
    points = search.polished(cells.starts)
    missing = len(cells.flat) or len(cells.unresolved)
    reason = "in parts of the box it could not be told whether there is a threshold"
    return _described(search, points), reason if missing else ""


def _described(search: _Search, points: FloatArray) -> Thresholds:
    """The zeros that a motion from the start reaches, with errors."""
    places, values = (search.corner + search.width * points).T
    reached = search.is_reached_saddle(places, values)
    order = np.flatnonzero(reached)[np.argsort(values[reached], kind="stable")]
    places, values = places[order], values[order]
    place_errors, value_errors = search.errors(points[order]).T
    at_start = np.abs(places - search.start) <= _SAME_PLACE * search.width[0]
    return Thresholds(
        values, value_errors, np.where(at_start, search.start, places),
        np.where(at_start, 0.0, place_errors), search.directions(places, values),
    )  # fmt: skip
