"""Special points and bifurcation curves of maps for which they are known in closed form."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from remanent._typing import FloatArray
from remanent.analysis.orbits.bifurcations import find_special_points
from remanent.analysis.orbits.continuation import ContinuationSettings, continue_curves
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.extended_systems import locate_special_points
from remanent.analysis.orbits.maps import MapImage
from remanent.analysis.orbits.orbit_equations import (
    build_bifurcation_equations,
    build_orbit_equations,
)
from remanent.analysis.orbits.periodic_orbits import fixed_point_newton_step, newton_fixed_points
from tests.unit.analysis.orbits.test_continuation import Logistic, traced

EPS = np.finfo(float).eps


@dataclass(frozen=True)
class RealPair:
    """(x, y) -> (2 x, (1/2 + p) y): real multipliers whose product is 1 at p = 0."""

    dimension: int = 2

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        assert iterate == 1
        p = parameters[:, 0]
        jacobian = np.zeros((len(p), 2, 2))
        jacobian[:, 0, 0], jacobian[:, 1, 1] = 2.0, 0.5 + p
        by_p = np.stack([np.zeros_like(p), states[:, 1]], axis=1)[:, :, None]
        image = np.einsum("kij,kj->ki", jacobian, states)
        return MapImage(image, jacobian, by_p, np.full(len(p), EPS))


def test_real_multipliers_with_product_one_are_no_bifurcation() -> None:
    """The product passes 1 at p = 0, but a torus needs a complex pair."""
    equations = build_orbit_equations(RealPair(), 1)
    curve = traced(equations, [0.0, 0.0, -0.1], [[-1, 1], [-1, 1], [-0.2, 0.2]])
    special = find_special_points(
        equations, curve.points, scale=np.ones(3), tolerance=1e-12, conservative=False
    )
    assert special == []


def test_special_points_come_in_order_along_the_branch() -> None:
    """1 - 1/r meets 0 at r = 1 and doubles at r = 3."""
    equations = build_orbit_equations(Logistic(), 1)
    curve = traced(equations, [0.5, 2.0], [[-0.5, 1.0], [0.7, 3.5]])
    special = find_special_points(
        equations, curve.points, scale=np.ones(2), tolerance=1e-12, conservative=False
    )
    r = [point.point.unknown[0, 1] for point in special]
    upwards = curve.points.unknown[-1, 1] > curve.points.unknown[0, 1]
    assert r == pytest.approx([1.0, 3.0] if upwards else [3.0, 1.0], abs=1e-8)


@dataclass(frozen=True)
class Cusp:
    """x -> x + a + b x - x^3: folds where b = 3 x^2 and a = -2 x^3."""

    dimension: int = 1

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        assert iterate == 1
        x, (a, b) = states[:, 0], parameters.T
        by_p = np.stack([np.ones_like(x), x], axis=1)[:, None, :]
        slope = (1.0 + b - 3.0 * x**2)[:, None, None]
        return MapImage((x + a + b * x - x**3)[:, None], slope, by_p, np.full(len(x), EPS))


@dataclass(frozen=True)
class Quadratic:
    """x -> a + b x - x^2: the multiplier b - 2 x is -1 where x = (1 + b)/2."""

    dimension: int = 1

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        assert iterate == 1
        x, (a, b) = states[:, 0], parameters.T
        by_p = np.stack([np.ones_like(x), x], axis=1)[:, None, :]
        slope = (b - 2.0 * x)[:, None, None]
        return MapImage((a + b * x - x**2)[:, None], slope, by_p, np.full(len(x), EPS))


@dataclass(frozen=True)
class Inexact:
    """A map whose error is said to be larger."""

    exact: Quadratic
    error: float
    dimension: int = 1

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        image = self.exact(states, parameters, iterate)
        return replace(image, error=np.full(len(states), self.error))


def test_errors_of_equations_are_proportional_to_that_of_the_map() -> None:
    """Law: the equations are those of the image and its derivatives, to first order."""
    unknown = np.array([[0.3, 0.2, 5.0], [-1.0, 0.4, 0.1]])
    errors = [
        build_bifurcation_equations(Inexact(Quadratic(), error), 1, "fold", np.ones(3))(
            unknown
        ).extra_arrays["equation_error"]
        for error in (1e-9, 2e-9)
    ]
    np.testing.assert_allclose(errors[1], 2.0 * errors[0], rtol=1e-6)
    assert (errors[0] >= 1e-9).all()


@dataclass(frozen=True)
class Steep:
    """x -> sin(k x) + a + b, whose derivative k cos(k x) is large and varies over 1/k."""

    steepness: float
    dimension: int = 1

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        assert iterate == 1
        k, x = self.steepness, states[:, 0]
        slope = (k * np.cos(k * x))[:, None, None]
        image = (np.sin(k * x) + parameters.sum(axis=1))[:, None]
        return MapImage(image, slope, np.ones((len(x), 1, 2)), np.full(len(x), EPS))


@pytest.mark.parametrize("by_determinant", [False, True])
@pytest.mark.parametrize("steepness", [1.0, 1e2, 1e4, 1e6, 1e8])
def test_a_steep_map_has_the_derivative_of_its_bifurcation_to_many_digits(
    steepness: float, by_determinant: bool
) -> None:
    """d(J - 1)/dx = -k^2 sin(k x) of x -> sin(k x), whatever k is."""
    angle = np.array([0.3, 0.7, 1.1, 2.0])
    unknown = np.column_stack([angle / steepness, np.zeros(4), np.zeros(4)])
    equations = build_bifurcation_equations(
        Steep(steepness), 1, "fold", np.ones(3), by_determinant=by_determinant
    )
    derivative = equations(unknown).extra_arrays["derivative"]
    np.testing.assert_allclose(derivative[:, 1, 0], -(steepness**2) * np.sin(angle), rtol=1e-7)


def bifurcation_curve(map_: Cusp | Quadratic, kind: str, guess: list[float]) -> FloatArray:
    """Points (x, a, b) of a curve of bifurcations within |x|, |a|, |b| < 2."""
    scale = np.ones(3)
    equations = build_bifurcation_equations(map_, 1, kind, scale)
    along = np.array([[0.0, 0.0, 1.0]])
    start, reached = correct_points(
        equations, np.array([guess]), along, scale=scale, tolerance=1e-11
    )
    assert reached.all()
    settings = ContinuationSettings(-2.0 * scale, 2.0 * scale, scale, tolerance=1e-11)
    (curve,) = continue_curves(equations, start, settings)
    assert curve.end_reasons == ("bounds", "bounds")
    return curve.points.unknown


def test_folds_meet_in_a_cusp() -> None:
    """27 a^2 = 4 b^3: the curve of folds passes smoothly through the cusp at a = b = 0."""
    x, a, b = bifurcation_curve(Cusp(), "fold", [0.5, -0.25, 0.75]).T
    np.testing.assert_allclose(b, 3.0 * x**2, atol=1e-8)
    np.testing.assert_allclose(27.0 * a**2, 4.0 * b**3, atol=1e-8)
    assert x.min() < -0.7
    assert x.max() > 0.7


def test_doublings_lie_on_their_parabola() -> None:
    """a = x - b x + x^2 at x = (1 + b)/2."""
    x, a, b = bifurcation_curve(Quadratic(), "period doubling", [0.5, 0.75, 0.0]).T
    np.testing.assert_allclose(x, 0.5 * (1.0 + b), atol=1e-8)
    np.testing.assert_allclose(a, x - b * x + x**2, atol=1e-8)


@dataclass(frozen=True)
class Henon:
    """(x, y) -> (1 - a x^2 + y, x/2): the multiplier -1 has the eigenvector (1, -1/2)."""

    dimension: int = 2

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        assert iterate == 1
        (x, y), a = states.T, parameters[:, 0]
        jacobian = np.zeros((len(x), 2, 2))
        jacobian[:, 0, 0], jacobian[:, 0, 1], jacobian[:, 1, 0] = -2.0 * a * x, 1.0, 0.5
        by_a = np.stack([-(x**2), 0.0 * x], axis=1)[:, :, None]
        image = np.stack([1.0 - a * x**2 + y, 0.5 * x], axis=1)
        return MapImage(image, jacobian, by_a, np.full(len(x), EPS))


def test_the_doubled_orbit_leaves_along_the_eigenvector_of_minus_one() -> None:
    """Henon's map doubles at a = 3 (1 - b)^2/4, x = (1 - b)/(2 a) = 2/(3 (1 - b)), b = 1/2."""
    scale = np.array([1.0, 2.0, 3.0])
    (found,) = locate_special_points(
        build_orbit_equations(Henon(), 1), ["period doubling"], np.array([[1.3, 0.7, 0.2]]),
        np.array([1.0]), scale,
    )  # fmt: skip
    assert found is not None
    assert (np.abs(found.unknown - [4.0 / 3.0, 2.0 / 3.0, 3.0 / 16.0]) <= found.error).all()
    along = found.null_vector * scale  # in the unknowns themselves
    np.testing.assert_allclose(along / along[0], [1.0, -0.5, 0.0], atol=1e-9)
    assert np.linalg.norm(found.null_vector) == pytest.approx(1.0)


