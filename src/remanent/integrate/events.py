"""Where an observable passes through a value: bracketed roots of the dense output."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from remanent._field import Field, Program
from remanent._roots import find_root
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble import dense
from remanent.integrate.ensemble.ensemble import Progress, integrate
from remanent.integrate.ensemble.problem import (
    Outcome,
    Problem,
    Request,
    Window,
    latest_trusted_time,
)
from remanent.integrate.methods.runge_kutta import default_method
from remanent.integrate.variations import derivatives

_ROOT = {"xatol": 0.0, "xrtol": 4.0 * np.finfo(float).eps, "fatol": 0.0, "frtol": 0.0}


@dataclass(frozen=True)
class Crossings:
    """Crossings of all trajectories, sorted by trajectory and time.

    Attributes
    ----------
    trajectory : array (crossing,)
    time : array (crossing,)
        tau.
    states : array (crossing, state)
    direction : array (crossing,)
        1 upwards, -1 downwards, 0 where the observable touches the value and turns back.
    """

    trajectory: IntArray
    time: FloatArray
    states: FloatArray
    direction: IntArray


def crossings(
    problem: Problem,
    name: str,
    value: float,
    *,
    tolerance: float,
    workers: int | None = None,
    progress: Progress | None = None,
) -> tuple[Crossings, Outcome]:
    """Every passage of an observable through a value, up to the horizon.

    A motion that starts on the value is not there by a passage; a passage that falls on
    the end of a step is found once.  Two passages within one step, and a touch, are found
    where the observable turns within the step: its extremum is located and compared with
    the value.  An extremum nearer to the value than the tolerance is a touch, since
    nothing better is known of it.

    Parameters
    ----------
    problem
        What to integrate.
    name
        A state variable, or one of ``problem.field.observables`` that depends on state and
        parameters only.
    value
        That it passes.
    tolerance, workers, progress
        As for :func:`~remanent.integrate.ensemble.ensemble.integrate`.
    """
    finder = _Finder(problem, name, value, tolerance)
    outcome = integrate(
        problem, Request(inspect=finder.look), tolerance=tolerance, workers=workers,
        progress=progress,
    )  # fmt: skip
    found = [f for f in outcome.findings if f is not None]
    dimension = problem.initial.shape[1]
    empty = Crossings(*(np.empty(0, dtype=np.int64), np.empty(0)),
                      np.empty((0, dimension)), np.empty(0, dtype=np.int64))  # fmt: skip
    parts = [empty, *found]
    joined = [
        np.concatenate([getattr(part, field) for part in parts])
        for field in ("trajectory", "time", "states", "direction")
    ]
    ends = latest_trusted_time(np.minimum(outcome.horizon, problem.duration)[joined[0]])
    kept = np.flatnonzero(joined[1] <= ends)
    order = kept[np.lexsort((joined[1][kept], joined[0][kept]))]
    return Crossings(*(column[order] for column in joined)), outcome


class _Finder:
    """Looks for crossings in windows of steps."""

    def __init__(self, problem: Problem, name: str, value: float, tolerance: float) -> None:
        self.field, self.waveform = problem.field, problem.timeline.waveform
        self.program = derivatives(self.field, name, self.field.state)
        if _depends_on_drive(self.program, self.field):
            raise ValueError(f"{name} depends on the drive itself, not only on the state")
        self.value, self.tolerance = value, tolerance

    def look(self, window: Window) -> Crossings | None:
        """The crossings in a window."""
        nodes = window.states.shape[1]
        level, rate = self._observed(
            np.moveaxis(window.states, 2, 0), window.parameters[:, :, None], window.phase
        )
        inside = np.arange(nodes - 1) < window.steps[:, None]
        before, after = level[:, :-1], level[:, 1:]
        # A step that starts on the value goes to the side it moves to.
        side = np.where(before == 0.0, np.sign(rate[:, :-1]), np.sign(before))
        through = inside & (side * after <= 0.0) & (side != 0.0)
        turns = inside & ~through & (rate[:, :-1] * rate[:, 1:] < 0.0) & (side * rate[:, :-1] < 0.0)
        found = [
            self._passages(window, *np.nonzero(through)),
            *self._turns(window, side, *np.nonzero(turns)),
        ]
        parts = [part for part in found if part is not None]
        if not parts:
            return None
        return Crossings(*(np.concatenate(column) for column in zip(*parts, strict=True)))

    def _observed(
        self, states: Any, parameters: FloatArray, phase: Any
    ) -> tuple[FloatArray, FloatArray]:
        """The observable less the value, and its rate."""
        inputs = [phase, *states, *parameters, *self.waveform(np.asarray(phase))]
        with np.errstate(all="ignore"):
            level, *slopes = self.program(inputs, functions=np)
            rates = self.field.rates(inputs, functions=np)
            rate = sum(a * b for a, b in zip(slopes, rates, strict=True))
        shape = np.shape(states[0])
        return np.broadcast_to(level - self.value, shape), np.broadcast_to(rate, shape)

    def _within(
        self, window: Window, row: IntArray, step: IntArray
    ) -> Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]:
        """Observable, rate and state at fractions of some steps."""

        def at(part: FloatArray, number: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
            k = number.astype(np.int64)
            i, j = row[k], step[k]
            parameters = window.parameters[:, i]
            states = dense.between(
                self.field, default_method(), self.waveform,
                states=window.states[i, j], parameters=list(parameters),
                phase=window.phase[j], span=part * window.span, time=part * window.step[i],
            )  # fmt: skip
            phase = window.phase[j] + part * window.span
            return *self._observed(list(states.T), parameters, phase), states

        return at

    def _passages(self, window: Window, row: IntArray, step: IntArray) -> Any:
        """One passage in each of some steps."""
        if not row.size:
            return None
        at = self._within(window, row, step)
        return self._located(window, row, step, at, np.zeros(row.size), np.ones(row.size))

    def _located(
        self, window: Window, row: IntArray, step: IntArray, at: Any,
        low: FloatArray, high: FloatArray,
    ) -> Any:  # fmt: skip
        number = np.arange(row.size, dtype=np.float64)
        start = np.nextafter(low, 1.0, where=low == 0.0, out=low.copy())
        part = find_root(lambda s, k: at(s, k)[0], (start, high), args=(number,), tolerances=_ROOT)
        # Where rounding hides the change of sign, the crossing is at the end of the step.
        s = np.where(part.success, part.x, high)
        _, rate, states = at(s, number)
        time = window.start[row] + (step + s) * window.step[row]
        return window.which[row], time, states, np.sign(rate).astype(np.int64)

    def _turns(self, window: Window, side: FloatArray, row: IntArray, step: IntArray) -> list[Any]:
        """Two passages, or a touch, in steps in which the observable turns towards the value."""
        if not row.size:
            return []
        at = self._within(window, row, step)
        number = np.arange(row.size, dtype=np.float64)
        turn = find_root(
            lambda s, k: at(s, k)[1], (np.zeros(row.size), np.ones(row.size)), args=(number,)
        )
        level, _, states = at(turn.x, number)
        side = side[row, step]
        touch = turn.success & (np.abs(level) <= self.tolerance)
        twice = turn.success & ~touch & (level * side < 0.0)
        found: list[Any] = []
        if touch.any():
            time = window.start[row] + (step + turn.x) * window.step[row]
            zeros = np.zeros(int(touch.sum()), dtype=np.int64)
            found.append((window.which[row[touch]], time[touch], states[touch], zeros))
        if twice.any():
            i, j, s = row[twice], step[twice], turn.x[twice]
            inner = self._within(window, i, j)
            found.append(self._located(window, i, j, inner, np.zeros(s.size), s))
            found.append(self._located(window, i, j, inner, s, np.ones(s.size)))
        return found


def _depends_on_drive(program: Program, field: Field) -> BoolArray | bool:
    """Whether the phase or a waveform enters."""
    first = len(field.inputs) - len(field.waveforms)
    driven = {0, *range(first, len(field.inputs))}
    base = len(program.inputs) + len(program.constants)
    for k, (_, *operands) in enumerate(program.code):
        if driven.intersection(operands):
            driven.add(base + k)
    return bool(driven.intersection(program.outputs))
