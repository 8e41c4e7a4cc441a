"""Errors of periodic orbits on maps whose orbits are known in closed form."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest

from remanent._typing import FloatArray
from remanent.analysis.orbits.curve_errors import errors_at_fixed_unknown
from remanent.analysis.orbits.curves import CurvePoints
from remanent.analysis.orbits.errors import OrbitErrors, orbit_errors
from remanent.analysis.orbits.maps import MapImage
from remanent.analysis.orbits.period_chain import PeriodChain
from remanent.analysis.orbits.periodic_orbits import PeriodicOrbits, distinct_fixed_points
from remanent.analysis.orbits.refinement import refine_orbits
from remanent.analysis.orbits.stability import Stability, floquet_multipliers, orbit_stability

EPS = float(np.finfo(float).eps)
#: Random cases of each law.
COUNT = 400


@dataclass(frozen=True)
class ClosedFormMap:
    """A map x -> image(x, p) whose images are wrong by `error`, of which it knows the size."""

    dimension: int
    image: Callable[[FloatArray, FloatArray], FloatArray]
    jacobian: Callable[[FloatArray, FloatArray], FloatArray]
    error: float = 0.0

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        x, product = states, np.tile(np.eye(self.dimension), (len(states), 1, 1))
        for _ in range(iterate):
            product = self.jacobian(x, parameters) @ product
            x = self.image(x, parameters) + self.error
        size = np.full(len(states), self.error)
        slope = np.zeros((len(states), self.dimension, 0))
        vector = np.full(states.shape, self.error)
        return MapImage(x, product, slope, size, vector, np.zeros_like(product))


def linear_map(error: float = 0.0) -> ClosedFormMap:
    """x -> A x + b; the parameters are the entries of A, then b."""

    def matrices(p: FloatArray) -> FloatArray:
        return p[:, :4].reshape(-1, 2, 2)

    def image(x: FloatArray, p: FloatArray) -> FloatArray:
        return (matrices(p) @ x[..., None])[..., 0] + p[:, 4:]

    return ClosedFormMap(2, image, lambda _, p: matrices(p), error)


#: x -> x + p - x^2, fixed at the roots of p: they meet in a fold at p = 0.
FOLD = ClosedFormMap(1, lambda x, p: x + p - x**2, lambda x, _: (1.0 - 2.0 * x)[..., None])


def twist(x: FloatArray, p: FloatArray) -> FloatArray:
    """Turn each point about the origin by 2 pi (p + r^2): a torus for each radius."""
    angle = 2.0 * np.pi * (p[:, 0] + (x**2).sum(axis=1))
    cos, sin = np.cos(angle), np.sin(angle)
    return np.column_stack([cos * x[:, 0] - sin * x[:, 1], sin * x[:, 0] + cos * x[:, 1]])


def twist_jacobian(x: FloatArray, p: FloatArray) -> FloatArray:
    """The derivatives of :func:`twist`, in closed form."""
    angle = 2.0 * np.pi * (p[:, 0] + (x**2).sum(axis=1))
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.stack([cos, -sin, sin, cos], axis=1).reshape(-1, 2, 2)
    across = np.stack([-sin, -cos, cos, -sin], axis=1).reshape(-1, 2, 2)
    along = (across @ x[..., None]) * (4.0 * np.pi * x)[:, None, :]
    return np.asarray(turn + along)


def test_the_error_of_an_orbit_of_a_linear_map_is_its_distance() -> None:
    """Law: Coverage.  x -> A x + b: the point is (1 - A)^-1 b - x away, and so is the bound."""
    rng = np.random.default_rng(1)
    parameters = rng.normal(size=(COUNT, 6))
    matrix = np.eye(2) - parameters[:, :4].reshape(-1, 2, 2)
    exact = np.linalg.solve(matrix, parameters[:, 4:, None])[..., 0]
    off = 10.0 ** rng.uniform(-12.0, -2.0, (COUNT, 1)) * rng.normal(size=(COUNT, 2))
    found = orbit_errors(linear_map(), exact + off, parameters, 1)
    true = np.abs(found.state - exact)
    condition = np.linalg.cond(matrix)
    noise = 100.0 * EPS * condition * (np.abs(exact).max(axis=1) + 1.0)
    assert found.is_confirmed.all()
    assert (true <= found.state_error + 1e-3 * noise[:, None]).all()
    assert (found.state_error <= 1.001 * true + 100.0 * noise[:, None]).all()


def test_the_error_of_the_map_goes_through_one_minus_the_jacobian() -> None:
    """x -> A x + b, images wrong by d: the fixed point is (1 - A)^-1 d from the true one."""
    rng = np.random.default_rng(2)
    parameters = rng.normal(size=(COUNT, 6))
    matrix = np.eye(2) - parameters[:, :4].reshape(-1, 2, 2)
    error = 1e-7
    exact = np.linalg.solve(matrix, parameters[:, 4:, None])[..., 0]
    wrong: FloatArray = np.asarray(np.linalg.solve(matrix, parameters[:, 4:, None] + error)[..., 0])
    found = orbit_errors(linear_map(error), wrong, parameters, 1)
    np.testing.assert_allclose(found.state_error, np.abs(wrong - exact), rtol=1e-3)


def test_near_a_fold_an_error_covers_or_there_is_none() -> None:
    """Law: Coverage.  x -> x + p - x²: fixed at ±√p, and nowhere where p < 0."""
    rng = np.random.default_rng(3)
    root = 10.0 ** rng.uniform(-7.0, 0.0, (COUNT, 1))
    guess = root * (1.0 + rng.uniform(-1.5, 1.5, (COUNT, 1)))
    found = orbit_errors(FOLD, guess, root**2, 1)
    true = np.minimum(np.abs(found.state - root), np.abs(found.state + root))[:, 0]
    told = found.is_confirmed
    assert (true[told] <= found.error[told] * (1.0 + 1e-9)).all()
    assert np.isnan(found.error[~told]).all()
    # The derivative 1 - 2 x of the map is as far from that of the orbit as 2 (x - root).
    assert (2.0 * true[told] <= found.jacobian_error[told, 0, 0] * (1.0 + 1e-9)).all()
    # At x = (1 + u)√p a contraction of 1/2 is allowed where |u (2 + u)| <= 3/4 (1 + u)^2.
    u = (guess / root - 1.0)[:, 0]
    share = np.abs(u * (2.0 + u)) / (0.75 * (1.0 + u) ** 2)
    clear = (share < 0.95) | (share > 1.05)
    assert (told == (share < 1.0))[clear].all()
    nothing = orbit_errors(FOLD, guess, -(root**2), 1)
    assert not nothing.is_confirmed.any()


def test_near_a_fold_the_error_of_the_map_counts_as_the_residual_does() -> None:
    """Law: Coverage.  Images too large by d: x² = p + d there, and x² = p in truth, if p > 0."""
    error, share = 1e-4, np.concatenate([np.linspace(0.05, 0.95, 19), np.linspace(1.05, 3.0, 19)])
    root = np.sqrt(error / share)[:, None]
    parameters = root**2 - error
    found = orbit_errors(replace(FOLD, error=error), root, parameters, 1)
    true = root - np.sqrt(np.maximum(parameters, 0.0))
    told = found.is_confirmed
    assert told[share < 0.5].all()
    assert not told[share > 1.0].any()
    assert (true[told] <= found.state_error[told] * (1.0 + 1e-9)).all()


@pytest.mark.parametrize("period", [1, 3, 7])
def test_points_of_a_torus_that_closes_are_no_orbits(period: int) -> None:
    """A twist map turns the radius where r² = k/n by whole turns: every point there closes."""
    rng = np.random.default_rng(period)
    angle = rng.uniform(0.0, 2.0 * np.pi, 50)
    radius = np.sqrt(1.0 + 1.0 / period + 10.0 ** rng.uniform(-16.0, -10.0, 50))
    points = radius[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
    map_ = ClosedFormMap(2, twist, twist_jacobian)
    found = orbit_errors(map_, points, np.zeros((50, 1)), period)
    assert found.residual.max() < 1e-8
    assert not found.is_confirmed.any()


def test_refinement_takes_the_coarsest_map_that_is_enough() -> None:
    """Maps wrong by 1e-6, 1e-7 ...: the error is below the tolerance, and no map far below it."""
    parameters = np.array([[0.5, 0.0, 0.0, -0.5, 1.0, 1.0]])
    exact = np.array([[2.0, 2.0 / 3.0]])
    used: list[int] = []

    def map_of_level(level: int) -> ClosedFormMap:
        used.append(level)
        return linear_map(1e-6 * 10.0**-level)

    for tolerance, last in ((1e-3, 0), (1e-6, 1), (1e-9, 4)):
        used.clear()
        found = refine_orbits(map_of_level, 8, exact + 1e-4, parameters, 1, tolerance)
        assert np.abs(found.state - exact).max() <= found.error[0] <= tolerance
        assert max(used) == last
    found = refine_orbits(map_of_level, 2, exact + 1e-4, parameters, 1, 1e-12)
    assert found.error[0] > 1e-12  # and says so
    none: OrbitErrors = refine_orbits(map_of_level, 2, exact[:0], parameters[:0], 1, 1e-9)
    assert none.error.shape == (0,)


def test_refinement_goes_on_until_the_error_is_that_of_rounding() -> None:
    """x -> x + p - x², fixed at √p: Newton's steps from a few thousandths away are several."""
    p = np.linspace(0.5, 2.0, 20)[:, None]
    found = refine_orbits(lambda _: FOLD, 0, np.sqrt(p) + 5e-3, p, 1, 1e-14)
    assert (np.abs(found.state - np.sqrt(p)) <= found.state_error).all()
    assert found.error.max() < 1e-14


