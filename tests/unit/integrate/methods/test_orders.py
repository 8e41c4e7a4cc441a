"""The order of every kernel, of its error estimate and of extremes between steps.

Law: Order of the methods.
"""

from __future__ import annotations

import numpy as np
import pytest

from remanent.integrate.ensemble.attempt import attempt_chunk
from remanent.integrate.ensemble.problem import Problem, Request
from remanent.integrate.ensemble.run import Attempt, Chunk, Run
from remanent.integrate.kernel.compile import KernelPair, compiled_kernel
from remanent.integrate.kernel.options import KernelOptions, Method
from remanent.integrate.kernel.tables import CycleTables
from remanent.integrate.methods.adams import adams_method
from remanent.integrate.methods.runge_kutta import default_method
from tests.unit.integrate.handmade import Oscillator, Q, V, problem
from tests.unit.integrate.observed_order import WITHIN, order

METHODS = [default_method(), adams_method(8)]


def attempted(asked: Problem, request: Request, method: Method, level: int) -> Attempt:
    """One attempt at a resolution, whatever its error."""
    options = KernelOptions(follows_extremes=request.wants_extremes)
    kernels = KernelPair(
        compiled_kernel(asked.field, default_method(), options),
        compiled_kernel(asked.field, method, options),
    )
    run = Run(asked, request, kernels, 1.0, CycleTables(asked.load_schedule.waveforms_at_phase))
    return attempt_chunk(run, Chunk(level, np.arange(asked.duration.size)))


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
    """The extremes of the cycle, 1 and -1, from many phases, between steps: at least of the order.

    Errors of the phase do not enter, and of Adams' errors of the amplitude terms of several orders
    are equally large at these steps.

    Law: Order of the methods.
    """
    angles = np.linspace(0.0, 2.0 * np.pi, 32)
    asked = problem(CYCLE, np.column_stack([np.cos(angles), -np.sin(angles)]), 10.0)
    errors = []
    for level in LEVELS:
        found = attempted(asked, Request(wants_extremes=True), method, int(level))
        errors.append(np.abs([found.maximum - 1.0, found.minimum + 1.0]).max())
    assert max(errors) < 1e-10
    assert order(LEVELS, errors) > method.order - WITHIN
