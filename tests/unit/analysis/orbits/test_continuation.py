"""Curves with known shape, and maps with known orbits and bifurcations."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field

import numpy as np
import pytest

from remanent._typing import BoolArray, FloatArray
from remanent.analysis.orbits.bifurcations import SpecialPoint, find_special_points
from remanent.analysis.orbits.continuation import (
    ContinuationSettings,
    _predict_points,
    _start_arm,
    continue_curves,
)
from remanent.analysis.orbits.correction import correct_points, unit_tangents
from remanent.analysis.orbits.curves import (
    Curve,
    CurveEquations,
    CurvePoints,
    EquationValues,
    interpolate_curve,
)
from remanent.analysis.orbits.maps import Map, MapImage
from remanent.analysis.orbits.orbit_equations import build_orbit_equations
from remanent.analysis.orbits.periodic_orbits import (
    PeriodicOrbits,
    distinct_orbits_of_least_period,
    newton_fixed_points,
    position_errors,
)
from remanent.analysis.orbits.stability import Stability, floquet_multipliers, orbit_stability

EPS = np.finfo(float).eps


def start(equations: CurveEquations, unknown: FloatArray, scale: FloatArray) -> CurvePoints:
    here = equations(unknown)
    along = np.zeros(unknown.shape)
    along[:, -1] = 1.0
    return CurvePoints(
        unknown, unit_tangents(here.derivative, along, scale), np.abs(here.value).max(axis=1),
        here.value_error, here.extra_arrays,
    )  # fmt: skip


def traced(
    equations: CurveEquations, z: list[float], box: list[list[float]], **options: float
) -> Curve:
    lower, upper = np.array(box).T
    scale = np.ones(len(z))
    settings = ContinuationSettings(lower, upper, scale, tolerance=1e-12, **options)  # type: ignore[arg-type]
    (curve,) = continue_curves(equations, start(equations, np.array([z]), scale), settings)
    return curve


def plane(f: str) -> CurveEquations:
    """One equation in two unknowns (x, p)."""

    def equations(z: FloatArray) -> EquationValues:
        x, p = z.T
        value, dx, dp = {
            "circle": (x**2 + p**2 - 1.0, 2.0 * x, 2.0 * p),
            "fold": (x**2 - p, 2.0 * x, -np.ones_like(p)),
            "cubic": (x**3 - x - p, 3.0 * x**2 - 1.0, -np.ones_like(p)),
            "lemniscate": (x**2 - p**2 * (1.0 - p**2), 2.0 * x, -2.0 * p + 4.0 * p**3),
        }[f]
        derivative = np.stack([dx, dp], axis=1)[:, None, :]
        return EquationValues(value[:, None], derivative, np.full(len(z), EPS), {"d": derivative})

    return equations


def test_a_circle_closes() -> None:
    """x^2 + p^2 = 1: every point on it, once round, the first point again as the last."""
    curve = traced(plane("circle"), [1.0, 0.0], [[-2, 2], [-2, 2]])
    assert curve.is_closed
    z = curve.points.unknown
    np.testing.assert_allclose(np.hypot(*z.T), 1.0, atol=1e-12)
    angle = np.unwrap(np.arctan2(z[:, 1], z[:, 0]))
    assert abs(angle[-1] - angle[0]) == pytest.approx(2.0 * np.pi, abs=0.1)
    assert np.array_equal(z[0], z[-1])
    assert (np.diff(angle) > 0).all() or (np.diff(angle) < 0).all()


def test_a_curve_goes_round_folds_to_its_bounds() -> None:
    """p = x^3 - x: x runs through, p turns at its extremes ±2/√27, both ends leave the box."""
    curve = traced(plane("cubic"), [0.0, 0.0], [[-3, 3], [-2, 2]])
    x, p = curve.points.unknown.T
    np.testing.assert_allclose(x**3 - x, p, atol=1e-11)
    assert curve.end_reasons == ("bounds", "bounds")
    assert not curve.is_closed
    assert (np.diff(x) > 0).all() or (np.diff(x) < 0).all()
    assert {-1.0, 1.0} == set(np.sign(p[[0, -1]]))
    turns = np.flatnonzero(np.diff(np.sign(curve.points.tangent[:, -1])))
    np.testing.assert_allclose(np.sort(p[turns]), [-2 / 27**0.5, 2 / 27**0.5], atol=2e-3)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_points_are_a_tenth_of_the_tolerance_from_a_curve(tolerance: float) -> None:
    """x^2 + p^2 = 1, known to rounding: corrections go on beyond the tolerance that is asked."""
    angle = np.linspace(0.0, 6.0, 40)
    along = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    guess = 1.3 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    points, reached = correct_points(
        plane("circle"), guess, along, scale=np.ones(2), tolerance=tolerance
    )
    assert reached.all()
    assert points.residual.max() <= 0.1 * tolerance


def test_steps_follow_the_curvature() -> None:
    """A sharp bend is resolved; a straight stretch takes few points."""
    curve = traced(plane("fold"), [3.0, 9.0], [[-5, 5], [-1, 20]], max_step_length=0.5)
    gaps = np.linalg.norm(np.diff(curve.points.unknown, axis=0), axis=1)
    assert gaps.max() > 4 * gaps[np.argmin(np.abs(curve.points.unknown[:-1, 0]))]


def test_a_curve_goes_straight_on_where_it_crosses_itself() -> None:
    """The lemniscate x^2 = p^2 (1 - p^2): one curve through the crossing at 0, closed."""
    curve = traced(plane("lemniscate"), [0.0, 1.0], [[-2, 2], [-2, 2]])
    assert curve.is_closed
    x, p = curve.points.unknown.T
    np.testing.assert_allclose(x**2, p**2 * (1.0 - p**2), atol=1e-11)
    # Straight on, p changes its sign at 0; turning off there, it would keep it.
    assert (p.min(), p.max()) == (pytest.approx(-1.0, abs=1e-2), pytest.approx(1.0, abs=1e-2))
    assert np.count_nonzero(np.diff(np.sign(p))) == 2


@pytest.mark.parametrize("scale", [1.0, 10.0])
def test_cubics_are_foreseen_exactly_with_their_directions(scale: float) -> None:
    """z(s) = (s, k s (s + g) (1 + q s)): through z(-g) = (-g, 0) and z(0) = 0 with their slopes."""
    gap, k, q, step = 0.4, 0.7, 0.3, 0.25

    def point(s: FloatArray) -> FloatArray:
        return scale * np.stack([s, k * s * (s + gap) * (1.0 + q * s)], axis=1)

    def slope(s: FloatArray) -> FloatArray:
        along = k * (2.0 * s + gap) * (1.0 + q * s) + k * q * s * (s + gap)
        return np.stack([np.ones_like(s), along], axis=1)

    settings = ContinuationSettings(
        np.full(2, -9.0), np.full(2, 9.0), np.full(2, scale), first_step_length=step
    )
    ends = np.array([-gap, 0.0])
    none = np.zeros(1)
    head = CurvePoints(point(ends)[1:], slope(ends)[1:], none, none, {})
    arm = _start_arm(head, settings)
    arm.point_before_last = (point(ends)[0], slope(ends)[0])
    guess, direction = _predict_points([arm], settings)
    ahead = step * np.arange(1.0, settings.points_per_block + 1)
    np.testing.assert_allclose(guess, point(ahead), rtol=1e-13)
    exact = slope(ahead) / np.linalg.norm(slope(ahead), axis=1, keepdims=True)
    np.testing.assert_allclose(direction, exact, rtol=1e-13)


def test_curves_followed_together_are_those_followed_alone() -> None:
    """Determinism: the company of other curves changes no bit of one."""
    equations, scale = plane("cubic"), np.ones(2)
    settings = ContinuationSettings(
        np.array([-3.0, -2.0]), np.array([3.0, 2.0]), scale, tolerance=1e-12
    )
    x = np.array([0.0, 1.1, -1.3])
    starts = start(equations, np.stack([x, x**3 - x], axis=1), scale)
    together = continue_curves(equations, starts, settings)
    assert len(together) == x.size
    for k, curve in enumerate(together):
        (alone,) = continue_curves(equations, starts.subset(slice(k, k + 1)), settings)
        np.testing.assert_array_equal(curve.points.unknown, alone.points.unknown)
        assert curve.end_reasons == alone.end_reasons


@pytest.mark.parametrize("number", [1, 1000])
def test_a_curve_ends_after_as_many_points_as_were_asked_for(number: int) -> None:
    """At least that number in each direction, at most one block more, and the end says why."""
    curve = traced(
        plane("circle"),
        [1.0, 0.0],
        [[-2, 2], [-2, 2]],
        max_points=number,
        max_step_length=0.001,
        first_step_length=0.001,
    )
    assert curve.end_reasons == ("points", "points")
    assert 2 * number - 1 <= len(curve.points) <= 2 * (number + 8)


def test_a_curve_that_ceases_ends_lost() -> None:
    """x = p where it is known, p < 1/2: followed up to there, and the end says so."""

    def equations(z: FloatArray) -> EquationValues:
        x, p = z.T
        value = np.where(p < 0.5, x - p, np.nan)[:, None]
        derivative = np.tile([1.0, -1.0], (len(z), 1, 1))
        return EquationValues(value, derivative, np.full(len(z), EPS), {"d": derivative})

    curve = traced(equations, [0.0, 0.0], [[-1, 1], [-1, 1]])
    assert sorted(curve.end_reasons) == ["bounds", "lost"]
    assert 0.5 - 1e-6 < curve.points.unknown[:, 1].max() < 0.5


@pytest.mark.parametrize("end", np.linspace(0.021, 0.901, 23))
def test_a_curve_ends_with_the_first_point_beyond_where_it_is_told_to(end: float) -> None:
    """x = p up to a point on it, within a block of points or between two blocks."""
    derivative = np.array([[1.0, -1.0]])

    def equations(z: FloatArray) -> EquationValues:
        slopes = np.tile(derivative, (len(z), 1, 1))
        return EquationValues(z @ derivative.T, slopes, np.full(len(z), EPS), {"d": slopes})

    def passes(points: CurvePoints) -> BoolArray:
        beyond = points.unknown[:, 1] > end
        return np.asarray(beyond[1:] & ~beyond[:-1])

    scale = np.ones(2)
    settings = ContinuationSettings(-scale, scale, scale, tolerance=1e-12, ends_between=passes)
    (curve,) = continue_curves(
        equations, start(equations, np.zeros((1, 2)), scale), settings, both_ways=False
    )
    assert curve.end_reasons == ("start", "branching")
    assert curve.points.unknown[-2, 1] <= end < curve.points.unknown[-1, 1]


def test_places_between_points_lie_on_the_curve_to_fourth_order() -> None:
    """Hermite's cubic through two points of a circle: half the step, a sixteenth of the error."""
    errors = []
    for angle in (0.2, 0.1):
        ends = np.array([0.0, angle])
        unknown = np.stack([np.cos(ends), np.sin(ends)], axis=1)
        tangent = np.stack([-np.sin(ends), np.cos(ends)], axis=1)
        points = CurvePoints(unknown, tangent, np.zeros(2), np.zeros(2), {})
        place, direction = interpolate_curve(points, np.array([0]), np.array([0.5]), np.ones(2))
        errors.append(abs(np.hypot(*place[0]) - 1.0))
        np.testing.assert_allclose(direction[0] @ place[0], 0.0, atol=1e-12)
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.05)
    assert errors[1] < 1e-5


