"""Datasets in netCDF files that MATLAB and every other reader can open.

Files keep to the classic data model: no groups, and no complex, boolean, string or
64-bit integer variables.  Such variables are stored in the nearest thing that has a
place there, with the attribute ``remanent_dtype`` saying what they were:

* complex ``x``: two variables, ``x_real`` and ``x_imag``;
* boolean: int8, 0 and 1;
* strings: int8 codes (int16 beyond 127) with CF ``flag_values`` and ``flag_meanings``,
  words joined by ``_``, the exact strings as JSON in ``flag_labels``;
* 64-bit integers: int32, or float64 where too large.

No clock time and no compression setting enters the file, so the same Dataset gives the
same bytes.
"""

from __future__ import annotations

import json
import os
from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import Any, Final, Literal

import numpy as np
import xarray as xr

from remanent._errors import InputError, shortened_repr
from remanent.results.atomic import atomic_replacement

__all__ = ["read", "write"]

#: How files of netCDF-4 begin, which are HDF5.
_HDF5_SIGNATURE: Final = b"\x89HDF\r\n\x1a\n"
#: Attribute with the type that a variable had, where the file holds another.
_DTYPE_ATTRIBUTE: Final = "remanent_dtype"
#: Attributes that say which words the codes of a variable stand for.
_FLAG_ATTRIBUTES: Final = ("flag_values", "flag_meanings", "flag_labels")


