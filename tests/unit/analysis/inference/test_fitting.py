"""Least squares, its errors, and decay, on functions that are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import binom, linregress

from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.analysis.inference.fitting import (
    Observations,
    ParameterBox,
    fit_least_squares,
    profile_likelihood_interval,
)
from remanent.analysis.inference.ringdown import _smoothed, fit_exponential_decay

T = np.linspace(0.0, 6.0, 40)
FREE = ParameterBox(np.ones(2), np.full(2, -np.inf), np.full(2, np.inf))


def line(x: FloatArray) -> FloatArray:
    return x[:, :1] + x[:, 1:] * T


def ringing(x: FloatArray) -> FloatArray:
    return np.exp(-x[:, :1] * T) * np.cos(x[:, 1:] * T)


def noisy(seed: int, sigma: float) -> Observations:
    values = ringing(np.array([[0.2, 3.0]]))[0]
    noise = np.random.default_rng(seed).normal(0.0, sigma, T.size)
    return Observations(values + noise, np.ones(T.size), has_absolute_deviations=False)


def test_a_line_is_the_textbook_regression() -> None:
    """Estimates, standard errors, and a profile that is the linear interval itself."""
    values = 1.0 + 0.3 * T + np.random.default_rng(0).normal(0.0, 0.1, T.size)
    data = Observations(values, np.ones(T.size), has_absolute_deviations=False)
    found = fit_least_squares(line, data, np.zeros(2), FREE)
    book = linregress(T, values)
    np.testing.assert_allclose(found.estimate, [book.intercept, book.slope], rtol=1e-7)
    np.testing.assert_allclose(
        found.standard_errors, [book.intercept_stderr, book.stderr], rtol=1e-7
    )
    half = found.two_sided_t_quantile(0.9) * found.standard_errors[1]
    ends = profile_likelihood_interval(line, data, found, FREE, 1, 0.9)
    np.testing.assert_allclose(ends, found.estimate[1] + [-half, half], atol=2e-3 * half)


def test_a_slope_that_one_parameter_does_not_have_is_an_error() -> None:
    """The model is known on one line alone: no step can be made across it."""
    data = Observations(T, np.ones(T.size), has_absolute_deviations=False)

    def model(x: FloatArray) -> FloatArray:
        predictions = line(x)
        predictions[x[:, 1] != 0.5, -1] = np.nan
        return predictions

    with pytest.raises(InputError, match="to either side"):
        fit_least_squares(model, data, np.full(2, 0.5), FREE)


def test_intervals_cover_as_often_as_they_say() -> None:
    """Of 400 noisy records, 95 % intervals hold the truth within binomial bounds."""
    inside = np.zeros(2, dtype=int)
    for seed in range(400):
        found = fit_least_squares(ringing, noisy(seed, 0.05), np.array([0.25, 2.9]), FREE)
        half = found.two_sided_t_quantile(0.95) * found.standard_errors
        inside += np.abs(found.estimate - [0.2, 3.0]) < half
    low, high = binom.interval(0.9999, 400, 0.95)
    assert ((inside >= low) & (inside <= high)).all(), inside


def test_known_deviations_set_the_scale() -> None:
    """Standard errors do not depend on the scatter where deviations are known."""
    data = noisy(1, 0.05)
    one = fit_least_squares(
        ringing,
        Observations(data.measured_values, np.full(T.size, 0.1), True),
        np.array([0.2, 3.0]),
        FREE,
    )
    two = fit_least_squares(
        ringing,
        Observations(data.measured_values, np.full(T.size, 0.2), True),
        np.array([0.2, 3.0]),
        FREE,
    )
    np.testing.assert_allclose(two.standard_errors, 2.0 * one.standard_errors, rtol=1e-6)
    assert one.chi_square == pytest.approx(4.0 * two.chi_square)


def test_parameters_that_cannot_be_told_apart_are_refused() -> None:
    """Only the sum of two enters."""

    def both(x: FloatArray) -> FloatArray:
        return ringing(np.column_stack([x.sum(axis=1) / 4.0, np.full(len(x), 3.0)]))

    with pytest.raises(InputError, match="combination"):
        fit_least_squares(both, noisy(2, 0.01), np.array([0.4, 0.4]), FREE)


def test_profile_ends_are_infinite_where_nothing_limits_them() -> None:
    """y = exp(-x) for x far out: no upper end."""

    def flat(x: FloatArray) -> FloatArray:
        return np.repeat(np.exp(-x), 5, axis=1)

    data = Observations(
        np.array([0.03, -0.03, 0.05, -0.04, 0.04]), np.full(5, 0.05), has_absolute_deviations=True
    )
    box = ParameterBox(np.ones(1), np.array([-5.0]), np.array([50.0]))
    ends = profile_likelihood_interval(
        flat, data, fit_least_squares(flat, data, np.array([3.0]), box), box, 0, 0.95
    )
    assert np.isfinite(ends[0])
    assert ends[1] == np.inf


def test_decay_of_a_known_oscillation() -> None:
    """exp(-a t) cos(w t) + drift of level: decrement 2 pi a/w whatever the level."""
    t = np.linspace(0.0, 30.0, 3001)
    found = fit_exponential_decay(t, 5.0 + np.exp(-0.1 * t) * np.cos(2.0 * t), prominence=0.01)
    assert found is not None
    assert found.logarithmic_decrement == pytest.approx(np.pi * 0.1, rel=1e-8)
    assert found.angular_frequency == pytest.approx(2.0, rel=1e-8)
    assert fit_exponential_decay(t[:200], np.cos(t[:200]), prominence=0.01) is None


def test_what_smoothing_leaves_tells_the_noise_without_bias() -> None:
    """The mean of its square is the variance: of n samples n less the coefficients are free."""
    t, sigma, rng = np.linspace(0.0, 3.0, 150), 0.01, np.random.default_rng(3)
    variances, free = [], []
    for _ in range(60):
        record = _smoothed(t, np.cos(2.0 * np.pi * t) + rng.normal(0.0, sigma, t.size))
        assert record is not None
        assert record.cycles == pytest.approx(3.0, abs=0.2)
        variances.append(record.noise**2 / sigma**2)
        free.append(t.size - len(record.covariance))
    standard_error = np.sqrt(2.0 / np.sum(free))
    assert abs(np.mean(variances) - 1.0) < 3.0 * standard_error < 0.06


def test_the_error_of_a_decrement_is_the_scatter_of_its_estimates() -> None:
    """Turning points of known logarithms with noise: the error against 80 repetitions."""
    rng = np.random.default_rng(7)
    t = np.linspace(0.0, 30.0, 1501)
    clean = np.exp(-0.05 * t) * np.cos(2.0 * t)
    estimates, errors = [], []
    for _ in range(80):
        # A slow change of the level moves every swing a little, as noise that a spline can follow.
        slow = np.interp(t, np.linspace(0.0, 30.0, 40), rng.normal(0.0, 0.01, 40))
        found = fit_exponential_decay(t, clean * (1.0 + slow), prominence=0.01)
        assert found is not None
        estimates.append(found.logarithmic_decrement)
        errors.append(found.logarithmic_decrement_error)
    assert np.mean(errors) == pytest.approx(np.std(estimates), rel=0.5)
