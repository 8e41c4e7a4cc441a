"""Checks of arguments that are results."""

from __future__ import annotations

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
