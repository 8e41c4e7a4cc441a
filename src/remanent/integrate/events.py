"""Where an observable passes through a value: bracketed roots of the dense output."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from remanent._field import Field, Program
from remanent._roots import find_roots
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble import dense
from remanent.integrate.ensemble.ensemble import ProgressCallback, integrate
from remanent.integrate.ensemble.problem import (
    Outcome,
    Problem,
    Request,
    StepWindow,
    latest_trusted_time,
)
from remanent.integrate.methods.runge_kutta import default_method
from remanent.integrate.variations import observable_derivatives

#: A root is located to the last digits of the fraction of a step.
_ROOT_TOLERANCES = {"xatol": 0.0, "xrtol": 4.0 * np.finfo(float).eps, "fatol": 0.0, "frtol": 0.0}


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

    @classmethod
    def concatenated(cls, parts: Sequence[Crossings], dimension: int) -> Self:
        """Several lists as one, in the order of the parts.

        Parameters
        ----------
        parts : sequence of Crossings
            May be empty.
        dimension : int
            Of the state.
        """
        numbers = np.empty(0, dtype=np.int64)
        empty = Crossings(numbers, np.empty(0), np.empty((0, dimension)), numbers)
        names = ("trajectory", "time", "states", "direction")
        lists = ([getattr(part, name) for part in (empty, *parts)] for name in names)
        return cls(*(np.concatenate(columns) for columns in lists))

    def sorted_up_to(self, ends: FloatArray) -> Crossings:
        """Those that come before the `ends` of their trajectories, sorted."""
        trusted = np.flatnonzero(self.time <= latest_trusted_time(ends[self.trajectory]))
        order = trusted[np.lexsort((self.time[trusted], self.trajectory[trusted]))]
        return Crossings(
            self.trajectory[order], self.time[order], self.states[order], self.direction[order]
        )


def find_crossings(
    problem: Problem,
    name: str,
    value: float,
    *,
    tolerance: float,
    workers: int | None = None,
    progress: ProgressCallback | None = None,
) -> tuple[Crossings, Outcome]:
    """Every passage of an observable through a value, up to the horizon.

    A motion that starts on the value is not there by a passage; a passage that falls on
    the end of a step is found once.  Two passages within one step, and a touch, are found
    where the observable turns within the step: its extremum is located and compared with
    the value.  An extremum nearer to the value than the tolerance is a touch, since
    nothing better is known of it.

    Parameters
    ----------
    problem : Problem
        What to integrate.
    name : str
        A state variable, or one of ``problem.field.observables`` that depends on state and
        parameters only.
    value : float
        That it passes.
    tolerance : float
        Of the error of the states, absolute.
    workers : int, optional
        Threads; the number of processors by default.
    progress : callable, optional
        Called from this thread with the share of trajectories that are finished.

    Returns
    -------
    Crossings
    Outcome
        Of the run, see :func:`~remanent.integrate.ensemble.ensemble.integrate`.

    See Also
    --------
    remanent.integrate.ensemble.ensemble.integrate : States at given times, and extremes.
    """
    finder = _CrossingFinder.for_observable(problem, name, value, tolerance)
    request = Request(inspect_window=finder.find_in_window)
    outcome = integrate(problem, request, tolerance=tolerance, workers=workers, progress=progress)
    parts = [part for part in outcome.inspection_results if part is not None]
    ends = np.minimum(outcome.horizon, problem.duration)
    joined = Crossings.concatenated(parts, problem.initial_states.shape[1])
    return joined.sorted_up_to(ends), outcome


@dataclass(frozen=True)
class _CrossingFinder:
    """Looks for crossings in windows of steps.

    Attributes
    ----------
    observable_program : Program
        The observable and its derivatives by the state.
    """

    field: Field
    waveform: Callable[[FloatArray], FloatArray]
    observable_program: Program
    crossed_value: float
    tolerance: float

    @classmethod
    def for_observable(cls, problem: Problem, name: str, value: float, tolerance: float) -> Self:
        """A finder for one observable."""
        program = observable_derivatives(problem.field, name, problem.field.state_names)
        if _depends_on_drive(program, problem.field):
            raise ValueError(f"{name} depends on the drive itself, not only on the state")
        return cls(problem.field, problem.timeline.waveforms_at_phase, program, value, tolerance)

    def find_in_window(self, window: StepWindow) -> Crossings | None:
        """The crossings in a window."""
        nodes = window.states.shape[1]
        level, rate = self.signed_distance_and_rate(
            np.moveaxis(window.states, 2, 0), window.parameters[:, :, None], window.phase
        )
        inside = np.arange(nodes - 1) < window.steps_in_run[:, None]
        before, after = level[:, :-1], level[:, 1:]
        # A step that starts on the value goes to the side it moves to.
        side = np.where(before == 0.0, np.sign(rate[:, :-1]), np.sign(before))
        passed = inside & (side * after <= 0.0) & (side != 0.0)
        # An extremum towards the value can hide two passages: the rate changes sign in the
        # step, and points towards the value at its beginning.
        turns = inside & ~passed & (rate[:, :-1] * rate[:, 1:] < 0.0) & (side * rate[:, :-1] < 0.0)
        parts: list[Crossings] = []
        if passed.any():
            steps = _WindowSteps(self, window, *np.nonzero(passed))
            parts.append(steps.locate_passages(np.zeros(steps.count), np.ones(steps.count)))
        if turns.any():
            parts += _WindowSteps(self, window, *np.nonzero(turns)).locate_turns(side)
        return Crossings.concatenated(parts, window.states.shape[2]) if parts else None

    def signed_distance_and_rate(
        self, states: Any, parameters: FloatArray, phase: Any
    ) -> tuple[FloatArray, FloatArray]:
        """The observable less the value, and its rate."""
        inputs = [phase, *states, *parameters, *self.waveform(np.asarray(phase))]
        with np.errstate(all="ignore"):
            level, *slopes = self.observable_program(inputs, functions=np)
            rates = self.field.rates(inputs, functions=np)
            rate = sum(a * b for a, b in zip(slopes, rates, strict=True))
        shape = np.shape(states[0])
        return np.broadcast_to(level - self.crossed_value, shape), np.broadcast_to(rate, shape)


@dataclass(frozen=True)
class _WindowSteps:
    """Some steps of a window, in which an observable is looked at more closely.

    Attributes
    ----------
    trajectory_rows, step_numbers : array (n,)
        Trajectory and step in the window.
    """

    finder: _CrossingFinder
    window: StepWindow
    trajectory_rows: IntArray
    step_numbers: IntArray

    @property
    def count(self) -> int:
        """How many steps there are."""
        return int(self.trajectory_rows.size)

    @property
    def consecutive_numbers(self) -> FloatArray:
        """Numbers of the steps, as a root finder hands them on."""
        return np.arange(self.count, dtype=np.float64)

    def subset(self, where: BoolArray) -> _WindowSteps:
        """Some of the steps."""
        return _WindowSteps(
            self.finder, self.window, self.trajectory_rows[where], self.step_numbers[where]
        )

    def evaluate_at(
        self, part: FloatArray, number: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Observable, rate and state at fractions of steps with these numbers."""
        k = number.astype(np.int64)
        i, j = self.trajectory_rows[k], self.step_numbers[k]
        window, finder = self.window, self.finder
        span = part * window.segment.phase_change_per_fine_step
        parameters = window.parameters[:, i]
        states = dense.partial_step(
            finder.field, default_method(), finder.waveform,
            states=window.states[i, j], parameters=list(parameters),
            phase=window.phase[j], span=span, time=part * window.segment.fine_step_length[i],
        )  # fmt: skip
        phase = window.phase[j] + span
        return *finder.signed_distance_and_rate(list(states.T), parameters, phase), states

    def time_at(self, part: FloatArray) -> FloatArray:
        """Time at a fraction of each step, tau."""
        return self.window.segment.time_after(self.step_numbers, part, self.trajectory_rows)

    def locate_passages(self, low: FloatArray, high: FloatArray) -> Crossings:
        """The passage in each of the steps, between two fractions of it."""
        # The root at the beginning of a step that starts on the value is none.
        start = np.nextafter(low, 1.0, where=low == 0.0, out=low.copy())
        root = find_roots(
            lambda s, k: self.evaluate_at(s, k)[0],
            (start, high),
            args=(self.consecutive_numbers,),
            tolerances=_ROOT_TOLERANCES,
        )
        # Where rounding hides the change of sign, the crossing is at the end of the step.
        part = np.where(root.success, root.x, high)
        _, rate, states = self.evaluate_at(part, self.consecutive_numbers)
        direction = np.sign(rate).astype(np.int64)
        return Crossings(
            self.window.indices[self.trajectory_rows], self.time_at(part), states, direction
        )

    def locate_turns(self, side: FloatArray) -> list[Crossings]:
        """Two passages, or a touch, in steps in which the observable turns towards the value.

        Parameters
        ----------
        side : array (trajectory, step)
            Sign of the observable less the value at the beginning of each step.
        """
        turn = find_roots(
            lambda s, k: self.evaluate_at(s, k)[1],
            (np.zeros(self.count), np.ones(self.count)),
            args=(self.consecutive_numbers,),
        )
        level, _, states = self.evaluate_at(turn.x, self.consecutive_numbers)
        touches = turn.success & (np.abs(level) <= self.finder.tolerance)
        passes_twice = (
            turn.success & ~touches & (level * side[self.trajectory_rows, self.step_numbers] < 0.0)
        )
        parts: list[Crossings] = []
        if touches.any():
            touched = self.subset(touches)
            direction = np.zeros(touched.count, dtype=np.int64)
            trajectory = self.window.indices[touched.trajectory_rows]
            time = touched.time_at(turn.x[touches])
            parts.append(Crossings(trajectory, time, states[touches], direction))
        if passes_twice.any():
            steps, part = self.subset(passes_twice), turn.x[passes_twice]
            parts.append(steps.locate_passages(np.zeros(part.size), part))
            parts.append(steps.locate_passages(part, np.ones(part.size)))
        return parts


def _depends_on_drive(program: Program, field: Field) -> BoolArray | bool:
    """Whether the phase or a waveform enters."""
    first = len(field.input_names) - len(field.waveform_names)
    driven = {0, *range(first, len(field.input_names))}
    base = len(program.input_names) + len(program.constants)
    for k, (_, *operands) in enumerate(program.instructions):
        if driven.intersection(operands):
            driven.add(base + k)
    return bool(driven.intersection(program.output_slots))
