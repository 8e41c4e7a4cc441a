"""Arguments with units, converted by the sizes of the actuator."""

from __future__ import annotations

from typing import Any

import numpy as np

from remanent._arrays import is_quantity, is_time_or_date, without_wrapping
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
        What was passed for it: a pint quantity, a length of time, text such as ``"50 Hz"``, or
        several of them.
    name : str
        The variable of results, or numeric field, whose values they are.
    system : System
        Its scales convert.

    Raises
    ------
    InputError
        A unit of another dimension, or no scales.
    """
    texts = _texts(value)
    if texts is not None:
        value = texts
    elif not (is_quantity(value) or is_time_or_date(value)):
        return value
    kind = describe(name).kind if is_described(name) else QuantityKind.NONE
    scales = getattr(system, "scales", None)
    known = scales if isinstance(scales, Scales) else None
    numbers = dimensionless_numbers(argument, value, kind, known)
    return numbers if numbers.ndim else float(numbers)


def _texts(value: object) -> str | list[Any] | None:
    """Text that begins with a number, or a list that begins with such text; nothing else."""
    content = without_wrapping(value)
    if isinstance(content, np.ndarray) and content.dtype.kind in "UO" and content.ndim == 1:
        content = content.tolist()
    first = content[0] if isinstance(content, list | tuple) and content else content
    if not (isinstance(first, str) and first.lstrip(" +-.")[:1].isdigit()):
        return None
    return first if first is content else list(content)
