"""The frequency of free oscillations by their size, against elliptic integrals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import ellipk

import remanent as rm
from remanent.analysis.response.harmonics import power_share
from remanent.studies.response._mean_rest import free_frequency, rest_under_mean_load
from remanent.studies.response._peaks import _SHARE_WEIGHT, _share_error

HARD = rm.LagrangianSystem(
    coordinates="x", kinetic="x_rate**2/2", potential="x**2/2 + x**4/4 - load*x"
)


def test_a_hard_spring_by_its_amplitude() -> None:
    """x'' = -x - x^3: w = pi sqrt(1 + a^2)/(2 K(m)), m = a^2/(2 (1 + a^2)), from four points on."""
    rest = rest_under_mean_load(HARD, 0.0, np.array([[-3.0, 3.0], [-3.0, 3.0]]))
    assert (rest.natural_frequency, rest.elastic_frequency) == (1.0, 1.0)
    amplitude = np.array([0.7, 0.9])
    exact = np.pi * np.sqrt(1.0 + amplitude**2) / 2.0
    exact /= ellipk(amplitude**2 / (2.0 * (1.0 + amplitude**2)))
    for count in (2, 3, 4, 40):
        few = replace(rest, turning_points=np.linspace(0.5, 1.5, count))
        found, error = free_frequency(few, amplitude, np.zeros(2))
        if count < 4:  # no cubic goes through so few
            assert np.isnan(found).all()
            assert np.isnan(error).all()
        else:
            assert (np.abs(found - exact) <= error).all()
            assert error.max() < 1e-8


def test_the_share_of_a_harmonic_moves_with_its_samples() -> None:
    """Two of size 1 and 1/2, shares 4/5 and 1/5: errors of both move these by no more than stated.

    All that the samples may be off is given a weight, since most of it moves no share.
    """
    rng = np.random.default_rng(3)
    exact = np.tile(np.array([0.0, 1.0, 0.5], dtype=complex), (200, 1))
    size = np.geomspace(1e-12, 0.1, 200)
    off = 0.5 * size[:, None] * np.exp(2j * np.pi * rng.uniform(size=exact.shape)) * [0, 1, 1]
    for number, share in ((1, 0.8), (2, 0.2)):
        numbers = np.full(200, number)
        moved = np.abs(power_share(exact + off, numbers) - share)
        bound = _share_error(exact, numbers, size)
        assert (_SHARE_WEIGHT * moved <= bound).all()
        assert bound[0] < 1e-11
