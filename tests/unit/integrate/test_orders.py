"""The order of every kernel, of states between steps and of extremes between steps.

Law: Order of the methods.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from tests.unit.integrate.handmade import Oscillator, Q, V, problem

from remanent._typing import FloatArray
from remanent.integrate.ensemble.attempt import attempt
from remanent.integrate.ensemble.problem import Problem, Request
from remanent.integrate.ensemble.run import Attempt, Chunk, Run
from remanent.integrate.kernel.compile import Kernels, compiled
from remanent.integrate.kernel.extrema import TimeDerivatives, hermite_coefficients, horner
from remanent.integrate.kernel.options import Method, Options
from remanent.integrate.kernel.tables import CycleTables
from remanent.integrate.methods.adams import adams
from remanent.integrate.methods.runge_kutta import cooper_verner_8, default_method

WITHIN = 0.2
METHODS = [default_method(), adams(8)]


def order(levels: Any, errors: Any) -> float:
    """Slope of the straight line through the logarithms."""
    return float(-np.polyfit(np.log(levels), np.log(np.array(errors, dtype=float)), 1)[0])


def attempted(asked: Problem, request: Request, method: Method, level: int) -> Attempt:
    """One attempt at a resolution, whatever its error."""
    options = Options(extremes=request.extremes)
    kernels = Kernels(
        compiled(asked.field, default_method(), options), compiled(asked.field, method, options)
    )
    run = Run(asked, request, kernels, 1.0, CycleTables(asked.timeline.waveform))
    return attempt(run, Chunk(level, np.arange(asked.duration.size)))


#: A round limit cycle of radius 1: nonlinear, attracting, and as smooth as its solution,
#: cos t, so that errors follow the order at steps long enough for double precision.
CYCLE = Oscillator(-Q + (1 - Q**2 - V**2) * V / 2, {})
TIMES = np.linspace(0.0, 10.0, 41)
EXACT = np.column_stack([np.cos(TIMES), -np.sin(TIMES)])
LEVELS = np.array([10, 12, 14, 16, 20])


@pytest.mark.parametrize("method", METHODS, ids=lambda m: m.name)
def test_order_of_the_kernels(method: Method) -> None:
    """States at and between the steps of a nonlinear motion, order 8 or 9 within 0.2.

    Law: Order of the methods.
    """
    asked = problem(CYCLE, (1.0, 0.0), TIMES[-1])
    errors = []
    for level in LEVELS:
        states = attempted(asked, Request(times=TIMES[None]), method, int(level)).states
        errors.append(np.abs(states - EXACT).max())
    assert min(errors) > 5e-14
    assert order(LEVELS, errors) == pytest.approx(method.order, abs=WITHIN)


@pytest.mark.parametrize("method", METHODS, ids=lambda m: m.name)
def test_order_of_the_error_estimate(method: Method) -> None:
    """Order of the methods: the difference of the two solutions shrinks with the order too."""
    asked = problem(CYCLE, (1.0, 0.0), TIMES[-1])
    bounds = [attempted(asked, Request(), method, int(n)).largest_error[0] for n in LEVELS]
    assert order(LEVELS, bounds) == pytest.approx(method.order, abs=WITHIN)


@pytest.mark.parametrize("method", METHODS, ids=lambda m: m.name)
def test_order_of_extremes(method: Method) -> None:
    """The extremes of the cycle, 1 and -1, from many phases, between steps.

    Law: Order of the methods.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, 32)
    asked = problem(CYCLE, np.column_stack([np.cos(angles), -np.sin(angles)]), 10.0)
    errors = []
    for level in LEVELS:
        found = attempted(asked, Request(extremes=True), method, int(level))
        errors.append(np.abs([found.maximum - 1.0, found.minimum + 1.0]).max())
    assert order(LEVELS, errors) == pytest.approx(method.order, abs=WITHIN)


def hermite_error(function: Callable[[Any], Any], centre: float, h: Any) -> Any:
    """Largest error between the nodes of the polynomial through three instants."""
    left, middle, right = [
        TimeDerivatives(function(t), mpmath.diff(function, t), mpmath.diff(function, t, 2))
        for t in (centre - h, mpmath.mpf(centre), centre + h)
    ]
    polynomial = hermite_coefficients(left, middle, right, h)
    places = [mpmath.mpf(s) for s in (-0.71, -0.3, 0.52, 0.9)]
    return max(abs(horner(polynomial, s) - function(centre + s * h)) for s in places)


def test_order_of_the_polynomial_between_steps() -> None:
    """Order of the methods: extremes between steps err by O(h**9), in fifty digits."""
    with mpmath.workdps(50):
        steps = [mpmath.mpf(2) ** -k for k in range(3, 8)]
        errors = [hermite_error(lambda t: mpmath.exp(mpmath.sin(t)), 0.4, h) for h in steps]
    assert order([1 / float(h) for h in steps], errors) == pytest.approx(9.0, abs=WITHIN)


