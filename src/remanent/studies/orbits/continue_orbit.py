"""One branch of periodic orbits, followed while a parameter changes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray
from remanent.analysis.orbits.periodic_orbits import PeriodicOrbits, newton_fixed_points
from remanent.models.system import System
from remanent.studies.ensemble.checks import (
    DriveArgument,
    require_parameter,
    require_parameter_range,
    require_state,
)
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.orbits._branch_tables import (
    BranchTablesOfSystem,
    describe_branches,
    label_branches,
)
from remanent.studies.orbits._checks import require_not_in_over
from remanent.studies.orbits._members import map_members_in_threads
from remanent.studies.orbits._orbit_tables import ORBIT_DIMENSIONS
from remanent.studies.orbits._search import nearest_to_rest, search_orbits
from remanent.studies.orbits._tracing import Tracing, TracingOptions, trace_through_orbits

_INITIAL_STATE_REMEDY = "Take one from periodic_orbits, at phase 0."


def continue_orbit(
    system: System,
    drive: DriveArgument,
    parameter: str,
    parameter_range: ArrayLike,
    *,
    initial: ArrayLike | None = None,
    orbit_period: int = 1,
    state_box: Mapping[str, Any] | None = None,
    over: OverArgument | None = None,
    max_points: int = 1000,
    tolerance: float = 1e-9,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Follow a periodic orbit while a parameter changes, through folds, both ways.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load.
    parameter : str
        A numeric field of either, such as ``"omega"``, ``"b"``, ``"temperature"`` or
        ``"dissipation.0.eta"``.
    parameter_range : (lowest, highest)
        Values of the parameter between which the branch is followed.
    initial : array_like (state,), optional
        A state near the orbit at phase 0, for the field's own value; by default the orbit
        nearest to rest.
    orbit_period : int
        Of the orbit, in drive periods.
    state_box : mapping of name to (lower, upper), optional
        Range of each state variable at phase 0, such as ``{"stretch": (0.3, 4.0)}``; the
        branch ends where it leaves the box.  By default stretches from 0.3 to 4, rates from
        −8 to 8, temperatures up to 5 K from that of the surroundings.
    over : mapping of name to values, optional
        Values of other numeric fields; they become dimensions of the result.  Each branch
        starts from `initial`, or from the orbit nearest to rest.
    max_points : int
        In each direction from the start.
    tolerance : float
        Of the residual: the distance of the orbit's point from its image.  No point beyond it
        is in the result.
    progress : bool or callable, optional
        True draws a bar; a callable is called with the share of the combinations in `over`
        that are finished.

    Returns
    -------
    xarray.Dataset
        Along ``point``: the parameter, the state at phase 0 and its ``error`` at that value of
        the parameter, ``residual``; ``multipliers`` and ``stability``; ``amplitude``,
        ``maximum`` and ``minimum`` with their errors; along ``point`` and ``period``:
        ``thickness_stretch`` and ``thickness_stretch_rate`` at the beginning of each drive
        period.  Along ``special``: ``special_kind`` (``fold``, ``period doubling``,
        ``Neimark-Sacker``, ``branch point``), its parameter ``special_<parameter>`` and
        ``special_error``, its state, such as ``special_stretch``, and ``special_state_error``,
        ``special_amplitude``, ``special_orbit_period``: the least period of its orbit, which
        is half the branch's where this starts or ends on the branch that it doubled from, and
        ``special_branch``, 0, as there is one branch.  Along ``end``: ``end_reason``, why the
        branch ends before its first and after its last point (``bounds``, ``closed``,
        ``period doubling``, ``max_points``, ``lost``), and ``end_bound``, what reached its
        bound.  ``status`` is ``incomplete`` where an end is ``max_points``, ``lost`` or a bound
        of the state that was not asked for, or where the search for the orbit nearest to rest
        was, with the ``reason``; ``diverged`` where `over` has other combinations and there is
        no orbit to start from.

    Raises
    ------
    InputError
        A bad argument; without `over` also where there is no orbit to start from.

    See Also
    --------
    switch_branch : Follow the branch that starts at a special point of this one.
    response_diagram : All branches over the drive's frequency.
    continue_bifurcation : Follow a special point in the plane of two parameters.

    Notes
    -----
    Pseudo-arclength continuation; special points are roots of test functions along the
    branch (Kuznetsov 2004, chapter 10), located by Newton's method on the extended system.

    Examples
    --------
    >>> import remanent as rm
    >>> hot = rm.Actuator(temperature=350)
    >>> ds = rm.continue_orbit(
    ...     hot, rm.SineSquared(0.4, 1.25), "omega", (1.0, 1.6), initial=(1.433, 0.0)
    ... )
    >>> ds.special_kind.values.tolist(), float(ds.special_omega[0].round(4))
    (['fold'], 1.2668)
    """
    ens = lay_out_ensemble(system, drive, over, reserved=ORBIT_DIMENSIONS)
    require_parameter("parameter", parameter, ens)
    limits = require_parameter_range(
        "parameter_range", parameter_range, parameter, ens, "A branch is followed between them."
    )
    require_not_in_over((parameter,), ens)
    _require_start_inside(float(ens.parameter_values[parameter][0]), limits)
    options = TracingOptions(parameter, limits, state_box, orbit_period, max_points, tolerance)
    options = options.require_valid(ens)
    guess = None
    if initial is not None:
        guess = require_state(
            "initial", initial, ens, why="The branch starts near it.", fix=_INITIAL_STATE_REMEDY
        )

    def trace(member: Ensemble) -> BranchTablesOfSystem:
        tracing, value = (
            options.tracing_of_member(member),
            float(member.parameter_values[parameter][0]),
        )
        start, missing = _start_orbit(tracing, guess, value)
        branches = trace_through_orbits(tracing, start, np.array([value]))
        return describe_branches(tracing, branches, parameter, missing)

    tables = map_members_in_threads(ens, trace, as_progress(progress))
    return label_branches(ens, tables, options, single=True, parameter=parameter)


def _require_start_inside(value: float, limits: tuple[float, float]) -> None:
    """The parameter's own value, where the branch starts, is between the limits."""
    if not limits[0] <= value <= limits[1]:
        raise InputError(
            "parameter_range",
            must=f"include the field's own value, {value:g}",
            got=limits,
            why="The branch starts there.",
            fix="Change the drive or the system, or the range.",
        )


def _start_orbit(
    tracing: Tracing, guess: FloatArray | None, value: float
) -> tuple[PeriodicOrbits, str]:
    """The orbit to start from, at the parameter's own value, and why it may be the wrong one."""
    missing = ""
    if guess is None:
        (outcome,) = search_orbits(tracing.orbit_search(), np.array([[value]]))
        orbits = outcome.orbits
        if outcome.reason:
            missing = (
                "the curve starts from the orbit nearest to rest of those that were found, and "
                f"the search for them was not complete: {outcome.reason}; pass initial"
            )
        why = "None was found at the parameter's own value."
    else:
        orbits = newton_fixed_points(
            tracing.map, guess[None], np.array([[value]]), iterate=tracing.orbit_period,
            tolerance=tracing.residual_tolerance, box=tracing.state_box,
        )  # fmt: skip
        why = "Newton's method reached none from it."
    if not orbits.residual.size:
        raise InputError(
            "initial",
            must="be near a periodic orbit",
            got=guess if guess is None else guess.tolist(),
            why=why,
            fix="Widen `state_box`, or take a state from periodic_orbits.",
        )
    if guess is None:
        orbits = nearest_to_rest(orbits, tracing.map.ensemble)
    return orbits, missing
