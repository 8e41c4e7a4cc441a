"""Where one fold or period doubling is, for many values of other fields."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from remanent._checks import require_choice
from remanent._errors import InputError
from remanent._status import Status
from remanent._typing import ArrayLike, BoolArray, FloatArray
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.maps import MapImage
from remanent.analysis.orbits.orbit_equations import build_bifurcation_equations
from remanent.models.system import System
from remanent.studies.ensemble.checks import (
    DriveArgument,
    require_parameter,
    require_state,
    require_tolerance,
)
from remanent.studies.ensemble.dataset import to_dataset
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.orbits._checks import (
    BIFURCATION_KINDS,
    require_heat_exchange,
    require_not_in_over,
    require_orbit_period,
)
from remanent.studies.orbits._orbit_tables import ORBIT_DIMENSIONS
from remanent.studies.orbits._period_map import StroboscopicMap, period_tolerance_for_residual

#: Rounding of a number, relative to it.
_ROUNDING = 8.0 * float(np.finfo(float).eps)
#: Steps in which other fields are moved from the system's own values.
_HOMOTOPY_STEP_COUNT = 4


def locate_bifurcation(
    system: System,
    drive: DriveArgument,
    kind: str,
    parameter: str,
    *,
    initial: ArrayLike,
    orbit_period: int = 1,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """Find where a periodic orbit folds or doubles, for many values of other fields.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load.  With their own values both are near the special point.
    kind : str
        ``"fold"`` or ``"period doubling"``.
    parameter : str
        The numeric field that is adjusted; its own value is the guess.
    initial : array_like (state,)
        A state near the orbit at phase 0, for example ``special_stretch`` and
        ``special_stretch_rate`` of :func:`remanent.continue_orbit`.
    orbit_period : int
        Of the orbit, in drive periods.
    over : mapping of name to values, optional
        Values of other numeric fields, not far from the own ones; they become dimensions.
    tolerance : float
        Of the residual, also of the singular value that vanishes.

    Returns
    -------
    xarray.Dataset
        `parameter` at the special point, with its error (``omega_error`` …); the state there,
        with its ``error``; ``residual`` and ``status``.  NaN, and ``diverged``, where Newton's
        method found none.

    Raises
    ------
    InputError
        A bad argument; without `over` also where there is no such point near the guess.

    See Also
    --------
    continue_orbit : A branch, with all its special points.
    continue_bifurcation : The same point along a curve in two parameters.

    Notes
    -----
    Newton's method on the extended system of the orbit and the smallest singular value of J - 1
    (a fold) or J + 1 (a period doubling), J being the Jacobian of the map over the orbit
    (Kuznetsov 2004, chapter 10).

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.locate_bifurcation(
    ...     rm.Actuator(temperature=350),
    ...     rm.SineSquared(0.4, 1.2668),
    ...     "fold",
    ...     "omega",
    ...     initial=(1.2268, 0.0),
    ... )
    >>> float(ds.omega.round(6))
    1.266795
    """
    require_choice("kind", kind, BIFURCATION_KINDS)
    tolerance = require_tolerance(tolerance, "the residual")
    orbit_period = require_orbit_period(orbit_period)
    single = lay_out_ensemble(system, drive)
    require_drive_periods(single)
    require_parameter("parameter", parameter, single)
    ens = lay_out_ensemble(system, drive, over, reserved=ORBIT_DIMENSIONS)
    require_heat_exchange(ens)
    require_not_in_over((parameter,), ens)
    state = require_state(
        "initial", initial, ens, why="The special point is looked for from there.",
        fix="Take it from the special points of a branch.",
    )  # fmt: skip
    outcome = _locate_in_all_members(
        single, ens, _BifurcationTarget(kind, parameter, state, orbit_period, tolerance)
    )
    if not ens.dimension_sizes and not outcome.has_converged[0]:
        raise InputError(
            "initial",
            must=f"be near a {kind}",
            got=state.tolist(),
            why="Newton's method found none from it.",
            fix="Pass the state and the parameter of a special point of a branch.",
        )
    columns = {
        parameter: outcome.unknowns[:, state.size],
        f"{parameter}_error": outcome.parameter_error,
        "residual": outcome.residual,
        "error": outcome.state_error,
        **{name: outcome.unknowns[:, k] for k, name in enumerate(ens.vector_field.state_names)},
    }
    missing = np.where(ens.is_invalid, Status.INVALID, Status.DIVERGED)
    return to_dataset(
        ens, {name: np.where(outcome.has_converged, v, np.nan) for name, v in columns.items()},
        status=np.where(outcome.has_converged, Status.OK, missing), tolerance=tolerance, kind=kind,
        orbit_period=orbit_period,
    )  # fmt: skip


@dataclass(frozen=True)
class _BifurcationTarget:
    """The special point that is looked for, and from where."""

    kind: str
    parameter: str
    initial_state: FloatArray
    orbit_period: int
    tolerance: float


@dataclass(frozen=True)
class _LocatedBifurcations:
    """What was reached for each member.

    Attributes
    ----------
    unknowns : array (member, state + 2)
        State, parameter, and the number of the member.
    residual, parameter_error, state_error : array (member,)
        The error of the state is that of its worst variable.
    has_converged : array (member,) of bool
        Whether Newton's method converged.
    """

    unknowns: FloatArray
    residual: FloatArray
    parameter_error: FloatArray
    state_error: FloatArray
    has_converged: BoolArray


def _locate_in_all_members(
    single: Ensemble, ens: Ensemble, target: _BifurcationTarget
) -> _LocatedBifurcations:
    """The special point of every member, all together, moved there from the system's own."""
    # Named, not compared by value: whether a field counts as varied must not depend on the
    # values of other members.
    fields = [name for name in ens.coords if name in ens.parameter_values]
    held = tuple(fields)
    map_ = StroboscopicMap(
        single,
        (target.parameter, *fields),
        period_tolerance_for_residual(target.tolerance, 0.01),
        undifferentiated_parameter_names=held,
    )
    members = np.flatnonzero(~ens.is_invalid)
    size = target.initial_state.size + 2
    located = _LocatedBifurcations(
        np.full((ens.trajectory_count, size), np.nan), np.full(ens.trajectory_count, np.nan),
        np.full(ens.trajectory_count, np.nan), np.full(ens.trajectory_count, np.nan),
        np.zeros(ens.trajectory_count, dtype=np.bool_),
    )  # fmt: skip
    if not members.size:
        return located
    begin = np.array([float(single.parameter_values[name][0]) for name in fields])
    end = np.array([ens.parameter_values[name][members] for name in fields]).T
    end = end.reshape(members.size, len(fields))
    value = float(single.parameter_values[target.parameter][0])
    scale = np.concatenate([np.ones(target.initial_state.size), [abs(value) or 1.0, 1.0]])
    start = np.tile(np.append(target.initial_state, value), (members.size, 1))
    guess = np.column_stack([start, np.arange(members.size)])
    fixed = np.tile(np.eye(size)[-1], (members.size, 1))  # the number of the member
    for share in np.linspace(0.0, 1.0, _HOMOTOPY_STEP_COUNT + 1) if fields else [0.0]:
        numbered = _MemberNumberMap(map_, begin + share * (end - begin))
        for by_determinant in (True, False):
            equations = build_bifurcation_equations(
                numbered, target.orbit_period, target.kind, scale, by_determinant=by_determinant
            )
            points, reached = correct_points(
                equations, guess, fixed, scale=scale, tolerance=target.tolerance
            )
            reached &= _is_possible(single, target.parameter, points.unknown)
            guess = np.where(reached[:, None], points.unknown, guess)
    defect = points.residual[:, None] + points.extra_arrays["equation_error"]
    square = points.extra_arrays["derivative"][:, :, :-1] * scale[:-1]
    with np.errstate(all="ignore"):
        inverse = np.abs(np.linalg.pinv(np.nan_to_num(square)))
    error = np.einsum("pij,pj->pi", inverse, defect) * scale[:-1]
    error += _ROUNDING * np.abs(points.unknown[:, :-1])
    located.unknowns[members], located.has_converged[members] = points.unknown, reached
    located.residual[members] = points.residual
    located.parameter_error[members] = error[:, -1]
    located.state_error[members] = error[:, :-1].max(axis=1)
    return located


