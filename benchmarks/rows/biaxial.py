"""Two coordinates with a Zener branch, six states, beside heyoka.py's batch form."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

import remanent as rm
from benchmarks.accuracy import LIMIT
from benchmarks.machine import one_core
from benchmarks.rows.plan import Plan
from benchmarks.tools.tool import TOLERANCES
from remanent._typing import FloatArray

_C, _B, _THETA, _LOADS, _MODULUS, _RELAXATION = 1.0, 0.4, 350.0 / 293.0, (0.3, 0.0), 0.5, 1.0
_WINDOW, _CHECKED = 100.0, 64
_REST = [1.0, 0.0, 1.0, 0.0, 1.0, 1.0]
#: Lanes, and whether its compact mode is used; the fastest on this machine is taken.
_FORMS = ((8, False), (4, False), (8, True))


@dataclass(frozen=True)
class _Found:
    """A way to do the work, at the cheapest tolerance that meets the limit."""

    run: Callable[[FloatArray, float], FloatArray]
    tolerance: float
    worst: float


def measure(plan: Plan) -> dict[str, Any]:
    """Microseconds of processor time per trajectory and unit of tau, at equal worst error."""
    omega = np.linspace(0.5, 2.0, 512 if plan.quick else 4096)
    sample = omega[:: omega.size // _CHECKED]
    with one_core():
        theirs = _fastest(sample)
        if theirs is None:
            plan.say("biaxial: heyoka.py is not installed")
            return {"tools": {}, "trajectories": omega.size}
        exact = thickness_stretch_of(theirs(sample, 1e-16))
        tools = {
            "remanent": _settled(_ours, sample, _extremes(sample)),
            "heyoka": _settled(lambda w, tol: thickness_stretch_of(theirs(w, tol)), sample, exact),
        }
        seconds: dict[str, list[float]] = {name: [] for name in tools}
        for _ in range(plan.repeats):
            for name, one in tools.items():
                begin = time.process_time()
                one.run(omega, one.tolerance)
                seconds[name].append(time.process_time() - begin)
    rows = {}
    for name, one in tools.items():
        microseconds = 1e6 * statistics.median(seconds[name]) / omega.size / _WINDOW
        plan.say(f"biaxial: {name}: {microseconds:.3g} µs, worst error {one.worst:.1e}")
        rows[name] = {
            "microseconds": microseconds,
            "tolerance": one.tolerance,
            "worst": one.worst,
            "met": one.worst <= LIMIT,
        }
    return {"tools": rows, "trajectories": omega.size}


def thickness_stretch_of(states: FloatArray) -> FloatArray:
    """Thickness stretch of states (trajectory, 6), an array (trajectory, 1)."""
    return np.asarray(1.0 / (states[:, 0] * states[:, 2]))[:, None]


def _ours(omega: FloatArray, tolerance: float) -> FloatArray:
    """Largest and smallest thickness stretch, between steps too."""
    body = rm.Actuator(
        c=_C, temperature=350.0, prestress=_LOADS, dissipation=rm.Zener(_MODULUS, _RELAXATION)
    )
    ds = rm.frequency_response(
        body, rm.SineSquared(_B, 1.0), omega, duration=_WINDOW, tolerance=tolerance,
        resonance_width=10.0,
    )  # fmt: skip
    return np.column_stack([ds.maximum.values, ds.minimum.values])


def _extremes(sample: FloatArray) -> FloatArray:
    """Largest and smallest thickness stretch by heyoka.py's events, at its best."""
    import heyoka as hy

    system, turning = _system(hy)
    seen: list[float] = []

    def turn(ta: Any, instant: float, _direction: int) -> None:
        ta.update_d_output(instant)
        seen.append(1.0 / (ta.d_output[0] * ta.d_output[2]))

    ta = hy.taylor_adaptive(
        system, _REST, pars=[1.0], tol=1e-16, nt_events=[hy.nt_event(turning, turn)]
    )
    found = []
    for omega in sample:
        seen[:] = [1.0]
        ta.time, ta.state[:], ta.pars[0] = 0.0, _REST, omega
        ta.propagate_until(_WINDOW)
        seen.append(1.0 / (ta.state[0] * ta.state[2]))
        found.append([max(seen), min(seen)])
    return np.array(found)