def local_errors(part: Any, steps: list[Any]) -> list[Any]:
    """Errors of y' = y cos t after a step of length part * h from t = 0.3."""
    method = cooper_verner_8(mpmath.sqrt, mpmath.mpf)
    begin = mpmath.mpf("0.3")
    errors = []
    for h in steps:
        length = part * h

        def rates(node: int, y: list[Any], length: Any = length) -> list[Any]:
            return [y[0] * mpmath.cos(begin + method.nodes[node] * length)]

        exact = mpmath.exp(mpmath.sin(begin + length) - mpmath.sin(begin))
        errors.append(abs(method.step(rates, [mpmath.mpf(1)], length)[0] - exact))
    return errors


@pytest.mark.parametrize("part", [0.1, 0.5, 0.9, 1.0])
def test_order_of_a_step_in_fifty_digits(part: float) -> None:
    """Whole steps, and the shorter ones that give states between them: O(h**9).

    Law: Order of the methods.
    """
    with mpmath.workdps(50):
        steps = [mpmath.mpf(2) ** -k for k in range(4, 9)]
        errors = local_errors(mpmath.mpf(part), steps)
    assert order([1 / float(h) for h in steps], errors) == pytest.approx(9.0, abs=WITHIN)


def test_coefficients_of_adams_are_the_published_ones() -> None:
    """The Adams-Bashforth formula of order 8 and the next term of its series.

    Law: Order of the methods.
    """
    numerators = [434241, -1152169, 2183877, -2664477, 2102243, -1041723, 295767, -36799]
    published = [float(Fraction(n, 120960)) for n in numerators]
    np.testing.assert_allclose(adams(8).single, published, rtol=1e-15)
    assert adams(8).single_correction == float(Fraction(1070017, 3628800))


def test_the_next_terms_are_integrals_of_newtons_polynomial() -> None:
    """The integral of s (s + 1) ... (s + 7)/8! over a step, and its double integral.

    Law: Order of the methods.
    """

    def newton(s: Any) -> Any:
        return mpmath.rf(s, 8) / mpmath.factorial(8)

    single = mpmath.quad(newton, [0, 1])
    double = mpmath.quad(lambda s: (1 - s) * newton(s), [0, 1])
    assert adams(8).single_correction == pytest.approx(float(single), rel=1e-14)
    assert adams(8).double_correction == pytest.approx(float(double), rel=1e-14)


def adams_march(steps: int) -> Any:
    """Error of the limit cycle after 2 units of time, in fifty digits, from exact past rates.

    The formulas of the kernel are written out once more; its rounded weights are quotients
    of integers below 10**8, which are found again.
    """
    method, number = adams(8), mpmath.mpf

    def exact(weights: Any) -> list[Any]:
        parts = [Fraction(w).limit_denominator(10**8) for w in weights]
        return [number(p.numerator) / p.denominator for p in parts]

    single, double, difference = map(exact, (method.single, method.double, method.difference))
    correction = exact([method.double_correction, method.single_correction])
    h = number(2) / steps
    q, v = mpmath.cos(7 * h), -mpmath.sin(7 * h)
    past = [-mpmath.cos(j * h) for j in range(7, -1, -1)]
    for _ in range(steps - 7):
        guess = q + h * (v + h * mpmath.fdot(double, past)), v + h * mpmath.fdot(single, past)
        surprise = acceleration(*guess) + mpmath.fdot(difference, past)
        q, v = guess[0] + h * h * surprise * correction[0], guess[1] + h * surprise * correction[1]
        past = [acceleration(q, v), *past[:-1]]
    return max(abs(q - mpmath.cos(2)), abs(v + mpmath.sin(2)))


def acceleration(q: Any, v: Any) -> Any:
    """Of the limit cycle."""
    return -q + (1 - q * q - v * v) * v / 2


def test_order_of_adams_in_fifty_digits() -> None:
    """Order of the methods: the formulas of the kernel are of order 9, with exact weights."""
    levels = [100, 200, 400]
    with mpmath.workdps(50):
        errors = [adams_march(n) for n in levels]
    assert max(errors) < 1e-12
    assert order(levels, errors) == pytest.approx(9.0, abs=WITHIN)


def test_the_polynomial_is_exact_for_its_degree() -> None:
    """Every power up to 8 is reproduced, so the error begins with the ninth.

    Law: Order of the methods.
    """
    h = 0.5
    for power in range(10):
        left, middle, right = [
            TimeDerivatives(
                s**power,
                power * s ** max(power - 1, 0),
                power * (power - 1) * s ** max(power - 2, 0),
            )
            for s in (-h, 0.0, h)
        ]
        found: FloatArray = np.array(hermite_coefficients(left, middle, right, h))
        exact = np.zeros(9)
        if power < 9:
            exact[power] = h**power
            np.testing.assert_allclose(found, exact, rtol=0, atol=1e-13)
        else:
            assert np.abs(found).max() > 1e-4
