"""Exponents, averages, indicators and labels of maps whose answers are known."""

from __future__ import annotations

import numpy as np
import pytest
from tests.unit.analysis.iterated import Iterated, Step, henon, logistic, rolled, standard

from remanent._typing import FloatArray, IntArray
from remanent.analysis import regimes
from remanent.analysis.basins import attractors
from remanent.analysis.birkhoff import overlapping_digits, rotation
from remanent.analysis.following import Path, follow, orthonormal
from remanent.analysis.indicators import alignment, zero_one
from remanent.analysis.lyapunov import batch_error, exponents, pairing
from remanent.analysis.regimes import Regime, Verdict
from remanent.analysis.returns import limit, returns
from remanent.analysis.spectra import lines, spectrum

GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


def run(step: Step, y0: FloatArray, par: FloatArray, periods: int, *, every: bool = False) -> Path:
    start, advance = np.atleast_2d(y0), Iterated(step, np.atleast_2d(par))
    return follow(advance, start, periods, directions=start.shape[1], every=every)


def label(
    step: Step, y0: FloatArray, par: FloatArray, periods: int, *, damped: bool = True
) -> Verdict:
    """Labels; rounding in other orders stands for other tolerances."""
    points = Iterated(step, par)

    def again(which: IntArray, n: int, states: FloatArray | None = None, /) -> Path:
        moved = y0[which] * (1.0 + n * 1e-13) if states is None else states
        advance = Iterated(step, par[which])
        return follow(advance, moved, periods, directions=y0.shape[1], every=True)

    verdict, _ = regimes.classify(
        again,
        len(y0),
        damped=np.full(len(y0), damped),
        iterate=points.iterate,
        observables=rolled if step is standard else regimes.plain,
    )
    return verdict


def test_logistic_map_at_four_has_exponent_ln_2() -> None:
    """Exponents: within 1 % and within 3 standard errors."""
    path = run(logistic, np.array([0.3]), np.array([4.0]), 20000)
    found = exponents(path.growth, path.lengths)
    assert found.mean[0, 0] == pytest.approx(np.log(2.0), rel=0.01)
    assert abs(found.mean[0, 0] - np.log(2.0)) <= 3.0 * found.error[0, 0]
    assert found.history[0, -1, 0] == pytest.approx(path.growth[0, :, 0].sum() / 20000)


def test_henon_exponents_add_up_to_ln_b() -> None:
    """The map contracts area by b everywhere, so the sum is exact."""
    path = run(henon, np.array([0.1, 0.1]), np.array([1.4, 0.3]), 5000)
    found = exponents(path.growth, path.lengths)
    assert found.mean.sum() == pytest.approx(np.log(0.3), abs=1e-9)
    assert found.mean[0, 0] == pytest.approx(0.419, abs=0.02)


def test_exponents_come_in_pairs_where_area_is_preserved() -> None:
    path = run(standard, np.array([0.5, 1.0]), np.array([5.0]), 2000)
    found = exponents(path.growth, path.lengths)
    assert abs(pairing(found.mean)[0, 0]) < 1e-6
    assert found.mean[0, 0] == pytest.approx(np.log(2.5), rel=0.1)


def test_a_fixed_point_has_its_eigenvalues() -> None:
    """Standard map at (0, 0) with K: multipliers of [[1 + K, 1], [K, 1]]."""
    path = run(standard, np.array([0.0, 0.0]), np.array([1.0]), 400)
    found = exponents(path.growth, path.lengths)
    largest = np.log((3.0 + np.sqrt(5.0)) / 2.0)
    np.testing.assert_allclose(found.mean[0], [largest, -largest], rtol=1e-9)


def test_exponents_do_not_depend_on_company() -> None:
    """Determinism: a point alone and among others goes the same way, to the bit."""
    par = np.linspace(3.6, 4.0, 9)[:, None]
    together = run(logistic, np.full((9, 1), 0.3), par, 500)
    alone = run(logistic, np.array([0.3]), par[4], 500)
    np.testing.assert_array_equal(together.factors[4], alone.factors[0])


