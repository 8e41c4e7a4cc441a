"""Curves of folds and period doublings in the plane of two parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._checks import require_choice, shortened_repr
from remanent._errors import InputError
from remanent._status import Status
from remanent._typing import ArrayLike, FloatArray
from remanent.analysis.orbits.continuation import ContinuationSettings, continue_curves
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.curve_errors import errors_at_fixed_unknown
from remanent.analysis.orbits.curves import Curve
from remanent.analysis.orbits.orbit_equations import build_bifurcation_equations
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import (
    DriveArgument,
    require_parameter,
    require_parameter_range,
    require_state,
    require_tolerance,
)
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.durations import require_count, require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.orbits._branch_ends import (
    END_LABELS,
    CurveEnds,
    ends_of_curves,
    member_status,
    stack_ends,
)
from remanent.studies.orbits._checks import (
    BIFURCATION_KINDS,
    require_heat_exchange,
    require_not_in_over,
    require_orbit_period,
    require_state_box,
)
from remanent.studies.orbits._curve_ends import clip_to_bounds
from remanent.studies.orbits._members import map_members_in_threads, stack_tables
from remanent.studies.orbits._orbit_tables import ORBIT_DIMENSIONS
from remanent.studies.orbits._period_map import StroboscopicMap, period_tolerance_for_residual
from remanent.studies.orbits._tracing import FIRST_CONTINUATION_STEP, LONGEST_CONTINUATION_STEP

#: Largest resolution of the map, double steps per period, at least.
_FINEST_RESOLUTION = 1024
#: The same per unit of time of the drive's period.
_FINEST_RESOLUTION_PER_TIME = 32.0


def continue_bifurcation(
    system: System,
    drive: DriveArgument,
    kind: str,
    parameters: Sequence[str],
    parameter_ranges: Sequence[ArrayLike],
    *,
    initial: ArrayLike,
    orbit_period: int = 1,
    state_box: Mapping[str, Any] | None = None,
    over: OverArgument | None = None,
    max_points: int = 500,
    tolerance: float = 1e-8,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Follow a fold or a period doubling in the plane of two parameters.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load.  The own values of both are where the curve is looked for.
    kind : str
        ``"fold"`` or ``"period doubling"``.
    parameters : (str, str)
        Two numeric fields of either, such as ``("omega", "b")``.  The first is adjusted to
        reach the special point from `initial`.
    parameter_ranges : ((lowest, highest), (lowest, highest))
        Values of each between which the curve is followed.
    initial : array_like (state,)
        A state near the special point at phase 0, for example ``special_stretch`` and
        ``special_stretch_rate`` of a branch.
    orbit_period : int
        Of the orbit, in drive periods.
    state_box : mapping of name to (lower, upper), optional
        Range of each state variable at phase 0, such as ``{"stretch": (0.3, 4.0)}``; the
        curve ends where it leaves the box.  By default stretches from 0.3 to 4, rates from
        −8 to 8, temperatures up to 5 K from that of the surroundings.
    over : mapping of name to values, optional
        Values of other numeric fields; they become dimensions of the result.  Each curve
        starts near `initial`.
    max_points : int
        In each direction from the start.
    tolerance : float
        Of the residual, also of the singular value that vanishes.
    progress : bool or callable, optional
        True draws a bar; a callable is called with the share of the combinations in `over`
        that are finished.

    Returns
    -------
    xarray.Dataset
        Along ``point``: both parameters with their errors (``omega_error``, ``b_error`` …), that
        of each at the other one as it is; the state at phase 0 and its ``error``;
        ``residual``.  Along ``end``: ``end_reason``, why the curve ends before its first and
        after its last point (``bounds``, ``closed``, ``max_points``, ``lost``), and
        ``end_bound``, what reached its bound.  ``status`` is ``incomplete`` where an end is
        ``max_points``, ``lost`` or a bound of the state that was not asked for, with the
        ``reason``; ``diverged`` where `over` has other combinations and no special point is
        near `initial`.

    Raises
    ------
    InputError
        A bad argument; without `over` also where no such point is near `initial`.

    See Also
    --------
    locate_bifurcation : One such point, for many values of other fields.
    continue_orbit : A branch, with its special points.

    Notes
    -----
    Orbits with det(J − 1) = 0 or det(J + 1) = 0, by pseudo-arclength continuation
    (Kuznetsov 2004, chapter 10).  In place of the determinant its smallest factor is taken, the
    smallest singular value of J ∓ 1.  The curve of folds has a cusp where two of them meet; it
    is passed without notice, as all unknowns are smooth along it.

    Examples
    --------
    >>> import remanent as rm
    >>> hot = rm.Actuator(temperature=350)
    >>> ds = rm.continue_bifurcation(
    ...     hot,
    ...     rm.SineSquared(0.4, 1.2668),
    ...     "fold",
    ...     ("omega", "b"),
    ...     [(1.0, 1.45), (0.2, 0.6)],
    ...     initial=(1.2268, 0.0),
    ... )
    >>> bool(ds.residual.max() < 1e-8), ds.omega.size > 20
    (True, True)
    """
    require_choice("kind", kind, BIFURCATION_KINDS)
    tolerance = require_tolerance(tolerance, "the residual")
    orbit_period = require_orbit_period(orbit_period)
    max_points = require_count("max_points", max_points, "A curve is made of points.")
    ens = lay_out_ensemble(system, drive, over, reserved=ORBIT_DIMENSIONS)
    require_drive_periods(ens)
    require_heat_exchange(ens)
    names, limits = _require_two_parameters(parameters, parameter_ranges, ens)
    require_state_box("state_box", state_box, ens)
    state = require_state(
        "initial", initial, ens, why="The special point is looked for from there.",
        fix="Take it from the special points of a branch.",
    )  # fmt: skip

    def trace(member: Ensemble) -> tuple[dict[str, NDArray[Any]], CurveEnds]:
        box = require_state_box("state_box", state_box, member)
        plane = _ParameterPlane(member, names, limits, box, orbit_period, tolerance, max_points)
        curve = plane.trace_bifurcation(kind, state)
        unknown_names = [*field.state_names, *names]
        return plane.columns(curve), ends_of_curves([curve], unknown_names)

    field = ens.vector_field
    traced = map_members_in_threads(ens, trace, as_progress(progress))
    columns = stack_tables(
        [None if one is None else one[0] for one in traced],
        dict.fromkeys(_column_names(field.state_names, names), np.empty(0)),
    )
    ends = [None if one is None else one[1] for one in traced]
    both = stack_ends(ends, 1)
    variables: dict[str, PerTrajectoryArray] = {
        **{name: (("point",), column) for name, column in columns.items()},
        "end_reason": (("end",), both.reasons[:, 0]),
        "end_bound": (("end",), both.bounds[:, 0]),
    }
    coords: dict[str, Labelled] = {
        "point": (("point",), np.arange(columns["residual"].shape[1])),
        "end": (("end",), np.array(END_LABELS)),
    }
    status, variables["reason"] = member_status(
        ens, ends, Status.DIVERGED, set(field.state_names) - set(state_box or {})
    )
    return to_dataset(
        ens, variables, coords=coords, status=status,
        tolerance=tolerance, kind=kind, parameter_ranges=limits, orbit_period=orbit_period,
    )  # fmt: skip


