"""The grid of a study, and its parts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._arrays import is_increasing
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.over import OverArgument, VariedFields, read_over

#: The part of a grid: a slice of each of its dimensions.
GridPart = tuple[slice, ...]


@dataclass(frozen=True)
class Grid:
    """Values of fields along named dimensions, of which parts can be taken.

    Attributes
    ----------
    fields : VariedFields
    """

    fields: VariedFields

    @classmethod
    def from_over(cls, over: OverArgument, system: System) -> Grid:
        """Read what ``over`` says; whether the names are fields, the verb itself checks.

        Raises
        ------
        InputError
            No numbers, an empty or unsorted grid, lengths or labels that do not match.
        """
        return cls(read_over(over, list(over), system, frozenset()))

    @cached_property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions, the slowest first."""
        return tuple(self.fields.sizes)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Length of each dimension."""
        return tuple(self.fields.sizes.values())

    @property
    def point_count(self) -> int:
        """Number of combinations."""
        return self.fields.count

    @property
    def whole(self) -> GridPart:
        """The part that is everything."""
        return tuple(slice(0, size) for size in self.shape)

    def over(self, part: GridPart) -> dict[str, Any]:
        """What a verb takes as ``over`` for a part of the grid."""
        slices = dict(zip(self.dims, part, strict=True))
        return {
            name: _selected(name, labelled, slices, self.fields.labels)
            for name, labelled in self.fields.arrays.items()
        }

    def subset(self, part: GridPart) -> Grid:
        """The grid of a part."""
        slices = dict(zip(self.dims, part, strict=True))
        labels = {
            name: (dims, values[tuple(slices[dim] for dim in dims)])
            for name, (dims, values) in self.fields.labels.items()
        }
        arrays = {
            name: (dims, values[tuple(slices[dim] for dim in dims)])
            for name, (dims, values) in self.fields.arrays.items()
        }
        sizes = {dim: s.stop - s.start for dim, s in slices.items()}
        return Grid(VariedFields(arrays, sizes, labels))

    def parts(self, shape: tuple[int, ...]) -> Iterator[GridPart]:
        """Parts of this shape side by side, in order; those at an end may be smaller."""
        cuts = [
            [slice(start, min(start + step, size)) for start in range(0, size, step)]
            for size, step in zip(self.shape, shape, strict=True)
        ]
        return product(*cuts)


def is_plain_grid(name: str, dims: tuple[str, ...], values: NDArray[np.float64]) -> bool:
    """Whether values are those of a dimension of their own, in the order that `over` asks for."""
    return dims == (name,) and is_increasing(values)


def _selected(
    name: str, labelled: Labelled, slices: Mapping[str, slice], labels: Mapping[str, Labelled]
) -> Any:
    dims, values = labelled
    chosen = np.ascontiguousarray(values[tuple(slices[dim] for dim in dims)])
    if is_plain_grid(name, dims, chosen):
        return chosen
    coords = {dim: labels[dim][1][slices[dim]] for dim in dims if dim in labels}
    return xr.DataArray(chosen, dims=dims, coords=coords)
