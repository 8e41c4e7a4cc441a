"""Results of the parts of a grid, joined into the result of the whole."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence

import numpy as np
import xarray as xr

from remanent._errors import RemanentError
from remanent.results.build import padding_of
from remanent.studies.sweep.grid import Grid, GridPart


def join_parts(grid: Grid, ordered: Sequence[tuple[GridPart, xr.Dataset]]) -> xr.Dataset:
    """The result that the verb gives for the whole grid, from its results for all parts.

    Dimensions that end where the longest entry ends, such as that of orbits, are as long as the
    longest part needs; shorter ones are padded as the verbs pad them.

    Parameters
    ----------
    grid : Grid
    ordered : sequence of (part, xarray.Dataset)

    Raises
    ------
    RemanentError
        A number that all points share differs between parts.
    """
    names = _ordered_names([ds for _, ds in ordered])
    sizes = _joined_sizes(grid, [ds for _, ds in ordered])
    joined = {name: _joined_variable(name, grid, ordered, sizes) for name in names}
    coords = {name for _, ds in ordered for name in ds.coords}
    return xr.Dataset(
        {k: v for k, v in joined.items() if k not in coords},
        coords={k: v for k, v in joined.items() if k in coords},
        attrs=ordered[0][1].attrs,
    )


def _ordered_names(datasets: Sequence[xr.Dataset]) -> list[str]:
    """Names of all variables, in the order of the result that has most."""
    longest = max(datasets, key=lambda ds: len(ds.variables))
    further = [name for ds in datasets for name in ds.variables if name not in longest.variables]
    return list(map(str, dict.fromkeys([*longest.variables, *further])))


def _joined_sizes(grid: Grid, datasets: Iterable[xr.Dataset]) -> dict[Hashable, int]:
    sizes: dict[Hashable, int] = {}
    for ds in datasets:
        for dim, size in ds.sizes.items():
            sizes[dim] = max(sizes.get(dim, 0), size)
    return sizes | dict(zip(grid.dims, grid.shape, strict=True))


def _joined_variable(
    name: str,
    grid: Grid,
    ordered: Sequence[tuple[GridPart, xr.Dataset]],
    sizes: Mapping[Hashable, int],
) -> xr.Variable:
    owners = [(part, ds.variables[name]) for part, ds in ordered if name in ds.variables]
    first = owners[0][1]
    if not set(first.dims) & set(grid.dims):
        return _shared_variable(name, [variable for _, variable in owners])
    dtype = np.result_type(*(variable.dtype for _, variable in owners))
    values = np.full([sizes[dim] for dim in first.dims], padding_of(dtype, name), dtype=dtype)
    for part, variable in owners:
        slices = dict(zip(grid.dims, part, strict=True))
        place = tuple(
            slices.get(str(dim), slice(0, size))
            for dim, size in zip(variable.dims, variable.shape, strict=True)
        )
        values[place] = variable.values
    return xr.Variable(first.dims, values, first.attrs)


def _shared_variable(name: str, variables: Sequence[xr.Variable]) -> xr.Variable:
    """What all points share: the longest, which begins as every other one."""
    longest = max(variables, key=lambda variable: variable.size)
    for variable in variables:
        begin = longest.values[tuple(slice(0, size) for size in variable.shape)]
        same = np.array_equal(begin, variable.values, equal_nan=begin.dtype.kind in "fc")
        if variable.dims != longest.dims or not same:
            raise RemanentError(
                f"`{name}` differs between parts of the grid, which makes no one result. "
                "Report this as a fault of remanent."
            )
    return longest.to_base_variable()