def _is_possible(ens: Ensemble, parameter: str, unknowns: FloatArray) -> BoolArray:
    """Whether the system and its drive allow the parameter, and the body the state."""
    values = {parameter: unknowns[:, -2]}
    is_forbidden = ens.system.where_invalid(values) | ens.drive.where_invalid(values)
    positive = [variable.positive for variable in ens.vector_field.variables]
    return np.asarray(~is_forbidden & (unknowns[:, : len(positive)][:, positive] > 0.0).all(axis=1))


@dataclass(frozen=True)
class _MemberNumberMap:
    """A map of one parameter and of the number of a member, which has its own fields.

    Curves have two parameters; here the second only says which member a point belongs to.

    Attributes
    ----------
    map : StroboscopicMap
        Of the parameter and of the fields.
    member_field_values : array (member, field)
    """

    map: StroboscopicMap
    member_field_values: FloatArray

    @property
    def dimension(self) -> int:
        """Number of state variables."""
        return self.map.dimension

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        """Apply the map.

        The number is rounded, so that a finite difference in it changes nothing.
        """
        rows = self.member_field_values[np.rint(parameters[:, 1]).astype(np.int64)]
        image = self.map.run(states, np.hstack([parameters[:, :1], rows]), iterate)
        slope = np.pad(image.parameter_jacobian[:, :, :1], ((0, 0), (0, 0), (0, 1)))
        return MapImage(image.state, image.jacobian, slope, image.error)
