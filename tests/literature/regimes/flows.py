"""Long reference orbits of forced oscillators, eight at a time, with one tangent vector each.

heyoka integrates state and tangent over whole drive periods at a tolerance of 1e-16. The
independent variable is the drive's phase, set back to 0 after every chunk of periods, so
all lanes share it and no rounding accumulates in it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import heyoka as hy
import numpy as np

from remanent._typing import FloatArray

TOLERANCE = 1e-16
LANES = 8
#: Periods between renormalisations of the tangent.
CHUNK = 10
#: A chunk that takes more steps than this is given up.
MOST_STEPS = 40_000
#: rates(x, v, s, parameters) -> (dx/ds, dv/ds), s the phase in periods.
Rates = Callable[[Any, Any, Any, Sequence[Any]], tuple[Any, Any]]


@dataclass(frozen=True)
class Orbit:
    """One case integrated.

    Attributes
    ----------
    strobes : array (period, 2)
        State at phase 0, the start included; ends early where the orbit escaped.
    growth : array (chunk,)
        Logarithm of the tangent's growth over each chunk of `CHUNK` periods.
    ending
        "" or "escaped" or "too many steps".
    """

    strobes: FloatArray
    growth: FloatArray
    ending: str


def integrator(rates: Rates, count: int) -> Any:
    """State (x, v) and tangent (p, q) of `LANES` orbits with `count` parameters."""
    x, v, p, q = hy.make_vars("x", "v", "p", "q")
    dx, dv = rates(x, v, hy.time, [hy.par[i] for i in range(count)])
    dp = hy.diff(dx, x) * p + hy.diff(dx, v) * q
    dq = hy.diff(dv, x) * p + hy.diff(dv, v) * q
    return hy.taylor_adaptive_batch(
        [(x, dx), (v, dv), (p, dp), (q, dq)],
        np.zeros((4, LANES)), pars=np.zeros((count, LANES)), tol=TOLERANCE,
        time=[0.0] * LANES, compact_mode=False,
    )  # fmt: skip


def orbits(
    rates: Rates,
    parameters: FloatArray,
    initial: FloatArray,
    periods: int,
    *,
    resting: tuple[FloatArray, FloatArray],
    lost: Callable[[FloatArray], Any],
    sweep: Any = None,
    turn: float | None = None,
) -> Iterator[tuple[int, Orbit]]:
    """Index and orbit of every case, in some order.

    Parameters
    ----------
    parameters : array (case, parameter)
    initial : array (case, 2)
    resting
        Parameters and state that fill lanes that are lost or left over.
    lost
        Whether each of some states (lane, 2) has escaped.
    sweep : array (case,), optional
        Cases that are close in this take steps of similar size and share lanes.
    turn
        Where x is an angle, what a full turn is: x is brought back after every chunk, since
        steps are as accurate as the largest number in the state.
    """
    ta = integrator(rates, parameters.shape[1])
    order = np.argsort(sweep) if sweep is not None else np.arange(len(initial))
    for begin in range(0, len(order), LANES):
        members = order[begin : begin + LANES]
        lanes = _run(ta, parameters[members], initial[members], periods, resting, lost, turn)
        yield from zip(members.tolist(), lanes, strict=True)


def _run(
    ta: Any,
    parameters: FloatArray,
    initial: FloatArray,
    periods: int,
    resting: tuple[FloatArray, FloatArray],
    lost: Callable[[FloatArray], Any],
    turn: float | None,
) -> list[Orbit]:
    count, chunks = len(initial), periods // CHUNK
    ta.pars[:] = resting[0][:, None]
    ta.pars[:, :count] = parameters.T
    ta.state[:] = np.array([*resting[1], np.sqrt(0.5), np.sqrt(0.5)])[:, None]
    ta.state[:2, :count] = initial.T
    strobes = np.full((periods + 1, count, 2), np.nan)
    strobes[0] = initial
    growth = np.full((chunks, count), np.nan)
    endings = [""] * count
    alive = np.ones(count, dtype=bool)
    for k in range(chunks):
        if not alive.any():
            break
        values = _chunk(ta, alive, endings, resting)
        states = values[1:, :2, :count].transpose(0, 2, 1)
        gone = alive & np.asarray(lost(states.reshape(-1, 2))).reshape(CHUNK, count).any(axis=0)
        for lane in np.flatnonzero(gone):
            _drop(ta, alive, endings, resting, int(lane), "escaped")
        strobes[1 + CHUNK * k : 1 + CHUNK * (k + 1), alive] = states[:, alive]
        if turn is not None:
            ta.state[0] = np.mod(ta.state[0], turn)
        size = np.hypot(ta.state[2], ta.state[3])
        ta.state[2:] /= size
        growth[k, alive] = np.log(size[:count])[alive]
    ends = [int(np.isfinite(growth[:, i]).sum()) for i in range(count)]
    return [
        Orbit(strobes[: CHUNK * end + 1, i], growth[:end, i], endings[i])
        for i, end in enumerate(ends)
    ]


def _chunk(
    ta: Any, alive: Any, endings: list[str], resting: tuple[FloatArray, FloatArray]
) -> FloatArray:
    """States and tangents (period, 4, lane) over a chunk; lanes that fail are dropped."""
    grid = np.repeat(np.arange(CHUNK + 1.0)[:, None], LANES, axis=1)
    while True:
        before = ta.state.copy()
        ta.set_time(0.0)
        with np.errstate(all="ignore"):
            values = ta.propagate_grid(grid, max_steps=MOST_STEPS)[1]
        outcomes = [result[0] for result in ta.propagate_res]
        if all(outcome == hy.taylor_outcome.time_limit for outcome in outcomes):
            return np.asarray(values)
        failed = [i for i, o in enumerate(outcomes) if o == hy.taylor_outcome.err_nf_state]
        worst = failed[0] if failed else int(np.argmin(ta.time))
        if worst >= len(alive) or not alive[worst]:
            raise ArithmeticError("a lane at rest failed")
        ta.state[:] = before
        why = "escaped" if failed else "too many steps"
        _drop(ta, alive, endings, resting, worst, why)


def _drop(
    ta: Any, alive: Any, endings: list[str], resting: tuple[FloatArray, FloatArray],
    lane: int, why: str,
) -> None:  # fmt: skip
    """Put a lane to rest."""
    alive[lane], endings[lane] = False, why
    ta.pars[:, lane] = resting[0]
    ta.state[:, lane] = [*resting[1], np.sqrt(0.5), np.sqrt(0.5)]
