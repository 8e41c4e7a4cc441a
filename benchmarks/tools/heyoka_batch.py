"""heyoka.py: Taylor series, several trajectories in the lanes of a vector."""

from __future__ import annotations

import time
from functools import cache
from typing import Any

import numpy as np

from benchmarks.jobs import Job, thickness_stretch
from benchmarks.tools.tool import Package, Run, Tool, clocked
from remanent._typing import FloatArray

#: Lanes, and whether its compact mode is used; the fastest on this machine is taken.
_FORMS = ((8, False), (4, False), (8, True))
_TRIAL_TOLERANCE, _TRIAL = 1e-10, 64


def equations(job: Job) -> tuple[Any, Any, list[Any]]:
    """Stretch, its rate, and the system; the frequency is a parameter."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    load = job.b * hy.sin(hy.par[0] * hy.time)
    return x, v, [(x, v), (v, job.acceleration(load * load, x, v))]


def build_end(job: Job) -> Run:
    """The state at the end only: the least that any use of it costs."""

    @cache
    def integrator(tolerance: float, form: tuple[int, bool]) -> Any:
        return _integrator(job, tolerance, form, [])

    @cache
    def best() -> tuple[int, bool]:
        sample = np.linspace(job.low, job.high, _TRIAL)
        return min(_FORMS, key=lambda form: _trial(integrator(_TRIAL_TOLERANCE, form), job, sample))

    def run(omegas: FloatArray, tolerance: float) -> FloatArray:
        return _propagate(integrator(tolerance, best()), job, omegas)

    return clocked(run)


def build_extremes(job: Job) -> Run:
    """Turns by its events.  Their callbacks are Python, which costs more than the steps."""
    import heyoka as hy

    seen: list[tuple[int, float]] = []

    def turn(ta: Any, instant: float, _direction: int, lane: int) -> None:
        ta.update_d_output([instant] * lanes)
        seen.append((lane, ta.d_output[0, lane]))

    lanes = _FORMS[0][0]

    @cache
    def integrator(tolerance: float) -> Any:
        _, v, _ = equations(job)
        return _integrator(job, tolerance, _FORMS[0], [hy.nt_event_batch(v, turn)])

    def run(omegas: FloatArray, tolerance: float) -> FloatArray:
        ta = integrator(tolerance)
        found = np.empty((omegas.size, 2))
        for first in range(0, omegas.size, lanes):
            seen[:] = [(lane, 1.0) for lane in range(lanes)]
            group = omegas[first : first + lanes]
            _propagate(ta, job, group)
            seen.extend(enumerate(ta.state[0]))
            for lane in range(group.size):
                stretches = thickness_stretch(np.array([s for k, s in seen if k == lane]))
                found[first + lane] = stretches.max(), stretches.min()
        return found

    return clocked(run)


def _integrator(job: Job, tolerance: float, form: tuple[int, bool], events: list[Any]) -> Any:
    import heyoka as hy

    lanes, compact = form
    _, _, system = equations(job)
    start = np.vstack([np.ones(lanes), np.zeros(lanes)])
    return hy.taylor_adaptive_batch(
        system, start, pars=np.ones((1, lanes)), tol=tolerance, time=[0.0] * lanes,
        compact_mode=compact, nt_events=events,
    )  # fmt: skip


def _propagate(ta: Any, job: Job, omegas: FloatArray) -> FloatArray:
    """The last thickness stretch of each, array (trajectory, 1)."""
    lanes = ta.state.shape[1]
    padded = np.append(omegas, np.full(-omegas.size % lanes, omegas[-1]))
    end = np.empty(padded.size)
    for first in range(0, padded.size, lanes):
        ta.set_time(0.0)
        ta.state[0], ta.state[1], ta.pars[0] = 1.0, 0.0, padded[first : first + lanes]
        ta.propagate_until([job.window] * lanes)
        end[first : first + lanes] = ta.state[0]
    return np.asarray(thickness_stretch(end[: omegas.size]))[:, None]


def _trial(ta: Any, job: Job, omegas: FloatArray) -> float:
    times = []
    for _ in range(3):
        begin = time.perf_counter()
        _propagate(ta, job, omegas)
        times.append(time.perf_counter() - begin)
    return min(times)


_PACKAGE = Package("heyoka")
END = Tool("heyoka", "heyoka.py, batch, end state only", _PACKAGE, "end", build_end)
EXTREMES = Tool(
    "heyoka-extremes", "heyoka.py, batch, extremes by events", _PACKAGE, "extremes", build_extremes
)
