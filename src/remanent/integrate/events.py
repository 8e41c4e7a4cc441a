"""Where an observable passes through a value: bracketed roots of the dense output."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from remanent._field import Field, Program
from remanent._roots import Roots, find_roots
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.crossings import (
    NO_CROSSING,
    Crossings,
    merge_within_error,
    with_distances,
)
from remanent.integrate.ensemble import dense, short_runs
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import (
    Outcome,
    Problem,
    Request,
    StepWindow,
    merge_outcomes,
)
from remanent.integrate.ensemble.progress import ProgressFunction, report_part_of_whole
from remanent.integrate.methods.runge_kutta import default_method
from remanent.integrate.variations import observable_derivatives

#: Step of the phase by which the rate of an observable of the load itself is taken.
_PHASE_STEP = 1e-5
#: A root is located to the last digits of the fraction of a step.
_ROOT_TOLERANCES = {"xatol": 0.0, "xrtol": 4.0 * np.finfo(float).eps, "fatol": 0.0, "frtol": 0.0}


def find_crossings(
    problem: Problem,
    name: str,
    value: float,
    *,
    tolerance: float,
    least_excursion: FloatArray | None = None,
    workers: int | None = None,
    progress: ProgressFunction | None = None,
) -> tuple[Crossings, Outcome]:
    """Every passage of an observable through a value, up to the horizon.

    A motion that starts on the value is not there by a passage; a passage that falls on
    the end of a step is found once.  Two passages within one step, and a touch, are found
    where the observable turns within the step: its extremum is located and compared with
    the value.  An extremum nearer to the value than the tolerance is a touch, since
    nothing better is known of it; and where the motion stays as near as that, its passages are
    those of its error, see :func:`~remanent.integrate.crossings.merge_within_error`.

    Parameters
    ----------
    problem : Problem
        What to integrate.
    name : str
        A state variable, or one of ``problem.field.observables``.
    value : float
        That it passes.
    tolerance : float
        Of the error of the states, absolute.
    least_excursion : array (trajectory,), optional
        Errors of the states within which passages count as one, where these are smaller than
        `tolerance`: what is known of a motion may be better than what was asked.
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
    short = short_runs.where_short(problem)
    if short.any():
        return _crossings_of_parts(
            problem, short, name, value, tolerance=tolerance, least_excursion=least_excursion,
            workers=workers, progress=progress,
        )  # fmt: skip
    finder = _CrossingFinder.for_observable(problem, name, value, tolerance)
    request = Request(inspect_window=finder.find_in_window)
    outcome = integrate(problem, request, tolerance=tolerance, workers=workers, progress=progress)
    parts = [part for part in outcome.inspection_results if part is not None]
    ends = np.minimum(outcome.horizon, problem.duration)
    joined = Crossings.concatenated(parts, problem.initial_states.shape[1])
    error = np.full(short.size, tolerance)
    if least_excursion is not None:
        error = np.fmin(error, least_excursion)
    return merge_within_error(joined.sorted_up_to(ends), error), outcome


def _crossings_of_parts(
    problem: Problem,
    short: BoolArray,
    name: str,
    value: float,
    *,
    least_excursion: FloatArray | None,
    progress: ProgressFunction | None,
    **options: Any,
) -> tuple[Crossings, Outcome]:
    """The same where some runs end early in the first period of their load."""
    found = [
        (
            indices,
            *find_crossings(
                part,
                name,
                value,
                least_excursion=None if least_excursion is None else least_excursion[indices],
                progress=report_part_of_whole(progress, place, short.size),
                **options,
            ),
        )
        for indices, part, place in short_runs.split(problem, short)
    ]
    listed = [
        replace(crossings, trajectory=indices[crossings.trajectory])
        for indices, crossings, _ in found
    ]
    outcome = merge_outcomes(short.size, [(indices, outcome) for indices, _, outcome in found])
    joined = Crossings.concatenated(listed, problem.initial_states.shape[1])
    return joined.sorted_up_to(np.minimum(outcome.horizon, problem.duration)), outcome


