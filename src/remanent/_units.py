"""Quantities with units, read at the edges of the package; inside there are none."""

from __future__ import annotations

import re
from collections.abc import Mapping
from datetime import date
from functools import cache, lru_cache
from importlib import import_module
from types import MappingProxyType
from typing import Any, Final, TypeAlias

import numpy as np

from remanent._arrays import as_float_array, is_time_or_date, without_wrapping
from remanent._errors import InputError, shortened_repr
from remanent._typing import FloatArray

#: Text such as ``"100 kPa"``, or a pint quantity.  (Pint is imported when needed.)
Quantity: TypeAlias = Any

#: A number and what follows it; the number is taken whole, so that long texts fail at once.
_QUANTITY_PATTERN: Final = re.compile(
    r"\s*((?>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?))\s*(\S.*?)\s*"
)
#: Longest text that is read as a unit, in characters.
_MAX_UNIT_CHARACTERS: Final = 80
#: Largest exponent of a unit.
_MAX_UNIT_EXPONENT: Final = 9
#: What a unit is written with: names, an exponent with its sign, operators.
_UNIT_TOKEN_PATTERN: Final = re.compile(
    r"(?P<name>°?[^\W\d_][^\W\d]*|[%℃])(?:(?:\*\*|\^)?(?P<exponent>[+-]?\d+)(?![\w.]))?"
    r"|(?P<operator>[*/()·⋅]|1(?=\s*/))|\s+"
)
#: Exponents that are written above the line.
_RAISED_DIGITS: Final = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺", "0123456789-+")
#: Names that pint has for something else, or not at all.
_OTHER_NAMES: Final[Mapping[str, str]] = MappingProxyType({
    "°C": "degC", "℃": "degC", "G": "field_in_gauss", "Gauss": "field_in_gauss",
    "gauss": "field_in_gauss", "kG": "kilofield_in_gauss", "mG": "millifield_in_gauss",
    "Oe": "field_in_gauss", "oersted": "field_in_gauss", "kOe": "kilofield_in_gauss",
})  # fmt: skip
#: One gauss, and one oersted in free space, in tesla; pint's own are of the cgs system.
_GAUSS_DEFINITION: Final = "field_in_gauss = 1e-4 T"
#: Permeability of free space as pint writes it, by which A/m become T.
_PERMEABILITY_UNIT: Final = "vacuum_permeability"
_ANGLE_UNITS: Final = frozenset({"radian", "degree", "turn", "revolution", "cycle", "milliradian"})


def magnitude_in_unit(name: str, quantity: Quantity, unit: str) -> float | FloatArray:
    """The number of `unit` in `quantity`: a float, or an array for an array.

    Parameters
    ----------
    name
        What the message calls it.
    quantity
        Text, ``"100 kPa"``, a pint quantity, a length of time of Python or NumPy, or a list of
        them.
    unit
        A unit that pint knows.

    Raises
    ------
    InputError
        If it has no unit, an unknown unit, or one of another dimension.
    """
    if isinstance(quantity, list | tuple):
        _require_entries(name, quantity, unit)
        return np.array([single_magnitude(name, entry, unit) for entry in quantity])
    value = _parse_quantity(name, quantity, unit)
    try:
        if unit == "T" and value.is_compatible_with("A/m"):  # in free space, B = mu0 H
            value = value * _unit_registry().Quantity(1.0, _PERMEABILITY_UNIT)
        converted = value.to(unit).magnitude
    except Exception as error:  # pint raises from several unrelated families
        raise _wrong_unit_error(name, quantity, unit) from error
    return _as_float_or_array(name, converted)


def with_unit(name: str, values: FloatArray, unit: str) -> Quantity:
    """Numbers with a unit, ``"ms"``."""
    try:
        return _unit_registry().Quantity(values, _as_pint_writes(unit))
    except Exception as error:  # pint raises from several unrelated families
        raise _wrong_unit_error(name, unit, "s, Hz, T, K") from error


def positive_magnitude(name: str, quantity: Quantity, unit: str) -> float:
    """The number of `unit` in one quantity that must be finite and greater than 0."""
    number = single_magnitude(name, quantity, unit)
    if not 0.0 < number < float("inf"):
        raise InputError(
            name,
            must="be greater than 0 and finite",
            got=shortened_repr(quantity),
            why="It is a physical size.",
            fix="Check its sign and its exponent.",
        )
    return number


def single_magnitude(name: str, quantity: Quantity, unit: str) -> float:
    """The number of `unit` in one quantity, not an array of them."""
    number = magnitude_in_unit(name, quantity, unit)
    if not isinstance(number, float):
        raise InputError(
            name,
            must="be a single quantity",
            got=shortened_repr(quantity),
            why="A model holds a single value of each field.",
            fix="Pass one quantity; for many values use over={...}.",
        )
    return number


