"""Branches of periodic orbits of one system: followed, clipped, each kept once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.orbits.bifurcations import SpecialPoint, find_special_points
from remanent.analysis.orbits.continuation import ContinuationSettings, continue_curves
from remanent.analysis.orbits.correction import correct_points, unit_tangents
from remanent.analysis.orbits.curves import (
    Curve,
    CurveEquations,
    CurvePoints,
    concatenate_points,
    interpolate_curve,
)
from remanent.analysis.orbits.orbit_equations import build_orbit_equations
from remanent.analysis.orbits.periodic_orbits import PeriodicOrbits
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import require_count, require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.orbits._checks import (
    require_heat_exchange,
    require_orbit_period,
    require_state_box,
)
from remanent.studies.orbits._period_map import StroboscopicMap, period_tolerance_for_residual
from remanent.studies.orbits._search import OrbitSearch, find_all_orbits, is_reversible

#: A point nearer to a curve than this, in scaled unknowns, is on it.
_MAX_DISTANCE_ON_CURVE = 1e-3
#: Chords of a curve, nearest to a point, on whose arcs it is looked for.
_NEAREST_CHORD_COUNT = 3
#: First step along a branch, in scaled unknowns.
FIRST_CONTINUATION_STEP = 0.005
#: Longest step along a branch, in scaled unknowns.
LONGEST_CONTINUATION_STEP = 0.02
#: Points predicted at once where a single curve is followed.
_POINTS_PREDICTED_ON_SINGLE_CURVE = 16
#: Points predicted at once on each of many curves.
_POINTS_PREDICTED_ON_EACH_OF_MANY_CURVES = 8


@dataclass(frozen=True)
class Branch:
    """A branch with its special points."""

    curve: Curve
    special_points: list[SpecialPoint]


@dataclass(frozen=True)
class Tracing:
    """How branches of one system are followed: the map's one parameter varies within a range.

    Attributes
    ----------
    map : StroboscopicMap
    state_box : array (state, 2)
        A branch ends where the state at phase 0 leaves it.
    parameter_range : (float, float)
    orbit_period : int
        In drive periods.
    residual_tolerance : float
        Of the residual.
    max_points : int
        In each direction from the start.
    """

    map: StroboscopicMap
    state_box: FloatArray
    parameter_range: tuple[float, float]
    orbit_period: int
    residual_tolerance: float
    max_points: int

    @property
    def curve_equations(self) -> CurveEquations:
        """Equations of the curve: state and parameter are the unknowns."""
        return build_orbit_equations(self.map, self.orbit_period)

    @property
    def continuation_settings(self) -> ContinuationSettings:
        """Bounds, scale and steps of the continuation."""
        lower, upper = (np.append(self.state_box[:, k], self.parameter_range[k]) for k in (0, 1))
        scale = np.append(
            np.ones(len(self.state_box)), self.parameter_range[1] - self.parameter_range[0]
        )
        return ContinuationSettings(
            lower, upper, scale,
            first_step_length=FIRST_CONTINUATION_STEP, max_step_length=LONGEST_CONTINUATION_STEP,
            tolerance=0.1 * self.residual_tolerance, max_points=self.max_points,
        )  # fmt: skip

    def orbit_search(self, *, dense: bool = True) -> OrbitSearch:
        """How orbits to start from are looked for."""
        ens = self.map.ensemble
        reversible = is_reversible(ens.system, ens.drive)
        return OrbitSearch(
            self.map, self.state_box, self.orbit_period, self.residual_tolerance, reversible, dense
        )


@dataclass(frozen=True)
class TracingOptions:
    """Arguments of a verb that follows branches, checked; the same for all its members.

    Attributes
    ----------
    parameter : str
    parameter_range : (float, float)
    state_box : mapping of name to (lower, upper), or None
    orbit_period, max_points : int
    tolerance : float
    """

    parameter: str
    parameter_range: tuple[float, float]
    state_box: Mapping[str, Any] | None
    orbit_period: int
    max_points: int
    tolerance: float

    def require_valid(self, ens: Ensemble) -> None:
        """Refuse what is wrong with these options for an ensemble."""
        require_tolerance(self.tolerance, "the residual")
        require_drive_periods(ens)
        require_heat_exchange(ens)
        require_state_box("state_box", self.state_box, ens)
        require_orbit_period(self.orbit_period)
        require_count("max_points", self.max_points, "A branch is made of points.")

    def tracing_of_member(self, member: Ensemble) -> Tracing:
        """For one trajectory."""
        return Tracing(
            map=StroboscopicMap(
                member, (self.parameter,), period_tolerance_for_residual(self.tolerance)
            ),
            state_box=require_state_box("state_box", self.state_box, member),
            parameter_range=self.parameter_range,
            orbit_period=self.orbit_period,
            residual_tolerance=self.tolerance,
            max_points=self.max_points,
        )


def trace_through_orbits(
    tracing: Tracing, orbits: PeriodicOrbits, values: FloatArray
) -> list[Branch]:
    """The branches through some orbits, each once.

    Parameters
    ----------
    tracing : Tracing
    orbits : PeriodicOrbits
    values : array (orbit,)
        Of the parameter, at which the orbits were found.
    """
    if not len(values):
        return []
    equations, settings = tracing.curve_equations, tracing.continuation_settings
    unknown = np.column_stack([orbits.state, values])
    at_starts = equations(unknown)
    upwards = np.zeros(unknown.shape)
    upwards[:, -1] = 1.0
    starts = CurvePoints(
        unknown,
        unit_tangents(at_starts.derivative, upwards, settings.scale),
        np.abs(at_starts.value).max(axis=1),
        at_starts.value_error,
        at_starts.extra_arrays,
    )
    block = (
        _POINTS_PREDICTED_ON_SINGLE_CURVE
        if len(values) == 1
        else _POINTS_PREDICTED_ON_EACH_OF_MANY_CURVES
    )
    curves = continue_curves(equations, starts, replace(settings, points_per_block=block))
    # Orbits on both arms of a fold lie on the same branch.  It was followed from each.
    distinct: list[Curve] = []
    for curve, start in zip(curves, unknown, strict=True):
        if not any(curve_contains(earlier, start, settings.scale) for earlier in distinct):
            distinct.append(_clip_to_bounds(equations, curve, settings))
    return [Branch(curve, _find_special_points(tracing, curve)) for curve in distinct]


def _find_special_points(tracing: Tracing, curve: Curve) -> list[SpecialPoint]:
    return find_special_points(
        tracing.curve_equations,
        curve.points,
        scale=tracing.continuation_settings.scale,
        tolerance=tracing.continuation_settings.tolerance,
        conservative=tracing.map.ensemble.system.conservative,
    )


def trace_all_branches(tracing: Tracing, slices: int) -> list[Branch]:
    """All branches that pass through one of several evenly spaced values of the parameter."""
    low, high = tracing.parameter_range
    values = low + (high - low) * (np.arange(slices) + 0.5) / slices
    orbits_at = find_all_orbits(tracing.orbit_search(dense=False), values[:, None])
    branches: list[Branch] = []
    scale = tracing.continuation_settings.scale
    # From the middle outwards: most branches pass there, and are followed together.
    for k in np.argsort(np.abs(values - values.mean()), kind="stable"):
        orbits = orbits_at[k]
        points = np.column_stack([orbits.state, np.full(len(orbits.state), values[k])])
        new = [
            i
            for i, point in enumerate(points)
            if not any(curve_contains(branch.curve, point, scale) for branch in branches)
        ]
        subset = orbits.subset(np.array(new, dtype=np.int64))
        branches += trace_through_orbits(tracing, subset, np.full(len(new), values[k]))
    return branches


def curve_contains(curve: Curve, point: FloatArray, scale: FloatArray) -> bool:
    """Whether a curve passes through a point, array (n + 1,)."""
    points = curve.points
    if len(points) < 2:
        return bool(np.linalg.norm((points.unknown[0] - point) / scale) < _MAX_DISTANCE_ON_CURVE)
    chain = points.unknown / scale
    chord = np.diff(chain, axis=0)
    away = point / scale - chain[:-1]
    square = np.maximum(np.einsum("ij,ij->i", chord, chord), 1e-300)
    part = (np.einsum("ij,ij->i", away, chord) / square).clip(0.0, 1.0)
    distance = np.linalg.norm(away - part[:, None] * chord, axis=1)
    # Between its points a curve bends away from the chord by more than the distance that
    # counts as on it, so the point is compared with the cubic.
    nearest = np.argsort(distance)[:_NEAREST_CHORD_COUNT]
    guess, _ = interpolate_curve(points, nearest, part[nearest], scale)
    return bool((np.linalg.norm((guess - point) / scale, axis=1) < _MAX_DISTANCE_ON_CURVE).any())


def _clip_to_bounds(
    equations: CurveEquations, curve: Curve, settings: ContinuationSettings
) -> Curve:
    """The curve up to the bounds exactly, where it left them."""
    points = curve.points
    if curve.end_reasons[1] == "bounds":
        points = _move_last_point_onto_bounds(equations, points, settings)
    if curve.end_reasons[0] == "bounds":
        backwards = np.arange(len(points))[::-1]
        points = _move_last_point_onto_bounds(equations, points.subset(backwards), settings)
        points = points.subset(np.arange(len(points))[::-1])
    return Curve(points, curve.is_closed, curve.end_reasons)


def _move_last_point_onto_bounds(
    equations: CurveEquations, points: CurvePoints, settings: ContinuationSettings
) -> CurvePoints:
    """Move the last point back to where the curve crosses the bounds."""
    if len(points) < 2:
        return points
    before, last = points.unknown[-2], points.unknown[-1]
    wall = np.where(last > settings.upper_bounds, settings.upper_bounds, settings.lower_bounds)
    outside = (last > settings.upper_bounds) | (last < settings.lower_bounds)
    with np.errstate(all="ignore"):
        part = np.where(outside, (wall - before) / (last - before), np.inf)
    i = int(np.argmin(part))  # the unknown whose bound is crossed first
    guess = before + np.clip(part[i], 0.0, 1.0) * (last - before)
    guess[i] = wall[i]
    direction = np.zeros((1, last.size))
    direction[0, i] = 1.0
    end, reached = correct_points(
        equations, guess[None], direction, scale=settings.scale, tolerance=settings.tolerance
    )
    inner = points.subset(slice(0, -1))
    side = np.sign(end.tangent[0] @ inner.tangent[-1])
    end = replace(end, tangent=side * end.tangent)
    return concatenate_points([inner, end]) if reached[0] else inner
