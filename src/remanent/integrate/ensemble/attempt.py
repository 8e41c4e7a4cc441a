"""One attempt: the trajectories of a chunk, run from start to end at one resolution."""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble.counts import cycle_counts, double_steps
from remanent.integrate.ensemble.run import Attempt, Chunk, Run
from remanent.integrate.ensemble.sampler import Sampler
from remanent.integrate.ensemble.segments import Segment, segments
from remanent.integrate.kernel.memory import LaneMemory

#: The end is moved by this factor so that rounding cannot put it past the last step.
_INWARD = 1.0 - 2.0**-50


def attempt(run: Run, chunk: Chunk) -> Attempt:
    """Integrate the trajectories of a chunk once, whatever their errors are."""
    problem, kernels, indices = run.problem, run.kernels, chunk.indices
    steps = double_steps(problem.timeline, chunk.resolution, indices[:1])[:, 0]
    cycles = int(cycle_counts(problem, indices).max())
    memory = _memory(run, indices)
    sampler = Sampler.empty(run, indices, cycles)
    most_steps = run.sizes.steps_per_segment(kernels.run, indices.size, recorded=run.recorded)
    for segment in segments(
        problem.timeline, indices, steps, cycles, run.request.strobe, most_steps
    ):
        if run.cancelled():
            break
        _set_segment(memory, run, segment)
        kernel = kernels.run if segment.has_past else kernels.start
        tables = segment.tables(run.tables(kernel.method.nodes, segment.resolution))
        sampler.advance(memory, kernel, tables, segment)
        # Where no trajectory is below the ceiling, the rest of the run tells nothing more.
        if not (memory.column("largest_error") <= run.error_ceiling).any():
            break
    return _collected(memory, sampler)


def _memory(run: Run, indices: IntArray) -> LaneMemory:
    """The numbers of a chunk before its first segment."""
    problem, begin = run.problem, run.request.begin
    initial = problem.initial[indices]
    vectors = {
        "fine": initial,
        "coarse": initial,
        "at_horizon": initial,
        "parameter": problem.parameters[indices],
    }
    scalars: dict[str, FloatArray | float] = {
        "begin": 0.0 if begin is None else begin[indices] * _INWARD,
        "end": problem.duration[indices] * _INWARD,
        "tolerance": run.tolerance,
        "error_ceiling": run.error_ceiling,
        "within_tolerance": 1.0,
        "horizon": np.inf,
        "maximum": -np.inf,
        "minimum": np.inf,
    }
    return LaneMemory.filled(run.kernels.layout, run.kernels.width, vectors, scalars)


def _set_segment(memory: LaneMemory, run: Run, segment: Segment) -> None:
    """Write down when a segment begins, its steps, and the parameters that hold in it."""
    memory.set_column("cycle", segment.length)
    memory.set_column("step", segment.step)
    memory.set_column("start", segment.piece_start)
    if run.request.extremes and segment.begins_piece:
        # Rates may have jumped since the end of the piece before.
        memory.set_column("direction", np.full(segment.length.size, np.nan))
    for name, values in segment.parameters.items():
        index = run.problem.field.parameters.index(name)
        memory.set_column(f"parameter.{index}", values)


def _collected(memory: LaneMemory, sampler: Sampler) -> Attempt:
    """What a chunk has come to."""
    within = memory.column("within_tolerance") > 0.5
    last = np.where(within[:, None], memory.vectors("fine"), memory.vectors("at_horizon"))
    names = ("horizon", "error_to_horizon", "largest_error", "maximum", "minimum")
    return Attempt(
        np.asarray(within),
        **{name: memory.column(name).copy() for name in names},
        last=last,
        states=sampler.states,
        findings=sampler.findings,
    )
