"""Weighted averages and rotation numbers of motions for which they are known."""

from __future__ import annotations

import numpy as np
import pytest

from remanent.analysis.regimes.birkhoff import (
    birkhoff_convergence_digits,
    rotation_numbers,
    weighted_birkhoff_average,
)
from tests.unit.analysis.regimes.iterated import run, standard
from tests.unit.analysis.regimes.spectra import lines, spectrum

GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


def test_weighted_averages_of_a_rotation_converge_beyond_any_power() -> None:
    """Of cos along a rotation by the golden mean: 0, to 12 digits after 2000 steps."""
    angle = 2.0 * np.pi * 0.5 * (np.sqrt(5.0) - 1.0) * np.arange(4000)
    average = weighted_birkhoff_average(np.cos(angle))
    assert abs(float(average)) < 1e-12
    assert float(birkhoff_convergence_digits(np.cos(angle))) > 10.0


def test_weighted_averages_along_chaos_converge_slowly() -> None:
    """Of the logistic map at 4: mean 1/2, a few digits only."""
    x = np.empty(4000)
    x[0] = 0.1234
    for k in range(x.size - 1):
        x[k + 1] = 4.0 * x[k] * (1.0 - x[k])
    assert float(weighted_birkhoff_average(x)) == pytest.approx(0.5, abs=0.03)
    assert float(birkhoff_convergence_digits(x)) < 4.0


def test_a_constant_has_all_digits() -> None:
    """Its spread is zero."""
    assert float(birkhoff_convergence_digits(np.full(100, 0.3))) == 16.0


def test_digits_of_a_torus_and_of_noise() -> None:
    """Averages converge faster than any power on a torus, like n^(-1/2) in noise."""
    n = np.arange(1000)
    torus = np.cos(2 * np.pi * GOLDEN * n) + 0.3 * np.cos(4 * np.pi * GOLDEN * n)
    noise = np.random.default_rng(5).normal(size=1000)
    digits = birkhoff_convergence_digits(np.stack([torus, noise]))
    assert digits[0] > 10.0
    assert digits[1] < 3.0


def test_rotation_number_of_a_twisted_circle() -> None:
    """A rigid rotation seen through a nonlinear change of coordinates, clockwise."""
    n = np.arange(400)
    for turns in (GOLDEN, 0.02, 0.97, 0.52):
        angle = -2.0 * np.pi * (turns * n + 0.1)
        shift = angle + 0.3 * np.sin(angle) + 0.1 * np.cos(2.0 * angle)
        points = np.stack([3.0 + np.cos(shift), 0.01 * np.sin(shift)], axis=1)
        found = rotation_numbers(points[None])
        assert found.turns_per_iterate[0] == pytest.approx(turns, abs=1e-6)
        assert found.converged_digits[0] > 5.0


def test_a_curve_beside_its_centre_has_no_rotation_number() -> None:
    """A circle about 0 does not turn about (3, 0)."""
    n = np.arange(400)
    points = np.stack([np.cos(n), np.sin(n)], axis=1)
    found = rotation_numbers(points[None], centre=np.array([[3.0, 0.0]]))
    assert np.isnan(found.turns_per_iterate[0])
    assert found.converged_digits[0] == 0.0


def test_lines_of_a_spectrum() -> None:
    """Two cosines, 40 dB apart, their frequencies to a millionth of a bin."""
    n = np.arange(500)
    values = 1.0 + np.cos(2 * np.pi * 0.12345 * n + 0.5) + 0.01 * np.cos(2 * np.pi * 0.31 * n)
    found = lines(values, 2)
    np.testing.assert_allclose(found.frequency, [0.12345, 0.31], atol=2e-6)
    np.testing.assert_allclose(found.amplitude, [1.0, 0.01], atol=1e-3)
    assert found.phase[0] == pytest.approx(0.5, abs=1e-2)
    assert found.residual < 2e-3
    frequency, amplitude = spectrum(np.cos(2 * np.pi * 0.25 * np.arange(400)))
    assert frequency[np.argmax(amplitude)] == 0.25
    assert amplitude.max() == pytest.approx(1.0, rel=1e-2)


@pytest.mark.parametrize("start", [0.3, 0.8, 1.2])
def test_rotation_numbers_are_the_frequencies_of_the_strongest_lines(start: float) -> None:
    """Two independent ways to one number: angles about the centre, and a spectrum.

    Tori about the elliptic point of the standard map, at K = 0.5.
    """
    path = run(standard, np.array([np.pi + start, 0.0]), np.array([0.5]), 2000, every=True)
    assert path.visited_states is not None
    y = path.visited_states
    momentum = (y[..., 1] + np.pi) % (2.0 * np.pi) - np.pi
    points = np.stack([y[..., 0] - np.pi, momentum], axis=-1)
    number = rotation_numbers(points).turns_per_iterate[0]
    frequency = lines(momentum[0], 1).frequency[0]
    assert min(number, 1.0 - number) == pytest.approx(frequency, abs=1e-6)


def test_a_slow_rotation_that_steps_back_is_counted_whole() -> None:
    """A change of coordinates that folds back: some angles from point to image are negative.

    A fixed cut at 0 would count each of them as a whole turn.
    """
    angle = -2.0 * np.pi * (0.005 * GOLDEN * np.arange(8000) + 0.1)
    folded = angle + 1.2 * np.sin(angle)
    points = np.stack([np.cos(folded), np.sin(folded)], axis=1)
    found = rotation_numbers(points[None], centre=np.zeros((1, 2)))
    assert found.turns_per_iterate[0] == pytest.approx(0.005 * GOLDEN, abs=1e-7)


def test_errors_of_rotation_numbers_cover_them() -> None:
    """Law: orbits of rotations, seen along ovals, turn by the angle of the rotation.

    Slow angles among them make averages over two parts of an orbit agree by chance; but each
    turns at least once in the run: slower ones no run can tell from none.
    """
    rng = np.random.default_rng(8)
    for _ in range(60):
        count = int(rng.integers(100, 400))
        rho = rng.uniform(0.0, 1.0, 20)
        slowest = np.abs((np.outer(np.arange(1, 13), rho) + 0.5) % 1.0 - 0.5).min(axis=0)
        rho = np.where(slowest * count > 1.0, rho, GOLDEN)
        phase = 2.0 * np.pi * (np.arange(count) * -rho[:, None] + rng.uniform(size=(20, 1)))
        size = 1.0 + rng.uniform(0.0, 0.5, (20, 1)) * np.cos(phase * rng.integers(1, 4))
        points = np.stack([size * np.cos(phase), size * np.sin(phase)], axis=-1)
        found = rotation_numbers(points, np.zeros((20, 2)))
        off = np.abs((found.turns_per_iterate - rho + 0.5) % 1.0 - 0.5)
        assert (off <= found.error + 1e-14).all()


def test_an_orbit_beside_the_centre_has_no_rotation_number() -> None:
    """Law: what swings to and fro turns by nothing, also where it is seen from three sides."""
    phase = 2.0 * np.pi * np.arange(300) * 0.0123
    direction = 0.6 * np.pi * np.cos(phase)
    size = 1.0 + 0.1 * np.sin(phase)
    crescent = np.stack([size * np.cos(direction), size * np.sin(direction)], axis=-1)[None]
    assert np.isnan(rotation_numbers(crescent, np.zeros((1, 2))).turns_per_iterate).all()
