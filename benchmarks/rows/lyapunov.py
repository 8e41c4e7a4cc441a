"""A map of Lyapunov exponents beside pynamicalsys on some of its points."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

import remanent as rm
from benchmarks.machine import one_core
from benchmarks.rows.plan import Plan

_PERIODS, _SIDE, _SAMPLE, _TOLERANCE = 500, 128, 6, 1e-8
_THETA = 350.0 / 293.0
_OMEGA, _B = (0.8, 2.0), (0.2, 1.2)


def measure(plan: Plan) -> dict[str, Any]:
    """Microseconds of processor time per trajectory and unit of tau."""
    side = 32 if plan.quick else _SIDE
    omega, b = np.linspace(*_OMEGA, side), np.linspace(*_B, side)
    hot, drive = rm.Actuator(temperature=350.0), rm.SineSquared(0.4, 1.0)
    with one_core():
        rm.lyapunov(hot, drive, periods=50, over={"omega": omega[:4]}, tolerance=_TOLERANCE)
        begin = time.process_time()
        ds = rm.lyapunov(hot, drive, periods=_PERIODS, over={"omega": omega, "b": b},
                         tolerance=_TOLERANCE)  # fmt: skip
        spent = time.process_time() - begin
        total = float((_PERIODS * np.pi / omega).sum() * side)
        ours = 1e6 * spent / total
        plan.say(f"lyapunov: {side} x {side}: {ours:.3g} µs")
        peer = _pynamicalsys(omega, b, plan)
    known = ds.exponent_error.where(np.isfinite(ds.exponent_error))
    return {
        "side": side,
        "microseconds": ours,
        "peer": peer,
        "error": float(known.median()),
    }


def _pynamicalsys(omega: Any, b: Any, plan: Plan) -> dict[str, Any] | None:
    """The same exponents of points drawn at random, where it is installed."""
    try:
        import numba
        from pynamicalsys import ContinuousDynamicalSystem
    except ImportError:
        return None

    @numba.njit  # type: ignore[untyped-decorator,unused-ignore]
    def rates(tau: float, u: Any, p: Any) -> Any:
        x, v = u[0], u[1]
        load = p[1] * np.sin(p[0] * tau)
        x2 = x * x
        x4 = x2 * x2
        force = _THETA * (x4 * x4 - x2) + load * load * x4
        return np.array([v, (6.0 * v * v - 3.0 * force) / (x4 * x2 * x + 2.0 * x)])

    @numba.njit  # type: ignore[untyped-decorator,unused-ignore]
    def jacobian(tau: float, u: Any, p: Any) -> Any:
        x, v = u[0], u[1]
        load = p[1] * np.sin(p[0] * tau)
        m = load * load
        top = 6.0 * v * v - 3.0 * (_THETA * (x**8 - x * x) + m * x**4)
        bottom = x**7 + 2.0 * x
        by_x = -3.0 * (_THETA * (8.0 * x**7 - 2.0 * x) + 4.0 * m * x**3)
        out = np.zeros((2, 2))
        out[0, 1] = 1.0
        out[1, 0] = (by_x - top * (7.0 * x**6 + 2.0) / bottom) / bottom
        out[1, 1] = 12.0 * v / bottom
        return out

    system = ContinuousDynamicalSystem(
        equations_of_motion=rates, jacobian=jacobian, system_dimension=2, number_of_parameters=2
    )
    system.integrator("rk45", atol=_TOLERANCE, rtol=_TOLERANCE)
    rng = np.random.default_rng(1)
    points = np.column_stack([rng.choice(omega, _SAMPLE), rng.choice(b, _SAMPLE)])
    system.lyapunov([1.0, 0.0], 10.0, parameters=points[0], num_exponents=1)
    begin, total = time.process_time(), 0.0
    for w, strength in points:
        length = _PERIODS * np.pi / w
        system.lyapunov([1.0, 0.0], length, parameters=[w, strength], num_exponents=1)
        total += length
    from importlib.metadata import version

    spent = 1e6 * (time.process_time() - begin) / total
    plan.say(f"lyapunov: pynamicalsys: {spent:.3g} µs")
    return {"microseconds": spent, "version": version("pynamicalsys"), "points": _SAMPLE}
