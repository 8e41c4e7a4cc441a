"""One attempt: the trajectories of a chunk, run from start to end at one resolution."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble.counts import counts_of_double_steps, cycle_counts
from remanent.integrate.ensemble.problem import EXTREME_NAMES
from remanent.integrate.ensemble.run import Attempt, Chunk, Run
from remanent.integrate.ensemble.sampler import Sampler
from remanent.integrate.ensemble.segments import START_DOUBLE_STEPS, Segment, cut_into_segments
from remanent.integrate.kernel.memory import LaneMemory

#: The end is moved by this factor so that rounding cannot put it past the last step.
_END_ROUNDING_FACTOR = 1.0 - 2.0**-50


def attempt_chunk(run: Run, chunk: Chunk) -> Attempt:
    """Integrate the trajectories of a chunk once, whatever their errors are."""
    if isinstance(chunk.resolution, np.ndarray):
        return _attempt_with_own_steps(run, chunk.indices, chunk.resolution)
    problem, kernels, indices = run.problem, run.kernel_pair, chunk.indices
    steps = counts_of_double_steps(problem.load_schedule, chunk.resolution, indices[:1])[:, 0]
    cycles = int(cycle_counts(problem, indices).max())
    memory = _initial_memory(run, indices)
    sampler = Sampler.before_first_segment(run, indices, cycles)
    most_steps = run.work_sizes.fine_steps_per_segment(
        kernels.run_kernel, indices.size, recorded=run.records_every_step
    )
    for segment in cut_into_segments(
        problem.load_schedule, indices, steps, cycles, run.request.strobe_cycles, most_steps
    ):
        _write_segment_to_memory(memory, run, segment)
        kernel = kernels.run_kernel if segment.has_past_rates else kernels.start_kernel
        tables = run.cycle_tables.rows(
            kernel.method.nodes, segment.resolution, segment.double_step_slice
        )
        sampler.run_segment(memory, kernel, tables, segment)
        # Where no trajectory is below the ceiling, the rest of the run tells nothing more.
        if not (memory.column("largest_error") <= run.error_ceiling).any():
            break
    return _collect_attempt(memory, sampler.states, sampler.inspection_results)


def _attempt_with_own_steps(run: Run, indices: IntArray, resolution: IntArray) -> Attempt:
    """Integrate trajectories of a periodic load that differ in resolution, for their extremes.

    Each does what it would do in a chunk of one resolution, in the same order.
    """
    kernels, load_schedule = run.kernel_pair, run.problem.load_schedule
    memory = _initial_memory(run, indices)
    lengths = load_schedule.piece_lengths[0, indices]
    _write_piece_to_memory(
        memory, run, lengths, lengths / (2 * resolution), np.zeros(indices.size),
        {name: values[0, indices] for name, values in load_schedule.piece_parameters.items()},
        begins_piece=True,
    )  # fmt: skip
    memory.set_column("own_double_steps", resolution.astype(np.float64))
    longest = int((resolution * cycle_counts(run.problem, indices)).max())
    # So many at a time that no lane passes the end of its cycle twice.
    double_steps = int(resolution.min())
    rounds = -(-max(0, longest - START_DOUBLE_STEPS) // double_steps)
    for kernel, first, count, cycles in (
        (kernels.start_kernel, 0, START_DOUBLE_STEPS, 1),
        (kernels.run_kernel, START_DOUBLE_STEPS, double_steps, rounds),
    ):
        tables, first_row = run.cycle_tables.of_lanes(kernel.method.nodes, resolution)
        memory.set_column("first_row", first_row.astype(np.float64))
        kernel(memory.slots, tables, cycles=cycles, double_steps=count, first_step=2 * first)
    return _collect_attempt(memory, None, [])


def _initial_memory(run: Run, indices: IntArray) -> LaneMemory:
    """The numbers of a chunk before its first segment."""
    problem, begin = run.problem, run.request.extremes_begin
    initial = problem.initial_states[indices]
    vectors = {
        "fine": initial,
        "coarse": initial,
        "at_horizon": initial,
        "parameter": problem.parameters[indices],
    }
    scalars: dict[str, FloatArray | float] = {
        "extremes_begin": 0.0 if begin is None else begin[indices] * _END_ROUNDING_FACTOR,
        "run_end": problem.duration[indices] * _END_ROUNDING_FACTOR,
        "tolerance": run.tolerance,
        "error_ceiling": run.error_ceiling,
        "within_tolerance": 1.0,
        "horizon": np.inf,
        "maximum": -np.inf,
        "minimum": np.inf,
        "maximum_time": np.nan,
        "minimum_time": np.nan,
    }
    return LaneMemory.with_values(
        run.kernel_pair.layout, run.kernel_pair.lane_count, vectors, scalars
    )


def _write_segment_to_memory(memory: LaneMemory, run: Run, segment: Segment) -> None:
    """Write down when a segment begins, its steps, and the parameters that hold in it."""
    _write_piece_to_memory(
        memory, run, segment.cycle_length, segment.fine_step_length, segment.piece_start,
        segment.parameters, begins_piece=segment.begins_piece,
    )  # fmt: skip


def _write_piece_to_memory(
    memory: LaneMemory,
    run: Run,
    cycle_length: FloatArray,
    fine_step_length: FloatArray,
    piece_start: FloatArray,
    parameters: Mapping[str, FloatArray],
    *,
    begins_piece: bool,
) -> None:
    """Write down when a piece begins, its steps, and the parameters that hold in it."""
    memory.set_column("cycle_length", cycle_length)
    memory.set_column("fine_step_length", fine_step_length)
    memory.set_column("piece_start", piece_start)
    if run.request.wants_extremes and begins_piece:
        # Rates may have jumped since the end of the piece before.
        memory.set_column("watched_rate_sign", np.full(cycle_length.size, np.nan))
    for name, values in parameters.items():
        index = run.problem.field.parameter_names.index(name)
        memory.set_column(f"parameter.{index}", values)


def _collect_attempt(
    memory: LaneMemory, states: FloatArray | None, inspection_results: list[Any]
) -> Attempt:
    """What a chunk has come to."""
    within = memory.column("within_tolerance") > 0.5
    last = np.where(
        within[:, None], memory.state_vectors("fine"), memory.state_vectors("at_horizon")
    )
    names = ("horizon", "error_to_horizon", "largest_error", *EXTREME_NAMES)
    return Attempt(
        np.asarray(within),
        **{name: memory.column(name).copy() for name in names},
        last_state=last,
        states=states,
        inspection_results=inspection_results,
    )
