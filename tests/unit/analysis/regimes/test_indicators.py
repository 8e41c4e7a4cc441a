"""The alignment index and the 0-1 test, against their definitions."""

from __future__ import annotations

import numpy as np
import pytest

from remanent.analysis.regimes import indicators
from remanent.analysis.regimes.indicators import smaller_alignment_index, zero_one_test
from remanent.analysis.regimes.orthonormalisation import orthonormalise
from tests.unit.analysis.regimes.iterated import Iterated, logistic, run, standard

GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


def test_zero_one_test_tells_order_from_chaos() -> None:
    """About 0 on a torus, about 1 for the logistic map at r = 4."""
    n = np.arange(1000)
    chaos = run(logistic, np.array([0.3]), np.array([4.0]), 999, every=True).visited_states
    assert chaos is not None
    series = np.stack([np.cos(2 * np.pi * GOLDEN * n) + 0.2, chaos[0, :, 0]])
    found = zero_one_test(series, rng=np.random.default_rng(1))
    assert abs(found[0]) < 0.1
    assert found[1] > 0.9


@pytest.mark.parametrize("longest_lag_of_products", [512, 10])
def test_displacement_is_what_its_definition_says(
    longest_lag_of_products: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """K with the mean-square displacement summed directly, by products and by transforms."""
    monkeypatch.setattr(indicators, "_MAX_LAG_OF_PRODUCTS", longest_lag_of_products)
    values = np.random.default_rng(2).normal(size=300) + 0.5
    c = np.random.default_rng(8).uniform(np.pi / 5, 4 * np.pi / 5, 1)[0]
    path = np.cumsum(values * np.exp(1j * c * np.arange(1, 301)))
    n = np.arange(1, 31)
    moved = [np.mean(np.abs(path[k : 270 + k] - path[:270]) ** 2) for k in n]
    moved = moved - np.mean(values) ** 2 * (1 - np.cos(c * n)) / (1 - np.cos(c))
    expected = np.corrcoef(n, moved)[0, 1]
    found = zero_one_test(values[None], rng=np.random.default_rng(8), frequencies=1)
    assert found[0] == pytest.approx(expected, abs=1e-9)


def test_alignment_is_that_of_tangents_left_alone() -> None:
    """The index from triangular factors against tangents that were never made orthogonal."""
    points = Iterated(standard, np.array([[0.7]]))
    path = run(standard, np.array([1.0, 0.3]), np.array([0.7]), 40)
    frame, _ = orthonormalise(np.random.default_rng(7).normal(size=(1, 2, 2)))
    image = points(np.array([0]), np.array([[1.0, 0.3]]), frame, 40, every=False)
    u, w = (t / np.linalg.norm(t) for t in image.tangents[0])
    exact = min(np.linalg.norm(u - w), np.linalg.norm(u + w))
    assert smaller_alignment_index(path.triangular_factors)[0, -1] == pytest.approx(exact, rel=1e-6)


def test_alignment_falls_with_twice_the_exponent() -> None:
    """In chaos the index falls like exp(-(L1 - L2) n), and L1 = -L2 where area is preserved.

    The standard map at large K: L1 = ln(K/2) (B. V. Chirikov, Phys. Rep. 52 (1979) 263).
    """
    rng = np.random.default_rng(6)
    starts = rng.uniform(0.0, 2.0 * np.pi, (400, 2))
    path = run(standard, starts, np.full((400, 1), 20.0), 6)
    logs = np.log(smaller_alignment_index(path.triangular_factors)).mean(axis=0)
    slope = (logs[-1] - logs[1]) / (path.block_lengths_in_periods[2:].sum())
    assert slope == pytest.approx(-2.0 * np.log(10.0), rel=0.05)


@pytest.mark.parametrize("start", [0.5, 0.8, 1.2])
def test_alignment_falls_like_an_inverse_square_on_a_torus(start: float) -> None:
    """Twist makes both tangents grow like n, and their area stays: the angle goes like 1/n^2.

    Tori about the elliptic point of the standard map, at K = 0.5.
    """
    path = run(standard, np.array([np.pi + start, 0.0]), np.array([0.5]), 1600)
    index = smaller_alignment_index(path.triangular_factors)[0]
    n = np.cumsum(path.block_lengths_in_periods)
    power, _ = np.polyfit(np.log(n[20:]), np.log(index[20:]), 1)
    assert power == pytest.approx(-2.0, abs=0.4)


def test_any_number_of_series_is_worked_out_a_few_at_a_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """More series than samples, one at a time, give what all of them together do."""
    values = np.random.default_rng(3).normal(size=(70, 50))
    together = zero_one_test(values, rng=np.random.default_rng(8))
    monkeypatch.setattr(indicators, "_MAX_PRODUCTS_IN_MEMORY", 1)
    np.testing.assert_array_equal(zero_one_test(values, rng=np.random.default_rng(8)), together)
