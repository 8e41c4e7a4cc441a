"""Quantities with units, read at the edges of the package; inside there are none."""

from __future__ import annotations

import re
from functools import cache
from importlib import import_module
from typing import Any, Final, TypeAlias

import numpy as np

from remanent._errors import InputError
from remanent._typing import FloatArray

#: Text such as ``"100 kPa"``, or a pint quantity.  (Pint is imported when needed.)
Quantity: TypeAlias = Any

_QUANTITY_PATTERN: Final = re.compile(
    r"\s*((?>[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?))\s*(\S.*?)\s*"
)
_ANGLE_UNITS: Final = frozenset({"radian", "degree", "turn", "revolution", "cycle", "milliradian"})


def magnitude_in_unit(name: str, quantity: Quantity, unit: str) -> float | FloatArray:
    """The number of `unit` in `quantity`: a float, or an array for an array.

    Parameters
    ----------
    name
        What the message calls it.
    quantity
        Text, ``"100 kPa"``, or a pint quantity.
    unit
        A unit that pint knows.

    Raises
    ------
    InputError
        If it has no unit, an unknown unit, or one of another dimension.
    """
    value = _parse_quantity(name, quantity, unit)
    try:
        converted = value.to(unit).magnitude
    except Exception as error:  # pint raises from several unrelated families
        raise _wrong_unit_error(name, quantity, unit) from error
    return _as_float_or_array(converted)


def with_unit(name: str, values: FloatArray, unit: str) -> Quantity:
    """Numbers with a unit, ``"ms"``."""
    try:
        return _unit_registry().Quantity(values, unit)
    except Exception as error:  # pint raises from several unrelated families
        raise _wrong_unit_error(name, unit, "s, Hz, T, K") from error


def positive_magnitude(name: str, quantity: Quantity, unit: str) -> float:
    """The number of `unit` in one quantity that must be finite and greater than 0."""
    number = single_magnitude(name, quantity, unit)
    if not 0.0 < number < float("inf"):
        raise InputError(
            name,
            must="be greater than 0 and finite",
            got=quantity,
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
            got=repr(quantity),
            why="A model holds a single value of each field.",
            fix="Pass one quantity; for many values use over={...}.",
        )
    return number


def radians_per_second(name: str, quantity: Quantity) -> float | FloatArray:
    """Radians per second of a frequency, cycles (``"50 Hz"``) or angles (``"rad/s"``)."""
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
        got=quantity,
        why="Plain 1/s does not say whether it counts cycles or radians.",
        fix='Write for example "50 Hz" or "314 rad/s".',
    )


def _parse_quantity(name: str, quantity: Quantity, unit: str) -> Any:
    """A pint quantity."""
    if hasattr(quantity, "to") and hasattr(quantity, "magnitude"):
        return quantity
    match = _QUANTITY_PATTERN.fullmatch(quantity) if isinstance(quantity, str) else None
    if match is None:
        raise InputError(
            name,
            must=f"be a quantity with a unit of the dimension of {unit}",
            got=repr(quantity),
            why="A number alone does not say what it counts.",
            fix=f'Write for example "1.5 {unit}", or pass a pint quantity.',
        )
    try:
        return _unit_registry().Quantity(float(match[1]), match[2])
    except Exception as error:  # pint raises from several unrelated families
        raise _wrong_unit_error(name, quantity, unit) from error


def _as_float_or_array(value: Any) -> float | FloatArray:
    array = np.asarray(value, dtype=np.float64)
    return float(array) if array.ndim == 0 else array


def _wrong_unit_error(name: str, quantity: Quantity, unit: str) -> InputError:
    return InputError(
        name,
        must=f"have a unit of the dimension of {unit}",
        got=repr(quantity),
        why="Any other unit is unknown or measures something else.",
        fix=f'Write for example "1.5 {unit}".',
    )


@cache
def _unit_registry() -> Any:
    """The registry of units, made on first use (it takes a while)."""
    return import_module("pint").UnitRegistry(cache_folder=None)
