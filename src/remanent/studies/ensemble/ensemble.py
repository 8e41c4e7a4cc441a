"""An actuator, a drive and ``over`` become many trajectories in plain arrays."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import increases
from remanent._errors import InputError
from remanent._field import Field
from remanent._timeline import Timeline
from remanent._typing import ArrayLike, BoolArray, FloatArray
from remanent.codegen.field import field_for
from remanent.integrate.ensemble.problem import Problem
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.results.build import Labelled

#: What ``over`` accepts.
Over = Mapping[str, ArrayLike | xr.DataArray]
#: Largest stretch and rate, and inverse of the smallest stretch, to start from.
FARTHEST = 1e6
#: Names of dimensions that results have of their own.
_RESERVED = frozenset(
    {"time", "cycle", "period", "crossing", "equilibrium", "thickness_stretch", "fold", "snap"}
)
#: Trajectories that are worked on together where their results are all that is kept.
_SLAB = 2**14
#: Bytes that a trajectory costs while it is computed, beside its samples.
_OVERHEAD = 1024


@dataclass(frozen=True)
class Ensemble:
    """Trajectories on the outer product of the values in ``over``.

    Attributes
    ----------
    sizes
        Length of each dimension, in order; empty for a single trajectory.
    coords
        Values of the varied fields, labelled.
    values : mapping of name to array (trajectory,)
        Every numeric field of actuator and drive.
    initial : array (trajectory, state)
    invalid : array (trajectory,) of bool
        Where a value breaks a rule.
    """

    system: Actuator
    drive: Drive
    field: Field
    sizes: dict[str, int]
    coords: dict[str, Labelled]
    values: dict[str, FloatArray]
    initial: FloatArray
    invalid: BoolArray

    @property
    def count(self) -> int:
        """Number of trajectories."""
        return math.prod(self.sizes.values())

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions, in order."""
        return tuple(self.sizes)

    def shaped(self, values: Any) -> Any:
        """From (trajectory, ...) to one axis for each dimension of the ensemble."""
        return np.reshape(values, (*self.sizes.values(), *np.shape(values)[1:]))

    def slabs(self) -> Iterator[tuple[slice, Ensemble]]:
        """The trajectories in parts, so that work on each takes memory for itself only."""
        for part in _parts(self.count):
            yield (
                part,
                replace(
                    self,
                    sizes={"trajectory": part.stop - part.start},
                    values={name: v[part] for name, v in self.values.items()},
                    initial=self.initial[part],
                    invalid=self.invalid[part],
                ),
            )

    def periods(self) -> FloatArray | None:
        """Smallest period of the load of every trajectory, or None."""
        found = _periods(self.drive, self.values)
        return None if found is None else np.broadcast_to(found, (self.count,)).astype(float)


def _parts(count: int) -> Iterator[slice]:
    return (slice(k, min(k + _SLAB, count)) for k in range(0, count, _SLAB))


