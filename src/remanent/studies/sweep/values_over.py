"""The table [over] of a study file: lists, ranges, values that go together, quasi-random points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from pydantic import Field, model_validator

from remanent._arrays import is_increasing
from remanent._typing import FloatArray
from remanent.studies.sweep.faults import Fault, FaultsError, read_each, shown
from remanent.studies.sweep.numbers_with_units import Sizes, number, numbers
from remanent.studies.sweep.tables import Table, not_a_table_fault, read_table

#: Most values along one dimension; a store keeps each in its study.
MAX_VALUES: Final = 2**20
#: Most coordinates of quasi-random points.
_MAX_SOBOL_NUMBERS: Final = 2**23
#: Key of the table of quasi-random points, and the dimension along which they lie.
SOBOL: Final = "sobol"
_SOBOL_DIMENSION: Final = "draw"
#: Scrambling of quasi-random points where the file gives no other.
_SOBOL_SEED: Final = 0
#: Keys of a range that a list may be written as, wherever there is one.
_RANGE_KEYS: Final = frozenset({"from", "to", "count"})

_Count = Annotated[int, Field(ge=2, le=MAX_VALUES)]


class Values(Table):
    """Values of one field: a list of them, or a range."""

    values: Any = None
    begin: Any = Field(None, alias="from")
    end: Any = Field(None, alias="to")
    count: _Count = Field(
        2, description="It is the number of values, the first and the last among them.",
        examples=["count = 64"],
    )  # fmt: skip
    spacing: Literal["linear", "log"] = Field(
        "linear", description="Values are as far from each other, or in one ratio.",
        examples=['spacing = "log"'],
    )  # fmt: skip
    dim: str | None = Field(
        None, min_length=1, max_length=40,
        description="Fields of one `dim` take their values together, one with one.",
        examples=['dim = "case"'],
    )  # fmt: skip

    @model_validator(mode="after")
    def _is_a_list_or_a_range(self) -> Values:
        given = self.model_fields_set
        in_range = [name for name in ("begin", "end", "count", "spacing") if name in given]
        missing = {"begin", "end", "count"} - given
        if ("values" in given) == bool(in_range) or (in_range and missing):
            raise FaultsError([
                Fault((), "be a list, or a table with either values, or from, to and count",
                      f"a table with {', '.join(sorted(map(_key, given))) or 'nothing in it'}",
                      "One of them says what the values are.",
                      "Write for example { from = 0.2, to = 1.2, count = 64 }.")
            ])  # fmt: skip
        return self


class SobolPoints(Table):
    """Quasi-random points in a box, along one dimension."""

    count: _Count = Field(
        description="It is the number of points.", examples=["count = 4096"]
    )  # fmt: skip
    ranges: dict[str, Any] = Field(
        description="It holds the smallest and the largest value of each field.",
        examples=["ranges = { b = [0.2, 1.2], omega = [0.8, 2.0] }"],
    )
    seed: Annotated[int, Field(ge=0, le=2**32 - 1)] = Field(
        _SOBOL_SEED, description="It chooses the scrambling.", examples=["seed = 1"]
    )
    dim: str = Field(
        _SOBOL_DIMENSION, min_length=1, max_length=40,
        description="It is the dimension along which the points lie.", examples=['dim = "case"'],
    )  # fmt: skip


def over_from_table(content: object, sizes: Sizes) -> dict[str, Any]:
    """What verbs take as ``over``.

    Parameters
    ----------
    content : object
        What [over] holds.
    sizes : Sizes

    Returns
    -------
    dict of str to array or DataArray

    Raises
    ------
    FaultsError
    """
    if not isinstance(content, dict):
        raise FaultsError([not_a_table_fault(content)])
    if not content:
        raise FaultsError([no_fields_fault()])

    def read(name: str, value: object) -> dict[str, Any]:
        if name == SOBOL and isinstance(value, dict) and not value.keys() >= _RANGE_KEYS:
            return _sobol_points(value, sizes)
        return {name: _values(name, value, sizes)}

    found = read_each(content, read)
    own = {name for name in found if name != SOBOL}
    twice = [name for name in found.get(SOBOL, {}) if name in own]
    if twice:
        raise FaultsError(_varied_twice_fault(name) for name in twice)
    return {name: values for part in found.values() for name, values in part.items()}


def _varied_twice_fault(name: str) -> Fault:
    return Fault(
        (SOBOL, "ranges", name), "be varied once", "a range",
        f"[over] {name} has values of its own.", "Remove one of them.",
    )  # fmt: skip


def no_fields_fault() -> Fault:
    """What is said where nothing is varied."""
    return Fault(
        (), "name at least one field", "nothing", "A study is a verb on a grid.",
        "Write for example temperature = [250, 350, 400] below [over].",
    )  # fmt: skip


def option_from_value(name: str, value: object, sizes: Sizes) -> object:
    """An option of a verb, in which a list of numbers may be written as a range."""
    if not isinstance(value, dict) or not value.keys() >= _RANGE_KEYS:
        return value
    table = read_table(Values, value, "a range")
    if table.dim is not None:
        raise FaultsError([
            Fault(("dim",), "be left out of an option", shown(table.dim),
                  "An option is no dimension of the grid.", "Move the field to [over].")
        ])  # fmt: skip
    return _range(name, table, sizes).tolist()


def _values(name: str, value: object, sizes: Sizes) -> Any:
    """Values of one field."""
    if not isinstance(value, dict):
        found = np.array(numbers(value, name, sizes))
        _require_increasing(found)
        return found
    table = read_table(Values, value, f"[over] {name}")
    if "values" not in table.model_fields_set:
        found = _range(name, table, sizes)
    else:
        try:
            found = np.array(numbers(table.values, name, sizes))
        except FaultsError as error:
            raise FaultsError(fault.below("values") for fault in error.faults) from None
    if table.dim is not None:
        return xr.DataArray(found, dims=table.dim)
    _require_increasing(found)
    return found


def _range(name: str, table: Values, sizes: Sizes) -> FloatArray:
    """Values from the first to the last, which both are among them."""
    ends = read_each(
        {"from": table.begin, "to": table.end}, lambda _, end: number(end, name, sizes)
    )
    begin, end = ends["from"], ends["to"]
    if begin >= end:
        raise FaultsError([
            Fault(("to",), "be greater than `from`", shown(table.end),
                  "Values of a dimension are sorted upwards.", "Exchange `from` and `to`.")
        ])  # fmt: skip
    if table.spacing == "log" and begin <= 0.0:
        raise FaultsError([
            Fault(("from",), 'be greater than 0 where spacing = "log"', shown(table.begin),
                  "Neighbours are in one ratio.", 'Write spacing = "linear", or begin above 0.')
        ])  # fmt: skip
    space = np.geomspace if table.spacing == "log" else np.linspace
    return np.asarray(space(begin, end, table.count), dtype=np.float64)


def _require_increasing(values: NDArray[np.float64]) -> None:
    if is_increasing(values):
        return
    raise FaultsError([
        Fault((), "be sorted upwards without repeated values", shown(values.tolist()),
              "They label a dimension of the result.",
              'Sort them; for values that go with those of other fields write { values = [...], '
              'dim = "case" }.')
    ])  # fmt: skip


def _sobol_points(content: Mapping[str, Any], sizes: Sizes) -> dict[str, Any]:
    """Points of a scrambled Sobol' sequence in a box, all along one dimension."""
    from scipy.stats import qmc  # a third of the start of a study that has none

    table = read_table(SobolPoints, content, "[over.sobol]")
    if not table.ranges:
        raise FaultsError([
            Fault(("ranges",), "name at least one field", "nothing", "The points lie in a box.",
                  "Write for example ranges = { b = [0.2, 1.2] }.")
        ])  # fmt: skip
    read = {"count": lambda: _require_sobol_count(table), "ranges": lambda: _box(table, sizes)}
    box = read_each(read, lambda _, one: one())["ranges"]
    points = qmc.Sobol(len(box), scramble=True, rng=table.seed).random(table.count)
    return {
        name: xr.DataArray(low + (high - low) * points[:, k], dims=table.dim)
        for k, (name, (low, high)) in enumerate(box.items())
    }


