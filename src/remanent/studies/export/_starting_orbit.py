"""A periodic orbit from which another tool may continue."""

from __future__ import annotations

from typing import Final

import numpy as np

from remanent._errors import InputError, shortened_repr
from remanent._typing import FloatArray
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.models.actuator import Actuator
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.orbits._checks import require_heat_exchange, require_state_box
from remanent.studies.orbits._orbit_search import OrbitSearch
from remanent.studies.orbits._period_map import (
    StroboscopicMap,
    period_tolerance_for_residual,
    refine_on_period_map,
)
from remanent.studies.orbits._search import is_reversible, search_orbits

#: Intervals of a period between states of the orbit.
_INTERVALS: Final = 400
#: Residual of orbits as they are found, and their error once they are refined.
_RESIDUAL, _TOLERANCE = 1e-9, 1e-9
#: Error of the states along the orbit.
_PATH_TOLERANCE: Final = 1e-8
#: Periods of the motion from rest near which orbits of one's own systems are looked for.
_PERIODS: Final = 40
#: Margin around that motion, as a share of what it covers, and of 1 where it covers nothing.
_MARGIN: Final = 0.25


def starting_orbit(ens: Ensemble) -> tuple[FloatArray, FloatArray, bool]:
    """An orbit of the period of the load, stable where one of those found is.

    Parameters
    ----------
    ens : Ensemble
        Of one trajectory.

    Returns
    -------
    phases : array (node,)
        From 0 to 1.
    states : array (node, state)
    conservative : bool
        Whether nothing in the model loses energy.

    Raises
    ------
    InputError
        The load has no period, or no orbit was found.
    """
    period = float(require_drive_periods(ens)[0])
    require_heat_exchange(ens)
    phases = np.linspace(0.0, 1.0, _INTERVALS + 1)
    for state in _points_of_orbits(ens):
        path = _path(ens, state, phases * period)
        if np.isfinite(path).all():
            return phases, path, bool(ens.system.conservative)
    raise InputError(
        "drive",
        must="lead to a periodic orbit that is found",
        got=shortened_repr(ens.drive),
        why="AUTO continues an orbit, and none of the load's period was found near the motion "
        "from rest.",
        fix="Pass another load, or a system whose rest is nearer to the orbit.",
    )


def _points_of_orbits(ens: Ensemble) -> list[FloatArray]:
    """States at phase 0 of orbits, those with the smallest multipliers first."""
    box = _state_box(ens)
    if box is None:
        return []
    map_ = StroboscopicMap(ens, (), period_tolerance_for_residual(_RESIDUAL))
    search = OrbitSearch(
        map_, box, 1, _RESIDUAL, is_reversible(ens.system, ens.drive), is_dense=False,
        box_is_free=isinstance(ens.system, Actuator),
    )  # fmt: skip
    (outcome,) = search_orbits(search, np.empty((1, 0)))
    found = outcome.orbits.state
    if not len(found):
        return []
    orbits = refine_on_period_map(map_, found, np.empty((len(found), 0)), 1, _TOLERANCE)
    with np.errstate(all="ignore"):
        finite = np.where(np.isfinite(orbits.jacobian), orbits.jacobian, 0.0)
        largest = np.abs(np.linalg.eigvals(finite)).max(axis=1)
    return [orbits.state[k] for k in np.argsort(largest, kind="stable")]


def _state_box(ens: Ensemble) -> FloatArray | None:
    """Where orbits are looked for: of a system of one's own, what motion from rest covers."""
    if isinstance(ens.system, Actuator):
        return require_state_box("state_box", None, ens)
    duration = _PERIODS * require_drive_periods(ens)
    motion = _path(ens, ens.initial_states[0], np.linspace(0.0, float(duration[0]), 20 * _PERIODS))
    motion = motion[np.isfinite(motion).all(axis=1)]
    if not len(motion):
        return None
    low, high = motion.min(axis=0), motion.max(axis=0)
    margin = _MARGIN * np.where(high > low, high - low, 1.0)
    return np.stack([low - margin, high + margin], axis=1)


def _path(ens: Ensemble, state: FloatArray, times: FloatArray) -> FloatArray:
    """States at times from one at time 0, array (time, state); NaN where they are not known."""
    single = ens.with_initial_states(state[np.newaxis], {})
    outcome = integrate(
        initial_value_problem(single, times[-1:]),
        Request(times=times[np.newaxis]),
        tolerance=_PATH_TOLERANCE,
    )
    assert outcome.states is not None
    return np.asarray(outcome.states[0])
