"""Where motion crosses the stable manifold of a saddle orbit, and so jumps."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import positive_rule, require_real
from remanent._errors import InputError
from remanent._status import Status
from remanent._typing import ArrayLike, ComplexArray, FloatArray
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.curves import CurvePoints
from remanent.analysis.orbits.orbit_equations import build_orbit_equations
from remanent.analysis.orbits.separatrix import (
    SaddlePassage,
    find_first_saddle_passages,
    unstable_directions,
)
from remanent.analysis.orbits.stability import Stability, floquet_multipliers, orbit_stability
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.models.actuator import Actuator
from remanent.models.system import System
from remanent.studies.ensemble.checks import (
    DriveArgument,
    require_parameter,
    require_parameter_range,
    require_state,
    require_tolerance,
)
from remanent.studies.ensemble.dataset import to_dataset
from remanent.studies.ensemble.durations import require_count, require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.observables import blank_beyond_horizon
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.orbits._checks import (
    require_not_in_over,
    require_orbit_period,
    require_state_box,
)
from remanent.studies.orbits._members import map_members_in_threads
from remanent.studies.orbits._orbit_tables import ORBIT_DIMENSIONS
from remanent.studies.orbits._period_map import StroboscopicMap, period_tolerance_for_residual
from remanent.studies.orbits._search import (
    OrbitSearch,
    is_planar,
    is_reversible,
    search_orbits,
)

#: Values inside a bracket that are tried at once: one for each lane of a kernel.
_VALUES_TRIED_AT_ONCE = 16
#: Drive periods of the first runs.
_FIRST_RUN_PERIODS = 48
#: Periods of the orbit that next runs last beyond what the last ones took.
_NEXT_RUN_EXTRA_ORBIT_PERIODS = 12
#: Distance of a saddle from the state that is passed for it, at most, in units of the state.
_MAX_DISTANCE_FROM_GUESS = 2.0
#: Residual of the saddle.
_SADDLE_RESIDUAL = 1e-11
#: Residual of the saddles that are looked for without a guess.
_SADDLE_SEARCH_RESIDUAL = 1e-9
_BRACKET_WIDTH_RULE = positive_rule(
    "It is the width of the last bracket.", "Pass for example 1e-8."
)


def manifold_crossing(
    system: System,
    drive: DriveArgument,
    parameter: str,
    parameter_range: ArrayLike,
    *,
    saddle: ArrayLike | None = None,
    initial: ArrayLike | None = None,
    orbit_period: int = 1,
    periods: int = 200,
    over: OverArgument | None = None,
    width: float = 1e-8,
    tolerance: float = 1e-6,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Find where the motion from `initial` crosses the stable manifold of a saddle orbit.

    On one side of that value the motion returns from the saddle the way it came, on the
    other it passes: this is where a response from rest jumps.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load.
    parameter : str
        A numeric field of either, such as ``"omega"``.
    parameter_range : (lowest, highest)
        Two values of it, on different sides.
    saddle : array_like (state,), optional
        A state near the saddle orbit at phase 0, at the lower value; by default the saddle
        nearest to the motion from `initial` there.
    initial : array_like (state,), optional
        State at the start; rest by default.
    orbit_period : int
        Of the saddle orbit in drive periods.
    periods : int
        Longest run in drive periods.  The nearer the crossing, the longer motion stays at
        the saddle.
    over : mapping of name to values, optional
        Values of other numeric fields; they become dimensions of the result.
    width : float
        Of the last bracket.
    tolerance : float
        Of the states along the runs: the sign of a coordinate near 0.1 needs few digits.
    progress : bool or callable, optional
        True draws a bar; a callable is called with the share of the combinations in `over`
        that are finished.

    Returns
    -------
    xarray.Dataset
        The parameter at the crossing, with ``_error``, the width of the last bracket, both of
        whose ends passed the saddle on a side that no error could change; ``stretch``,
        ``stretch_rate`` and ``multipliers`` of the saddle there, with ``error``, the largest of
        its state, and ``multipliers_error``; ``residual``, which is itself a measure of error.
        Where `over` has other combinations and this one has no saddle or no single crossing,
        NaN, ``status`` ``incomplete``, and ``reason``, what was missing; so too, with numbers,
        where the saddle is the nearest one of an incomplete search.

    Raises
    ------
    InputError
        A bad argument; without `over` also no saddle, or ends of the range that pass on the
        same side.

    See Also
    --------
    periodic_orbits : The saddle orbits.
    frequency_response : The response that jumps there.

    Notes
    -----
    The first approach to the saddle counts; later ones, of which undamped motion has many,
    do not.  The side is the sign of the coordinate along the unstable direction once it
    exceeds the rest of the distance.  Each round divides the bracket by 17.

    Examples
    --------
    >>> import remanent as rm
    >>> hot = rm.Actuator(temperature=350)
    >>> ds = rm.manifold_crossing(
    ...     hot, rm.SineSquared(0.4, 1.25), "omega", (1.25, 1.26), saddle=(1.433, 0.0), width=1e-4
    ... )
    >>> round(float(ds.omega), 3)
    1.254
    """
    tolerance = require_tolerance(tolerance, "the states along the runs")
    width = require_real("width", width, _BRACKET_WIDTH_RULE)
    orbit_period = require_orbit_period(orbit_period)
    periods = require_count("periods", periods, "The motion must have time to leave.", 3)
    ens = lay_out_ensemble(system, drive, over, initial, reserved=ORBIT_DIMENSIONS)
    require_drive_periods(ens)
    require_parameter("parameter", parameter, ens)
    limits = require_parameter_range(
        "parameter_range", parameter_range, parameter, ens, "The motion jumps between them."
    )
    require_not_in_over((parameter,), ens)
    guess = None
    if saddle is None and not isinstance(ens.system, Actuator):
        raise InputError(
            "saddle",
            must="be given for a system of one's own",
            got=saddle,
            why="Nothing says by itself in which part of the states its orbits are.",
            fix="Take one from rm.periodic_orbits(..., state_box=...).",
        )
    if saddle is not None:
        guess = require_state("saddle", saddle, ens, why="It is a state at phase 0.",
                              fix="Take one from periodic_orbits.")  # fmt: skip

    def bracket(member: Ensemble) -> _ManifoldCrossing | str:
        motions = _MotionsPastSaddle(member, parameter, orbit_period, periods, tolerance)
        try:
            return motions.bracket_crossing(limits, guess, width)
        except InputError as error:
            if not ens.dimension_sizes:
                raise
            return f"`{error.name}` must {error.must}. {error.why}"

    crossings = map_members_in_threads(ens, bracket, as_progress(progress))
    return _crossings_dataset(
        ens, crossings, parameter, tolerance=tolerance, orbit_period=orbit_period,
        periods=periods, width=width,
    )  # fmt: skip


