"""Where equilibria meet while a parameter is varied, and from where a motion passes them."""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.analysis.statics.equilibria import balancing_parameter, find_force_zeros, force_slope
from remanent.results.build import Labelled
from remanent.studies.statics._static_ensemble import StaticEnsemble


def folds_along_first_varied_parameter(static: StaticEnsemble) -> dict[str, Labelled]:
    """Folds along the first field in ``over``, labelled; nothing where there is none."""
    ens = static.ensemble
    # The first field that has a dimension of its own.
    name = next((k for k, (dims, _) in ens.coords.items() if dims == (k,)), None)
    if (
        name is None
        or name not in ens.vector_field.parameter_names
        or ens.dimension_sizes[name] < 2
    ):
        return {}
    shape, axis = tuple(ens.dimension_sizes.values()), ens.dims.index(name)
    cases = np.take(np.arange(ens.trajectory_count).reshape(shape), 0, axis).ravel()
    valid = ~ens.is_invalid.reshape(shape).any(axis=axis).ravel()
    ends = np.take(ens.parameter_values[name].reshape(shape), [0, -1], axis)
    low, high = np.moveaxis(ends, axis, 0).reshape(2, -1)
    stretch, value = fold_points(static, name, cases[valid], (low[valid], high[valid]))
    other_sizes = [size for k, size in ens.dimension_sizes.items() if k != name]

    def shaped(values: FloatArray) -> FloatArray:
        rows = np.full((valid.size, values.shape[1]), np.nan)
        rows[valid] = values
        return rows.reshape(*other_sizes, values.shape[1])

    dims = (*(k for k in ens.dims if k != name), "fold")
    return {
        f"fold_{name}": (dims, shaped(value)),
        "fold_stretch": (dims, shaped(stretch)),
        "fold_thickness_stretch": (dims, shaped(static.thickness(cases[:1], stretch))),
        "fold": (("fold",), np.arange(stretch.shape[1])),
    }


def fold_points(
    static: StaticEnsemble, name: str, cases: IntArray, bounds: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Stretches and parameters (case, fold) at which two equilibria meet."""
    force = static.first_acceleration_function(name)

    def stiffness(row: IntArray, x: FloatArray) -> FloatArray:
        value = balancing_parameter(lambda i, y, p: force(cases[i], y, p), bounds, row, x)
        steepness = force_slope(lambda i, y: force(cases[i], y, value), row, x)
        return np.where(np.isnan(value), np.nan, steepness)

    stretches = find_force_zeros(stiffness, cases.size, stretch_grid_of_cases(static, cases))
    return stretches, balancing_parameters(static, name, cases, bounds, stretches)


def balancing_parameters(
    static: StaticEnsemble,
    name: str,
    cases: IntArray,
    bounds: tuple[FloatArray, FloatArray],
    stretches: FloatArray,
) -> FloatArray:
    """The parameter that balances the force at stretches (case, point)."""
    force = static.first_acceleration_function(name)
    row = np.repeat(np.arange(cases.size), stretches.shape[1])
    value = balancing_parameter(
        lambda i, y, p: force(cases[i], y, p), bounds, row, stretches.ravel()
    )
    return value.reshape(stretches.shape)


def stretch_grid_of_cases(static: StaticEnsemble, cases: IntArray) -> FloatArray:
    """The grid of some cases."""
    return static.stretch_grid if static.stretch_grid.ndim == 1 else static.stretch_grid[cases]
