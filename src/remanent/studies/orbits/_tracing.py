"""Branches of periodic orbits of one system: followed, clipped, each kept once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from remanent._typing import BoolArray, FloatArray
from remanent.analysis.orbits.bifurcations import SpecialPoint, find_special_points
from remanent.analysis.orbits.continuation import ContinuationSettings, continue_curves
from remanent.analysis.orbits.correction import unit_tangents
from remanent.analysis.orbits.curves import Curve, CurveEquations, CurvePoints
from remanent.analysis.orbits.extended_systems import LocatedPoint, locate_special_points
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
from remanent.studies.orbits._curve_ends import clip_to_bounds, curve_contains, replace_last_point
from remanent.studies.orbits._period_map import StroboscopicMap, period_tolerance_for_residual
from remanent.studies.orbits._search import (
    OrbitSearch,
    is_planar,
    is_reversible,
    search_orbits,
)

#: First step along a branch, in scaled unknowns.
FIRST_CONTINUATION_STEP = 0.005
#: Longest step along a branch, in scaled unknowns.
LONGEST_CONTINUATION_STEP = 0.02
#: Points predicted at once where a single curve is followed.
_POINTS_PREDICTED_ON_SINGLE_CURVE = 16
#: Points predicted at once on each of many curves.
_POINTS_PREDICTED_ON_EACH_OF_MANY_CURVES = 8
#: Error of the map by which special points are located, as a share of that for branches; and of
#: the one by which their error is judged, as a share of that.
_PRECISE_MAP_SHARES = (0.1, 0.01)
#: No smaller errors are asked of these two maps.
_LEAST_PRECISE_TOLERANCES = (1e-12, 1e-13)
#: Largest resolution of these maps: where motions part fast, rounding keeps them from such errors.
_PRECISE_FINEST_RESOLUTION = 1024
#: Least distance, in scaled unknowns, within which a branch meets that of half its period.
_MIN_BRANCHING_REACH = 1e-6
#: Distance in steps within which a branch meets that of half its period.
_MAX_BRANCHING_DISTANCE_IN_STEPS = 4.0


@dataclass(frozen=True)
class Branch:
    """A branch with its special points.

    Attributes
    ----------
    curve : Curve
    special_points : list of SpecialPoint
        In order along it.
    joins_shorter_period : list of bool
        Of each special point, whether it is a doubling of the branch of half the period, at
        which this branch ends.
    """

    curve: Curve
    special_points: list[SpecialPoint]
    joins_shorter_period: list[bool]


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
    has_default_box : bool
        Whether nobody asked for the box.
    """

    map: StroboscopicMap
    state_box: FloatArray
    parameter_range: tuple[float, float]
    orbit_period: int
    residual_tolerance: float
    max_points: int
    has_default_box: bool = False

    @property
    def curve_equations(self) -> CurveEquations:
        """Equations of the curve: state and parameter are the unknowns."""
        return build_orbit_equations(self.map, self.orbit_period)

    @cached_property
    def _precise_maps(self) -> list[StroboscopicMap]:
        """With smaller errors, the second one the smallest."""
        tolerances = [self.map.period_tolerance]
        for share, least in zip(_PRECISE_MAP_SHARES, _LEAST_PRECISE_TOLERANCES, strict=True):
            tolerances.append(min(max(share * tolerances[-1], least), tolerances[-1]))
        return [
            replace(
                self.map, period_tolerance=tolerance, finest_resolution=_PRECISE_FINEST_RESOLUTION
            )
            for tolerance in tolerances[1:]
        ]

    def precise_equations(self, orbit_period: int) -> CurveEquations:
        """Equations of orbits of a period, with a smaller error: they locate special points."""
        return build_orbit_equations(self._precise_maps[0], orbit_period)

    def judging_equations(self, orbit_period: int) -> CurveEquations:
        """The same with a still smaller error: they tell how well these are located."""
        return build_orbit_equations(self._precise_maps[1], orbit_period)

    def locate(
        self, kind: str, orbit_period: int, guess: FloatArray, reach: float
    ) -> LocatedPoint | None:
        """A special point of orbits of some period near a guess, array (state + 1,)."""
        (located,) = locate_special_points(
            self.precise_equations(orbit_period), [kind], guess[None], np.array([reach]),
            self.scale, judging_equations=self.judging_equations(orbit_period),
        )  # fmt: skip
        return located

    @property
    def scale(self) -> FloatArray:
        """Units of the unknowns, array (state + 1,)."""
        return np.append(
            np.ones(len(self.state_box)), self.parameter_range[1] - self.parameter_range[0]
        )

    @property
    def continuation_settings(self) -> ContinuationSettings:
        """Bounds, scale and steps of the continuation."""
        lower, upper = (np.append(self.state_box[:, k], self.parameter_range[k]) for k in (0, 1))
        return ContinuationSettings(
            lower, upper, self.scale,
            first_step_length=FIRST_CONTINUATION_STEP, max_step_length=LONGEST_CONTINUATION_STEP,
            tolerance=self.residual_tolerance, max_points=self.max_points,
            ends_between=None if self.orbit_period % 2 else self._meets_shorter_period,
        )  # fmt: skip

    def orbit_search(self, *, dense: bool = True) -> OrbitSearch:
        """How orbits to start from are looked for."""
        ens = self.map.ensemble
        reversible = is_reversible(ens.system, ens.drive, self.map.parameter_names)
        # Branches end at the box: in the plane, orbits outside of it are not looked for.
        return OrbitSearch(
            self.map, self.state_box, self.orbit_period, self.residual_tolerance, reversible, dense,
            box_is_free=self.has_default_box and not is_planar(self.map),
        )  # fmt: skip

    def states_at_all_phases(self, states: FloatArray, values: FloatArray) -> list[FloatArray]:
        """Points of orbits after 0, 1, ... drive periods, each an array (orbit, state)."""
        phases = [states]
        for _ in range(self.orbit_period - 1 if len(states) else 0):
            phases.append(self.map(phases[-1], values[:, None], 1).state)
        return phases

    def _meets_shorter_period(self, points: CurvePoints) -> BoolArray:
        """Between which points the orbits have half the period: array (point - 1,).

        There the branch turns back and passes through the same orbits once more, at their other
        phase: the way from each point to that half the period later changes its sign.
        """
        turns = points.tangent[:-1, -1] * points.tangent[1:, -1] < 0.0
        rows = np.flatnonzero(turns)
        if rows.size:
            ends = points.unknown[np.concatenate([rows, rows + 1])]
            away = self._state_after(ends, self.orbit_period // 2) - ends[:, :-1]
            before, after = np.split(away, 2)
            turns[rows] = np.einsum("ij,ij->i", before, after) < 0.0
        return np.asarray(turns)

    def _state_after(self, unknown: FloatArray, periods: int) -> FloatArray:
        return self.map(unknown[:, :-1], unknown[:, -1:], periods).state

    def point_of_branch(self, located: LocatedPoint) -> CurvePoints:
        """A located point as one of this branch, to be left along its null vector."""
        values = self.curve_equations(located.unknown[None])
        return CurvePoints(
            located.unknown[None], located.null_vector[None], np.abs(values.value).max(axis=1),
            values.value_error, values.extra_arrays,
        )  # fmt: skip


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

    def require_valid(self, ens: Ensemble) -> TracingOptions:
        """These options with plain integers; refuse what is wrong with them for an ensemble."""
        require_drive_periods(ens)
        require_heat_exchange(ens)
        require_state_box("state_box", self.state_box, ens)
        return replace(
            self,
            orbit_period=require_orbit_period(self.orbit_period),
            max_points=require_count("max_points", self.max_points, "A branch is made of points."),
            tolerance=require_tolerance(self.tolerance, "the residual"),
        )

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
            has_default_box=self.state_box is None,
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
    phases = np.stack(tracing.states_at_all_phases(orbits.state, values), axis=1)
    # Orbits on both arms of a fold lie on the same branch, which was followed from each.
    distinct: list[Branch] = []
    for k, curve in enumerate(curves):
        if not lies_on_branches(tracing, distinct, phases[k], values[k]):
            distinct.append(_finished_branch(tracing, curve))
    return distinct


def trace_from_special_point(tracing: Tracing, start: LocatedPoint, *, doubles: bool) -> Branch:
    """The branch that leaves another one at a special point.

    Parameters
    ----------
    tracing : Tracing
        Of the branch to be followed.
    start : LocatedPoint
        Where it leaves, along the null vector.
    doubles : bool
        Whether it has twice the period of the other.  Then both directions hold the same orbits,
        at two phases, and one of them is followed.
    """
    settings = replace(
        tracing.continuation_settings, points_per_block=_POINTS_PREDICTED_ON_SINGLE_CURVE
    )
    (curve,) = continue_curves(
        tracing.curve_equations, tracing.point_of_branch(start), settings, both_ways=not doubles
    )
    if doubles:
        curve = replace(curve, end_reasons=("branching", curve.end_reasons[1]))
        return _finished_branch(tracing, curve, begins_at=start)
    branch = _finished_branch(tracing, curve)
    k = int(np.linalg.norm((curve.points.unknown - start.unknown) / tracing.scale, axis=1).argmin())
    special = _special_point(tracing, "branch point", k, start)
    others = [
        one
        for one in branch.special_points
        if abs(one.segment_index - k) > 1 or one.kind not in ("fold", "branch point")
    ]
    every = sorted([*others, special], key=lambda one: one.segment_index)
    return Branch(branch.curve, every, [False] * len(every))


def _special_point(
    tracing: Tracing, kind: str, segment_index: int, located: LocatedPoint
) -> SpecialPoint:
    return SpecialPoint(kind, segment_index, tracing.point_of_branch(located), located.error)


def _finished_branch(
    tracing: Tracing, curve: Curve, *, begins_at: LocatedPoint | None = None
) -> Branch:
    """A curve cut at its ends, with its special points.

    Where it begins on the branch of half the period, `begins_at` is that point.
    """
    curve = clip_to_bounds(tracing.curve_equations, curve, tracing.continuation_settings)
    last: LocatedPoint | None = None
    if curve.end_reasons[1] == "branching":
        curve, last = _cut_at_shorter_period(tracing, curve)
    first = begins_at
    if curve.end_reasons[0] == "branching" and first is None:
        curve, first = _cut_at_shorter_period(tracing, curve.reversed())
        curve = curve.reversed()
    inner = find_special_points(
        tracing.curve_equations,
        curve.points,
        scale=tracing.scale,
        tolerance=tracing.residual_tolerance,
        conservative=tracing.map.ensemble.system.conservative,
        precise_equations=tracing.precise_equations(tracing.orbit_period),
        judging_equations=tracing.judging_equations(tracing.orbit_period),
        touching_ends=(first is not None, last is not None),
    )
    end_index = max(len(curve.points) - 2, 0)
    before = [] if first is None else [_special_point(tracing, "period doubling", 0, first)]
    after = [] if last is None else [_special_point(tracing, "period doubling", end_index, last)]
    joins = [True] * len(before) + [False] * len(inner) + [True] * len(after)
    return Branch(curve, [*before, *inner, *after], joins)


def _cut_at_shorter_period(tracing: Tracing, curve: Curve) -> tuple[Curve, LocatedPoint | None]:
    """The curve up to where its orbits have half the period, beyond which its last point is."""
    points = curve.points
    before = points.unknown[-2 if len(points) > 1 else -1]
    later = tracing._state_after(before[None], tracing.orbit_period // 2)[0]
    guess = np.append(0.5 * (before[:-1] + later), before[-1])
    step = np.linalg.norm((points.unknown[-1] - before) / tracing.scale)
    located = tracing.locate(
        "period doubling", tracing.orbit_period // 2, guess,
        _MAX_BRANCHING_DISTANCE_IN_STEPS * float(step) + _MIN_BRANCHING_REACH,
    )  # fmt: skip
    if located is None:
        return replace(curve, points=points.subset(slice(0, max(len(points) - 1, 1)))), None
    return replace_last_point(curve, tracing.point_of_branch(located)), located


def lies_on_branches(
    tracing: Tracing, branches: list[Branch], phases: FloatArray, value: float
) -> bool:
    """Whether an orbit is on one of some branches, by any of its points.

    Parameters
    ----------
    tracing : Tracing
    branches : list of Branch
    phases : array (period, state)
        The points of the orbit.
    value : float
        Of the parameter.
    """
    return any(
        curve_contains(branch.curve, np.append(state, value), tracing.scale)
        for branch in branches
        for state in phases
    )


def trace_all_branches(tracing: Tracing, slices: int) -> tuple[list[Branch], str]:
    """All branches that pass through one of several evenly spaced values of the parameter.

    The second value says why some may be missing; it is empty where the search for orbits found
    all of them at each value.
    """
    low, high = tracing.parameter_range
    values = low + (high - low) * (np.arange(slices) + 0.5) / slices
    outcomes = search_orbits(tracing.orbit_search(dense=False), values[:, None])
    branches: list[Branch] = []
    # From the middle outwards: most branches pass there, and are followed together.
    for k in np.argsort(np.abs(values - values.mean()), kind="stable"):
        orbits = outcomes[k].orbits
        here = np.full(len(orbits.state), values[k])
        phases = np.stack(tracing.states_at_all_phases(orbits.state, here), axis=1)
        new = [
            i
            for i in range(len(here))
            if not lies_on_branches(tracing, branches, phases[i], float(values[k]))
        ]
        subset = orbits.subset(np.array(new, dtype=np.int64))
        branches += trace_through_orbits(tracing, subset, here[: len(new)])
    return branches, _why_branches_may_be_missing(
        tracing.map.parameter_names[0], values, [outcome.reason for outcome in outcomes]
    )


def _why_branches_may_be_missing(parameter: str, values: FloatArray, reasons: list[str]) -> str:
    """What stopped the search for orbits at some values of the parameter; "" if nothing did."""
    stopped = [k for k, reason in enumerate(reasons) if reason]
    if not stopped:
        return ""
    first = stopped[0]
    return (
        f"branches may be missing: at {len(stopped)} of {len(values)} values of {parameter}, "
        f"such as {values[first]:.4g}, the search for orbits was not complete: {reasons[first]}"
    )
