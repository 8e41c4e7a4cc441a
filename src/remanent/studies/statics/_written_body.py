"""A member of an ensemble of systems of one's own, where nothing moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from remanent._field import Role
from remanent._typing import FloatArray, IntArray
from remanent.analysis.orbits.cell_samples import Sample
from remanent.analysis.orbits.cells import zeros_by_cells
from remanent.analysis.orbits.maps import MapImage
from remanent.analysis.orbits.periodic_orbits import (
    distinct_orbits_of_least_period,
    newton_fixed_points,
)
from remanent.analysis.statics.rounding import RoundedDual, RoundedDualFunctions
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.statics._static_errors import largest

#: First cells along each unknown, by how many unknowns there are.
_FIRST_CELL_COUNTS = (64, 24, 10, 6, 4)
#: A curve on which the rates are no larger than this is a continuum of equilibria.
_FLATNESS = 1e-10
#: Evaluations of the rates in one search.
_MAX_EVALUATIONS = 4e6
#: Largest rate at an equilibrium, beside rounding.
_MAX_RATE = 1e-12
#: Step of a complex difference.
_COMPLEX_STEP = 1e-100
#: No parameter is changed.
_UNCHANGED: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True)
class WrittenBody:
    """One member of an ensemble: its rates at states where nothing moves.

    Attributes
    ----------
    ens : Ensemble
        Under a constant load.
    case : int
        Number of the member.
    """

    ens: Ensemble
    case: int

    @cached_property
    def unknown(self) -> IntArray:
        """State variables that rest determines: coordinates and internal variables."""
        return np.array(self.ens.vector_field.indices_of_roles(Role.COORDINATE, Role.INTERNAL))

    @property
    def dimension(self) -> int:
        """Number of unknowns."""
        return self.unknown.size

    @cached_property
    def moving(self) -> IntArray:
        """All state variables."""
        return np.arange(len(self.ens.vector_field.variables))

    @cached_property
    def inertial(self) -> IntArray:
        """Rates of coordinates."""
        return np.array(self.ens.vector_field.indices_of_roles(Role.RATE), dtype=np.int64)

    @cached_property
    def balanced(self) -> IntArray:
        """State variables whose rates vanish at rest by a balance, not by definition."""
        variables = self.ens.vector_field.variables
        with_rate = {v.belongs_to for v in variables if v.role is Role.RATE}
        return np.array([k for k, v in enumerate(variables) if v.name not in with_rate])

    def parameters(self, changed: Mapping[str, Any] = _UNCHANGED) -> list[Any]:
        """Values of the numeric fields, those of `changed` in place of the member's own."""
        own = self.ens.parameter_values
        return [
            changed[name] if name in changed else float(own[name][self.case])
            for name in self.ens.vector_field.parameter_names
        ]

    def states(self, places: Any) -> Any:
        """Whole states at places (point, unknown), array (point, state)."""
        states = np.zeros((len(places), self.moving.size), dtype=np.asarray(places).dtype)
        states[:, self.unknown] = places
        return states

    def rates(self, states: Any, changed: Mapping[str, Any] = _UNCHANGED) -> Any:
        """Rates of states (point, state)."""
        inputs = [0.0, *states.T, *self.parameters(changed)]
        with np.errstate(all="ignore"):
            values = self.ens.vector_field.rates(inputs, functions=np)
        return np.stack([np.broadcast_to(v, len(states)) for v in values], axis=1)

    def rate_derivatives(
        self, states: FloatArray, changed: Mapping[str, Any] = _UNCHANGED
    ) -> FloatArray:
        """Derivatives of all rates by the whole state, array (point, state, state)."""
        columns = [
            self.rates(states + 1j * _COMPLEX_STEP * direction, changed).imag / _COMPLEX_STEP
            for direction in np.eye(self.moving.size)
        ]
        return np.stack(columns, axis=2)

    def balance(self, places: FloatArray, changed: Mapping[str, Any] = _UNCHANGED) -> FloatArray:
        """The rates that vanish at equilibria, array (point, unknown)."""
        return np.asarray(self.rates(self.states(places), changed)[:, self.balanced])

    def stiffness(self, places: FloatArray, changed: Mapping[str, Any] = _UNCHANGED) -> FloatArray:
        """Derivatives of the balance by the unknowns, array (point, unknown, unknown)."""
        derivatives = self.rate_derivatives(self.states(places), changed)
        return np.asarray(derivatives[:, self.balanced][:, :, self.unknown])

    def balance_slope(self, places: FloatArray, name: str, values: FloatArray) -> FloatArray:
        """Derivative of the balance by a parameter, array (point, unknown)."""
        moved = {name: values + 1j * _COMPLEX_STEP}
        rates = self.rates(self.states(places).astype(np.complex128), moved)
        return np.asarray(rates.imag[:, self.balanced] / _COMPLEX_STEP)

    def balance_rounding(
        self, places: FloatArray, changed: Mapping[str, Any] = _UNCHANGED
    ) -> tuple[FloatArray, FloatArray]:
        """The balance that rounding may leave, and what it did at most, (point, unknown)."""
        numbers = [RoundedDual.variable(column, 0.0) for column in self.states(places).T]
        columns = [RoundedDual.variable(np.asarray(p), 0.0) for p in self.parameters(changed)]
        with np.errstate(all="ignore"):
            rates = self.ens.vector_field.rates(
                [RoundedDual.constant(0.0), *numbers, *columns],
                functions=RoundedDualFunctions, constant=RoundedDual.constant,
            )  # fmt: skip
            left, bound = (
                np.stack([np.broadcast_to(of(rates[k]), len(places)) for k in self.balanced], 1)
                for of in (lambda rate: largest(rate.value), lambda rate: rate.value.bound)
            )
        return left, bound

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        """Places plus their balanced rates: a map whose fixed points are the equilibria."""
        sample = self.sample(states, 0.0, None)
        jacobian = sample.derivative + np.eye(states.shape[1])
        empty = np.zeros((*states.shape, 0))
        return MapImage(states + sample.value, jacobian, empty, sample.error)

    def sample(self, points: FloatArray, tolerance: float, effort: IntArray | None) -> Sample:
        """See :class:`remanent.analysis.orbits.cell_samples.SampledFunction`."""
        derivative = self.stiffness(points)
        with np.errstate(all="ignore"):
            size = np.abs(derivative).max(axis=(1, 2)) * (1.0 + np.abs(points).max(axis=1))
        return Sample(
            self.balance(points), derivative, 8.0 * np.finfo(float).eps * (1.0 + size),
            np.ones(len(points), dtype=np.int64),
        )  # fmt: skip

    def equilibria(self, box: FloatArray) -> tuple[FloatArray, str]:
        """All equilibria in a box, array (equilibrium, unknown), and what may be missing."""
        d = len(box)
        count = _FIRST_CELL_COUNTS[min(d, len(_FIRST_CELL_COUNTS)) - 1]
        cells = zeros_by_cells(
            self.sample, [np.linspace(low, high, count + 1) for low, high in box],
            flatness=_FLATNESS, max_effort=_MAX_EVALUATIONS,
        )  # fmt: skip
        none = np.empty((len(cells.starts), 0))
        points = newton_fixed_points(
            self, cells.starts, none, iterate=1, tolerance=_MAX_RATE, box=box
        )
        points = distinct_orbits_of_least_period(self, points, np.empty(0), iterate=1)
        order = np.lexsort(points.state.T[::-1])
        reason = ""
        if len(cells.flat):
            reason = "equilibria form a curve, of which single points cannot be listed"
        elif len(cells.unresolved):
            reason = "in parts of the box it could not be told whether there is an equilibrium"
        return points.state[order], reason

    def position_errors(self, places: FloatArray) -> FloatArray:
        """What rounding in the rates makes of places of equilibria, array (point, unknown)."""
        left, _ = self.balance_rounding(places)
        with np.errstate(all="ignore"):
            error = np.einsum("pij,pj->pi", np.abs(np.linalg.pinv(self.stiffness(places))), left)
        return np.asarray(error + np.finfo(float).eps * np.abs(places))

    def observable(self, name: str, states: Any, changed: Mapping[str, Any] = _UNCHANGED) -> Any:
        """A function of the state at states (point, state), array (point,)."""
        program = self.ens.vector_field.observables[name]
        with np.errstate(all="ignore"):
            (value,) = program([0.0, *states.T, *self.parameters(changed)], functions=np)
        return np.broadcast_to(value, len(states))

    def observable_slopes(
        self, name: str, states: FloatArray, changed: Mapping[str, Any] = _UNCHANGED
    ) -> FloatArray:
        """Its derivatives by the unknowns, array (point, unknown)."""
        directions = 1j * _COMPLEX_STEP * np.eye(states.shape[1])[self.unknown]
        slopes = [self.observable(name, states + d, changed).imag for d in directions]
        return np.asarray(np.stack(slopes, axis=1) / _COMPLEX_STEP)

    def observable_with_rounding(
        self, name: str, places: FloatArray, changed: Mapping[str, Any] = _UNCHANGED
    ) -> RoundedDual:
        """A function of the state, its slope by the first unknown, and bounds of their rounding."""
        states, first = self.states(places), int(self.unknown[0])
        numbers = [RoundedDual.variable(c, float(k == first)) for k, c in enumerate(states.T)]
        columns = [RoundedDual.variable(np.asarray(p), 0.0) for p in self.parameters(changed)]
        with np.errstate(all="ignore"):
            values: list[RoundedDual] = self.ens.vector_field.observables[name](
                [RoundedDual.constant(0.0), *numbers, *columns],
                functions=RoundedDualFunctions, constant=RoundedDual.constant,
            )  # fmt: skip
        return values[0]

    def observable_with_error(
        self,
        name: str,
        states: FloatArray,
        errors: FloatArray,
        changed: Mapping[str, Any] = _UNCHANGED,
    ) -> tuple[FloatArray, FloatArray]:
        """A function of the state, and its slopes times the errors of places, with rounding."""
        value = np.asarray(self.observable(name, states, changed), dtype=np.float64)
        slopes = np.abs(self.observable_slopes(name, states, changed))
        rounding = 16.0 * np.finfo(float).eps * (1.0 + np.abs(value))
        return value, (slopes * errors).sum(axis=1) + rounding
