"""From branch to branch: where the other one is known in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from tests.unit.analysis.orbits.test_continuation import Logistic

from remanent._typing import FloatArray
from remanent.analysis.orbits.maps import MapImage
from remanent.analysis.orbits.orbit_equations import build_orbit_equations
from remanent.analysis.orbits.switching import find_point_on_crossing_branch


@dataclass(frozen=True)
class Pitchfork:
    """x -> x + p x - x^3: beside 0 the pair x^2 = p that breaks the symmetry."""

    dimension: int = 1

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        assert iterate == 1
        x, p = states[:, 0], parameters[:, 0]
        return MapImage(
            (x + p * x - x**3)[:, None],
            (1.0 + p - 3.0 * x**2)[:, None, None],
            x[:, None, None],
            np.full(len(x), 1e-16),
        )


def test_the_pair_beside_a_symmetric_orbit_is_found() -> None:
    """x^2 = p beside x = 0."""
    point = find_point_on_crossing_branch(
        build_orbit_equations(Pitchfork(), 1), np.zeros(2), scale=np.ones(2), tolerance=1e-13
    )
    assert point is not None
    x, p = point.unknown[0]
    assert abs(x) > 1e-3
    assert x**2 == pytest.approx(p, rel=1e-9)


@dataclass(frozen=True)
class Turned:
    """The same beside a coordinate that follows the parameter, in turned coordinates."""

    angle: float
    dimension: int = 2

    @property
    def axes(self) -> FloatArray:
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array([[c, -s], [s, c]])

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        (u, w), p, r = (states @ self.axes).T, parameters[:, 0], self.axes
        image = np.stack([u + p * u - u**3, 0.5 * w + 0.3 * p], axis=1)
        slopes = np.zeros((len(u), 2, 2))
        slopes[:, 0, 0], slopes[:, 1, 1] = 1.0 + p - 3.0 * u**2, 0.5
        by_p = np.stack([u, np.full(len(u), 0.3)], axis=1)
        return MapImage(
            image @ r.T, r @ slopes @ r.T, (by_p @ r.T)[:, :, None], np.full(len(u), 1e-16)
        )


@pytest.mark.parametrize("angle", np.linspace(0.0, 3.0, 13))
@pytest.mark.parametrize("stretch", [0.2, 1.0, 5.0])
def test_the_first_branch_is_left_however_it_runs(angle: float, stretch: float) -> None:
    """Its tangent holds the parameter, the other's does not."""
    map_ = Turned(angle)
    point = find_point_on_crossing_branch(
        build_orbit_equations(map_, 1), np.zeros(3), scale=np.array([1.0, 1.0, stretch]),
        tolerance=1e-13,
    )  # fmt: skip
    assert point is not None
    u, w = point.unknown[0, :2] @ map_.axes
    p = point.unknown[0, 2]
    assert abs(u) == pytest.approx(0.01, rel=0.1)
    assert u**2 == pytest.approx(p, rel=1e-6)
    assert w == pytest.approx(0.6 * p, rel=1e-6)


def test_the_doubled_orbit_of_the_logistic_map_is_found() -> None:
    """Of period 2 beyond r = 3: x = (r + 1 ± √((r − 3)(r + 1)))/(2r)."""
    point = find_point_on_crossing_branch(
        build_orbit_equations(Logistic(), 2), np.array([2.0 / 3.0, 3.0]), scale=np.ones(2),
        tolerance=1e-13,
    )  # fmt: skip
    assert point is not None
    x, r = point.unknown[0]
    roots = [(r + 1.0 + s * np.sqrt((r - 3.0) * (r + 1.0))) / (2.0 * r) for s in (-1.0, 1.0)]
    assert min(abs(x - root) for root in roots) < 1e-8
    assert abs(x - (1.0 - 1.0 / r)) > 1e-3  # not the orbit of period 1


def test_where_no_branch_crosses_none_is_found() -> None:
    """At an ordinary point the second vector leads away from every solution."""
    point = find_point_on_crossing_branch(
        build_orbit_equations(Logistic(), 1),
        np.array([0.6, 2.5]),
        scale=np.ones(2),
        tolerance=1e-13,
    )
    assert point is None
