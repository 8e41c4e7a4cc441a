"""Equilibria of a system of one's own: all zeros of its rates in a box."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from remanent._field import Role
from remanent._status import Status
from remanent._typing import ComplexArray, FloatArray, IntArray
from remanent.analysis.orbits.cell_samples import Sample
from remanent.analysis.orbits.cells import zeros_by_cells
from remanent.analysis.orbits.maps import MapImage
from remanent.analysis.orbits.periodic_orbits import (
    distinct_orbits_of_least_period,
    newton_fixed_points,
)
from remanent.analysis.statics.rounding import RoundedDual, RoundedDualFunctions
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.statics._static_box import require_static_box
from remanent.studies.statics._static_errors import largest, square_root_error

#: First cells along each unknown, by how many unknowns there are.
_FIRST_CELL_COUNTS = (64, 24, 10, 6, 4)
#: A curve on which the rates are no larger than this is a continuum of equilibria.
_FLATNESS = 1e-10
#: Evaluations of the rates in one search.
_MAX_EVALUATIONS = 4e6
#: Largest rate at an equilibrium, beside rounding.
_MAX_RATE = 1e-12
#: Share of the largest eigenvalue below which the sign of a real part is not told.
_UNDECIDED_SHARE = 1e-7
#: Roundings in an entry of a matrix of derivatives.
_MATRIX_ROUNDINGS = 6.0
#: Step of a complex difference.
_COMPLEX_STEP = 1e-100


@np.errstate(all="ignore")  # rates and slopes may be infinite
def written_equilibria(ens: Ensemble, state_box: Mapping[str, Any] | None) -> xr.Dataset:
    """Equilibria of every member of an ensemble under a constant load."""
    bodies = [_Body(ens, k) for k in range(ens.trajectory_count)]
    box = require_static_box(state_box, ens, bodies[0].unknown)
    found = [
        (np.empty((0, len(box))), "") if invalid else body.equilibria(box)
        for body, invalid in zip(bodies, ens.is_invalid, strict=True)
    ]
    count = max((len(places) for places, _ in found), default=0)
    rows = [
        _properties(body, places, count) for body, (places, _) in zip(bodies, found, strict=True)
    ]
    variables: dict[str, PerTrajectoryArray] = {}
    for name in rows[0]:
        stacked = np.stack([row[name] for row in rows])
        last = {"natural_frequency": "mode", "eigenvalues": "eigenvalue"}
        dim = last.get(name.removesuffix("_error"))
        dims = ("equilibrium", dim) if dim and stacked.ndim > 2 else ("equilibrium",)
        variables[name] = (dims, stacked)
    reasons = np.array([reason for _, reason in found])
    status = np.where(
        ens.is_invalid, Status.INVALID, np.where(reasons != "", Status.INCOMPLETE, Status.OK)
    )
    coords = {"equilibrium": (("equilibrium",), np.arange(count))}
    sizes = {"mode": bodies[0].inertial.size, "eigenvalue": bodies[0].moving.size}
    coords |= {
        dim: ((dim,), np.arange(size))
        for dim, size in sizes.items()
        if any(dim in labelled[0] for labelled in variables.values())
    }
    return to_dataset(
        ens, {**variables, "reason": reasons}, coords=coords, status=status.astype(np.int8),
        tolerance=None, state_box=box.ravel(),
    )  # fmt: skip


@dataclass(frozen=True)
class _Body:
    """One member of an ensemble: its rates at states where nothing moves.

    Attributes
    ----------
    ens : Ensemble
    case : int
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

    @cached_property
    def parameters(self) -> list[float]:
        """Values of the numeric fields."""
        names = self.ens.vector_field.parameter_names
        return [float(self.ens.parameter_values[name][self.case]) for name in names]

    def states(self, places: Any) -> Any:
        """Whole states at places (point, unknown), array (point, state)."""
        states = np.zeros((len(places), self.moving.size), dtype=np.asarray(places).dtype)
        states[:, self.unknown] = places
        return states

    def rates(self, states: Any) -> Any:
        """Rates of states (point, state)."""
        with np.errstate(all="ignore"):
            values = self.ens.vector_field.rates([0.0, *states.T, *self.parameters], functions=np)
        return np.stack([np.broadcast_to(v, len(states)) for v in values], axis=1)

    def rate_derivatives(self, states: FloatArray) -> FloatArray:
        """Derivatives of all rates by the whole state, array (point, state, state)."""
        columns = [
            self.rates(states + 1j * _COMPLEX_STEP * direction).imag / _COMPLEX_STEP
            for direction in np.eye(self.moving.size)
        ]
        return np.stack(columns, axis=2)

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        """Places plus their balanced rates: a map whose fixed points are the equilibria."""
        sample = self.sample(states, 0.0, None)
        jacobian = sample.derivative + np.eye(states.shape[1])
        empty = np.zeros((*states.shape, 0))
        return MapImage(states + sample.value, jacobian, empty, sample.error)

    def sample(self, points: FloatArray, tolerance: float, effort: IntArray | None) -> Sample:
        """See :class:`remanent.analysis.orbits.cell_samples.SampledFunction`."""
        states = self.states(points)
        value = self.rates(states)[:, self.balanced]
        derivative = self.rate_derivatives(states)[:, self.balanced][:, :, self.unknown]
        with np.errstate(all="ignore"):
            size = np.abs(derivative).max(axis=(1, 2)) * (1.0 + np.abs(points).max(axis=1))
        return Sample(
            value, derivative, 8.0 * np.finfo(float).eps * (1.0 + size),
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
        states = self.states(places)
        derivative = self.rate_derivatives(states)[:, self.balanced][:, :, self.unknown]
        numbers = [RoundedDual.variable(column, 0.0 * column) for column in states.T]
        columns = [RoundedDual.variable(np.asarray(p), 0.0) for p in self.parameters]
        with np.errstate(all="ignore"):
            rates = self.ens.vector_field.rates(
                [RoundedDual.constant(0.0), *numbers, *columns],
                functions=RoundedDualFunctions, constant=RoundedDual.constant,
            )  # fmt: skip
            left = np.stack(
                [np.broadcast_to(largest(rates[k].value), len(places)) for k in self.balanced],
                axis=1,
            )
            error = np.einsum("pij,pj->pi", np.abs(np.linalg.pinv(derivative)), left)
        return np.asarray(error + np.finfo(float).eps * np.abs(places))


def _properties(body: _Body, places: FloatArray, count: int) -> dict[str, np.ndarray[Any, Any]]:
    """What is known of the equilibria of one body, each array (equilibrium, ...), filled up."""
    field = body.ens.vector_field
    states, errors = body.states(places), body.position_errors(places)
    derivatives = body.rate_derivatives(states)
    eigenvalues = _sorted_eigenvalues(derivatives)
    change = _derivative_changes(body, states, errors)
    columns: dict[str, np.ndarray[Any, Any]] = {}
    for position, k in enumerate(body.unknown):
        name = field.state_names[k]
        columns[name], columns[f"{name}_error"] = places[:, position], errors[:, position]
    if field.observable_name not in field.state_names:
        columns |= _observable(body, field.observable_name, "observable", states, errors)
    for name in field.energy_names:
        columns |= _observable(body, name, "equilibrium_potential", states, errors)
    if body.inertial.size:
        columns |= _natural_frequencies(body, derivatives, change)
    columns["eigenvalues"] = eigenvalues
    columns["eigenvalues_error"] = _eigenvalue_errors(derivatives, change)
    columns["stability"] = _stability(eigenvalues, columns["eigenvalues_error"], body)
    return {name: _filled(column, count) for name, column in columns.items()}


def _filled(column: np.ndarray[Any, Any], count: int) -> np.ndarray[Any, Any]:
    """Rows of what is not a number, or of empty text, after the last."""
    text = column.dtype.kind == "U"
    rows = np.full((count, *column.shape[1:]), "" if text else np.nan, dtype="U9" if text else
                   column.dtype)  # fmt: skip
    rows[: len(column)] = column
    return rows


def _observable(
    body: _Body, name: str, title: str, states: FloatArray, errors: FloatArray
) -> dict[str, FloatArray]:
    """A function of the state with its error: its slopes times the errors of the places."""
    program = body.ens.vector_field.observables[name]

    def value(at: Any) -> Any:
        with np.errstate(all="ignore"):
            (result,) = program([0.0, *at.T, *body.parameters], functions=np)
        return np.broadcast_to(result, len(at))

    slopes = np.stack(
        [
            value(states + 1j * _COMPLEX_STEP * np.eye(states.shape[1])[k]).imag / _COMPLEX_STEP
            for k in body.unknown
        ],
        axis=1,
    )
    there = np.asarray(value(states), dtype=np.float64)
    rounding = 16.0 * np.finfo(float).eps * (1.0 + np.abs(there))
    return {title: there, f"{title}_error": (np.abs(slopes) * errors).sum(axis=1) + rounding}


def _sorted_eigenvalues(matrices: FloatArray) -> ComplexArray:
    """Eigenvalues by falling real part, then falling imaginary part, array (point, eigenvalue)."""
    values = np.linalg.eigvals(matrices).astype(np.complex128)
    order = np.lexsort((-values.imag, -np.round(values.real, 9)), axis=1)
    return np.take_along_axis(values, order, axis=1)


def _derivative_changes(body: _Body, states: FloatArray, errors: FloatArray) -> FloatArray:
    """How far the derivatives are off, by the errors of places and rounding, (point,)."""
    there = body.rate_derivatives(states)
    change = _MATRIX_ROUNDINGS * np.finfo(float).eps * np.abs(there).max(axis=(1, 2), initial=0.0)
    step = 1e-6
    for position, k in enumerate(body.unknown):
        moved = states.copy()
        moved[:, k] += step * (1.0 + np.abs(states[:, k]))
        with np.errstate(all="ignore"):
            slope = np.abs(body.rate_derivatives(moved) - there).max(axis=(1, 2), initial=0.0)
            change = change + 2.0 * slope / (moved[:, k] - states[:, k]) * errors[:, position]
    return np.asarray(change)


def _eigenvalue_errors(matrices: FloatArray, change: FloatArray) -> FloatArray:
    """Bauer and Fike: no further than the change times the condition of the eigenvectors.

    A pair that is about to merge moves by the root of the change at most.
    """
    n = matrices.shape[1]
    if not len(matrices):
        return np.empty((0, n))
    condition = np.linalg.cond(np.linalg.eig(matrices)[1])
    norm = n * change
    error = np.minimum(condition * norm, norm + (norm * np.abs(matrices).max(axis=(1, 2))) ** 0.5)
    return np.asarray(error[:, None] * np.ones(n))


def _natural_frequencies(
    body: _Body, derivatives: FloatArray, change: FloatArray
) -> dict[str, FloatArray]:
    """Of small oscillations without damping, internal variables relaxed.

    With A the derivatives of accelerations by coordinates, and B, C, D those by internal
    variables and of their rates: omega^2 are the eigenvalues of -(A - B D^-1 C).
    """
    rate = body.inertial
    field = body.ens.vector_field
    coordinate = np.array(field.indices_of_roles(Role.COORDINATE))
    internal = np.array(field.indices_of_roles(Role.INTERNAL), dtype=np.int64)
    stiffness = -derivatives[:, rate][:, :, coordinate]
    if internal.size:
        inner = derivatives[:, internal]
        relaxed = np.linalg.pinv(inner[:, :, internal]) @ inner[:, :, coordinate]
        stiffness = stiffness + derivatives[:, rate][:, :, internal] @ relaxed
    if not len(stiffness):
        none = np.empty((0, rate.size) if rate.size > 1 else 0)
        return {"natural_frequency": none, "natural_frequency_error": none}
    squares, vectors = np.linalg.eig(stiffness)
    condition = np.linalg.cond(vectors)
    squared_error = (rate.size * condition * change)[:, None]
    order = np.argsort(squares.real, axis=1)
    squares = np.take_along_axis(squares.real, order, axis=1)
    with np.errstate(invalid="ignore"):
        frequency = np.sqrt(np.where(squares > 0.0, squares, np.nan))
    error = square_root_error(frequency, squared_error * np.ones(rate.size))
    if rate.size == 1:
        frequency, error = frequency[:, 0], error[:, 0]
    return {"natural_frequency": frequency, "natural_frequency_error": error}


def _stability(eigenvalues: ComplexArray, errors: FloatArray, body: _Body) -> np.ndarray[Any, Any]:
    """By the largest real part; of what is conservative, oscillations count as stable."""
    if not len(eigenvalues):
        return np.empty(0, dtype="U9")
    growth = eigenvalues.real.max(axis=1)
    slack = errors[:, 0] + _UNDECIDED_SHARE * np.abs(eigenvalues).max(axis=1)
    zero = np.abs(eigenvalues).min(axis=1) <= slack
    near = np.where(zero | (not body.ens.system.conservative), "undecided", "stable")
    return np.where(growth > slack, "unstable", np.where(growth < -slack, "stable", near))
