"""From a special point of one branch to the branch that starts there."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

import xarray as xr

from remanent._checks import as_float_array
from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray
from remanent.analysis.orbits.periodic_orbits import PeriodicOrbits
from remanent.models.system import System
from remanent.results import provenance
from remanent.results.checks import require_dataset
from remanent.studies.ensemble.checks import (
    DriveArgument,
    require_parameter,
    require_parameter_range,
)
from remanent.studies.ensemble.durations import require_count
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.orbits._branch_tables import describe_branches, label_branches
from remanent.studies.orbits._tracing import (
    Branch,
    Tracing,
    TracingOptions,
    trace_from_special_point,
    trace_through_orbits,
)

#: Where other branches start, and how many times longer the period of their orbits is.
_PERIOD_FACTOR_OF_KIND: Final[Mapping[str, int]] = MappingProxyType(
    {"period doubling": 2, "branch point": 1}
)
#: Distance of a special point from the one in the result, in scaled unknowns, at most.
_MAX_DISTANCE_FROM_RESULT = 0.01
#: A branch has at least so many points: where it starts, and one beside it.
_MIN_BRANCH_POINTS = 2


def switch_branch(
    branch: xr.Dataset,
    special_point: int = 0,
    *,
    system: System | None = None,
    drive: DriveArgument | None = None,
    parameter: str | None = None,
    parameter_range: ArrayLike | None = None,
    orbit_period: int | None = None,
    state_box: Mapping[str, Any] | None = None,
    max_points: int = 1000,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """Follow the other branch that starts at a special point of a branch.

    Parameters
    ----------
    branch : xarray.Dataset
        A result of :func:`remanent.continue_orbit` or of this verb.
    special_point : int
        The number of one of its special points: a ``period doubling``, where the branch of
        twice the period starts, or a ``branch point``, where another of the same period does
        (the pair of orbits that break a symmetry).
    system, drive : System and Drive, optional
        Those of the branch; by default they are read from its attributes, which some
        operations on a Dataset drop.
    parameter : str, optional
        The field that changes along the branch; by default read from its attributes.
    parameter_range : (float, float), optional
        The lowest and the highest value of that field on the new branch; by default those of
        `branch`.
    orbit_period : int, optional
        Of the orbits on `branch`, in drive periods; by default read from its attributes.
    state_box : mapping of str to (float, float), optional
        Range of each state variable at phase 0, such as ``{"stretch": (0.3, 4.0)}``; the new
        branch ends where it leaves the box.
    max_points : int
        The largest number of points in each direction from the special point.
    tolerance : float
        Of the residual: the distance of the orbit's point from its image.

    Returns
    -------
    xarray.Dataset
        The same variables as of :func:`remanent.continue_orbit`: along ``point`` the parameter,
        the state at phase 0, ``multipliers``, ``stability`` and extremes; along ``special`` its
        special points; along ``end`` why it ended.  A branch that starts at a doubling is
        followed once: its other direction holds the same orbits, half their period later.  It
        begins with the doubling, whose ``special_orbit_period`` is that of the first branch;
        there this verb leads back.

    Raises
    ------
    InputError
        A bad argument, another kind of special point, a branch that does not say what made
        it, or no other branch that is reached.

    See Also
    --------
    remanent.continue_orbit : The branch to start from.
    remanent.periodic_orbits : Orbits of any period, without a branch.

    Notes
    -----
    At the point the equations have a second null vector, for a doubling the eigenvector of
    the multiplier −1; a step along it, corrected across it, is a point of the other branch.

    Examples
    --------
    >>> import remanent as rm
    >>> damped, drive = rm.Actuator(dissipation=rm.Rayleigh(0.01)), rm.SineSquared(0.8, 2.4)
    >>> forced = rm.continue_orbit(damped, drive, "omega", (2.25, 2.45))
    >>> forced.special_kind.values.tolist()
    ['period doubling', 'period doubling']
    >>> doubled = rm.switch_branch(forced, 1)
    >>> doubled.attrs["orbit_period"], set(doubled.stability.values.tolist()) >= {"stable"}
    (2, True)
    """
    kind, number = _require_switching_point(branch, special_point)
    system, drive = _system_and_drive_of_branch(branch, system, drive)
    parameter = _setting_of_branch(branch, "parameter", parameter)
    single_period = require_count(
        "orbit_period",
        _setting_of_branch(branch, "orbit_period", orbit_period),
        "Orbits close after whole drive periods.",
    )
    ens = lay_out_ensemble(system, drive)
    drive = ens.drive
    require_parameter("parameter", parameter, ens)
    if f"special_{parameter}" not in branch:
        raise InputError(
            "parameter",
            must="be the field that was followed along `branch`",
            got=repr(parameter),
            why="The special point has a value of that one only.",
            fix="Leave it out: the branch says which it is.",
        )
    _require_states_of_branch(branch, ens)
    limits = require_parameter_range(
        "parameter_range",
        _setting_of_branch(branch, "parameter_range", parameter_range),
        parameter,
        ens,
        "The branch is followed between them.",
    )
    joins = _joins_shorter_period(branch, number, single_period)
    period = single_period // 2 if joins else single_period * _PERIOD_FACTOR_OF_KIND[kind]
    options = TracingOptions(parameter, limits, state_box, period, max_points, tolerance)
    options = options.require_valid(ens)
    crossing = _read_special_point(branch, number, ens, parameter)
    tracing = options.tracing_of_member(ens)
    branches = _branches_at_point(tracing, crossing, kind, joins=joins)
    tables = [describe_branches(tracing, branches, parameter)]
    return label_branches(ens, tables, options, single=True, parameter=parameter)


def _require_switching_point(branch: xr.Dataset, special_point: int) -> tuple[str, int]:
    """The kind and the number of a special point at which another branch starts."""
    why = "It counts the special points of the branch from 0."
    number = require_count("special_point", special_point, why, 0)
    if "special_kind" not in require_dataset("branch", branch):
        raise InputError(
            "branch",
            must="have special points",
            got=f"variables {', '.join(map(str, branch.data_vars)) or 'none'}",
            why="Another branch starts at one of them.",
            fix="Pass the result of continue_orbit.",
        )
    kinds = [str(kind) for kind in branch["special_kind"].values.ravel()]
    if number >= len(kinds) or kinds[number] not in _PERIOD_FACTOR_OF_KIND:
        raise InputError(
            "special_point",
            must="be the number of a period doubling or of a branch point",
            got=number,
            why=f"The special points are {kinds}.",
            fix="Pass the number of such a point, from 0.",
        )
    return kinds[number], number


def _system_and_drive_of_branch(
    branch: xr.Dataset, system: System | None, drive: DriveArgument | None
) -> tuple[System, DriveArgument]:
    """The system and the drive of a branch, unless they are given."""
    several = provenance.varying_field_names(branch)
    if several and (system is None or drive is None):
        raise InputError(
            "branch",
            must="be that of one system and one drive",
            got=f"several values of {several}",
            why="A branch is followed for one value of every other field.",
            fix="Select one, branch.isel(...) without drop=True, or pass system=... and drive=....",
        )
    return (
        provenance.read_system(branch) if system is None else system,
        provenance.read_drive(branch) if drive is None else drive,
    )


def _require_states_of_branch(branch: xr.Dataset, ens: Ensemble) -> None:
    """Refuse a system of other state variables than the special points have."""
    names = ens.vector_field.state_names
    missing = [name for name in names if f"special_{name}" not in branch]
    if missing:
        raise InputError(
            "system",
            must="be the one whose orbits are on `branch`",
            got=ens.system,
            why=f"Its special points have no {', '.join(missing)}, which is a state variable of "
            "this one.",
            fix="Leave it out: the branch says which it is.",
        )


def _setting_of_branch(branch: xr.Dataset, name: str, value: Any) -> Any:
    """A setting of the branch: as it is given, else from the attributes."""
    if value is None and name not in branch.attrs:
        raise InputError(
            name,
            must="be given, or be an attribute of the branch",
            got="neither",
            why="Some operations on a Dataset drop its attributes.",
            fix=f"Pass {name}=... as it was for the branch.",
        )
    return branch.attrs[name] if value is None else value


def _read_special_point(
    branch: xr.Dataset, number: int, ens: Ensemble, parameter: str
) -> FloatArray:
    """Where the branches cross, array (state + 1,)."""
    names = [f"special_{name}" for name in (*ens.vector_field.state_names, parameter)]
    return as_float_array(
        "branch", [branch[name].values.ravel()[number] for name in names],
        what="state and parameter of each special point",
        why="Another branch starts at such a point.",
        fix="Pass the result of continue_orbit.", finite=True,
    )  # fmt: skip


def _joins_shorter_period(branch: xr.Dataset, number: int, orbit_period: int) -> bool:
    """Whether a special point is where the branch starts on that of half its period."""
    if "special_orbit_period" not in branch:
        return False
    return int(branch["special_orbit_period"].values.ravel()[number]) < orbit_period


def _branches_at_point(
    tracing: Tracing, crossing: FloatArray, kind: str, *, joins: bool
) -> list[Branch]:
    """The other branch at a special point.

    Parameters
    ----------
    tracing : Tracing
        Of that branch.
    crossing : array (state + 1,)
        Where both meet, roughly.
    kind : str
    joins : bool
        Whether the known branch starts there, and the other has half its period.
    """
    doubles = kind == "period doubling" and not joins
    period = tracing.orbit_period // (2 if doubles else 1)
    located = tracing.locate(kind, period, crossing, _MAX_DISTANCE_FROM_RESULT)
    if located is None:
        raise _no_branch(f"Newton's method found no {kind} at the state in the result.")
    if not joins:
        branch = trace_from_special_point(tracing, located, doubles=doubles)
        if len(branch.curve.points) < _MIN_BRANCH_POINTS:
            raise _no_branch("No point of one was reached by short steps across the branch.")
        return [branch]
    point = tracing.point_of_branch(located)
    orbit = PeriodicOrbits(
        point.unknown[:, :-1], point.extra_arrays["jacobian"], point.residual, point.residual_error
    )
    return trace_through_orbits(tracing, orbit, point.unknown[:, -1])


def _no_branch(why: str) -> InputError:
    return InputError(
        "special_point",
        must="have another branch beside it",
        got="none",
        why=why,
        fix="Look for its orbits with periodic_orbits, and start there.",
    )