def radians_per_second(name: str, quantity: Quantity) -> float | FloatArray:
    """Radians per second of a frequency, cycles (``"50 Hz"``) or angles (``"rad/s"``)."""
    if isinstance(quantity, list | tuple):
        _require_entries(name, quantity, "Hz")
        return np.array([radians_per_second(name, entry) for entry in quantity])
    value = _parse_quantity(name, quantity, "Hz")
    units = {str(unit) for unit, _ in value.unit_items()}
    roots = {str(unit) for unit, _ in value.to_root_units().unit_items()}
    if any(unit.endswith("hertz") for unit in units):
        return 2.0 * np.pi * magnitude_in_unit(name, value, "Hz")
    if roots & _ANGLE_UNITS:
        return magnitude_in_unit(name, value, "rad/s")
    raise InputError(
        name,
        must="be a frequency in Hz or an angular frequency in rad/s",
        got=shortened_repr(quantity),
        why="Plain 1/s does not say whether it counts cycles or radians.",
        fix='Write for example "50 Hz" or "314 rad/s".',
    )


def _require_entries(name: str, quantities: list[Any] | tuple[Any, ...], unit: str) -> None:
    """Refuse a list without entries, and lists within lists."""
    if not quantities or any(isinstance(entry, list | tuple) for entry in quantities):
        raise _no_quantity_error(name, quantities, unit)


def _parse_quantity(name: str, quantity: Quantity, unit: str) -> Any:
    """A pint quantity."""
    content = without_wrapping(quantity)
    if is_time_or_date(content):
        return _length_of_time(name, content, unit)
    if hasattr(content, "to") and hasattr(content, "magnitude"):
        return content
    match = _QUANTITY_PATTERN.fullmatch(content) if isinstance(content, str) else None
    if match is None:
        raise _no_quantity_error(name, quantity, unit)
    if not np.isfinite(float(match[1])):
        raise InputError(
            name,
            must=f"be a finite number of {unit}",
            got=shortened_repr(quantity),
            why="It is larger than every number that can be computed with.",
            fix="Check its exponent.",
        )
    try:
        return _unit_registry().Quantity(float(match[1]), _as_pint_writes(match[2]))
    except Exception as error:  # pint raises from several unrelated families
        raise _wrong_unit_error(name, quantity, unit) from error


def _length_of_time(name: str, value: Any, unit: str) -> Any:
    """Seconds of a timedelta, single or in an array; a date is no length of time."""
    try:
        if np.asarray(value).dtype.kind == "M" or isinstance(value, date):
            raise TypeError("a date is no length of time")
        seconds = np.asarray(value, dtype="timedelta64[ns]") / np.timedelta64(1, "s")
    except (TypeError, ValueError, OverflowError) as error:
        raise _no_quantity_error(name, value, unit) from error
    return _unit_registry().Quantity(seconds, "s")


@lru_cache(maxsize=256)
def _as_pint_writes(unit: str) -> str:
    """A unit as pint reads it: ``kg m-3`` and ``kg/m³`` become ``kg*m**-3`` and ``kg/m**3``.

    Raises
    ------
    ValueError
        If it is not made of names, exponents and ``* / ( )``, or is too long.
    """
    text = unit.translate(_RAISED_DIGITS).strip()
    if len(text) > _MAX_UNIT_CHARACTERS:
        raise ValueError("too long")
    parts: list[str] = []
    position = 0
    while position < len(text):
        token = _UNIT_TOKEN_PATTERN.match(text, position)
        if token is None or abs(int(token["exponent"] or 1)) > _MAX_UNIT_EXPONENT:
            raise ValueError("not a unit")
        position = token.end()
        if token["name"]:
            power = f"**{int(token['exponent'])}" if token["exponent"] else ""
            parts.append(f"{_OTHER_NAMES.get(token['name'], token['name'])}{power}")
        elif token["operator"]:
            parts.append("*" if token["operator"] in "·⋅" else token["operator"])
        else:
            parts.append(" ")
    return "".join(parts)


def _as_float_or_array(name: str, value: Any) -> float | FloatArray:
    array = as_float_array(
        name,
        value,
        what="a number of units",
        why="It is a physical size.",
        fix="Pass real numbers.",
    )
    return float(array) if array.ndim == 0 else array


def _no_quantity_error(name: str, quantity: object, unit: str) -> InputError:
    if not unit:
        return _unit_of_number_error(name, quantity)
    return InputError(
        name,
        must=f"be a quantity with a unit of the dimension of {unit}",
        got=shortened_repr(quantity),
        why="A number alone does not say what it counts.",
        fix=f'Write for example "1.5 {unit}", or pass a pint quantity.',
    )


def _unit_of_number_error(name: str, quantity: object) -> InputError:
    return InputError(
        name,
        must="be a number without a unit",
        got=shortened_repr(quantity),
        why="It is a ratio of two quantities of one dimension.",
        fix="Pass the number alone.",
    )


def _wrong_unit_error(name: str, quantity: Quantity, unit: str) -> InputError:
    if not unit:
        return _unit_of_number_error(name, quantity)
    return InputError(
        name,
        must=f"have a unit of the dimension of {unit}",
        got=shortened_repr(quantity),
        why="Any other unit is unknown or measures something else.",
        fix=f'Write for example "1.5 {unit}".',
    )


@cache
def _unit_registry() -> Any:
    """The registry of units, made on first use (it takes a while)."""
    registry = import_module("pint").UnitRegistry(cache_folder=None)
    registry.define(_GAUSS_DEFINITION)
    return registry
