"""Solutions known in closed form: a forced line, Duffing's oscillator, the pendulum."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.special import ellipj

from remanent._status import Status
from remanent._typing import FloatArray
from remanent.integrate.ensemble.attempt import attempt_chunk
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.integrate.ensemble.run import Chunk, Run
from remanent.integrate.kernel.compile import KernelPair, compiled_kernel
from remanent.integrate.kernel.options import KernelOptions, Method
from remanent.integrate.kernel.outline import MAX_INLINED_INSTRUCTIONS
from remanent.integrate.kernel.tables import CycleTables
from remanent.integrate.methods.adams import adams_method
from remanent.integrate.methods.runge_kutta import default_method
from tests.unit.integrate.handmade import SINE, Oscillator, Q, V, problem, sampled

TIMES = np.linspace(0.0, 50.0, 101)
K, G, A = sp.symbols("k g a")
LINEAR = Oscillator(-K * Q - G * V + A * SINE, {"k": 4.0, "g": 0.1, "a": 1.0})
DUFFING = Oscillator(-Q - sp.Symbol("e") * Q**3, {"e": 2.0})
PENDULUM = Oscillator(-sp.sin(Q), {})
TOLERANCES = [1e-5, 1e-7, 1e-9, 1e-11]


def forced_line(k: float, g: float, a: float, period: float, y0: tuple[float, float]) -> FloatArray:
    """q'' + g q' + k q = a sin(w t), both parts of the solution written out."""
    w = 2.0 * math.pi / period
    denominator = (k - w * w) ** 2 + (g * w) ** 2
    p, r = a * (k - w * w) / denominator, -a * g * w / denominator
    root = math.sqrt(k - g * g / 4.0)
    q0 = y0[0] - r
    v0 = (y0[1] - p * w + 0.5 * g * q0) / root
    decay = np.exp(-0.5 * g * TIMES)
    c, s = np.cos(root * TIMES), np.sin(root * TIMES)
    free = decay * (q0 * c + v0 * s)
    rate = decay * (root * (v0 * c - q0 * s)) - 0.5 * g * free
    sine, cosine = np.sin(w * TIMES), np.cos(w * TIMES)
    return np.stack([p * sine + r * cosine + free, w * (p * cosine - r * sine) + rate], axis=-1)


def duffing(e: float, amplitude: float) -> FloatArray:
    """q = A cn(w t | m) from rest at A: w**2 = 1 + e A**2, m = e A**2 / (2 w**2)."""
    w = math.sqrt(1.0 + e * amplitude**2)
    sn, cn, dn, _ = ellipj(w * TIMES, e * amplitude**2 / (2.0 * w * w))
    return np.stack([amplitude * cn, -amplitude * w * sn * dn], axis=-1)


def pendulum(amplitude: float) -> FloatArray:
    """sin(q/2) = k cd(t | k**2) from rest at the angle A, k = sin(A/2)."""
    with mpmath.workdps(30):
        k = mpmath.sin(mpmath.mpf(amplitude) / 2)
        sn, cn, dn = (
            [mpmath.ellipfun(name, mpmath.mpf(t), m=k * k) for t in TIMES]
            for name in ("sn", "cn", "dn")
        )
        half = [k * c / d for c, d in zip(cn, dn, strict=True)]
        angle = [float(2 * mpmath.asin(x)) for x in half]
        rate = [
            float(-2 * k * (1 - k * k) * s / d**2 / mpmath.sqrt(1 - x * x))
            for s, d, x in zip(sn, dn, half, strict=True)
        ]
    return np.column_stack([angle, rate])


CASES: dict[str, tuple[Oscillator, tuple[float, float], float | None, FloatArray]] = {
    "forced line": (
        LINEAR,
        (0.3, -0.2),
        2.7,
        forced_line(4.0, 0.1, 1.0, 2.7, (0.3, -0.2)),
    ),
    "duffing": (DUFFING, (1.3, 0.0), None, duffing(2.0, 1.3)),
    "pendulum": (PENDULUM, (2.8, 0.0), None, pendulum(2.8)),
}


