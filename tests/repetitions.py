"""Parameters of tests of which some are fast, and the others are left to `make test-all`."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

import pytest


def fast_and_slow(
    values: Iterable[str] | Mapping[str, Any],
    fast: Collection[str] | None = None,
    *,
    slow: Collection[str] = (),
) -> list[Any]:
    """Parameters by name, in order; those that are not `fast`, or are `slow`, are marked as slow.

    A mapping has the values by their names; names alone are the values themselves.
    """
    named = values if isinstance(values, Mapping) else {name: name for name in values}
    unknown = {*(fast or ()), *slow} - {*named}
    assert not unknown, f"no parameters: {sorted(unknown)}"
    fast = {*named} - {*slow} if fast is None else fast
    return [
        pytest.param(value, id=name, marks=() if name in fast else pytest.mark.slow)
        for name, value in named.items()
    ]
