"""Attributes that say what made a Dataset, for people and for programs; no clock time."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Final

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent.models.drives.base import Drive
from remanent.models.plain import from_plain_data, to_plain_data
from remanent.models.system import System
from remanent.models.variable_text import VariableText
from remanent.results.checks import require_dataset

__all__ = [
    "DRIVE_ATTRIBUTE",
    "ORIGIN_ATTRIBUTE_NAMES",
    "SYSTEM_ATTRIBUTE",
    "attributes",
    "has_drive",
    "model_attributes",
    "observable_name",
    "own_variable_texts",
    "package_versions",
    "read_drive",
    "read_plain_model",
    "read_system",
    "varying_field_names",
]  # fmt: skip

#: Attribute with the name of the observable of a system of one's own.
OBSERVABLE_ATTRIBUTE: Final = "observable"
#: The observable of an actuator.
ACTUATOR_OBSERVABLE: Final = "thickness_stretch"
#: Packages whose version can change a number.
VERSIONED_PACKAGES: Final = ("remanent", "numpy", "llvmlite", "xarray")
#: Attribute with the system as JSON; with ``_text`` after it, that for people.
SYSTEM_ATTRIBUTE: Final = "system"
#: Attribute with the drive as JSON; with ``_text`` after it, that for people.
DRIVE_ATTRIBUTE: Final = "drive"
#: Attributes that say where numbers come from, whatever was done to them since.
ORIGIN_ATTRIBUTE_NAMES: Final = (
    SYSTEM_ATTRIBUTE,
    f"{SYSTEM_ATTRIBUTE}_text",
    DRIVE_ATTRIBUTE,
    f"{DRIVE_ATTRIBUTE}_text",
    "versions",
)
#: Largest integer that files hold: it is one of the numbers that floats hold exactly.
_LARGEST_INTEGER: Final = 2**53 - 1
#: Longest description of a value for people; tables of samples are cut there.
MAX_MODEL_TEXT_LENGTH: Final = 1000


def attributes(
    system: object,
    drive: object,
    tolerance: float | None,
    *,
    over: Iterable[str] = (),
    **settings: Any,
) -> dict[str, Any]:
    """Describe how a Dataset was made.

    Parameters
    ----------
    system, drive : System and Drive, or other frozen dataclasses
        `drive` may be None (equilibria).  Text is kept as text for people.
    tolerance : float or None
        The tolerance asked for; None where nothing was integrated.
    over : iterable of str
        Names of the fields that were given many values: their value in `system` or `drive`
        is not the one that was used.
    **settings : float, int, str, sequence of float or None
        What else decides the numbers (``duration``, ``every``, ``method``).  None is left out;
        tables are kept flat, as attributes of netCDF have one dimension.

    Returns
    -------
    dict
        Strings and numbers only, as netCDF wants: ``system`` and ``drive`` as JSON, which
        :func:`read_system` and :func:`read_drive` read, ``system_text`` and ``drive_text``
        for people, ``over``, the settings with their names in ``settings``, ``tolerance``,
        ``versions``, ``scales``.  A value that is no plain data has its text only.

    See Also
    --------
    read_system, read_drive : the values that made a Dataset.
    remanent.models.plain.to_plain_data : what the JSON holds.

    Examples
    --------
    >>> from remanent import Constant
    >>> attrs = attributes("a pendulum", Constant(0.1), 1e-9, duration=100.0)
    >>> attrs["system_text"], attrs["drive"]
    ('a pendulum', '{"kind": "Constant", "m": 0.1}')
    >>> attrs["settings"], attrs["duration"], attrs["tolerance"]
    ('duration', 100.0, 1e-09)
    """
    given = {
        name: _flattened_sequence(value) for name, value in settings.items() if value is not None
    }
    attrs: dict[str, Any] = {
        "Conventions": "CF-1.11",
        "versions": package_versions(),
        **model_attributes(SYSTEM_ATTRIBUTE, system),
        **model_attributes(DRIVE_ATTRIBUTE, drive),
        **_entry_unless_empty("over", " ".join(over)),
        **_entry_unless_empty("settings", " ".join(given)),
        **given,
    }
    if tolerance is not None:
        attrs["tolerance"] = float(tolerance)
    scales = getattr(system, "scales", None)
    if scales is not None:
        factors = {name: float(factor) for name, factor in scales.si_factors().items()}
        attrs["scales"] = json.dumps(factors, sort_keys=True)
    return attrs


def model_attributes(name: str, value: object) -> dict[str, str]:
    """The attributes `name`, JSON, and ``<name>_text``; nothing for None and empty text."""
    if value is None or isinstance(value, str):
        return _entry_unless_empty(f"{name}_text", value or "")
    text = repr(value)
    if len(text) > MAX_MODEL_TEXT_LENGTH:
        text = f"{text[: MAX_MODEL_TEXT_LENGTH - 1]}…"
    try:
        return {name: json.dumps(to_plain_data(value)), f"{name}_text": text}
    except InputError:
        return {f"{name}_text": text}


def read_plain_model(dataset: xr.Dataset, name: str) -> dict[str, Any] | None:
    """The table of the system or the drive, attribute `name`; None where there is none."""
    try:
        table = json.loads(str(dataset.attrs.get(name, "")))
    except ValueError:
        return None
    return table if isinstance(table, dict) else None


def read_system(dataset: xr.Dataset) -> System:
    """The system that made a Dataset.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result, in memory or read from a file.

    Returns
    -------
    System
        As it was given to the verb, or as a fit found it.  Fields named in the attribute
        ``over`` have the value that `dataset` was reduced to
        (``dataset.sel(temperature=350)``); where it still has several, or dropped them, they
        keep the value from before, which was not used.

    Raises
    ------
    InputError
        The attribute is missing, as after arithmetic, or names a class that is not public.

    See Also
    --------
    remanent.read_drive : The drive.
    remanent.fit : Parameters from measurements.

    Examples
    --------
    >>> import remanent as rm
    >>> many = rm.equilibria(rm.Actuator(), 0.16, over={"temperature": [293.0, 350.0]})
    >>> rm.read_system(many.isel(temperature=1)).temperature
    350.0
    """
    system: System = _read_model(require_dataset("dataset", dataset), SYSTEM_ATTRIBUTE)
    return system


def read_drive(dataset: xr.Dataset) -> Drive:
    """The drive that made a Dataset; see :func:`read_system`.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result, in memory or read from a file.

    Returns
    -------
    Drive
        As it was given to the verb, or as a fit found it, with the values that `dataset` was
        reduced to.

    Raises
    ------
    InputError
        The attribute is missing, as after arithmetic, or names a class that is not public.

    See Also
    --------
    read_system : The system that made it.
    rescale : A result for another temperature.

    Examples
    --------
    >>> import remanent as rm
    >>> run = rm.simulate(rm.Actuator(), rm.SineSquared(0.4, 1.25), periods=1)
    >>> rm.read_drive(run)
    SineSquared(b=0.4, omega=1.25, phase=0.0)
    """
    drive: Drive = _read_model(require_dataset("dataset", dataset), DRIVE_ATTRIBUTE)
    return drive


def has_drive(dataset: xr.Dataset) -> bool:
    """Whether a Dataset says that it was made with a drive, readable or not."""
    return DRIVE_ATTRIBUTE in dataset.attrs or f"{DRIVE_ATTRIBUTE}_text" in dataset.attrs


def observable_name(dataset: xr.Dataset) -> str:
    """Name of the quantity whose extremes a Dataset follows: of an actuator the thickness."""
    return str(dataset.attrs.get(OBSERVABLE_ATTRIBUTE, ACTUATOR_OBSERVABLE))


def own_variable_texts(dataset: xr.Dataset) -> Mapping[str, VariableText]:
    """What a system of the user's own says of its variables; nothing where none made a Dataset."""
    try:
        return read_system(dataset).variable_texts()
    except InputError:  # it was dropped, or is no plain data
        return {}


