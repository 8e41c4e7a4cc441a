"""A system, a drive and ``over`` become an ensemble."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr

from remanent._checks import as_float_array, is_increasing, shortened_repr
from remanent._errors import InputError
from remanent._field import Field
from remanent._typing import ArrayLike, BoolArray, FloatArray
from remanent.codegen.field import vector_field_for
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_drive, require_system
from remanent.studies.ensemble.ensemble import (
    TRAJECTORIES_PER_BATCH,
    Ensemble,
    batch_slices,
    load_periods_for_values,
)
from remanent.studies.ensemble.initial import (
    initial_states,
    is_invalid_start,
    require_admissible_state,
)
from remanent.studies.ensemble.memory import BYTES_PER_TRAJECTORY, require_memory

#: What ``over`` accepts.
OverArgument = Mapping[str, ArrayLike | xr.DataArray]
#: Names of dimensions that results have of their own.
RESERVED_DIMENSIONS = frozenset(
    {"time", "cycle", "period", "crossing", "equilibrium", "thickness_stretch", "fold", "snap"}
)


def lay_out_ensemble(
    system: System,
    drive: Drive,
    over: OverArgument | None = None,
    initial: ArrayLike | None = None,
    *,
    reserved: frozenset[str] = RESERVED_DIMENSIONS,
    extra: Mapping[str, float] | None = None,
    system_argument: str = "system",
    batch_size: int = TRAJECTORIES_PER_BATCH,
) -> Ensemble:
    """Lay out the trajectories that a verb was asked for.

    Parameters
    ----------
    system : System
    drive : Drive
    over : mapping of name to array_like or DataArray, optional
        Numeric fields with their values.
    initial : array_like (state,), optional
        State to start from; rest by default.
    reserved : frozenset of str
        Names of dimensions that the result has of its own.
    extra : mapping of name to float, optional
        Further names that `over` may vary, with their usual values.
    system_argument : str
        What the verb calls its first argument.
    batch_size : int
        Trajectories that are checked together.

    Returns
    -------
    Ensemble

    Raises
    ------
    InputError
        Unknown field, empty, unsorted or too large grid, bad initial state; for a
        single trajectory also any value that breaks a rule.
    """
    require_system(system_argument, system)
    require_drive(drive)
    require_over(over)
    _require_load_rate_where_needed(system, drive, over)
    field = vector_field_for(system, drive)
    defaults = {**system.parameters(), **drive.parameters(), **(extra or {})}
    names = [*defaults, *(f"initial.{variable}" for variable in field.state_names)]
    arrays = {
        name: _label_over_values(name, value, names, reserved)
        for name, value in (over or {}).items()
    }
    sizes = _dimension_sizes(arrays)
    count = math.prod(sizes.values())
    require_memory("over", count * BYTES_PER_TRAJECTORY, f"{count} trajectories")
    varied = {name: _repeat_over_outer_product(*array, sizes) for name, array in arrays.items()}
    shared = {name: np.broadcast_to(v, count) for name, v in defaults.items()}  # takes no memory
    values = {name: varied.get(name, shared[name]) for name in defaults}
    states = initial_states(initial, varied, field, values, count)
    invalid = np.empty(count, dtype=np.bool_)
    for part in batch_slices(count, batch_size):
        batch = {name: column[part] for name, column in values.items()}
        invalid[part] = _breaks_input_rule(system, drive, batch, states[part], field)
    if not sizes and invalid.any():
        _require_finite_periods(drive, values)
        require_admissible_state(system, values, states, field)
    return Ensemble(system, drive, field, sizes, dict(arrays), values, states, invalid)


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


def _require_load_rate_where_needed(
    system: System, drive: Drive, over: OverArgument | None
) -> None:
    """Refuse a remanence that depends on a temperature which jumps of the load change."""
    if system.needs_load_rate({}, varied=over or ()) and not drive.has_load_rate:
        raise InputError(
            "drive",
            must="have a rate of its load in closed form where the remanence warms the body",
            got=shortened_repr(drive),
            why="A change of the field warms a magnet whose remanence depends on temperature.",
            fix="Use Constant, Sine, SineSquared or Sines, or a temperature_coefficient of 0.",
        )


def _label_over_values(
    name: str, value: ArrayLike | xr.DataArray, names: list[str], reserved: frozenset[str]
) -> Labelled:
    """The values of a field with the names of their dimensions."""
    if name not in names:
        raise InputError(
            f"over[{name!r}]",
            must="be a numeric field of the system or of the drive",
            got=repr(name),
            why="Only fields that enter the equations of motion can be varied.",
            fix=f"Its fields are: {', '.join(names)}.",
        )
    array = as_float_array(
        f"over[{name!r}]",
        value,
        what="values of the dimensionless field",
        why="They become a dimension of the result.",
        fix="Pass for example numpy.linspace(0.5, 2.0, 300).",
        least=1,
    )
    if isinstance(value, xr.DataArray):
        dims = tuple(map(str, value.dims))
        _require_unreserved_dims(name, dims, reserved)
        return dims, array
    if array.ndim == 0:
        array = array[None]
    if array.ndim != 1:
        raise InputError(
            f"over[{name!r}]",
            must="have one dimension",
            got=f"an array of shape {array.shape}",
            why="Its values become a dimension of the result.",
            fix="Pass a one-dimensional array, or an xarray.DataArray that names its dimensions.",
        )
    _require_increasing_grid(name, array)
    return (name,), array


def _require_unreserved_dims(name: str, dims: tuple[str, ...], reserved: frozenset[str]) -> None:
    for dim in dims:
        if dim in reserved:
            raise InputError(
                f"over[{name!r}]",
                must="have dimensions that results do not have of their own",
                got=repr(dim),
                why="The result has one axis for each name.",
                fix="Rename the dimension of the DataArray, for example to 'case'.",
            )


def _require_increasing_grid(name: str, array: FloatArray) -> None:
    if is_increasing(array):
        return
    finite = array[np.isfinite(array)]
    if (np.diff(finite) <= 0).any():
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


def _repeat_over_outer_product(
    dims: tuple[str, ...], values: FloatArray, sizes: Mapping[str, int]
) -> FloatArray:
    """Values along some dimensions for every combination, array (trajectory,)."""
    order = [d for d in sizes if d in dims]
    moved = values.transpose([dims.index(d) for d in order])
    shape = [size if d in dims else 1 for d, size in sizes.items()]
    return np.broadcast_to(moved.reshape(shape), tuple(sizes.values())).reshape(-1)


def _breaks_input_rule(
    system: System,
    drive: Drive,
    values: Mapping[str, FloatArray],
    states: FloatArray,
    field: Field,
) -> BoolArray:
    """Where a value or an initial state breaks a rule, array (trajectory,) of bool."""
    broken = system.where_invalid(values) | drive.where_invalid(values)
    periods = load_periods_for_values(drive, values)
    if periods is not None:
        broken = broken | ~np.isfinite(periods)
    return np.asarray(is_invalid_start(system, values, states, field) | broken)


def _require_finite_periods(drive: Drive, values: Mapping[str, FloatArray]) -> None:
    periods = load_periods_for_values(drive, values)
    if periods is not None and not np.isfinite(periods).all():
        raise InputError(
            "drive",
            must="have a finite period",
            got=repr(drive),
            why="Steps are fractions of it.",
            fix="Use Constant for a load that does not change within any run.",
        )
