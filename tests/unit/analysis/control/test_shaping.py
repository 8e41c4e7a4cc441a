"""Steps after which linear systems are at rest, and when sampled answers pass levels."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import expm

from remanent._typing import FloatArray
from remanent.analysis.control import settling, shaping


def test_known_shapers() -> None:
    """An undamped pair: 1/2, 1/2, and 1/4, 1/2, 1/4 for a double root."""
    pair = np.array([2.0j, -2.0j])
    spacing = shaping.default_impulse_spacing(pair)
    assert spacing == pytest.approx(np.pi / 2.0)
    np.testing.assert_allclose(
        shaping.zero_vibration_impulse_amplitudes(pair, spacing), [0.5, 0.5], atol=1e-15
    )
    np.testing.assert_allclose(
        shaping.zero_vibration_impulse_amplitudes(pair, spacing, 2), [0.25, 0.5, 0.25], atol=1e-15
    )


@pytest.mark.parametrize("seed", range(5))
def test_a_linear_system_is_at_rest_after_its_steps(seed: int) -> None:
    """y' = a y + b u, integrated exactly over the steps, ends at its equilibrium."""
    rng = np.random.default_rng(seed)
    a = rng.normal(size=(5, 5)) - 3.0 * np.eye(5)
    b = rng.normal(size=5)
    found = shaping.controllable_poles(a, b)
    spacing = 0.4 * shaping.default_impulse_spacing(found)
    parts = shaping.zero_vibration_impulse_amplitudes(found, spacing)
    rest = -np.linalg.solve(a, b)
    y: FloatArray = np.zeros(5)
    for u in np.cumsum(parts)[:-1]:
        y = u * rest + expm(a * spacing) @ (y - u * rest)
    np.testing.assert_allclose(y, rest, rtol=1e-6, atol=1e-9)


def test_poles_that_the_input_does_not_reach_are_left_out() -> None:
    """Of two equal oscillators the input moves one combination only."""
    one = np.array([[0.0, 1.0], [-9.0, 0.0]])
    both = np.kron(np.eye(2), one)
    found = shaping.controllable_poles(both, np.array([0.0, 1.0, 0.0, 1.0]))
    np.testing.assert_allclose(sorted(found.imag), [-3.0, 3.0])


def test_exact_steps_of_a_pendulum() -> None:
    """x'' + x = u: the answer to a unit move is 1/2 for pi, from a guess far off."""

    def arrive(loads: FloatArray, durations: FloatArray) -> tuple[FloatArray, ...]:
        (u,), (t,) = loads, durations
        away = np.array([u * (1 - np.cos(t)) - 1.0, u * np.sin(t)])
        return (
            away,
            np.array([[1 - np.cos(t)], [np.sin(t)]]),
            np.array([[u * np.sin(t)], [u * np.cos(t)]]),
        )

    guess = shaping.StepSequence(np.array([0.7]), np.array([2.4]))
    found = shaping.solve_step_sequence(arrive, guess, scale=1.0, tolerance=1e-9)  # type: ignore[arg-type]
    np.testing.assert_allclose([found.loads[0], found.durations[0]], [0.5, np.pi], atol=1e-12)
    assert found.largest_terminal_residual < 1e-12


def test_passages_of_a_damped_sine() -> None:
    """Rise and settling of 1 - exp(-t/5) cos t, against roots of the formula."""

    def answer(t: FloatArray) -> tuple[FloatArray, FloatArray]:
        e = np.exp(-t / 5.0)
        return 1.0 - e * np.cos(t), e * (np.sin(t) + np.cos(t) / 5.0)

    turns = np.pi * np.arange(1, 10) - np.arctan(0.2)
    times = np.concatenate([[0.0], turns, [30.0]])[None]
    share = answer(times)[0]
    last = settling.last_node_outside(share, np.array([[0.95]]), np.array([[1.05]]))
    first = settling.way_to_level(share, np.array([[0.5]]))
    levels = np.array([[0.5, 1.05 if share[0, last[0, 0]] > 1.0 else 0.95]])
    before = np.concatenate([first, last], axis=1)
    start, end = (np.take_along_axis(times, before + k, axis=1) for k in (0, 1))
    rising = np.sign(np.diff(share[0]))[before]
    found = settling.locate_level_crossings(answer, start, end, levels, rising)
    np.testing.assert_allclose(answer(found.time)[0], levels, atol=1e-13)
    dense = np.linspace(0.0, 30.0, 3_000_001)
    away = np.flatnonzero(np.abs(answer(dense)[0] - 1.0) > 0.05)[-1]
    assert found.time[0, 1] == pytest.approx(dense[away], abs=2e-5)
    assert settling.way_to_level(share, np.array([[3.0]]))[0, 0] == -1


def test_the_error_of_a_sequence_is_what_errors_of_its_conditions_make_of_it() -> None:
    """Conditions wrong by up to the tolerance change the duration by no more than the error."""
    guess = shaping.StepSequence(np.array([0.6]), np.array([3.0]))

    def solution(wrong: FloatArray) -> shaping.StepSequence:
        def arrive(
            loads: FloatArray, durations: FloatArray
        ) -> tuple[FloatArray, FloatArray, FloatArray]:
            (u,), (t,) = loads, durations
            away = np.array([u * (1 - np.cos(t)) - 1.0, u * np.sin(t)]) + wrong
            by_load = np.array([[1 - np.cos(t)], [np.sin(t)]])
            return away, by_load, np.array([[u * np.sin(t)], [u * np.cos(t)]])

        return shaping.solve_step_sequence(arrive, guess, scale=1.0, tolerance=1e-4)

    exact = solution(np.zeros(2))
    corners = 1e-4 * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    changes = [abs(solution(c).durations.sum() - exact.durations.sum()) for c in corners]
    assert max(changes) == pytest.approx(exact.total_duration_error, rel=0.01)