@dataclass(frozen=True)
class Logistic:
    """x -> r x (1 - x)."""

    dimension: int = 1

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        x, r = states[:, 0], parameters[:, 0]
        slope, by_r = np.ones_like(x), np.zeros_like(x)
        for _ in range(iterate):
            by_r = x * (1.0 - x) + r * (1.0 - 2.0 * x) * by_r
            slope = r * (1.0 - 2.0 * x) * slope
            x = r * x * (1.0 - x)
        return MapImage(
            x[:, None], slope[:, None, None], by_r[:, None, None], np.full(len(x), iterate * EPS)
        )


@dataclass
class WithoutFixedPoint:
    """x -> x^2 + x + p, which has none where p > 0; counts how often it is applied to each p."""

    applied: Counter[float] = field(default_factory=Counter)
    dimension: int = 1

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        x, p = states[:, 0], parameters[:, 0]
        self.applied.update(p.tolist())
        return MapImage(
            (x**2 + x + p)[:, None], (2.0 * x + 1.0)[:, None, None], np.ones((len(x), 1, 1)),
            np.full(len(x), EPS),
        )  # fmt: skip


@dataclass(frozen=True)
class Delayed:
    """The delayed logistic map (x, y) -> (r x (1 - y), x): a Neimark-Sacker point at r = 2."""

    dimension: int = 2

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        (x, y), r = states.T, parameters[:, 0]
        jacobian = np.tile(np.eye(2), (len(x), 1, 1))
        by_r = np.zeros((len(x), 2, 1))
        for _ in range(iterate):
            step = np.zeros_like(jacobian)
            step[:, 0, 0], step[:, 0, 1], step[:, 1, 0] = r * (1.0 - y), -r * x, 1.0
            own = np.zeros_like(by_r)
            own[:, 0, 0] = x * (1.0 - y)
            jacobian, by_r = step @ jacobian, step @ by_r + own
            x, y = r * x * (1.0 - y), x
        return MapImage(np.stack([x, y], axis=1), jacobian, by_r, np.full(len(x), iterate * EPS))