def _require_two_parameters(
    parameters: Sequence[str], ranges: Sequence[ArrayLike], ens: Ensemble
) -> tuple[tuple[str, str], list[tuple[float, float]]]:
    """Two different fields and their ranges."""
    for name, pair, what, example in (
        ("parameters", parameters, "different fields", "('omega', 'b')"),
        ("parameter_ranges", ranges, "ranges", "[(1.0, 1.4), (0.2, 0.6)]"),
    ):
        if not _is_distinct_pair(pair):
            raise InputError(
                name,
                must=f"be two {what}",
                got=shortened_repr(pair),
                why="A curve lies in a plane.",
                fix=f"Pass for example {example}.",
            )
    first, second = (require_parameter("parameters", name, ens) for name in parameters)
    require_not_in_over((first, second), ens)
    limits = [
        require_parameter_range(
            "parameter_ranges", pair, name, ens, "The curve is followed between them."
        )
        for name, pair in zip(parameters, ranges, strict=True)
    ]
    return (first, second), limits


def _is_distinct_pair(value: object) -> bool:
    """Whether `value` is a sequence of two entries that are not the same."""
    if not isinstance(value, Sequence | np.ndarray) or isinstance(value, str):
        return False
    if np.shape(value)[:1] != (2,) if isinstance(value, np.ndarray) else len(value) != 2:
        return False
    return not (isinstance(value[0], str) and value[0] == value[1])


