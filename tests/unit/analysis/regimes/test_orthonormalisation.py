"""Gram-Schmidt by its own identities."""

from __future__ import annotations

import numpy as np

from remanent.analysis.regimes.orthonormalisation import orthonormalise


def test_orthonormal_factors_give_back_the_vectors() -> None:
    """V = R^T Q and Q Q^T = 1, also for two vectors that are nearly parallel."""
    rng = np.random.default_rng(3)
    vectors = rng.normal(size=(5, 3, 3))
    vectors[0, 1] = vectors[0, 0] * (1.0 + 1e-9) + 1e-9 * rng.normal(size=3)
    rows, factors = orthonormalise(vectors)
    np.testing.assert_allclose(np.einsum("pij,pis->pjs", factors, rows), vectors, atol=1e-14)
    np.testing.assert_allclose(
        rows @ rows.transpose(0, 2, 1), np.tile(np.eye(3), (5, 1, 1)), atol=1e-14
    )


def test_vectors_that_lined_up_leave_a_frame() -> None:
    """Equal vectors: no NaN, orthonormal rows, a factor of the size of rounding."""
    rows, factors = orthonormalise(np.ones((1, 2, 2)))
    np.testing.assert_allclose(rows[0] @ rows[0].T, np.eye(2), atol=1e-15)
    assert 0.0 < factors[0, 1, 1] < 1e-14