@pytest.mark.parametrize("scale", [[1.0, 1.0], [0.1, 10.0], [5.0, 0.3]])
def test_crossings_of_branches_are_found_in_any_units(scale: list[float]) -> None:
    """0 and 1 - 1/r cross at r = 1: from 20 guesses, within the error."""
    rng = np.random.default_rng(0)
    guesses = [0.0, 1.0] + 0.03 * rng.uniform(-1.0, 1.0, (20, 2))
    found = locate_special_points(
        build_orbit_equations(Logistic(), 1), ["branch point"] * 20, guesses, np.ones(20),
        np.array(scale),
    )  # fmt: skip
    for point in found:
        assert point is not None
        assert (np.abs(point.unknown - [0.0, 1.0]) <= point.error + EPS).all()
        assert point.error.max() < 1e-8


@dataclass(frozen=True)
class Blurred(Logistic):
    """The logistic map, whose image is not known well beyond x = 1/2."""

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        image = super().__call__(states, parameters, iterate)
        error = np.where(states[:, 0] > 0.5, 1e-3, EPS)
        return MapImage(image.state, image.jacobian, image.parameter_jacobian, error)


@pytest.mark.parametrize(
    ("map_", "box", "expected"),
    [
        (Logistic(), [-0.1, 1.0], [0.0, 0.6875]),
        (Logistic(), [0.1, 1.0], [0.6875]),
        (Logistic(), [-0.1, 0.6], [0.0]),
        (Blurred(), [-0.1, 1.0], [0.0]),
    ],
)
def test_fixed_points_are_those_in_the_box_that_are_known(
    map_: Logistic, box: list[float], expected: list[float]
) -> None:
    """r = 3.2: 0 and 1 - 1/r = 0.6875, the second only where its error is small."""
    guesses = np.linspace(0.0, 1.1, 17)[:, None]  # one of them is 0.6875 itself
    found = newton_fixed_points(
        map_, guesses, np.full((17, 1), 3.2), iterate=1, tolerance=1e-12, box=np.array([box])
    )
    assert np.unique(np.round(found.state[:, 0], 9)).tolist() == pytest.approx(expected, abs=1e-8)
    assert (found.image_error == EPS).all()
    image = 3.2 * found.state * (1.0 - found.state)
    np.testing.assert_allclose(found.residual, np.abs(image - found.state)[:, 0], atol=EPS)


def test_no_step_is_made_where_the_equations_are_singular() -> None:
    """1 - J singular: NaN for that point, Newton's step x + (f - x)/(1 - f') for the other."""
    move, residual = fixed_point_newton_step(
        np.array([[0.2], [0.2]]), np.array([[0.3], [0.3]]), np.array([[[1.0]], [[0.5]]])
    )
    assert np.isnan(move[0, 0])
    assert move[1, 0] == pytest.approx(0.2)
    assert residual.tolist() == pytest.approx([0.1, 0.1])
