"""Where motion crosses the stable manifold of a saddle orbit, and so jumps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from remanent._checks import positive, require_real
from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.curves import CurvePoints
from remanent.analysis.orbits.orbit_equations import orbit_equations
from remanent.analysis.orbits.separatrix import SaddlePassage, saddle_passages, unstable_direction
from remanent.analysis.orbits.stability import floquet_multipliers
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import require_count, require_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import lay_out
from remanent.studies.motion.poincare_section import poincare_section
from remanent.studies.orbits._period_map import StroboscopicMap
from remanent.studies.orbits.continue_orbit import parameter_bounds
from remanent.studies.orbits.periodic_orbits import periodic_orbits

#: Values tried at once: one for each lane of a kernel.
_TRIED = 16
#: Drive periods of the first run, and of the next ones beyond what the last one took.
_FIRST, _MORE = 48, 12
#: Of the saddle's residual.
_RESIDUAL = 1e-11
_WIDTH = positive("It is the width of the last bracket.", "Pass for example 1e-8.")


def manifold_crossing(
    system: System,
    drive: Drive,
    parameter: str,
    parameter_range: ArrayLike,
    *,
    saddle: ArrayLike | None = None,
    initial: ArrayLike | None = None,
    orbit_period: int = 1,
    periods: int = 200,
    width: float = 1e-8,
    tolerance: float = 1e-6,
) -> xr.Dataset:
    """Find where the motion from `initial` crosses the stable manifold of a saddle orbit.

    On one side of that value the motion returns from the saddle the way it came, on the
    other it passes: this is where a response from rest jumps.

    Parameters
    ----------
    system, drive
        What moves, and a periodic load.
    parameter
        A numeric field of either, such as ``"omega"``.
    parameter_range
        Two values of it, on different sides.
    saddle : (stretch, rate), optional
        A state near the saddle orbit at phase 0, at the lower value; by default the saddle
        nearest to the motion from `initial` there.
    initial
        State at the start; rest by default.
    orbit_period
        Of the saddle orbit in drive periods.
    periods
        Longest run in drive periods.  The nearer the crossing, the longer motion stays at
        the saddle.
    width
        Of the last bracket.
    tolerance
        Of the states along the runs: the sign of a coordinate near 0.1 needs few digits.

    Returns
    -------
    xarray.Dataset
        The parameter at the crossing, with ``_error``, the width of the last bracket, both of
        whose ends passed the saddle on a side that no error could change; ``stretch``,
        ``stretch_rate`` and ``multipliers`` of the saddle there; ``residual``.

    Raises
    ------
    InputError
        A bad argument, no saddle, or ends of the bracket that pass on the same side.

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
    require_tolerance(tolerance)
    width = require_real("width", width, _WIDTH)
    every = require_count("orbit_period", orbit_period, "Orbits close after whole drive periods.")
    periods = require_count("periods", periods, "The motion must have time to leave.", 3)
    ens = lay_out(system, drive, None, initial)
    require_periods(ens)
    low, high = parameter_bounds(parameter, parameter_range, ens)
    runs = _Runs(ens, parameter, every, periods, tolerance)
    state = runs.guess(low) if saddle is None else np.asarray(saddle, dtype=float).ravel()
    if state.size != len(ens.field.state):
        raise InputError(
            "saddle",
            must=f"be {len(ens.field.state)} numbers",
            got=repr(saddle),
            why="It is a state at phase 0.",
            fix="Take one from periodic_orbits.",
        )
    values = np.linspace(low, high, _TRIED + 2)
    length = min(_FIRST, periods)
    while True:
        points, passage = runs.passed(values, state, length)
        ends = _change(passage)
        if ends is None and length < periods:
            length = min(2 * length, periods)
            continue
        if ends is None:
            raise InputError(
                "parameter_range",
                must="hold one crossing between its ends",
                got=(low, high),
                why=f"From its values the motion leaves on the sides {passage.side.tolist()} "
                "(1: the way it came, -1: beyond, 0: not decided).",
                fix="Move the ends nearer to the jump, or pass more `periods`.",
            )
        gap = float(values[ends[1]] - values[ends[0]])
        state = points.unknown[ends[0], :-1]
        if gap <= width or gap > 0.5 * (values[-1] - values[0]):
            break
        length = min(
            int(passage.iterate[list(ends)].max()) * orbit_period + _MORE * orbit_period, periods
        )
        values = np.linspace(values[ends[0]], values[ends[1]], _TRIED + 2)
    there = points.subset(slice(ends[0], ends[0] + 1))
    return _labelled(runs, values[ends[0]] + 0.5 * gap, gap, there, width)


