"""Runs that end early in the first period of their load.

A period is cut into steps as a whole, whatever the run takes of it.  Of a period that is much
longer than the run hardly a step would be needed, and the number of steps in it grows without
bound as the load becomes slower.  In such a run the waveforms of the load are followed through
a small part of their period only, in which each is a polynomial of the time to round-off: the
run becomes one piece, with the coefficients as its parameters.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from remanent._field import Field, Program
from remanent._load_schedule import LoadSchedule
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble.problem import Problem, Request

#: A run is short if it takes no more than this share of its first period.
_LARGEST_SHARE_OF_PERIOD = 0.125
#: Degree of the polynomials: for a sine they are exact to round-off up to that share.
_DEGREE = 10
#: Error of a polynomial, over the largest value of its waveform, that is round-off.
_LARGEST_POLYNOMIAL_ERROR = 1e-14
#: Name of the share of the period that a run takes, a parameter of its piece.
_SHARE_PARAMETER = "piece.share"


def where_short(problem: Problem, request: Request | None = None) -> BoolArray:
    """Which runs end so early in the first period that they are better made one piece.

    None where whole periods are counted, or where steps are looked at: who does that must know
    the field.
    """
    load_schedule = problem.load_schedule
    looks_closer = request is not None and (
        request.strobe_cycles > 0 or request.inspect_window is not None
    )
    if not load_schedule.periodic or looks_closer:
        return np.zeros(problem.duration.shape, dtype=np.bool_)
    with np.errstate(all="ignore"):
        share = problem.duration / load_schedule.piece_lengths[0]
    short = ~problem.invalid & (share <= _LARGEST_SHARE_OF_PERIOD)
    if short.any():
        short[short] = _polynomials(problem, share[short])[1]
    return np.asarray(short)


def split(problem: Problem, short: BoolArray) -> Iterator[tuple[IntArray, Problem, slice]]:
    """The short runs as one piece, then the others: indices, problem, and place in this order."""
    chosen, others = np.flatnonzero(short), np.flatnonzero(~short)
    yield chosen, as_one_piece(subset(problem, chosen)), slice(0, chosen.size)
    if others.size:
        yield others, subset(problem, others), slice(chosen.size, short.size)


def subset(problem: Problem, indices: IntArray) -> Problem:
    """Some of the trajectories of a problem."""
    load_schedule = problem.load_schedule
    return replace(
        problem,
        load_schedule=replace(
            load_schedule,
            piece_lengths=load_schedule.piece_lengths[:, indices],
            piece_parameters={k: v[:, indices] for k, v in load_schedule.piece_parameters.items()},
        ),
        parameters=problem.parameters[indices],
        initial_states=problem.initial_states[indices],
        duration=problem.duration[indices],
        invalid=problem.invalid[indices],
    )


def subset_of_request(request: Request, indices: IntArray) -> Request:
    """What is wanted of some of the trajectories."""
    begin, times = request.extremes_begin, request.times
    return replace(
        request,
        times=None if times is None else times[indices],
        extremes_begin=None if begin is None else begin[indices],
    )


def as_one_piece(problem: Problem) -> Problem:
    """A problem whose runs are all short, with the load as polynomials of the time."""
    share = problem.duration / problem.load_schedule.piece_lengths[0]
    coefficients, _ = _polynomials(problem, share)
    field = _field_with_polynomial_waveforms(problem.field)
    names = field.parameter_names[len(problem.field.parameter_names) :]
    columns = np.concatenate([share[None], coefficients.reshape(-1, share.size)])
    load_schedule = LoadSchedule(
        problem.duration[None].copy(),
        periodic=False,
        piece_parameters={n: column[None] for n, column in zip(names, columns, strict=True)},
        waveforms_at_phase=_no_waveforms,
    )
    parameters = np.hstack([problem.parameters, columns.T])
    return replace(problem, field=field, load_schedule=load_schedule, parameters=parameters)


def _no_waveforms(phase: FloatArray) -> FloatArray:
    return np.empty((0, *np.shape(phase)))


def _polynomials(problem: Problem, share: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Coefficients (waveform, power, run) in the fraction of the run, and where they will do.

    Parameters
    ----------
    problem : Problem
    share : array (run,)
        Of the period that each run takes.
    """
    waveform = problem.load_schedule.waveforms_at_phase
    # Chebyshev's points of the first kind on [0, 1], and points between them.
    nodes = 0.5 - 0.5 * np.cos(np.pi * (np.arange(_DEGREE + 1) + 0.5) / (_DEGREE + 1))
    between = 0.5 * (nodes[1:] + nodes[:-1])
    powers = np.arange(_DEGREE + 1)
    values = np.asarray(waveform(share * nodes[:, None]))
    coefficients = np.asarray(np.linalg.solve(nodes[:, None] ** powers, values), dtype=np.float64)
    found = np.einsum("np,wpr->wnr", between[:, None] ** powers, coefficients)
    exact = np.asarray(waveform(share * between[:, None]))
    size = np.abs(values).max(axis=1, initial=0.0)
    error = np.abs(found - exact).max(axis=1, initial=0.0)
    return coefficients, np.asarray((error <= _LARGEST_POLYNOMIAL_ERROR * size).all(axis=0))


def _field_with_polynomial_waveforms(field: Field) -> Field:
    """The same field with coefficients of polynomials as parameters in place of waveforms."""
    coefficients = tuple(
        f"piece.{name}.{power}" for name in field.waveform_names for power in range(_DEGREE + 1)
    )
    parameters = (*field.parameter_names, _SHARE_PARAMETER, *coefficients)
    inputs = ("drive_phase", *field.state_names, *parameters)

    def rewritten(program: Program) -> Program:
        return _program_with_polynomials(program, inputs, len(field.waveform_names))

    return replace(
        field,
        parameter_names=parameters,
        waveform_names=(),
        rates=rewritten(field.rates),
        observable_and_rates=rewritten(field.observable_and_rates),
        observables={name: rewritten(p) for name, p in field.observables.items()},
    )


def _program_with_polynomials(
    program: Program, inputs: tuple[str, ...], waveform_count: int
) -> Program:
    """A program that first works out its phase and waveforms from its last inputs."""
    old_inputs, old_constants = len(program.input_names), len(program.constants)
    kept = old_inputs - waveform_count
    first = len(inputs) + old_constants  # slot of the first result
    instructions: list[tuple[str, int] | tuple[str, int, int]] = [("mul", 0, kept)]
    slot_of_input = {0: first, **{k: k for k in range(1, kept)}}
    for k in range(waveform_count):
        base = kept + 1 + k * (_DEGREE + 1)
        total = base + _DEGREE
        for power in range(_DEGREE - 1, -1, -1):  # Horner's scheme
            instructions += [("mul", total, 0)]
            instructions += [("add", first + len(instructions) - 1, base + power)]
            total = first + len(instructions) - 1
        slot_of_input[kept + k] = total
    before = len(instructions)

    def moved(slot: int) -> int:
        if slot < old_inputs:
            return slot_of_input[slot]
        if slot < old_inputs + old_constants:
            return slot - old_inputs + len(inputs)
        return slot - old_inputs - old_constants + first + before

    for operation, *operands in program.instructions:
        instructions.append((operation, *map(moved, operands)))  # type: ignore[arg-type]
    outputs = tuple(map(moved, program.output_slots))
    return Program(inputs, program.constants, tuple(instructions), outputs)
