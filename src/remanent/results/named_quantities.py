"""Which named quantity every number of a result is, so that results turn to other units.

Most variables are the quantity of their own name.  Those of fits, sensitivities, designs and
orbits hold numbers of several quantities: an estimate is one of its parameter, a derivative one
of the measure over one of the field.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import xarray as xr

from remanent._arrays import as_float_array
from remanent._errors import InputError, shortened_repr
from remanent._typing import FloatArray
from remanent.results.schema import describe

__all__ = [
    "UNKNOWN_QUANTITY",
    "QuantityPower",
    "attribute_numbers",
    "attribute_quantity",
    "quantities_of",
]

#: In the attribute ``measured``: a function makes the measure, so that its unit is not known.
UNKNOWN_QUANTITY: Final = "?"
#: Variables that hold numbers of the quantities that label this dimension.
_LABELLED_BY_DIMENSION: Final[Mapping[str, str]] = MappingProxyType(
    {
        **dict.fromkeys(("estimate", "guess", "interval", "profile_interval"), "parameter"),
        **dict.fromkeys(("observed", "predicted"), "quantity"),
        **dict.fromkeys(("initial", "attractor_state"), "state"),
        "solution": "field",
    }
)
#: Variables that hold numbers of the measure.
_OF_THE_MEASURE: Final = frozenset({"value", "average", "deviation", "target", "reached"})
#: Variables with the scatter of data that have no deviations of their own, and its power.
_SCATTER_POWERS: Final[Mapping[str, int]] = MappingProxyType({"noise": 1, "chi_square": 2})
#: Settings that are quantities under another name.
_SETTINGS: Final[Mapping[str, str]] = MappingProxyType(
    {"discard": "duration", "every": "duration", "resonance_width": "omega"}
)
#: Settings that are no counts, even where a whole number was given.
_NEVER_COUNTS: Final = frozenset({"duration", "parameter_range", "parameter_ranges"})
#: Settings that are pairs of values of fields, with the attribute that names the fields.
_RANGES: Final[Mapping[str, str]] = MappingProxyType(
    {"parameter_range": "parameter", "parameter_ranges": "parameters"}
)


@dataclass(frozen=True)
class QuantityPower:
    """A factor of the unit of an array: a power of one quantity, or of one for each label.

    Attributes
    ----------
    names : array of str
        Names of quantities; of no dimension where all numbers have the same.
    dimension : str or None
        The dimension of the array along which they lie.
    power : int
    """

    names: np.ndarray[Any, Any]
    dimension: str | None = None
    power: int = 1

    def raised(self, power: int) -> QuantityPower:
        """The same to another power."""
        return QuantityPower(self.names, self.dimension, power)


def quantities_of(dataset: xr.Dataset, name: str) -> list[QuantityPower]:
    """The quantities that make up the unit of a variable; none for a plain number.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result.
    name : str
        One of its variables.

    Raises
    ------
    InputError
        It is a number of a measure whose quantity is not known.
    """
    base = name.removesuffix("_error")
    if base in _LABELLED_BY_DIMENSION and _LABELLED_BY_DIMENSION[base] in dataset.variables:
        return [_labels(dataset, _LABELLED_BY_DIMENSION[base])]
    if base == "covariance":
        return [_labels(dataset, "parameter"), _labels(dataset, "other_parameter")]
    if base in _SCATTER_POWERS:
        return _scatter(dataset, _SCATTER_POWERS[base])
    if base in _OF_THE_MEASURE:
        return _measured(dataset, name)
    if base == "derivative" and "field" in dataset.variables:
        return [*_measured(dataset, name), _labels(dataset, "field").raised(-1)]
    return [QuantityPower(np.asarray(name))]


def attribute_quantity(dataset: xr.Dataset, name: str) -> list[str]:
    """Names of the quantities of the numbers in an attribute; empty for plain numbers.

    Counts, which are integers, are plain; a length of time is none.  One name stands for all
    numbers, or each for two.

    Raises
    ------
    InputError
        A number with a decimal point that no table describes.
    """
    value = dataset.attrs[name]
    if np.asarray(value).dtype.kind not in ("fi" if name in _NEVER_COUNTS else "f"):
        return []
    if name in _RANGES:
        return str(dataset.attrs.get(_RANGES[name], "omega")).split()
    if name == "value" and "variable" in dataset.attrs:
        return [str(dataset.attrs["variable"])]
    if name == "tolerance" or name not in str(dataset.attrs.get("settings", "")).split():
        return []
    try:
        return [describe(_SETTINGS.get(name, name)).name]
    except InputError as error:
        raise InputError(
            "dataset",
            must="have settings whose unit is known",
            got=f"{name} = {value}",
            why="It is not known how this one turns to other units.",
            fix=f"Remove it: del dataset.attrs[{name!r}].",
        ) from error


def attribute_numbers(dataset: xr.Dataset, name: str, count: int) -> FloatArray:
    """The numbers of an attribute that holds some for each of `count` quantities.

    Returns
    -------
    array
        Of no dimension where the attribute is a single number.

    Raises
    ------
    InputError
        If these are no numbers, or do not go with the quantities.
    """
    value = dataset.attrs[name]
    why = "It is a setting of the run, which changes with the units of the result."
    fix = f"Remove it: del dataset.attrs[{name!r}]."
    numbers = as_float_array("dataset", value, what=f"its attribute {name}", why=why, fix=fix)
    if numbers.size % count:
        raise InputError(
            "dataset",
            must=f"have as many numbers in its attribute {name} for each of {count} quantities",
            got=shortened_repr(value),
            why=why,
            fix=fix,
        )
    return numbers


def _labels(dataset: xr.Dataset, coordinate: str) -> QuantityPower:
    """The names that a coordinate holds, along its dimension."""
    labels = dataset[coordinate]
    names = np.asarray(labels.values).astype(str)
    return QuantityPower(names, str(labels.dims[0]) if labels.ndim else None)


def _scatter(dataset: xr.Dataset, power: int) -> list[QuantityPower]:
    """Of data with deviations, a plain number; else of the unit of the data, if that is one."""
    if "quantity" not in dataset.variables or dataset.attrs.get("deviations") == "given":
        return []
    names = np.unique(np.asarray(dataset["quantity"].values).astype(str))
    return [QuantityPower(names[0], None, power)] if len(names) == 1 else []


def _measured(dataset: xr.Dataset, name: str) -> list[QuantityPower]:
    """The quantity of a measure, or of several along ``measure``."""
    names = str(dataset.attrs.get("measured", "")).split()
    if not names:
        return [QuantityPower(np.asarray(name))]
    if UNKNOWN_QUANTITY in names:
        raise InputError(
            "dataset",
            must="be of measures that are variables of a verb's result",
            got=f"{name} of {dataset.attrs.get('measure', 'a function')}",
            why="It is not known what quantity a function gives, and so not how it changes.",
            fix="Pass of='...', the name of a variable, or convert the numbers by hand.",
        )
    if "measure" in dataset[name].dims:
        return [QuantityPower(np.array(names), "measure")]
    return [QuantityPower(np.asarray(names[0]))]
