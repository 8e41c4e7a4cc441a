"""Results of every verb, and what people make of them, as values of calls."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, partial
from typing import Any

import xarray as xr

import remanent as rm
from tests.contracts.sound_calls import SOUND
from tests.faults.own_systems import own_sound_calls
from tests.faults.value import Value
from tests.unit.plots import synthetic


def results() -> list[Value]:
    """Results of every verb, and what people make of them."""
    made = [Value(f"result of {verb}", partial(result_of, verb)) for verb in SOUND]
    made += [
        Value(f"result of {verb}, an own system's", partial(own_result_of, verb))
        for verb in own_sound_calls()
    ]
    drawn: dict[str, Callable[[], Any]] = {
        "basins": synthetic.basins_of_two, "potential": synthetic.potential,
    }  # fmt: skip
    made += [Value(f"result of {name}, made up", make) for name, make in drawn.items()]
    changed = [
        Value(f"{value.word}, {how}", partial(altered, how, value))
        for value in made
        for how in ALTER
    ]
    # Half of them as they were.
    return [*changed, *made * len(ALTER)]


def first_entry(ds: xr.Dataset) -> xr.Dataset:
    """Of each dimension, dropped."""
    return ds.isel(dict.fromkeys(ds.dims, 0)) if 0 not in ds.sizes.values() else ds


#: What people do to results.
ALTER: dict[str, Callable[[xr.Dataset], Any]] = {
    "first entry": first_entry,
    "first entries": lambda ds: ds.isel({dim: slice(1) for dim in ds.dims}),
    "no entry": lambda ds: ds.isel({dim: slice(0) for dim in ds.dims}),
    "all NaN": lambda ds: ds.where(False),
    "averaged": lambda ds: ds.mean(numeric_only=True),
    "without attributes": lambda ds: ds.drop_attrs(),
    "without coordinates": lambda ds: ds.reset_coords(drop=True).drop_vars(list(ds.coords)),
    "without a status": lambda ds: ds.drop_vars("status", errors="ignore"),
    "of objects": lambda ds: ds.astype(object),
    "of texts": lambda ds: ds.astype(str),
    "complex": lambda ds: ds.map(lambda x: x * 1j if x.dtype.kind == "f" else x),
    "infinite": lambda ds: ds.map(lambda x: x * float("inf") if x.dtype.kind == "f" else x),
    "stacked": lambda ds: ds.stack(every=[...]) if ds.sizes else ds,
    "reversed": lambda ds: ds.isel({dim: slice(None, None, -1) for dim in ds.dims}),
    "twice": lambda ds: xr.concat([ds, ds], "case"),
    "renamed": lambda ds: ds.rename({name: f"{name}'" for name in ds.variables}),
    "of other attributes": lambda ds: ds.assign_attrs(
        system='{"kind": "Actuator", "c": "NaN"}', drive="[", over=1.5, tolerance="x", scales="{}"
    ),
    "as an array": lambda ds: ds.to_dataarray(),
    "as a table": lambda ds: ds.to_dataframe() if ds.sizes else ds.to_pandas(),
}  # fmt: skip


def altered(how: str, value: Value) -> Any:
    """A result after something was done to it; itself where that cannot be done."""
    result = value.make()
    if not isinstance(result, xr.Dataset):
        return result
    try:
        return ALTER[how](result)
    except (TypeError, ValueError):  # of xarray
        return result


@cache
def result_of(verb: str) -> Any:
    """The result of a sound call."""
    return getattr(rm, verb)(**SOUND[verb]())


@cache
def own_result_of(verb: str) -> Any:
    """The result of a sound call with a system of one's own."""
    return getattr(rm, verb)(**own_sound_calls()[verb]())