def test_orthonormal_factors_give_back_the_vectors() -> None:
    rng = np.random.default_rng(3)
    vectors = rng.normal(size=(5, 3, 3))
    vectors[0, 1] = vectors[0, 0] * (1.0 + 1e-9) + 1e-9 * rng.normal(size=3)
    rows, factors = orthonormal(vectors)
    np.testing.assert_allclose(np.einsum("pij,pis->pjs", factors, rows), vectors, atol=1e-14)
    np.testing.assert_allclose(rows @ rows.transpose(0, 2, 1), np.tile(np.eye(3), (5, 1, 1)),
                               atol=1e-14)  # fmt: skip


def test_vectors_that_lined_up_leave_a_frame() -> None:
    """Equal vectors: no NaN, orthonormal rows, a factor of the size of rounding."""
    rows, factors = orthonormal(np.ones((1, 2, 2)))
    np.testing.assert_allclose(rows[0] @ rows[0].T, np.eye(2), atol=1e-15)
    assert 0.0 < factors[0, 1, 1] < 1e-14


@pytest.mark.parametrize("memory", [0.0, 0.9, -0.5])
def test_batch_error_of_correlated_noise(memory: float) -> None:
    """x' = a x + noise: the variance of the mean tends to 1/(1 - a)^2 per sample."""
    rng = np.random.default_rng(4)
    noise = rng.normal(size=(400, 4000))
    values = np.empty_like(noise)
    values[:, 0] = noise[:, 0]
    for k in range(1, 4000):
        values[:, k] = memory * values[:, k - 1] + noise[:, k]
    exact = 1.0 / (1.0 - memory) / np.sqrt(4000)
    found = batch_error(values)
    assert np.mean(found) == pytest.approx(exact, rel=0.2)
    covered = np.abs(values.mean(axis=1)) <= 3.0 * found
    assert covered.mean() > 0.97


def test_rotation_number_of_a_twisted_circle() -> None:
    """A rigid rotation seen through a nonlinear change of coordinates, clockwise."""
    n = np.arange(400)
    for turns in (GOLDEN, 0.02, 0.97, 0.52):
        angle = -2.0 * np.pi * (turns * n + 0.1)
        shift = angle + 0.3 * np.sin(angle) + 0.1 * np.cos(2.0 * angle)
        points = np.stack([3.0 + np.cos(shift), 0.01 * np.sin(shift)], axis=1)
        found = rotation(points[None])
        assert found.number[0] == pytest.approx(turns, abs=1e-6)
        assert found.digits[0] > 5.0


def test_a_curve_beside_its_centre_has_no_rotation_number() -> None:
    n = np.arange(400)
    points = np.stack([np.cos(n), np.sin(n)], axis=1)
    found = rotation(points[None], centre=np.array([[3.0, 0.0]]))
    assert np.isnan(found.number[0])
    assert found.digits[0] == 0.0


def test_digits_of_a_torus_and_of_noise() -> None:
    n = np.arange(1000)
    torus = np.cos(2 * np.pi * GOLDEN * n) + 0.3 * np.cos(4 * np.pi * GOLDEN * n)
    noise = np.random.default_rng(5).normal(size=1000)
    digits = overlapping_digits(np.stack([torus, noise]))
    assert digits[0] > 10.0
    assert digits[1] < 3.0


def test_zero_one_test_tells_order_from_chaos() -> None:
    """About 0 on a torus, about 1 for the logistic map at r = 4."""
    n = np.arange(1000)
    chaos = run(logistic, np.array([0.3]), np.array([4.0]), 999, every=True).visited
    assert chaos is not None
    series = np.stack([np.cos(2 * np.pi * GOLDEN * n) + 0.2, chaos[0, :, 0]])
    found = zero_one(series, rng=np.random.default_rng(1))
    assert abs(found[0]) < 0.1
    assert found[1] > 0.9


