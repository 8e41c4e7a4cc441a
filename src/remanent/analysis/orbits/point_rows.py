"""Dataclasses whose fields are arrays with one row for each point."""

from __future__ import annotations

from dataclasses import fields
from typing import Any, TypeVar

from remanent._typing import BoolArray, IntArray

Rows = TypeVar("Rows")


def subset_of_rows(value: Rows, indices: IntArray | BoolArray) -> Rows:
    """Some of the points, in the order of the indices."""
    one: Any = value
    return type(value)(**{f.name: getattr(value, f.name)[indices] for f in fields(one)})


def replace_rows(value: Rows, indices: IntArray, by: Rows) -> Rows:
    """The same with other points at some places."""
    one: Any = value
    columns = {}
    for column in fields(one):
        rows = getattr(value, column.name).copy()
        rows[indices] = getattr(by, column.name)
        columns[column.name] = rows
    return type(value)(**columns)
