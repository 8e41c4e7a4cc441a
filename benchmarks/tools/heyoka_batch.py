"""heyoka.py: Taylor series, several trajectories in the lanes of a vector.

The form is the fastest of those tried with heyoka.py 7.13, on both jobs:

* The load (b sin ωτ)² is written ½ b² (1 − cos 2ωτ): one function and no square.  A square
  costs a convolution of Taylor coefficients in every order; a constant costs nothing.
* The acceleration has one division, and the parameters are numbers.
* ``fast_math`` lets LLVM fuse multiplications with additions.

Together they take 0.86 of the time of sin² without ``fast_math``.  Writing the force with one
square less, or forcing 512-bit registers, made no difference beyond the scatter.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from benchmarks.jobs import Job, thickness_stretch
from benchmarks.tools.tool import Package, Run, Tool, clocked
from remanent._typing import FloatArray


@dataclass(frozen=True)
class Form:
    """How heyoka.py lays out its code: trajectories per vector, and loops instead of unrolling."""

    lanes: int
    compact_mode: bool


#: Forms that are tried; the fastest on the machine at hand is timed.
FORMS = (Form(8, False), Form(4, False), Form(8, True))
#: Tolerance at which forms are compared.
_TRIAL_TOLERANCE = 1e-10
#: Frequencies on which forms are compared.
_TRIAL_COUNT = 64
#: Runs of a form in the comparison, of which the fastest counts.
_TRIAL_REPEATS = 3


def sine_squared(b: float) -> Any:
    """The load (b sin ωτ)² of heyoka.py's parameter 0, the frequency ω, as ½ b² (1 − cos 2ωτ)."""
    import heyoka as hy

    half = 0.5 * b**2
    return half - half * hy.cos((2.0 * hy.par[0]) * hy.time)


def equations(job: Job, load: Any) -> tuple[Any, list[Any]]:
    """The rate of stretch, and the system under a load; the frequency is parameter 0."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    return v, [(x, v), (v, job.acceleration(load, x, v))]


def build_end(job: Job) -> Run:
    """The state at the end only: the least that any use of it costs."""

    @cache
    def integrator(tolerance: float, form: Form) -> Any:
        return _integrator(job, tolerance, form, [])

    @cache
    def fastest_form() -> Form:
        sample = np.linspace(job.low, job.high, _TRIAL_COUNT)
        return min(
            FORMS, key=lambda form: _seconds(integrator(_TRIAL_TOLERANCE, form), job, sample)
        )

    def run(omegas: FloatArray, tolerance: float) -> FloatArray:
        return _propagate(integrator(tolerance, fastest_form()), job, omegas)

    return clocked(run)


def build_extremes(job: Job) -> Run:
    """Extremes at the zeros of the rate, by its events.

    Their callbacks are Python, which costs more than the steps.
    """
    import heyoka as hy

    lanes = FORMS[0].lanes
    #: Lane and stretch at every turning point of the group at hand.
    turning_points: list[tuple[int, float]] = []

    def record(ta: Any, instant: float, _direction: int, lane: int) -> None:
        ta.update_d_output([instant] * lanes)
        turning_points.append((lane, ta.d_output[0, lane]))

    @cache
    def integrator(tolerance: float) -> Any:
        v, _ = equations(job, sine_squared(job.b))
        return _integrator(job, tolerance, FORMS[0], [hy.nt_event_batch(v, record)])

    def run(omegas: FloatArray, tolerance: float) -> FloatArray:
        ta = integrator(tolerance)
        extremes = np.empty((omegas.size, 2))
        for first in range(0, omegas.size, lanes):
            # A largest value may also lie at either end, where nothing turns.
            turning_points[:] = [(lane, 1.0) for lane in range(lanes)]
            group = omegas[first : first + lanes]
            _propagate(ta, job, group)
            turning_points.extend(enumerate(ta.state[0]))
            for lane in range(group.size):
                stretches = np.array([x for k, x in turning_points if k == lane])
                thickness = thickness_stretch(stretches)
                extremes[first + lane] = thickness.max(), thickness.min()
        return extremes

    return clocked(run)


def _integrator(job: Job, tolerance: float, form: Form, events: list[Any]) -> Any:
    _, system = equations(job, sine_squared(job.b))
    return batch_integrator(system, [1.0, 0.0], tolerance, form, events)


def batch_integrator(
    system: Any,
    rest: Sequence[float],
    tolerance: float,
    form: Form,
    events: Sequence[Any] = (),
    *,
    parameter_count: int = 1,
) -> Any:
    """A batch integrator of a system whose first parameter is the frequency, from `rest`."""
    import heyoka as hy

    start = np.tile(np.array(rest)[:, None], (1, form.lanes))
    parameters = np.ones((parameter_count, form.lanes))
    return hy.taylor_adaptive_batch(
        system, start, pars=parameters, tol=tolerance, time=[0.0] * form.lanes,
        compact_mode=form.compact_mode, fast_math=True, nt_events=list(events),
    )  # fmt: skip


def _propagate(ta: Any, job: Job, omegas: FloatArray) -> FloatArray:
    """The last thickness stretch of each trajectory, array (trajectory, 1)."""
    lanes = ta.state.shape[1]
    padded = np.append(omegas, np.full(-omegas.size % lanes, omegas[-1]))
    end = np.empty(padded.size)
    for first in range(0, padded.size, lanes):
        ta.set_time(0.0)
        ta.state[0], ta.state[1], ta.pars[0] = 1.0, 0.0, padded[first : first + lanes]
        ta.propagate_until([job.window] * lanes)
        end[first : first + lanes] = ta.state[0]
    return np.asarray(thickness_stretch(end[: omegas.size]))[:, None]


def _seconds(ta: Any, job: Job, omegas: FloatArray) -> float:
    """The fastest of a few runs."""
    times = []
    for _ in range(_TRIAL_REPEATS):
        begin = time.perf_counter()
        _propagate(ta, job, omegas)
        times.append(time.perf_counter() - begin)
    return min(times)


PACKAGE = Package("heyoka")
END = Tool("heyoka", "heyoka.py, batch, end state only", PACKAGE, "end", build_end)
EXTREMES = Tool(
    "heyoka-extremes", "heyoka.py, batch, extremes by events", PACKAGE, "extremes", build_extremes
)
