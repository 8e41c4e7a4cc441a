"""One value of a call."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Value:
    """A value that may be used up, and what to call it."""

    word: str
    make: Callable[[], Any]
