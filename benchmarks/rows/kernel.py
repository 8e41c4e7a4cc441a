"""Arithmetic of the kernels against a loop that does nothing else, on the same core.

Counted are the instructions that go through the multiply-add units (fused
multiply-adds, multiplications, additions, subtractions, each one slot per lane) of the
part of a double step that is always done.  Divisions, comparisons, turns and loads of
tables take time and count for nothing.  The share of slots is

    operations of a double step / (seconds of a double step × multiply-adds a second),

a number from 0 to 1; the share of floating-point operations counts a multiply-add as two.
"""

from __future__ import annotations

import statistics
import time
from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.jobs import RESPONSE
from benchmarks.machine import one_core
from benchmarks.machine_code import assembly, work_per_pass
from benchmarks.multiply_add import lanes_per_second
from benchmarks.rows.plan import Plan
from benchmarks.tools import ours
from remanent._typing import FloatArray
from remanent.integrate.ensemble.attempt import attempt_chunk
from remanent.integrate.ensemble.problem import Request
from remanent.integrate.ensemble.resolution import choose_method
from remanent.integrate.ensemble.run import Chunk, Run
from remanent.integrate.kernel.compile import Kernel, KernelPair, compiled_kernel, host_processor
from remanent.integrate.kernel.options import KernelOptions, Method
from remanent.integrate.kernel.tables import CycleTables
from remanent.integrate.methods.runge_kutta import default_method

#: Double steps per cycle, the same for every trajectory.
_RESOLUTION = 64
#: Groups of trajectories that are timed together.
_GROUPS = 64
#: Tolerance by which the method is chosen.
_TOLERANCE = 1e-9
#: Error that no trajectory exceeds, so that all are integrated to their end.
_ERROR_CEILING = 1.0
#: Neighbouring frequencies, whose motions have equally many cycles.
_OMEGA = (1.25, 1.2501)
#: Kernels by name: what is asked of a run, and what its kernel holds.
_CASES = {
    "extremes and bound": (Request(wants_extremes=True), KernelOptions(follows_extremes=True)),
    "extremes alone": (
        Request(wants_extremes=True),
        KernelOptions(follows_extremes=True, has_coarse_solution=False),
    ),
    "states and bound": (Request(), KernelOptions()),
}


@dataclass
class _Timed:
    """A kernel that adds up its double steps, and the processor time they take.

    It stands where :class:`~remanent.integrate.kernel.compile.Kernel` is expected.  Every
    call adds to `seconds` and `passes`.
    """

    kernel: Kernel
    seconds: float = 0.0
    passes: int = 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self.kernel, name)

    def __call__(
        self, lanes: FloatArray, tables: tuple[FloatArray, FloatArray], *rest: Any, **options: Any
    ) -> None:
        begin = time.thread_time()
        self.kernel(lanes, tables, *rest, **options)
        self.seconds += time.thread_time() - begin
        self.passes += lanes.shape[0] * options["cycles"] * tables[1].shape[0]


def measure(plan: Plan) -> dict[str, Any]:
    """Share of the multiply-add loop that every kernel reaches."""
    target = host_processor()
    with one_core():
        rows, peaks = {}, []
        for name, (request, options) in _CASES.items():
            method = choose_method(request, _TOLERANCE)
            peaks.append(lanes_per_second(target, plan.repeats))
            rows[name] = _row(method, options, plan.repeats, peaks[-1])
            plan.say(f"kernel: {name}: {rows[name]['share']:.0%} of the multiply-add loop")
    return {"peak": statistics.median(peaks), "kernels": rows}


def _row(method: Method, options: KernelOptions, repeats: int, peak: float) -> dict[str, Any]:
    work = _operations(method, options)
    seconds = _seconds_per_pass(method, options, repeats)
    slots = work["fma"] + work["mul"] + work["add"]
    return {
        "method": method.name,
        "work": dict(work),
        "lanes": host_processor().lane_count,
        "nanoseconds": seconds * 1e9,
        "share": slots / seconds / peak,
        "flops_share": (slots + work["fma"]) / seconds / (2.0 * peak),
    }


def _operations(method: Method, options: KernelOptions) -> Counter[str]:
    """Operations of a double step of one group of lanes, by kind."""
    field = ours.response_problem(RESPONSE, RESPONSE.omegas[:1]).field
    return work_per_pass(
        assembly(host_processor().kernel_source(field, method, options), host_processor())
    )


def _seconds_per_pass(method: Method, options: KernelOptions, repeats: int) -> float:
    """Processor time of one double step of one group, the median of runs."""
    problem = ours.response_problem(
        RESPONSE, np.linspace(*_OMEGA, _GROUPS * host_processor().lane_count)
    )
    start = compiled_kernel(problem.field, default_method(), options)
    seconds = []
    for _ in range(repeats + 1):  # the first is for the caches
        timed = _Timed(compiled_kernel(problem.field, method, options))
        run = Run(
            problem,
            Request(wants_extremes=options.follows_extremes),
            KernelPair(start, timed),  # type: ignore[arg-type]
            _ERROR_CEILING,
            CycleTables(problem.load_schedule.waveforms_at_phase),
        )
        attempt_chunk(run, Chunk(_RESOLUTION, np.arange(problem.duration.size)))
        seconds.append(timed.seconds / timed.passes)
    return statistics.median(seconds[1:])
