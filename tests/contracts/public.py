"""Public parts of one kind, each by its example: a new part joins its contract by itself."""

from __future__ import annotations

from typing import TypeVar

import remanent as rm
from remanent.models.parts import Part

Kind = TypeVar("Kind", bound=Part)


def examples(kind: type[Kind]) -> dict[str, Kind]:
    """An example of every public class of this kind, by the name of the class."""
    values = {name: getattr(rm, name) for name in rm.__all__}
    return {
        name: value.example()
        for name, value in values.items()
        if isinstance(value, type) and issubclass(value, kind)
    }
