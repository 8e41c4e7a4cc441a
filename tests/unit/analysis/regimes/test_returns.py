"""Returns, limits and attractors of orbits that are known."""

from __future__ import annotations

import numpy as np
import pytest

from remanent._typing import FloatArray, IntArray
from remanent.analysis.orbits.stability import floquet_multipliers
from remanent.analysis.regimes.attractors import assign_attractors, replace_tails_by_limit_orbits
from remanent.analysis.regimes.labels import Regime
from remanent.analysis.regimes.limit_orbits import (
    approaches_at_multiplier_rate,
    find_approached_orbit_periods,
    find_limit_orbits,
)
from remanent.analysis.regimes.long_runs import propagate_tangents
from remanent.analysis.regimes.orbit_exponents import find_settled_orbit_periods, orbit_exponents
from remanent.analysis.regimes.returns import find_best_returns
from tests.unit.analysis.regimes.iterated import Iterated, logistic

GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


def test_period_of_the_best_return() -> None:
    """cos(2πn/7) comes back after 7 exactly, a golden rotation never."""
    n = np.arange(300)
    points = np.stack([np.cos(2 * np.pi * n / 7), np.cos(2 * np.pi * n * GOLDEN)])[:, :, None]
    found = find_best_returns(points, closed=1e-9)
    assert found.period[0] == 7
    assert found.return_defect[0] < 1e-12
    assert found.return_defect[1] > 1e-3


def test_each_settled_motion_has_the_period_of_its_own_orbit() -> None:
    """The logistic map at 2.8, 3.2, 3.5 and 3.835, and chaos at 4, all together."""
    maps = Iterated(logistic, np.array([[2.8], [3.2], [3.5], [3.835], [4.0]]))
    path = propagate_tangents(maps, np.full((5, 1), 0.3), 1200, directions=1, every=True)
    assert path.visited_states is not None
    period = find_settled_orbit_periods(
        path.visited_states[:, -300:], np.arange(5), maps.iterate, np.ones(5, dtype=np.bool_)
    )
    assert period.tolist() == [1, 2, 4, 3, 0]


@pytest.mark.parametrize("known", [True, False])
def test_a_multiplier_that_is_all_rounding_has_no_exponent_with_an_error(known: bool) -> None:
    """diag(1/2, tiny): rounding of the largest entry is a twelfth of it, or an eighth."""
    _, rounding = floquet_multipliers(np.diag([0.5, 1e-15])[None], np.zeros(1))
    tiny = rounding[0, 1] * (12.0 if known else 8.0)
    jacobian = np.diag([0.5, tiny])

    def iterate(_: IntArray, states: FloatArray, periods: int) -> tuple[FloatArray, FloatArray]:
        power = np.linalg.matrix_power(jacobian, periods)
        return states @ power.T, np.tile(power, (len(states), 1, 1))

    found = orbit_exponents(
        iterate, lambda *_: (iterate, iterate), np.array([0]), np.zeros((1, 2)), np.array([1]), 1.0
    )
    np.testing.assert_allclose(found.exponents[0], np.log([0.5, tiny]))
    assert np.isfinite(found.exponents_error[0]).tolist() == [True, known]


def test_the_limit_ahead_is_the_fixed_point() -> None:
    """1 - 1/r, multiplier 2 - r."""
    points = Iterated(logistic, np.array([[2.8]]))
    found = find_limit_orbits(points.iterate, np.array([0]), np.array([[0.6]]), 1)
    assert found.state[0, 0] == pytest.approx(1 - 1 / 2.8, abs=1e-14)
    assert found.largest_multiplier_modulus[0] == pytest.approx(0.8, abs=1e-12)


def test_a_limit_that_is_reached_is_not_computed_again() -> None:
    """Two fixed points, one from nearby, one from afar; the second needs more steps."""
    points = Iterated(logistic, np.array([[2.8], [2.8]]))
    asked: list[int] = []

    def iterate(orbits: IntArray, states: FloatArray, period: int) -> tuple[FloatArray, FloatArray]:
        asked.extend(orbits.tolist())
        return points.iterate(orbits, states, period)

    found = find_limit_orbits(iterate, np.arange(2), np.array([[1 - 1 / 2.8 + 1e-7], [0.9]]), 1)
    np.testing.assert_allclose(found.state[:, 0], 1 - 1 / 2.8, atol=1e-14)
    assert found.has_converged.all()
    assert asked.count(0) == 2
    assert 2 < asked.count(1) <= 6


def test_the_limit_is_not_looked_for_far_from_the_motion() -> None:
    """x^2 - 2: Newton's method would go from 0.9 to the fixed point at 2, and does from 1.9."""

    def iterate(_: IntArray, states: FloatArray, __: int) -> tuple[FloatArray, FloatArray]:
        return states**2 - 2.0, 2.0 * states[:, :, None]

    states = np.array([[0.9], [1.9]])
    anywhere = find_limit_orbits(iterate, np.arange(2), states, 1)
    np.testing.assert_allclose(anywhere.state[:, 0], 2.0)
    near = find_limit_orbits(iterate, np.arange(2), states, 1, extent=np.array([0.3, 0.3]))
    assert near.has_converged.tolist() == [False, True]
    assert np.isnan(near.state[0, 0])
    assert near.largest_multiplier_modulus[1] == pytest.approx(4.0)


