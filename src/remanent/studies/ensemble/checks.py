"""Rules for arguments that many verbs share."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from copy import deepcopy
from typing import TypeAlias

import numpy as np

from remanent._checks import (
    Rule,
    as_float_array,
    is_integer,
    require_choice,
    require_field_names,
    require_instance,
    require_mapping,
    require_real,
    shortened_repr,
)
from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.drives.loads import Loads
from remanent.models.system import System
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.quantities import without_unit

#: Below this, round-off in double precision is all that is left.
FINEST_TOLERANCE = 1e-13
#: Above this, an error bound says nothing.
COARSEST_TOLERANCE = 0.1
#: What to do where a drive stands in the place of a system, or a system in that of a drive.
_ORDER_REMEDY = "Pass the system first, then the drive: simulate(actuator, drive, ...)."
#: Largest end of a range, in size: differences of larger numbers overflow.
_LARGEST_RANGE_END = 1e150
#: Narrowest range over the size of its ends: steps are up to ten thousand times shorter.
_NARROWEST_RELATIVE_RANGE = 1e4 * float(np.finfo(np.float64).eps)
#: What ``drive`` accepts: a drive, or a drive for the name of each load.
DriveArgument: TypeAlias = Drive | Mapping[str, Drive]
#: What ``rng`` accepts.
RngArgument: TypeAlias = int | np.random.Generator | None
#: The seed of all random choices where none is given.
_DEFAULT_SEED = 0
#: Seeds that are drawn from a generator are smaller than this.
_DRAWN_SEED_LIMIT = 2**31
#: Largest seed: files of every kind keep whole numbers exactly up to it.
_LARGEST_SEED = 2**53 - 1


def require_tolerance(value: object, of: str = "the absolute global error") -> float:
    """A tolerance that double precision can meet.

    Parameters
    ----------
    value : object
        What was passed for ``tolerance``.
    of : str
        What it is asked of, as in ``"the residual"``.
    """
    rule = Rule(
        f"lie between {FINEST_TOLERANCE:g} and {COARSEST_TOLERANCE:g}",
        lambda x: np.asarray((x >= FINEST_TOLERANCE) & (x <= COARSEST_TOLERANCE)),
        f"It is asked of {of}, in double precision.",
        "Pass for example 1e-9.",
    )
    return require_real("tolerance", value, rule)


def require_system(name: str, system: object) -> System:
    """Whatever has the members of a system; its equations are found by its kind."""
    # Asked first whether it is an actuator: a protocol looks at every member.
    if isinstance(system, Actuator):
        return system
    if isinstance(system, type) or not isinstance(system, System):
        raise InputError(
            name,
            must="be a system that can move",
            got=_kind_or_value(system),
            why="The equations of motion are derived from it.",
            fix=_ORDER_REMEDY if isinstance(system, Drive) else "Pass for example rm.Actuator().",
        )
    return system


def require_actuator(name: str, system: object) -> Actuator:
    """An actuator, for what only that has: stretches, scales, shaping."""
    if not isinstance(system, Actuator):
        raise InputError(
            name,
            must="be an actuator",
            got=_kind_or_value(system),
            why="Only an actuator has in-plane stretches, dead loads and a magnetic load.",
            fix=_ORDER_REMEDY if isinstance(system, Drive) else "Pass for example rm.Actuator().",
        )
    return system


def require_energy(ens: Ensemble) -> None:
    """A system that has an energy: one of first order has none."""
    if "stored_energy" not in ens.vector_field.observables:
        raise InputError(
            "system",
            must="have an energy",
            got=_kind_or_value(ens.system),
            why="Work and dissipation change it; a system given by its rates says nothing of one.",
            fix="Write it as rm.LagrangianSystem(...).",
        )


def require_drive(drive: object) -> Drive:
    """A drive, or drives by the names of their loads."""
    if isinstance(drive, Mapping):
        try:
            return Loads(drive)
        except InputError as error:  # of the field `drives`, which nobody named
            name = error.name.replace("drives", "drive", 1)
            raise InputError(
                name, must=error.must, got=error.got, why=error.why, fix=error.fix
            ) from None
    # Asked last whether it is a system: a protocol looks at every member, which takes a while.
    if not isinstance(drive, Drive | type) and isinstance(drive, System):
        raise InputError(
            "drive",
            must="be a Drive",
            got=_kind_or_value(drive),
            why="It says how the load changes in time.",
            fix=_ORDER_REMEDY,
        )
    require_instance(
        "drive", drive, Drive,
        "rm.SineSquared(0.4, 1.25), rm.Constant(0.1) for a load that does not change, or "
        "rm.Sampled(times, loads) for any other",
    )  # fmt: skip
    assert isinstance(drive, Drive)
    return drive


def _kind_or_value(value: object) -> str:
    """A value in a message; of a system, a drive or a class its kind."""
    if isinstance(value, type):
        return f"the class {value.__name__} itself"
    if isinstance(value, System | Drive):
        return f"{type(value).__name__}(...)"
    return shortened_repr(value)


def require_interval(
    name: str, value: object, *, what: str, why: str, finite: bool = True
) -> tuple[float, float]:
    """Two increasing numbers.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : object
        What was passed for it.
    what, why : str
        What the two numbers are, and a sentence on why they are needed.
    finite : bool
        Whether infinite ends are refused.
    """
    fix = "Pass two increasing numbers."
    pair = as_float_array(name, value, what=what, why=why, fix=fix, ndim=1, finite=finite)
    if pair.size != 2 or not pair[0] < pair[1]:
        raise InputError(name, must=f"be {what}", got=shortened_repr(value), why=why, fix=fix)
    low, high = pair.tolist()
    if finite and math.isinf(high - low):
        raise InputError(
            name,
            must=f"be {what}, no farther apart than floats reach",
            got=shortened_repr(value),
            why=why,
            fix="Pass two numbers that are nearer to each other.",
        )
    return low, high


def require_intervals(
    name: str, value: object, known: Iterable[str], owner: str, why: str
) -> dict[str, tuple[float, float]]:
    """Intervals of some fields by name; none where nothing was passed.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : mapping of str to (float, float), or None
        What was passed for it.  Ends may be infinite.
    known : iterable of str
        Names that there are.
    owner : str
        What has these names, as in "the actuator".
    why : str
        What the intervals are for, a sentence.
    """
    if value is None:
        return {}
    fix = "Pass for example {'temperature': (280.0, 300.0)}."
    table = require_mapping(name, value, what="names of fields to two numbers", fix=fix)
    if table:
        require_field_names(name, table, known, owner)
    return {
        field: require_interval(
            f"{name}[{field!r}]",
            pair,
            what=f"the lowest and the highest value of {field}",
            why=why,
            finite=False,
        )
        for field, pair in table.items()
    }


def require_drive_frequency(drive: Drive, why: str) -> None:
    """A drive whose frequency can vary."""
    if "omega" not in drive.parameter_values():
        raise InputError(
            "drive",
            must="have a field `omega`",
            got=repr(drive),
            why=why,
            fix="Pass rm.SineSquared(b, omega) or rm.Sine(m, omega).",
        )


def require_parameter_range(
    name: str, value: object, parameter: str, ens: Ensemble, why: str
) -> tuple[float, float]:
    """The lowest and the highest value of a numeric field.

    Parameters
    ----------
    name : str
        Name of the argument.
    value : object
        What was passed for it.
    parameter : str
        The field.
    ens : Ensemble
        Its system or its drive has the field.
    why : str
        What happens between the two values, a sentence.

    Raises
    ------
    InputError
        If it is not two increasing numbers that the field may take.
    """
    what = f"the lowest and the highest value of {parameter}"
    ends = require_interval(
        name, without_unit(name, value, parameter, ens.system), what=what, why=why
    )
    for end in ends:
        broken = ens.system.where_invalid({parameter: end}) | ens.drive.where_invalid(
            {parameter: end}
        )
        if broken.any() or abs(end) > _LARGEST_RANGE_END:
            raise InputError(
                name,
                must=f"hold possible values of {parameter} only",
                got=end,
                why=why,
                fix="Pass values within the field's own range.",
            )
    if ends[1] - ends[0] < _NARROWEST_RELATIVE_RANGE * max(map(abs, ends)):
        raise InputError(
            name,
            must=f"be {what}, told apart by more than rounding",
            got=shortened_repr(value),
            why=why,
            fix="Pass values that are farther apart, or compute the motion at one of them.",
        )
    return ends


def require_parameter(name: str, value: object, ens: Ensemble) -> str:
    """The name of a numeric field of the system or of the drive."""
    return require_choice(name, value, list(ens.parameter_values))


def require_state(name: str, value: ArrayLike, ens: Ensemble, *, why: str, fix: str) -> FloatArray:
    """All state variables of one point, array (state,)."""
    names = ens.vector_field.state_names
    state = as_float_array(name, value, what=", ".join(names), why=why, fix=fix, finite=True)
    if state.size != len(names):
        raise InputError(
            name,
            must=f"be {len(names)} numbers, ({', '.join(names)})",
            got=shortened_repr(value),
            why=why,
            fix=fix,
        )
    return state.ravel()


def as_seed(rng: RngArgument) -> int:
    """The seed of the random choices of one call: fixed where nothing is given.

    Choices are then drawn for each point from this seed and the point alone, so that they do
    not depend on the batch or tile that the point is in.  Of a generator a copy is asked for
    its next number: no verb changes its arguments, and every tile of a sweep, which is a call
    with the same arguments, draws what the whole grid draws.
    """
    if rng is None:
        return _DEFAULT_SEED
    if isinstance(rng, np.random.Generator):
        return int(deepcopy(rng).integers(_DRAWN_SEED_LIMIT))
    if not is_integer(rng) or not 0 <= rng <= _LARGEST_SEED:
        raise InputError(
            "rng",
            must="be an integer from 0 to 2**53 - 1, or a numpy.random.Generator",
            got=shortened_repr(rng),
            why="Equal seeds give equal results, and files of every kind keep the seed exactly.",
            fix="Pass for example 1, or leave it out for one fixed seed.",
        )
    return int(rng)
