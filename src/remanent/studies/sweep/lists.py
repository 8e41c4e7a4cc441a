"""Dimensions of lists, such as that of orbits, which are as long as the longest list needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent.results.build import padding_of

#: Entries along dimensions of lists that make a chunk of a store.
LIST_CHUNKS: Final[Mapping[str, int]] = MappingProxyType({
    "point": 64, "crossing": 64, "orbit": 8, "special": 8, "branch": 4, "peak": 4, "end": 2,
    "equilibrium": 4, "step": 4, "fold": 4, "snap": 2, "attractor": 4,
})  # fmt: skip


def list_dims(result: xr.Dataset, grid_dims: Sequence[str]) -> list[str]:
    """Names of the dimensions of lists that a result has."""
    return sorted(
        str(dim) for dim in result.dims if dim not in grid_dims and str(dim) in LIST_CHUNKS
    )


def list_lengths(result: xr.Dataset, grid_dims: Sequence[str]) -> dict[str, NDArray[np.int32]]:
    """How many entries the list of each point has: up to the last that says something."""
    shape = [result.sizes[dim] for dim in grid_dims]
    lengths: dict[str, NDArray[np.int32]] = {}
    for dim in list_dims(result, grid_dims):
        length = np.zeros(shape, dtype=np.int32)
        for variable in result.data_vars.values():
            if dim in variable.dims and set(variable.dims) & set(grid_dims):
                length = np.maximum(length, _lengths_by(variable, dim, grid_dims, shape))
        lengths[dim] = length
    return lengths


def _lengths_by(
    variable: xr.DataArray, dim: str, grid_dims: Sequence[str], shape: Sequence[int]
) -> NDArray[np.int32]:
    """The length of the list of each point by one of its variables."""
    if not variable.sizes[dim]:
        return np.zeros(shape, dtype=np.int32)
    values = variable.values
    is_float = values.dtype.kind in "fc"
    padding = padding_of(values.dtype, str(variable.name))
    said = xr.Variable(variable.dims, ~np.isnan(values) if is_float else values != padding)
    numbers = xr.Variable((dim,), np.arange(1, variable.sizes[dim] + 1, dtype=np.int32))
    present = [d for d in grid_dims if d in variable.dims]
    further = [d for d in variable.dims if d not in present]
    table = (said * numbers).transpose(*present, *further).values
    last = table.max(axis=tuple(range(len(present), table.ndim)), initial=0)
    index = tuple(slice(None) if d in present else np.newaxis for d in grid_dims)
    return np.broadcast_to(last[index], shape).astype(np.int32)
