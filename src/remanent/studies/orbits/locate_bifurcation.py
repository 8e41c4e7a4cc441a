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
from remanent.analysis.orbits.orbit_equations import bifurcation_equations
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import require_count, require_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import Over, lay_out
from remanent.studies.orbits._period_map import StroboscopicMap

_KINDS = ("fold", "period doubling")
#: Stages in which other fields are moved from the actuator's own values.
_STAGES = 4


def locate_bifurcation(
    system: System,
    drive: Drive,
    kind: str,
    parameter: str,
    *,
    initial: ArrayLike,
    orbit_period: int = 1,
    over: Over | None = None,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """Find where a periodic orbit folds or doubles, for many values of other fields.

    Parameters
    ----------
    system, drive
        What moves, and a periodic load, near the special point.
    kind
        ``"fold"`` or ``"period doubling"``.
    parameter
        The field that is adjusted; its own value is the guess.
    initial : (stretch, rate)
        A state near the orbit at phase 0, for example ``special_stretch`` and
        ``special_stretch_rate`` of :func:`remanent.continue_orbit`.
    orbit_period
        Of the orbit, in drive periods.
    over
        Values of other fields, not far from the actuator's own; they become dimensions.
    tolerance
        Of the residual, also of the determinant that vanishes.

    Returns
    -------
    xarray.Dataset
        `parameter` at the special point, with its error; the state there; ``residual`` and
        ``status``.  NaN where Newton's method found none.

    Raises
    ------
    InputError
        A bad argument; without `over` also where there is no such point near the guess.

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
    require_choice("kind", kind, _KINDS)
    require_tolerance(tolerance)
    orbit_period = require_count(
        "orbit_period", orbit_period, "Orbits close after whole drive periods."
    )
    single = lay_out(system, drive)
    require_periods(single)
    require_choice("parameter", parameter, list(single.values))
    ens = lay_out(system, drive, over)
    if over and parameter in over:
        raise InputError(
            "over",
            must=f"not name {parameter}",
            got=repr(parameter),
            why="It is adjusted.",
            fix="Leave it out.",
        )
    state = np.asarray(initial, dtype=float).ravel()
    d = len(single.field.state)
    if state.shape != (d,) or not np.isfinite(state).all():
        raise InputError(
            "initial",
            must=f"be {d} numbers",
            got=repr(initial),
            why="It is a state at phase 0.",
            fix="Take it from the special points of a branch.",
        )
    unknown, residual, error, reached = _found(
        single, ens, kind, parameter, state, orbit_period, tolerance
    )
    if not ens.sizes and not reached[0]:
        raise InputError(
            "initial",
            must=f"be near a {kind}",
            got=repr(initial),
            why="Newton's method found none from it.",
            fix="Pass the state and the parameter of a special point of a branch.",
        )
    columns = {parameter: unknown[:, d], f"{parameter}_error": error, "residual": residual}
    columns |= {name: unknown[:, k] for k, name in enumerate(ens.field.state)}
    variables: dict[str, Labelled] = {
        name: (ens.dims, ens.shaped(np.where(reached, v, np.nan))) for name, v in columns.items()
    }
    bad = np.where(ens.invalid, Status.INVALID, Status.DIVERGED)
    status = np.where(reached, Status.OK, bad).astype(np.int8)
    variables["status"] = (ens.dims, ens.shaped(status))
    attributes = provenance.attributes(
        system, drive, tolerance, over=ens.coords, kind=kind, orbit_period=orbit_period
    )
    return build.dataset(variables, dict(ens.coords), attributes)


def _found(
    single: Ensemble,
    ens: Ensemble,
    kind: str,
    parameter: str,
    state: FloatArray,
    period: int,
    tolerance: float,
) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
    """Unknowns, residuals, errors of the parameter, and whether Newton's method converged."""
    fields = [n for n in ens.values if np.any(ens.values[n] != single.values[n])]
    fine = min(0.01 * tolerance, 1e-10)
    map_ = StroboscopicMap(single, (parameter, *fields), fine, held=fields)
    valid = np.flatnonzero(~ens.invalid)
    begin = np.array([float(single.values[n][0]) for n in fields])
    ends = np.array([ens.values[n][valid] for n in fields]).T.reshape(valid.size, len(fields))
    size = state.size + 2
    here = float(single.values[parameter][0])
    scale = np.concatenate([np.ones(state.size), [abs(here) or 1.0, 1.0]])
    guess = np.column_stack(
        [np.tile(np.append(state, here), (valid.size, 1)), np.arange(valid.size)]
    )
    held = np.tile(np.eye(size)[-1], (valid.size, 1))
    for share in np.linspace(0.0, 1.0, _STAGES + 1) if fields else [0.0]:
        numbered = _Numbered(map_, begin + share * (ends - begin))
        equations = bifurcation_equations(numbered, period, kind, scale)
        points, reached = correct_points(equations, guess, held, scale=scale, tolerance=tolerance)
        guess = np.where(reached[:, None], points.unknown, guess)
    square = equations(points.unknown).derivative[:, :, :-1]
    with np.errstate(all="ignore"):
        spread = np.abs(np.linalg.pinv(np.nan_to_num(square)))[:, state.size].sum(axis=1)
    whole = np.full((ens.count, size), np.nan)
    residual, error = np.full((2, ens.count), np.nan)
    found = np.zeros(ens.count, dtype=np.bool_)
    whole[valid], found[valid] = points.unknown, reached
    residual[valid], error[valid] = points.residual, spread * (points.residual + points.error)
    return whole, residual, error, found


@dataclass(frozen=True)
class _Numbered:
    """A map with one parameter, and the number of a point, which has other fields of its own."""

    map: StroboscopicMap
    fields: FloatArray

    @property
    def dimension(self) -> int:
        """Number of state variables."""
        return self.map.dimension

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        """Apply the map; a number next to a whole one is that, so that it has no effect."""
        own = self.fields[np.rint(parameters[:, 1]).astype(np.int64)]
        image = self.map.run(states, np.hstack([parameters[:, :1], own]), iterate)
        slope = np.pad(image.parameter_jacobian[:, :, :1], ((0, 0), (0, 0), (0, 1)))
        return MapImage(image.state, image.jacobian, slope, image.error)