def _require_sobol_count(table: SobolPoints) -> None:
    most = _MAX_SOBOL_NUMBERS // len(table.ranges)
    if table.count & (table.count - 1):
        below = 2 ** (table.count.bit_length() - 1)
        raise FaultsError([
            Fault((), "be a power of 2", str(table.count),
                  "Only then are the points evenly spread.", f"Write {below} or {2 * below}.")
        ])  # fmt: skip
    if table.count > most:
        raise FaultsError([
            Fault((), f"be at most {most} for so many fields", str(table.count),
                  "The study holds every coordinate of every point.", "Take fewer points.")
        ])  # fmt: skip


def _box(table: SobolPoints, sizes: Sizes) -> dict[str, tuple[float, float]]:
    return read_each(table.ranges, lambda name, ends: _ends(name, ends, sizes))


def _ends(name: str, ends: object, sizes: Sizes) -> tuple[float, float]:
    """The smallest and the largest value of a field."""
    found = numbers(ends, name, sizes)
    if len(found) != 2 or found[0] >= found[1]:
        raise FaultsError([
            Fault((), "be a list of the smallest and the largest value", shown(ends),
                  "Points lie between them.", "Write for example [0.2, 1.2].")
        ])  # fmt: skip
    return found[0], found[1]


def _key(field: str) -> str:
    return {"begin": "from", "end": "to"}.get(field, field)
