"""Frequency responses of a biaxial actuator with a Zener branch, beside heyoka.py.

Six states: two in-plane stretches with their rates, and the viscous stretches of the branch.
Measured is processor time per trajectory and unit of dimensionless time, in microseconds, at
the loosest tolerance with which a program's own results are within 1e-8 of heyoka.py's at
1e-16.  Ours gives the extremes of the thickness stretch with their error, heyoka.py its value
at the end only.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import remanent as rm
from benchmarks.accuracy import LIMIT
from benchmarks.jobs import REFERENCE_TEMPERATURE
from benchmarks.machine import one_core
from benchmarks.rows.plan import Plan
from benchmarks.tools import heyoka_batch
from benchmarks.tools.heyoka_batch import Form
from benchmarks.tools.tool import TOLERANCES
from remanent._typing import FloatArray

#: Slenderness of the actuator.
_C = 1.0
#: Root of the peak load.
_B = 0.4
#: Temperature, kelvin.
_TEMPERATURE = 350.0
#: Temperature over that of the reference configuration.
_THETA = _TEMPERATURE / REFERENCE_TEMPERATURE
#: Prestress in either direction.
_PRESTRESS = (0.3, 0.0)
#: Shear modulus of the Zener branch over that of the network.
_MODULUS = 0.5
#: Relaxation time of the Zener branch.
_RELAXATION = 1.0
#: Length of a motion, tau.
_WINDOW = 100.0
#: Frequencies that are timed.
_COUNT = 4096
#: The same in a quick run.
_QUICK_COUNT = 512
#: Frequencies on which errors are measured and forms compared.
_CHECKED = 64
#: Stretches with their rates, then the viscous stretches.
_REST = [1.0, 0.0, 1.0, 0.0, 1.0, 1.0]
#: Tolerance at which heyoka.py is the reference for both.
_REFERENCE_TOLERANCE = 1e-16
#: Tolerance at which its forms are compared.
_TRIAL_TOLERANCE = 1e-9


@dataclass(frozen=True)
class _Prepared:
    """A way to do the work, at the loosest tolerance that meets the limit."""

    run: Callable[[FloatArray, float], FloatArray]
    tolerance: float
    worst: float


def measure(plan: Plan) -> dict[str, Any]:
    """Microseconds of processor time per trajectory and unit of tau, at equal worst error."""
    omega = np.linspace(0.5, 2.0, _QUICK_COUNT if plan.quick else _COUNT)
    if reason := heyoka_batch.PACKAGE.missing():
        plan.say(f"biaxial: left out, {reason}")
        return {"tools": {}, "trajectories": omega.size}
    with one_core():
        tools = _prepared(omega[:: omega.size // _CHECKED])
        seconds: dict[str, list[float]] = {name: [] for name in tools}
        for _ in range(plan.repeats):
            for name, tool in tools.items():
                begin = time.process_time()
                tool.run(omega, tool.tolerance)
                seconds[name].append(time.process_time() - begin)
    rows = {}
    for name, tool in tools.items():
        microseconds = 1e6 * statistics.median(seconds[name]) / omega.size / _WINDOW
        plan.say(f"biaxial: {name}: {microseconds:.3g} µs, worst error {tool.worst:.1e}")
        rows[name] = {
            "microseconds": microseconds,
            "setting": tool.tolerance,
            "setting_name": "tolerance",
            "worst": tool.worst,
            "met": tool.worst <= LIMIT,
        }
    return {"tools": rows, "trajectories": omega.size}


def _prepared(sample: FloatArray) -> dict[str, _Prepared]:
    """Both programs, each at its loosest tolerance that is good enough on the sample."""
    states = _fastest_form(sample)

    def end(omega: FloatArray, tolerance: float) -> FloatArray:
        return _thickness_stretch(states(omega, tolerance))

    return {
        "remanent": _loosest(_ours, sample, _reference_extremes(sample)),
        "heyoka": _loosest(end, sample, end(sample, _REFERENCE_TOLERANCE)),
    }


def _thickness_stretch(states: FloatArray) -> FloatArray:
    """Thickness stretch of states (trajectory, 6), an array (trajectory, 1)."""
    return np.asarray(1.0 / (states[:, 0] * states[:, 2]))[:, None]


def _ours(omega: FloatArray, tolerance: float) -> FloatArray:
    """Largest and smallest thickness stretch, between steps too."""
    body = rm.Actuator(
        c=_C,
        temperature=_TEMPERATURE,
        prestress=_PRESTRESS,
        dissipation=rm.Zener(_MODULUS, _RELAXATION),
    )
    ds = rm.frequency_response(
        body, rm.SineSquared(_B, 1.0), omega, duration=_WINDOW, tolerance=tolerance,
        resonance_width=10.0,
    )  # fmt: skip
    return np.column_stack([ds.maximum.values, ds.minimum.values])


def _reference_extremes(sample: FloatArray) -> FloatArray:
    """Largest and smallest thickness stretch by heyoka.py's events, array (trajectory, 2)."""
    import heyoka as hy

    system, thickness_rate = _equations()
    thickness: list[float] = []

    def record(ta: Any, instant: float, _direction: int) -> None:
        ta.update_d_output(instant)
        thickness.append(1.0 / (ta.d_output[0] * ta.d_output[2]))

    ta = hy.taylor_adaptive(
        system, _REST, pars=[1.0], tol=_REFERENCE_TOLERANCE,
        nt_events=[hy.nt_event(thickness_rate, record)],
    )  # fmt: skip
    extremes = []
    for omega in sample:
        thickness[:] = [1.0]
        ta.time, ta.state[:], ta.pars[0] = 0.0, _REST, omega
        ta.propagate_until(_WINDOW)
        thickness.append(1.0 / (ta.state[0] * ta.state[2]))
        extremes.append([max(thickness), min(thickness)])
    return np.array(extremes)