def ensemble(
    actuator: Actuator,
    drive: Drive,
    over: Over | None = None,
    initial: ArrayLike | None = None,
    *,
    reserved: frozenset[str] = _RESERVED,
    extra: Mapping[str, float] | None = None,
) -> Ensemble:
    """Lay out the trajectories that a verb was asked for.

    `reserved` are the names of dimensions that its result has of its own; `extra` are
    further names that `over` may vary, with their usual values.

    Raises
    ------
    InputError
        Unknown field, empty, unsorted or too large grid, bad initial state; for a
        single trajectory also any value that breaks a rule.
    """
    from remanent._checks import require_instance

    require_instance("actuator", actuator, Actuator, "rm.Actuator()")
    require_instance("drive", drive, Drive, "rm.SineSquared(0.4, 1.25)")
    _require_rate(actuator, drive, over)
    field = field_for(actuator, drive)
    own = {**actuator.parameters(), **drive.parameters(), **(extra or {})}
    if over is not None and not isinstance(over, Mapping):
        raise InputError(
            "over",
            "be a mapping of names to values",
            repr(over)[:80],
            "It says which fields take many values.",
            "Pass for example {'temperature': [250, 350, 400]}.",
        )
    arrays = {name: _labelled(name, v, own, field, reserved) for name, v in (over or {}).items()}
    sizes = _sizes(arrays)
    count = math.prod(sizes.values())
    require_memory(count * _OVERHEAD, f"{count} trajectories")
    varied = {name: _spread(*array, sizes) for name, array in arrays.items()}
    same = {name: np.broadcast_to(value, count) for name, value in own.items()}  # costs no memory
    values = {name: varied.get(name, same[name]) for name in own}
    start = _initial(initial, varied, field, values)
    wrong = np.empty(count, dtype=np.bool_)
    for part in _parts(count):
        some = {name: v[part] for name, v in values.items()}
        wrong[part] = _invalid(actuator, drive, some, start[part], field)
    if not sizes and wrong.any():
        _refuse(start, field, drive, _periods(drive, values))
        _refuse_beyond(actuator, values, start, field)
    return Ensemble(actuator, drive, field, sizes, dict(arrays), values, start, wrong)


def _require_rate(actuator: Actuator, drive: Drive, over: Over | None) -> None:
    """Refuse a remanence that depends on a temperature which jumps of the load change."""
    name = "magnet.temperature_coefficient"
    depends = name in (over or {}) or actuator.parameters()[name] != 0.0
    if actuator.heat is not None and depends and not drive.has_rate:
        raise InputError(
            "drive",
            "have a rate of its load in closed form where the remanence takes part in the heat",
            repr(drive)[:80],
            "A change of the field warms a magnet whose remanence depends on temperature.",
            "Use Constant, Sine, SineSquared or Sines, or a temperature_coefficient of 0.",
        )


def problem(ens: Ensemble, duration: FloatArray) -> Problem:
    """The trajectories of an ensemble, each lasting its `duration`."""
    safe = np.where(ens.invalid, 1.0, duration)
    usable = {
        name: np.where(ens.invalid, _harmless(ens, name), v) for name, v in ens.values.items()
    }
    timeline = _timeline(ens.drive, usable, safe)
    lengths = np.broadcast_to(timeline.lengths, (len(timeline.lengths), ens.count))
    timeline = Timeline(lengths, timeline.periodic, timeline.parameters, timeline.waveform)
    columns = [usable.get(name, np.zeros(ens.count)) for name in ens.field.parameters]
    parameters = np.column_stack(columns) if columns else np.zeros((ens.count, 0))
    return Problem(ens.field, timeline, parameters, ens.initial, safe, ens.invalid)


def _timeline(drive: Drive, values: Mapping[str, FloatArray], end: FloatArray) -> Timeline:
    try:
        with np.errstate(all="ignore"):
            return drive.timeline(values, end)
    except InputError:
        raise
    except ValueError as error:  # from the interpolation of samples
        raise InputError(
            "drive",
            "have loads that a spline can pass through in floating point",
            repr(drive)[:80],
            f"Interpolation failed: {error}",
            "Use loads and times of ordinary size.",
        ) from error


def require_memory(needed: float, what: str) -> None:
    """Refuse a request before allocating more than half of this machine's memory."""
    limit = _physical_memory() / 2
    if needed > limit:
        raise InputError(
            "over",
            f"ask for results of at most {limit / 2**30:.1f} GiB",
            f"{what}, about {needed / 2**30:.1f} GiB",
            "The request was refused before any memory was allocated.",
            "Pass fewer values, fewer times, or split the request.",
        )


def _physical_memory() -> float:
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return 8.0 * 2**30


def _harmless(ens: Ensemble, name: str) -> float:
    return {**ens.system.parameters(), **ens.drive.parameters()}[name]


