"""What a table of plain columns cannot say of a Dataset, as JSON: labels, types, attributes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._errors import InputError

__all__ = [
    "dataset_of", "described", "described_attributes", "is_text", "ordered",
    "read_attributes", "require_plain",
]  # fmt: skip

#: What of a variable is kept beside its values.
Record = dict[str, Any]


def ordered(dataset: xr.Dataset) -> dict[str, xr.Variable]:
    """Variables by name: coordinates, sorted as their order means nothing, then the others."""
    coords = {str(name): array.variable for name, array in dataset.coords.items()}
    others = {str(name): array.variable for name, array in dataset.data_vars.items()}
    return {**dict(sorted(coords.items())), **others}


def described(variable: xr.Variable, *, coordinate: bool) -> Record:
    """Dimensions, shape, type and attributes of a variable, ready for JSON."""
    kind = "str" if is_text(variable) else str(variable.dtype)
    return {
        "dims": list(map(str, variable.dims)),
        "shape": list(variable.shape),
        "dtype": kind,
        "coordinate": coordinate,
        "attributes": described_attributes(variable.attrs),
    }


def described_attributes(attrs: Mapping[Any, Any]) -> dict[str, Any]:
    """Attributes, with arrays as tables of their values and type."""
    return {str(name): _plain(str(name), value) for name, value in attrs.items()}


def read_attributes(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """Undo :func:`described_attributes`; sequences come back as arrays."""
    return {name: _rebuilt(value) for name, value in attrs.items()}


def dataset_of(
    values: Mapping[str, NDArray[Any]],
    descriptions: Mapping[str, Record],
    attrs: Mapping[str, Any],
) -> xr.Dataset:
    """Put a Dataset together from its values and what was kept of them.

    Parameters
    ----------
    values : mapping of name to array
        Of any shape with the right number of entries.
    descriptions : mapping of name to Record
        Those of :func:`described`, for the same names.
    attrs : mapping
        Attributes of the whole, from :func:`described_attributes`.
    """
    variables = {
        name: xr.Variable(
            description["dims"],
            np.reshape(values[name], description["shape"]).astype(description["dtype"]),
            read_attributes(description["attributes"]),
        )
        for name, description in descriptions.items()
    }
    coords = {name for name, description in descriptions.items() if description["coordinate"]}
    return xr.Dataset(
        {name: variable for name, variable in variables.items() if name not in coords},
        coords={name: variable for name, variable in variables.items() if name in coords},
        attrs=read_attributes(attrs),
    )


def is_text(variable: xr.Variable) -> bool:
    """Whether a variable holds text only."""
    kind = variable.dtype.kind
    return kind in "UT" or (
        kind == "O" and all(isinstance(item, str) for item in np.ravel(variable.values))
    )


def require_plain(name: str, variable: xr.Variable) -> None:
    """Raise unless a variable holds numbers, truth values or text."""
    if variable.dtype.kind not in "biufc" and not is_text(variable):
        raise InputError(
            name,
            must="hold numbers, booleans or strings",
            got=str(variable.dtype),
            why="Files hold plain numbers that every program can read.",
            fix="Convert it or leave it out.",
        )


def _plain(name: str, value: Any) -> Any:
    if isinstance(value, str | bool | int | float) and not isinstance(value, np.generic):
        return value
    array = np.asarray(value)
    if array.dtype.kind not in "biufU":
        raise InputError(
            "attrs",
            must="hold text and numbers",
            got=f"{name} = {value!r}"[:80],
            why="Other programs read them.",
            fix=f"Remove it: del dataset.attrs[{name!r}].",
        )
    return {"values": array.tolist(), "dtype": str(array.dtype)} if array.ndim else array.item()


def _rebuilt(value: Any) -> Any:
    return np.array(value["values"], dtype=value["dtype"]) if isinstance(value, dict) else value
