"""Forces and potentials of an ensemble that does not move."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from remanent._field import Program, Role, StateVariable
from remanent._roots import find_roots
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.statics.rounding import RoundedDual, RoundedDualFunctions
from remanent.studies.ensemble.ensemble import Ensemble

#: Stretches at which the force is computed, to find where it changes its sign.
DEFAULT_STRETCH_GRID = np.geomspace(0.05, 20.0, 4001)
#: Distance from the limits of a material, as a share of the way to them, within which rounding
#: decides the sign of the force, which grows without bound there: nothing is sought so near.
_LIMIT_MARGIN = 1e-12

#: Values of parameters that stand in place of the ensemble's own, by name.
ParameterOverrides = Mapping[str, FloatArray]


@dataclass(frozen=True)
class StaticEnsemble:
    """The field of an ensemble at zero rates, branches relaxed, at the surroundings' temperature.

    Stretches are given for each coordinate, arrays (point,); differences of stretches
    that the state holds as well are 1.
    """

    ensemble: Ensemble

    @cached_property
    def stretch_grid(self) -> FloatArray:
        """Equal stretches on which zeros are sought, array (point,) or (case, point).

        Where the material has limits they are the ends, and points are dense there.
        """
        cases = np.arange(self.ensemble.trajectory_count)
        inside = self.is_reachable(cases[:, None], DEFAULT_STRETCH_GRID, DEFAULT_STRETCH_GRID)
        if inside.all():
            return DEFAULT_STRETCH_GRID
        rest = DEFAULT_STRETCH_GRID.size // 2
        outside = np.argmin(inside[:, rest:], axis=1), np.argmin(inside[:, rest::-1], axis=1)
        top = self._last_reachable_stretch(
            np.minimum(rest + outside[0], DEFAULT_STRETCH_GRID.size - 1), -1, outside[0] == 0
        )
        bottom = self._last_reachable_stretch(np.maximum(rest - outside[1], 0), 1, outside[1] == 0)
        share = 0.5 - 0.5 * np.cos(np.linspace(0.0, np.pi, DEFAULT_STRETCH_GRID.size))
        share = _LIMIT_MARGIN + (1.0 - 2.0 * _LIMIT_MARGIN) * share
        return np.asarray(bottom[:, None] * (top / bottom)[:, None] ** share)

    def _last_reachable_stretch(
        self, outside: IntArray, inward: int, unlimited: BoolArray
    ) -> FloatArray:
        """The last stretch that can be reached, between two neighbours on the grid."""
        last = np.where(
            unlimited,
            DEFAULT_STRETCH_GRID[-1 if inward < 0 else 0],
            DEFAULT_STRETCH_GRID[outside + inward],
        )
        case = np.flatnonzero(~unlimited)
        if case.size:
            last[case] = bisect_last_inside(
                lambda x, i: self.is_reachable(i, x, x),
                last[case],
                DEFAULT_STRETCH_GRID[outside[case]],
                case,
            )
        return last

    def is_reachable(self, case: IntArray, first: FloatArray, second: FloatArray) -> BoolArray:
        """Whether the material reaches in-plane stretches, arrays that broadcast with `case`."""
        columns = {name: value[case] for name, value in self.ensemble.parameter_values.items()}
        inside = self.ensemble.system.where_admissible(columns, first, second)
        return np.broadcast_to(inside, np.broadcast_shapes(case.shape, first.shape))

    def first_acceleration(
        self, case: IntArray, stretch: FloatArray, changed: ParameterOverrides | None = None
    ) -> FloatArray:
        """The acceleration of the first coordinate, which has the sign of the force."""
        return np.asarray(self.accelerations(case, stretch, changed=changed)[0])

    def first_acceleration_function(
        self, name: str
    ) -> Callable[[IntArray, FloatArray, FloatArray], FloatArray]:
        """The same as a function of case, stretch and one parameter."""
        return lambda case, stretch, value: self.first_acceleration(case, stretch, {name: value})

    def accelerations(
        self, case: IntArray, *stretches: Any, changed: ParameterOverrides | None = None
    ) -> list[Any]:
        """Acceleration of each coordinate."""
        rates = self.evaluate_program(
            self.ensemble.vector_field.rates, case, *stretches, changed=changed
        )
        return [rates[k] for k in self.ensemble.vector_field.indices_of_roles(Role.RATE)]

    def thickness(self, case: IntArray, *stretches: FloatArray) -> FloatArray:
        """The thickness stretch."""
        (thickness,) = self.evaluate_program(
            self.ensemble.vector_field.observables["thickness_stretch"], case, *stretches
        )
        return np.asarray(thickness)

    def potential(
        self, case: IntArray, *stretches: FloatArray, changed: ParameterOverrides | None = None
    ) -> FloatArray:
        """The energy."""
        program = self.ensemble.vector_field.observables["energy"]
        (energy,) = self.evaluate_program(program, case, *stretches, changed=changed)
        return np.asarray(energy)

    def states_at(self, case: IntArray, *stretches: FloatArray) -> FloatArray:
        """The whole states at rest at stretches, arrays (point,): array (point, state)."""
        values = {name: column[case] for name, column in self.ensemble.parameter_values.items()}
        columns = [
            np.broadcast_to(self._static_value(v, stretches, values), case.shape)
            for v in self.ensemble.vector_field.variables
        ]
        return np.stack(columns, axis=-1)

    def evaluate_program(
        self,
        program: Program,
        case: IntArray,
        *stretches: Any,
        changed: ParameterOverrides | None = None,
    ) -> list[Any]:
        """Outputs of a program of the field, each an array (point,)."""
        values = {name: column[case] for name, column in self.ensemble.parameter_values.items()}
        values |= changed or {}
        state = [
            self._static_value(v, stretches, values) for v in self.ensemble.vector_field.variables
        ]
        columns = [values[name] for name in self.ensemble.vector_field.parameter_names]
        with np.errstate(all="ignore"):
            outputs = program([0.0, *state, *columns], functions=np)
        return [np.broadcast_to(value, np.shape(stretches[0])) for value in outputs]

    def evaluate_with_rounding(
        self,
        program: Program,
        case: IntArray,
        *stretches: FloatArray,
        along: str = "",
        changed: ParameterOverrides | None = None,
    ) -> list[RoundedDual]:
        """Outputs with bounds of their rounding, and their derivatives.

        Parameters
        ----------
        program : Program
            Of the field.
        case : array (point,) of int
        *stretches : array (point,)
        along : str
            The parameter by which is derived; by default the first stretch.
        changed : mapping of name to array (point,), optional
            Values that stand in place of the ensemble's own.
        """
        values = {name: column[case] for name, column in self.ensemble.parameter_values.items()}
        values |= changed or {}
        moved = (stretches[0] + 1j, *stretches[1:]) if not along else stretches
        state = []
        for variable in self.ensemble.vector_field.variables:
            place = self._static_value(variable, moved, values)
            slope = np.imag(place) if np.iscomplexobj(place) else 0.0
            state.append(RoundedDual.variable(np.real(place), slope))
        columns = [
            RoundedDual.variable(values[name], float(name == along))
            for name in self.ensemble.vector_field.parameter_names
        ]
        phase = RoundedDual.constant(0.0)
        with np.errstate(all="ignore"):
            return program(
                [phase, *state, *columns],
                functions=RoundedDualFunctions,
                constant=RoundedDual.constant,
            )

    def first_acceleration_with_rounding(
        self,
        case: IntArray,
        *stretches: FloatArray,
        along: str = "",
        changed: ParameterOverrides | None = None,
    ) -> RoundedDual:
        """The first acceleration, :meth:`evaluate_with_rounding`."""
        field = self.ensemble.vector_field
        rates = self.evaluate_with_rounding(
            field.rates, case, *stretches, along=along, changed=changed
        )
        return rates[field.indices_of_roles(Role.RATE)[0]]

    def potential_with_rounding(
        self,
        case: IntArray,
        *stretches: FloatArray,
        along: str = "",
        changed: ParameterOverrides | None = None,
    ) -> RoundedDual:
        """The energy, :meth:`evaluate_with_rounding`."""
        program = self.ensemble.vector_field.observables["energy"]
        return self.evaluate_with_rounding(program, case, *stretches, along=along, changed=changed)[
            0
        ]

    def thickness_with_rounding(self, case: IntArray, *stretches: FloatArray) -> RoundedDual:
        """The thickness stretch, :meth:`evaluate_with_rounding`."""
        program = self.ensemble.vector_field.observables["thickness_stretch"]
        return self.evaluate_with_rounding(program, case, *stretches)[0]

    def _static_value(
        self, variable: StateVariable, stretches: Sequence[Any], values: Mapping[str, FloatArray]
    ) -> Any:
        """A state variable where nothing moves and internal variables have relaxed."""
        field = self.ensemble.vector_field
        if variable.role is Role.VARIATION:
            varied = variable.belongs_to
            moves = varied is not None and field.state_variable(varied).role is Role.RATE
            return np.full(np.shape(stretches[0]), 0.0 if moves else 1.0)
        if variable.role is Role.RATE:
            return np.zeros(np.shape(stretches[0]))
        coordinate = variable.name if variable.role is Role.COORDINATE else variable.belongs_to
        if coordinate is None:
            return variable.value_at_rest(values)
        # Equal stretches are given once, and so is the one coordinate that stands for both.
        return (
            stretches[-1]
            if field.names_of_roles(Role.COORDINATE).index(coordinate)
            else stretches[0]
        )


def bisect_last_inside(
    inside: Callable[..., BoolArray], near: FloatArray, far: FloatArray, index: IntArray
) -> FloatArray:
    """The last numbers with `inside(number, index)`, from `near`, where it holds, to `far`."""
    solved = find_roots(lambda x, i: np.where(inside(x, i), 1.0, -1.0), (near, far), args=(index,))
    return np.asarray(np.where(solved.f_bracket[0] > 0.0, *solved.bracket))
