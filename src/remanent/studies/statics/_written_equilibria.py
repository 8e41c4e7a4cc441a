"""Equilibria of a system of one's own: all zeros of its rates in a box."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._field import Role
from remanent._status import Status
from remanent._typing import ComplexArray, FloatArray, IntArray
from remanent.results.build import Labelled
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.statics._folds import folds_along_first_varied_parameter
from remanent.studies.statics._static_box import require_static_box
from remanent.studies.statics._static_errors import square_root_error
from remanent.studies.statics._written_body import WrittenBody
from remanent.studies.statics._written_snap_through import written_fold_columns

#: Share of the largest eigenvalue below which the sign of a real part is not told.
_UNDECIDED_SHARE = 1e-7
#: Roundings in an entry of a matrix of derivatives.
_MATRIX_ROUNDINGS = 6.0


@np.errstate(all="ignore")  # rates and slopes may be infinite
def written_equilibria(ens: Ensemble, state_box: Mapping[str, Any] | None) -> xr.Dataset:
    """Equilibria of every member of an ensemble under a constant load."""
    bodies = [WrittenBody(ens, k) for k in range(ens.trajectory_count)]
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
    missing: list[str] = []

    def folds_of_cases(
        name: str, cases: IntArray, bounds: tuple[FloatArray, FloatArray]
    ) -> dict[str, NDArray[Any]]:
        columns, reasons = written_fold_columns(ens, box, name, cases, bounds)
        missing.extend(dict.fromkeys(reason for reason in reasons if reason))
        return columns

    folds = folds_along_first_varied_parameter(ens, folds_of_cases)
    reasons = np.array(["; ".join(one for one in (reason, *missing) if one) for _, reason in found])
    status = np.where(
        ens.is_invalid, Status.INVALID, np.where(reasons != "", Status.INCOMPLETE, Status.OK)
    )
    coords: dict[str, Labelled] = {"equilibrium": (("equilibrium",), np.arange(count))}
    coords |= {"fold": folds.pop("fold")} if folds else {}
    sizes = {"mode": bodies[0].inertial.size, "eigenvalue": bodies[0].moving.size}
    coords |= {
        dim: ((dim,), np.arange(size))
        for dim, size in sizes.items()
        if any(dim in labelled[0] for labelled in variables.values())
    }
    return to_dataset(
        ens, {**variables, "reason": reasons}, coords=coords, shared=folds,
        status=status.astype(np.int8),
        tolerance=None, state_box=box.ravel(),
    )  # fmt: skip


def _properties(body: WrittenBody, places: FloatArray, count: int) -> dict[str, NDArray[Any]]:
    """What is known of the equilibria of one body, each array (equilibrium, ...), filled up."""
    field = body.ens.vector_field
    states, errors = body.states(places), body.position_errors(places)
    derivatives = body.rate_derivatives(states)
    change = _derivative_changes(body, states, errors)
    columns: dict[str, NDArray[Any]] = {}
    for position, k in enumerate(body.unknown):
        name = field.state_names[k]
        columns[name], columns[f"{name}_error"] = places[:, position], errors[:, position]
    if field.observable_name not in field.state_names:
        pair = body.observable_with_error(field.observable_name, states, errors)
        columns["observable"], columns["observable_error"] = pair
    for name in field.energy_names:
        pair = body.observable_with_error(name, states, errors)
        columns["equilibrium_potential"], columns["equilibrium_potential_error"] = pair
    if body.inertial.size:
        columns |= _natural_frequencies(body, derivatives, change)
    eigenvalues, eigenvalue_errors = _eigenvalues(derivatives, change)
    # By falling real part, then falling imaginary part.
    order = np.lexsort((-eigenvalues.imag, -np.round(eigenvalues.real, 9)), axis=1)
    eigenvalues = np.take_along_axis(eigenvalues, order, axis=1)
    eigenvalue_errors = np.take_along_axis(eigenvalue_errors, order, axis=1)
    columns |= {"eigenvalues": eigenvalues, "eigenvalues_error": eigenvalue_errors}
    columns["stability"] = _stability(eigenvalues, eigenvalue_errors, body)
    return {name: _filled(column, count) for name, column in columns.items()}


def _filled(column: NDArray[Any], count: int) -> NDArray[Any]:
    """Rows of what is not a number, or of empty text, after the last."""
    text = column.dtype.kind == "U"
    rows = np.full((count, *column.shape[1:]), "" if text else np.nan, dtype="U9" if text else
                   column.dtype)  # fmt: skip
    rows[: len(column)] = column
    return rows


def _derivative_changes(body: WrittenBody, states: FloatArray, errors: FloatArray) -> FloatArray:
    """How far the derivatives are off, by the errors of places and rounding, like them."""
    there = body.rate_derivatives(states)
    change = _MATRIX_ROUNDINGS * np.finfo(float).eps * np.abs(there)
    step = 1e-6
    for position, k in enumerate(body.unknown):
        moved = states.copy()
        moved[:, k] += step * (1.0 + np.abs(states[:, k]))
        with np.errstate(all="ignore"):
            slope = np.abs(body.rate_derivatives(moved) - there)
            relative = errors[:, position] / (moved[:, k] - states[:, k])
            change = change + 2.0 * slope * relative[:, None, None]
    return np.asarray(change)


def _eigenvalues(matrices: FloatArray, change: FloatArray) -> tuple[ComplexArray, FloatArray]:
    """Eigenvalues (point, eigenvalue), and how far each is off where entries change so much.

    To first order |y^H| |change| |x| / |y^H x|, with x and y the eigenvectors from the right
    and from the left; the algorithm adds a rounding of the whole matrix.  A pair that is about
    to merge moves by the root of the change at most.
    """
    n = matrices.shape[1]
    if not len(matrices):
        return np.empty((0, n), dtype=np.complex128), np.empty((0, n))
    values, right = np.linalg.eig(matrices)
    left = np.abs(np.linalg.pinv(right))  # its rows are the y^H, with y^H x = 1
    rounding = np.finfo(float).eps * np.linalg.norm(matrices, axis=(1, 2))
    change = change + (rounding / n)[:, None, None]
    first_order = np.einsum("pki,pij,pjk->pk", left, change, np.abs(right))
    norm = np.linalg.norm(change, axis=(1, 2))
    merging = norm + np.sqrt(norm * np.abs(matrices).max(axis=(1, 2)))
    return values.astype(np.complex128), np.minimum(first_order, merging[:, None])


def _natural_frequencies(
    body: WrittenBody, derivatives: FloatArray, change: FloatArray
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
    stiffness_change = change[:, rate][:, :, coordinate]
    if internal.size:
        pull, inner = derivatives[:, rate][:, :, internal], derivatives[:, internal]
        pull_change, inner_change = change[:, rate][:, :, internal], change[:, internal]
        inverse = np.linalg.pinv(inner[:, :, internal])
        relaxed = inverse @ inner[:, :, coordinate]
        stiffness = stiffness + pull @ relaxed
        relaxed = np.abs(relaxed)
        left = inner_change[:, :, coordinate] + inner_change[:, :, internal] @ relaxed
        stiffness_change += pull_change @ relaxed + np.abs(pull @ inverse) @ left
    squares, squared_error = _eigenvalues(stiffness, stiffness_change)
    order = np.argsort(squares.real, axis=1)
    squared = np.take_along_axis(squares.real, order, axis=1)
    with np.errstate(invalid="ignore"):
        frequency = np.sqrt(np.where(squared > 0.0, squared, np.nan))
    error = square_root_error(frequency, np.take_along_axis(squared_error, order, axis=1))
    if rate.size == 1:
        frequency, error = frequency[:, 0], error[:, 0]
    return {"natural_frequency": frequency, "natural_frequency_error": error}


def _stability(eigenvalues: ComplexArray, errors: FloatArray, body: WrittenBody) -> NDArray[Any]:
    """By the largest real part; of what is conservative, oscillations count as stable."""
    if not len(eigenvalues):
        return np.empty(0, dtype="U9")
    growth = eigenvalues.real.max(axis=1)
    slack = errors.max(axis=1) + _UNDECIDED_SHARE * np.abs(eigenvalues).max(axis=1)
    zero = np.abs(eigenvalues).min(axis=1) <= slack
    near = np.where(zero | (not body.ens.system.conservative), "undecided", "stable")
    return np.where(growth > slack, "unstable", np.where(growth < -slack, "stable", near))
