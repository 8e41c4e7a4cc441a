"""Measurements, from tables and files with units to dimensionless Datasets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pandas as pd
import xarray as xr

from remanent._arrays import is_quantity
from remanent._checks import as_float_array, require_mapping, shortened_repr
from remanent._errors import InputError, warn_of_input
from remanent._typing import FloatArray
from remanent.models.system import System
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.results.headings import (
    ABSCISSA_NAMES,
    Heading,
    canonical_name,
    measurable_names,
    suggestions,
    variable_name,
)
from remanent.results.mat_reader import read_mat
from remanent.results.measured_values import dimensionless_column
from remanent.results.text_tables import read_text_table

__all__ = ["MeasurementSource", "read_measurements"]

#: What :func:`read_measurements` reads.
MeasurementSource: TypeAlias = xr.Dataset | pd.DataFrame | Mapping[str, Any] | str | PathLike[str]


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
    data : path, pandas.DataFrame, mapping of str to array, or xarray.Dataset
        A path to a text file (commas, semicolons or tabs; decimal points or commas; UTF-8,
        UTF-16 or Latin-1) or a MAT file (versions 5 to 7.2), a DataFrame, a mapping of names to
        arrays, or a Dataset, which is taken as it is.  Columns are called as in results:
        ``time`` or ``omega`` (or ``frequency``), ``thickness_stretch``, ``amplitude`` ...,
        with a unit in brackets, ``time [ms]``, where they are not dimensionless;
        ``thickness_stretch_error`` is a standard deviation.  Thicknesses in mm become
        stretches by the size of the actuator; ``Thickness [mm]`` is understood.  Columns of
        other names are left aside, with a warning that names them.
    actuator : Actuator, optional
        Made by ``Actuator.from_si``, where there are units.
    names : mapping of str to str, optional
        From headings, with or without their units, to these names.
    units : mapping of str to str, optional
        Units by name, for files that cannot hold them in headings.

    Returns
    -------
    xarray.Dataset
        Dimensionless, along ``time`` or ``omega``, sorted; rows with NaN, or where an array is
        masked, are left out.  The attributes say which actuator, so that
        :func:`remanent.to_si` turns them back.

    Raises
    ------
    InputError
        An unreadable file, an unknown unit, neither time nor frequency, nothing measured; two
        columns for one variable, times that repeat or lie before 0, infinite values.

    Warns
    -----
    InputWarning
        Names columns that are left aside.

    See Also
    --------
    fit : Parameters from what was read.
    logarithmic_decrement : Damping from a ring-down.
    load : Results that :func:`remanent.save` wrote.

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
    given_names = _require_text_mapping("names", names)
    given_units = _require_text_mapping("units", units)
    if isinstance(data, xr.Dataset):
        return _require_plain_dataset(data)
    columns, left_aside = _chosen_columns(_read_table(data), given_names, given_units)
    numbers = {
        column.name: dimensionless_column(
            column.name, column.values, column.unit, column.argument, actuator
        )
        for column in columns
    }
    _require_abscissa(numbers, left_aside)
    along: str = next(name for name in ABSCISSA_NAMES if name in numbers)
    table = pd.DataFrame(numbers).dropna().sort_values(along, kind="stable")
    _require_rows(table, along)
    labelled: dict[str, Labelled] = {n: ((along,), table[n].to_numpy()) for n in table}
    coordinate = {along: labelled.pop(along)}
    if left_aside:
        warn_of_input(_left_aside_message(left_aside))
    about = {} if actuator is None else provenance.attributes(actuator, None, None)
    if left_aside:
        about["left_aside"] = ", ".join(heading.text for heading in left_aside)
    return build.dataset(labelled, coordinate, about)


@dataclass(frozen=True)
class _Column:
    """A column that is read: the variable it means, its values and unit, and who gave the unit."""

    name: str
    values: Any
    unit: str | None
    argument: str


def _chosen_columns(
    table: Mapping[str, Any], names: Mapping[str, str], units: Mapping[str, str]
) -> tuple[list[_Column], list[Heading]]:
    """The columns that mean something, and the headings of the others."""
    headings = {text: Heading.of(text, has_unit=is_quantity(v)) for text, v in table.items()}
    _require_used("names", names, headings.values())
    asked = {
        text: target
        for text, heading in headings.items()
        for key, target in names.items()
        if key in heading.spellings
    }
    renamed = {text: _require_measurable(headings[text], units, t) for text, t in asked.items()}
    meanings = {
        text: renamed.get(text, heading.meaning)
        for text, heading in headings.items()
        if text in renamed or heading.meaning not in renamed.values()
    }
    chosen = {text: name for text, name in meanings.items() if name is not None}
    for text, name in chosen.items():
        others = [headings[t].text for t, n in chosen.items() if n == name]
        if len(others) > 1:
            raise InputError(
                "data",
                must=f"have one column for {name}",
                got=" and ".join(map(repr, others)),
                why="Only one of them can be compared.",
                fix=f"Say which, names={{{headings[text].text!r}: {name!r}}}.",
            )
    by_name = {name: _unit_of(name, headings[text], units) for text, name in chosen.items()}
    _require_units_used(units, headings, chosen)
    columns = [_Column(name, table[text], *by_name[name]) for text, name in chosen.items()]
    return columns, [heading for text, heading in headings.items() if text not in chosen]


def _unit_of(name: str, heading: Heading, units: Mapping[str, str]) -> tuple[str | None, str]:
    """The unit of a column, and the argument that gave it."""
    for key, unit in units.items():
        if key == name or key in heading.spellings:
            return unit, f"units[{key!r}]"
    return heading.unit, f"data[{heading.text!r}]"


def _require_used(name: str, table: Mapping[str, str], headings: Iterable[Heading]) -> None:
    """Refuse entries that belong to no column, which are misspelt."""
    known = list(headings)
    for key in table:
        if not any(key in heading.spellings for heading in known):
            raise _unused_entry_error(name, key, known)


def _require_units_used(
    units: Mapping[str, str], headings: Mapping[str, Heading], chosen: Mapping[str, str]
) -> None:
    for key in units:
        spelt = any(key in heading.spellings for heading in headings.values())
        if key not in chosen.values() and not spelt:
            raise _unused_entry_error("units", key, list(headings.values()))


def _unused_entry_error(name: str, key: str, headings: list[Heading]) -> InputError:
    return InputError(
        name,
        must=f"be of columns, which are {shortened_repr([h.text for h in headings])}",
        got=shortened_repr(key),
        why="An entry without a column would be passed over.",
        fix="Write it as the heading of the column.",
    )


def _require_measurable(heading: Heading, units: Mapping[str, str], target: str) -> str:
    """The variable that a caller gave a column, if there is such a one."""
    has_unit = heading.has_unit or not heading.spellings.isdisjoint(units)
    name = variable_name(canonical_name(target), has_unit=has_unit)
    if name is None:
        plain = sorted(name for name in measurable_names() if not name.endswith("_error"))
        raise InputError(
            f"names[{shortened_repr(heading.text)}]",
            must="be a variable that can be measured",
            got=shortened_repr(target),
            why="Each column is compared with one of a history or of a response.",
            fix=f"Name one of {', '.join(plain)}, or one of these with _error at the end.",
        )
    return name


def _left_aside_message(headings: list[Heading]) -> str:
    texts = ", ".join(repr(heading.text) for heading in headings)
    hint = suggestions(headings) or "Give them a meaning by names={...}, or leave them out."
    return f"`data`: columns that mean no variable are left aside: {texts}. {hint}"


def _require_abscissa(columns: Mapping[str, FloatArray], left_aside: list[Heading]) -> None:
    along = [name for name in ABSCISSA_NAMES if name in columns]
    measured = set(columns) - {*along, *(f"{name}_error" for name in along)}
    lengths = {values.size for values in columns.values()}
    if len(along) == 1 and len(lengths) == 1 and measured:
        return
    found = {name: values.size for name, values in columns.items()}
    others = f"; {', '.join(repr(h.text) for h in left_aside)} left aside" if left_aside else ""
    raise InputError(
        "data",
        must="have a column `time` or `omega`, one of the two, and measured ones as long",
        got=f"{found or 'none of them'}{others}",
        why="A measurement is a history or a response.",
        fix=suggestions(left_aside)
        or "Name the columns by names={...}, as in {'Gap': 'thickness_stretch'}.",
    )


def _require_rows(table: pd.DataFrame, along: str) -> None:
    """Refuse what is no history and no response: nothing, repetitions, times before the start."""
    values = table[along].to_numpy()
    repeated = values[1:][np.diff(values) == 0.0]
    lowest = values[0] if values.size else np.nan
    again = f", {repeated.size} more than one at {along} = {repeated[0]:g}" if repeated.size else ""
    if not values.size or repeated.size:
        raise InputError(
            "data",
            must=f"have rows, and one for each {along}",
            got=f"{values.size} rows{again}",
            why="Repeated points would make a coordinate ambiguous.",
            fix="Average them first.",
        )
    if lowest < 0.0 or (along == "omega" and lowest == 0.0):
        raise InputError(
            "data",
            must="start at time 0 or later" if along == "time" else "have frequencies above 0",
            got=f"{along} = {lowest:g}",
            why="The motion starts at tau = 0." if along == "time" else "A load is periodic.",
            fix="Leave rows before the start out, or count time from the first.",
        )


def _require_plain_dataset(data: xr.Dataset) -> xr.Dataset:
    """A Dataset, if it is dimensionless numbers."""
    if "scales_applied" in data.attrs:
        raise InputError(
            "data",
            must="be dimensionless where it is a Dataset",
            got="a Dataset in SI",
            why="It is taken as it is.",
            fix="Pass the result that to_si was given.",
        )
    for name, variable in data.variables.items():
        if name in measurable_names():
            as_float_array(
                f"data[{name!r}]",
                variable,
                what="measured values",
                why="A Dataset is taken as it is.",
                fix="Pass numbers without a unit.",
            )
    return data


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


def _read_table(data: Any) -> Mapping[str, Any]:
    """Columns by heading."""
    if isinstance(data, str | PathLike):
        path = Path(data)
        if path.suffix.lower() != ".mat":
            return read_text_table(path)
        contents = read_mat(path, "data")
        return {**contents.arrays, **dict.fromkeys(contents.other_names)}
    if isinstance(data, pd.DataFrame):
        named = data.index.name is not None or isinstance(
            data.index, pd.DatetimeIndex | pd.TimedeltaIndex
        )
        table = data.rename_axis(data.index.name or "time").reset_index() if named else data
        return dict(table.items())
    if isinstance(data, Mapping):
        return dict(data.items())
    raise InputError(
        "data",
        must="be a table: a path, a DataFrame, a mapping of names to arrays or a Dataset",
        got=shortened_repr(data),
        why="Its columns are measurements.",
        fix="Pass for example {'time': t, 'thickness_stretch': x}.",
    )
