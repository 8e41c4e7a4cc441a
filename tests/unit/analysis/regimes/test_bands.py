"""Indicators of motion in bands, on maps whose bands are known."""

from __future__ import annotations

import numpy as np
import pytest

from remanent._typing import FloatArray
from remanent.analysis.regimes.bands import convergence_digits_within_bands, relative_band_scatter
from remanent.analysis.regimes.birkhoff import birkhoff_convergence_digits
from remanent.analysis.regimes.orbit_batch import OrbitBatch
from tests.unit.analysis.regimes.iterated import logistic, run

GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


def batch(points: FloatArray) -> OrbitBatch:
    """Orbits (orbit, iterate) of one observable."""
    return OrbitBatch(points[:, :, None], np.ones((len(points), 1, 1, 1)), 0)


def test_chaos_within_bands_is_not_hidden_by_the_step_between_them() -> None:
    """Points that jump between 0 and 1 in turn, with noise of 1e-6 upon it.

    The averages agree to the size of the noise beside that of the jump, over the root of the
    number of points; within a band the jump is gone, and they agree like those of noise.
    """
    n = np.arange(1000)
    noise = 1e-6 * np.random.default_rng(3).normal(size=(20, 1000))
    points = (n % 2) + noise
    assert birkhoff_convergence_digits(points).min() > 5.0
    assert convergence_digits_within_bands(batch(points)).max() < 3.5


def test_a_torus_has_no_bands() -> None:
    """Every k-th point of a golden rotation is spread over all of it, and is a torus too."""
    torus = np.cos(2.0 * np.pi * GOLDEN * np.arange(1000))[None]
    assert convergence_digits_within_bands(batch(torus))[0] == birkhoff_convergence_digits(torus)[0]
    assert relative_band_scatter(batch(torus))[0] == pytest.approx(1.0, abs=0.02)


def test_every_eighth_point_of_many_bands_lies_in_one() -> None:
    """The end of the doublings of the logistic map: bands of all sizes, 2^k of them."""
    path = run(logistic, np.array([0.3]), np.array([3.569945672]), 4000, every=True)
    assert path.visited_states is not None
    assert relative_band_scatter(batch(path.visited_states[:, 1000:, 0]))[0] < 0.1
