"""Datasets as MAT files, which MATLAB and Octave load as one variable for each of theirs.

Names that MATLAB does not allow have ``_`` for every other character.  Text becomes a cell
array, a truth value a logical.  The text ``metadata`` holds, as JSON, the attributes of the
whole and, of each variable, its name here, dimensions, type, unit and meaning:
``jsondecode(metadata)`` in MATLAB.  It makes the way back exact.
"""

from __future__ import annotations

import json
import os
import re
from pathlib import Path
from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._errors import InputError
from remanent.results import metadata
from remanent.results.atomic import atomic_replacement
from remanent.results.mat_reader import read_mat

__all__ = ["read", "write"]

#: The variable with what the others cannot say.
_METADATA_VARIABLE: Final = "metadata"
#: Longest name of a variable in MATLAB.
_MAX_MATLAB_NAME_LENGTH: Final = 63
#: The first bytes of a MAT file are text, in which SciPy writes the time.
_FILE_HEADER: Final = b"MATLAB 5.0 MAT-file, written by remanent".ljust(116)


def write(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write a Dataset to a MAT file of version 5, whole or not at all.

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
        A variable holds objects, or two names are the same in MATLAB.
    """
    from scipy.io import savemat

    path = Path(path)
    contents: dict[str, Any] = {}
    descriptions: dict[str, metadata.VariableRecord] = {}
    for name, variable in metadata.ordered_variables(dataset).items():
        metadata.require_storable(name, variable)
        key = _matlab_name(name)
        if key in {*contents, _METADATA_VARIABLE}:
            raise InputError(
                name,
                must="have a name of its own in MATLAB",
                got=key,
                why="Another variable has the same.",
                fix="Rename it: dataset.rename({...: ...}).",
            )
        about = metadata.variable_record(variable, coordinate=name in dataset.coords)
        descriptions[name] = {"variable": key, **about}
        text = metadata.holds_text(variable)
        contents[key] = variable.values.astype(object) if text else variable.values
    about_all = {
        "attributes": metadata.encode_attributes(dataset.attrs), "variables": descriptions
    }  # fmt: skip
    contents[_METADATA_VARIABLE] = json.dumps(about_all)
    with atomic_replacement(path) as part:
        savemat(part, contents, appendmat=False, oned_as="column", do_compression=True)
        with part.open("r+b") as file:
            file.write(_FILE_HEADER)
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
        A file without ``metadata``.
    """
    contents = read_mat(Path(path)).arrays
    if _METADATA_VARIABLE not in contents:
        raise InputError(
            "path",
            must="be a MAT file that rm.save wrote",
            got=str(path),
            why=f"Its `{_METADATA_VARIABLE}` says what the variables are.",
            fix="Read other files by read_measurements.",
        )
    about = json.loads(str(np.ravel(contents[_METADATA_VARIABLE])[0]))
    descriptions: dict[str, metadata.VariableRecord] = about["variables"]
    values = {name: _unpack_values(contents[d["variable"]], d) for name, d in descriptions.items()}
    return metadata.dataset_from_records(values, descriptions, about["attributes"])


def _matlab_name(name: str) -> str:
    """The name with what MATLAB allows in one: letters, digits and ``_``, a letter first."""
    key = re.sub(r"\W", "_", name, flags=re.ASCII)
    return (key if key[:1].isalpha() else f"x{key}")[:_MAX_MATLAB_NAME_LENGTH]


def _unpack_values(array: NDArray[Any], about: metadata.VariableRecord) -> NDArray[Any]:
    return array if about["dtype"] != "str" else np.ravel(array).astype(np.str_)
