"""Periodic orbits of a given period, found without a guess."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._status import Status
from remanent._typing import FloatArray
from remanent.analysis.orbits.errors import OrbitErrors, orbit_errors
from remanent.analysis.orbits.point_rows import replace_rows
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import DriveArgument, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.orbits._checks import (
    require_heat_exchange,
    require_orbit_period,
    require_state_box,
)
from remanent.studies.orbits._members import map_members_in_threads, stack_tables
from remanent.studies.orbits._orbit_tables import (
    ORBIT_DIMENSIONS,
    describe_orbits,
    empty_orbit_columns,
)
from remanent.studies.orbits._period_map import (
    StroboscopicMap,
    period_tolerance_for_residual,
    refine_on_period_map,
)
from remanent.studies.orbits._search import (
    OrbitSearch,
    OrbitSearchOutcome,
    is_reversible,
    search_orbits,
)

#: Dimensions of columns beyond that of the orbits.
_EXTRA_DIMENSIONS_OF_COLUMN = MappingProxyType(
    {"initial": ("state",), "multipliers": ("multiplier",), "multipliers_error": ("multiplier",)}
)
#: Residual of orbits as they are found; refinement goes on from there.
_SEARCH_RESIDUAL = 1e-9


def periodic_orbits(
    system: System,
    drive: DriveArgument,
    *,
    orbit_period: int = 1,
    state_box: Mapping[str, Any] | None = None,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Find the periodic orbits of a given period, stable and unstable.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load.
    orbit_period : int
        Least period of the orbits in drive periods: 1 for the forced response, 2, 3 ... for
        subharmonic orbits.
    state_box : mapping of name to (lower, upper), optional
        Range of each state variable at phase 0 in which orbits are looked for, such as
        ``{"stretch": (0.3, 4.0)}``: orbits with a point inside are listed.  By default all
        orbits are, where motion of one stretch is damped; elsewhere those with stretches from
        0.3 to 4, rates from −8 to 8, temperatures up to 5 K from that of the surroundings.
    over : mapping of name to values, optional
        Values of numeric fields; they become dimensions of the result.
    tolerance : float
        Of the error of the orbit's point; shorter steps are taken until it is met.
    progress : bool or callable, optional
        True draws a bar; a callable is called with the share of the combinations in `over`
        that are finished.

    Returns
    -------
    xarray.Dataset
        ``initial`` (orbit, state): the state at phase 0, one point of each orbit;
        ``multipliers`` (orbit, multiplier), complex, largest first, with
        ``multipliers_error``; ``stability`` (orbit): ``elliptic`` or ``saddle`` without
        dissipation, ``stable``, ``saddle`` or ``unstable`` with it, ``undecided`` within the
        error; ``maximum``, ``minimum`` and ``amplitude`` of the thickness stretch along the
        orbit, with ``maximum_error`` and so on; ``residual``, the distance of the point from
        its image; ``error``, that of the point: its step in Newton's method, the error of the
        map and rounding, each through (1 - J)^-1, where J has the multipliers, with the terms
        of second order; NaN where they leave it open whether there is an orbit.  ``orbits``,
        how many there are; ``status``: ``incomplete`` where some may be missing, and the
        ``reason``; else ``max-steps`` where an error is above the tolerance or NaN, and why.
        NaN where there are fewer orbits than elsewhere.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    See Also
    --------
    continue_orbit : Follow one of the orbits while a parameter changes.
    response_diagram : All orbits of forced response over a range of frequencies.
    poincare_section : Motion from any state, once per period.

    Notes
    -----
    With one stretch, the box is divided into cells.  Where Taylor's formula shows that
    P^n(z) − z, or the change of the energy, does not vanish on a cell, P being the period
    map, it holds no orbit; where it shows that Newton's method contracts, it holds one at most.
    Other cells are divided.  Second derivatives between points are taken to be as large as the
    differences of the Jacobians.  Each orbit is confirmed by Newton and Kantorovich's theorem,
    or, without dissipation and with a load even in time, as a symmetric one: at rest at phase 0
    and half its period later.  The indices of all fixed points of P^n, the signs of
    det(1 − DP^n), have to add up to the number of times that P^n(z) − z winds around zero along
    the edge of the box, which with dissipation and all orbits in it is one.

    With more state variables Newton's method starts from a grid of guesses and from motions that
    have settled; an orbit that it reaches from none of them is missed, which only the sum of
    the indices can show, with dissipation and without a `state_box`: else the search is always
    ``incomplete``.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.periodic_orbits(rm.Actuator(temperature=350), rm.SineSquared(0.4, 1.25))
    >>> ds.stability.values.tolist()
    ['elliptic', 'elliptic', 'saddle']
    """
    orbit_period = require_orbit_period(orbit_period)
    tolerance = require_tolerance(tolerance, "the error of the orbits")
    ens = lay_out_ensemble(system, drive, over, reserved=ORBIT_DIMENSIONS)
    require_drive_periods(ens)
    require_heat_exchange(ens)
    require_state_box("state_box", state_box, ens)

    def find(member: Ensemble) -> dict[str, NDArray[Any]]:
        map_ = StroboscopicMap(member, (), period_tolerance_for_residual(_SEARCH_RESIDUAL))
        box = require_state_box("state_box", state_box, member)
        search = OrbitSearch(
            map_, box, orbit_period, _SEARCH_RESIDUAL, is_reversible(ens.system, ens.drive),
            box_is_free=state_box is None,
        )  # fmt: skip
        (outcome,) = search_orbits(search, np.empty((1, 0)))
        orbits = _refined(map_, outcome, orbit_period, tolerance)
        columns = describe_orbits(member, orbits, orbit_period, {})
        reason = outcome.reason or _why_errors_are_large(columns["error"], tolerance)
        return columns | {
            "reason": np.array(reason), "is_complete": np.array(not outcome.reason)
        }  # fmt: skip

    tables = map_members_in_threads(ens, find, as_progress(progress))
    reasons = np.array(["" if t is None else str(t["reason"]) for t in tables])
    columns = stack_tables(tables, empty_orbit_columns(len(ens.vector_field.state_names)))
    variables: dict[str, PerTrajectoryArray] = {
        name: (("orbit", *_EXTRA_DIMENSIONS_OF_COLUMN.get(name, ())), column)
        for name, column in columns.items()
    }
    variables["reason"] = reasons
    variables["orbits"] = np.array([0 if t is None else len(t["residual"]) for t in tables])
    coords: dict[str, Labelled] = {
        "orbit": (("orbit",), np.arange(columns["residual"].shape[1])),
        "state": (("state",), np.array(ens.vector_field.state_names)),
        "multiplier": (("multiplier",), np.arange(len(ens.vector_field.state_names))),
    }
    status = [
        Status.INVALID if table is None
        else Status.INCOMPLETE if not table["is_complete"]
        else Status.OK if (table["error"] <= tolerance).all()
        else Status.MAX_STEPS
        for table in tables
    ]  # fmt: skip
    return to_dataset(
        ens, variables, coords=coords, tolerance=tolerance, status=np.array(status),
        orbit_period=orbit_period,
    )  # fmt: skip


