"""From a special point of one branch to the branch that starts there."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.analysis.orbits.periodic_orbits import Orbits
from remanent.analysis.orbits.switching import crossing_branch_point
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results.checks import require_dataset
from remanent.studies.ensemble.durations import require_count
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import lay_out
from remanent.studies.orbits._branch_tables import describe_branches, label_branches
from remanent.studies.orbits._tracing import Branch, Tracing, TracingOptions, trace_through

#: Kinds of special points where other branches start, and how many times longer the period of
#: their orbits is.
_PERIOD_FACTORS = MappingProxyType({"period doubling": 2, "branch point": 1})


def switch_branch(
    system: System,
    drive: Drive,
    branch: xr.Dataset,
    special: int = 0,
    *,
    state_box: Mapping[str, Any] | None = None,
    max_points: int = 1000,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """Follow the other branch that starts at a special point of a branch.

    Parameters
    ----------
    system, drive : System, Drive
        Those of the branch.
    branch : xarray.Dataset
        A result of :func:`remanent.continue_orbit`, without `over`, or of this verb.
    special : int
        Number of a special point of `branch`: a ``period doubling``, where the branch of twice
        the period starts, or a ``branch point``, where another of the same period does (the
        pair of orbits that break a symmetry).
    state_box : mapping of name to (lower, upper), optional
        Range of each state variable at phase 0, such as ``{"stretch": (0.3, 4.0)}``; the
        branch ends where it leaves the box.
    max_points : int
        In each direction from the special point.
    tolerance : float
        Of the residual: the distance of the orbit's point from its image.

    Returns
    -------
    xarray.Dataset
        The same variables as of :func:`remanent.continue_orbit`: along ``point`` the parameter,
        within the range of the first branch, the state at phase 0, ``multipliers``,
        ``stability`` and extremes; along ``special`` its special points; along ``end`` why it
        ended.

    Raises
    ------
    InputError
        A bad argument, another kind of special point, or a branch that is not reached.

    See Also
    --------
    continue_orbit : Follow the first branch.
    periodic_orbits : Find orbits of any period without a branch.

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
    >>> doubled = rm.switch_branch(damped, drive, forced, 1)
    >>> doubled.attrs["orbit_period"], set(doubled.stability.values.tolist()) >= {"stable"}
    (2, True)
    """
    kind = _require_switch(branch, special)
    parameter = str(branch.attrs.get("parameter", "omega"))
    period = int(branch.attrs["orbit_period"]) * _PERIOD_FACTORS[kind]
    ens = lay_out(system, drive)
    low, high = branch.attrs["parameter_range"]
    limits = (float(low), float(high))
    options = TracingOptions(parameter, limits, state_box, period, max_points, tolerance)
    options.check(ens)
    crossing = _crossing(branch, special, ens, parameter)
    branches = _cross(options.tracing(ens), crossing, kind)
    tables = [describe_branches(ens, branches, options)]
    return label_branches(ens, tables, options, single=True, parameter=parameter)


def _require_switch(branch: xr.Dataset, special: int) -> str:
    """The kind of a special point, where another branch starts there."""
    if "special_kind" not in require_dataset("branch", branch):
        raise InputError(
            "branch",
            must="have special points",
            got=f"variables {', '.join(map(str, branch.data_vars)) or 'none'}",
            why="The other branch starts at one of them.",
            fix="Pass a result of continue_orbit.",
        )
    kinds = [str(kind) for kind in branch["special_kind"].values.ravel()]
    number = require_count("special", special, "It is the number of a special point.", 0)
    known = number < len(kinds) and kinds[number] in _PERIOD_FACTORS
    if not known or "orbit_period" not in branch.attrs:
        raise InputError(
            "special",
            must="be the number of a period doubling or of a branch point",
            got=special,
            why=f"The special points are {kinds}.",
            fix="Pass one of these, of a result of continue_orbit.",
        )
    return kinds[number]


def _crossing(branch: xr.Dataset, special: int, ens: Ensemble, parameter: str) -> FloatArray:
    """Where the branches cross, array (state + 1,)."""
    names = [f"special_{name}" for name in (*ens.field.state, parameter)]
    return np.array([float(branch[name].values.ravel()[special]) for name in names])


def _cross(tracing: Tracing, crossing: FloatArray, kind: str) -> list[Branch]:
    """The branch that crosses another one at a point."""
    point = crossing_branch_point(
        tracing.equations, crossing, scale=tracing.settings.scale, tolerance=0.1 * tracing.tolerance
    )
    if point is None:
        raise InputError(
            "special",
            must="have another branch beside it",
            got=kind,
            why="No point of one was reached by short steps across the branch.",
            fix="Look for its orbits with periodic_orbits, and start there.",
        )
    z = point.unknown
    orbit = Orbits(z[:, :-1], point.extra["jacobian"], point.residual, point.error)
    return trace_through(tracing, orbit, z[:, -1])
