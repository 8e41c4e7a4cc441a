"""What a table of plain columns cannot say of a Dataset, as JSON: labels, types, attributes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._errors import InputError

__all__ = [
    "dataset_from_records",
    "decode_attributes",
    "encode_attributes",
    "holds_text",
    "ordered_variables",
    "require_storable",
    "variable_record",
]  # fmt: skip

#: What of a variable is kept beside its values.
VariableRecord = dict[str, Any]


def ordered_variables(dataset: xr.Dataset) -> dict[str, xr.Variable]:
    """Variables by name: coordinates, sorted as their order means nothing, then the others."""
    coords = {str(name): array.variable for name, array in dataset.coords.items()}
    others = {str(name): array.variable for name, array in dataset.data_vars.items()}
    return {**dict(sorted(coords.items())), **others}


def variable_record(variable: xr.Variable, *, coordinate: bool) -> VariableRecord:
    """Dimensions, shape, type and attributes of a variable, ready for JSON."""
    kind = "str" if holds_text(variable) else str(variable.dtype)
    return {
        "dims": list(map(str, variable.dims)),
        "shape": list(variable.shape),
        "dtype": kind,
        "coordinate": coordinate,
        "attributes": encode_attributes(variable.attrs),
    }


def encode_attributes(attrs: Mapping[Any, Any]) -> dict[str, Any]:
    """Attributes, with arrays as tables of their values and type."""
    return {str(name): _encode_attribute(str(name), value) for name, value in attrs.items()}


def decode_attributes(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """Undo :func:`encode_attributes`; sequences come back as arrays."""
    return {name: _decode_attribute(value) for name, value in attrs.items()}


def dataset_from_records(
    values: Mapping[str, NDArray[Any]],
    descriptions: Mapping[str, VariableRecord],
    attrs: Mapping[str, Any],
) -> xr.Dataset:
    """Put a Dataset together from its values and what was kept of them.

    Parameters
    ----------
    values : mapping of name to array
        Of any shape with the right number of entries.
    descriptions : mapping of name to Record
        Those of :func:`variable_record`, for the same names.
    attrs : mapping
        Attributes of the whole, from :func:`encode_attributes`.
    """
    variables = {
        name: xr.Variable(
            description["dims"],
            np.reshape(values[name], description["shape"]).astype(description["dtype"]),
            decode_attributes(description["attributes"]),
        )
        for name, description in descriptions.items()
    }
    coords = {name for name, description in descriptions.items() if description["coordinate"]}
    return xr.Dataset(
        {name: variable for name, variable in variables.items() if name not in coords},
        coords={name: variable for name, variable in variables.items() if name in coords},
        attrs=decode_attributes(attrs),
    )


def holds_text(variable: xr.Variable) -> bool:
    """Whether a variable holds text only."""
    kind = variable.dtype.kind
    return kind in "UT" or (
        kind == "O" and all(isinstance(item, str) for item in np.ravel(variable.values))
    )


def require_storable(name: str, variable: xr.Variable) -> None:
    """Raise unless a variable holds numbers, truth values or text."""
    if variable.dtype.kind not in "biufc" and not holds_text(variable):
        raise InputError(
            name,
            must="hold numbers, booleans or strings",
            got=str(variable.dtype),
            why="Files hold plain numbers that every program can read.",
            fix="Convert it or leave it out.",
        )


def _encode_attribute(name: str, value: Any) -> Any:
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


def _decode_attribute(value: Any) -> Any:
    return np.array(value["values"], dtype=value["dtype"]) if isinstance(value, dict) else value
