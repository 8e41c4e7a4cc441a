"""Observables of states that are already known, by the interpreted field."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from remanent._field import Program
from remanent._load_schedule import LoadSchedule
from remanent._typing import FloatArray
from remanent.integrate.ensemble.problem import ERROR_SHARE_IN_FUNCTIONS, Outcome, Problem
from remanent.integrate.variations import observable_derivatives

#: Numbers of one variable that a program works on at once: as many as stay near a processor.
_NUMBERS_AT_ONCE = 2**13


def evaluate_observable(
    problem: Problem, name: str, times: FloatArray, states: FloatArray
) -> FloatArray:
    """An observable of the field, array (trajectory, time).

    Parameters
    ----------
    name
        One of ``problem.field.observables``.
    times : array (trajectory, time)
    states : array (trajectory, time, state)
    """
    values = np.empty(times.shape, dtype=states.dtype)
    program = problem.field.observables[name]
    for rows, (value,) in _evaluated_blocks(problem, program, times, states):
        values[rows] = value
    return values


def largest_observable_error(
    problem: Problem, name: str, times: FloatArray, states: FloatArray, error: FloatArray
) -> FloatArray:
    """Error that an observable has from that of the state, the largest over the times.

    To first order it is the sum of the sizes of the derivatives times the error of a state
    variable, without the factor of safety of the latter.

    Parameters
    ----------
    name
        One of ``problem.field.observables``.
    times : array (trajectory, time)
    states : array (trajectory, time, state)
        NaN where unknown.
    error : array (trajectory,)
        Of each state variable.

    Returns
    -------
    array (trajectory,)
        NaN where no state is known.
    """
    program = observable_derivatives(problem.field, name, problem.field.state_names)
    largest = np.full(len(times), np.nan)
    for rows, (_, *slopes) in _evaluated_blocks(problem, program, times, states):
        known = np.asarray(np.isfinite(states[rows]).all(axis=2))
        total = np.where(known, sum(np.abs(slope) for slope in slopes), 0.0)
        largest[rows] = np.where(known.any(axis=1), total.max(axis=1, initial=0.0), np.nan)
    return largest * ERROR_SHARE_IN_FUNCTIONS * error


def _evaluated_blocks(
    problem: Problem, program: Program, times: FloatArray, states: FloatArray
) -> Iterator[tuple[slice, list[Any]]]:
    """Outputs of a program of the field, each (row, time) or a number, some trajectories at once.

    The numbers of a block stay near the processor, however large the histories are.
    """
    field, schedule = problem.field, problem.load_schedule
    is_driven = field.is_driven(program)
    if is_driven or schedule.piece_parameters:
        phase, piece = phase_and_piece_index(schedule, times)
    rows_at_once = max(_NUMBERS_AT_ONCE // max(times.shape[1], 1), 1)
    for first in range(0, len(times), rows_at_once):
        rows = slice(first, first + rows_at_once)
        numbers = np.arange(len(times))[rows, None]
        columns = []
        for k, parameter in enumerate(field.parameter_names):
            by_piece = schedule.piece_parameters.get(parameter)
            own = problem.parameters[rows, k][:, None]
            columns.append(own if by_piece is None else by_piece[piece[rows], numbers])
        load: list[Any] = [0.0] * (1 + len(field.waveform_names))
        if is_driven:
            load = [phase[rows], *schedule.waveforms_at_phase(phase[rows])]
        inputs = [load[0], *np.moveaxis(states[rows], 2, 0), *columns, *load[1:]]
        with np.errstate(all="ignore"):
            outputs = list(program(inputs, functions=np))
        yield rows, outputs


def blank_beyond_horizon(states: FloatArray, times: FloatArray, outcome: Outcome) -> FloatArray:
    """`states` (trajectory, time, ...) with NaN where `times` are past the trusted horizon.

    They are changed in place: histories are the largest arrays there are.
    """
    states[outcome.is_beyond_horizon(times)] = np.nan
    return states


def phase_and_piece_index(
    load_schedule: LoadSchedule, times: FloatArray
) -> tuple[FloatArray, np.ndarray]:
    """Phase in the period or piece, and number of the piece, at each time.

    A time at a boundary belongs to the piece that begins there; the end of the run
    belongs to the last piece.
    """
    if load_schedule.periodic:
        with np.errstate(all="ignore"):  # more periods than numbers: no phase, and no states
            turns = times / load_schedule.piece_lengths[0][:, None]
            nearest_turns = np.rint(turns)
            turns = np.where(
                np.abs(turns - nearest_turns) < 1e-12 * np.maximum(nearest_turns, 1.0),
                nearest_turns,
                turns,
            )
            return turns - np.floor(turns), np.zeros(times.shape, dtype=np.int64)
    ends = np.cumsum(load_schedule.piece_lengths, axis=0)
    piece = np.zeros(times.shape, dtype=np.int64)
    for end in ends[:-1]:
        piece += times >= end[:, None] * (1 - 1e-15)
    row = np.arange(times.shape[0])[:, None]
    length = load_schedule.piece_lengths[piece, row]
    start = ends[piece, row] - length
    with np.errstate(all="ignore"):
        phase = np.where(length > 0, (times - start) / length, 0.0)
    return phase.clip(0.0, 1.0), piece
