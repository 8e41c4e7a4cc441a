"""What is asked of a search for periodic orbits, what it answers, and what all searches share."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.errors import orbit_errors
from remanent.analysis.orbits.periodic_orbits import (
    PeriodicOrbits,
    concatenate_orbits,
    newton_fixed_points,
)
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.observables import evaluate_observable
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.orbits._period_map import StroboscopicMap

#: Error of a period of the map by which orbits are confirmed that a coarser one cannot.
_FINEST_PERIOD_TOLERANCE = 1e-13
#: Residual that is asked of them.
_FINEST_RESIDUAL = 1e-12
#: Times within a period at which loads are compared.
_LOAD_SAMPLE_COUNT = 65
#: Share of its width by which a point may lie outside the box, for rounding.
_BOX_SLACK_SHARE_OF_WIDTH = 1e-9


@dataclass(frozen=True)
class OrbitSearch:
    """Where and how orbits are looked for.

    Attributes
    ----------
    map : StroboscopicMap
        Its parameters are the columns of `parameters` in
        :func:`remanent.studies.orbits._search.search_orbits`.
    state_box : array (state, 2)
        Bounds of the state at phase 0: orbits with a point inside are looked for.
    orbit_period : int
        In drive periods.
    residual_tolerance : float
        Of the residual.
    is_reversible : bool
        Undamped, with a load that is even in time: symmetric orbits start at zero rate.
    is_dense : bool
        Whether to spend many guesses, where a grid of guesses is all there is.
    box_is_free : bool
        Whether the box may be replaced by one that holds all orbits.
    """

    map: StroboscopicMap
    state_box: FloatArray
    orbit_period: int
    residual_tolerance: float
    is_reversible: bool
    is_dense: bool = True
    box_is_free: bool = False

    def member(self, row: FloatArray) -> Ensemble:
        """The system with one row of the map's parameters, as an ensemble of one trajectory."""
        ens = self.map.ensemble
        varied = {name: row[k : k + 1] for k, name in enumerate(self.map.parameter_names)}
        return ens.with_initial_states(ens.initial_states[:1], varied)

    def is_dissipative(self, row: FloatArray) -> bool:
        """Whether motion loses energy, for one row of the map's parameters."""
        ens = self.member(row)
        return bool(ens.system.where_dissipative(ens.parameter_values).all())

    def drive_period(self, row: FloatArray) -> float:
        """In tau, for one row of the map's parameters."""
        return float(require_drive_periods(self.member(row))[0])

    def has_constant_load(self, row: FloatArray) -> bool:
        """Whether no load varies within a period."""
        ens = self.member(row)
        times = self.drive_period(row) * np.linspace(0.0, 1.0, _LOAD_SAMPLE_COUNT)[None]
        states = np.broadcast_to(ens.initial_states[:, None], (1, times.size, self.map.dimension))
        problem = initial_value_problem(ens, np.ones(1))
        loads = [
            evaluate_observable(problem, name, times, states)
            for name in ens.vector_field.load_names
        ]
        return all(bool(np.ptp(load) == 0.0) for load in loads)


@dataclass(frozen=True)
class OrbitSearchOutcome:
    """Periodic orbits that were found.

    Attributes
    ----------
    orbits : PeriodicOrbits
    reason : str
        Why some may be missing; empty where none is.
    symmetric : array (symmetric orbit,) of int
        Which were found on a line of symmetry, where they are known better than Newton's method
        in the plane tells, if they are on a curve along which P^n(z) - z almost vanishes.
    """

    orbits: PeriodicOrbits
    reason: str = ""
    symmetric: IntArray = field(default_factory=lambda: np.empty(0, dtype=np.int64))


@dataclass(frozen=True)
class ConfirmedPoints:
    """Fixed points of an iterate of the map, each with exactly one orbit within its error.

    Attributes
    ----------
    orbits : PeriodicOrbits
    error : array (orbit,)
    unconfirmed : array (point, state)
        Points to which Newton's method converged and of which this is not known.
    """

    orbits: PeriodicOrbits
    error: FloatArray
    unconfirmed: FloatArray


def confirmed_fixed_points(
    search: OrbitSearch, starts: FloatArray, row: FloatArray, box: FloatArray
) -> ConfirmedPoints:
    """Fixed points of the iterate that Newton's method reaches, confirmed by its contraction.

    Points that the map of the search does not confirm are refined with a finer one.

    Parameters
    ----------
    search : OrbitSearch
    starts : array (start, state)
    row : array (parameter,)
    box : array (state, 2)
        Newton's method is given up in steps far outside of it.
    """
    finer = replace(search.map, period_tolerance=_FINEST_PERIOD_TOLERANCE)
    ways = ((search.map, search.residual_tolerance), (finer, _FINEST_RESIDUAL))
    parts, errors = [], []
    for map_, tolerance in ways:
        points = newton_fixed_points(
            map_, starts, np.tile(row, (len(starts), 1)), iterate=search.orbit_period,
            tolerance=tolerance, box=box,
        )  # fmt: skip
        rows = np.tile(row, (len(points.state), 1))
        known = orbit_errors(map_, points.state, rows, search.orbit_period)
        good = known.is_confirmed
        parts.append(points.subset(good))
        errors.append(known.error[good])
        starts = points.state[~good]
        if not len(starts):
            break
    return ConfirmedPoints(
        concatenate_orbits(parts, search.map.dimension), np.concatenate(errors), starts
    )


def is_inside_box(states: FloatArray, box: FloatArray) -> BoolArray:
    """Whether states are inside a box, array (point,) of bool."""
    slack = _BOX_SLACK_SHARE_OF_WIDTH * (box[:, 1] - box[:, 0])
    return np.asarray(((states >= box[:, 0] - slack) & (states <= box[:, 1] + slack)).all(axis=1))
