"""What the verbs that take measures share: arguments, many measures at once, labels."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
import xarray as xr

from remanent._checks import finite_rule, require_field_names, require_real
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results import provenance
from remanent.results.build import Labelled
from remanent.results.named_quantities import UNKNOWN_QUANTITY
from remanent.studies.ensemble.layout import numeric_fields
from remanent.studies.inference.measure import SAMPLE_DIMENSION, Measure, OfArgument

_Model = TypeVar("_Model", System, Drive)


def as_parameter_values(
    parameters: str | Sequence[str] | Mapping[str, float], nominal: Mapping[str, float]
) -> dict[str, float]:
    """Parameters by name, with the values given, or else with their nominal ones.

    Names that `nominal` does not have are refused.
    """
    names = require_field_names(
        "parameters", parameters, nominal, "the system or the drive, or a physical size"
    )
    if not isinstance(parameters, Mapping):
        return {name: float(nominal[name]) for name in names}
    rule = finite_rule("It is the value from which the search starts.")
    return {name: require_real(f"parameters[{name!r}]", parameters[name], rule) for name in names}


def as_measure(
    measure: Measure | Callable[..., Any],
    arguments: tuple[Any, ...],
    of: OfArgument | None,
    **options: Any,
) -> Measure:
    """A measure as it is, or made of a verb and its arguments."""
    if not isinstance(measure, Measure):
        return Measure(measure, *arguments, of=of, **options)
    if arguments or of is not None or options:
        raise InputError(
            "measure",
            must="come alone",
            got=repr(measure),
            why="It holds its arguments already.",
            fix="Pass them to rm.Measure.",
        )
    return measure


def with_parameters(model: _Model, values: Mapping[str, float]) -> _Model:
    """A system or a drive with those of the values that are its numeric fields."""
    if isinstance(model, Drive):
        own = {name: value for name, value in values.items() if name in model.parameter_values()}
        return model.replace(**own)
    known = numeric_fields(model)
    for name, value in values.items():
        if name in known:
            model = model.with_parameter(name, value)
    return model


def evaluate_measures(
    measures: Sequence[Measure], names: Sequence[str], candidates: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Values and errors of several measures.

    Parameters
    ----------
    names : sequence of str
        Of the parameters.
    candidates : array (candidate, parameter)

    Returns
    -------
    values, errors : array (candidate, number)
        The numbers of all measures, one measure after the other.
    """
    columns = dict(zip(names, candidates.T, strict=True))
    pairs = [measure.at(columns) for measure in measures]
    flat = [[np.reshape(part.values, (len(candidates), -1)) for part in pair] for pair in pairs]
    values, errors = (np.concatenate(parts, axis=1) for parts in zip(*flat, strict=True))
    return values, errors


def values_of_measures(
    measures: Sequence[Measure], names: Sequence[str], candidates: FloatArray
) -> FloatArray:
    """Values alone of several measures, as in :func:`evaluate_measures`."""
    columns = dict(zip(names, candidates.T, strict=True))
    values = [measure.values_at(columns).values for measure in measures]
    return np.concatenate([np.reshape(v, (len(candidates), -1)) for v in values], axis=1)


@dataclass(frozen=True)
class MeasureLayout:
    """The dimensions that a measure has beside that of its samples.

    Attributes
    ----------
    dims : tuple of str
    shape : tuple of int
    coords : mapping of str to Labelled
        Of those dimensions that have coordinates.
    """

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    coords: Mapping[str, Labelled]

    @classmethod
    def from_values(cls, values: xr.DataArray) -> MeasureLayout:
        """The layout of a measure along ``sample``, which is its first dimension."""
        dims = tuple(str(d) for d in values.dims if d != SAMPLE_DIMENSION)
        coords: dict[str, Labelled] = {
            d: ((d,), values[d].values) for d in dims if d in values.coords
        }
        return cls(dims, values.shape[1:], coords)

    def label_numbers(self, numbers: FloatArray, *first: str) -> Labelled:
        """Numbers (..., number), in which the measure is flat, with names of all dimensions."""
        leading = numbers.shape[: len(first)]
        return (*first, *self.dims), np.reshape(numbers, (*leading, *self.shape))


def measure_provenance(
    measures: Sequence[Measure], /, values: Mapping[str, float] | None = None, **settings: Any
) -> dict[str, Any]:
    """What says how a result about measures was made, with their parameters at `values`.

    The attribute ``measured`` has the name of the variable of each, by which its numbers are
    turned to other units, and ``?`` where a function makes the measure.
    """
    first = measures[0]
    names = [measure.variable_name or UNKNOWN_QUANTITY for measure in measures]
    found = values or {}
    system = with_parameters(first.system, found)
    drive = None if first.drive is None else with_parameters(first.drive, found)
    attributes = provenance.attributes(
        system, drive, None, measure="; ".join(map(repr, measures)), **settings
    )
    return attributes | {"measured": " ".join(names)}