@pytest.mark.parametrize("tolerance", TOLERANCES)
@pytest.mark.parametrize("name", CASES)
def test_the_requested_tolerance_is_met(name: str, tolerance: float) -> None:
    """Closed forms are met: true error <= reported error <= tolerance, between steps too.

    Law: Exact solutions.
    """
    oscillator, initial, period, exact = CASES[name]
    asked = problem(oscillator, initial, TIMES[-1], period=period)
    outcome = sampled(asked, TIMES, tolerance)
    assert outcome.states is not None
    assert outcome.status[0] == Status.OK
    assert np.abs(outcome.states[0] - exact).max() <= outcome.error[0] <= tolerance


def test_equations_that_are_too_long_to_be_copied_are_solved_as_well() -> None:
    """q'' = -k q, times the mean of forty sums of squares of a sine and a cosine."""
    one = sum(sp.sin(j * Q) ** 2 + sp.cos(j * Q) ** 2 for j in range(1, 41)) / 40
    asked = problem(Oscillator(-K * Q * one, {"k": 4.0}), (0.3, -0.2), 5.0)
    assert len(asked.field.rates.instructions) > MAX_INLINED_INSTRUCTIONS
    outcome = sampled(asked, TIMES[:11], 1e-9)
    assert outcome.states is not None
    exact = 0.3 * np.cos(2.0 * TIMES[:11]) - 0.1 * np.sin(2.0 * TIMES[:11])
    np.testing.assert_allclose(outcome.states[0, :, 0], exact, rtol=0.0, atol=1e-9)


def test_steps_are_no_shorter_than_the_tolerance_needs() -> None:
    """A method of order 8 takes 1e6^(1/8) = 5.6 times as many steps for a millionth of the error.

    Law: Order of the methods.
    """
    asked = problem(DUFFING, (1.3, 0.0), 5.0)
    loose, tight = (sampled(asked, TIMES[:11], t).resolution[0] for t in (1e-5, 1e-11))
    assert 4.0 < tight / loose < 9.0


def test_rounding_puts_no_time_beyond_the_horizon() -> None:
    """A run up to 0.3, asked at 3 times 0.1, which is 0.30000000000000004."""
    asked, times = problem(Oscillator(-Q, {}), (1.0, 0.0), 0.3), 0.1 * np.arange(4.0)
    outcome = sampled(asked, times, 1e-9)
    assert outcome.states is not None
    np.testing.assert_allclose(outcome.states[0, :, 0], np.cos(times), atol=1e-9)
    assert not outcome.is_beyond_horizon(times[None]).any()
    assert outcome.is_beyond_horizon(np.array([[0.3 + 1e-9]])).all()


def test_where_steps_make_no_error_rounding_does() -> None:
    """q'' = -1, of which the method makes no error: no bound below the last place, all cover."""
    rng = np.random.default_rng(0)
    starts, times = rng.uniform(-1.0, 1.0, (64, 2)), np.linspace(0.0, 3.0, 7)
    outcome = sampled(problem(Oscillator(0.0 * Q - 1.0, {}), starts, 3.0), times, 1e-4)
    assert outcome.states is not None
    exact = [
        [(float(q + v * t - t * t / 2), float(v - t)) for t in map(Fraction, times)]
        for q, v in ((Fraction(q), Fraction(v)) for q, v in starts)
    ]
    assert (np.abs(outcome.states - exact).max(axis=(1, 2)) <= outcome.error).all()
    assert (outcome.error >= np.finfo(float).eps).all()


@pytest.mark.parametrize("method", [default_method(), adams_method(8)])
def test_error_falls_with_the_order_of_the_method(method: Method) -> None:
    """The compiled kernels are of order 8 (Runge-Kutta) and 9 (Adams).

    Law: Order of the methods.
    """
    oscillator, initial, period, exact = CASES["forced line"]
    asked = problem(oscillator, initial, TIMES[-1], period=period)
    kernels = KernelPair(
        compiled_kernel(asked.field, default_method(), KernelOptions()),
        compiled_kernel(asked.field, method, KernelOptions()),
    )
    run = Run(
        asked,
        Request(times=TIMES[None]),
        kernels,
        1.0,
        CycleTables(asked.load_schedule.waveforms_at_phase),
    )
    levels = np.array([16, 20, 24, 28, 32])
    errors = []
    for level in levels:
        found = attempt_chunk(run, Chunk(int(level), np.array([0])))
        assert found.states is not None
        errors.append(np.abs(found.states[0] - exact).max())
    slope = np.polyfit(np.log(levels), np.log(errors), 1)[0]
    assert slope == pytest.approx(-method.order, abs=0.2)


