"""Long runs of [Thermal, eq. 16] by heyoka.py in double precision, with one tangent.

Many times longer than the runs of verbs that they judge, so that what a mean over them has
left of chance is small beside the errors judged.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from benchmarks.errors.period_map import PeriodMap
from remanent._typing import FloatArray

#: Periods of the run that tells regular from chaotic motion.
_REGULAR_PERIODS = 600
#: Regular tangents grow at most in proportion to time, times e to this.
_MAX_REGULAR_EXCESS = 3.0
#: Periods of the run over which the growth of chaotic motion is averaged.
_CHAOTIC_PERIODS = 10_000
#: Share of a run that passes before anything is averaged.
_TRANSIENT = 0.2
#: Periods of the run that gives a rotation number.
_ROTATION_PERIODS = 4000


def long_run_exponent(reference: PeriodMap) -> float | None:
    """Largest exponent per tau of the motion from rest; None where it escapes.

    Exactly 0 for undamped motion whose tangents grow no faster than in proportion to time.
    """
    damped = reference.values.get("dissipation.0.eta", 0.0) > 0.0
    if not damped:
        growth = np.cumsum(_run(reference, _REGULAR_PERIODS)[1])
        if not np.isfinite(growth[-1]):
            return None
        if growth[-1] <= np.log(_REGULAR_PERIODS) + _MAX_REGULAR_EXCESS:
            return 0.0
    growth = _run(reference, _CHAOTIC_PERIODS)[1]
    mean = growth[int(_TRANSIENT * growth.size) :].mean() / float(reference.period)
    return float(mean) if np.isfinite(mean) else None


def rotation_number(reference: PeriodMap) -> float:
    """Turns per period, clockwise and modulo 1, of the motion from rest about its mean.

    A mean of the angles between points with a smooth weight that vanishes at both ends.
    """
    points = _run(reference, _ROTATION_PERIODS)[0]
    s = np.arange(1, len(points) + 1) / (len(points) + 1)
    weight = np.exp(-1.0 / (s * (1.0 - s)))
    seen = points - (weight[:, None] * points).sum(axis=0) / weight.sum()
    turns = -np.arctan2(*(seen / seen.std(axis=0)).T[::-1]) / (2.0 * np.pi)
    step = np.diff(turns)
    # Representatives modulo 1 that lie together: about the mean direction.
    middle = np.angle(np.exp(2j * np.pi * step).mean()) / (2.0 * np.pi)
    step = (step - middle + 0.5) % 1.0 - 0.5
    s = np.arange(1, step.size + 1) / (step.size + 1)
    weight = np.exp(-1.0 / (s * (1.0 - s)))
    return float(((weight * step).sum() / weight.sum() + middle) % 1.0)


def _run(reference: PeriodMap, periods: int) -> tuple[FloatArray, FloatArray]:
    """States after each period, (period, 2), and logarithms of a tangent's growth in each."""
    engine, v = _engine(), reference.values
    theta = v["temperature"] / v.get("reference_temperature", 293.0)
    engine.pars[:] = [
        v["c"], theta, v.get("prestress", 0.0), v.get("dissipation.0.eta", 0.0), v["omega"], v["b"]
    ]  # fmt: skip
    engine.state[:] = [1.0, 0.0, 0.6, 0.8]
    length = float(reference.period)
    states, growth = np.full((periods, 2), np.nan), np.full(periods, np.nan)
    for n in range(periods):
        engine.time = 0.0
        outcome = engine.propagate_until(length)
        if "time_limit" not in str(outcome[0]):
            break
        size = np.hypot(*engine.state[2:])
        states[n], growth[n] = engine.state[:2], np.log(size)
        engine.state[2:] /= size
    return states, growth


@cache
def _engine() -> Any:
    """The motion and one tangent, whose equation is the derivative of the motion's."""
    import heyoka as hy

    x, v, dx, dv = hy.make_vars("x", "v", "dx", "dv")
    c, theta, prestress, eta, omega, size = (hy.par[k] for k in range(6))
    sine = size * hy.sin(omega * hy.time)
    m = sine * sine
    x2 = x * x
    x4, x7 = x2 * x2, x2 * x2 * x2 * x
    force = theta * (x4 * x4 - x2) - prestress * x7 + m * x4 + eta * v * x7
    rate = (6.0 * c * v * v - 3.0 * force) / (x7 + 2.0 * c * x)
    change = hy.diff(rate, x) * dx + hy.diff(rate, v) * dv
    system = [(x, v), (v, rate), (dx, dv), (dv, change)]
    return hy.taylor_adaptive(system, [1.0, 0.0, 1.0, 0.0], tol=1e-15)
