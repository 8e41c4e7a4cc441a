"""Lags of harmonics of a response behind terms of the load."""

from __future__ import annotations

import numpy as np
import pytest

from remanent.analysis.response.harmonics import phase_lag_behind_load


def test_a_harmonic_that_the_load_lacks_is_behind_the_first_one_that_it_has() -> None:
    """Law: for a term j of the load and a response h/q, the lag is (h/q)/j arg F_j - arg X.

    That holds also for h/q beyond all terms of the load, and for one between its terms.
    """
    load = np.array([0.5, 0.0, np.exp(-0.9j), 0.0, 0.3j])
    for number, ratio, modulus in ((3, 1.5, np.pi), (7, 3.5, np.pi), (8, 4.0, 2.0 * np.pi)):
        lag = phase_lag_behind_load(0.4, number, 1, load)
        assert not lag.in_load
        assert lag.modulus == pytest.approx(modulus)
        assert lag.angle == pytest.approx(np.mod(-0.9 * ratio - 0.4, modulus))
    own = phase_lag_behind_load(0.4, 4, 1, load)
    assert own.in_load
    assert own.angle == pytest.approx(0.5 * np.pi - 0.4)


def test_behind_a_constant_load_there_is_no_lag() -> None:
    """Law: where nothing of the load oscillates no lag is known, up to whole turns."""
    lag = phase_lag_behind_load(0.4, 1, 1, np.array([0.7, 0.0, 0.0], dtype=complex))
    assert np.isnan(lag.angle)
    assert lag.modulus == pytest.approx(2.0 * np.pi)
    assert not lag.in_load