def _labelled(
    name: str,
    value: ArrayLike | xr.DataArray,
    own: Mapping[str, float],
    field: Field,
    reserved: frozenset[str],
) -> Labelled:
    known = [*own, *(f"initial.{s}" for s in field.state)]
    if name not in known:
        raise InputError(
            f"over[{name!r}]",
            "be a numeric field of the actuator or of the drive",
            repr(name),
            "Only fields that enter the equations of motion can be varied.",
            f"Its fields are: {', '.join(known)}.",
        )
    if isinstance(value, xr.DataArray):
        dims = tuple(map(str, value.dims))
        _require_free(name, dims, reserved)
        return dims, _floats(name, value.values)
    array = _floats(name, value)
    if array.ndim == 0:
        array = array[None]
    if array.ndim != 1:
        raise InputError(
            f"over[{name!r}]",
            "have one dimension",
            f"an array of shape {array.shape}",
            "Its values become a dimension of the result.",
            "Pass a one-dimensional array, or an xarray.DataArray that names its dimensions.",
        )
    _require_grid(name, array)
    return (name,), array


def _require_free(name: str, dims: tuple[str, ...], reserved: frozenset[str]) -> None:
    for dim in dims:
        if dim in reserved:
            raise InputError(
                f"over[{name!r}]",
                "have dimensions that results do not have of their own",
                repr(dim),
                "The result has one axis for each name.",
                "Rename the dimension of the DataArray, for example to 'case'.",
            )


def _floats(name: str, value: Any) -> FloatArray:
    try:
        array = np.array(value, dtype=np.float64)  # the result keeps it
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(
            f"over[{name!r}]",
            "be an array of real numbers",
            repr(value)[:80],
            "Every value is a number of the dimensionless model.",
            "Pass for example numpy.linspace(0.5, 2.0, 300).",
        ) from error
    if array.size == 0:
        raise InputError(
            f"over[{name!r}]",
            "have at least one value",
            "an empty array",
            "A grid without points has no results.",
            "Pass at least one value.",
        )
    return array


def _require_grid(name: str, array: FloatArray) -> None:
    if increases(array):
        return
    finite = array[np.isfinite(array)]
    if (np.diff(finite) <= 0).any():
        raise InputError(
            f"over[{name!r}]",
            "be sorted upwards without repeated values",
            np.array2string(array, threshold=6),
            "The values label a dimension of the result, on which one selects and interpolates.",
            "Pass numpy.unique(values), or a DataArray with a dimension of its own.",
        )


def _sizes(arrays: Mapping[str, Labelled]) -> dict[str, int]:
    sizes: dict[str, int] = {}
    for name, (dims, values) in arrays.items():
        for dim, size in zip(dims, values.shape, strict=True):
            if sizes.setdefault(dim, size) != size:
                raise InputError(
                    f"over[{name!r}]",
                    f"have length {sizes[dim]} along {dim!r}",
                    size,
                    "Values that share a dimension go together, one with one.",
                    "Give them the same length, or different dimensions.",
                )
    return sizes


def _spread(dims: tuple[str, ...], values: FloatArray, sizes: Mapping[str, int]) -> FloatArray:
    order = [d for d in sizes if d in dims]
    moved = values.transpose([dims.index(d) for d in order])
    shape = [size if d in dims else 1 for d, size in sizes.items()]
    return np.broadcast_to(moved.reshape(shape), tuple(sizes.values())).reshape(-1)


