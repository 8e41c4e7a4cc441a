"""From branch to branch: where the other one is known in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from remanent._typing import FloatArray
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.extended_systems import locate_special_points
from remanent.analysis.orbits.maps import Map, MapImage
from remanent.analysis.orbits.orbit_equations import build_orbit_equations
from tests.unit.analysis.orbits.test_continuation import Logistic

#: Length of the step from the crossing onto the other branch, in scaled unknowns.
STEP = 0.01


def beside(
    map_: Map, kind: str, crossing: FloatArray, period: int, scale: FloatArray
) -> FloatArray | None:
    """A point of the branch that crosses at a special point, along its null vector."""
    (located,) = locate_special_points(
        build_orbit_equations(map_, 1), [kind], crossing[None], np.array([0.05]), scale
    )
    if located is None:
        return None
    direction = located.null_vector[None]
    points, reached = correct_points(
        build_orbit_equations(map_, period), located.unknown + STEP * direction * scale, direction,
        scale=scale, tolerance=1e-13,
    )  # fmt: skip
    assert reached.all()
    return np.asarray(points.unknown[0])


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
    point = beside(Pitchfork(), "branch point", np.zeros(2), 1, np.ones(2))
    assert point is not None
    x, p = point
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
    point = beside(map_, "branch point", np.zeros(3), 1, np.array([1.0, 1.0, stretch]))
    assert point is not None
    u, w = point[:2] @ map_.axes
    p = point[2]
    assert abs(u) == pytest.approx(STEP, rel=0.1)
    assert u**2 == pytest.approx(p, rel=1e-6)
    assert w == pytest.approx(0.6 * p, rel=1e-6)


def test_the_doubled_orbit_of_the_logistic_map_is_found() -> None:
    """Of period 2 beyond r = 3: x = (r + 1 ± √((r − 3)(r + 1)))/(2r)."""
    point = beside(Logistic(), "period doubling", np.array([0.66, 3.01]), 2, np.ones(2))
    assert point is not None
    x, r = point
    roots = [(r + 1.0 + s * np.sqrt((r - 3.0) * (r + 1.0))) / (2.0 * r) for s in (-1.0, 1.0)]
    assert min(abs(x - root) for root in roots) < 1e-8
    assert abs(x - (1.0 - 1.0 / r)) > 1e-3  # not the orbit of period 1


def test_where_no_branch_crosses_none_is_found() -> None:
    """No special point is near an ordinary one."""
    assert beside(Logistic(), "branch point", np.array([0.6, 2.5]), 1, np.ones(2)) is None
