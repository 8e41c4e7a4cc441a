"""A system, a drive and ``over`` become an ensemble."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from remanent._checks import shortened_repr
from remanent._errors import InputError
from remanent._field import Field
from remanent._typing import ArrayLike, BoolArray, FloatArray
from remanent.codegen.field import vector_field_for
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.physical_sizes import PHYSICAL_SIZES, PhysicalSizes
from remanent.models.system import System
from remanent.studies.ensemble.checks import DriveArgument, require_drive, require_system
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
from remanent.studies.ensemble.over import (
    RESERVED_DIMENSIONS,
    OverArgument,
    read_over,
    require_over,
    warn_of_varied_values,
)

__all__ = ["RESERVED_DIMENSIONS", "OverArgument", "lay_out_ensemble", "require_over"]


def lay_out_ensemble(
    system: System,
    drive: DriveArgument,
    over: OverArgument | None = None,
    initial: ArrayLike | None = None,
    *,
    reserved: frozenset[str] = RESERVED_DIMENSIONS,
    extra: Mapping[str, float] | None = None,
    system_argument: str = "system",
    batch_size: int = TRAJECTORIES_PER_BATCH,
    tells: bool = True,
) -> Ensemble:
    """Lay out the trajectories that a verb was asked for.

    Parameters
    ----------
    system : System
    drive : Drive, or mapping of str to Drive
    over : mapping of name to array_like or DataArray, optional
        Numeric fields with their values; the physical sizes of an actuator are among them.
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
    tells : bool
        Whether varied values that break a rule draw a warning, as those of a caller do.

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
    drive = require_drive(drive)
    require_over(over)
    system = with_physical_sizes(system, over or ())
    _require_load_rate_where_needed(system, drive, over)
    field = vector_field_for(system, drive)
    defaults = {**system.parameter_values(), **drive.parameter_values(), **(extra or {})}
    names = [*defaults, *(f"initial.{variable}" for variable in field.state_names)]
    names += [name for name in numeric_fields(system) if name not in names]
    fields = read_over(over, names, system, reserved)
    sizes, count = fields.sizes, fields.count
    require_memory("over", count * BYTES_PER_TRAJECTORY, f"{count} trajectories")
    varied = fields.outer_product()
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
    if tells:
        warn_of_varied_values(fields.arrays, varied, system, drive, invalid)
    return Ensemble(
        system, drive, field, sizes, fields.arrays, values, states, invalid, fields.labels
    )


def with_physical_sizes(system: System, names: Iterable[str]) -> System:
    """The system with its physical sizes as numeric fields, where `names` has one of them.

    Equations of motion hold them only where they are varied.
    """
    if not isinstance(system, Actuator) or set(names).isdisjoint(PHYSICAL_SIZES):
        return system
    return system.replace(physical_sizes=system.physical_sizes or PhysicalSizes())


def numeric_fields(system: System) -> dict[str, float]:
    """Values of all numeric fields of a system; physical sizes are 1 where they are left out."""
    sizes = dict.fromkeys(PHYSICAL_SIZES, 1.0) if isinstance(system, Actuator) else {}
    return {**sizes, **system.parameter_values()}


def _require_load_rate_where_needed(
    system: System, drive: Drive, over: OverArgument | None
) -> None:
    """Refuse a remanence that depends on a temperature which jumps of the load change."""
    if system.needs_load_rate({}, varied=over or ()) and not drive.has_load_rate:
        raise InputError(
            "drive",
            must="have a rate of its load in closed form for this system",
            got=shortened_repr(drive),
            why="The rate enters its equations: a change of the field warms a magnet whose "
            "remanence depends on temperature, and moves an observable whose rate holds the load.",
            fix="Use Constant, Sine, SineSquared or Sines; or a temperature_coefficient of 0, or "
            "another observable.",
        )


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
