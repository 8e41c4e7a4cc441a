"""Reading the stores of studies: what a verb would have returned, from a folder in Zarr format."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._extras import require_extra
from remanent.results.checks import is_file

__all__ = [
    "BOOKKEEPING", "FLAG_LABELS", "LENGTHENING_FILE", "LENGTH_ENDING", "SCHEMA_VERSION",
    "TEXT_DTYPE", "is_store", "read",
]  # fmt: skip

#: Version of the schema; older ones are read for ever, newer ones are refused.
SCHEMA_VERSION: Final = 1
#: Ending of the names of lengths of lists.
LENGTH_ENDING: Final = "_length"
#: Group for what is no result.
BOOKKEEPING: Final = "bookkeeping"
#: File in it that is there while arrays are made longer.
LENGTHENING_FILE: Final = "lengthening"
#: Attribute with the exact words that numbers stand for; the names of CF cannot hold blanks.
FLAG_LABELS: Final = "flag_labels"
#: Attribute with the type of text.
TEXT_DTYPE: Final = "remanent_dtype"
#: Text that verbs add only where there is something to say.
_OPTIONAL: Final = "reason"
#: Attributes that only say how to read a store.
_READING_ATTRIBUTES: Final = frozenset(
    {"coordinate_names", "variable_names", "list_dimensions", "has_reason", "sample_point"}
)


def is_store(path: Path) -> bool:
    """Whether a path is a folder in Zarr format."""
    return is_file(path / "zarr.json")


def require_readable_version(attributes: Any) -> None:
    """Refuse a store of a newer version.

    Raises
    ------
    InputError
        Saying which version is needed.
    """
    version = int(attributes["schema_version"])
    if version > SCHEMA_VERSION:
        raise InputError(
            "store",
            must=f"be of schema version {SCHEMA_VERSION} or older",
            got=f"version {version}",
            why=f"It was written by a newer remanent: {attributes.get('versions', 'unknown')}.",
            fix="Install that version, or a newer one.",
        )


def read(path: str | os.PathLike[str]) -> xr.Dataset:
    """What a store holds, as the verb returns it, in memory; also of a study that is under way.

    Parameters
    ----------
    path : str or path
        The folder.

    Raises
    ------
    InputError
        There is no store of a study, one of a newer version, or one whose lists are just
        being made longer.
    RemanentError
        What reads stores is not installed.
    """
    require_extra("studies", "a store")
    if (Path(path) / BOOKKEEPING / LENGTHENING_FILE).exists():
        raise InputError(
            "path",
            must="be a store whose arrays fit together",
            got=str(path),
            why="A process makes its lists longer, or was ended while it did.",
            fix="Try again; if no process writes to it, `remanent run` of its study goes on.",
        )
    raw = xr.open_zarr(str(path), chunks=None, consolidated=False, decode_cf=False)
    if "schema_version" not in raw.attrs:
        raise InputError(
            "path",
            must="be the store of a study",
            got=str(path),
            why="It has no version of the schema of stores.",
            fix="Open other Zarr stores by xarray.open_zarr.",
        )
    require_readable_version(raw.attrs)
    lists = {f"{dim}{LENGTH_ENDING}" for dim in raw.attrs["list_dimensions"]}
    variables = {
        str(name): _as_in_results(variable)
        for name, variable in raw.variables.items()
        if name not in lists
    }
    if not raw.attrs["has_reason"] and not (variables[_OPTIONAL].values != "").any():
        del variables[_OPTIONAL]
    coords, others = raw.attrs["coordinate_names"], raw.attrs["variable_names"]
    return xr.Dataset(
        {name: variables[name] for name in [*others, _OPTIONAL] if name in variables},
        coords={name: variables[name] for name in coords},
        attrs={k: v for k, v in raw.attrs.items() if k not in _READING_ATTRIBUTES},
    )


def _as_in_results(variable: xr.Variable) -> xr.Variable:
    """A stored variable as results have it: text for numbered words, flags as arrays."""
    values, attributes = np.asarray(variable.values), dict(variable.attrs)
    if TEXT_DTYPE not in attributes:
        if "flag_values" in attributes:
            attributes["flag_values"] = np.asarray(attributes["flag_values"], dtype=values.dtype)
        return xr.Variable(variable.dims, values, attributes)
    labels = attributes.get(FLAG_LABELS)
    for name in ("flag_values", "flag_meanings", FLAG_LABELS, TEXT_DTYPE):
        attributes.pop(name, None)
    if labels is not None:
        return xr.Variable(variable.dims, np.array([*labels, ""])[values], attributes)
    longest = max(map(len, values.ravel().tolist()), default=0)
    return xr.Variable(variable.dims, values.astype(f"<U{max(longest, 1)}"), attributes)
