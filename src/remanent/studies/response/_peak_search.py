"""Peaks of branches of forced response: the curves resolved, and each peak refined."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.curves import CurvePoints, concatenate_points, interpolate_curve
from remanent.analysis.orbits.errors import orbit_errors
from remanent.analysis.response.tops import top_of_polynomials
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import ERROR_SHARE_IN_FUNCTIONS, Problem, Request
from remanent.models.actuator import Actuator
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.observables import largest_observable_error
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.orbits._orbit_tables import describe_orbits
from remanent.studies.orbits._period_map import period_tolerance_for_residual
from remanent.studies.orbits._tracing import Branch, Tracing

#: Between neighbouring points multipliers change by no more than this share of their distance
#: from 1, to the inverse of which the response to a small harmonic is proportional.
_LARGEST_CHANGE_OF_MULTIPLIERS = 0.5
#: Angle through which free oscillations turn in the difference of the periods of neighbours.
_LARGEST_ANGLE_BETWEEN_POINTS = 1.0
#: How often intervals are halved, and how many points a curve may have then.
_MAX_HALVINGS = 8
_MAX_RESOLVED_POINTS = 8192
#: Points on both sides of a peak through which a polynomial is laid.
_NODE_COUNT = 9
#: How often a peak is looked at again, more closely, and by which factor.
_MAX_ZOOMS = 4
_ZOOM_FACTOR = 4.0
#: Residual of the orbits of refined peaks.
_REFINED_RESIDUAL = 1e-12
#: Distance of orbits beside a peak at which its harmonics are compared, as a share of the nodes'.
_NEARBY_SHARE = 1e-3
#: Tolerances of the amplitudes of refined peaks: the next is taken where one cannot be met.
_AMPLITUDE_TOLERANCES = (1e-11, 1e-8, 1e-5)
#: Instants of an orbit at which the slope of an observable is looked at, and their tolerance.
_SLOPE_SAMPLES, _SLOPE_TOLERANCE = 32, 1e-5
#: The same at the peak itself.
_TOLERANCES_AT_PEAK = (1e-12, *_AMPLITUDE_TOLERANCES)


@dataclass(frozen=True)
class Peak:
    """A peak of a branch: where it is, and the orbit there.

    Attributes
    ----------
    omega, omega_error : float
        Frequency of the drive; the error is NaN where the branch ends still rising.
    amplitude, amplitude_error : float
    state : array (state,)
        At phase 0.
    state_error : float
    nearby_omega : array (node,)
    nearby_states : array (node, state)
        Orbits on both sides, as far away as the error of the peak may be.
    orbit_period : int
        Of the orbit, in drive periods.
    stability : str
    is_unbounded : bool
        Whether the branch ends here, still rising.
    is_from_period_doubling : bool
        Whether the branch springs from one of another period.
    """

    omega: float
    omega_error: float
    amplitude: float
    amplitude_error: float
    state: FloatArray
    state_error: float
    nearby_omega: FloatArray
    nearby_states: FloatArray
    orbit_period: int
    stability: str
    is_unbounded: bool
    is_from_period_doubling: bool


@dataclass(frozen=True)
class PeakSearch:
    """Looks for peaks on the branches of one system.

    Attributes
    ----------
    member : Ensemble
        Of one trajectory.
    tracing : Tracing
        How its branches were followed, with ``omega`` as the parameter.
    natural_frequency : float
        Of small free oscillations; NaN where there are none.
    """

    member: Ensemble
    tracing: Tracing
    natural_frequency: float

    def peaks_of(self, branch: Branch) -> list[Peak]:
        """Local maxima of the amplitude along a branch, and ends that run off."""
        points = self.resolved(branch.curve.points)
        amplitude, _ = self._amplitudes(points)
        low, high = self.tracing.parameter_range
        peaks = []
        for k in _local_maximum_indices(amplitude):
            omega = points.unknown[k, -1]
            inner = 0 < k < len(points) - 1
            if not inner and not low < omega < high:
                continue  # the end of the range of frequencies
            doubled = any(branch.joins_shorter_period)
            peaks.append(self._refined(points, int(k), inner=inner, doubled=doubled))
        return peaks

    def resolved(self, points: CurvePoints) -> CurvePoints:
        """A curve with further points, where its own may hide what the multipliers tell of.

        A small harmonic of the load has a response in proportion to 1/(1 - mu): neighbouring
        points are close enough for its peak where mu moves by a part of that distance only.
        """
        for _ in range(_MAX_HALVINGS):
            if len(points) < 2 or len(points) > _MAX_RESOLVED_POINTS:
                break
            wide = np.flatnonzero(self._intervals_to_halve(points))
            if not wide.size:
                break
            new, reached = self._points_between(points, wide, np.full(wide.size, 0.5))
            new, wide = new.subset(reached), wide[reached]
            if not wide.size:
                break
            order = np.argsort(np.concatenate([np.arange(len(points)), wide + 0.5]), kind="stable")
            points = concatenate_points([points, new]).subset(order)
        return points

    def _intervals_to_halve(self, points: CurvePoints) -> BoolArray:
        """Which intervals between neighbouring points are too wide."""
        multipliers = np.linalg.eigvals(points.extra_arrays["jacobian"])
        before, after = multipliers[:-1], multipliers[1:]
        change = np.abs(before[:, :, None] - after[:, None, :]).min(axis=2)
        distance = np.minimum(np.abs(1.0 - before), np.abs(1.0 - after).min(axis=1)[:, None])
        wide = (change > _LARGEST_CHANGE_OF_MULTIPLIERS * distance).any(axis=1)
        periods = 2.0 * np.pi * self.tracing.orbit_period / points.unknown[:, -1]
        angle = self.natural_frequency * np.abs(np.diff(periods))
        with np.errstate(invalid="ignore"):
            return np.asarray(wide | (angle > _LARGEST_ANGLE_BETWEEN_POINTS))

    def _points_between(
        self, points: CurvePoints, segment: IntArray, fraction: FloatArray
    ) -> tuple[CurvePoints, BoolArray]:
        settings = self.tracing.continuation_settings
        guess, direction = interpolate_curve(points, segment, fraction, settings.scale)
        return correct_points(
            self.tracing.curve_equations, guess, direction,
            scale=settings.scale, tolerance=settings.tolerance,
        )  # fmt: skip

    def _refined(self, points: CurvePoints, k: int, *, inner: bool, doubled: bool) -> Peak:
        """The peak near a point of a curve."""
        place = points.subset(np.array([k]))
        span, shift_error = np.nan, np.nan
        nearby, finest = place, self
        if inner:
            finest = closer = self._with_smaller_errors()
            place, span, shift_error = closer._climb(points, k)
            if shift_error >= span:  # nothing was found with such small errors
                place, span, shift_error = self._climb(points, k)
                finest = self
            nearby = closer._nearby(place, max(shift_error, _NEARBY_SHARE * span))
        (position_error,) = self._position_errors(place)
        slope = abs(float(place.tangent[0, -1])) * self.tracing.continuation_settings.scale[-1]
        omega, period = place.unknown[:, -1], self.tracing.orbit_period
        errors = orbit_errors(finest.tracing.map, place.unknown[:, :-1], omega[:, None], period)
        orbit = describe_orbits(self.member, errors, period, {"omega": omega})
        # At this frequency; where none is told, the curve's own error stands for it.
        state_error = np.fmin(errors.error, position_error)
        (amplitude,), (error,) = self._amplitudes(
            place, state_error, tolerances=_TOLERANCES_AT_PEAK
        )
        return Peak(
            omega=float(place.unknown[0, -1]),
            omega_error=float(shift_error * slope + position_error) if inner else np.nan,
            amplitude=float(amplitude),
            amplitude_error=float(error),
            state=place.unknown[0, :-1],
            state_error=float(state_error[0]),
            nearby_omega=nearby.unknown[:, -1],
            nearby_states=nearby.unknown[:, :-1],
            orbit_period=self.tracing.orbit_period,
            stability=str(orbit["stability"][0]),
            is_unbounded=not inner,
            is_from_period_doubling=doubled,
        )

    def _with_smaller_errors(self) -> PeakSearch:
        """The same with a map whose errors hide less of the top of a peak."""
        tolerance = min(_REFINED_RESIDUAL, self.tracing.residual_tolerance)
        period_map = replace(
            self.tracing.map, period_tolerance=period_tolerance_for_residual(tolerance)
        )
        return replace(
            self, tracing=replace(self.tracing, map=period_map, residual_tolerance=tolerance)
        )

    def _climb(self, points: CurvePoints, k: int) -> tuple[CurvePoints, float, float]:
        """The top between the neighbours of a point: the orbit, its span, and its error.

        In planes across one direction the curve is a function of the distance along it, and so
        is the amplitude.  Polynomials of two degrees through points at Chebyshev's nodes give its
        top; their difference, and what errors of the amplitudes make of it, is the error.
        """
        scale = self.tracing.continuation_settings.scale
        centre = points.subset(np.array([k]))
        direction = centre.tangent[0]

        def along(unknown: FloatArray, origin: CurvePoints) -> FloatArray:
            return np.asarray((unknown - origin.unknown[0]) / scale @ direction)

        around = points.subset(slice(k - 1, k + 2))
        span = float(np.abs(along(around.unknown, centre)).max())
        error = span
        for _ in range(_MAX_ZOOMS):
            nodes = self._at_distances(centre, direction, span)
            if nodes is None:
                break
            distance = along(nodes.unknown, centre)
            values, errors = self._amplitudes(nodes)
            if not np.isfinite(values).all():
                break
            top = top_of_polynomials(distance, values, float(errors.max()))
            if top is None:
                span /= _ZOOM_FACTOR
                continue
            moved = self._at_place(nodes, distance, top.place, direction)
            if moved is None or top.error >= error:
                break
            centre, error = moved, top.error
            if top.cut_off <= top.noise:
                break  # closer by, errors of the amplitudes would show more
            span = max(span / _ZOOM_FACTOR, 2.0 * error)
        return centre, span, error

    def _at_distances(
        self, centre: CurvePoints, direction: FloatArray, span: float
    ) -> CurvePoints | None:
        """Points of the curve at Chebyshev's nodes on both sides of one; None if any is lost."""
        settings = self.tracing.continuation_settings
        nodes = -np.cos(np.pi * (np.arange(_NODE_COUNT) + 0.5) / _NODE_COUNT)
        guess = (
            centre.unknown
            + span
            * nodes[:, None]
            * centre.tangent
            / (direction @ centre.tangent[0])
            * settings.scale
        )
        found, reached = correct_points(
            self.tracing.curve_equations, guess, np.tile(direction, (_NODE_COUNT, 1)),
            scale=settings.scale, tolerance=settings.tolerance,
        )  # fmt: skip
        return found if reached.all() else None

    def _at_place(
        self, nodes: CurvePoints, distance: FloatArray, shift: float, direction: FloatArray
    ) -> CurvePoints | None:
        """The point of the curve at a distance between nodes."""
        settings = self.tracing.continuation_settings
        near = int(np.argmin(np.abs(distance - shift)))
        tangent = nodes.tangent[near] / (direction @ nodes.tangent[near])
        guess = nodes.unknown[near] + (shift - distance[near]) * tangent * settings.scale
        found, reached = correct_points(
            self.tracing.curve_equations, guess[None], direction[None],
            scale=settings.scale, tolerance=settings.tolerance,
        )  # fmt: skip
        return found if reached.all() else None

    def _nearby(self, place: CurvePoints, reach: float) -> CurvePoints:
        """Orbits at a distance on both sides of a peak, and the peak between them."""
        settings = self.tracing.continuation_settings
        steps = reach * np.array([-1.0, 0.0, 1.0])[:, None]
        guess = place.unknown + steps * place.tangent * settings.scale
        found, reached = correct_points(
            self.tracing.curve_equations, guess, np.tile(place.tangent, (3, 1)),
            scale=settings.scale, tolerance=settings.tolerance,
        )  # fmt: skip
        return found if reached.all() else place

    def _position_errors(self, points: CurvePoints) -> FloatArray:
        """How far the exact curve may be from each point: what is left, by the inverse."""
        scale = self.tracing.continuation_settings.scale
        matrices = points.extra_arrays["derivative"] * scale
        left = points.residual + points.residual_error
        inverse = np.linalg.norm(np.linalg.pinv(matrices), 2, axis=(1, 2))
        return np.asarray(inverse * left * np.sqrt(matrices.shape[1]))

    def _amplitudes(
        self,
        points: CurvePoints,
        position_errors: FloatArray | None = None,
        tolerances: tuple[float, ...] = _AMPLITUDE_TOLERANCES,
    ) -> tuple[FloatArray, FloatArray]:
        """Amplitudes of the orbits at points of a curve, and their errors, arrays (point,)."""
        if position_errors is None:
            position_errors = self._position_errors(points)
        orbits = self.member.with_initial_states(
            points.unknown[:, :-1], {"omega": points.unknown[:, -1]}
        )
        problem = initial_value_problem(
            orbits, self.tracing.orbit_period * require_drive_periods(orbits)
        )
        missing = np.ones(len(points), dtype=np.bool_)
        amplitude, error = np.full((2, len(points)), np.nan)
        for tolerance in tolerances:
            outcome = integrate(
                replace(problem, invalid=~missing),
                Request(wants_extremes=True), tolerance=tolerance,
            )  # fmt: skip
            found = 0.5 * (outcome.maximum - outcome.minimum)
            amplitude = np.where(missing, found, amplitude)
            error = np.where(missing, outcome.error, error)
            missing = np.isnan(amplitude)
            if not missing.any():
                break
        # An orbit that is off by d has an amplitude that is off by d times how far its motion
        # carries a difference, which the largest entry of its derivatives stands for.
        carried = np.abs(points.extra_arrays["jacobian"]).max(axis=(1, 2)) + 1.0
        slope = self._observable_slopes(problem)
        return amplitude, error + 2.0 * slope * carried * position_errors

    def _observable_slopes(self, problem: Problem) -> FloatArray:
        """How far an observable of the user's own moves with the state, at most, array (point,).

        Thickness stretches move by about as much as the stretch.
        """
        count, name = len(problem.initial_states), problem.field.observable_name
        if isinstance(self.member.system, Actuator) or name in problem.field.state_names:
            return np.ones(count)
        share = np.arange(_SLOPE_SAMPLES) / _SLOPE_SAMPLES
        times = np.asarray(problem.duration)[:, None] * share
        outcome = integrate(problem, Request(times=times), tolerance=_SLOPE_TOLERANCE)
        assert outcome.states is not None
        one = np.ones(count) / ERROR_SHARE_IN_FUNCTIONS
        return largest_observable_error(problem, name, times, outcome.states, one)


def _local_maximum_indices(values: FloatArray) -> IntArray:
    """Where an array is larger than its neighbours, ends included."""
    padded = np.concatenate([[-np.inf], values, [-np.inf]])
    return np.flatnonzero((padded[1:-1] > padded[:-2]) & (padded[1:-1] >= padded[2:]))