def _loosest(
    run: Callable[[FloatArray, float], FloatArray], sample: FloatArray, exact: FloatArray
) -> _Prepared:
    """The loosest tolerance within the limit; the tightest of all if none is."""
    for tolerance in TOLERANCES:
        worst = float(np.abs(run(sample, tolerance) - exact).max())
        if worst <= LIMIT:
            break
    return _Prepared(run, tolerance, worst)


def _fastest_form(sample: FloatArray) -> Callable[[FloatArray, float], FloatArray]:
    """States at the end by heyoka.py, in the form that is fastest on this machine."""

    @cache
    def integrator(tolerance: float, form: Form) -> Any:
        system, _ = _equations()
        return heyoka_batch.batch_integrator(system, _REST, tolerance, form)

    def seconds(form: Form) -> float:
        ta = integrator(_TRIAL_TOLERANCE, form)
        _states_at_end(ta, sample[:16])
        begin = time.process_time()
        _states_at_end(ta, sample)
        return time.process_time() - begin

    fastest = min(heyoka_batch.FORMS, key=seconds)
    return lambda omega, tolerance: _states_at_end(integrator(tolerance, fastest), omega)


def _equations() -> tuple[list[Any], Any]:
    """The system with its numbers written in, and what vanishes where the thickness turns.

    The form has the fewest products of those tried.  The thickness stretch is x = 1/(a b), p
    and q are viscous stretches; the accelerations of a and b solve two linear equations, whose
    matrix is the identity plus a matrix of rank one, so that its inverse needs one division.
    """
    import heyoka as hy

    a, u, b, v, p, q = hy.make_vars("a", "u", "b", "v", "p", "q")
    x = 1.0 / (a * b)
    x2 = x * x
    area_rate = a * v + b * u
    x_rate = -x2 * area_rate
    # Part of the second derivative of x that is no acceleration of a or b.
    convective = -2.0 * (x * x_rate * area_rate + x2 * u * v)
    # Elastic stretches of the branch in the three directions.
    e1, e2, e3 = a / p, b / q, x * p * q
    g = _THETA
    force1 = -3.0 * (g * (a + _MODULUS * e1 / p) - _PRESTRESS[0])
    force2 = -3.0 * (g * (b + _MODULUS * e2 / q) - _PRESTRESS[1])
    force3 = 3.0 * (g * (x + _MODULUS * e3 * p * q) - heyoka_batch.sine_squared(_B))
    force3 += _C * convective
    # Derivatives of x by a and b.
    s1, s2 = -x2 * b, -x2 * a
    coupling = _C * (s2 * force1 - s1 * force2)
    mobility = 1.0 / (1.0 + _C * (s1 * s1 + s2 * s2))
    e1, e2, e3 = e1 * e1, e2 * e2, e3 * e3
    relaxation = g / (6.0 * _RELAXATION)
    system = [
        (a, u), (u, (force1 - s1 * force3 + s2 * coupling) * mobility),
        (b, v), (v, (force2 - s2 * force3 - s1 * coupling) * mobility),
        (p, relaxation * p * (2.0 * e1 - e2 - e3)), (q, relaxation * q * (2.0 * e2 - e1 - e3)),
    ]  # fmt: skip
    return system, area_rate


def _states_at_end(ta: Any, omega: FloatArray) -> FloatArray:
    """The last states, array (trajectory, 6)."""
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
