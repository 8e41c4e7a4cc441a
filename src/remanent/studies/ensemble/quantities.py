"""Arguments with units, converted by the sizes of the actuator."""

from __future__ import annotations

from typing import Any

from remanent._arrays import is_quantity, is_time_or_date
from remanent.models.scaling import Scales
from remanent.results.quantities import dimensionless_numbers
from remanent.results.schema import QuantityKind, describe, is_described


def without_unit(argument: str, value: object, name: str, system: object) -> Any:
    """Dimensionless numbers where `value` has units; anything else as it is.

    Parameters
    ----------
    argument : str
        Name of the argument.
    value : object
        What was passed for it.
    name : str
        The variable of results, or numeric field, whose values they are.
    system : System
        Its scales convert.

    Raises
    ------
    InputError
        A unit of another dimension, or no scales.
    """
    if not (is_quantity(value) or is_time_or_date(value)):
        return value
    kind = describe(name).kind if is_described(name) else QuantityKind.NONE
    scales = getattr(system, "scales", None)
    known = scales if isinstance(scales, Scales) else None
    numbers = dimensionless_numbers(argument, value, kind, known)
    return numbers if numbers.ndim else float(numbers)