def specials(map_: Map, z: list[float], box: list[list[float]]) -> list[SpecialPoint]:
    equations = build_orbit_equations(map_, 1)
    curve = traced(equations, z, box)
    return find_special_points(
        equations, curve.points, scale=np.ones(len(z)), tolerance=1e-12, conservative=False
    )


def test_the_logistic_map_doubles_its_period_at_3() -> None:
    """The multiplier 2 - r of x = 1 - 1/r is -1 at r = 3, within the error that is reported."""
    found = specials(Logistic(), [0.5, 2.0], [[0.1, 1.0], [1.5, 3.8]])
    assert [special.kind for special in found] == ["period doubling"]
    assert found[0].point.unknown[0] == pytest.approx([2.0 / 3.0, 3.0], abs=1e-10)
    assert abs(found[0].point.unknown[0, 1] - 3.0) <= found[0].parameter_error < 1e-9


def test_short_steps_hide_no_special_point() -> None:
    """The same doubling on a branch whose points are 1e-4 apart."""
    equations = build_orbit_equations(Logistic(), 1)
    curve = traced(
        equations, [1.0 - 1.0 / 2.999, 2.999], [[0.1, 1.0], [2.998, 3.002]],
        first_step_length=1e-4, max_step_length=1e-4,
    )  # fmt: skip
    (found,) = find_special_points(
        equations, curve.points, scale=np.ones(2), tolerance=1e-12, conservative=False
    )
    assert found.point.unknown[0] == pytest.approx([2.0 / 3.0, 3.0], abs=1e-10)


