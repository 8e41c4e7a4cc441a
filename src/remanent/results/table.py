"""Datasets as CSV: one table, a row for each point, with lines of comment above it.

The comments, from a ``#`` to the end of the line, say what columns cannot: attributes of the
whole, and of each variable its dimensions, type, unit and meaning, as JSON.  They make the
way back exact.  Numbers are written with the digits that tell every float from its
neighbours; a complex ``x`` has the columns ``x_real`` and ``x_imag``.
"""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Hashable, Mapping
from pathlib import Path
from typing import Any, Final, TextIO

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._errors import InputError
from remanent.results import metadata
from remanent.results.atomic import replaced_whole

__all__ = ["read", "write"]

#: How the line with attributes of the whole begins.
_WHOLE: Final = "# attributes: "
#: How a line about one variable begins; its name and a colon follow.
_VARIABLE: Final = "# variable "


def write(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write a Dataset as one CSV table, whole or not at all.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result one of whose variables has all dimensions; values of others are repeated
        along the dimensions that they do not have.
    path : str or path
        The file; an existing one is replaced in one step.

    Returns
    -------
    pathlib.Path

    Raises
    ------
    InputError
        Variables that belong in several tables, or that hold objects.
    """
    path = Path(path)
    dims = _common_dimensions(dataset)
    columns: dict[str, NDArray[Any]] = {}
    comments = [_WHOLE + json.dumps(metadata.described_attributes(dataset.attrs))]
    for name, variable in metadata.ordered(dataset).items():
        metadata.require_plain(name, variable)
        about = metadata.described(variable, coordinate=name in dataset.coords)
        comments.append(f"{_VARIABLE}{name}: {json.dumps(about)}")
        columns |= _columns(name, np.ravel(_repeated(variable, dims, dataset.sizes)))
    with replaced_whole(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"{comment}\n" for comment in comments)
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(columns)
        rows.writerows(zip(*(column.tolist() for column in columns.values()), strict=True))
    return path


def read(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read what :func:`write` wrote, equal in values, types, names and attributes.

    Parameters
    ----------
    path : str or path
        The file.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    InputError
        A table without the lines of comment that say what its columns are.
    """
    with Path(path).open(encoding="utf-8", newline="") as file:
        attrs, descriptions, headings = _comments(file)
        if attrs is None:
            raise InputError(
                "path",
                must="be a table that rm.save wrote",
                got=str(path),
                why="Its comments say what the columns are.",
                fix="Read other tables by read_measurements.",
            )
        # A table without rows has headings without columns.
        columns = dict(zip(headings, zip(*csv.reader(file), strict=True), strict=False))
    lengths: dict[str, int] = {}
    for about in descriptions.values():
        lengths |= dict(zip(about["dims"], about["shape"], strict=True))
    sizes = {d: lengths[d] for d in _largest([tuple(a["dims"]) for a in descriptions.values()])}
    return metadata.dataset_of(
        {name: _values(name, about, columns, sizes) for name, about in descriptions.items()},
        descriptions,
        attrs,
    )


def _comments(
    file: TextIO,
) -> tuple[dict[str, Any] | None, dict[str, metadata.Record], list[str]]:
    """Read up to the headings: attributes of the whole, descriptions of variables, headings."""
    attrs: dict[str, Any] | None = None
    descriptions: dict[str, metadata.Record] = {}
    for line in iter(file.readline, ""):
        if line.startswith(_WHOLE):
            attrs = json.loads(line.removeprefix(_WHOLE))
        elif line.startswith(_VARIABLE):
            name, _, entries = line.removeprefix(_VARIABLE).partition(": {")
            descriptions[name] = json.loads(f"{{{entries}")
        else:
            return attrs, descriptions, next(csv.reader([line]), [])
    return attrs, descriptions, []


def _common_dimensions(dataset: xr.Dataset) -> tuple[str, ...]:
    """Dimensions of the table: those of a variable that has all."""
    variables = metadata.ordered(dataset)
    dims = _largest([tuple(map(str, v.dims)) for v in variables.values()])
    wider = [name for name, v in variables.items() if not set(v.dims) <= set(dims)]
    if wider:
        raise InputError(
            "dataset",
            must="have one variable with all dimensions, to be one table",
            got=f"`{wider[0]}` along {dataset[wider[0]].dims}, others along {dims}",
            why="Rows of a CSV file are points.",
            fix="Select some variables, dataset[['amplitude']], or write a .nc or .mat file.",
        )
    lost = [name for name, v in variables.items() if v.size and 0 in dataset.sizes.values()]
    if lost:
        raise InputError(
            "dataset",
            must="have a point, to be a table",
            got=f"none along {dims}",
            why=f"A table without rows has no place for `{lost[0]}`.",
            fix="Write a .nc or .mat file.",
        )
    return dims


def _largest(dims: list[tuple[str, ...]]) -> tuple[str, ...]:
    return max(dims, key=len, default=())


def _repeated(
    variable: xr.Variable, dims: tuple[str, ...], sizes: Mapping[Hashable, int]
) -> NDArray[Any]:
    """Values along all dimensions of the table, repeated along those that they lack."""
    ordered = variable.transpose(*(dim for dim in dims if dim in variable.dims))
    lengths = [sizes[dim] if dim in variable.dims else 1 for dim in dims]
    return np.broadcast_to(np.reshape(ordered.values, lengths), [sizes[dim] for dim in dims])


def _columns(name: str, values: NDArray[Any]) -> dict[str, NDArray[Any]]:
    if values.dtype.kind != "c":
        return {name: values}
    return {f"{name}_real": values.real, f"{name}_imag": values.imag}


def _values(
    name: str,
    about: metadata.Record,
    columns: Mapping[str, tuple[str, ...]],
    sizes: Mapping[str, int],
) -> NDArray[Any]:
    """Values of a variable from the columns of the table, without their repetitions."""
    dtype = np.dtype(about["dtype"])
    if dtype.kind == "c":
        flat = np.empty(len(columns.get(f"{name}_real", ())), dtype=dtype)
        flat.real = _parsed(columns.get(f"{name}_real", ()), flat.real.dtype)
        flat.imag = _parsed(columns.get(f"{name}_imag", ()), flat.real.dtype)
    else:
        flat = _parsed(columns.get(name, ()), dtype)
    if 0 in sizes.values():
        return np.zeros(about["shape"], dtype=flat.dtype)
    table = xr.Variable(tuple(sizes), np.reshape(flat, tuple(sizes.values())))
    repeated = {dim: 0 for dim in sizes if dim not in about["dims"]}
    return np.asarray(table.isel(repeated).transpose(*about["dims"]).values)


def _parsed(column: tuple[str, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
    text = np.array(column, dtype=np.str_)
    return text == "True" if dtype.kind == "b" else text.astype(dtype)
