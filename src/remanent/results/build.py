"""Plain arrays into labelled Datasets."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray

from remanent._errors import InputError
from remanent.models.variable_text import VariableText
from remanent.results.schema import FLAG_MEANINGS, describe, flag_attributes

__all__ = ["Labelled", "dataset", "padding_of", "with_labels"]

#: Dimension names and values, as xarray takes them.
Labelled = tuple[tuple[str, ...], NDArray[Any]]
#: What systems with a table of their own variables say of them; an actuator has none.
OwnTexts = Mapping[str, VariableText]
#: Nothing of one's own.
_NO_OWN_TEXTS: Final[OwnTexts] = MappingProxyType({})
#: What stands where an array ends before others, by the kind of its numbers.
_PADDING: Final[Mapping[str, Any]] = MappingProxyType(
    {"f": np.nan, "c": complex(np.nan, 0.0), "i": -1, "b": False, **dict.fromkeys("UTO", "")}
)
#: Variables of integers in which 0 says nothing: downwards is -1, and 0 is not computed.
_PADDED_WITH_ZERO: Final = frozenset({"direction", "status", "resonance_status"})


def dataset(
    variables: Mapping[str, Labelled],
    coords: Mapping[str, Labelled],
    provenance: Mapping[str, Any],
    own: OwnTexts = _NO_OWN_TEXTS,
) -> xr.Dataset:
    """Label plain arrays.

    Parameters
    ----------
    variables
        Name to (dimensions, values); every name must be in the schema.
    coords
        The same for coordinates.
    provenance
        Attributes of the whole, see :func:`remanent.results.provenance.attributes`.
    own
        What a system of the user's own says of its variables.

    Returns
    -------
    xarray.Dataset
        Every variable and coordinate has ``units``, ``long_name`` and ``symbol``;
        ``status`` is int8 with ``flag_values`` and ``flag_meanings``.

    Raises
    ------
    InputError
        A name is not in the schema, or lengths along a dimension differ.

    Examples
    --------
    >>> import numpy as np
    >>> ds = dataset(
    ...     {"amplitude": (("omega",), np.array([0.1, 0.2]))},
    ...     {"omega": (("omega",), np.array([1.0, 1.1]))},
    ...     {},
    ... )
    >>> ds["amplitude"].attrs["units"], ds["omega"].attrs["units"]
    ('1', 'rad')
    """
    _require_equal_lengths({**coords, **variables})
    return xr.Dataset(
        {name: _labelled_variable(name, *labelled, own) for name, labelled in variables.items()},
        coords={
            name: _labelled_coordinate(name, *labelled, own) for name, labelled in coords.items()
        },
        attrs=dict(provenance),
    )


def padding_of(dtype: np.dtype[Any], name: str = "") -> Any:
    """What says nothing among values of a type: NaN, -1, False or empty text.

    Parameters
    ----------
    dtype : numpy.dtype
    name : str
        Of the variable; in some -1 means something, and 0 nothing.
    """
    return 0 if name in _PADDED_WITH_ZERO else _PADDING[dtype.kind]


def with_labels(result: xr.Dataset, labels: Mapping[str, Labelled]) -> xr.Dataset:
    """A result with the labels that its caller gave to dimensions of their own naming.

    Parameters
    ----------
    result : xarray.Dataset
    labels : mapping of name to Labelled
        One array (entry,) for each dimension; those that `result` does not have are left out.
    """
    added = {
        name: xr.Variable(
            dims, values, {"units": "1", "long_name": name.replace("_", " "), "symbol": ""}
        )
        for name, (dims, values) in labels.items()
        if name in result.dims
    }
    return result.assign_coords(added) if added else result


def _labelled_variable(
    name: str, dims: tuple[str, ...], values: NDArray[Any], own: OwnTexts
) -> xr.Variable:
    if name in FLAG_MEANINGS:
        values = np.asarray(values, dtype=np.int8)
    return xr.Variable(dims, values, {**describe(name, own).attributes(), **flag_attributes(name)})


def _labelled_coordinate(
    name: str, dims: tuple[str, ...], values: NDArray[Any], own: OwnTexts
) -> xr.Variable:
    """A coordinate; one of numbers that label its dimension is an index.

    xarray would make the index itself, but looks for pint in any array, and importing
    that takes longer than most runs.
    """
    if dims == (name,) and values.dtype.kind in "iuf":
        return xr.Variable(dims, pd.Index(values, copy=False), describe(name, own).attributes())
    return _labelled_variable(name, dims, values, own)


def _require_equal_lengths(labelled: Mapping[str, Labelled]) -> None:
    sizes: dict[str, tuple[int, str]] = {}
    for name, (dims, values) in labelled.items():
        shape = np.shape(values)
        if len(dims) != len(shape):
            raise InputError(
                name,
                must=f"have {len(dims)} dimensions, {dims}",
                got=f"shape {shape}",
                why="Every dimension of a result has a name.",
                fix="Name each dimension of the array.",
            )
        for dim, length in zip(dims, shape, strict=True):
            first, owner = sizes.setdefault(dim, (length, name))
            if length != first:
                raise InputError(
                    name,
                    must=f"have length {first} along `{dim}`",
                    got=length,
                    why=f"`{owner}` has that length.",
                    fix="Give both the same points.",
                )