@dataclass(frozen=True)
class _CrossingFinder:
    """Looks for crossings in windows of steps.

    Attributes
    ----------
    observable_program : Program
        The observable and its derivatives by the state.
    is_driven : bool
        Whether the observable depends on the load itself.
    """

    field: Field
    waveform: Callable[[FloatArray], FloatArray]
    observable_program: Program
    is_driven: bool
    crossed_value: float
    tolerance: float

    @classmethod
    def for_observable(cls, problem: Problem, name: str, value: float, tolerance: float) -> Self:
        """A finder for one observable."""
        program = observable_derivatives(problem.field, name, problem.field.state_names)
        driven = problem.field.is_driven(program)
        waveform = problem.load_schedule.waveforms_at_phase
        return cls(problem.field, waveform, program, driven, value, tolerance)

    @np.errstate(all="ignore")  # rates may be infinite
    def find_in_window(self, window: StepWindow) -> Crossings:
        """The crossings in a window, and its ends."""
        nodes = window.states.shape[1]
        length = _positive(window.segment.fine_step_length)[:, None]
        at_nodes = self.observe(
            np.moveaxis(window.states, 2, 0),
            window.parameters[:, :, None],
            window.phase,
            window.segment.phase_change_per_fine_step / length,
        )
        level, rate = at_nodes.level, at_nodes.rate
        inside = np.arange(nodes - 1) < window.steps_in_run[:, None]
        before, after = level[:, :-1], level[:, 1:]
        # A step that starts on the value goes to the side it moves to.
        side = np.where(before == 0.0, np.sign(rate[:, :-1]), np.sign(before))
        passed = inside & (side * after <= 0.0) & (side != 0.0)
        # An extremum towards the value can hide two passages: the rate changes sign in the
        # step, and points towards the value at its beginning.
        turns = inside & ~passed & (rate[:, :-1] * rate[:, 1:] < 0.0) & (side * rate[:, :-1] < 0.0)
        curvature = _largest_of_neighbours(np.abs(np.diff(rate, axis=1)) / length)
        parts: list[Crossings] = []
        if passed.any():
            steps = _WindowSteps(self, window, curvature, *np.nonzero(passed))
            begins_on_value = before[steps.trajectory_rows, steps.step_numbers] == 0.0
            parts.append(
                steps.locate_passages(
                    steps.places_before_passages(begins_on_value), np.ones(steps.count)
                )
            )
        if turns.any():
            turning = _WindowSteps(self, window, curvature, *np.nonzero(turns))
            parts += turning.locate_turns(side)
        found = Crossings.concatenated(parts, window.states.shape[2])
        found = found.subset(np.lexsort((found.time, found.trajectory)))
        row_of_trajectory = np.zeros(int(window.indices.max()) + 1, dtype=np.int64)
        row_of_trajectory[window.indices] = np.arange(len(window.indices))
        distance = np.abs(level)
        distance[:, 1:][~inside] = 0.0
        return with_distances(
            found, distance, row_of_trajectory[found.trajectory], _ends_of_window(window)
        )

    def observe(
        self, states: Any, parameters: FloatArray, phase: Any, phase_rate: Any
    ) -> _Observed:
        """What is observed of some states, whose phase advances at a rate."""
        fixed, shape = [*states, *parameters], np.shape(states[0])

        def program_at(s: Any) -> list[Any]:
            inputs = [s, *fixed, *self.waveform(np.asarray(s))]
            return list(self.observable_program(inputs, functions=np))

        with np.errstate(all="ignore"):
            level, *slopes = program_at(phase)
            inputs = [phase, *fixed, *self.waveform(np.asarray(phase))]
            rates = self.field.rates(inputs, functions=np)
            rate = sum(a * b for a, b in zip(slopes, rates, strict=True))
            if self.is_driven:
                change = program_at(phase + _PHASE_STEP)[0] - program_at(phase - _PHASE_STEP)[0]
                rate = rate + change / (2.0 * _PHASE_STEP) * phase_rate
            sensitivity = sum(np.abs(slope) for slope in slopes)
        speed = np.max([np.broadcast_to(np.abs(r), shape) for r in rates], axis=0)
        level, rate, sensitivity = (
            np.broadcast_to(v, shape) for v in (level - self.crossed_value, rate, sensitivity)
        )
        return _Observed(level, rate, sensitivity, speed)


def _largest_of_neighbours(values: FloatArray) -> FloatArray:
    """The largest of each value and the two beside it, array (trajectory, step)."""
    padded = np.pad(values, ((0, 0), (1, 1)), mode="edge")
    return np.asarray(np.maximum(np.maximum(padded[:, :-2], padded[:, 2:]), values))


def _ends_of_window(window: StepWindow) -> Crossings:
    """The end of a window in each of its trajectories, as what comes after their crossings."""
    count = window.indices.size
    steps = np.clip(window.steps_in_run, 0, window.states.shape[1] - 1)
    unknown = np.full(count, np.nan)
    return Crossings(
        trajectory=window.indices,
        time=window.segment.time_after(steps),
        states=np.full((count, window.states.shape[2]), np.nan),
        direction=np.full(count, NO_CROSSING),
        rate=unknown,
        curvature=unknown,
        sensitivity=unknown,
        speed=unknown,
        largest_before=unknown,
        step=steps,
    )


@dataclass(frozen=True)
class _Observed:
    """What is observed of some states, arrays of one shape.

    Attributes
    ----------
    level : array
        The observable less the value that is crossed.
    rate : array
        Of the observable.
    sensitivity : array
        Sum of the sizes of its derivatives by the state.
    speed : array
        Largest rate of a state variable.
    """

    level: FloatArray
    rate: FloatArray
    sensitivity: FloatArray
    speed: FloatArray

    def subset(self, where: BoolArray) -> _Observed:
        """Some of the states."""
        return _Observed(
            self.level[where], self.rate[where], self.sensitivity[where], self.speed[where]
        )


