"""Measurements, from tables and files with units to dimensionless Datasets."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
import xarray as xr

from remanent import _units
from remanent._checks import as_float_array, require_mapping, shortened_repr
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.models.system import System
from remanent.results import build
from remanent.results.build import Labelled
from remanent.results.schema import QuantityKind, describe

__all__ = ["MeasurementSource", "read_measurements"]

#: What :func:`read_measurements` reads.
MeasurementSource: TypeAlias = xr.Dataset | pd.DataFrame | Mapping[str, Any] | str | PathLike[str]
#: ``time [ms]``, ``omega (rad/s)`` or ``amplitude``.
_HEADING_PATTERN = re.compile(r"\s*(.*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*")
#: SI unit of each kind, and the scale that makes a number of it dimensionless.
_SI_UNITS_AND_SCALES: Mapping[QuantityKind, tuple[str, str, float]] = {
    QuantityKind.TIME: ("s", "time_s", -1.0),
    QuantityKind.RATE: ("1/s", "time_s", 1.0),
    QuantityKind.LOAD: ("T", "load_T", -1.0),
    QuantityKind.STRESS: ("Pa", "stress_pa", -1.0),
    QuantityKind.ENERGY_DENSITY: ("J/m^3", "stress_pa", -1.0),
}
_ABSCISSA_NAMES = ("time", "omega")


def read_measurements(
    data: MeasurementSource,
    actuator: System | None = None,
    *,
    names: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> xr.Dataset:
    """Read measurements: a history against time, or a response against frequency.

    Parameters
    ----------
    data
        A path to a CSV or a MAT file (up to version 7.2), a DataFrame, a mapping of names to
        arrays, or a Dataset, which is taken as it is.  Columns are called as in results:
        ``time`` or ``omega`` (or ``frequency``), ``thickness_stretch``, ``amplitude`` ...,
        with a unit in brackets, ``time [ms]``, where they are not dimensionless;
        ``thickness_stretch_error`` is a standard deviation.
    actuator
        Made by ``Actuator.from_si``, where there are units.
    names
        From headings, without their units, to these names.
    units
        Units by name, for files that cannot hold them in headings.

    Returns
    -------
    xarray.Dataset
        Dimensionless, along ``time`` or ``omega``, sorted; rows with NaN are left out.

    Raises
    ------
    InputError
        An unreadable file, an unknown column or unit, or neither time nor frequency.

    Examples
    --------
    >>> ds = read_measurements({"time": [0.0, 1.0, 2.0], "thickness stretch": [1.0, 1.1, 1.0]})
    >>> dict(ds.sizes), list(ds.data_vars)
    ({'time': 3}, ['thickness_stretch'])
    """
    if actuator is not None and not isinstance(actuator, System):
        raise InputError(
            "actuator",
            must="be a system, or left out",
            got=shortened_repr(actuator),
            why="Its scales turn units into dimensionless numbers.",
            fix="Pass one that Actuator.from_si made.",
        )
    if isinstance(data, xr.Dataset):
        return data
    columns = _dimensionless_columns(
        _read_table(data),
        actuator,
        _require_text_mapping("names", names),
        _require_text_mapping("units", units),
    )
    along = [name for name in _ABSCISSA_NAMES if name in columns]
    if len(along) != 1 or len({v.size for v in columns.values()}) != 1 or len(columns) < 2:
        raise InputError(
            "data",
            must="have a column `time` or `omega`, and others as long",
            got=list(columns),
            why="A measurement is a history or a response.",
            fix="Name the columns by names={...}.",
        )
    table = pd.DataFrame(columns).dropna().sort_values(along[0])
    if not len(table) or table[along[0]].duplicated().any():
        raise InputError(
            "data",
            must=f"have rows, and one for each {along[0]}",
            got=f"{len(table)} rows",
            why="Repeated points would make a coordinate ambiguous.",
            fix="Average them first.",
        )
    labelled: dict[str, Labelled] = {n: ((along[0],), table[n].to_numpy()) for n in table}
    coordinate = {along[0]: labelled.pop(along[0])}
    return build.dataset(labelled, coordinate, {})


def _dimensionless_columns(
    table: Mapping[str, Any],
    actuator: System | None,
    names: Mapping[str, str],
    units: Mapping[str, str],
) -> dict[str, FloatArray]:
    """Dimensionless columns under the names that results have."""
    headings = [_split_heading(heading) for heading in table]
    _require_used("names", names, [text for text, _ in headings])
    columns: dict[str, FloatArray] = {}
    called = [names.get(text, text).strip().replace(" ", "_").lower() for text, _ in headings]
    _require_used("units", units, called)
    for name, (_, bracket), values in zip(called, headings, table.values(), strict=True):
        key = "omega" if name == "frequency" else name
        unit, source = (units[name], "units") if name in units else (bracket, "data")
        argument = f"{source}[{name!r}]"
        columns[key] = _dimensionless_values(
            key, np.ravel(np.asarray(values)), unit, actuator, argument
        )
    return columns


def _split_heading(heading: object) -> tuple[str, str | None]:
    """The text of a heading, and the unit in its brackets."""
    match = _HEADING_PATTERN.fullmatch(str(heading))
    return (match[1], match[2]) if match else (str(heading), None)


def _require_text_mapping(name: str, value: object) -> Mapping[str, str]:
    """A mapping of text to text; empty where nothing was passed."""
    if value is None:
        return {}
    fix = "Pass for example {'time': 's'}."
    table = require_mapping(name, value, what="text to text", fix=fix)
    for key, text in table.items():
        if not isinstance(text, str):
            raise InputError(
                f"{name}[{key!r}]",
                must="be text",
                got=shortened_repr(text),
                why="Names and units are written in words.",
                fix=fix,
            )
    return table


def _require_used(name: str, table: Mapping[str, str], headings: Sequence[str]) -> None:
    """Refuse entries that belong to no column, which are misspelt."""
    for key in table:
        if key not in headings:
            raise InputError(
                name,
                must=f"be of columns, which are {', '.join(headings)}",
                got=repr(key),
                why="An entry without a column would be passed over.",
                fix="Write it as the heading of the column.",
            )


def _read_table(data: Any) -> Mapping[str, Any]:
    if not isinstance(data, str | PathLike):
        if not isinstance(data, Mapping | pd.DataFrame):
            raise InputError(
                "data",
                must="be a table: a path, a DataFrame, a mapping of names to arrays or a Dataset",
                got=shortened_repr(data),
                why="Its columns are measurements.",
                fix="Pass for example {'time': t, 'thickness_stretch': x}.",
            )
        return dict(data.items())
    path = Path(data)
    try:
        if path.suffix.lower() == ".mat":
            return _read_mat(path)
        return dict(pd.read_csv(path, comment="#", skipinitialspace=True).items())
    except (OSError, ValueError, NotImplementedError, UnicodeDecodeError) as error:
        raise InputError(
            "data",
            must="be a readable CSV or MAT file",
            got=str(path),
            why=f"{error}.",
            fix="Check the path; save MAT files with the option -v7.",
        ) from error


def _read_mat(path: Path) -> Mapping[str, Any]:
    from scipy.io import loadmat

    return {k: v for k, v in loadmat(path, squeeze_me=True).items() if not k.startswith("__")}


def _dimensionless_values(
    name: str, values: Any, unit: str | None, actuator: System | None, argument: str
) -> FloatArray:
    """Values of a variable without their unit, which came with `argument`."""
    numbers = as_float_array(
        f"data[{name!r}]",
        values,
        what="measured values",
        why="Everything but its heading is measured.",
        fix="Leave other rows out of the file.",
    )
    kind = describe(name).kind
    if unit in {None, "", "1"} or (unit == "K" and kind is QuantityKind.TEMPERATURE):
        return numbers
    quantity = _units.with_unit(argument, numbers, unit)
    if kind in {QuantityKind.NONE, QuantityKind.TEMPERATURE}:
        unit = "K" if kind is not QuantityKind.NONE else ""
        return np.asarray(_units.magnitude_in_unit(argument, quantity, unit))
    scales = None if actuator is None else actuator.scales
    if scales is None:
        raise InputError(
            argument,
            must="be dimensionless for this actuator",
            got=f"values in {unit}",
            why="Dimensionless numbers alone do not fix a length or a stress.",
            fix="Build it with Actuator.from_si.",
        )
    if kind is QuantityKind.FREQUENCY:
        return np.asarray(_units.radians_per_second(argument, quantity) * scales.time_unit)
    if kind not in _SI_UNITS_AND_SCALES:
        raise InputError(
            argument,
            must="be of a kind that has a unit",
            got=unit,
            why="It is not measured.",
            fix="Leave it out.",
        )
    base, scale, power = _SI_UNITS_AND_SCALES[kind]
    one = scales.flux_density_unit if kind is QuantityKind.LOAD else scales.si_factors()[scale]
    return np.asarray(_units.magnitude_in_unit(argument, quantity, base) * one**power)
