"""Long runs of [Thermal, eq. 16] by heyoka.py in double precision, with one tangent.

Many times longer than the runs of verbs that they judge, so that what a mean over them has
left of chance is small beside the errors judged.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np

from benchmarks.errors.period_map import PeriodMap
from remanent._typing import BoolArray, FloatArray

#: Periods of the run that tells regular from chaotic motion.
_REGULAR_PERIODS = 600
#: Regular tangents grow at most in proportion to time, times e to this.
_MAX_REGULAR_EXCESS = 3.0
#: Periods of the run over which growth is averaged.
_LONG_PERIODS = 4000
#: Share of a run that passes before anything is averaged.
_TRANSIENT = 0.2
#: Relative error of a step where states are wanted, and where only means of growth are.
_PRECISE, _ENOUGH_FOR_MEANS = 1e-15, 1e-11
#: Stretch, rate and tangent that a run begins with.
_START = (1.0, 0.0, 0.6, 0.8)


def long_run_exponents(references: Sequence[PeriodMap]) -> FloatArray:
    """Largest exponents per tau of motions from rest; NaN where they escape.

    Exactly 0 for undamped motion whose tangents grow no faster than in proportion to time.
    """
    damped = np.array([r.values.get("dissipation.0.eta", 0.0) > 0.0 for r in references])
    exponents = np.zeros(len(references))
    growth = _runs(references, _REGULAR_PERIODS, _ENOUGH_FOR_MEANS)[1].sum(axis=1)
    is_open = ~(growth <= np.log(_REGULAR_PERIODS) + _MAX_REGULAR_EXCESS) | damped
    longer = [references[int(k)] for k in np.flatnonzero(is_open)]
    after = int(_TRANSIENT * _LONG_PERIODS)
    settled = _runs(longer, _LONG_PERIODS, _ENOUGH_FOR_MEANS)[1][:, after:]
    exponents[is_open] = settled.mean(axis=1) / [float(r.period) for r in longer]
    return exponents


def rotation_numbers(references: Sequence[PeriodMap]) -> FloatArray:
    """Turns per period, clockwise and modulo 1, of motions from rest about their means."""
    return np.array([_rotation_number(p) for p in _runs(references, _LONG_PERIODS, _PRECISE)[0]])


def _rotation_number(points: FloatArray) -> float:
    """A mean of the angles between points with a smooth weight that vanishes at both ends."""
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


def _runs(
    references: Sequence[PeriodMap], periods: int, precision: float
) -> tuple[FloatArray, FloatArray]:
    """States after each period, (case, period, 2), and logarithms of a tangent's growth in each.

    NaN from where a motion escapes.
    """
    states, growth = np.empty((0, periods, 2)), np.empty((0, periods))
    lanes = int(_engine(precision).batch_size)
    for first in range(0, len(references), lanes):
        some = references[first : first + lanes]
        found = _run_of_lanes([*some, *[some[-1]] * (lanes - len(some))], periods, precision)
        states = np.concatenate([states, found[0][: len(some)]])
        growth = np.concatenate([growth, found[1][: len(some)]])
    return states, growth


def _run_of_lanes(
    references: Sequence[PeriodMap], periods: int, precision: float
) -> tuple[FloatArray, FloatArray]:
    engine = _engine(precision)
    for lane, reference in enumerate(references):
        engine.pars[:, lane] = _parameters(reference)
    engine.state[:] = np.array(_START)[:, None]
    lengths = [float(reference.period) for reference in references]
    states = np.full((len(references), periods, 2), np.nan)
    growth = np.full((len(references), periods), np.nan)
    alive = np.ones(len(references), dtype=bool)
    for n in range(periods):
        alive &= _advance(engine, lengths)
        size = np.hypot(*engine.state[2:])
        states[alive, n], growth[alive, n] = engine.state[:2, alive].T, np.log(size[alive])
        engine.state[2:] /= size
        if not alive.any():
            break
    return states, growth


def _advance(engine: Any, lengths: Sequence[float]) -> BoolArray:
    """Follow all lanes for a period; those that escape rest from there on, and are told."""
    before, escaped = engine.state.copy(), np.zeros(len(lengths), dtype=bool)
    while True:
        engine.set_time(0.0)
        engine.propagate_until(lengths)
        lost = np.array(["time_limit" not in str(one[0]) for one in engine.propagate_res])
        if not lost.any():
            return ~escaped
        # One lane that fails stops all: the others begin once more.
        blown = lost & ~np.isfinite(engine.state).all(axis=0)
        escaped |= blown if blown.any() else lost
        engine.state[:] = before
        engine.state[:, escaped] = np.array(_START)[:, None]
        engine.pars[5, escaped] = 0.0


def _parameters(reference: PeriodMap) -> list[float]:
    v = reference.values
    theta = v["temperature"] / v.get("reference_temperature", 293.0)
    return [
        v["c"], theta, v.get("prestress", 0.0), v.get("dissipation.0.eta", 0.0), v["omega"], v["b"]
    ]  # fmt: skip


@cache
def _engine(precision: float) -> Any:
    """The motion and one tangent, whose equation is the derivative of the motion's.

    Several motions at once, as many as fit into the registers of the processor.
    """
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
    start = np.tile(np.array(_START)[:, None], hy.recommended_simd_size())
    return hy.taylor_adaptive_batch(system, start, tol=precision)