def test_refinement_does_not_go_to_an_orbit_far_away() -> None:
    """x -> x + p - x², fixed at √p: a point 0.05 from it stays where it is, one 0.005 does not."""
    p = np.linspace(0.5, 2.0, 20)[:, None]
    for off, moves in ((0.05, False), (5e-3, True)):
        start = np.sqrt(p) + off
        found = refine_orbits(lambda _: FOLD, 0, start, p, 1, 1e-14)
        assert ((found.state != start) == moves).all()


@dataclass(frozen=True)
class OneMatrix:
    """A linear map of whose matrix the errors are given."""

    matrix: FloatArray
    matrix_error: FloatArray
    dimension: int = 2

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        assert iterate == 1
        count = len(states)
        jacobian, error = (np.tile(m, (count, 1, 1)) for m in (self.matrix, self.matrix_error))
        zero = np.zeros(states.shape)
        image = states @ self.matrix.T
        return MapImage(image, jacobian, np.zeros((count, 2, 0)), zero[:, 0], zero, error)

    def chain(self, periods: int) -> PeriodChain:
        return PeriodChain.along(self, np.ones((1, 2)), np.zeros((1, 0)), periods)


@pytest.mark.parametrize("periods", [1, 3])
def test_rounding_of_jacobians_goes_with_their_size(periods: int) -> None:
    """A matrix c A without any other error: that of its power goes with the power of c."""
    matrix = np.array([[0.5, 1.0], [-2.0, 0.3]])
    found = OneMatrix(matrix, np.zeros((2, 2))).chain(periods).jacobian_error
    larger = OneMatrix(2.0**20 * matrix, np.zeros((2, 2))).chain(periods).jacobian_error
    assert (found >= EPS * np.abs(np.linalg.matrix_power(matrix, periods))).all()
    np.testing.assert_allclose(larger, 2.0 ** (20 * periods) * found, rtol=1e-12)