@dataclass(frozen=True)
class _ManifoldCrossing:
    """Where motion crosses the stable manifold, with the saddle there.

    Attributes
    ----------
    parameter_value, bracket_width : float
        Middle and width of the bracket.
    saddle_state : array (state,)
    saddle_error : float
        Of its state: what the residual leaves open, and its change over the bracket.
    saddle_multipliers : array (multiplier,) of complex
    saddle_multipliers_error : array (multiplier,)
    saddle_residual : float
        Of the saddle.
    missing : str
        Why another saddle may be nearer; empty where none is.
    """

    parameter_value: float
    bracket_width: float
    saddle_state: FloatArray
    saddle_error: float
    saddle_multipliers: ComplexArray
    saddle_multipliers_error: FloatArray
    saddle_residual: float
    missing: str


@dataclass(frozen=True)
class _MotionsPastSaddle:
    """Motions of one system and its saddles at many values of the parameter.

    Attributes
    ----------
    ensemble : Ensemble
        Of one trajectory.
    parameter : str
    orbit_period : int
        Of the saddle, in drive periods.
    max_periods : int
        Longest run, in drive periods.
    state_tolerance : float
        Of the states along the runs.
    """

    ensemble: Ensemble
    parameter: str
    orbit_period: int
    max_periods: int
    state_tolerance: float

    def bracket_crossing(
        self, limits: tuple[float, float], guess: FloatArray | None, width: float
    ) -> _ManifoldCrossing:
        """Divide a range until the crossing lies in a bracket of some width."""
        state, missing = self._nearest_saddle(limits[0]) if guess is None else (guess, "")
        values = np.linspace(*limits, _VALUES_TRIED_AT_ONCE + 2)
        length = min(_FIRST_RUN_PERIODS, self.max_periods)
        while True:
            points, passage = self._pass_saddle(values, state, length)
            ends = _neighbours_on_different_sides(passage)
            if ends is None:
                if length >= self.max_periods:
                    raise _no_crossing_error(passage, limits)
                length = min(2 * length, self.max_periods)
                continue
            gap = float(values[ends[1]] - values[ends[0]])
            state = points.unknown[ends[0], :-1]
            divided = gap <= 0.5 * (values[-1] - values[0])
            if gap <= width or not divided:
                break
            latest = (
                int(passage.departure_iterate[list(ends)].max()) + _NEXT_RUN_EXTRA_ORBIT_PERIODS
            )
            length = min(latest * self.orbit_period, self.max_periods)
            values = np.linspace(values[ends[0]], values[ends[1]], _VALUES_TRIED_AT_ONCE + 2)
        at_ends = points.subset(np.array(ends))
        jacobian = at_ends.extra_arrays["jacobian"]
        multipliers, multipliers_error = floquet_multipliers(jacobian, at_ends.residual_error)
        inverse = np.linalg.inv(np.eye(state.size) - jacobian)
        defect = (at_ends.residual + at_ends.residual_error)[:, None]
        open_distance = (np.abs(inverse).sum(axis=2) * defect).max()
        across_bracket = np.abs(np.diff(at_ends.unknown[:, :-1], axis=0)).max()
        return _ManifoldCrossing(
            parameter_value=float(values[ends[0]] + 0.5 * gap),
            bracket_width=gap,
            saddle_state=state,
            saddle_error=float(open_distance + across_bracket),
            saddle_multipliers=multipliers[0],
            saddle_multipliers_error=multipliers_error.max(axis=0)
            + np.abs(multipliers[1] - multipliers[0]),
            saddle_residual=float(at_ends.residual[0]),
            missing=missing,
        )

    def _section_states(self, values: FloatArray, length: int) -> tuple[FloatArray, FloatArray]:
        """States (value, iterate, state) once per period of the orbit, and their errors."""
        start = np.tile(self.ensemble.initial_states, (values.size, 1))
        runs = self.ensemble.with_initial_states(start, {self.parameter: values})
        periods = require_drive_periods(runs)
        outcome = integrate(
            initial_value_problem(runs, length * periods),
            Request(strobe_cycles=self.orbit_period),
            tolerance=self.state_tolerance,
        )
        assert outcome.states is not None
        number = np.arange(0, length + 1, self.orbit_period)
        states = outcome.states[:, : number.size]
        states = blank_beyond_horizon(states, number * periods[:, None], outcome)
        return states, np.nan_to_num(outcome.error, nan=self.state_tolerance)

    def _nearest_saddle(self, value: float) -> tuple[FloatArray, str]:
        """The saddle nearest to the motion at a value, and why it may be the wrong one."""
        there = replace(
            self.ensemble,
            parameter_values={**self.ensemble.parameter_values, self.parameter: np.array([value])},
        )
        map_ = StroboscopicMap(there, (), period_tolerance_for_residual(_SADDLE_SEARCH_RESIDUAL))
        search = OrbitSearch(
            map_,
            require_state_box("state_box", None, there),
            self.orbit_period,
            _SADDLE_SEARCH_RESIDUAL,
            is_reversible(there.system, there.drive),
            box_is_free=not is_planar(map_),
        )
        (outcome,) = search_orbits(search, np.empty((1, 0)))
        orbits = outcome.orbits
        kinds = orbit_stability(
            *floquet_multipliers(orbits.jacobian, orbits.image_error),
            conservative=there.system.conservative,
        )
        saddles = orbits.state[kinds == Stability.SADDLE]
        if not len(saddles):
            raise InputError(
                "parameter_range",
                must="begin where there is a saddle orbit",
                got=value,
                why="Motion is told by the side on which it passes one.",
                fix="Pass `saddle`.",
            )
        states, _ = self._section_states(
            np.array([value]), min(_FIRST_RUN_PERIODS, self.max_periods)
        )
        distance = np.linalg.norm(states[0][:, None] - saddles, axis=2)
        missing = ""
        if outcome.reason:
            missing = (
                "the saddle is the nearest one of those that were found, and the search for them "
                f"was not complete: {outcome.reason}; pass saddle"
            )
        return np.asarray(saddles[np.nanmin(distance, axis=0).argmin()]), missing

    def _pass_saddle(
        self, values: FloatArray, state: FloatArray, length: int
    ) -> tuple[CurvePoints, SaddlePassage]:
        """The saddle at each value, and how the motion passes it."""
        map_ = StroboscopicMap(self.ensemble, (self.parameter,), 0.1 * _SADDLE_RESIDUAL)
        guess = np.column_stack([np.tile(state, (values.size, 1)), values])
        fixed = np.zeros(guess.shape)
        fixed[:, -1] = 1.0  # the parameter
        points, reached = correct_points(
            build_orbit_equations(map_, self.orbit_period), guess, fixed,
            scale=np.ones(guess.shape[1]), tolerance=_SADDLE_RESIDUAL,
            reach=_MAX_DISTANCE_FROM_GUESS,
        )  # fmt: skip
        jacobian = points.extra_arrays["jacobian"]
        if not reached.all() or not unstable_directions(jacobian)[2].all():
            raise InputError(
                "saddle",
                must="be near a saddle orbit throughout `parameter_range`",
                got=state.tolist(),
                why=f"Newton's method reached none within {_MAX_DISTANCE_FROM_GUESS:g} of it, or "
                "another kind of orbit.",
                fix="Pass a narrower range, or a saddle's state from periodic_orbits.",
            )
        states, error = self._section_states(values, length)
        uncertainty = error + points.residual_error + points.residual
        return points, find_first_saddle_passages(
            states, points.unknown[:, :-1], jacobian, uncertainty
        )


