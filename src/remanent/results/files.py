"""Results to files and back, in the format that the ending of the name says."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Final

import xarray as xr

from remanent._errors import InputError, error_sentence, shortened_repr
from remanent.results import mat, netcdf, stores, table
from remanent.results.checks import is_file

__all__ = ["load", "require_path", "save"]

#: The module that writes and reads files of each ending.
_FORMAT_MODULES: Final[Mapping[str, ModuleType]] = MappingProxyType(
    {".nc": netcdf, ".csv": table, ".mat": mat}
)


def save(dataset: xr.Dataset, path: str | os.PathLike[str]) -> Path:
    """Write a result to a file, whole or not at all.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of a verb, or what was computed from one.
    path : str or path
        Where to, in a folder that exists; a file that is there is replaced.  The ending says
        how:

        ``.nc``
            netCDF-4 of the classic model, which MATLAB (``ncread``), xarray, Panoply and others
            open.  It has no complex numbers and no text: a complex ``x`` is two variables,
            ``x_real`` and ``x_imag``; text is a number with its meaning beside it
            (``flag_values``, ``flag_meanings``); a truth value is 0 or 1.
        ``.csv``
            One table with a row for each point and a column for each variable, below comments
            that begin with ``#`` (in pandas ``read_csv(path, comment="#")``).  Some variable
            must have all dimensions; others are repeated along those that they lack.
        ``.mat``
            A MAT file of version 5 (``load`` in MATLAB and Octave, ``scipy.io.loadmat``), with
            the attributes as JSON in ``metadata``.  A dot in a name becomes ``_``.

    Returns
    -------
    pathlib.Path
        The file.

    Raises
    ------
    InputError
        Another ending, a folder that does not exist or cannot be written to, a variable
        that is no number and no text, or for ``.csv`` variables of several tables.

    See Also
    --------
    load : The way back.
    read_measurements : To read files of other origin.

    Notes
    -----
    All three keep everything: values bit for bit, complex and boolean variables and text, names,
    dimensions, coordinates and attributes.  A file depends on its Dataset alone and holds
    no clock time, so equal results make equal files.

    Examples
    --------
    >>> import tempfile
    >>> import remanent as rm
    >>> result = rm.equilibria(rm.Actuator(), 0.16)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     rm.load(rm.save(result, f"{folder}/rest.nc")).identical(result)
    True
    """
    if not isinstance(dataset, xr.Dataset):
        raise InputError(
            "dataset",
            must="be an xarray.Dataset",
            got=type(dataset).__name__,
            why="A file holds variables by name.",
            fix="Pass a Dataset; array.to_dataset(name=...) makes one of a DataArray.",
        )
    unnamed = [name for name in (*dataset.variables, *dataset.dims) if not isinstance(name, str)]
    if unnamed:
        raise InputError(
            "dataset",
            must="have names that are text, of variables and of dimensions",
            got=shortened_repr(unnamed[0]),
            why="Files know no other names.",
            fix="Rename it: dataset.rename({...}).",
        )
    target = require_path("path", path)
    module = _format_module(target)
    if not target.parent.is_dir():
        raise InputError(
            "path",
            must="lie in a folder that exists",
            got=shortened_repr(str(path)),
            why=f"There is no folder {str(target.parent)!r}.",
            fix="Create it first.",
        )
    with _explain_file_errors("written", target, OSError):
        module.write(dataset, target)
    return target


def load(path: str | os.PathLike[str]) -> xr.Dataset:
    """Read a result that :func:`save` wrote.

    Parameters
    ----------
    path : str or path
        A file with the ending ``.nc``, ``.csv`` or ``.mat``, or the folder of a study's store.
        Every netCDF file without groups can be read, also one of other origin.

    Returns
    -------
    xarray.Dataset
        Equal to what was saved, in memory: values bit for bit, types, names, dimensions,
        coordinates and attributes.  Sequences among the attributes come back as arrays.

    Raises
    ------
    InputError
        Another ending, a file that is missing, damaged, or was not written by :func:`save`.

    See Also
    --------
    save : The way there.
    read_measurements : To read CSV and MAT files of other origin.

    Examples
    --------
    >>> import tempfile
    >>> import remanent as rm
    >>> section = rm.poincare_section(rm.Actuator(), rm.SineSquared(0.4, 1.25), periods=3)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     again = rm.load(rm.save(section, f"{folder}/section.csv"))
    >>> again.identical(section)
    True
    """
    source = require_path("path", path)
    is_store = stores.is_store(source)
    module = stores if is_store else _format_module(source)
    if not is_store and not is_file(source):
        raise InputError(
            "path",
            must="be a file",
            got=shortened_repr(str(path)),
            why="There is none of that name.",
            fix="Check the path.",
        )

    # What the readers of other packages raise of a damaged file is not limited.
    with _explain_file_errors("read", source, Exception):
        dataset: xr.Dataset = module.read(source)
    return dataset


def require_path(name: str, path: object) -> Path:
    """A path in text or as an object; anything else, and nothing but blanks, is refused."""
    if not isinstance(path, str | os.PathLike) or "\0" in str(path) or not str(path).strip():
        raise InputError(
            name,
            must="be a path",
            got=shortened_repr(path),
            why="It says where results are.",
            fix="Pass for example 'result.nc', or 'chart.zarr' for a store.",
        )
    return Path(path)


def _format_module(path: Path) -> ModuleType:
    module = _FORMAT_MODULES.get(path.suffix.lower())
    if module is None:
        endings = ", ".join(_FORMAT_MODULES)
        raise InputError(
            "path",
            must=f"end in one of {endings}",
            got=shortened_repr(str(path)),
            why="The ending says the format.",
            fix="Use .nc for everything, .csv for one table, .mat for MATLAB and Octave.",
        )
    return module


@contextmanager
def _explain_file_errors(action: str, path: Path, errors: type[Exception]) -> Iterator[None]:
    """Say in words that a file cannot be written or read."""
    try:
        yield
    except InputError:
        raise
    except errors as error:
        raise InputError(
            "path",
            must=f"be a file that can be {action}",
            got=shortened_repr(str(path)),
            why=error_sentence(error),
            fix="Check the disk, the permissions and the file.",
        ) from error
