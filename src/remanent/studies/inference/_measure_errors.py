"""The error of a measure, from the errors that the verb states of its own variables."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import numpy as np
import xarray as xr

from remanent._typing import FloatArray

#: Patterns of signs with which the entries of a variable are moved, beside all plus and minus.
_RANDOM_SIGN_PATTERN_COUNT = 6
#: Seed of these patterns: equal results have equal errors.
_SIGN_PATTERN_SEED = 0
#: Relative and absolute change by which it is seen whether a measure depends on a variable.
_NUDGE = 1e-7

#: Variables whose error has another name: both extremes are as good as half their difference.
_ERROR_NAMES = {"maximum": "amplitude_error", "minimum": "amplitude_error"}


def stated_error(result: xr.Dataset, name: str) -> xr.DataArray | None:
    """The error of one variable of a result, or None where the verb states none.

    It is ``<name>_error``, else the ``error`` of the state.  Counts and labels have none to
    speak of: theirs is 0.
    """
    variable = result[name]
    if variable.dtype.kind not in "fc":
        return xr.zeros_like(variable, dtype=np.float64)
    error = result.get(f"{name}_error")
    if error is None:
        error = result.get(_ERROR_NAMES.get(name, "error"), result.get("error"))
    if error is None or name in {"error", "status"} or name.endswith("_error"):
        return None
    if error.dims == variable.dims:
        return error
    further = [d for d in error.dims if d not in variable.dims]
    return error.max(further).broadcast_like(variable).transpose(*variable.dims)


def propagated_error(
    function: Callable[[xr.Dataset], Any], result: xr.Dataset, value: xr.DataArray
) -> xr.DataArray:
    """What the errors of all variables of a result make of a function of it.

    Each variable is moved by its error, as a whole to either side and with random signs of
    its entries; the largest change counts, and the changes by all variables are added.  Where
    the function depends on a number without an error, it has none itself: NaN.

    Parameters
    ----------
    function : callable
        Of a Dataset like `result`.
    result : xarray.Dataset
    value : xarray.DataArray
        The function of `result`.
    """
    used = _used_part(function, result, value)
    total = np.zeros(value.shape)
    for name in map(str, used.data_vars):
        variable = used[name].variable
        if variable.dtype.kind not in "fc":
            continue
        stated = stated_error(result, name)
        error = np.full(variable.shape, np.nan) if stated is None else stated.values
        unknown = np.isnan(error) & ~np.isnan(variable.values)
        if unknown.any():
            nudged = np.where(unknown, variable.values * (1.0 + _NUDGE) + _NUDGE, variable.values)
            total = np.where(_change(function, used, name, nudged, value) > 0.0, np.nan, total)
        known = np.nan_to_num(error)
        changes = [
            _change(function, used, name, moved, value)
            for moved in _moved_by_error(variable.values, known)
        ]
        total = total + np.max(changes, axis=0, initial=0.0)
    return value.copy(data=total)


def _used_part(
    function: Callable[[xr.Dataset], Any], result: xr.Dataset, value: xr.DataArray
) -> xr.Dataset:
    """The one variable on which a function depends, where that is one; else the whole result."""
    for name in result.data_vars:
        part = result[[name]]
        with suppress(Exception):  # of what the function misses, whatever it raises then
            if function(part).equals(value):
                return part
    return result


def _moved_by_error(values: FloatArray, error: FloatArray) -> Iterator[FloatArray]:
    """Values moved by their error with several patterns of signs; nothing for no error."""
    if not (error > 0.0).any():
        return
    rng = np.random.default_rng(_SIGN_PATTERN_SEED)
    yield values + error
    yield values - error
    for _ in range(_RANDOM_SIGN_PATTERN_COUNT):
        yield values + error * rng.choice([-1.0, 1.0], size=error.shape)


def _change(
    function: Callable[[xr.Dataset], Any],
    result: xr.Dataset,
    name: str,
    moved: FloatArray,
    value: xr.DataArray,
) -> FloatArray:
    """How far a function moves with one variable, an array like `value`; NaN where it is lost."""
    data = {str(n): moved if n == name else v.data for n, v in result.data_vars.items()}
    there = function(result.copy(data=data))
    if there.dims != value.dims:
        there = there.transpose(*value.dims)
    if there.shape != value.shape:  # the moved entries select others
        return np.full(value.shape, np.nan)
    change = np.abs(there.values - value.values)
    return np.where(np.isnan(value.values), 0.0, change)