def test_displacement_is_what_its_definition_says() -> None:
    """K with the mean-square displacement summed directly."""
    values = np.random.default_rng(2).normal(size=300) + 0.5
    c = np.random.default_rng(8).uniform(np.pi / 5, 4 * np.pi / 5, 1)[0]
    path = np.cumsum(values * np.exp(1j * c * np.arange(1, 301)))
    n = np.arange(1, 31)
    moved = [np.mean(np.abs(path[k : 270 + k] - path[:270]) ** 2) for k in n]
    moved = moved - np.mean(values) ** 2 * (1 - np.cos(c * n)) / (1 - np.cos(c))
    expected = np.corrcoef(n, moved)[0, 1]
    found = zero_one(values[None], rng=np.random.default_rng(8), frequencies=1)
    assert found[0] == pytest.approx(expected, abs=1e-9)


def test_alignment_is_that_of_tangents_left_alone() -> None:
    """The index from triangular factors against tangents that were never made orthogonal."""
    points = Iterated(standard, np.array([[0.7]]))
    path = run(standard, np.array([1.0, 0.3]), np.array([0.7]), 40)
    start = follow(points, np.array([[1.0, 0.3]]), 0 + 1, directions=2)
    frame, _ = orthonormal(np.random.default_rng(7).normal(size=(1, 2, 2)))
    image = points(np.array([0]), np.array([[1.0, 0.3]]), frame, 40, every=False)
    u, w = (t / np.linalg.norm(t) for t in image.tangents[0])
    exact = min(np.linalg.norm(u - w), np.linalg.norm(u + w))
    assert alignment(path.factors)[0, -1] == pytest.approx(exact, rel=1e-6)
    assert start.factors.shape == (1, 1, 2, 2)


def test_alignment_falls_with_twice_the_exponent() -> None:
    path = run(standard, np.array([0.5, 1.0]), np.array([5.0]), 12)
    assert alignment(path.factors)[0, -1] < 1e-6


def test_lines_of_a_spectrum() -> None:
    """Two cosines, 40 dB apart, their frequencies to a millionth of a bin."""
    n = np.arange(500)
    values = 1.0 + np.cos(2 * np.pi * 0.12345 * n + 0.5) + 0.01 * np.cos(2 * np.pi * 0.31 * n)
    found = lines(values, 2)
    np.testing.assert_allclose(found.frequency, [0.12345, 0.31], atol=2e-6)
    np.testing.assert_allclose(found.amplitude, [1.0, 0.01], atol=1e-3)
    assert found.phase[0] == pytest.approx(0.5, abs=1e-2)
    assert found.residual < 2e-3
    frequency, amplitude = spectrum(np.cos(2 * np.pi * 0.25 * np.arange(400)))
    assert frequency[np.argmax(amplitude)] == 0.25
    assert amplitude.max() == pytest.approx(1.0, rel=1e-2)


def test_the_golden_torus_breaks_near_0_97() -> None:
    """On x = 0 the orbit of golden rotation is a torus at K = 0.9; at 1.1 none is left.

    J. M. Greene, J. Math. Phys. 20 (1979) 1183: the last torus breaks at K = 0.971635.
    """
    v = np.linspace(4.0, 4.4, 24)
    y0 = np.column_stack([np.zeros(24), v])
    below = label(standard, y0, np.full((24, 1), 0.9), 1000, damped=False)
    above = label(standard, y0, np.full((24, 1), 1.1), 1000, damped=False)
    points = Iterated(standard, np.full((24, 1), 0.9))
    angle = follow(points, y0, 1000, directions=2, every=True).visited
    assert angle is not None
    turns = np.remainder(np.diff(angle[:, :, 0], axis=1), 2 * np.pi).mean(axis=1) / (2 * np.pi)
    golden = np.abs(turns - GOLDEN) < 4e-3
    assert golden.any()
    assert (below.regime[golden] == Regime.QUASI_PERIODIC).all()
    assert (above.regime == Regime.CHAOTIC).sum() > 3


def test_labels_of_the_logistic_map() -> None:
    """A fixed point, periods 2 and 4, chaos in one band and in two, the window of period 3."""
    r = np.array([2.8, 3.2, 3.5, 4.0, 3.65, 3.835])
    found = label(logistic, np.full((6, 1), 0.3), r[:, None], 500)
    chaos, periodic = int(Regime.CHAOTIC), int(Regime.PERIODIC)
    expected = [periodic, periodic, periodic, chaos, chaos, periodic]
    assert found.regime.tolist() == expected
    assert found.period.tolist() == [1, 2, 4, 0, 0, 3]
    assert (found.margin >= 1.0).all()


