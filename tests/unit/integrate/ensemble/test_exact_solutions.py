"""Solutions known in closed form: a forced line, Duffing's oscillator, the pendulum."""

from __future__ import annotations

import math
from typing import Any

import mpmath
import numpy as np
import pytest
import sympy as sp
from scipy.special import ellipj
from tests.unit.integrate.handmade import SINE, Oscillator, Q, V, problem, sampled

from remanent._status import Status
from remanent._typing import FloatArray
from remanent.integrate.ensemble.attempt import attempt_chunk
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.integrate.ensemble.run import Chunk, Run
from remanent.integrate.kernel.compile import KernelPair, compiled_kernel
from remanent.integrate.kernel.options import KernelOptions, Method
from remanent.integrate.kernel.tables import CycleTables
from remanent.integrate.methods.adams import adams_method
from remanent.integrate.methods.runge_kutta import default_method

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
    """True error <= reported error <= tolerance, at steps and between them.

    Law: Exact solutions.
    """
    oscillator, initial, period, exact = CASES[name]
    asked = problem(oscillator, initial, TIMES[-1], period=period)
    outcome = sampled(asked, TIMES, tolerance)
    assert outcome.states is not None
    assert outcome.status[0] == Status.OK
    assert np.abs(outcome.states[0] - exact).max() <= outcome.error[0] <= tolerance


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