def test_entries_without_an_error_have_a_share_of_those_by_the_same_variable() -> None:
    """Derivatives by x are known to 1e-6, those by y to 1e-9, as far as one of each pair tells."""
    error = OneMatrix(np.eye(2), np.diag([1e-6, 1e-9])).chain(1).jacobian_error[0]
    np.testing.assert_allclose(np.diag(error), [1e-6, 1e-9], rtol=1e-5)
    assert 1e-8 < error[1, 0] < 1e-6
    assert 1e-11 < error[0, 1] < 1e-9


@pytest.mark.parametrize("slope", [0.0, 0.1, 1.0, -30.0])
def test_of_a_straight_curve_the_error_at_a_fixed_parameter_is_that_of_the_equation(
    slope: float,
) -> None:
    """x - s p = 0, known to d: at fixed p, x is known to d, whatever the slope s is."""
    p, error = np.linspace(0.0, 1e-3, 5), 1e-4
    points = CurvePoints(
        np.stack([slope * p, p], axis=1),
        np.tile([slope, 1.0], (5, 1)) / np.hypot(slope, 1.0),
        np.zeros(5), np.full(5, error),
        {"derivative": np.tile([[1.0, -slope]], (5, 1, 1)), "value": np.zeros((5, 1))},
    )  # fmt: skip
    found = errors_at_fixed_unknown(points, np.full((5, 1), error), np.ones(2), 1)
    np.testing.assert_allclose(found[:, 0], error, rtol=1e-9)


