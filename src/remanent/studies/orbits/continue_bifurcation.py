"""Curves of folds and period doublings in two parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import require_choice
from remanent._errors import InputError
from remanent._typing import ArrayLike
from remanent.analysis.orbits.continuation import ContinuationSettings, continue_curves
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.orbit_equations import bifurcation_equations
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import require_count, require_periods
from remanent.studies.ensemble.layout import lay_out
from remanent.studies.orbits._period_map import StroboscopicMap
from remanent.studies.orbits._search import box_of, require_isolated
from remanent.studies.orbits.continue_orbit import parameter_bounds

_KINDS = ("fold", "period doubling")


def continue_bifurcation(
    system: System,
    drive: Drive,
    kind: str,
    parameters: Sequence[str],
    parameter_ranges: Sequence[ArrayLike],
    *,
    initial: ArrayLike,
    orbit_period: int = 1,
    state_box: Mapping[str, Any] | None = None,
    max_points: int = 500,
    tolerance: float = 1e-8,
) -> xr.Dataset:
    """Follow a fold or a period doubling in the plane of two parameters.

    Parameters
    ----------
    system, drive
        What moves, and a periodic load; their own values are where the curve is looked for.
    kind
        ``"fold"`` or ``"period doubling"``.
    parameters
        Two numeric fields of either, such as ``("omega", "b")``.  The first is adjusted to
        reach the special point from `initial`.
    parameter_ranges
        Lowest and highest value of each.
    initial : (stretch, rate)
        A state near the special point, for example ``special_stretch`` and
        ``special_stretch_rate`` of a branch.
    orbit_period, state_box, max_points
        As for :func:`remanent.continue_orbit`.
    tolerance
        Of the residual, also of the determinant that vanishes.

    Returns
    -------
    xarray.Dataset
        Along ``point``: both parameters, the state at phase 0, ``residual``, ``error``.

    Raises
    ------
    InputError
        A bad argument, or no such point near the start.

    Notes
    -----
    Orbits with det(J − 1) = 0 or det(J + 1) = 0, by pseudo-arclength continuation
    (Kuznetsov 2004, chapter 10).  The curve of folds has a cusp where two of them meet; it
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
    require_choice("kind", kind, _KINDS)
    require_tolerance(tolerance)
    orbit_period = require_count(
        "orbit_period", orbit_period, "Orbits close after whole drive periods."
    )
    most = require_count("max_points", max_points, "A curve is made of points.")
    ens = lay_out(system, drive)
    require_periods(ens)
    require_isolated(ens)
    if len(parameters) != 2 or len(parameter_ranges) != 2 or parameters[0] == parameters[1]:
        raise InputError(
            "parameters",
            must="be two different fields, with a pair of bounds each",
            got=(parameters, parameter_ranges),
            why="A curve lies in a plane.",
            fix="Pass for example ('omega', 'b').",
        )
    limits = [
        parameter_bounds(n, b, ens) for n, b in zip(parameters, parameter_ranges, strict=True)
    ]
    box = box_of(ens, state_box)
    lower, upper = np.concatenate([box, np.array(limits)]).T
    scale = np.concatenate([np.ones(len(box)), np.ptp(np.array(limits), axis=1)])
    map_ = StroboscopicMap(ens, tuple(parameters), min(0.01 * tolerance, 1e-10))
    equations = bifurcation_equations(map_, orbit_period, kind, scale)
    own = [float(ens.values[name][0]) for name in parameters]
    guess = np.concatenate([np.asarray(initial, dtype=float).ravel(), own])[None]
    if guess.shape[1] != scale.size:
        raise InputError(
            "initial",
            must=f"be {len(box)} numbers",
            got=repr(initial),
            why="It is a state at phase 0.",
            fix="Take it from the special points of a branch.",
        )
    held = np.zeros(guess.shape)
    held[0, -1] = 1.0
    points, reached = correct_points(equations, guess, held, scale=scale, tolerance=tolerance)
    if not reached[0]:
        raise InputError(
            "initial",
            must=f"be near a {kind}",
            got=(repr(initial), own),
            why="Newton's method found none from it.",
            fix="Pass the state and parameters of a special point of a branch.",
        )
    settings = ContinuationSettings(
        lower, upper, scale, first_step=0.005, max_step=0.02, tolerance=tolerance, max_points=most
    )
    (curve,) = continue_curves(equations, points, settings)
    some, d = curve.points, len(box)
    columns = {
        **{name: some.unknown[:, d + k] for k, name in enumerate(parameters)},
        **{name: some.unknown[:, k] for k, name in enumerate(ens.field.state)},
        "residual": some.residual,
        "error": some.error,
    }
    variables: dict[str, Labelled] = {name: (("point",), v) for name, v in columns.items()}
    coords: dict[str, Labelled] = {"point": (("point",), np.arange(len(some)))}
    attributes = provenance.attributes(
        system, drive, tolerance, kind=kind, parameter_ranges=limits, orbit_period=orbit_period
    )
    return build.dataset(variables, coords, attributes)