def _settled(
    run: Callable[[FloatArray, float], FloatArray], sample: FloatArray, exact: FloatArray
) -> _Found:
    for tolerance in TOLERANCES:
        worst = float(np.abs(run(sample, tolerance) - exact).max())
        if worst <= LIMIT:
            break
    return _Found(run, tolerance, worst)


def _fastest(sample: FloatArray) -> Callable[[FloatArray, float], FloatArray] | None:
    """States at the end by heyoka.py, in its fastest form."""
    try:
        import heyoka
    except ImportError:
        return None
    engines: dict[tuple[float, tuple[int, bool]], Any] = {}

    def run(omega: FloatArray, tolerance: float, form: tuple[int, bool] = _FORMS[0]) -> FloatArray:
        key = (tolerance, form)
        if key not in engines:
            engines[key] = _engine(heyoka, tolerance, *form)
        return _propagated(engines[key], omega)

    def seconds(form: tuple[int, bool]) -> float:
        run(sample[:16], 1e-9, form)
        begin = time.process_time()
        run(sample, 1e-9, form)
        return time.process_time() - begin

    best = min(_FORMS, key=seconds)
    return lambda omega, tolerance: run(omega, tolerance, best)


def _system(hy: Any) -> tuple[list[Any], Any]:
    """Equations with the fewest products that we found, numbers written in; where x turns."""
    a, u, b, v, p, q = hy.make_vars("a", "u", "b", "v", "p", "q")
    wave = _B * hy.sin(hy.par[0] * hy.time)
    area = a * b
    x = 1.0 / area
    x2 = x * x
    turning = a * v + b * u
    x_rate = -x2 * turning
    k = -2.0 * (x * x_rate * turning + x2 * u * v)
    q1, q2, q3 = a / p, b / q, x * p * q
    g = _THETA
    one = -3.0 * (g * (a + _MODULUS * q1 / p) - _LOADS[0])
    two = -3.0 * (g * (b + _MODULUS * q2 / q) - _LOADS[1])
    drag = 3.0 * (g * (x + _MODULUS * q3 * p * q) - wave * wave) + _C * k
    s1, s2 = -x2 * b, -x2 * a
    twist = _C * (s2 * one - s1 * two)
    inertia = 1.0 / (1.0 + _C * (s1 * s1 + s2 * s2))
    q1, q2, q3 = q1 * q1, q2 * q2, q3 * q3
    speed = g / (6.0 * _RELAXATION)
    system = [
        (a, u), (u, (one - s1 * drag + s2 * twist) * inertia),
        (b, v), (v, (two - s2 * drag - s1 * twist) * inertia),
        (p, speed * p * (2.0 * q1 - q2 - q3)), (q, speed * q * (2.0 * q2 - q1 - q3)),
    ]  # fmt: skip
    return system, turning


def _engine(hy: Any, tolerance: float, lanes: int, compact: bool) -> Any:
    system, _ = _system(hy)
    start = np.tile(np.array(_REST)[:, None], (1, lanes))
    return hy.taylor_adaptive_batch(
        system, start, pars=np.ones((1, lanes)), tol=tolerance, time=[0.0] * lanes,
        compact_mode=compact,
    )  # fmt: skip


def _propagated(ta: Any, omega: FloatArray) -> FloatArray:
    lanes = ta.state.shape[1]
    padded = np.append(omega, np.full(-omega.size % lanes, omega[-1]))
    end = np.empty((padded.size, 6))
    for first in range(0, padded.size, lanes):
        ta.set_time(0.0)
        ta.state[:] = np.array(_REST)[:, None]
        ta.pars[0] = padded[first : first + lanes]
        ta.propagate_until([_WINDOW] * lanes)
        end[first : first + lanes] = ta.state.T
    return end[: omega.size]