def test_errors_at_a_fixed_parameter_do_not_depend_on_units() -> None:
    """x² = p in units of x and p that are powers of two: errors are the same numbers of units."""
    x = np.linspace(0.1, 0.3, 6)
    tangent = np.stack([np.ones(6), 2.0 * x], axis=1)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    derivative = np.stack([2.0 * x, -np.ones(6)], axis=1)[:, None, :]
    found = []
    for scale in (np.ones(2), np.array([2.0**6, 2.0**-3])):
        extra = {"derivative": derivative / scale, "value": np.zeros((6, 1))}
        points = CurvePoints(
            np.stack([x, x**2], axis=1) * scale, tangent, np.zeros(6), np.full(6, 1e-3), extra
        )
        found.append(errors_at_fixed_unknown(points, np.full((6, 1), 1e-3), scale, 1) / scale)
    np.testing.assert_allclose(found[1], found[0], rtol=1e-13)


@pytest.mark.parametrize("dimension", [2, 3, 4])
@pytest.mark.parametrize("gap", [0.0, 1e-10, 1e-6, 1e-3, 1.0])
def test_no_eigenvalue_moves_further_than_its_error(dimension: int, gap: float) -> None:
    """Law: Coverage.  Matrices with two eigenvalues a gap apart, each entry changed at random."""
    rng = np.random.default_rng(round(1e3 * gap) + dimension)
    block = np.triu(rng.normal(size=(COUNT, dimension, dimension)), 1)
    values = rng.normal(size=(COUNT, dimension))
    values[:, 1] = values[:, 0] + gap
    block[:, np.arange(dimension), np.arange(dimension)] = values
    turned, _ = np.linalg.qr(rng.normal(size=block.shape))
    matrix = turned @ block @ turned.swapaxes(1, 2)
    bound = 10.0 ** rng.uniform(-14.0, -4.0, (COUNT, 1, 1)) * rng.uniform(0.0, 1.0, block.shape)
    changed = matrix + bound * rng.choice([-1.0, 1.0], block.shape)
    found, errors = floquet_multipliers(matrix, bound)
    others, _ = floquet_multipliers(changed, np.zeros(COUNT))
    distance = np.abs(found[:, :, None] - others[:, None, :]).min(axis=2)
    # what the eigenvalues of the changed matrix are themselves known to
    _, rounding = floquet_multipliers(changed, np.full(COUNT, 4.0 * EPS))
    assert (distance <= errors + rounding).all()


@pytest.mark.parametrize("dimension", [2, 3, 4])
def test_rounding_alone_moves_eigenvalues_by_less_than_their_error(dimension: int) -> None:
    """Law: Coverage.  Whole numbers as eigenvalues, in bases of whole numbers: exact matrices."""
    rng = np.random.default_rng(dimension)
    shape = (COUNT, dimension, dimension)
    lower, upper = (np.tril(rng.integers(-3, 4, shape), -1) + np.eye(dimension) for _ in range(2))
    base = lower @ upper.swapaxes(1, 2)
    exact = rng.permuted(np.tile(np.arange(1.0, 9.0), (COUNT, 1)), axis=1)[:, :dimension]
    inverse = np.rint(np.linalg.inv(base))  # of whole numbers, since the determinant is 1
    found, errors = floquet_multipliers((base * exact[:, None, :]) @ inverse, np.zeros(COUNT))
    assert (np.abs(found - -np.sort(-exact, axis=1)) <= errors).all()


def test_errors_of_eigenvalues_are_not_needlessly_large() -> None:
    """Of a symmetric matrix no eigenvalue moves further than the norm of the change."""
    rng = np.random.default_rng(4)
    matrix = rng.normal(size=(COUNT, 2, 2))
    matrix = matrix + matrix.swapaxes(1, 2)
    _, errors = floquet_multipliers(matrix, np.full(matrix.shape, 1e-8))
    assert (errors <= 4.0 * 2e-8).all()


def test_multipliers_off_the_unit_circle_are_not_elliptic() -> None:
    """Complex ones of a map that preserves area are on it: more than 1e-6 off, they are wrong."""
    for off, kind in ((0.9e-6, Stability.ELLIPTIC), (1.1e-6, Stability.UNDECIDED)):
        values: Any = (1.0 + off) * np.exp([[0.3j, -0.3j]])
        errors = np.full((1, 2), 1e-9)
        assert orbit_stability(values, errors, conservative=True)[0] == kind