@dataclass(frozen=True)
class Grazing:
    """x -> (p^2 - 1 - w^2) x: the multiplier of 0 passes -1 at p = -w and comes back at w."""

    width: float
    dimension: int = 1

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        x, p = states[:, 0], parameters[:, 0]
        slope = p**2 - 1.0 - self.width * abs(self.width)
        return MapImage(
            (slope * x)[:, None],
            slope[:, None, None],
            (2.0 * p * x)[:, None, None],
            np.full(len(x), EPS),
        )


@pytest.mark.parametrize("width", [1e-2, 1e-4, 1e-6])
def test_doublings_narrower_than_a_step_are_found(width: float) -> None:
    """Both edges of a window of instability between two points of the branch."""
    found = specials(Grazing(width), [0.0, 0.2037], [[-1.0, 1.0], [-0.5, 0.5]])
    assert [special.kind for special in found] == ["period doubling"] * 2
    places = np.array([special.point.unknown[0, 1] for special in found])
    assert np.sort(places) == pytest.approx([-width, width], rel=1e-4)
    assert all(abs(abs(p) - width) <= s.parameter_error for p, s in zip(places, found, strict=True))


@dataclass(frozen=True)
class Noisy:
    """x -> (p^2 - 1) x with noise of a given size in the slope: the multiplier of 0 touches -1."""

    noise: float
    dimension: int = 1

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        x, p = states[:, 0], parameters[:, 0]
        slope = p**2 - 1.0 + self.noise * np.sin(1e9 * p)
        return MapImage(
            (slope * x)[:, None],
            slope[:, None, None],
            (2.0 * p * x)[:, None, None],
            np.full(len(x), self.noise),
        )


@pytest.mark.parametrize("noise", [1e-14, 1e-12, 1e-9])
def test_noise_about_a_touch_is_no_doubling(noise: float) -> None:
    """Beyond -1 by no more than its error, the multiplier may not have passed."""
    assert not specials(Noisy(noise), [0.0, 0.2037], [[-1.0, 1.0], [-0.5, 0.5]])