@pytest.mark.parametrize("unit", [1e-3, 1.0, 1e3])
def test_how_far_the_limit_is_looked_for_goes_with_the_extent_of_the_motion(unit: float) -> None:
    """x/2, in whatever unit: 0 is 1.5 extents from one state, 5 from the other."""

    def iterate(_: IntArray, states: FloatArray, __: int) -> tuple[FloatArray, FloatArray]:
        return 0.5 * states, np.full((len(states), 1, 1), 0.5)

    states = unit * np.array([[1.5], [5.0]])
    found = find_limit_orbits(iterate, np.arange(2), states, 1, extent=np.full(2, unit))
    assert found.has_converged.tolist() == [True, False]


def test_attractors_are_sorted_by_their_visitors() -> None:
    """Two orbits of period 2, seen at different phases, and a third motion that is lost."""
    a, b = np.tile([0.0, 1.0], 8), np.tile([5.0, 6.0], 8)
    tails = np.stack([b, a, np.roll(a, 1), a, np.full(16, np.nan)])[:, :, None]
    regime = np.array([1, 1, 1, 1, 4])
    found = assign_attractors(tails, regime, np.array([2, 2, 2, 2, 0]))
    assert found.attractor_number.tolist() == [1, 0, 0, 0, -1]
    assert found.representative_orbit.tolist() == [1, 0]


def decaying(multiplier: float, count: int = 41) -> FloatArray:
    """x <- a x from 1, array (1, iterate, 1)."""
    return np.asarray(multiplier ** np.arange(count), dtype=np.float64)[None, :, None]


@pytest.mark.parametrize(("multiplier", "approaches"), [(0.9, True), (0.8, False), (0.95, False)])
def test_the_limit_is_approached_at_the_rate_of_its_multiplier(
    multiplier: float, approaches: bool
) -> None:
    """x <- 0.9 x tends to 0 at the rate ln 0.9, and at no other."""
    rate = np.array([np.log(multiplier)])
    found = approaches_at_multiplier_rate(decaying(0.9), np.zeros((1, 1)), 1, rate)
    assert found.tolist() == [approaches]


@pytest.mark.parametrize(("points", "approaches"), [(2, False), (6, True), (9, True)])
def test_a_handful_of_points_shows_the_rate_of_approach(points: int, approaches: bool) -> None:
    """x <- x/2 falls by 2^5 over six points; two points have some rate whatever the motion is."""
    rate = np.array([np.log(0.5)])
    found = approaches_at_multiplier_rate(decaying(0.5, points), np.zeros((1, 1)), 1, rate)
    assert found.tolist() == [approaches]


def test_motion_that_was_nearer_at_first_does_not_approach() -> None:
    """The distance falls at the right rate, but one of the first points was nearer."""
    points = decaying(0.9)
    points[0, 3] = 0.99 * points[0, -1]
    assert not approaches_at_multiplier_rate(points, np.zeros((1, 1)), 1, np.array([np.log(0.9)]))[
        0
    ]


def test_the_period_ahead_is_the_least_one() -> None:
    """r = 2.8: the fixed point, though every second point returns as well."""
    points = Iterated(logistic, np.array([[2.8]]))
    x = np.empty((1, 61, 1))
    x[0, 0] = 0.3
    for n in range(60):
        x[:, n + 1] = points.iterate(np.array([0]), x[:, n], 1)[0]
    for candidate in (1, 2, 6):
        found = find_approached_orbit_periods(
            x, np.array([0]), np.array([candidate]), points.iterate
        )
        assert found.tolist() == [1]


def test_tails_end_on_the_orbit_that_they_approach() -> None:
    """r = 2.95 and 3.2 at once: 1 - 1/r, and the two points of period 2, in the order of time.

    Of period 2: x = (r + 1 ± √((r − 3)(r + 1)))/(2r).
    """
    r = np.array([[2.95], [3.2]])
    points = Iterated(logistic, r)
    tails = np.empty((2, 8, 1))
    low, high = ((4.2 + s * np.sqrt(0.84)) / 6.4 for s in (-1.0, 1.0))
    tails[:, 0, 0] = 0.65, low + 0.003
    for n in range(7):
        tails[:, n + 1] = points.iterate(np.arange(2), tails[:, n], 1)[0]
    settled = orbit_exponents(
        points.iterate, lambda *_: (points.iterate, points.iterate),
        np.arange(2), tails[:, -1], np.array([1, 2]), 0.0,
    )  # fmt: skip
    ends = replace_tails_by_limit_orbits(points.iterate, tails, settled)
    np.testing.assert_allclose(ends[0, -1, 0], 1.0 - 1.0 / 2.95, atol=1e-12)
    np.testing.assert_allclose(ends[1, -2:, 0], [low, high], atol=1e-12)
    np.testing.assert_array_equal(ends[:, :-2], tails[:, :-2])
    assert abs(tails[0, -1, 0] - ends[0, -1, 0]) > 1e-3


def test_what_shows_nothing_is_not_an_attractor() -> None:
    """Two tori about different centres are two attractors, chaos on one of them a third."""
    n = np.arange(64)
    wave = np.cos(2 * np.pi * GOLDEN * n)
    tails = np.stack([wave, 3.0 + wave, 0.01 + np.roll(wave, 3), wave, wave])[:, :, None]
    torus, chaos, undecided = Regime.QUASI_PERIODIC, Regime.CHAOTIC, Regime.UNDECIDED
    regime = np.array([torus, torus, torus, chaos, undecided])
    found = assign_attractors(tails, regime, np.zeros(5, dtype=np.int64))
    assert found.attractor_number.tolist() == [0, 1, 0, 2, -1]
