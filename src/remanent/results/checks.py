"""Checks of arguments that are results."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import xarray as xr

from remanent._checks import shortened_repr
from remanent._errors import InputError


def require_dataset(name: str, value: object) -> xr.Dataset:
    """`value` if it is a Dataset."""
    if not isinstance(value, xr.Dataset):
        raise InputError(
            name,
            must="be an xarray.Dataset",
            got=shortened_repr(value),
            why="Its variables are read by name.",
            fix="Pass the result of a verb.",
        )
    return value


def require_unstacked_dataset(name: str, value: object) -> xr.Dataset:
    """`value` if it is a Dataset whose dimensions are single, so that each can be changed."""
    dataset = require_dataset(name, value)
    levels = [key for key, index in dataset.indexes.items() if isinstance(index, pd.MultiIndex)]
    stacked = sorted({str(dim) for key in levels for dim in dataset[key].dims})
    if stacked:
        raise InputError(
            name,
            must="have dimensions that are not stacked",
            got=f"one that is stacked along {', '.join(stacked)}",
            why="Labels of several levels cannot be taken one by one.",
            fix="Take it apart first: dataset.unstack(), or dataset.reset_index(...) for labels "
            "side by side.",
        )
    return dataset


def is_file(path: Path) -> bool:
    """Whether there is a file; not where its name is too long, or its folder closed."""
    try:
        return path.is_file()
    except OSError:
        return False
