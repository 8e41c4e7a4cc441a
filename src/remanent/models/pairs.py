"""Fields that hold one number, or one for each of the two in-plane directions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from remanent._errors import InputError, shortened_repr


def is_several_numbers(value: object) -> bool:
    """Whether a field was given as several numbers; text is refused as a number elsewhere."""
    is_scalar = isinstance(value, str) or getattr(value, "ndim", 1) == 0
    return isinstance(value, Sequence | np.ndarray) and not is_scalar


def split_by_direction(name: str, value: Any) -> dict[str, Any]:
    """The two numbers of a pair under their own names; a single number stands for both.

    Examples
    --------
    >>> split_by_direction("prestress", (0.0, 0.5))
    {'prestress_1': 0.0, 'prestress_2': 0.5}
    """
    pair = (
        tuple(value)
        if is_several_numbers(value) and getattr(value, "ndim", 1) == 1
        else (value, value)
    )
    if len(pair) != 2:
        raise InputError(
            name,
            must="be one number or a pair of them",
            got=shortened_repr(value),
            why="There are two in-plane directions.",
            fix=f"Pass {name}=(1.0, 0.5).",
        )
    return {f"{name}_{i}": number for i, number in enumerate(pair, start=1)}