def _why_errors_are_large(error: FloatArray, tolerance: float) -> str:
    """Why the error of some orbits is above the tolerance, or not told; empty if none is."""
    words = []
    large, unknown = error[error > tolerance], np.isnan(error)
    if large.size:
        words.append(
            f"{large.size} of {error.size} orbits {'is' if large.size == 1 else 'are'} known "
            f"to {large.max():.1g} at best, above the tolerance: rounding, and the error of the "
            "map at its shortest steps, are magnified by (1 - J)^-1"
        )
    if unknown.any():
        words.append(
            f"{unknown.sum()} of {error.size} orbits {'has' if unknown.sum() == 1 else 'have'} "
            "no error: within rounding and the error of the map it is open whether there is "
            "one orbit near the point, or none, or more"
        )
    return "; ".join(words)


def _refined(
    map_: StroboscopicMap, outcome: OrbitSearchOutcome, orbit_period: int, tolerance: float
) -> OrbitErrors:
    """Orbits with errors below a tolerance, where they can be had.

    Symmetric ones that Newton's method cannot confirm stay where they are: it would move them
    along a curve on which P^n(z) - z almost vanishes.
    """
    found = outcome.orbits.state
    orbits = refine_on_period_map(map_, found, np.empty((len(found), 0)), orbit_period, tolerance)
    staying = outcome.symmetric[~orbits.is_confirmed[outcome.symmetric]]
    as_found = orbit_errors(map_, found[staying], np.empty((len(staying), 0)), orbit_period)
    return replace_rows(orbits, staying, as_found)