@dataclass(frozen=True)
class _Runs:
    """Motions and saddles at many values of the parameter."""

    ens: Ensemble
    parameter: str
    period: int
    periods: int
    tolerance: float

    def visited(self, values: FloatArray, length: int) -> tuple[FloatArray, FloatArray]:
        """States (value, iterate, state) once per period of the orbit, and their errors."""
        run = poincare_section(
            self.ens.system, self.ens.drive, periods=length, every=self.period,
            over={self.parameter: values}, initial=self.ens.initial[0], tolerance=self.tolerance,
        )  # fmt: skip
        states = np.stack([run[name].values for name in self.ens.field.state], axis=-1)
        return states, np.nan_to_num(run["error"].values, nan=self.tolerance)

    def guess(self, value: float) -> FloatArray:
        """The saddle nearest to the motion at a value."""
        found = periodic_orbits(
            self.ens.system,
            self.ens.drive,
            orbit_period=self.period,
            over={self.parameter: [value]},
        ).isel({self.parameter: 0})
        saddles = found["initial"].values[found["stability"].values == "saddle"]
        if not len(saddles):
            raise InputError(
                "bracket",
                must="begin where there is a saddle orbit",
                got=value,
                why="Motion is told by the side on which it passes one.",
                fix="Pass `saddle`.",
            )
        states, _ = self.visited(np.array([value]), min(_FIRST, self.periods))
        distance = np.linalg.norm(states[0][:, None] - saddles, axis=2)
        return np.asarray(saddles[np.nanmin(distance, axis=0).argmin()])

    def passed(
        self, values: FloatArray, state: FloatArray, length: int
    ) -> tuple[CurvePoints, SaddlePassage]:
        """The saddle at each value, and how the motion passes it."""
        map_ = StroboscopicMap(self.ens, (self.parameter,), 0.1 * _RESIDUAL)
        guess = np.column_stack([np.tile(state, (values.size, 1)), values])
        held = np.zeros(guess.shape)
        held[:, -1] = 1.0
        points, reached = correct_points(
            orbit_equations(map_, self.period), guess, held,
            scale=np.ones(guess.shape[1]), tolerance=_RESIDUAL,
        )  # fmt: skip
        jacobian = points.extra["jacobian"]
        if not reached.all() or not unstable_direction(jacobian)[2].all():
            raise InputError(
                "saddle",
                must="be near a saddle orbit throughout the bracket",
                got=state.tolist(),
                why="Newton's method reached none, or another kind of orbit.",
                fix="Pass a narrower bracket, or a saddle's state from periodic_orbits.",
            )
        states, error = self.visited(values, length)
        both = error + points.error + points.residual
        return points, saddle_passages(states, points.unknown[:, :-1], jacobian, both)


def _change(passage: SaddlePassage) -> tuple[int, int] | None:
    """Neighbours among the decided that pass on different sides: those that come nearest.

    Where motion passes far from the saddle its side means little.
    """
    decided = np.flatnonzero(passage.side)
    side, near = passage.side[decided], passage.nearest[decided]
    change = np.flatnonzero(side[1:] != side[:-1])
    if not change.size:
        return None
    k = int(change[np.argmin(near[change] + near[change + 1])])
    return int(decided[k]), int(decided[k + 1])


def _labelled(
    runs: _Runs, value: float, gap: float, points: CurvePoints, width: float
) -> xr.Dataset:
    known, _ = floquet_multipliers(points.extra["jacobian"], points.error)
    variables: dict[str, Labelled] = {
        runs.parameter: ((), np.array(value)),
        f"{runs.parameter}_error": ((), np.array(gap)),
        "multipliers": (("multiplier",), known[0]),
        "residual": ((), points.residual[0]),
    }
    for k, name in enumerate(runs.ens.field.state):
        variables[name] = ((), points.unknown[0, k])
    coords: dict[str, Labelled] = {"multiplier": (("multiplier",), np.arange(known.shape[1]))}
    attributes = provenance.attributes(
        runs.ens.system, runs.ens.drive, runs.tolerance, over=(runs.parameter,),
        orbit_period=runs.period, periods=runs.periods, width=width,
    )  # fmt: skip
    return build.dataset(variables, coords, attributes)
