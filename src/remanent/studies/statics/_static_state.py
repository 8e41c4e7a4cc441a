"""States of rest of any actuator, and the energy of a state above them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import root

from remanent._field import Field, Role
from remanent._typing import FloatArray

#: Step of complex differences: its square vanishes beside 1, so nothing is cut off.
_COMPLEX_STEP = 1e-100
_GAUSS_RULE = np.polynomial.legendre.leggauss(24)
#: Nodes of the Gauss rule on [-1, 1].
_GAUSS_NODES = _GAUSS_RULE[0]
#: Weights of the Gauss rule.
_GAUSS_WEIGHTS = _GAUSS_RULE[1]
#: Unbalance, relative to the load, above which nothing is at rest.
_MAX_RELATIVE_UNBALANCE = 1e-9
#: Tolerance of the root finder: the last digit.
_ROOT_TOLERANCE = 1e-15


@dataclass(frozen=True)
class StaticState:
    """A state of the field of an actuator under a constant load, for one set of its parameters.

    Attributes
    ----------
    vector_field
        Of the actuator and a ``Constant`` drive.
    parameters : array (parameter,)
        In the order of ``vector_field.parameter_names``; the load `m` among them.
    state : array (state,)
        What does not follow from rest (a temperature) is taken from it.
    """

    vector_field: Field
    parameters: FloatArray
    state: FloatArray

    @cached_property
    def free_indices(self) -> list[int]:
        """State variables that rest determines: stretches and internal variables."""
        return self.vector_field.indices_of_roles(Role.COORDINATE, Role.INTERNAL)

    @cached_property
    def moving_indices(self) -> list[int]:
        """Those and the rates of stretches."""
        return self.vector_field.indices_of_roles(Role.COORDINATE, Role.RATE, Role.INTERNAL)

    @cached_property
    def balanced_indices(self) -> list[int]:
        """State variables whose rates vanish at rest by a balance, not by definition."""
        variables = [self.vector_field.variables[k] for k in self.moving_indices]
        has_rate = {v.belongs_to for v in variables if v.role is Role.RATE}
        return [
            k for k, v in zip(self.moving_indices, variables, strict=True) if v.name not in has_rate
        ]

    @property
    def magnetic_load(self) -> float:
        """The magnetic load."""
        return float(self.parameters[self.vector_field.parameter_names.index("m")])

    def with_load(self, load: float) -> StaticState:
        """The same state under another load."""
        values = self.parameters.copy()
        values[self.vector_field.parameter_names.index("m")] = load
        return replace(self, parameters=values)

    def rest_at_thickness(self, thickness: float) -> StaticState | None:
        """The state of rest with a thickness stretch, under the load for it, if there is one."""

        def unbalance(u: FloatArray) -> FloatArray:
            return np.real(self._unbalance(u[:-1], u[-1], thickness))

        guess = np.full(len(self.free_indices), thickness**-0.5)
        solution = root(
            unbalance,
            np.append(guess, self.magnetic_load),
            jac=self._jacobian,
            tol=_ROOT_TOLERANCE,
        )
        if not self._is_at_rest(solution.fun, solution.x[:-1], float(solution.x[-1])):
            return None
        return self.with_load(float(solution.x[-1]))._with_free_values(solution.x[:-1])

    def rest_nearby(self) -> StaticState | None:
        """The state of rest nearby under the same load, if there is one."""

        def unbalance(u: FloatArray) -> FloatArray:
            return np.real(self._unbalance(u, self.magnetic_load)[:-1])

        def jacobian(u: FloatArray) -> FloatArray:
            return self._jacobian(np.append(u, self.magnetic_load))[:-1, :-1]

        solution = root(unbalance, self.state[self.free_indices], jac=jacobian, tol=_ROOT_TOLERANCE)
        if not self._is_at_rest(solution.fun, solution.x, self.magnetic_load):
            return None
        return self._with_free_values(solution.x)

    def _is_at_rest(self, unbalance: FloatArray, free: FloatArray, load: float) -> bool:
        """Whether a root finder found a balance, and a body that can be: stretches are positive."""
        has_meaning = [
            value > 0.0 or not self.vector_field.variables[k].positive
            for k, value in zip(self.free_indices, free, strict=True)
        ]
        balanced = np.abs(unbalance).max() < _MAX_RELATIVE_UNBALANCE * (1.0 + abs(load))
        return bool(balanced) and all(has_meaning)

    def thickness_stiffness(self) -> float:
        """Force on the thickness stretch, over its change, from rest to rest; NaN where none is."""
        u = np.append(self.state[self.free_indices], self.magnetic_load)
        try:
            compliance = np.linalg.solve(self._jacobian(u), np.eye(len(u))[-1])[-1]
        except np.linalg.LinAlgError:  # no load changes it, or any does
            return np.nan
        return float(compliance * self._conjugate_thickness_slope())

    def rate_derivatives(self) -> tuple[FloatArray, FloatArray]:
        """Derivatives of the rates by the moving state variables, and by the load."""
        moved = [self._rate_derivative_by_state(k) for k in self.moving_indices]
        column = 1 + len(self.state) + self.vector_field.parameter_names.index("m")
        return np.column_stack(moved), self._rate_derivative_by_input(column)[self.moving_indices]

    def excess_energies_of(self, states: FloatArray) -> FloatArray:
        """Energies of other states (..., state) above that of this one.

        The gradient is integrated along the straight line between them, which loses no
        digits where they are close.  Its component along the line is a complex step.
        """
        moves = np.isin(np.arange(self.state.size), self.moving_indices)
        way = np.moveaxis(np.where(moves, states - self.state, 0.0), -1, 0)[..., None]
        fraction = 0.5 * (1.0 + _GAUSS_NODES) + 1j * _COMPLEX_STEP
        inputs = [
            0.0 * fraction,
            *(rest + part * fraction for rest, part in zip(self.state, way, strict=True)),
            *self.parameters,
        ]
        (energy,) = self.vector_field.observables["energy"](inputs, functions=np)
        return np.asarray(0.5 * (np.imag(energy) / _COMPLEX_STEP) @ _GAUSS_WEIGHTS)

    def thickness(self) -> float:
        """The thickness stretch."""
        inputs = [0.0, *self.state, *self.parameters]
        return float(
            self.vector_field.observables[self.vector_field.observable_name](inputs, functions=np)[
                0
            ]
        )

    def _with_free_values(self, free: FloatArray) -> StaticState:
        state = np.where([r is Role.RATE for r in self.vector_field.roles], 0.0, self.state)
        state[self.free_indices] = free
        return replace(self, state=state)

    def _unbalance(self, free: Any, load: Any, thickness: float = 0.0) -> Any:
        state = self._with_free_values(np.real(free)).state.astype(np.complex128)
        state[self.free_indices] = free
        values = self.parameters.astype(np.complex128)
        values[self.vector_field.parameter_names.index("m")] = load
        inputs = [0.0, *state, *values]
        with np.errstate(all="ignore"):  # a root finder may try what has no meaning
            rates = self.vector_field.rates(inputs, functions=np)
            (x,) = self.vector_field.observables[self.vector_field.observable_name](
                inputs, functions=np
            )
        return np.array([*(rates[k] for k in self.balanced_indices), x - thickness])

    def _jacobian(self, u: FloatArray) -> FloatArray:
        columns = []
        for k in range(len(u)):
            moved = u.astype(np.complex128)
            moved[k] += 1j * _COMPLEX_STEP
            columns.append(np.imag(self._unbalance(moved[:-1], moved[-1])) / _COMPLEX_STEP)
        return np.column_stack(columns)

    def _rate_derivative_by_state(self, k: int) -> FloatArray:
        return self._rate_derivative_by_input(1 + k)[self.moving_indices]

    def _rate_derivative_by_input(self, column: int) -> FloatArray:
        """Derivative of the rates by one input."""
        inputs = np.array([0.0, *self.state, *self.parameters], dtype=np.complex128)
        inputs[column] += 1j * _COMPLEX_STEP
        return (
            np.imag(np.array(self.vector_field.rates(list(inputs), functions=np))) / _COMPLEX_STEP
        )

    def _conjugate_thickness_slope(self) -> float:
        """Minus the derivative of the energy by the load, over the thickness stretch."""
        inputs = np.array([0.0, *self.state, *self.parameters], dtype=np.complex128)
        inputs[1 + len(self.state) + self.vector_field.parameter_names.index("m")] += (
            1j * _COMPLEX_STEP
        )
        (energy,) = self.vector_field.observables["energy"](list(inputs), functions=np)
        return float(-np.imag(energy) / _COMPLEX_STEP / self.thickness())
