"""Where an actuator is after a sequence of constant loads, with all derivatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._field import Field
from remanent._typing import ArrayLike, FloatArray
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.integrate.variations import field_with_tangents
from remanent.models.actuator import Actuator
from remanent.models.drives.waves import Constant
from remanent.models.physical_sizes import PHYSICAL_SIZES
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.statics._static_state import StaticState

#: Half the relative change of a parameter in the difference by which insensitivity is judged.
_RELATIVE_PARAMETER_HALF_STEP = 1e-3


@dataclass(frozen=True)
class _StepEnd:
    """What a step of constant load comes to.

    Attributes
    ----------
    state : array (variant, state)
    fundamental : array (variant, state, state)
        Derivative by the state before the step.
    by_load, rate : array (variant, state)
        Derivatives by the load and by the time.
    error : array (variant,)
        Of the state, for an exact one before.
    """

    state: FloatArray
    fundamental: FloatArray
    by_load: FloatArray
    rate: FloatArray
    error: FloatArray


@dataclass(frozen=True)
class TerminalConditions:
    """Conditions that the state after a sequence of steps is one of rest.

    Attributes
    ----------
    actuator : Actuator
        What moves.
    target_rest : StaticState
        The body at rest at the target, under the last load.
    initial_state : array (state,) or None
        The state at τ = 0.
    robust_to : sequence of str
        Names of fields and physical sizes; the derivative by each of them of the distance
        from rest shall vanish too.
    motion_tolerance : float
        Of the states.
    """

    actuator: Actuator
    target_rest: StaticState
    initial_state: ArrayLike | None
    robust_to: Sequence[str]
    motion_tolerance: float

    def __call__(
        self, loads: FloatArray, durations: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """The conditions and their derivatives by loads and durations.

        Parameters
        ----------
        loads, durations : array (step,)

        Returns
        -------
        conditions : array (condition,)
        by_load, by_duration : array (condition, step)
        """
        state, by_load, by_duration = self._variant_final_states(loads, durations)
        moving = self.target_rest.moving_indices
        distance = (state - self._variant_rest_states)[:, moving]
        return (
            self._nominal_and_parameter_differences(distance),
            self._nominal_and_parameter_differences(by_load[:, moving]),
            self._nominal_and_parameter_differences(by_duration[:, moving]),
        )

    def nominal_residual(self, loads: FloatArray, durations: FloatArray) -> tuple[float, float]:
        """Largest distance of the actuator itself from rest after the steps, and its error.

        The error of each step is carried through the later ones by their fundamental matrices.

        Parameters
        ----------
        loads, durations : array (step,)
        """
        state = self.parameter_variants.initial_states
        error = np.zeros(state.shape[1])
        for load, duration in zip(loads, durations, strict=True):
            step = self._integrate_load_step(state, load, duration)
            state = step.state
            error = np.abs(step.fundamental[0]) @ error + step.error[0]
        moving = self.target_rest.moving_indices
        rounding = np.finfo(float).eps * np.abs(state[0]).max()
        distance = np.abs(state[0] - self._variant_rest_states[0])[moving].max()
        return float(distance), float(error[moving].max() + rounding)

    def _nominal_and_parameter_differences(self, values: FloatArray) -> FloatArray:
        """Values of the nominal actuator, then central differences by each parameter.

        Parameters
        ----------
        values : array (variant, state, ...)
        """
        pairs = values[1:].reshape(-1, 2, *values.shape[1:])
        slopes = (pairs[:, 1] - pairs[:, 0]) / (2.0 * _RELATIVE_PARAMETER_HALF_STEP)
        rows = np.concatenate([values[:1], slopes])
        return rows.reshape(rows.shape[0] * rows.shape[1], *rows.shape[2:])

    @cached_property
    def parameter_variants(self) -> Ensemble:
        """The actuator itself, then with each parameter a little less and a little more."""
        nominal = {**self.actuator.parameter_values(), **dict.fromkeys(PHYSICAL_SIZES, 1.0)}
        count = 1 + 2 * len(self.robust_to)
        over = {}
        for k, name in enumerate(self.robust_to):
            values = np.full(count, nominal[name])
            width = _RELATIVE_PARAMETER_HALF_STEP * (nominal[name] or 1.0)
            values[1 + 2 * k : 3 + 2 * k] += np.array([-1.0, 1.0]) * width
            over[name] = xr.DataArray(values, dims="variant")
        return lay_out_ensemble(
            self.actuator, Constant(self.target_rest.magnetic_load), over, self.initial_state
        )

    @cached_property
    def _variant_rest_states(self) -> FloatArray:
        """States of rest of all variants under the last load, array (variant, state)."""
        ens = self.parameter_variants
        columns = np.column_stack(
            [ens.parameter_values[name] for name in ens.vector_field.parameter_names]
        )
        # The physical sizes are parameters of the variants only.
        rest = replace(self.target_rest, vector_field=ens.vector_field)
        bodies = [replace(rest, parameters=row).rest_nearby() for row in columns]
        states = [body.state for body in bodies if body is not None]
        if len(states) < len(bodies):
            raise InputError(
                "robust_to",
                must="name fields whose small changes leave a state of rest",
                got=self.robust_to,
                why="The target is at the edge of where rest is possible.",
                fix="Leave it out.",
            )
        return np.array(states)

    @cached_property
    def _variational_vector_field(self) -> Field:
        """The motion with its derivatives by the initial state and by the load."""
        field = self.parameter_variants.vector_field
        return field_with_tangents(field, directions=len(field.state_names), parameters=("m",))

    def _variant_final_states(
        self, loads: FloatArray, durations: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """States after the last step and their derivatives, of all variants.

        The derivatives by earlier loads and durations are carried through each step by its
        fundamental matrix; those by the step's own load and duration are added to them.

        Returns
        -------
        states : array (variant, state)
        by_load, by_duration : array (variant, state, step)
        """
        ens, d = self.parameter_variants, len(self.target_rest.state)
        state = ens.initial_states
        by_load = np.zeros((ens.trajectory_count, d, loads.size))
        by_duration = np.zeros_like(by_load)
        for k, (load, duration) in enumerate(zip(loads, durations, strict=True)):
            step = self._integrate_load_step(state, load, duration)
            state = step.state
            by_load, by_duration = step.fundamental @ by_load, step.fundamental @ by_duration
            by_load[:, :, k], by_duration[:, :, k] = step.by_load, step.rate
        return state, by_load, by_duration

    def _integrate_load_step(self, state: FloatArray, load: float, duration: float) -> _StepEnd:
        """One step from `state` (variant, state)."""
        ens, d = self.parameter_variants, len(self.target_rest.state)
        problem = initial_value_problem(ens, np.full(ens.trajectory_count, duration))
        problem.parameters[:, ens.vector_field.parameter_names.index("m")] = load
        unit = np.tile(np.eye(d).ravel(), (ens.trajectory_count, 1))
        start = np.hstack([state, unit, np.zeros((ens.trajectory_count, d))])
        outcome = integrate(
            replace(problem, field=self._variational_vector_field, initial_states=start),
            Request(times=problem.duration[:, None]),
            tolerance=self.motion_tolerance,
        )
        assert outcome.states is not None
        ends = outcome.states[:, 0]
        state, columns = ends[:, :d], ends[:, d:].reshape(ens.trajectory_count, d + 1, d)
        rates = ens.vector_field.rates([0.0, *state.T, *problem.parameters.T], functions=np)
        return _StepEnd(
            state,
            np.moveaxis(columns[:, :d], 1, 2),
            columns[:, d],
            np.column_stack(rates),
            outcome.error,
        )