@dataclass(frozen=True)
class _WindowSteps:
    """Some steps of a window, in which an observable is looked at more closely.

    Attributes
    ----------
    curvature : array (trajectory, step)
        Size of the observable's second derivative in every step of the window.
    trajectory_rows, step_numbers : array (n,)
        Trajectory and step in the window.
    """

    finder: _CrossingFinder
    window: StepWindow
    curvature: FloatArray
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
            self.finder,
            self.window,
            self.curvature,
            self.trajectory_rows[where],
            self.step_numbers[where],
        )

    def evaluate_at(self, part: FloatArray, number: FloatArray) -> tuple[_Observed, FloatArray]:
        """What is observed, and the state, at fractions of steps with these numbers."""
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
        length = _positive(window.segment.fine_step_length[i])
        phase_rate = window.segment.phase_change_per_fine_step / length
        observed = finder.observe(list(states.T), parameters, window.phase[j] + span, phase_rate)
        return observed, states

    def crossings_at(
        self,
        part: FloatArray,
        observed: _Observed,
        states: FloatArray,
        direction: IntArray,
        beyond: FloatArray | float = 0.0,
    ) -> Crossings:
        """Crossings at a fraction of each step.

        Where another one in the same step comes before, `beyond` is the distance between them.
        """
        return Crossings(
            trajectory=self.window.indices[self.trajectory_rows],
            time=self.time_at(part),
            states=states,
            direction=direction,
            rate=observed.rate,
            curvature=self.curvature[self.trajectory_rows, self.step_numbers],
            sensitivity=observed.sensitivity,
            speed=observed.speed,
            largest_before=np.broadcast_to(beyond, (self.count,)),
            step=self.step_numbers,
        )

    def time_at(self, part: FloatArray) -> FloatArray:
        """Time at a fraction of each step, tau."""
        return self.window.segment.time_after(self.step_numbers, part, self.trajectory_rows)

    def locate_passages(
        self, low: FloatArray, high: FloatArray, beyond: FloatArray | float = 0.0
    ) -> Crossings:
        """The passage in each of the steps, between two fractions of it."""
        root = find_roots(
            lambda s, k: self.evaluate_at(s, k)[0].level,
            (low, high),
            args=(self.consecutive_numbers,),
            tolerances=_ROOT_TOLERANCES,
        )
        # Where rounding hides the change of sign, the crossing is at the end of the step.
        part = np.where(root.success, root.x, high)
        observed, states = self.evaluate_at(part, self.consecutive_numbers)
        # An infinite motion has no rate there, and no direction.
        direction = np.nan_to_num(np.sign(observed.rate)).astype(np.int64)
        return self.crossings_at(part, observed, states, direction, beyond)

    def places_before_passages(self, begins_on_value: BoolArray) -> FloatArray:
        """Fractions of the steps after which a passage is looked for, array (n,).

        The root at the beginning of a step that begins on the value is none.  What comes back to
        it within the step has turned before.
        """
        places = np.zeros(self.count)
        if begins_on_value.any():
            turn = self.subset(begins_on_value).find_turns()
            places[begins_on_value] = np.where(turn.success, turn.x, 1.0)
        return places

    def find_turns(self) -> Roots:
        """Fractions of the steps at which the rate of the observable changes its sign."""
        return find_roots(
            lambda s, k: self.evaluate_at(s, k)[0].rate,
            (np.zeros(self.count), np.ones(self.count)),
            args=(self.consecutive_numbers,),
        )

    def locate_turns(self, side: FloatArray) -> list[Crossings]:
        """Two passages, or a touch, in steps in which the observable turns towards the value.

        Parameters
        ----------
        side : array (trajectory, step)
            Sign of the observable less the value at the beginning of each step.
        """
        turn = self.find_turns()
        observed, states = self.evaluate_at(turn.x, self.consecutive_numbers)
        level = observed.level
        touches = turn.success & (np.abs(level) <= self.finder.tolerance)
        passes_twice = (
            turn.success & ~touches & (level * side[self.trajectory_rows, self.step_numbers] < 0.0)
        )
        parts: list[Crossings] = []
        if touches.any():
            touched = self.subset(touches)
            direction = np.zeros(touched.count, dtype=np.int64)
            at_turn, place = observed.subset(touches), turn.x[touches]
            parts.append(touched.crossings_at(place, at_turn, states[touches], direction))
        if passes_twice.any():
            steps, part = self.subset(passes_twice), turn.x[passes_twice]
            parts.append(steps.locate_passages(np.zeros(part.size), part))
            beyond = np.abs(level[passes_twice])
            parts.append(steps.locate_passages(part, np.ones(part.size), beyond))
        return parts


def _positive(lengths: FloatArray) -> FloatArray:
    """Lengths of steps, of which the shortest runs that there are have none."""
    return np.maximum(lengths, np.finfo(float).tiny)
