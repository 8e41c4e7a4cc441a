"""Free oscillations from rest: their frequency, by the time between two turning points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._errors import InputError
from remanent._typing import FloatArray, IntArray
from remanent.integrate import events
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Outcome, Problem, Request
from remanent.models.actuator import Actuator
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.problem import initial_value_problem

#: Time within which half a period is looked for first.
_FIRST_SEARCH_DURATION_IN_TAU = 8.0
#: Factor by which the time grows where none was found.
_DURATION_GROWTH_FACTOR = 4.0
#: How often it is looked for.
_MAX_ATTEMPTS = 5


@dataclass(frozen=True)
class FreeOscillations:
    """Free oscillations of the members of an ensemble, each from its own turning point.

    Attributes
    ----------
    problem : Problem
        Of one whole period each.
    outcome : Outcome
        With the extremes of the thickness stretch.
    frequency, frequency_error : array (trajectory,)
        NaN where no other turning point was found.
    """

    problem: Problem
    outcome: Outcome
    frequency: FloatArray
    frequency_error: FloatArray

    @property
    def amplitude(self) -> FloatArray:
        """Half the difference of the extremes, array (trajectory,)."""
        return np.asarray(0.5 * (self.outcome.maximum - self.outcome.minimum))


def require_free_oscillations(actuator: Actuator, name: str) -> None:
    """Refuse what has no free oscillations that are all periodic."""
    if not actuator.conservative or actuator.coordinate_count > 1:
        raise InputError(
            name,
            must="have one coordinate, no dissipation and no heat balance",
            got=actuator,
            why="Only free oscillations of one coordinate all have a period.",
            fix="Pass one number as prestress, no edges, dissipation=() and heat=None.",
        )


def free_oscillations(ens: Ensemble, tolerance: float) -> FreeOscillations:
    """Oscillations from the ensemble's initial states, which are at rest.

    Parameters
    ----------
    ens : Ensemble
        Of one coordinate, without dissipation, under a constant load.
    tolerance : float
        Of the state at the other turning point.
    """
    half, error = np.full(ens.trajectory_count, np.nan), np.full(ens.trajectory_count, np.nan)
    duration = _FIRST_SEARCH_DURATION_IN_TAU
    for _ in range(_MAX_ATTEMPTS):
        missing = np.isnan(half) & ~ens.is_invalid
        if not missing.any():
            break
        problem = initial_value_problem(ens, np.full(ens.trajectory_count, duration))
        turns, outcome = events.find_crossings(problem, "stretch_rate", 0.0, tolerance=tolerance)
        rows, first = np.unique(turns.trajectory, return_index=True)
        acceleration = _rate_slope_at_zero(problem, rows, turns.states[first])
        half[rows] = turns.time[first]
        error[rows] = outcome.error[rows] / np.abs(acceleration)
        duration *= _DURATION_GROWTH_FACTOR
    problem = initial_value_problem(ens, np.where(np.isfinite(half), 2.0 * half, 1.0))
    outcome = integrate(problem, Request(wants_extremes=True), tolerance=tolerance)
    with np.errstate(all="ignore"):
        frequency = np.pi / half
    return FreeOscillations(problem, outcome, frequency, frequency * error / half)


def _rate_slope_at_zero(problem: Problem, rows: IntArray, states: FloatArray) -> FloatArray:
    """How fast the rate passes zero, array (row,)."""
    inputs = [np.zeros(rows.size), *states.T, *problem.parameters[rows].T]
    return np.asarray(problem.field.rates(inputs, functions=np)[1])
