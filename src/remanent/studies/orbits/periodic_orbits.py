"""Periodic orbits of a given period, found without a guess."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

from remanent._status import Status
from remanent._typing import FloatArray
from remanent.analysis.orbits.periodic_orbits import Orbits
from remanent.analysis.orbits.stability import Stability, floquet_multipliers, orbit_stability
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import require_count, require_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import Over, lay_out
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.orbits._period_map import DIMENSIONS, StroboscopicMap
from remanent.studies.orbits._search import (
    Search,
    all_orbits,
    box_of,
    is_symmetric,
    require_isolated,
)

#: Tolerances of the extremes along an orbit: the second where the first cannot be met.
_FINE, _COARSE = 1e-8, 1e-5


def periodic_orbits(
    system: System,
    drive: Drive,
    *,
    orbit_period: int = 1,
    state_box: Mapping[str, Any] | None = None,
    over: Over | None = None,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """Find the periodic orbits of a given period, stable and unstable.

    Parameters
    ----------
    system, drive
        What moves, and a periodic load.
    orbit_period
        Least period of the orbits in drive periods: 1 for the forced response, 2, 3 ... for
        subharmonic orbits.
    state_box
        Range of each state variable at phase 0 in which orbits are looked for, such as
        ``{"stretch": (0.3, 4.0)}``; by default stretches from 0.3 to 4 and rates from −8
        to 8.
    over
        Values of numeric fields; they become dimensions of the result.
    tolerance
        Of the residual: the distance of the orbit's point from its image.

    Returns
    -------
    xarray.Dataset
        ``initial`` (orbit, state): the state at phase 0, one point of each orbit;
        ``multipliers`` (orbit, multiplier), complex, largest first, with
        ``multipliers_error``; ``stability`` (orbit): ``elliptic`` or ``saddle`` without
        dissipation, ``stable``, ``saddle`` or ``unstable`` with it, ``undecided`` within the
        error; ``maximum``, ``minimum`` and ``amplitude`` of the thickness stretch along the
        orbit; ``residual``; ``orbits``, how many there are; ``status``.  NaN where there are
        fewer orbits than elsewhere.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    Notes
    -----
    Newton's method on the period map starts from a grid over the bounds.  Where the motion
    is reversible in time (no dissipation, a load even in time), orbits at rest at phase 0
    and half their period later are bracketed along the line of zero rate first: none of
    them is missed but by twos between neighbouring points of that line.  Elsewhere an
    orbit whose basin under Newton's method holds no point of the grid is missed.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.periodic_orbits(rm.Actuator(temperature=350), rm.SineSquared(0.4, 1.25))
    >>> ds.stability.values.tolist()
    ['elliptic', 'elliptic', 'saddle']
    """
    orbit_period = require_count(
        "orbit_period", orbit_period, "Orbits close after whole drive periods."
    )
    require_tolerance(tolerance)
    ens = lay_out(system, drive, over, reserved=DIMENSIONS)
    require_periods(ens)
    require_isolated(ens)
    box = box_of(ens, state_box)
    found = [_of_one(ens.member(k), box, orbit_period, tolerance) for k in range(ens.count)]
    return _labelled(ens, found, orbit_period, tolerance)


def _of_one(ens: Ensemble, box: FloatArray, period: int, tolerance: float) -> dict[str, Any]:
    """Orbits of a single actuator and drive, with all that is known of them."""
    if ens.invalid[0]:
        return {}
    map_ = StroboscopicMap(ens, (), min(0.1 * tolerance, 1e-10))
    symmetric = is_symmetric(ens.system, ens.drive)
    (orbits,) = all_orbits(Search(map_, box, period, tolerance, symmetric), np.empty((1, 0)))
    return described(ens, orbits, period, {})


def described(
    ens: Ensemble, orbits: Orbits, period: int, varied: Mapping[str, FloatArray]
) -> dict[str, Any]:
    """Multipliers, stability and extremes of some orbits of one actuator.

    Parameters
    ----------
    varied : mapping of name to array (orbit,)
        Fields whose values differ between the orbits.
    """
    values, errors = floquet_multipliers(orbits.jacobian, orbits.error)
    kinds = orbit_stability(values, errors, conservative=ens.system.conservative)
    maximum, minimum = _extremes(ens, orbits.state, period, varied)
    return {
        "initial": orbits.state,
        "multipliers": values,
        "multipliers_error": errors,
        "stability": np.array([Stability(k).meaning for k in kinds], dtype="<U9"),
        "maximum": maximum,
        "minimum": minimum,
        "amplitude": 0.5 * (maximum - minimum),
        "residual": orbits.residual,
        "error": orbits.error,
    }


def _extremes(
    ens: Ensemble, states: FloatArray, period: int, varied: Mapping[str, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Extremes of the thickness stretch over one period of each orbit."""
    if not len(states):
        return np.empty(0), np.empty(0)
    some = ens.with_states(states, varied)
    asked = initial_value_problem(some, period * require_periods(some))
    first = integrate(asked, Request(extremes=True), tolerance=_FINE)
    maximum, minimum = first.maximum, first.minimum
    missed = np.isnan(maximum)
    if missed.any():  # motions of large amplitude, whose extremes have fewer digits
        again = integrate(
            replace(asked, invalid=~missed), Request(extremes=True), tolerance=_COARSE
        )
        maximum = np.where(missed, again.maximum, maximum)
        minimum = np.where(missed, again.minimum, minimum)
    return maximum, minimum


def _labelled(
    ens: Ensemble, found: list[dict[str, Any]], period: int, tolerance: float
) -> xr.Dataset:
    most = max((len(one["residual"]) for one in found if one), default=0)
    d = len(ens.field.state)
    shapes: dict[str, tuple[tuple[str, ...], tuple[int, ...], Any]] = {
        "initial": (("orbit", "state"), (most, d), np.nan),
        "multipliers": (("orbit", "multiplier"), (most, d), np.nan + 0j),
        "multipliers_error": (("orbit", "multiplier"), (most, d), np.nan),
        "stability": (("orbit",), (most,), ""),
        **dict.fromkeys(
            ("maximum", "minimum", "amplitude", "residual", "error"),
            (("orbit",), (most,), np.nan),
        ),
    }
    variables: dict[str, Labelled] = {}
    for name, (dims, shape, missing) in shapes.items():
        kind = "<U9" if name == "stability" else None
        whole = np.full((ens.count, *shape), missing, dtype=kind)
        for k, one in enumerate(found):
            if one:
                whole[k, : len(one[name])] = one[name]
        variables[name] = ((*ens.dims, *dims), ens.shaped(whole))
    status = np.where(ens.invalid, Status.INVALID, Status.OK).astype(np.int8)
    variables["status"] = (ens.dims, ens.shaped(status))
    known = [len(one["residual"]) if one else 0 for one in found]
    variables["orbits"] = (ens.dims, ens.shaped(np.array(known, dtype=np.int64)))
    coords: dict[str, Labelled] = {
        **ens.coords,
        "orbit": (("orbit",), np.arange(most)),
        "state": (("state",), np.array(ens.field.state)),
        "multiplier": (("multiplier",), np.arange(d)),
    }
    attributes = provenance.attributes(
        ens.system, ens.drive, tolerance, over=ens.coords, orbit_period=period
    )
    return build.dataset(variables, coords, attributes)
