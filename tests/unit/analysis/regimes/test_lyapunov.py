"""Lyapunov exponents of maps for which they are known."""

from __future__ import annotations

import numpy as np
import pytest

from remanent.analysis.regimes.lyapunov import batch_means_error, lyapunov_exponents
from tests.unit.analysis.regimes.iterated import henon, logistic, run, standard


def test_logistic_map_at_four_has_exponent_ln_2() -> None:
    """Exponents: within 1 % and within 3 standard errors."""
    path = run(logistic, np.array([0.3]), np.array([4.0]), 20000)
    found = lyapunov_exponents(path.log_growth, path.block_lengths_in_periods)
    assert found.mean[0, 0] == pytest.approx(np.log(2.0), rel=0.01)
    assert abs(found.mean[0, 0] - np.log(2.0)) <= 3.0 * found.error[0, 0]
    assert found.running_mean[0, -1, 0] == pytest.approx(path.log_growth[0, :, 0].sum() / 20000)


def test_henon_exponents_add_up_to_ln_b() -> None:
    """The map contracts area by b everywhere, so the sum is exact."""
    path = run(henon, np.array([0.1, 0.1]), np.array([1.4, 0.3]), 5000)
    found = lyapunov_exponents(path.log_growth, path.block_lengths_in_periods)
    assert found.mean.sum() == pytest.approx(np.log(0.3), abs=1e-9)
    assert found.mean[0, 0] == pytest.approx(0.419, abs=0.02)


def test_exponents_come_in_pairs_where_area_is_preserved() -> None:
    """Standard map: L1 + L2 = 0, and L1 near ln(K/2) at large K (Chirikov 1979)."""
    path = run(standard, np.array([0.5, 1.0]), np.array([5.0]), 2000)
    found = lyapunov_exponents(path.log_growth, path.block_lengths_in_periods)
    assert abs(found.mean[0].sum()) < 1e-6
    assert found.mean[0, 0] == pytest.approx(np.log(2.5), rel=0.1)


def test_a_fixed_point_has_its_eigenvalues() -> None:
    """Standard map at (0, 0) with K: multipliers of [[1 + K, 1], [K, 1]]."""
    path = run(standard, np.array([0.0, 0.0]), np.array([1.0]), 400)
    found = lyapunov_exponents(path.log_growth, path.block_lengths_in_periods)
    largest = np.log((3.0 + np.sqrt(5.0)) / 2.0)
    np.testing.assert_allclose(found.mean[0], [largest, -largest], rtol=1e-9)


def test_exponents_do_not_depend_on_company() -> None:
    """Determinism: a point alone and among others goes the same way, to the bit."""
    par = np.linspace(3.6, 4.0, 9)[:, None]
    together = run(logistic, np.full((9, 1), 0.3), par, 500)
    alone = run(logistic, np.array([0.3]), par[4], 500)
    np.testing.assert_array_equal(together.triangular_factors[4], alone.triangular_factors[0])


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
    found = batch_means_error(values)
    assert np.mean(found) == pytest.approx(exact, rel=0.2)
    covered = np.abs(values.mean(axis=1)) <= 3.0 * found
    assert covered.mean() > 0.97


def test_a_shorter_last_block_is_no_scatter() -> None:
    """Growth at a constant rate: the rate itself, and no error, whatever the blocks are."""
    lengths = np.append(np.full(40, 16), 5)
    growth = 0.3 * lengths[None, :, None].astype(np.float64)
    found = lyapunov_exponents(growth, lengths)
    assert found.mean[0, 0] == pytest.approx(0.3)
    assert found.error[0, 0] == pytest.approx(0.0, abs=1e-15)