@pytest.mark.parametrize("width", [0.0, -1e-4])
def test_a_multiplier_that_does_not_pass_is_no_doubling(width: float) -> None:
    """It reaches -1, or turns before it."""
    assert not specials(Grazing(width), [0.0, 0.2037], [[-1.0, 1.0], [-0.5, 0.5]])


def test_branches_cross_at_1() -> None:
    """The fixed points 0 and 1 - 1/r meet at r = 1."""
    found = specials(Logistic(), [0.5, 2.0], [[-0.5, 1.0], [0.7, 2.5]])
    assert [special.kind for special in found] == ["branch point"]
    assert found[0].point.unknown[0] == pytest.approx([0.0, 1.0], abs=1e-8)


def test_the_delayed_logistic_map_has_a_torus_at_2() -> None:
    """The multipliers of x = 1 - 1/r are exp(±iπ/3) at r = 2, and leave the unit circle there."""
    found = specials(Delayed(), [1 / 3, 1 / 3, 1.5], [[0.1, 1.0], [0.1, 1.0], [1.2, 2.5]])
    assert [special.kind for special in found] == ["Neimark-Sacker"]
    assert found[0].point.unknown[0, 2] == pytest.approx(2.0, abs=1e-10)


@dataclass(frozen=True)
class AreaPreserving:
    """Henon's map (x, y) -> (y, -x + 2 y (p + y)), whose multipliers have product 1."""

    dimension: int = 2

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        (x, y), p = states.T, parameters[:, 0]
        jacobian = np.tile(np.eye(2), (len(x), 1, 1))
        by_p = np.zeros((len(x), 2, 1))
        for _ in range(iterate):
            step = np.zeros_like(jacobian)
            step[:, 0, 1], step[:, 1, 0], step[:, 1, 1] = 1.0, -1.0, 2.0 * (p + 2.0 * y)
            own = np.zeros_like(by_p)
            own[:, 1, 0] = 2.0 * y
            jacobian, by_p = step @ jacobian, step @ by_p + own
            x, y = y, -x + 2.0 * y * (p + y)
        return MapImage(np.stack([x, y], axis=1), jacobian, by_p, np.full(len(x), 4.0 * EPS))


def test_a_conservative_map_has_no_neimark_sacker_points() -> None:
    """The multipliers of 0 stay on the unit circle: that their product rounds to 1 says nothing."""
    equations = build_orbit_equations(AreaPreserving(), 3)
    curve = traced(equations, [0.0, 0.0, 0.2], [[-2, 2], [-2, 2], [-0.4, 0.4]])
    special = find_special_points(
        equations, curve.points, scale=np.ones(3), tolerance=1e-12, conservative=True
    )
    assert special == []


def logistic_orbits(r: float, period: int) -> FloatArray:
    guesses = np.linspace(0.01, 0.99, 200)[:, None]
    p = np.full((200, 1), r)
    found = newton_fixed_points(
        Logistic(), guesses, p, iterate=period, tolerance=1e-13, box=np.array([[0.0, 1.0]])
    )
    return distinct_orbits_of_least_period(Logistic(), found, np.array([r]), iterate=period).state[
        :, 0
    ]


@pytest.mark.parametrize(("period", "count"), [(1, 2), (2, 1), (3, 2), (4, 3), (5, 6), (6, 9)])
def test_numbers_of_orbits_of_the_full_logistic_map(period: int, count: int) -> None:
    """At r = 4 the orbits of least period q are counted by Moebius inversion of 2^q."""
    assert len(logistic_orbits(4.0, period)) == count


@pytest.mark.parametrize("patience", [1, 3, 5])
def test_a_guess_without_progress_is_given_up(patience: int) -> None:
    """x^2 + p = 0 has the root 0 for p = 0, to which Newton's method halves its steps; none else.

    Where p >= 1 the residual is at least p and begins as 0.09 + p, so that it never falls to 0.7
    of that.
    """
    p = np.array([0.0, 1.0, 2.0, 4.0])
    map_ = WithoutFixedPoint()
    found = newton_fixed_points(
        map_, np.full((4, 1), 0.3), p[:, None], iterate=1, tolerance=1e-12,
        box=np.array([[-50.0, 50.0]]), patience=patience,
    )  # fmt: skip
    np.testing.assert_allclose(found.state, [[0.0]], atol=1e-6)
    # 0.3^2 / 4^k falls below 1e-12 at k = 19.
    assert [map_.applied[value] for value in p] == [20, patience + 1, patience + 1, patience + 1]