def test_extremes_between_steps_are_those_of_the_solution() -> None:
    """Of A cn(w t) they are A and -A, and in a window without a turn those of its ends."""
    asked = problem(DUFFING, [(1.3, 0.0)] * 2, [50.0, 0.4])
    outcome = integrate(
        asked, Request(wants_extremes=True, extremes_begin=np.array([0.0, 0.1])), tolerance=1e-10
    )
    w = math.sqrt(1.0 + 2.0 * 1.69)
    cn = ellipj(w * np.array([0.1, 0.4]), 1.69 / w**2)[1]
    expected_max, expected_min = [1.3, 1.3 * cn[0]], [-1.3, 1.3 * cn[1]]
    assert (np.abs(outcome.maximum - expected_max) <= outcome.error + 1e-14).all()
    assert (np.abs(outcome.minimum - expected_min) <= outcome.error + 1e-14).all()
    assert (outcome.error <= 1e-10).all()


@pytest.mark.parametrize("tolerance", [1e-7, 1e-8, 1e-9])
def test_errors_of_extremes_are_known_to_a_small_factor(tolerance: float) -> None:
    """Of forced lines, stiff and soft: at most six times the true error in most, never below it.

    The extremes of the other method, at a much smaller tolerance, stand for the true ones.
    """
    count, rng = 48, np.random.default_rng(3)
    parameters = {"k": rng.uniform(1.0, 30.0, count), "g": rng.uniform(0.0, 0.4, count)}
    start = rng.uniform(-1.0, 1.0, (count, 2))
    asked = problem(LINEAR, start, np.full(count, 40.0), period=2.7, **parameters)
    window = Request(wants_extremes=True, extremes_begin=np.full(count, 20.0))
    outcome, exact = (integrate(asked, window, tolerance=t) for t in (tolerance, 1e-13))
    true = np.maximum(abs(outcome.maximum - exact.maximum), abs(outcome.minimum - exact.minimum))
    assert (outcome.error >= true).all()
    assert np.median(outcome.error / true) <= 6.0


@pytest.mark.parametrize("tolerance", [1e-6, 1e-11])
def test_extremes_count_from_the_start(tolerance: float) -> None:
    """Of A cn(w t) over less than a quarter of a turn: A at once, and the least at the end."""
    asked = problem(DUFFING, (1.3, 0.0), 0.4)
    outcome = integrate(asked, Request(wants_extremes=True), tolerance=tolerance)
    w = math.sqrt(1.0 + 2.0 * 1.69)
    least = 1.3 * ellipj(w * 0.4, 1.69 / w**2)[1]
    assert abs(outcome.maximum[0] - 1.3) <= outcome.error[0] + 1e-14
    assert abs(outcome.minimum[0] - least) <= outcome.error[0] + 1e-14
    np.testing.assert_allclose([outcome.maximum_time, outcome.minimum_time], [[0.0], [0.4]])


@pytest.mark.parametrize("tolerance", [1e-6, 1e-11])
def test_extremes_of_what_becomes_infinite_have_no_horizon_beyond(tolerance: float) -> None:
    """q'' = 6 q^2 from (1, 2) is 1/(1 - t)^2: it never turns, and is infinite at t = 1."""
    asked = problem(Oscillator(6 * Q**2, {}), (1.0, 2.0), 3.0)
    outcome = integrate(asked, Request(wants_extremes=True), tolerance=tolerance)
    assert 0.9 < outcome.horizon[0] < 1.0
    assert np.isnan(outcome.maximum[0])


def test_strobe_takes_the_state_after_whole_cycles() -> None:
    """Strobed states are those at multiples of the period, counted, for any stride."""
    asked = problem(LINEAR, (0.3, -0.2), 60 * 2.7, period=2.7)
    every = integrate(asked, Request(strobe_cycles=1), tolerance=1e-10).states
    assert every is not None
    assert every.shape == (1, 61, 2)
    for stride in (2, 3, 7, 60):
        some = integrate(asked, Request(strobe_cycles=stride), tolerance=1e-10).states
        assert some is not None
        np.testing.assert_allclose(some[0], every[0, ::stride], rtol=0, atol=2e-10)
    exact = forced_line(4.0, 0.1, 1.0, 2.7, (0.3, -0.2))
    start: Any = exact[0]
    np.testing.assert_allclose(every[0, 0], start, rtol=0, atol=1e-15)
