"""What ``over`` means: values of fields along named dimensions, matched by their labels."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
import pandas as pd
import xarray as xr

from remanent._checks import as_float_array, is_increasing, shortened_repr
from remanent._errors import InputError, warn_of_input
from remanent._status import Status
from remanent._typing import ArrayLike, BoolArray, FloatArray
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.results.schema import is_described
from remanent.studies.ensemble.invalid import FINITE_RULE, varied_rules
from remanent.studies.ensemble.quantities import without_unit

#: What ``over`` accepts.
OverArgument = Mapping[str, ArrayLike | xr.DataArray]
#: Names of dimensions that results have of their own.
RESERVED_DIMENSIONS: Final = frozenset(
    {
        "time",
        "cycle",
        "period",
        "crossing",
        "equilibrium",
        "thickness_stretch",
        "fold",
        "snap",
        "branch_point",
    }
)
#: Rows of the table of variables that no result has as a variable of its own: the number of a case,
#: and fields of drives, which are refused where the drive has them.
_FREE_DIMENSIONS: Final = frozenset({"case", "point", "start", "stop"})
#: Kinds of NumPy data that labels may have: numbers, text, truth values, dates.
_LABEL_DTYPE_KINDS: Final = frozenset("iufUbM")

#: How many of the values that break a rule a warning shows.
_MAX_SHOWN_VALUES: Final = 3


@dataclass(frozen=True)
class VariedFields:
    """Values of the fields that vary, and the dimensions that they span.

    Attributes
    ----------
    arrays : mapping of name to Labelled
        Values of each field with the names of their dimensions.
    sizes : mapping of name to int
        Length of each dimension, in the order in which they are named.
    labels : mapping of name to Labelled
        Labels of the dimensions that have some, beside those that are named after a field.
    """

    arrays: dict[str, Labelled]
    sizes: dict[str, int]
    labels: dict[str, Labelled]

    @property
    def count(self) -> int:
        """Number of combinations."""
        return math.prod(self.sizes.values())

    def outer_product(self) -> dict[str, FloatArray]:
        """Values of each field for every combination, arrays (trajectory,)."""
        return {name: self._repeated(*labelled) for name, labelled in self.arrays.items()}

    def _repeated(self, dims: tuple[str, ...], values: FloatArray) -> FloatArray:
        order = [d for d in self.sizes if d in dims]
        moved = values.transpose([dims.index(d) for d in order])
        shape = [size if d in dims else 1 for d, size in self.sizes.items()]
        return np.broadcast_to(moved.reshape(shape), tuple(self.sizes.values())).reshape(-1)


@dataclass(frozen=True)
class _FieldValues:
    """Values of one field, array with an axis for each of `dims`, and labels of some of these."""

    name: str
    dims: tuple[str, ...]
    values: FloatArray
    labels: Mapping[str, pd.Index[Any]]


def read_over(
    over: OverArgument | None,
    known: Sequence[str],
    system: System,
    reserved: frozenset[str] = RESERVED_DIMENSIONS,
) -> VariedFields:
    """Read what a caller passed as ``over``.

    Arrays that share a dimension go together: by its labels where they have some, whose order
    is that of the first, else one with one.

    Parameters
    ----------
    over : mapping of name to array_like or DataArray, optional
        Numeric fields with their values.
    known : sequence of str
        Names that it may have.
    system : System
        Whose scales convert quantities with units.
    reserved : frozenset of str
        Names of dimensions that the result has of its own.

    Raises
    ------
    InputError
        Unknown field, no numbers, an empty or unsorted grid, dimensions that the result has
        itself, lengths or labels that do not match.
    """
    require_over(over)
    fields = [_field_values(name, value, known, system) for name, value in (over or {}).items()]
    own = {field.name for field in fields if field.dims == (field.name,)}
    for field in fields:
        _require_unreserved_dims(field, reserved, known, own)
    aligned = _align_by_labels(fields)
    labels: dict[str, Labelled] = {
        dim: ((dim,), np.asarray(index.to_numpy()))
        for field in aligned
        for dim, index in field.labels.items()
        if dim not in own
    }
    arrays = {field.name: (field.dims, field.values) for field in aligned}
    return VariedFields(arrays, _dimension_sizes(arrays), labels)


def require_over(over: object) -> None:
    """Raise unless ``over`` is left out or a mapping."""
    if over is not None and not isinstance(over, Mapping):
        raise InputError(
            "over",
            must="be a mapping of names to values",
            got=shortened_repr(over),
            why="It says which fields take many values.",
            fix="Pass for example {'temperature': [250, 350, 400]}.",
        )


def _field_values(
    name: str, value: ArrayLike | xr.DataArray, known: Sequence[str], system: System
) -> _FieldValues:
    argument = f"over[{name!r}]"
    if name not in known:
        raise InputError(
            argument,
            must="be a numeric field of the system or of the drive",
            got=shortened_repr(name),
            why="Only fields that enter the equations of motion can be varied.",
            fix=f"Name one of its fields: {', '.join(known)}.",
        )
    array = as_float_array(
        argument,
        without_unit(argument, value, name, system),
        what="values of the dimensionless field",
        why="They become a dimension of the result.",
        fix="Pass for example numpy.linspace(0.5, 2.0, 300).",
        least=1,
    )
    if isinstance(value, xr.DataArray) and value.ndim:
        return _FieldValues(name, tuple(map(str, value.dims)), array, _labels(argument, value))
    if array.ndim == 0:
        array = array[None]
    if array.ndim != 1:
        raise InputError(
            argument,
            must="have one dimension",
            got=f"an array of shape {array.shape}",
            why="Its values become a dimension of the result.",
            fix="Pass a one-dimensional array, or an xarray.DataArray that names its dimensions.",
        )
    _require_increasing_grid(name, array)
    labels = {name: pd.Index(array)} if np.isfinite(array).all() else {}
    return _FieldValues(name, (name,), array, labels)


def _labels(argument: str, value: xr.DataArray) -> dict[str, pd.Index[Any]]:
    """Labels of the dimensions that have some."""
    labels: dict[str, pd.Index[Any]] = {}
    for dim, index in value.indexes.items():
        entries = pd.Index(index)
        if entries.dtype.kind == "O" and all(isinstance(entry, str) for entry in entries):
            entries = pd.Index(entries.to_numpy().astype(np.str_))
        kind = "U" if pd.api.types.is_string_dtype(entries) else entries.dtype.kind
        if kind not in _LABEL_DTYPE_KINDS or not entries.is_unique:
            raise InputError(
                argument,
                must=f"have labels along {str(dim)!r} that are text, numbers or dates, each once",
                got=shortened_repr(index.tolist()),
                why="Values that share a dimension go together by its labels.",
                fix=f"Drop them, values.drop_vars({str(dim)!r}), or make each different.",
            )
        labels[str(dim)] = entries
    return labels


def _require_unreserved_dims(
    field: _FieldValues, reserved: frozenset[str], known: Sequence[str], own: set[str]
) -> None:
    """Refuse dimensions that are named like what stands in results, or by blanks."""
    for dim in field.dims:
        if not dim.strip():
            raise InputError(
                f"over[{field.name!r}]",
                must="have dimensions with names",
                got=shortened_repr(dim),
                why="The result has an axis of that name, in files too.",
                fix="Rename the dimension, for example to 'case'.",
            )
        taken = dim in known or (is_described(dim) and dim not in _FREE_DIMENSIONS)
        if dim in reserved or (taken and dim not in own and dim != field.name):
            raise InputError(
                f"over[{field.name!r}]",
                must="have dimensions that results do not have of their own",
                got=shortened_repr(dim),
                why="The result has one axis, or one variable, for each name.",
                fix="Rename the dimension, for example to 'case'.",
            )


def _align_by_labels(fields: Sequence[_FieldValues]) -> list[_FieldValues]:
    """The same fields, each dimension in the order of the first labels that it has."""
    first: dict[str, tuple[str, pd.Index[Any]]] = {}
    aligned = []
    for field in fields:
        values = field.values
        for dim, index in field.labels.items():
            owner, labels = first.setdefault(dim, (field.name, index))
            if len(labels) != len(index):
                continue  # the lengths differ, which is told of all dimensions alike
            places = index.get_indexer(labels)
            if (places < 0).any():
                raise InputError(
                    f"over[{field.name!r}]",
                    must=f"have the labels along {dim!r} that {owner} has, in any order",
                    got=shortened_repr(index.tolist()),
                    why="Values that share a dimension go together by its labels.",
                    fix=f"Give it the labels {shortened_repr(labels.tolist())}.",
                )
            values = np.take(values, places, axis=field.dims.index(dim))
        known = {dim: first[dim][1] for dim in field.labels}
        aligned.append(replace(field, values=values, labels=known))
    return aligned


def _require_increasing_grid(name: str, array: FloatArray) -> None:
    if is_increasing(array):
        return
    finite = array[np.isfinite(array)]
    if finite.size and not is_increasing(finite):
        raise InputError(
            f"over[{name!r}]",
            must="be sorted upwards without repeated values",
            got=np.array2string(array, threshold=6),
            why="They label a dimension of the result, on which one selects and interpolates.",
            fix="Pass numpy.unique(values), or a DataArray with a dimension of its own.",
        )


def _dimension_sizes(arrays: Mapping[str, Labelled]) -> dict[str, int]:
    """Length of each dimension, in the order in which they are named."""
    sizes: dict[str, int] = {}
    for name, (dims, values) in arrays.items():
        for dim, size in zip(dims, values.shape, strict=True):
            if sizes.setdefault(dim, size) != size:
                raise InputError(
                    f"over[{name!r}]",
                    must=f"have length {sizes[dim]} along {dim!r}",
                    got=size,
                    why="Values that share a dimension go together, one with one.",
                    fix="Give them the same length, or different dimensions.",
                )
    return sizes


def warn_of_varied_values(
    arrays: Mapping[str, Labelled],
    varied: Mapping[str, FloatArray],
    system: System,
    drive: Drive,
    invalid: BoolArray,
) -> None:
    """Warn once of varied values that break a rule, and of those that look like a mistake.

    Parameters
    ----------
    arrays : mapping of name to Labelled
        The varied fields with their values.
    varied : mapping of name to array (trajectory,)
        The same for each trajectory.
    system, drive
        Whose rules they are.
    invalid : array (trajectory,) of bool
        Where nothing is computed.
    """
    if not arrays:
        return
    system.warn_if_implausible(varied)
    if not invalid.any():
        return
    rules = varied_rules(system, drive)
    reasons = []
    for name, (_, values) in arrays.items():
        rule = rules.get(name, FINITE_RULE)
        broken = values[~rule.is_satisfied_by(values)]
        if broken.size:
            shown = ", ".join(f"{value:g}" for value in np.unique(broken)[:_MAX_SHOWN_VALUES])
            more = "" if np.unique(broken).size <= _MAX_SHOWN_VALUES else " and others"
            reasons.append(f"over[{name!r}] must {rule.must}; got {shown}{more}. {rule.why}")
    told = " ".join(reasons) or "Their values do not go together, or the start is no state."
    warn_of_input(
        f"`over`: {np.count_nonzero(invalid)} of {invalid.size} points break a rule and are not "
        f"computed (status {Status.INVALID.meaning}). {told}"
    )
