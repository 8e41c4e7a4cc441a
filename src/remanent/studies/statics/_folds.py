"""Where equilibria meet while a parameter is varied, and from where a motion passes them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remanent._typing import FloatArray, IntArray
from remanent.analysis.statics.equilibria import balancing_parameter, find_force_zeros, force_slope
from remanent.results.build import Labelled
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.statics._static_ensemble import StaticEnsemble
from remanent.studies.statics._static_errors import (
    balancing_parameter_error,
    largest,
    least,
    thickness_error,
)

#: Half the relative change of a stretch over which a derivative is a difference.
_RELATIVE_HALF_STEP = 1e-5


#: Columns (case, fold) of folds of some cases, between bounds (case,) of a parameter.
FoldsOfCases = Callable[[str, IntArray, tuple[FloatArray, FloatArray]], dict[str, NDArray[Any]]]


def folds_along_first_varied_parameter(
    ens: Ensemble, folds_of_cases: FoldsOfCases
) -> dict[str, Labelled]:
    """Folds along the first field in ``over``, labelled; nothing where there is none.

    Parameters
    ----------
    ens : Ensemble
    folds_of_cases : callable
        Of the field, of members of the ensemble, and of its least and largest value for each.
    """
    # The first field that has a dimension of its own.
    name = next((k for k, (dims, _) in ens.coords.items() if dims == (k,)), None)
    if (
        name is None
        or name not in ens.vector_field.parameter_names
        or ens.dimension_sizes[name] < 2
    ):
        return {}
    shape, axis = tuple(ens.dimension_sizes.values()), ens.dims.index(name)

    def in_rows(column: NDArray[Any]) -> NDArray[Any]:
        """One row for each combination of the other fields."""
        return np.moveaxis(column.reshape(shape), axis, -1).reshape(-1, shape[axis])

    is_valid = ~in_rows(ens.is_invalid)
    values = in_rows(ens.parameter_values[name])
    low = np.where(is_valid, values, np.inf).min(axis=1)
    high = np.where(is_valid, values, -np.inf).max(axis=1)
    first_valid = np.argmax(is_valid, axis=1)[:, None]
    numbers = in_rows(np.arange(ens.trajectory_count))
    cases = np.take_along_axis(numbers, first_valid, axis=1)[:, 0]
    valid = low < high
    found = folds_of_cases(name, cases[valid], (low[valid], high[valid]))
    if name not in found:  # no member has a range of the field
        return {}
    other_sizes = [size for k, size in ens.dimension_sizes.items() if k != name]

    def shaped(values: NDArray[Any]) -> NDArray[Any]:
        blank = "" if values.dtype.kind == "U" else np.nan
        rows = np.full((valid.size, values.shape[1]), blank, dtype=values.dtype)
        rows[valid] = values
        return rows.reshape(*other_sizes, values.shape[1])

    dims = (*(k for k in ens.dims if k != name), "fold")
    return {
        **{f"fold_{k}": (dims, shaped(v)) for k, v in found.items()},
        "fold": (("fold",), np.arange(found[name].shape[1])),
    }


def fold_points(
    static: StaticEnsemble, name: str, cases: IntArray, bounds: tuple[FloatArray, FloatArray]
) -> dict[str, FloatArray]:
    """Parameters and stretches at which two equilibria meet, and errors, arrays (case, fold)."""
    force = static.first_acceleration_function(name)

    def stiffness(row: IntArray, x: FloatArray) -> FloatArray:
        value = balancing_parameter(lambda i, y, p: force(cases[i], y, p), bounds, row, x)
        steepness = force_slope(lambda i, y: force(cases[i], y, value), row, x)
        return np.where(np.isnan(value), np.nan, steepness)

    stretches = find_force_zeros(stiffness, cases.size, stretch_grid_of_cases(static, cases))
    values = balancing_parameters(static, name, cases, bounds, stretches)
    row = np.repeat(np.arange(cases.size), stretches.shape[1]).reshape(stretches.shape)
    case, step = cases[row], _RELATIVE_HALF_STEP * stretches
    with np.errstate(all="ignore"):
        curvature = (stiffness(row, stretches + step) - stiffness(row, stretches - step)) / (
            2.0 * step
        )
        by_stretch = static.first_acceleration_with_rounding(
            case, stretches, changed={name: values}
        )
        by_value = static.first_acceleration_with_rounding(
            case, stretches, along=name, changed={name: values}
        )
        value_error = balancing_parameter_error(static, name, case, stretches, values)
        # The slope of the force is off by its own rounding and by the error of the parameter.
        ends = (
            static.first_acceleration_with_rounding(case, stretches, changed={name: end})
            for end in (values - value_error, values + value_error)
        )
        low, high = (np.asarray(end.slope.value) for end in ends)
        slope_left = largest(by_stretch.slope) + 0.5 * np.abs(high - low)
        error = slope_left / np.abs(curvature)
        value_error = value_error + slope_left / least(by_value.slope) * error
    return {
        name: values,
        f"{name}_error": value_error,
        "stretch": stretches,
        "stretch_error": error,
        "thickness_stretch": static.thickness(case, stretches),
        "thickness_stretch_error": thickness_error(static, case, stretches, error),
    }


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
