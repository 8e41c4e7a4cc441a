"""From a special point of one branch to the branch that starts there."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent.analysis.orbits import Orbits
from remanent.analysis.switching import other_branch
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.studies.ensemble.durations import require_count
from remanent.studies.ensemble.ensemble import ensemble
from remanent.studies.orbits._period_map import at
from remanent.studies.orbits._tracing import through
from remanent.studies.orbits.continue_orbit import (
    describe_branches,
    label_branches,
    parameter_bounds,
    trace_with,
)

#: Where other branches start, and how many times longer the period of their orbits is.
_SWITCHES = {"period doubling": 2, "branch point": 1}


def switch_branch(
    actuator: Actuator,
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
    actuator, drive
        Those of the branch.
    branch
        A result of :func:`remanent.continue_orbit` or of this verb.
    special
        Which of its special points: a ``period doubling``, where the branch of twice the
        period starts, or a ``branch point``, where another of the same period does (the pair
        of orbits that break a symmetry).
    state_box, max_points, tolerance
        As for :func:`remanent.continue_orbit`.

    Returns
    -------
    xarray.Dataset
        As that of :func:`remanent.continue_orbit`, within the bounds of the first branch.

    Raises
    ------
    InputError
        A bad argument, another kind of special point, or a branch that is not reached.

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
    kinds = [str(one) for one in branch["special_kind"].values.ravel()]
    which = require_count("special", special, "It is the number of a special point.", 0)
    if which >= len(kinds) or kinds[which] not in _SWITCHES or "orbit_period" not in branch.attrs:
        raise InputError(
            "special", "be the number of a period doubling or of a branch point", special,
            f"The special points are {kinds}.", "Pass one of these, of a result of continue_orbit.",
        )  # fmt: skip
    parameter = str(branch.attrs.get("parameter", "omega"))
    period = int(branch.attrs["orbit_period"]) * _SWITCHES[kinds[which]]
    ens = ensemble(actuator, drive)
    limits = parameter_bounds(parameter, branch.attrs["parameter_range"], ens)
    tracing = trace_with(ens, parameter, limits, state_box, period, max_points, tolerance)
    names = [f"special_{name}" for name in (*ens.field.state, parameter)]
    crossing = np.array([float(branch[name].values.ravel()[which]) for name in names])
    point = other_branch(
        tracing.equations, crossing, scale=tracing.settings.scale, tolerance=0.1 * tolerance
    )
    if point is None:
        raise InputError(
            "special", "have another branch beside it", kinds[which],
            "No point of one was reached by short steps across the branch.",
            "Look for its orbits with periodic_orbits, and start there.",
        )  # fmt: skip
    z = point.unknown
    orbit = Orbits(z[:, :-1], point.extra["jacobian"], point.residual, point.error)
    found = [describe_branches(at(ens, 0), through(tracing, orbit, z[:, -1]), parameter, period)]
    settings = {"parameter": parameter, "parameter_range": limits, "orbit_period": period}
    return label_branches(ens, found, parameter, tolerance, settings).isel(branch=0, drop=True)
