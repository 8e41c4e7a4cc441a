"""The search for steps that bring one actuator to rest at a target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from remanent._errors import InputError
from remanent._typing import ComplexArray, FloatArray
from remanent.analysis.control import shaping
from remanent.analysis.control.shaping import StepSequence
from remanent.models.actuator import Actuator
from remanent.studies.control._terminal_conditions import TerminalConditions
from remanent.studies.ensemble.checks import FINEST_TOLERANCE, require_actuator
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.statics._static_state import StaticState

#: Numbers of stages in which the target is moved out from the start, tried in this order.
_STAGE_COUNTS_TO_TRY = (1, 4, 16)
#: Spacing of the steps over half a period where the start is not at rest.
_MOVING_START_STEP_SPACING_IN_HALF_PERIODS = 0.8
#: A state nearer to rest than this is at rest.
_MAX_DISTANCE_TO_COUNT_AS_REST = 1e-9
#: A command is accepted if its conditions are met to this many times the tolerance.
_ACCEPTED_RESIDUAL_OVER_TOLERANCE = 100.0
#: Tolerance of the motion over that of the command.
_MOTION_TOLERANCE_OVER_COMMAND_TOLERANCE = 0.1
#: Tolerance of the motion that tells the error of another, over that one's.
_FINER_SHARE = 0.01
#: Factor of the difference of the two.
_SAFETY = 1.5
#: Changes of load and distances from rest below this do not set the scale of the loads.
_SMALLEST_LOAD_SCALE = 1e-3
#: Real part of a pole over the largest modulus, above which an equilibrium is unstable.
_UNSTABLE_POLE_RELATIVE_REAL_PART = 1e-9


def find_shaped_steps(
    single: Ensemble, target: float, robust_to: Sequence[str], tolerance: float
) -> tuple[StepSequence, float]:
    """The steps before the last, and the last load, for an ensemble of one actuator.

    Raises
    ------
    InputError
        There is no such command, or none was found.
    """
    if single.is_invalid[0]:
        raise _unreachable_error(target, "a field is invalid")
    problem = _ShapingProblem.from_ensemble(single, target, robust_to, tolerance)
    if problem.is_there_at_rest:
        return problem.stay()
    for stages in _STAGE_COUNTS_TO_TRY:
        sequence, load = problem.solve_in_stages(stages)
        if sequence.largest_terminal_residual <= problem.accepted_residual:
            return problem.with_residual(sequence), load
    raise _unreachable_error(
        target, f"the best command misses rest by {sequence.largest_terminal_residual:.1e}"
    )


@dataclass(frozen=True)
class _ShapingProblem:
    """One actuator, where it starts from and where it is to rest.

    Attributes
    ----------
    actuator : Actuator
    unloaded_body : StaticState
        As the motion starts, under no load.
    start_rest : StaticState
        At rest at the thickness stretch that the motion starts with, where it can be, else
        the body as it starts.
    start_displacement_from_rest : array (state,)
        Of the initial state from that rest.
    start_thickness, target_thickness : float
        Thickness stretch at the start and in the end.
    robust_to : sequence of str
    state_tolerance : float
        Of the state at the last step.
    motion_tolerance : float
        Of the motion; above that of the state where a state variable exceeds 10.
    """

    actuator: Actuator
    unloaded_body: StaticState
    start_rest: StaticState
    start_displacement_from_rest: FloatArray
    start_thickness: float
    target_thickness: float
    robust_to: Sequence[str]
    state_tolerance: float
    motion_tolerance: float

    @property
    def accepted_residual(self) -> float:
        """The largest residual that a command may have."""
        return _ACCEPTED_RESIDUAL_OVER_TOLERANCE * max(self.state_tolerance, self.motion_tolerance)

    @property
    def is_there_at_rest(self) -> bool:
        """Whether nothing has to move: the start is at rest at the target."""
        distance = abs(self.target_thickness - self.start_thickness)
        return distance <= self.state_tolerance and not self.start_displacement_from_rest.any()

    def stay(self) -> tuple[StepSequence, float]:
        """No step before the last load, under which the start stays as it is."""
        (rest,) = self._intermediate_rest_states(np.ones(1))
        self._require_stable(rest)
        distance = float(np.abs(self.unloaded_body.state - rest.state)[rest.moving_indices].max())
        rounding = float(np.finfo(float).eps * np.abs(rest.state).max())
        nothing = np.empty(0)
        return StepSequence(nothing, nothing, distance, 0.0, distance, rounding), rest.magnetic_load

    def with_residual(self, sequence: StepSequence) -> StepSequence:
        """A command to the target with what it leaves, and the error of that.

        The motion is followed with a smaller tolerance too: the difference is the error, but for
        what the smaller bound leaves.
        """
        (rest,) = self._intermediate_rest_states(np.ones(1))
        initial = self.start_rest.state + self.start_displacement_from_rest
        finer_tolerance = max(_FINER_SHARE * self.motion_tolerance, FINEST_TOLERANCE)
        (residual, bound), (finer, finer_bound) = (
            TerminalConditions(self.actuator, rest, initial, (), tolerance).nominal_residual(
                sequence.loads, sequence.durations
            )
            for tolerance in (self.motion_tolerance, finer_tolerance)
        )
        error = _SAFETY * abs(residual - finer) + finer_bound
        error = min(error, bound) if np.isfinite(error) else bound
        duration_error = sequence.total_duration_error
        if not self.robust_to:  # the distance from rest is all that may be left of conditions
            left = (residual + error) / self.state_tolerance
            rounding = np.finfo(float).eps * float(sequence.durations.sum())
            duration_error = duration_error * min(left, 1.0) + rounding
        return replace(
            sequence, residual=residual, residual_error=error, total_duration_error=duration_error
        )

    @classmethod
    def from_ensemble(
        cls, single: Ensemble, target: float, robust_to: Sequence[str], tolerance: float
    ) -> _ShapingProblem:
        """The problem of one trajectory of an ensemble."""
        row = np.array(
            [
                float(single.parameter_values[name][0])
                for name in single.vector_field.parameter_names
            ]
        )
        body = StaticState(single.vector_field, row, single.initial_states[0])
        thickness = body.thickness()
        start = body.rest_at_thickness(thickness) or body
        offset = body.state - start.state
        size = max(1.0, float(np.abs(body.state).max()))
        return cls(
            actuator=_actuator_with_values(single),
            unloaded_body=body,
            start_rest=start,
            start_displacement_from_rest=np.where(
                np.abs(offset) > _MAX_DISTANCE_TO_COUNT_AS_REST, offset, 0.0
            ),
            start_thickness=thickness,
            target_thickness=target,
            robust_to=robust_to,
            state_tolerance=tolerance,
            motion_tolerance=_MOTION_TOLERANCE_OVER_COMMAND_TOLERANCE * tolerance * size,
        )

    def solve_in_stages(self, stages: int) -> tuple[StepSequence, float]:
        """The command to the target by way of nearer ones, and its last load.

        The command to each is the guess for the next, with loads and the displacement at the
        start in proportion.  A stage that fails ends the search: shorter ones are tried next.
        """
        parts = np.linspace(0.0, 1.0, stages + 1)[1:]
        rests = self._intermediate_rest_states(parts)
        guess = self._guess_steps_by_linear_motion(rests[0])
        before = parts[0]
        for part, rest in zip(parts, rests, strict=True):
            loads = self.start_rest.magnetic_load + part / before * (
                guess.loads - self.start_rest.magnetic_load
            )
            guess = self._solve(rest, replace(guess, loads=loads), part)
            before = part
            if guess.largest_terminal_residual > self.accepted_residual:
                break
        return guess, rests[-1].magnetic_load

    def _intermediate_rest_states(self, parts: FloatArray) -> list[StaticState]:
        """The body at rest after each part of the way."""
        ends = [
            self.start_thickness + part * (self.target_thickness - self.start_thickness)
            for part in parts
        ]
        rests = [
            rest for end in ends if (rest := self.unloaded_body.rest_at_thickness(end)) is not None
        ]
        if len(rests) < len(ends):
            raise _unreachable_error(self.target_thickness, "no load holds it there")
        return rests

    def _solve(self, rest: StaticState, guess: StepSequence, part: float) -> StepSequence:
        """The command to a state of rest near a guess."""
        initial = self.start_rest.state + part * self.start_displacement_from_rest
        conditions = TerminalConditions(
            self.actuator, rest, initial, self.robust_to, self.motion_tolerance
        )
        distance = float(np.abs(self.start_displacement_from_rest).max())
        scale = max(
            abs(rest.magnetic_load - self.start_rest.magnetic_load), distance, _SMALLEST_LOAD_SCALE
        )
        return shaping.solve_step_sequence(
            conditions, guess, scale=scale, tolerance=self.state_tolerance
        )

    def _require_stable(self, rest: StaticState) -> ComplexArray:
        """The poles of small motions about a state of rest, if none of them grows."""
        poles = shaping.controllable_poles(*rest.rate_derivatives())
        if not poles.size:
            raise _unreachable_error(self.target_thickness, "no small load moves it there")
        if (poles.real > _UNSTABLE_POLE_RELATIVE_REAL_PART * np.abs(poles).max()).any():
            raise _unreachable_error(self.target_thickness, "the equilibrium there is unstable")
        return poles

    def _guess_steps_by_linear_motion(self, rest: StaticState) -> StepSequence:
        """The steps for a small move, by the linear motion about the target.

        A start that is not at rest needs as many steps as there are poles.  At half a period
        the roots of two poles would coincide, and give one step for both: the spacing is then
        another.
        """
        poles = self._require_stable(rest)
        moving = bool(self.start_displacement_from_rest.any())
        spacing = shaping.default_impulse_spacing(poles) * (
            _MOVING_START_STEP_SPACING_IN_HALF_PERIODS if moving else 1.0
        )
        if not np.isfinite(spacing):
            raise _unreachable_error(self.target_thickness, "motion about it never comes to rest")
        parts = shaping.zero_vibration_impulse_amplitudes(poles, spacing, 1 + len(self.robust_to))
        loads = (
            self.start_rest.magnetic_load
            + (rest.magnetic_load - self.start_rest.magnetic_load) * np.cumsum(parts)[:-1]
        )
        return StepSequence(loads, np.full(loads.size, spacing))


def _actuator_with_values(single: Ensemble) -> Actuator:
    """The actuator with the values that its trajectory has."""
    actuator = require_actuator("actuator", single.system)
    for name, value in actuator.parameter_values().items():
        if single.parameter_values[name][0] != value:
            actuator = actuator.with_parameter(name, float(single.parameter_values[name][0]))
    return actuator


def _unreachable_error(target: float, why: str) -> InputError:
    return InputError(
        "target",
        must="be a thickness stretch that steps can reach at rest",
        got=target,
        why=f"For this actuator {why}.",
        fix="Pass one nearer to the start, or leave `robust_to` out.",
    )
