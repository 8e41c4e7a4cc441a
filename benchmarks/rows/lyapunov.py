"""A map of Lyapunov exponents beside pynamicalsys on some of its points.

Measured is the processor time per trajectory and unit of dimensionless time, in microseconds.
Each program has the loosest tolerance with which one period of the load, from 64 states on
such motions, ends within 1e-7 of what SciPy finds at 1e-13.  Ours runs everything once more
with steps twice as long, to give the error of an exponent.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.jobs import REFERENCE_TEMPERATURE
from benchmarks.machine import one_core
from benchmarks.rows.plan import Plan
from benchmarks.tools import pynamicalsys_rk45
from remanent._typing import FloatArray
from remanent.integrate.maps.period_map import PeriodMap
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem

#: Drive periods over which exponents are averaged.
_PERIODS = 500
#: Points along each side of the map.
_SIDE = 256
#: The same in a quick run.
_QUICK_SIDE = 32
#: Points of the map that pynamicalsys computes, drawn at random.
_SAMPLE = 6
#: Temperature, kelvin.
_TEMPERATURE = 350.0
#: Temperature over that of the reference configuration.
_THETA = _TEMPERATURE / REFERENCE_TEMPERATURE
#: Drive frequencies of the map.
_OMEGA = (0.8, 2.0)
#: Roots of the peak load of the map.
_B = (0.2, 1.2)
#: Largest error of the state after one period that a tolerance may give.
_LIMIT = 1e-7
#: States from which that period starts.
_STARTS = 64
#: Drive periods from rest after which those states are taken.
_PERIODS_TO_STARTS = 50
#: Relative tolerance of SciPy as the reference.
_REFERENCE_RTOL = 1e-13
#: Absolute tolerance of SciPy as the reference.
_REFERENCE_ATOL = 1e-15
#: Tolerances that are tried, loosest first.
_TOLERANCES = 10.0 ** -np.arange(4.0, 12.0, 0.5)


def measure(plan: Plan) -> dict[str, Any]:
    """Microseconds of processor time per trajectory and unit of tau."""
    side = _QUICK_SIDE if plan.quick else _SIDE
    omega, b = np.linspace(*_OMEGA, side), np.linspace(*_B, side)
    hot, drive = rm.Actuator(temperature=_TEMPERATURE), rm.SineSquared(0.4, 1.0)
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
    exponent_error = ds.exponent_error.where(np.isfinite(ds.exponent_error))
    return {
        "side": side,
        "microseconds": ours,
        "tolerance": tolerance,
        "worst": worst,
        "peer": peer,
        "error": float(exponent_error.median()),
    }


def _starts(hot: rm.Actuator, drive: rm.SineSquared) -> dict[str, FloatArray]:
    """States on motions from rest, with their loads."""
    rng = np.random.default_rng(2)
    omega, b = rng.uniform(*_OMEGA, _STARTS), rng.uniform(*_B, _STARTS)
    over = {"omega": xr.DataArray(omega, dims="case"), "b": xr.DataArray(b, dims="case")}
    ds = rm.poincare_section(hot, drive, periods=_PERIODS_TO_STARTS, over=over)
    last = ds.isel(period=-1)
    return {"omega": omega, "b": b, "x": last.stretch.values, "v": last.stretch_rate.values}


def _exact(starts: dict[str, FloatArray]) -> Callable[[FloatArray], FloatArray]:
    """States at given times, by SciPy at the best of double precision."""
    from scipy.integrate import solve_ivp

    def at(times: FloatArray) -> FloatArray:
        ends = []
        for omega, b, x, v, end in zip(*starts.values(), times, strict=True):

            def rates(tau: float, u: Any, omega: float = omega, b: float = b) -> list[float]:
                return _rates(tau, u, (omega, b))

            run = solve_ivp(
                rates, (0.0, end), [x, v], method="DOP853",
                rtol=_REFERENCE_RTOL, atol=_REFERENCE_ATOL,
            )  # fmt: skip
            ends.append(run.y[:, -1])
        return np.array(ends)

    return at


def _loosest(period: Callable[[float], tuple[FloatArray, FloatArray]],
             exact: Callable[[FloatArray], FloatArray]) -> tuple[float, float]:  # fmt: skip
    """The loosest tolerance that is good enough, and the largest error with it."""
    for tolerance in _TOLERANCES.tolist():
        states, times = period(tolerance)
        worst = float(np.abs(states - exact(times)).max())
        if worst <= _LIMIT:
            return tolerance, worst
    raise RuntimeError("no tolerance is good enough")


def _ours(
    hot: rm.Actuator, drive: rm.SineSquared, starts: dict[str, FloatArray]
) -> Callable[[float], tuple[FloatArray, FloatArray]]:
    """States after a period, and its length, by the map that the verb iterates."""
    over = {name: xr.DataArray(starts[name], dims="case") for name in ("omega", "b")}
    problem = initial_value_problem(lay_out_ensemble(hot, drive, over), np.ones(_STARTS))
    flow = PeriodMap(
        problem.field, problem.load_schedule.waveforms_at_phase, directions=1, error_control="state"
    )
    states, length = np.column_stack([starts["x"], starts["v"]]), np.pi / starts["omega"]

    def period(tolerance: float) -> tuple[FloatArray, FloatArray]:
        return flow(states, problem.parameters, length, tolerance=tolerance).state, length

    return period


def _rates(tau: float, u: Any, p: Any) -> list[float]:
    """[Thermal, eq. 16] without prestress, with parameters (omega, b), in one quotient."""
    x, v = u
    load = p[1] * np.sin(p[0] * tau)
    x2 = x * x
    x4 = x2 * x2
    force = _THETA * (x4 * x4 - x2) + load * load * x4
    return [v, (6.0 * v * v - 3.0 * force) / (x4 * x2 * x + 2.0 * x)]


def _pynamicalsys(
    omega: FloatArray, b: FloatArray, starts: dict[str, FloatArray], plan: Plan
) -> dict[str, Any] | None:
    """The same exponents at points drawn at random; None where it is not installed."""
    if reason := pynamicalsys_rk45.TOOL.source.missing():
        plan.say(f"lyapunov: pynamicalsys left out, {reason}")
        return None
    system = pynamicalsys_rk45.variational_system(_THETA)

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
    system.lyapunov([1.0, 0.0], 10.0, parameters=points[0], num_exponents=1)  # compiles
    begin, total = time.process_time(), 0.0
    for w, strength in points:
        length = _PERIODS * np.pi / w
        system.lyapunov([1.0, 0.0], length, parameters=[w, strength], num_exponents=1)
        total += length
    microseconds = 1e6 * (time.process_time() - begin) / total
    plan.say(f"lyapunov: pynamicalsys, tolerance {tolerance:.0e}: {microseconds:.3g} µs")
    return {
        "microseconds": microseconds,
        "version": pynamicalsys_rk45.TOOL.source.version(),
        "points": _SAMPLE,
        "tolerance": tolerance,
        "worst": worst,
    }
