"""Quantiles and indices of functions for which they are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import norm, uniform

from remanent._typing import FloatArray
from remanent.analysis.inference.uncertainty import (
    UncertainArguments,
    estimate_sobol_indices,
    propagate_distributions,
)

QUANTILES = np.array([0.05, 0.5, 0.95])


def ishigami(x: FloatArray) -> FloatArray:
    """sin x1 + 7 sin^2 x2 + 0.1 x3^4 sin x1, and a sum with weights 3, 2, 1."""
    a, b, c = np.sin(x[:, 0]), np.sin(x[:, 1]), x[:, 2]
    return np.column_stack([a + 7.0 * b**2 + 0.1 * c**4 * a, x @ [3.0, 2.0, 1.0]])


def test_indices_of_ishigami_and_of_a_sum() -> None:
    """Closed forms (Ishigami and Homma 1990), within four standard errors."""
    box = UncertainArguments([uniform(-np.pi, 2.0 * np.pi)] * 3)
    found = estimate_sobol_indices(ishigami, box, 4096, np.random.default_rng(1))
    v1, v2 = 0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2, 49.0 / 8.0
    v13 = 0.01 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    total = v1 + v2 + v13
    first = np.array([[v1 / total, 9.0 / 14.0], [v2 / total, 4.0 / 14.0], [0.0, 1.0 / 14.0]])
    whole = first + np.array([[v13 / total, 0.0], [0.0, 0.0], [v13 / total, 0.0]])
    assert (np.abs(found.first_order - first) < 4.0 * found.first_order_error).all()
    assert (np.abs(found.total_effect - whole) < 4.0 * found.total_effect_error).all()
    assert (found.first_order_error < 0.05).all()


def test_quantiles_of_a_normal_distribution() -> None:
    """2 + 3 z: intervals from the errors cover the quantiles and the mean."""
    far, normal = [], UncertainArguments([norm(2.0, 3.0)])
    for seed in range(60):
        found = propagate_distributions(
            lambda x: x, normal, QUANTILES, 512, np.random.default_rng(seed)
        )
        exact = norm(2.0, 3.0).ppf(QUANTILES)[:, None]
        far += [*(np.abs(found.quantiles - exact) / found.quantiles_error)]
        far += [np.abs(found.average - 2.0) / found.average_error]
        assert abs(found.deviation[0] - 3.0) < 7.0 * found.deviation_error[0]
    # Student's t of 7 degrees of freedom: 68 % within 1.08 deviations, 95 % within 2.36.
    assert 0.60 < (np.array(far) < 1.0).mean() < 0.76
    assert 0.90 < (np.array(far) < 2.36 / 1.08).mean() < 0.98


def test_the_faces_of_the_unit_cube_are_points_too() -> None:
    """Shares of 0 and 1, whose quantiles would be infinite, lie eight deviations out."""
    joint = UncertainArguments([norm(1.0, 2.0)], np.array([-3.0]), np.array([[4.0]]))
    ends = joint.points(np.array([[0.0, 0.0], [1.0, 1.0]]))
    deviations = (ends - [1.0, -3.0]) / 2.0
    np.testing.assert_allclose(deviations, [[-8.3, -8.3], [8.2, 8.2]], atol=0.1)


def test_scrambled_points_beat_random_ones() -> None:
    """The mean of a smooth function of three arguments, against 512 random points."""
    box = UncertainArguments([uniform(0.0, 1.0)] * 3)
    found = propagate_distributions(
        lambda x: x.prod(axis=1, keepdims=True), box, QUANTILES, 512, np.random.default_rng(0)
    )
    random = np.sqrt(1.0 / 27.0 - 1.0 / 64.0) / np.sqrt(512.0)
    assert abs(found.average[0] - 0.125) < 0.2 * random


def test_what_is_not_known_is_counted_and_left_out() -> None:
    """Half of the points unknown; one number constant; one known nowhere."""

    def function(x: FloatArray) -> FloatArray:
        half = np.where(x[:, 0] < 0.5, x[:, 0], np.nan)
        return np.column_stack([half, np.ones(len(x)), np.full(len(x), np.nan), x[:, 0]])

    box = UncertainArguments([uniform(0.0, 1.0)])
    found = propagate_distributions(function, box, QUANTILES, 512, np.random.default_rng(0))
    np.testing.assert_allclose(found.known_share, [0.5, 1.0, 0.0, 1.0], atol=0.01)
    assert found.quantiles[1, 0] == pytest.approx(0.25, abs=0.01)
    assert np.isnan(found.quantiles[:, 2]).all()
    shares = estimate_sobol_indices(function, box, 64, np.random.default_rng(0))
    np.testing.assert_array_equal(np.isfinite(shares.first_order[0]), [False, False, False, True])
    assert shares.first_order[0, 3] == pytest.approx(1.0, abs=0.1)


def test_joint_normal_arguments_have_their_covariance() -> None:
    """Sums and differences of correlated arguments beside an independent one, in closed form."""
    covariance = np.array([[4.0, -1.5], [-1.5, 1.0]])
    arguments = UncertainArguments([norm(0.0, 2.0)], np.array([1.0, 2.0]), covariance)
    weights = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [1.0, 1.0, -1.0]]).T
    found = propagate_distributions(
        lambda x: x @ weights, arguments, QUANTILES, 1024, np.random.default_rng(0)
    )
    expected = np.sqrt([4.0, 4.0 + 1.0 - 3.0, 4.0 + 4.0 + 1.0 + 3.0])
    np.testing.assert_allclose(found.average, [0.0, 3.0, -1.0], atol=0.01)
    np.testing.assert_allclose(found.deviation, expected, rtol=0.01)