@pytest.mark.parametrize("count", [2, 3, 20])
def test_near_a_fold_errors_at_a_fixed_parameter_cover(count: int) -> None:
    """Law: Coverage.  x² = p, known to d: at fixed p, x may be √(p - d) as well."""
    for share in (0.05, 0.3, 0.6, 0.9):
        x = 1e-3 * np.linspace(1.0, 1.05, count)
        error = share * x[0] ** 2
        derivative = np.stack([2.0 * x, -np.ones(count)], axis=1)[:, None, :]
        tangent = np.stack([np.ones(count), 2.0 * x], axis=1)
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        extra = {"derivative": derivative, "value": np.zeros((count, 1))}
        points = CurvePoints(
            np.stack([x, x**2], axis=1), tangent, np.zeros(count), np.full(count, error), extra
        )
        found = errors_at_fixed_unknown(points, np.full((count, 1), error), np.ones(2), 1)
        # The curve is taken for a parabola about its tangent: true up to some x², relative.
        assert (x - np.sqrt(x**2 - error) <= found[:, 0] * (1.0 + 20.0 * x**2)).all()
        assert not found[:, 1].any()


def test_stability_follows_the_errors() -> None:
    """Undecided as soon as the error reaches the unit circle, and not before."""
    for conservative, values, kind in (
        (False, [0.9, 0.5], Stability.STABLE),
        (False, [1.1, 0.5], Stability.SADDLE),
        (False, [1.3, 1.1], Stability.UNSTABLE),
        (True, [1.1, 1.0 / 1.1], Stability.SADDLE),
        (True, np.exp([0.1j, -0.1j]), Stability.ELLIPTIC),
    ):
        multipliers: Any = np.array([values], dtype=complex)
        for error, expected in ((0.089, kind), (0.101, Stability.UNDECIDED)):
            errors = np.full((1, 2), error)
            assert orbit_stability(multipliers, errors, conservative=conservative)[0] == expected
        unknown = np.full((1, 2), np.nan)
        assert orbit_stability(multipliers, unknown, conservative=conservative)[0] == 0


#: x, y -> 1 - p x^2 + y, 0.3 x, by Henon.
HENON = ClosedFormMap(
    2,
    lambda x, p: np.stack([1.0 - p[:, 0] * x[:, 0] ** 2 + x[:, 1], 0.3 * x[:, 0]], axis=1),
    lambda x, p: np.stack(
        [np.stack([-2.0 * p[:, 0] * x[:, 0], np.ones(len(x))], axis=1),
         np.tile([0.3, 0.0], (len(x), 1))], axis=1,
    ),
)  # fmt: skip


def test_what_happens_to_an_error_later_is_the_product_of_the_jacobians_after_it() -> None:
    """J3 J2, J3 and 1 for errors of the first, the second and the third period."""
    start, p = np.array([[0.3, 0.1], [-0.5, 0.2]]), np.array([[1.4], [1.1]])
    matrices: list[FloatArray] = []
    x = start
    for _ in range(3):
        matrices.append(HENON.jacobian(x, p))
        x = HENON.image(x, p)
    chain = PeriodChain.along(HENON, start, p, 3)
    one = np.tile(np.eye(2), (2, 1, 1))
    after = np.stack([matrices[2] @ matrices[1], matrices[2], one], axis=1)
    np.testing.assert_allclose(chain.later, after, rtol=1e-13)
    np.testing.assert_allclose(chain.jacobian, after[:, 0] @ matrices[0], rtol=1e-13)


def test_two_points_in_one_place_are_one_unless_they_have_another_index() -> None:
    """A node and a saddle that are about to meet are two; a node found twice is one."""
    node, saddle = np.diag([0.5, 0.5]), np.diag([2.0, 0.5])
    for jacobians in ([node, saddle, node], [saddle, node, node], [node, node, saddle]):
        orbits = PeriodicOrbits(np.ones((3, 2)), np.stack(jacobians), np.zeros(3), np.zeros(3))
        kept = distinct_fixed_points(orbits, np.array([1e-9, 2e-9, 3e-9]))
        assert sorted(orbits.index[kept]) == [-1, 1]


@pytest.mark.parametrize("order", [2, 3, 4])
def test_eigenvalues_that_meet_move_no_farther_than_their_bound(order: int) -> None:
    """Of a Jordan block, by the root of the change, and in proportion to the size of the matrix."""
    change = 1e-6
    block = 0.5 * np.eye(order) + np.eye(order, k=1)
    moved = np.linalg.eigvals(block + change * np.eye(order, k=1 - order))
    _, error = floquet_multipliers(block[None], np.full((1, order, order), change))
    distance = np.abs(moved - 0.5).max()
    assert distance == pytest.approx(change ** (1.0 / order), rel=1e-3)
    assert distance <= error.min()
    _, larger = floquet_multipliers(100.0 * block[None], np.full((1, order, order), 100.0 * change))
    np.testing.assert_allclose(larger, 100.0 * error, rtol=1e-6)
