"""Measurements, from tables and files with units to dimensionless Datasets."""

from __future__ import annotations

import re
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
import xarray as xr

from remanent import _units
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.models.actuator import Actuator
from remanent.results import build
from remanent.results.build import Labelled
from remanent.results.schema import Kind, describe

__all__ = ["Table", "read_measurements"]

#: What :func:`read_measurements` reads.
Table: TypeAlias = xr.Dataset | pd.DataFrame | Mapping[str, Any] | str | PathLike[str]
#: ``time [ms]``, ``omega (rad/s)`` or ``amplitude``.
_HEADING = re.compile(r"\s*(.*?)\s*(?:[\[(]\s*([^\])]*?)\s*[\])])?\s*")
#: SI unit of each kind, and the scale that makes a number of it dimensionless.
_SI: Mapping[Kind, tuple[str, str, float]] = {
    Kind.TIME: ("s", "time_s", -1.0),
    Kind.RATE: ("1/s", "time_s", 1.0),
    Kind.LOAD: ("T", "load_T", -1.0),
    Kind.STRESS: ("Pa", "stress_pa", -1.0),
    Kind.ENERGY_DENSITY: ("J/m^3", "stress_pa", -1.0),
}
_ALONG = ("time", "omega")


def read_measurements(
    data: Table,
    actuator: Actuator | None = None,
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
    if isinstance(data, xr.Dataset):
        return data
    columns: dict[str, FloatArray] = {}
    for heading, values in _table(data).items():
        match = _HEADING.fullmatch(str(heading))
        said = match[1] if match else str(heading)
        name = (names or {}).get(said, said).strip().replace(" ", "_").lower()
        unit = (units or {}).get(name, match[2] if match else None)
        key = "omega" if name == "frequency" else name
        columns[key] = _dimensionless(key, np.ravel(np.asarray(values)), unit, actuator)
    along = [name for name in _ALONG if name in columns]
    if len(along) != 1 or len({v.size for v in columns.values()}) != 1 or len(columns) < 2:
        raise InputError(
            "data", "have a column `time` or `omega`, and others as long", list(columns),
            "A measurement is a history or a response.", "Name the columns by names={...}.",
        )  # fmt: skip
    table = pd.DataFrame(columns).dropna().sort_values(along[0])
    if not len(table) or table[along[0]].duplicated().any():
        raise InputError(
            "data", f"have rows, and one for each {along[0]}", f"{len(table)} rows",
            "Repeated points would make a coordinate ambiguous.", "Average them first.",
        )  # fmt: skip
    labelled: dict[str, Labelled] = {n: ((along[0],), table[n].to_numpy()) for n in table}
    coordinate = {along[0]: labelled.pop(along[0])}
    return build.dataset(labelled, coordinate, {})


def _table(data: Any) -> Mapping[str, Any]:
    if not isinstance(data, str | PathLike):
        return dict(data.items())
    path = Path(data)
    try:
        if path.suffix.lower() == ".mat":
            return _mat(path)
        return dict(pd.read_csv(path, comment="#", skipinitialspace=True).items())
    except (OSError, ValueError, NotImplementedError, UnicodeDecodeError) as error:
        raise InputError(
            "data", "be a readable CSV or MAT file", str(path), f"{error}.",
            "Check the path; save MAT files with the option -v7.",
        ) from error  # fmt: skip


def _mat(path: Path) -> Mapping[str, Any]:
    from scipy.io import loadmat

    return {k: v for k, v in loadmat(path, squeeze_me=True).items() if not k.startswith("__")}


def _dimensionless(
    name: str, values: Any, unit: str | None, actuator: Actuator | None
) -> FloatArray:
    try:
        numbers = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(
            name, "be a column of numbers", repr(values[:3]),
            "Everything but its heading is measured.", "Leave other rows out of the file.",
        ) from error  # fmt: skip
    kind = describe(name).kind
    if unit in {None, "", "1"} or (unit == "K" and kind is Kind.TEMPERATURE):
        return numbers
    quantity = _units.quantity(name, numbers, unit)
    if kind in {Kind.NONE, Kind.TEMPERATURE}:
        return np.asarray(_units.magnitude(name, quantity, "K" if kind is not Kind.NONE else ""))
    scales = None if actuator is None else actuator.scales
    if scales is None:
        raise InputError(
            name, "be dimensionless for this actuator", f"values in {unit}",
            "Dimensionless numbers alone do not fix a length or a stress.",
            "Build it with Actuator.from_si.",
        )  # fmt: skip
    if kind is Kind.FREQUENCY:
        return np.asarray(_units.angular_frequency(name, quantity) * scales.time)
    if kind not in _SI:
        raise InputError(
            name, "be of a kind that has a unit", unit, "It is not measured.", "Leave it out."
        )
    base, scale, power = _SI[kind]
    one = scales.flux_density if kind is Kind.LOAD else scales.factors()[scale]
    return np.asarray(_units.magnitude(name, quantity, base) * one**power)