def varying_field_names(dataset: xr.Dataset) -> list[str]:
    """Fields that were given many values and are not reduced to one in this Dataset."""
    names = str(dataset.attrs.get("over", "")).split()
    return [name for name in names if name not in dataset.coords or dataset[name].size != 1]


def _read_model(dataset: xr.Dataset, name: str) -> Any:
    table = read_plain_model(dataset, name)
    if table is None:
        raise InputError(
            "dataset",
            must=f"say which {name} made it",
            got=dataset.attrs.get(f"{name}_text", "one without the attribute"),
            why="Some operations drop attributes, and only plain data can be read back.",
            fix=f"Pass {name}=... as well, or the result of a verb as it was.",
        )
    value = from_plain_data(table)
    if not isinstance(value, System if name == SYSTEM_ATTRIBUTE else Drive):
        raise InputError(
            "dataset",
            must=f"say which {name} made it",
            got=repr(value),
            why=f"Its attribute `{name}` holds something else.",
            fix=f"Pass {name}=... as well.",
        )
    return _with_selected_values(value, dataset)


def _with_selected_values(value: Any, dataset: xr.Dataset) -> Any:
    """A system or a drive with the fields that a Dataset was reduced to."""
    reduced = set(str(dataset.attrs.get("over", "")).split()) - set(varying_field_names(dataset))
    for name in sorted(reduced & set(value.parameter_values())):
        number = float(dataset[name].item())
        if isinstance(value, Drive):
            value = value.replace(**{name: number})
        else:
            value = value.with_parameter(name, number)
    return value


@cache
def package_versions() -> str:
    """Names and versions of the packages whose version can change a number."""
    return ", ".join(f"{name} {_package_version(name)}" for name in VERSIONED_PACKAGES)


def _package_version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "(not installed)"


def _flattened_sequence(value: Any) -> Any:
    is_large = isinstance(value, int | np.integer) and abs(int(value)) > _LARGEST_INTEGER
    if is_large or isinstance(value, Fraction):
        return float(value)
    return tuple(np.ravel(value).tolist()) if isinstance(value, list | tuple) else value


def _entry_unless_empty(name: str, text: str) -> dict[str, str]:
    """Keep an entry unless it is empty: netCDF knows no empty text."""
    return {name: text} if text else {}
