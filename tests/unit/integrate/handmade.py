"""Fields written by hand, with exact solutions, and one call to integrate them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import sympy as sp

from remanent._field import Field, Role, StateVariable
from remanent._load_schedule import LoadSchedule
from remanent._typing import ArrayLike, FloatArray
from remanent.codegen.lower import DependenceLevel, lower_to_program
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Outcome, Problem, Request

Q, V = sp.symbols("q v", real=True)
#: Waveforms of a periodic load, sin 2 pi s and cos 2 pi s.
SINE, COSINE = sp.symbols("sine cosine", real=True)


@dataclass(frozen=True)
class Oscillator:
    """q'' = acceleration, with numeric parameters; `q` itself is watched."""

    acceleration: Any
    parameters: Mapping[str, float]

    def field(self) -> Field:
        names = tuple(self.parameters)
        symbols = {name: sp.Symbol(name, real=True) for name in names}
        inputs = ("drive_phase", "q", "v", *names, "sine", "cosine")
        levels = dict.fromkeys((Q, V), DependenceLevel.STATE) | dict.fromkeys(
            (SINE, COSINE), DependenceLevel.DRIVE
        )
        levels |= dict.fromkeys(symbols.values(), DependenceLevel.PARAMETER)
        acceleration = self.acceleration.subs({sp.Symbol(n): s for n, s in symbols.items()})

        def program(*outputs: Any) -> Any:
            return lower_to_program(outputs, inputs=inputs, levels=levels, definitions={})

        return Field(
            variables=(
                StateVariable("q", Role.COORDINATE),
                StateVariable("v", Role.RATE, belongs_to="q"),
            ),
            load_names=(),
            parameter_names=names,
            waveform_names=("sine", "cosine"),
            rates=program(V, acceleration),
            observable_name="position",
            observable_and_rates=program(Q, V, acceleration, V),
            observables={"position": program(Q), "acceleration": program(acceleration)},
        )


def turning(phase: FloatArray) -> FloatArray:
    """Waveforms sin 2 pi s and cos 2 pi s."""
    angle = 2.0 * np.pi * np.asarray(phase)
    return np.stack([np.sin(angle), np.cos(angle)])


def still(phase: FloatArray) -> FloatArray:
    """The same waveforms, held at zero."""
    return np.zeros((2, *np.shape(phase)))


def problem(
    oscillator: Oscillator,
    initial: ArrayLike,
    duration: ArrayLike,
    *,
    period: float | None = None,
    **parameters: ArrayLike,
) -> Problem:
    """Trajectories of an oscillator; a period makes the waveforms turn."""
    start = np.atleast_2d(np.asarray(initial, dtype=float))
    end = np.broadcast_to(np.asarray(duration, dtype=float), (len(start),)).copy()
    values = {**oscillator.parameters, **parameters}
    columns = [np.broadcast_to(np.asarray(v, dtype=float), end.shape) for v in values.values()]
    lengths = end[None] if period is None else np.full((1, end.size), period)
    waveform = still if period is None else turning
    load_schedule = LoadSchedule(lengths, period is not None, {}, waveform)
    matrix = np.column_stack(columns) if columns else np.zeros((end.size, 0))
    return Problem(
        oscillator.field(), load_schedule, matrix, start, end, np.zeros(end.size, dtype=np.bool_)
    )


def sampled(asked: Problem, times: FloatArray, tolerance: float, **options: Any) -> Outcome:
    """The states at `times`, the same for every trajectory."""
    grid = np.tile(times, (asked.duration.size, 1))
    return integrate(asked, Request(times=grid), tolerance=tolerance, **options)
