"""Richardson's extrapolation on functions with known derivatives."""

from __future__ import annotations

import numpy as np
import pytest

from remanent.analysis.inference.differences import richardson_derivative, richardson_offsets


@pytest.mark.parametrize("noise", [0.0, 1e-10, 1e-6])
def test_the_error_covers_and_is_not_much_too_large(noise: float) -> None:
    """exp(2x), sin(3x), 1/(1 - x) and x^7 at 0: 2, 3, 1 and 0, with and without noise."""
    x = richardson_offsets(0.1, 6)
    exact = np.array([2.0, 3.0, 1.0, 0.0])
    values = np.stack([np.exp(2 * x), np.sin(3 * x), 1 / (1 - x), x**7], axis=1)
    values += np.random.default_rng(0).uniform(-noise, noise, values.shape)
    found, error = richardson_derivative(values, np.full_like(values, noise), 0.1, 1.0)
    assert (np.abs(found - exact) <= error + 1e-13).all()
    assert (error < 1e-8 + 1e3 * noise).all()


def test_a_corner_has_an_error_as_large_as_its_slope() -> None:
    """|x - 0.03| is not differentiable within the widest differences, and fine within others."""
    x = richardson_offsets(0.1, 6)
    found, error = richardson_derivative(np.abs(x - 0.01)[:, None], np.zeros((12, 1)), 0.1, 1.0)
    assert abs(found[0] + 1.0) <= error[0] + 1e-12
    jump, doubt = richardson_derivative(np.sign(x)[:, None], np.zeros((12, 1)), 0.1, 1.0)
    assert doubt[0] >= 0.5 * abs(jump[0])


def test_what_is_not_known_is_nan() -> None:
    """All values missing: no derivative, an infinite error."""
    found, error = richardson_derivative(np.full((12, 1), np.nan), np.zeros((12, 1)), 0.1, 1.0)
    assert np.isnan(found[0])
    assert np.isinf(error[0])


def test_a_smooth_error_adds_its_derivative() -> None:
    """Values off by 1e-6 exp(x), which no scatter shows: the stated errors do."""
    x = richardson_offsets(0.1, 6)
    off = 1e-6 * np.exp(x)[:, None]
    found, error = richardson_derivative(np.sin(x)[:, None] + off, 2.0 * off, 0.1, 1.0)
    assert 1e-7 < abs(found[0] - 1.0) <= error[0] < 1e-5
