"""On which side of a saddle motion passes: the pendulum, whose stable manifold is known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from remanent._typing import FloatArray
from remanent.analysis.orbits.separatrix import find_first_saddle_passages, unstable_directions

STEP = 0.4
#: Of the pendulum's map over STEP at its upper equilibrium.
JACOBIAN = expm(STEP * np.array([[0.0, 1.0], [1.0, 0.0]]))
TOP = np.array([np.pi, 0.0])


def swings(speed: FloatArray, iterates: int = 60) -> FloatArray:
    """Pendulums set off from below, array (pendulum, iterate, state)."""

    def one(v: float) -> FloatArray:
        times = STEP * np.arange(iterates)
        return np.asarray(
            solve_ivp(
                lambda _, y: [y[1], -np.sin(y[0])], (0.0, times[-1]), [0.0, v],
                t_eval=times, rtol=1e-11, atol=1e-12,
            ).y.T
        )  # fmt: skip

    return np.stack([one(float(v)) for v in speed])


def passed(speed: FloatArray, error: float = 1e-9) -> list[int]:
    n = speed.size
    found = find_first_saddle_passages(
        swings(speed), np.tile(TOP, (n, 1)), np.tile(JACOBIAN, (n, 1, 1)), np.full(n, error)
    )
    return [int(side) for side in found.side_relative_to_start]


def test_the_side_is_that_of_the_stable_manifold() -> None:
    """A pendulum set off at v < 2 returns from the top, at v > 2 it goes over."""
    assert passed(np.array([1.9, 1.99, 2.0 - 1e-6, 2.0 + 1e-6, 2.01, 2.1])) == [1, 1, 1, -1, -1, -1]


def test_what_an_error_could_turn_is_not_decided() -> None:
    """v = 1.99 and 2.01 part by 0.01 at the top: an error of 0.1 could turn the sign."""
    assert passed(np.array([1.99, 2.01]), error=0.1) == [0, 0]


def test_what_does_not_come_near_is_not_decided() -> None:
    """At v = 0.5 the pendulum swings by 29 degrees only."""
    assert passed(np.array([0.5])) == [0]


@pytest.mark.parametrize(("least", "side"), [(0.59, 1), (0.61, 0)])
def test_near_is_within_six_tenths_of_the_first_distance(least: float, side: int) -> None:
    """Motion along the unstable direction of diag(2, 1/2), that turns back at a distance."""
    path = np.array([[1.0, 0.0], [least, 0.0], [0.9, 0.0]])
    found = find_first_saddle_passages(
        path[None], np.zeros((1, 2)), np.diag([2.0, 0.5])[None], np.array([1e-9])
    )
    assert found.side_relative_to_start.tolist() == [side]


def test_the_least_distance_is_that_of_the_whole_passage() -> None:
    """In along the stable direction and out along the unstable one of diag(2, 1/2)."""
    path = np.array([[0.01, 1.0], [0.02, 0.5], [0.04, 0.25], [0.08, 0.125], [0.16, 0.0625]])
    found = find_first_saddle_passages(
        path[None], np.zeros((1, 2)), np.diag([2.0, 0.5])[None], np.array([1e-9])
    )
    assert found.departure_iterate.tolist() == [4]
    assert found.least_distance_before_departure[0] == pytest.approx(np.hypot(0.08, 0.125))


def test_what_stays_is_not_decided() -> None:
    """Exactly on the manifold the run ends at the top."""
    at = np.stack(
        [
            4.0 * np.arctan(np.exp(STEP * np.arange(40))) - np.pi,
            2.0 / np.cosh(STEP * np.arange(40)),
        ],
        axis=1,
    )
    found = find_first_saddle_passages(at[None], TOP[None], JACOBIAN[None], np.array([1e-9]))
    assert found.side_relative_to_start.tolist() == [0]


@pytest.mark.parametrize(
    ("matrix", "expected"),
    [
        (np.diag([2.0, 0.5]), True),
        (np.diag([2.0, 3.0]), False),
        (np.diag([0.2, 0.5]), False),
        (np.array([[0.0, -1.0], [1.0, 0.0]]), False),
    ],
)
def test_saddles_have_one_real_multiplier_outside(matrix: FloatArray, expected: bool) -> None:
    """A saddle, a source, a sink, a centre; direction and form are dual eigenvectors."""
    direction, form, saddle = unstable_directions(matrix[None])
    assert saddle.tolist() == [expected]
    if expected:
        np.testing.assert_allclose(matrix @ direction[0], 2.0 * direction[0])
        assert form[0] @ direction[0] == pytest.approx(1.0)