def write(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write a Dataset to a netCDF-4 file of the classic model, whole or not at all.

    Parameters
    ----------
    dataset : xarray.Dataset
        Any result of this package.
    path : str or path
        The file; an existing one is replaced in one step.

    Returns
    -------
    pathlib.Path

    Raises
    ------
    InputError
        A variable holds objects, or integers too large for a float64.
    """
    path = Path(path)
    plain = _classic_dataset(dataset)
    with atomic_replacement(path) as part:
        plain.to_netcdf(
            part,
            engine="h5netcdf",
            format=_netcdf_format(plain),
            encoding={name: {"_FillValue": None} for name in plain.variables},
        )
    return path


def _netcdf_format(dataset: xr.Dataset) -> Literal["NETCDF4", "NETCDF4_CLASSIC"]:
    """The classic model, unless several dimensions are empty: it has one such at most."""
    empty = [dim for dim, length in dataset.sizes.items() if length == 0]
    return "NETCDF4" if len(empty) > 1 else "NETCDF4_CLASSIC"


def read(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read what :func:`write` wrote, equal in values, types, names and attributes.

    Parameters
    ----------
    path : str or path
        The file; it is closed again before this returns.

    Returns
    -------
    xarray.Dataset
    """
    with Path(path).open("rb") as file:
        if file.read(len(_HDF5_SIGNATURE)) != _HDF5_SIGNATURE:
            raise InputError(
                "path",
                must="be a file of netCDF-4",
                got=str(path),
                why="Such files begin with the signature of HDF5, and this one does not.",
                fix="Save it by rm.save(dataset, 'name.nc'); read tables by read_measurements.",
            )
    raw = xr.load_dataset(path, engine="h5netcdf", decode_cf=False)
    coords = {name for v in raw.variables.values() for name in _coordinate_names(v.attrs)}
    coords |= _coordinate_names(raw.attrs) | set(map(str, raw.coords))
    rich = {str(name): _from_classic_type(variable) for name, variable in raw.variables.items()}
    rich = _join_complex(rich)
    attrs = {k: _decode_attribute(v) for k, v in raw.attrs.items() if k != "coordinates"}
    return xr.Dataset(
        {k: v for k, v in rich.items() if k not in coords},
        coords={k: rich[k] for k in sorted(coords & set(rich))},
        attrs=attrs,
    )


def _classic_dataset(dataset: xr.Dataset) -> xr.Dataset:
    variables: dict[str, xr.Variable] = {}
    coords: list[str] = []
    for name, array in dataset.variables.items():
        parts = _split_complex(str(name), xr.Variable(array.dims, array.values, array.attrs))
        variables |= {key: _to_classic_type(key, part) for key, part in parts.items()}
        coords += list(parts) if name in dataset.coords else []
    return xr.Dataset(
        {k: v for k, v in variables.items() if k not in coords},
        coords={k: variables[k] for k in sorted(coords)},  # order is no part of a Dataset
        attrs=_encode_attributes(dataset.attrs),
    )


def _split_complex(name: str, variable: xr.Variable) -> dict[str, xr.Variable]:
    values = np.asarray(variable.values)
    if values.dtype.kind != "c":
        return {name: variable}
    attrs = {**variable.attrs, _DTYPE_ATTRIBUTE: str(values.dtype)}
    return {
        f"{name}_real": xr.Variable(variable.dims, values.real.copy(), attrs),
        f"{name}_imag": xr.Variable(variable.dims, values.imag.copy(), attrs),
    }


def _join_complex(variables: Mapping[str, xr.Variable]) -> dict[str, xr.Variable]:
    joined: dict[str, xr.Variable] = {}
    for name, variable in variables.items():
        kind = variable.attrs.get(_DTYPE_ATTRIBUTE, "")
        if not kind.startswith("complex"):
            joined[name] = variable
        elif name.endswith("_real"):
            base = name.removesuffix("_real")
            # Not real + 1j*imag, which loses signs of zeros and makes infinities NaN.
            values = np.empty(variable.shape, dtype=kind)
            values.real, values.imag = variable.values, variables[f"{base}_imag"].values
            attrs = {k: v for k, v in variable.attrs.items() if k != _DTYPE_ATTRIBUTE}
            joined[base] = xr.Variable(variable.dims, values, attrs)
    return joined


def _to_classic_type(name: str, variable: xr.Variable) -> xr.Variable:
    """Cast to the nearest type of the classic model."""
    values = np.asarray(variable.values)
    attrs = _encode_attributes(variable.attrs)
    if values.dtype.kind in "UT" or (values.dtype.kind == "O" and _all_strings(values)):
        values, labels = _encode_strings(values)
        return xr.Variable(variable.dims, values, {**attrs, **labels, _DTYPE_ATTRIBUTE: "str"})
    if values.dtype.kind == "b":
        return xr.Variable(
            variable.dims, values.astype(np.int8), {**attrs, _DTYPE_ATTRIBUTE: "bool"}
        )
    if values.dtype.kind in "iu" and values.dtype not in (np.int8, np.int16, np.int32):
        attrs[_DTYPE_ATTRIBUTE] = str(values.dtype)
        values = _integers_as_classic_type(name, values)
    if values.dtype.kind not in "if":
        raise InputError(
            name,
            must="hold numbers, booleans or strings",
            got=str(values.dtype),
            why="Files hold plain numbers that every program can read.",
            fix="Convert it or leave it out.",
        )
    return xr.Variable(variable.dims, values, attrs)


def _from_classic_type(variable: xr.Variable) -> xr.Variable:
    """Undo :func:`_to_classic_type`, except for complex pairs."""
    kind = _decode_attribute(variable.attrs.get(_DTYPE_ATTRIBUTE, ""))
    hidden = {"coordinates", "_FillValue"} | (
        {_DTYPE_ATTRIBUTE} if kind[:7] != "complex" else set()
    )
    values = np.asarray(variable.values)
    if kind == "str":
        labels = json.loads(variable.attrs["flag_labels"])
        values = np.array(labels, dtype=np.str_)[values] if labels else values.astype(np.str_)
        hidden |= set(_FLAG_ATTRIBUTES)
    elif kind and kind[:7] != "complex":
        values = values.astype(kind)
    attrs = {k: _decode_attribute(v) for k, v in variable.attrs.items() if k not in hidden}
    return xr.Variable(variable.dims, values, attrs)


def _all_strings(values: np.ndarray[Any, Any]) -> bool:
    return all(isinstance(item, str) for item in values.flat)


def _encode_strings(values: np.ndarray[Any, Any]) -> tuple[np.ndarray[Any, Any], dict[str, Any]]:
    """Codes of strings in alphabetical order, and the attributes that explain them."""
    labels, codes = np.unique(values.astype(np.str_), return_inverse=True)
    integer = np.min_scalar_type(-max(len(labels), 1))  # signed, as small as the codes allow
    if len(labels) == 0:
        return codes.reshape(values.shape).astype(integer), {"flag_labels": "[]"}
    meanings = ["_".join(str(label).split()) or "none" for label in labels]
    return codes.reshape(values.shape).astype(integer), {
        "flag_values": np.arange(len(labels), dtype=integer),
        "flag_meanings": " ".join(meanings),
        "flag_labels": json.dumps([str(label) for label in labels]),
    }


def _integers_as_classic_type(name: str, values: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Integers as int32, else as float64 if that is exact."""
    for target in (np.int32, np.float64):
        with np.errstate(invalid="ignore", over="ignore"):
            narrow = values.astype(target)
        exact = target is np.int32 or bool((np.abs(narrow) <= 2.0**53).all())
        if exact and bool((narrow == values).all()):
            return narrow
    raise InputError(
        name,
        must="hold integers below 2^53",
        got=int(np.abs(values).max()),
        why="Larger ones do not fit the classic netCDF model.",
        fix="Store them as two variables.",
    )


def _encode_attributes(attrs: Mapping[Any, Any]) -> dict[str, Any]:
    return {str(k): _encode_attribute(v) for k, v in attrs.items() if v is not None}


def _encode_attribute(value: Any) -> Any:
    """Text, or a number of the classic model; a text of blanks, or of none, gets one more."""
    if isinstance(value, str):
        return value if value.strip(" ") else f"{value} "  # netCDF knows no empty text
    number = np.asarray(value)
    if number.dtype.kind not in "biufU":
        raise InputError(
            "attrs",
            must="hold text and numbers",
            got=shortened_repr(value),
            why="Other programs read them.",
            fix="Remove that attribute, or write it as text.",
        )
    if number.dtype.kind in "biu" and number.dtype not in (np.int8, np.int16, np.int32):
        number = (
            number.astype(np.int8)
            if number.dtype.kind == "b"
            else _integers_as_classic_type("attrs", number)
        )
    return number if number.ndim else number[()]


def _decode_attribute(value: Any) -> Any:
    if isinstance(value, str):  # h5py reads fixed-length text as ASCII with escapes
        if not value.strip(" "):
            return value[:-1]
        return value.encode("utf-8", "surrogateescape").decode("utf-8")
    return value.item() if isinstance(value, np.generic) else value


def _coordinate_names(attrs: Mapping[Hashable, Any]) -> set[str]:
    return set(str(attrs.get("coordinates", "")).split())