def _initial(
    initial: ArrayLike | None,
    varied: Mapping[str, FloatArray],
    field: Field,
    values: Mapping[str, FloatArray],
) -> FloatArray:
    """Initial states, array (trajectory, state): rest where nothing else is said."""
    rest = [at_rest(name, values) for name in field.state]
    first = [column[0] for column in rest]
    moving = [name for name in field.state if name.startswith("stretch")]
    try:
        given = np.asarray(first if initial is None else initial, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        given = np.empty(0)
    if given.shape not in {(len(moving),), (len(rest),)} or not np.isfinite(given).all():
        raise InputError(
            "initial",
            f"be {len(moving)} finite numbers, ({', '.join(moving)})"
            + (f", or all of {', '.join(field.state)}" if moving != [*field.state] else ""),
            repr(initial),
            "A motion starts from one state.",
            "Leave it out to start from rest; "
            f"vary it by over={{'initial.{field.state[0]}': ...}}.",
        )
    own = {k: varied[f"initial.{n}"] for k, n in enumerate(field.state) if f"initial.{n}" in varied}
    said = given.size if initial is not None else 0
    for k, column in enumerate(rest):
        if k >= said and column.strides != (0,):
            own.setdefault(k, column)
    row = np.append(given, first[given.size :])
    start = np.broadcast_to(row, (values["c"].size, len(rest)))
    if own:
        start = start.copy()
        for k, column in own.items():
            start[:, k] = column
    return start


def at_rest(name: str, values: Mapping[str, FloatArray]) -> FloatArray:
    """A state variable at rest: temperature that of the surroundings, all stretches 1."""
    if name == "body_temperature":
        return values["temperature"]
    return np.broadcast_to(0.0 if name.endswith("_rate") else 1.0, values["c"].shape)


def _stretches(field: Field) -> list[int]:
    return [k for k, name in enumerate(field.state) if not name.endswith("_rate")]


def _in_plane(start: FloatArray, field: Field) -> tuple[FloatArray, FloatArray]:
    """The two in-plane stretches of states, the same array twice for one coordinate."""
    names = ("stretch", "stretch_1", "stretch_2")
    columns = [k for k, name in enumerate(field.state) if name in names]
    return start[:, columns[0]], start[:, columns[-1]]


def _invalid(
    actuator: Actuator,
    drive: Drive,
    values: Mapping[str, FloatArray],
    start: FloatArray,
    field: Field,
) -> BoolArray:
    broken = actuator.invalid(values) | drive.invalid(values)
    beyond = ~actuator.reachable(values, *_in_plane(start, field))
    bad_state = ~(np.abs(start) <= FARTHEST).all(axis=1)
    bad_state |= ~(start[:, _stretches(field)] >= 1.0 / FARTHEST).all(axis=1)
    periods = _periods(drive, values)
    if periods is not None:
        broken = broken | ~np.isfinite(periods)
    return np.asarray(np.broadcast_to(broken, bad_state.shape) | bad_state | beyond)


def _periods(drive: Drive, values: Mapping[str, FloatArray]) -> FloatArray | None:
    with np.errstate(all="ignore"):
        return drive.periods(values)


def _refuse(states: FloatArray, field: Field, drive: Drive, periods: FloatArray | None) -> None:
    start = states[0]
    if periods is not None and not np.isfinite(periods).all():
        raise InputError(
            "drive",
            "have a finite period",
            repr(drive),
            "Steps are fractions of it.",
            "Use Constant for a load that does not change within any run.",
        )
    for k in _stretches(field):
        if not start[k] > 0.0:
            raise InputError(
                "initial",
                f"have a {field.state[k]} greater than 0",
                start[k],
                "Stretches are ratios of lengths, temperatures are absolute.",
                "Pass 1 for the undeformed block.",
            )
    if (np.abs(start) <= FARTHEST).all() and min(start[_stretches(field)]) >= 1.0 / FARTHEST:
        return
    raise InputError(
        "initial",
        f"have stretches from {1.0 / FARTHEST:g} to {FARTHEST:g} and rates up to {FARTHEST:g}",
        start.tolist(),
        "No actuator gets beyond them, and formulas with high powers lose their digits there.",
        "Pass (1, 0) for rest.",
    )


def _refuse_beyond(
    actuator: Actuator, values: Mapping[str, FloatArray], start: FloatArray, field: Field
) -> None:
    if not actuator.reachable(values, *_in_plane(start, field)).all():
        raise InputError(
            "initial",
            "be a state that the material can reach",
            start[0].tolist(),
            f"It lies beyond the limiting chain extension of {actuator.material!r}.",
            "Start nearer to (1, 0), or raise the limit.",
        )