def test_a_multiplier_near_minus_one_does_not_double_the_period() -> None:
    """r = 2.95: the fixed point is approached from both sides in turn."""
    found = label(logistic, np.array([[0.3]]), np.array([[2.95]]), 300)
    assert (found.regime[0], found.period[0]) == (Regime.PERIODIC, 1)


def test_at_the_edge_nothing_is_said() -> None:
    """r = 3, where period 1 gives way to period 2, and the end of the doublings."""
    found = label(logistic, np.full((2, 1), 0.3), np.array([[3.0], [3.569945672]]), 500)
    assert found.regime.tolist() == [Regime.UNDECIDED] * 2
    assert np.isnan(found.margin).all()


def test_what_leaves_has_escaped() -> None:
    found = label(henon, np.array([[0.1, 0.1]]), np.array([[1.5, 0.3]]), 500)
    assert found.regime[0] == Regime.ESCAPED


def test_one_tolerance_that_disagrees_takes_the_label_away() -> None:
    """Chaos needs two witnesses: chaos at one tolerance, a fixed point at another."""
    par = np.array([[3.9]])

    def again(which: IntArray, n: int, _states: FloatArray | None = None, /) -> Path:
        values = par[which] if n != 2 else np.full((which.size, 1), 2.8)
        start = np.full((which.size, 1), 0.3)
        return follow(Iterated(logistic, values), start, 500, directions=1, every=True)

    found, _ = regimes.classify(again, 1, damped=np.ones(1, dtype=np.bool_))
    assert found.regime[0] == Regime.UNDECIDED


@pytest.mark.parametrize(("later", "regime"), [(3.9, Regime.CHAOTIC), (2.8, Regime.UNDECIDED)])
def test_damped_chaos_has_to_outlast_the_run(later: float, regime: Regime) -> None:
    """Chaos needs two witnesses: chaos that settles in what follows the run was a transient."""

    def again(which: IntArray, n: int, states: FloatArray | None = None, /) -> Path:
        par = np.full((which.size, 1), 3.9 if states is None else later)
        start = np.full((which.size, 1), 0.3 + n * 1e-13) if states is None else states
        return follow(Iterated(logistic, par), start, 500, directions=1, every=True)

    found, _ = regimes.classify(again, 1, damped=np.ones(1, dtype=np.bool_))
    assert found.regime[0] == regime


def test_period_of_the_best_return() -> None:
    n = np.arange(300)
    points = np.stack([np.cos(2 * np.pi * n / 7), np.cos(2 * np.pi * n * GOLDEN)])[:, :, None]
    found = returns(points, closed=1e-9)
    assert found.period[0] == 7
    assert found.defect[0] < 1e-12
    assert found.defect[1] > 1e-3


def test_the_limit_ahead_is_the_fixed_point() -> None:
    """1 - 1/r, multiplier 2 - r."""
    points = Iterated(logistic, np.array([[2.8]]))
    found = limit(points.iterate, np.array([0]), np.array([[0.6]]), 1)
    assert found.state[0, 0] == pytest.approx(1 - 1 / 2.8, abs=1e-14)
    assert found.multiplier[0] == pytest.approx(0.8, abs=1e-12)


def test_attractors_are_sorted_by_their_visitors() -> None:
    """Two orbits of period 2, seen at different phases, and a third motion that is lost."""
    a, b = np.tile([0.0, 1.0], 8), np.tile([5.0, 6.0], 8)
    tails = np.stack([b, a, np.roll(a, 1), a, np.full(16, np.nan)])[:, :, None]
    regime = np.array([1, 1, 1, 1, 4])
    found = attractors(tails, regime, np.array([2, 2, 2, 2, 0]))
    assert found.which.tolist() == [1, 0, 0, 0, -1]
    assert found.first.tolist() == [1, 0]
