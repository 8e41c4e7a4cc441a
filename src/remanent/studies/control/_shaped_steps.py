"""The search for steps that bring one actuator to rest at a target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.analysis.control import shaping
from remanent.analysis.control.shaping import StepSequence
from remanent.models.actuator import Actuator
from remanent.studies.control._terminal_conditions import TerminalConditions
from remanent.studies.ensemble.checks import require_actuator
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.statics._static_state import StaticState

#: Numbers of stages in which the target is moved out from the start, tried in this order.
_STAGES = (1, 4, 16)
#: Spacing of the steps over half a period where the start is not at rest.
_UNEVEN_SPACING = 0.8
#: A state nearer to rest than this is at rest.
_REST_DISTANCE = 1e-9
#: A command is accepted if its conditions are met to this many times the tolerance.
_ACCEPTANCE = 100.0
#: Tolerance of the motion over that of the command.
_MOTION_TOLERANCE = 0.1
#: Changes of load and distances from rest below this do not set the scale of the loads.
_SMALLEST_SCALE = 1e-3
#: Real part of a pole over the largest modulus, above which an equilibrium is unstable.
_UNSTABLE = 1e-9


def shaped_steps(
    single: Ensemble, target: float, robust_to: Sequence[str], tolerance: float
) -> tuple[StepSequence, float]:
    """The steps before the last, and the last load, for an ensemble of one actuator.

    Raises
    ------
    InputError
        There is no such command, or none was found.
    """
    if single.invalid[0]:
        raise _unreachable(target, "a field is invalid")
    problem = _ShapingProblem.of(single, target, robust_to, tolerance)
    for stages in _STAGES:
        sequence, load = problem.in_stages(stages)
        if sequence.largest_terminal_residual <= problem.accepted:
            return sequence, load
    raise _unreachable(
        target, f"the best command misses rest by {sequence.largest_terminal_residual:.1e}"
    )


@dataclass(frozen=True)
class _ShapingProblem:
    """One actuator, where it starts from and where it is to rest.

    Attributes
    ----------
    actuator : Actuator
    body : StaticState
        As the motion starts, under no load.
    start : StaticState
        At rest at the thickness stretch that the motion starts with, where it can be, else
        the body as it starts.
    displacement : array (state,)
        Of the initial state from that rest.
    thickness, target : float
        Thickness stretch at the start and in the end.
    robust_to : sequence of str
    tolerance : float
        Of the state at the last step.
    motion_tolerance : float
        Of the motion; above that of the state where a state variable exceeds 10.
    """

    actuator: Actuator
    body: StaticState
    start: StaticState
    displacement: FloatArray
    thickness: float
    target: float
    robust_to: Sequence[str]
    tolerance: float
    motion_tolerance: float

    @property
    def accepted(self) -> float:
        """The largest residual that a command may have."""
        return _ACCEPTANCE * max(self.tolerance, self.motion_tolerance)

    @classmethod
    def of(
        cls, single: Ensemble, target: float, robust_to: Sequence[str], tolerance: float
    ) -> _ShapingProblem:
        """The problem of one trajectory of an ensemble."""
        row = np.array([float(single.values[name][0]) for name in single.field.parameters])
        body = StaticState(single.field, row, single.initial[0])
        thickness = body.thickness()
        start = body.at_thickness(thickness) or body
        offset = body.state - start.state
        size = max(1.0, float(np.abs(body.state).max()))
        return cls(
            actuator=_with_values(single),
            body=body,
            start=start,
            displacement=np.where(np.abs(offset) > _REST_DISTANCE, offset, 0.0),
            thickness=thickness,
            target=target,
            robust_to=robust_to,
            tolerance=tolerance,
            motion_tolerance=_MOTION_TOLERANCE * tolerance * size,
        )

    def in_stages(self, stages: int) -> tuple[StepSequence, float]:
        """The command to the target by way of nearer ones, and its last load.

        The command to each is the guess for the next, with loads and the displacement at the
        start in proportion.  A stage that fails ends the search: shorter ones are tried next.
        """
        parts = np.linspace(0.0, 1.0, stages + 1)[1:]
        rests = self._rests(parts)
        guess = self._linear_steps(rests[0])
        before = parts[0]
        for part, rest in zip(parts, rests, strict=True):
            loads = self.start.load + part / before * (guess.loads - self.start.load)
            guess = self._solve(rest, replace(guess, loads=loads), part)
            before = part
            if guess.largest_terminal_residual > self.accepted:
                break
        return guess, rests[-1].load

    def _rests(self, parts: FloatArray) -> list[StaticState]:
        """The body at rest after each part of the way."""
        ends = [self.thickness + part * (self.target - self.thickness) for part in parts]
        rests = [rest for end in ends if (rest := self.body.at_thickness(end)) is not None]
        if len(rests) < len(ends):
            raise _unreachable(self.target, "no load holds it there")
        return rests

    def _solve(self, rest: StaticState, guess: StepSequence, part: float) -> StepSequence:
        """The command to a state of rest near a guess."""
        initial = self.start.state + part * self.displacement
        conditions = TerminalConditions(
            self.actuator, rest, initial, self.robust_to, self.motion_tolerance
        )
        distance = float(np.abs(self.displacement).max())
        scale = max(abs(rest.load - self.start.load), distance, _SMALLEST_SCALE)
        return shaping.solve_step_sequence(conditions, guess, scale=scale, tolerance=self.tolerance)

    def _linear_steps(self, rest: StaticState) -> StepSequence:
        """The steps for a small move, by the linear motion about the target.

        A start that is not at rest needs as many steps as there are poles.  At half a period
        the roots of two poles would coincide, and give one step for both: the spacing is then
        another.
        """
        poles = shaping.controllable_poles(*rest.linearised())
        if (poles.real > _UNSTABLE * np.abs(poles).max()).any():
            raise _unreachable(self.target, "the equilibrium there is unstable")
        moving = bool(self.displacement.any())
        spacing = shaping.impulse_spacing(poles) * (_UNEVEN_SPACING if moving else 1.0)
        parts = shaping.impulse_amplitudes(poles, spacing, 1 + len(self.robust_to))
        loads = self.start.load + (rest.load - self.start.load) * np.cumsum(parts)[:-1]
        return StepSequence(loads, np.full(loads.size, spacing))


def _with_values(single: Ensemble) -> Actuator:
    """The actuator with the values that its trajectory has."""
    actuator = require_actuator("actuator", single.system)
    for name, value in actuator.parameters().items():
        if single.values[name][0] != value:
            actuator = actuator.with_parameter(name, float(single.values[name][0]))
    return actuator


def _unreachable(target: float, why: str) -> InputError:
    return InputError(
        "target",
        must="be a thickness stretch that steps can reach at rest",
        got=target,
        why=f"For this actuator {why}.",
        fix="Pass one nearer to the start, or leave `robust_to` out.",
    )
