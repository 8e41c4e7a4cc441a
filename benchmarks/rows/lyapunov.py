"""A map of Lyapunov exponents beside pynamicalsys on some of its points."""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.machine import one_core
from benchmarks.rows.plan import Plan
from remanent._typing import FloatArray
from remanent.integrate.maps.period_map import PeriodMap
from remanent.studies.ensemble.layout import lay_out
from remanent.studies.ensemble.problem import initial_value_problem

_PERIODS, _SIDE, _SAMPLE = 500, 256, 6
_THETA = 350.0 / 293.0
_OMEGA, _B = (0.8, 2.0), (0.2, 1.2)
#: Each program gets the loosest tolerance with which one period of these many is so exact.
_ACHIEVED, _STARTS = 1e-7, 64
_TOLERANCES = 10.0 ** -np.arange(4.0, 12.0, 0.5)


def measure(plan: Plan) -> dict[str, Any]:
    """Microseconds of processor time per trajectory and unit of tau."""
    side = 32 if plan.quick else _SIDE
    omega, b = np.linspace(*_OMEGA, side), np.linspace(*_B, side)
    hot, drive = rm.Actuator(temperature=350.0), rm.SineSquared(0.4, 1.0)
    starts = _starts(hot, drive)
    tolerance, worst = _loosest(_ours(hot, drive, starts), _exact(starts))
    with one_core():
        rm.lyapunov(hot, drive, periods=50, over={"omega": omega[:4]}, tolerance=tolerance)
        begin = time.process_time()
        ds = rm.lyapunov(hot, drive, periods=_PERIODS, over={"omega": omega, "b": b},
                         tolerance=tolerance)  # fmt: skip
        spent = time.process_time() - begin
        total = float((_PERIODS * np.pi / omega).sum() * side)
        ours = 1e6 * spent / total
        plan.say(f"lyapunov: {side} x {side}, tolerance {tolerance:.0e}: {ours:.3g} µs")
        peer = _pynamicalsys(omega, b, starts, plan)
    known = ds.exponent_error.where(np.isfinite(ds.exponent_error))
    return {
        "side": side,
        "microseconds": ours,
        "tolerance": tolerance,
        "worst": worst,
        "peer": peer,
        "error": float(known.median()),
    }


def _starts(hot: rm.Actuator, drive: rm.SineSquared) -> dict[str, FloatArray]:
    """States on motions from rest, with their loads."""
    rng = np.random.default_rng(2)
    omega, b = rng.uniform(*_OMEGA, _STARTS), rng.uniform(*_B, _STARTS)
    over = {"omega": xr.DataArray(omega, dims="case"), "b": xr.DataArray(b, dims="case")}
    ds = rm.poincare_section(hot, drive, periods=50, over=over)
    last = ds.isel(period=-1)
    return {"omega": omega, "b": b, "x": last.stretch.values, "v": last.stretch_rate.values}


def _exact(starts: dict[str, FloatArray]) -> Callable[[FloatArray], FloatArray]:
    """States at given times, by SciPy at the best of double precision."""
    from scipy.integrate import solve_ivp

    def at(times: FloatArray) -> FloatArray:
        found = []
        for omega, b, x, v, end in zip(*starts.values(), times, strict=True):

            def rates(tau: float, u: Any, omega: float = omega, b: float = b) -> list[float]:
                return _rates(tau, u, (omega, b))

            run = solve_ivp(rates, (0.0, end), [x, v], method="DOP853", rtol=1e-13, atol=1e-15)
            found.append(run.y[:, -1])
        return np.array(found)

    return at


def _loosest(period: Callable[[float], tuple[FloatArray, FloatArray]],
             exact: Callable[[FloatArray], FloatArray]) -> tuple[float, float]:  # fmt: skip
    """The loosest tolerance that is good enough, and the largest error with it."""
    for tolerance in _TOLERANCES.tolist():
        states, times = period(tolerance)
        worst = float(np.abs(states - exact(times)).max())
        if worst <= _ACHIEVED:
            return tolerance, worst
    raise RuntimeError("no tolerance is good enough")


def _ours(
    hot: rm.Actuator, drive: rm.SineSquared, starts: dict[str, FloatArray]
) -> Callable[[float], tuple[FloatArray, FloatArray]]:
    over = {name: xr.DataArray(starts[name], dims="case") for name in ("omega", "b")}
    asked = initial_value_problem(lay_out(hot, drive, over), np.ones(_STARTS))
    flow = PeriodMap(asked.field, asked.timeline.waveform, directions=1, error_control="state")
    states, length = np.column_stack([starts["x"], starts["v"]]), np.pi / starts["omega"]

    def period(tolerance: float) -> tuple[FloatArray, FloatArray]:
        return flow(states, asked.parameters, length, tolerance=tolerance).state, length

    return period


def _rates(tau: float, u: Any, p: Any) -> list[float]:
    """Equation (16) at 350 K without prestress, in one quotient."""
    x, v = u
    load = p[1] * np.sin(p[0] * tau)
    x2 = x * x
    x4 = x2 * x2
    force = _THETA * (x4 * x4 - x2) + load * load * x4
    return [v, (6.0 * v * v - 3.0 * force) / (x4 * x2 * x + 2.0 * x)]


def _pynamicalsys(
    omega: FloatArray, b: FloatArray, starts: dict[str, FloatArray], plan: Plan
) -> dict[str, Any] | None:
    """The same exponents of points drawn at random, where it is installed."""
    try:
        import numba
        from pynamicalsys import ContinuousDynamicalSystem
    except ImportError:
        return None
    plain = numba.njit(_rates)

    @numba.njit  # type: ignore[untyped-decorator,unused-ignore]
    def rates(tau: float, u: Any, p: Any) -> Any:
        return np.array(plain(tau, (u[0], u[1]), p))

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

    def period(tolerance: float) -> tuple[FloatArray, FloatArray]:
        system.integrator("rk45", atol=tolerance, rtol=tolerance)
        ends = np.array([
            system.trajectory(np.array([x, v]), np.pi / w, parameters=np.array([w, strength]))[-1]
            for w, strength, x, v in zip(*starts.values(), strict=True)
        ])  # fmt: skip
        return ends[:, 1:], ends[:, 0]

    tolerance, worst = _loosest(period, _exact(starts))
    system.integrator("rk45", atol=tolerance, rtol=tolerance)
    rng = np.random.default_rng(1)
    points = np.column_stack([rng.choice(omega, _SAMPLE), rng.choice(b, _SAMPLE)])
    system.lyapunov([1.0, 0.0], 10.0, parameters=points[0], num_exponents=1)
    begin, total = time.process_time(), 0.0
    for w, strength in points:
        length = _PERIODS * np.pi / w
        system.lyapunov([1.0, 0.0], length, parameters=[w, strength], num_exponents=1)
        total += length
    spent = 1e6 * (time.process_time() - begin) / total
    plan.say(f"lyapunov: pynamicalsys, tolerance {tolerance:.0e}: {spent:.3g} µs")
    return {
        "microseconds": spent,
        "version": version("pynamicalsys"),
        "points": _SAMPLE,
        "tolerance": tolerance,
        "worst": worst,
    }
