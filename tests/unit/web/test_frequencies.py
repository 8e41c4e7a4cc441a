"""The range of a response that nobody chose: resonances lie inside, wherever the load is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import remanent as rm
from remanent.web.frequencies import frequency_range, natural_frequencies, resonances
from remanent.web.jobs import job_result
from remanent.web.subjects import Subject

#: Duffing's oscillator: about its two wells it vibrates at the root of 2.
DUFFING = rm.LagrangianSystem.example()
DAMPED = rm.Actuator(dissipation=rm.Rayleigh(0.05))


def test_natural_frequencies_are_those_of_small_vibrations() -> None:
    """Law: both wells have the curvature 2, and a block that moves nothing vibrates at root 6."""
    found = natural_frequencies(DUFFING, 0.0)
    np.testing.assert_allclose(found.max(), math.sqrt(2.0), rtol=1e-9)
    np.testing.assert_allclose(natural_frequencies(rm.Actuator(), 0.0), math.sqrt(6.0), rtol=1e-9)


def test_each_harmonic_of_the_load_has_its_resonance() -> None:
    """Law: a sine acts at its own frequency, its square at twice that, sines at theirs."""
    (own, _) = resonances(rm.Actuator(), rm.Sine(1e-6, 1.0))
    (half, _) = resonances(rm.Actuator(), rm.SineSquared(1e-3, 1.0))
    assert own == pytest.approx(math.sqrt(6.0), rel=1e-5)
    assert half == pytest.approx(0.5 * math.sqrt(6.0), rel=1e-5)
    several = resonances(rm.Actuator(), rm.Sines((1e-6, 1e-6), (1.0, 3.0), 1.0))
    np.testing.assert_allclose(np.unique(several.round(4)), [0.8165, 2.4495])


@pytest.mark.parametrize(
    ("system", "drive", "initial"),
    [
        (DAMPED, rm.Sine(0.16, 2.5, mean=0.16), {}),
        (DAMPED, rm.SineSquared(0.4, 1.25), {}),
        (rm.Actuator(prestress=2.0), rm.SineSquared(0.4, 300.0), {}),
        (rm.Actuator(dissipation=rm.Zener(3.0, 10.0)), rm.SineSquared(0.4, 0.3), {}),
        (DUFFING, rm.Sine(0.02, 1.0), {"x": 1.0}),
    ],
)
def test_a_response_has_its_resonance_inside(
    system: Any, drive: Any, initial: dict[str, float]
) -> None:
    """Law: without a range the largest amplitude is a peak within it, and the range is told."""
    result = job_result("frequency_response", Subject(system, drive, initial), {"count": 120})
    low, high = result["settings"]["range"]
    found = result["resonance"]["resonance"]["values"]
    assert found is not None
    assert low < found < high


def test_the_frequency_of_the_load_is_inside_where_it_is_near() -> None:
    """Law: the place where the motion is can be seen, unless it is far from all resonances."""
    for omega, is_inside in ((0.3, True), (1.25, True), (6.0, True), (300.0, False)):
        low, high = frequency_range(rm.Actuator(), rm.SineSquared(0.4, omega))
        assert (low < omega < high) == is_inside


def test_what_does_not_vibrate_has_a_range_around_its_load() -> None:
    """Law: without a natural frequency the range lies around the frequency of the load."""
    falling = rm.LagrangianSystem(
        coordinates="x", kinetic="x_rate**2/2", potential="-x**2 - load*x"
    )
    assert frequency_range(falling, rm.Sine(0.3, 4.0)) == (2.0, 8.0)
