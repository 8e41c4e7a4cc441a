"""Branches of periodic orbits: one, or all of a forced response."""

from __future__ import annotations

import os
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import xarray as xr

from remanent._checks import require_choice
from remanent._errors import InputError
from remanent._status import Status
from remanent._typing import ArrayLike, FloatArray
from remanent.analysis.orbits.periodic_orbits import Orbits, newton_fixed_points
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import require_count, require_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import Over, lay_out
from remanent.studies.ensemble.progress import Progress, as_progress
from remanent.studies.orbits._period_map import DIMENSIONS, StroboscopicMap
from remanent.studies.orbits._search import (
    Search,
    all_orbits,
    box_of,
    is_symmetric,
    nearest_rest,
    require_isolated,
)
from remanent.studies.orbits._tracing import Branch, Tracing, everywhere, through
from remanent.studies.orbits.periodic_orbits import described


def continue_orbit(
    system: System,
    drive: Drive,
    parameter: str,
    parameter_range: ArrayLike,
    *,
    initial: ArrayLike | None = None,
    orbit_period: int = 1,
    state_box: Mapping[str, Any] | None = None,
    max_points: int = 1000,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """Follow a periodic orbit while a parameter changes, through folds, both ways.

    Parameters
    ----------
    system, drive
        What moves, and a periodic load.
    parameter
        A numeric field of either, such as ``"omega"``, ``"b"``, ``"temperature"`` or
        ``"dissipation.0.eta"``.
    parameter_range
        Its lowest and highest value.
    initial : (stretch, rate), optional
        A state near the orbit at phase 0, for the field's own value; by default the orbit
        nearest to rest.
    orbit_period
        Of the orbit, in drive periods.
    state_box
        The branch ends where the state at phase 0 leaves them; as `parameter_range` of
        :func:`remanent.periodic_orbits`.
    max_points
        In each direction from the start.
    tolerance
        Of the residual.

    Returns
    -------
    xarray.Dataset
        Along ``point``: the parameter, the state at phase 0, ``multipliers``,
        ``stability``, ``amplitude``, ``maximum``, ``minimum``, ``residual``, ``error``;
        along ``special``: ``special_kind`` (``fold``, ``period doubling``,
        ``Neimark-Sacker``, ``branch point``), its parameter, state and error.

    Raises
    ------
    InputError
        A bad argument, or no orbit to start from.

    Notes
    -----
    Pseudo-arclength continuation; special points are roots of test functions along the
    branch (Kuznetsov 2004, chapter 10), located with the map's own accuracy.

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
    ens = lay_out(system, drive)
    low, high = parameter_bounds(parameter, parameter_range, ens)
    tracing = trace_with(
        ens, parameter, (low, high), state_box, orbit_period, max_points, tolerance
    )
    value = float(ens.values[parameter][0])
    orbit = _start(tracing, initial, value)
    branches = through(tracing, orbit, np.array([value]))
    found = [describe_branches(ens.member(0), branches, parameter, orbit_period)]
    settings = {
        "parameter": parameter,
        "parameter_range": (low, high),
        "orbit_period": orbit_period,
    }
    return label_branches(ens, found, parameter, tolerance, settings).isel(branch=0, drop=True)


def response_diagram(
    system: System,
    drive: Drive,
    omega_range: ArrayLike,
    *,
    state_box: Mapping[str, Any] | None = None,
    orbit_period: int = 1,
    over: Over | None = None,
    slices: int = 9,
    max_points: int = 2000,
    tolerance: float = 1e-9,
    progress: Progress = None,
) -> xr.Dataset:
    """All branches of forced response over the drive's frequency, stable and unstable.

    Parameters
    ----------
    system, drive
        What moves, and a drive with a field ``omega``, whose value is not used.
    omega_range
        Lowest and highest frequency, radians per unit of tau.
    state_box
        Of the state at phase 0, as for :func:`remanent.periodic_orbits`: undamped branches
        run off to infinite amplitude.
    orbit_period
        Of the orbits in drive periods.
    over
        Values of other numeric fields; they become dimensions of the result.
    slices
        At how many frequencies orbits are looked for.  A branch (an isola) that passes
        none of them is missed.
    max_points, tolerance
        As for :func:`remanent.continue_orbit`.
    progress
        Called with the share of the combinations in `over` that are finished.

    Returns
    -------
    xarray.Dataset
        As that of :func:`remanent.continue_orbit`, along ``branch`` and ``point``, and
        ``special`` with ``special_branch``; padded with NaN where there are fewer.

    Raises
    ------
    InputError
        A bad argument, or a drive without ``omega``.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.response_diagram(rm.Actuator(temperature=350), rm.SineSquared(0.4, 1.0), (1.1, 1.4))
    >>> [round(float(w), 4) for w in ds.special_omega[ds.special_kind == "fold"]]
    [1.2668]
    """
    whole = dict(over or {})
    ens = lay_out(system, drive, whole, reserved=DIMENSIONS)
    low, high = parameter_bounds("omega", omega_range, ens)
    slices = require_count("slices", slices, "Orbits are looked for at each of them.")
    report = as_progress(progress)
    done: list[int] = []

    def one(k: int) -> dict[str, Any]:
        own = ens.member(k)
        if ens.invalid[k]:
            return {}
        own.values["omega"] = np.array([0.5 * (low + high)])
        tracing = trace_with(
            own, "omega", (low, high), state_box, orbit_period, max_points, tolerance
        )
        symmetric = is_symmetric(system, drive)
        search = Search(tracing.map, tracing.box, orbit_period, tolerance, symmetric, dense=False)
        found = describe_branches(own, everywhere(tracing, search, slices), "omega", orbit_period)
        done.append(k)
        if report is not None:
            report(len(done) / ens.count)
        return found

    with ThreadPoolExecutor(min(os.cpu_count() or 1, ens.count)) as pool:
        found = list(pool.map(one, range(ens.count)))
    settings = {"parameter_range": (low, high), "orbit_period": orbit_period, "slices": slices}
    return label_branches(ens, found, "omega", tolerance, settings)


def parameter_bounds(parameter: str, bounds: ArrayLike, ens: Ensemble) -> tuple[float, float]:
    """The lowest and the highest value of a field; raises what is wrong with them."""
    require_choice("parameter", parameter, list(ens.values))
    pair = np.asarray(bounds, dtype=float)
    if pair.shape != (2,) or not np.isfinite(pair).all() or not pair[0] < pair[1]:
        raise InputError(
            "parameter_range",
            must=f"be the lowest and the highest value of {parameter}",
            got=repr(bounds),
            why="A branch is followed between them.",
            fix="Pass two increasing numbers.",
        )
    for value in pair:
        broken = ens.system.invalid({parameter: value}) | ens.drive.invalid({parameter: value})
        if broken.any():
            raise InputError(
                "parameter_range",
                must=f"be possible values of {parameter}",
                got=float(value),
                why="Orbits are computed up to them.",
                fix="Pass values within the field's own range.",
            )
    return float(pair[0]), float(pair[1])


def trace_with(
    ens: Ensemble,
    parameter: str,
    bounds: tuple[float, float],
    state_bounds: Mapping[str, Any] | None,
    period: int,
    max_points: int,
    tolerance: float,
) -> Tracing:
    """How branches are followed over one parameter; raises what is wrong with the settings."""
    require_tolerance(tolerance)
    require_periods(ens)
    require_isolated(ens)
    return Tracing(
        map=StroboscopicMap(ens, (parameter,), min(0.1 * tolerance, 1e-10)),
        box=box_of(ens, state_bounds),
        bounds=bounds,
        period=require_count("period", period, "Orbits close after whole drive periods."),
        tolerance=tolerance,
        most=require_count("max_points", max_points, "A branch is made of points."),
        conservative=ens.system.conservative,
    )


def _start(tracing: Tracing, start: ArrayLike | None, value: float) -> Orbits:
    """The orbit to start from, at the field's own value."""
    ens, (low, high) = tracing.map.ensemble, tracing.bounds
    if not low <= value <= high:
        raise InputError(
            "parameter_range",
            must=f"include the field's own value, {value:g}",
            got=(low, high),
            why="The branch starts there.",
            fix="Change the drive or the actuator, or the bounds.",
        )
    if start is None:
        symmetric = is_symmetric(ens.system, ens.drive)
        search = Search(tracing.map, tracing.box, tracing.period, tracing.tolerance, symmetric)
        (orbits,) = all_orbits(search, np.array([[value]]))
        why = "None was found at the field's own value."
    else:
        guess = np.asarray(start, dtype=float).reshape(1, -1)
        if guess.shape[1] != tracing.map.dimension:
            raise InputError(
                "start",
                must=f"be {tracing.map.dimension} numbers",
                got=repr(start),
                why="It is a state at phase 0.",
                fix="Take one from periodic_orbits.",
            )
        orbits = newton_fixed_points(
            tracing.map, guess, np.array([[value]]), iterate=tracing.period,
            tolerance=tracing.tolerance, box=tracing.box,
        )  # fmt: skip
        why = "Newton's method reached none from it."
    if not orbits.residual.size:
        raise InputError(
            "start",
            must="be near a periodic orbit",
            got=repr(start),
            why=why,
            fix="Widen `state_bounds`, or take a state from periodic_orbits.",
        )
    return nearest_rest(orbits, ens) if start is None else orbits


def describe_branches(
    ens: Ensemble, branches: list[Branch], parameter: str, period: int
) -> dict[str, Any]:
    """Everything about the branches of one actuator, as lists of arrays."""
    points, special = [], []
    for number, branch in enumerate(branches):
        some = branch.curve.points
        orbits = Orbits(some.unknown[:, :-1], some.extra["jacobian"], some.residual, some.error)
        along = described(ens, orbits, period, {parameter: some.unknown[:, -1]})
        points.append(along | {"parameter": some.unknown[:, -1]})
        for one in branch.special:
            z = one.points.unknown
            orbit = Orbits(z[:, :-1], one.points.extra["jacobian"], one.points.residual,
                           one.points.error)  # fmt: skip
            more = described(ens, orbit, period, {parameter: z[:, -1]})
            special.append(
                {
                    "kind": one.kind, "branch": number, "parameter": z[0, -1],
                    "state": z[0, :-1], "error": one.error, "amplitude": more["amplitude"][0],
                }
            )  # fmt: skip
    ends = [branch.curve.ends for branch in branches]
    return {"points": points, "special": special, "ends": ends}


def label_branches(
    ens: Ensemble,
    found: list[dict[str, Any]],
    parameter: str,
    tolerance: float,
    settings: dict[str, Any],
) -> xr.Dataset:
    """Tables of all branches, padded, as a Dataset."""
    d, n = len(ens.field.state), ens.count
    branches = max((len(one["points"]) for one in found if one), default=0)
    lengths = [len(p["parameter"]) for one in found if one for p in one["points"]]
    most = max(lengths, default=0)
    specials = max((len(one["special"]) for one in found if one), default=0)
    tables: dict[str, FloatArray] = {
        "parameter": np.full((n, branches, most), np.nan),
        "initial": np.full((n, branches, most, d), np.nan),
        "multipliers": np.full((n, branches, most, d), np.nan + 0j),
        "multipliers_error": np.full((n, branches, most, d), np.nan),
        "stability": np.full((n, branches, most), "", dtype="<U9"),
        **{
            name: np.full((n, branches, most), np.nan)
            for name in ("amplitude", "maximum", "minimum", "residual", "error")
        },
    }
    marks: dict[str, Any] = {
        "kind": np.full((n, specials), "", dtype="<U15"),
        "branch": np.full((n, specials), -1),
        "parameter": np.full((n, specials), np.nan),
        "state": np.full((n, specials, d), np.nan),
        "error": np.full((n, specials), np.nan),
        "amplitude": np.full((n, specials), np.nan),
    }
    for k, one in enumerate(found):
        for i, along in enumerate(one.get("points", [])):
            for name, table in tables.items():
                table[k, i, : len(along["parameter"])] = along[name]
        for i, mark in enumerate(one.get("special", [])):
            for name, table in marks.items():
                table[k, i] = mark[name]
    status = np.where(ens.invalid, Status.INVALID, Status.OK).astype(np.int8)
    return _dataset(ens, tables, marks, status, parameter, tolerance, settings)


def _dataset(
    ens: Ensemble,
    tables: Mapping[str, FloatArray],
    marks: Mapping[str, Any],
    status: Any,
    parameter: str,
    tolerance: float,
    settings: dict[str, Any],
) -> xr.Dataset:
    along, spot = (*ens.dims, "branch", "point"), (*ens.dims, "special")
    variables: dict[str, Labelled] = {parameter: (along, ens.shaped(tables["parameter"]))}
    for k, name in enumerate(ens.field.state):
        variables[name] = (along, ens.shaped(tables["initial"][..., k]))
        variables[f"special_{name}"] = (spot, ens.shaped(marks["state"][..., k]))
    for name in ("multipliers", "multipliers_error"):
        variables[name] = ((*along, "multiplier"), ens.shaped(tables[name]))
    for name in ("stability", "amplitude", "maximum", "minimum", "residual", "error"):
        variables[name] = (along, ens.shaped(tables[name]))
    for name in ("kind", "branch", "error", "amplitude"):
        variables[f"special_{name}"] = (spot, ens.shaped(marks[name]))
    variables[f"special_{parameter}"] = (spot, ens.shaped(marks["parameter"]))
    variables["status"] = (ens.dims, ens.shaped(status))
    shape = tables["multipliers"].shape
    coords: dict[str, Labelled] = {
        **ens.coords,
        "branch": (("branch",), np.arange(shape[1])),
        "point": (("point",), np.arange(shape[2])),
        "multiplier": (("multiplier",), np.arange(shape[3])),
        "special": (("special",), np.arange(marks["kind"].shape[1])),
    }
    attributes = provenance.attributes(
        ens.system, ens.drive, tolerance, over=ens.coords, **settings
    )
    return build.dataset(variables, coords, attributes)