def _neighbours_on_different_sides(passage: SaddlePassage) -> tuple[int, int] | None:
    """Neighbours among the decided that pass on different sides: those that come nearest.

    Where motion passes far from the saddle its side means little.
    """
    decided = np.flatnonzero(passage.side_relative_to_start)
    side, distance = (
        passage.side_relative_to_start[decided],
        passage.least_distance_before_departure[decided],
    )
    change = np.flatnonzero(side[1:] != side[:-1])
    if not change.size:
        return None
    k = int(change[np.argmin(distance[change] + distance[change + 1])])
    return int(decided[k]), int(decided[k + 1])


def _no_crossing_error(passage: SaddlePassage, limits: tuple[float, float]) -> InputError:
    return InputError(
        "parameter_range",
        must="hold one crossing between its ends",
        got=limits,
        why="From its values the motion leaves on the sides "
        f"{passage.side_relative_to_start.tolist()} "
        "(1: the way it came, -1: beyond, 0: not decided).",
        fix="Move the ends nearer to the jump, or pass more `periods`.",
    )


def _crossings_dataset(
    ens: Ensemble, crossings: list[_ManifoldCrossing | str | None], parameter: str, **settings: Any
) -> xr.Dataset:
    """Crossings of all members as a Dataset; where there is none, NaN and the reason."""
    d = len(ens.vector_field.state_names)
    unknown = np.full(d, np.nan)
    nothing = _ManifoldCrossing(np.nan, np.nan, unknown, np.nan, unknown + 0j, unknown, np.nan, "")
    rows = [each if isinstance(each, _ManifoldCrossing) else nothing for each in crossings]
    saddles = np.array([row.saddle_state for row in rows])
    missing = np.where(ens.is_invalid, Status.INVALID, Status.INCOMPLETE)
    reasons = [
        each if isinstance(each, str) else row.missing
        for each, row in zip(crossings, rows, strict=True)
    ]
    dataset = to_dataset(
        ens,
        {
            parameter: np.array([row.parameter_value for row in rows]),
            f"{parameter}_error": np.array([row.bracket_width for row in rows]),
            "error": np.array([row.saddle_error for row in rows]),
            "multipliers": (("multiplier",), np.array([row.saddle_multipliers for row in rows])),
            "multipliers_error": (
                ("multiplier",),
                np.array([row.saddle_multipliers_error for row in rows]),
            ),
            "reason": np.array(reasons),
            "residual": np.array([row.saddle_residual for row in rows]),
            **{name: saddles[:, k] for k, name in enumerate(ens.vector_field.state_names)},
        },
        coords={"multiplier": (("multiplier",), np.arange(d))},
        status=np.where(ens.is_invalid | (np.array(reasons) != ""), missing, Status.OK),
        **settings,
    )
    # The drive's or the system's own value of the parameter has no part in the result.
    return dataset.assign_attrs(over=" ".join([*ens.coords, parameter]))