def test_orbits_of_the_logistic_map() -> None:
    """r = 3.2: 0, 1 - 1/r, and x = (r + 1 ± √((r + 1)(r - 3)))/(2r) of period 2."""
    np.testing.assert_allclose(logistic_orbits(3.2, 1), [0.0, 1.0 - 1.0 / 3.2], atol=1e-12)
    (x,) = logistic_orbits(3.2, 2)
    roots = [(4.2 + s * np.sqrt(4.2 * 0.2)) / 6.4 for s in (-1, 1)]
    assert min(abs(x - root) for root in roots) < 1e-12


def test_the_error_of_a_fixed_point_covers_its_distance() -> None:
    """x -> A x + b: the residual over the least singular value of 1 - A, however large A is."""
    rng = np.random.default_rng(5)
    matrix = rng.normal(size=(400, 2, 2))
    off = 1e-3 * rng.normal(size=(400, 2))  # from the fixed point 0
    residual = np.abs(((np.eye(2) - matrix) @ off[..., None])[..., 0]).max(axis=1)
    errors = position_errors(PeriodicOrbits(off, matrix, residual, np.zeros(400)))
    # The residual is a largest component, of which the length is at most sqrt 2 times as large.
    assert (np.linalg.norm(off, axis=1) <= 2.0**0.5 * errors * (1.0 + 1e-9)).all()


def test_multipliers_and_their_error() -> None:
    """Eigenvalues of matrices with a known one, and of a defective one."""
    rng = np.random.default_rng(3)
    exact = np.array([[3.0, 0.5], [1.2, -0.4]])
    base = rng.normal(size=(2, 2, 2)) + 2.0 * np.eye(2)
    jacobian = np.stack(
        [b @ np.diag(e) @ np.linalg.inv(b) for b, e in zip(base, exact, strict=True)]
    )
    noise = 1e-9
    values, errors = floquet_multipliers(
        jacobian * (1.0 + noise * rng.uniform(-1, 1, jacobian.shape)), np.full(2, noise)
    )
    assert (np.abs(values - exact) <= errors).all()
    assert errors.max() < 1e-7
    _, errors = floquet_multipliers(np.array([[[1.0, 1.0], [0.0, 1.0]]]), np.array([1e-10]))
    assert errors.max() == pytest.approx(1e-5, rel=0.5)


def test_stability_is_undecided_within_the_error() -> None:
    """Multipliers inside, outside and on the unit circle, the last within their error."""
    values = np.array([[1.2, 0.5], [0.9, 0.5], [1.3, 1.2], [1.0 + 1e-9, 0.5]], dtype=complex)
    kinds = orbit_stability(values, np.full(values.shape, 1e-8), conservative=False)
    assert [Stability(k).meaning for k in kinds] == ["saddle", "stable", "unstable", "undecided"]
    turning = np.exp(1j * np.array([[0.3, -0.3], [1e-9, -1e-9]]))
    values = np.concatenate([turning, np.array([[2.0, 0.5]], dtype=complex)])
    kinds = orbit_stability(values, np.full(values.shape, 1e-8), conservative=True)
    assert [Stability(k).meaning for k in kinds] == ["elliptic", "undecided", "saddle"]


def test_a_curve_that_is_followed_one_way_is_not_closed() -> None:
    """x = p from the origin upwards ends at its bound, and says so."""
    derivative = np.array([[1.0, -1.0]])

    def equations(z: FloatArray) -> EquationValues:
        slopes = np.tile(derivative, (len(z), 1, 1))
        return EquationValues(z @ derivative.T, slopes, np.full(len(z), EPS), {"d": slopes})

    scale = np.ones(2)
    settings = ContinuationSettings(-scale, scale, scale, tolerance=1e-12)
    first = start(equations, np.zeros((1, 2)), scale)
    (curve,) = continue_curves(equations, first, settings, both_ways=False)
    assert (curve.is_closed, curve.end_reasons) == (False, ("start", "bounds"))