@dataclass(frozen=True)
class _ParameterPlane:
    """The plane of two parameters of one system, in which a curve is followed.

    Attributes
    ----------
    ensemble : Ensemble
        Of one trajectory.
    parameters : (str, str)
    parameter_ranges : two of (float, float)
    state_box : array (state, 2)
    orbit_period : int
    tolerance : float
    max_points : int
    """

    ensemble: Ensemble
    parameters: tuple[str, str]
    parameter_ranges: list[tuple[float, float]]
    state_box: FloatArray
    orbit_period: int
    tolerance: float
    max_points: int

    @property
    def continuation_settings(self) -> ContinuationSettings:
        """Bounds, scale and steps of the continuation."""
        lower, upper = np.concatenate([self.state_box, np.array(self.parameter_ranges)]).T
        scale = np.concatenate(
            [np.ones(len(self.state_box)), np.ptp(np.array(self.parameter_ranges), axis=1)]
        )
        return ContinuationSettings(
            lower, upper, scale,
            first_step_length=FIRST_CONTINUATION_STEP, max_step_length=LONGEST_CONTINUATION_STEP,
            tolerance=self.tolerance, max_points=self.max_points,
        )  # fmt: skip

    @property
    def _finest_resolution(self) -> int:
        """Largest resolution of the map: where motions part fast, finer steps only add rounding."""
        longest = float(require_drive_periods(self.ensemble).max())
        return max(_FINEST_RESOLUTION, int(_FINEST_RESOLUTION_PER_TIME * longest))

    def columns(self, curve: Curve) -> dict[str, NDArray[Any]]:
        """Columns along a curve, with the errors of its points.

        The error of each parameter is that at the other one as it is; that of the state is the
        larger one of these two ways.
        """
        points, scale = curve.points, self.continuation_settings.scale
        value_error = points.extra_arrays["equation_error"]
        first, second = -2, -1
        at_second = errors_at_fixed_unknown(points, value_error, scale, second)
        at_first = errors_at_fixed_unknown(points, value_error, scale, first)
        values = [
            points.unknown[:, first], points.unknown[:, second], *points.unknown[:, :first].T,
            at_second[:, first], at_first[:, second], points.residual,
            np.maximum(at_first, at_second)[:, :first].max(axis=1),
        ]  # fmt: skip
        names = _column_names(self.ensemble.vector_field.state_names, self.parameters)
        return dict(zip(names, values, strict=True))

    def trace_bifurcation(self, kind: str, state: FloatArray) -> Curve:
        """The curve through the special point nearest to a state, at the system's own values."""
        settings = self.continuation_settings
        # The determinant of the Jacobian has to be right, so the map is more precise than
        # for a branch.
        map_ = StroboscopicMap(
            self.ensemble, self.parameters, period_tolerance_for_residual(self.tolerance, 0.01),
            finest_resolution=self._finest_resolution,
        )  # fmt: skip
        equations = build_bifurcation_equations(map_, self.orbit_period, kind, settings.scale)
        values = [float(self.ensemble.parameter_values[name][0]) for name in self.parameters]
        guess = np.concatenate([state, values])[None]
        fixed = np.zeros(guess.shape)
        fixed[0, -1] = 1.0  # the second parameter
        points, reached = correct_points(
            equations, guess, fixed, scale=settings.scale, tolerance=self.tolerance
        )
        if not reached[0]:
            raise InputError(
                "initial",
                must=f"be near a {kind}",
                got=(state.tolist(), values),
                why="Newton's method found none from it.",
                fix="Pass the state and parameters of a special point of a branch.",
            )
        (curve,) = continue_curves(equations, points, settings)
        return clip_to_bounds(equations, curve, settings)


def _column_names(state_names: Sequence[str], parameters: tuple[str, str]) -> list[str]:
    """Of the columns along a curve."""
    errors = [f"{name}_error" for name in parameters]
    return [*parameters, *state_names, *errors, "residual", "error"]
