"""Free oscillations from rest: their frequency, by the time between two turning points."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from remanent._errors import InputError
from remanent._field import Role
from remanent._status import Status
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate import events
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Outcome, Problem, Request
from remanent.models.actuator import Actuator
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.observables import evaluate_observable
from remanent.studies.ensemble.problem import initial_value_problem

#: Time within which half a period is looked for first.
_FIRST_SEARCH_DURATION_IN_TAU = 2.5
#: Instants of that time at which the direction of the motion is looked at.
_SEARCH_INSTANTS = 64
#: Factor by which the time grows where none was found.
_DURATION_GROWTH_FACTOR = 4.0
#: Rounding of a frequency, relative to it.
_ROUNDING = 8.0 * float(np.finfo(float).eps)
#: How often it is looked for.
_MAX_ATTEMPTS = 6


@dataclass(frozen=True)
class FreeOscillations:
    """Free oscillations of the members of an ensemble, each from its own turning point.

    Attributes
    ----------
    problem : Problem
        Of half a period each, and a little more.
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
    def frequency_is_missing(self) -> BoolArray:
        """Where there is none, or none was found, array (trajectory,)."""
        return np.asarray(np.isnan(self.frequency))

    @property
    def acceleration(self) -> FloatArray:
        """At the start, array (trajectory,): zero at an equilibrium."""
        rows = np.arange(len(self.frequency))
        return _rate_slope_at_zero(self.problem, rows, self.problem.initial_states)

    @property
    def amplitude(self) -> FloatArray:
        """Half the difference of the extremes, array (trajectory,)."""
        return np.asarray(0.5 * (self.outcome.maximum - self.outcome.minimum))


def require_free_oscillations(ens: Ensemble, name: str) -> None:
    """Refuse what has no free oscillations that are all periodic."""
    field = ens.vector_field
    if field.roles != (Role.COORDINATE, Role.RATE) or not ens.system.conservative:
        raise InputError(
            name,
            must="have one coordinate, and nothing that dissipates or gives energy",
            got=ens.system,
            why="Only free oscillations of one coordinate all have a period.",
            fix="Pass one number as prestress of an actuator, no edges, dissipation=() and "
            "heat=None; of a system of one's own one coordinate and no dissipation.",
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
    # No further than to the turn: the error of a longer run is that of its end.
    after, without = _times_after_first_turns(ens, tolerance)
    turn = _first_turns(ens, np.where(np.isfinite(after), after, without), tolerance)
    half = np.where(np.isfinite(after), turn.time, np.nan)
    lowest, highest = _extremes_between_turns(ens, turn, tolerance)
    # Where the run ended beyond the turn is the search's own choice.
    horizon = np.where(np.isfinite(half), half, turn.outcome.horizon)
    outcome = replace(turn.outcome, maximum=highest, minimum=lowest, horizon=horizon)
    with np.errstate(all="ignore"):
        frequency = np.pi / half
        frequency_error = frequency * turn.time_error / half + _ROUNDING * frequency
    return FreeOscillations(turn.problem, outcome, frequency, frequency_error)


def _extremes_between_turns(
    ens: Ensemble, turn: _FirstTurns, tolerance: float
) -> tuple[FloatArray, FloatArray]:
    """Least and largest value of the observable, arrays (trajectory,).

    A coordinate is extreme where it turns, at the start and there, and so is the thickness
    stretch of an actuator.  Another observable may be so in between.
    """
    name = turn.problem.field.observable_name
    if name in turn.problem.field.state_names or isinstance(ens.system, Actuator):
        ends = np.stack([ens.initial_states, turn.states], axis=1)
        values = evaluate_observable(turn.problem, name, np.zeros(ends.shape[:2]), ends)
        return values.min(axis=1), values.max(axis=1)
    followed = integrate(turn.problem, Request(wants_extremes=True), tolerance=tolerance)
    return followed.minimum, followed.maximum


def _times_after_first_turns(ens: Ensemble, tolerance: float) -> tuple[FloatArray, FloatArray]:
    """Times soon after first turns, looked for in longer and longer runs.

    Returns
    -------
    after : array (trajectory,)
        NaN where no turn was found.
    without : array (trajectory,)
        Length of the run that tells why there is none: the one that ended early, or a short one.
    """
    after = np.full(ens.trajectory_count, np.nan)
    until = np.full(ens.trajectory_count, _FIRST_SEARCH_DURATION_IN_TAU)
    missing = ~ens.is_invalid
    for _ in range(_MAX_ATTEMPTS):
        if not missing.any():
            break
        problem = initial_value_problem(ens, until)
        instants = until[:, None] * np.arange(1, _SEARCH_INSTANTS + 1) / _SEARCH_INSTANTS
        outcome = integrate(problem, Request(times=instants), tolerance=tolerance)
        assert outcome.states is not None
        start = _rate_slope_at_zero(problem, np.arange(len(after)), ens.initial_states)
        with np.errstate(invalid="ignore"):
            returns = outcome.states[:, :, 1] * start[:, None] < 0.0
        first = np.take_along_axis(instants, returns.argmax(axis=1)[:, None], axis=1)[:, 0]
        after = np.where(missing & returns.any(axis=1), first, after)
        # A run that ended early ends there however long it is to be.
        missing &= np.isnan(after) & (outcome.status == Status.OK)
        until = np.where(missing, _DURATION_GROWTH_FACTOR * until, until)
    return after, np.where(missing, 1.0, until)


@dataclass(frozen=True)
class _FirstTurns:
    """Where the rate is zero first: NaN where it is not.

    Attributes
    ----------
    problem : Problem
    outcome : Outcome
    time, time_error : array (trajectory,)
    states : array (trajectory, state)
    """

    problem: Problem
    outcome: Outcome
    time: FloatArray
    time_error: FloatArray
    states: FloatArray


def _first_turns(ens: Ensemble, duration: FloatArray, tolerance: float) -> _FirstTurns:
    """Runs of some duration, up to where the rate is zero first."""
    problem = initial_value_problem(ens, duration)
    (rate,) = ens.vector_field.names_of_roles(Role.RATE)
    turns, outcome = events.find_crossings(problem, rate, 0.0, tolerance=tolerance)
    rows, first = np.unique(turns.trajectory, return_index=True)
    acceleration = _rate_slope_at_zero(problem, rows, turns.states[first])
    time, error = np.full(ens.trajectory_count, np.nan), np.full(ens.trajectory_count, np.nan)
    time[rows] = turns.time[first]
    error[rows] = outcome.error[rows] / np.abs(acceleration)
    states = np.full(ens.initial_states.shape, np.nan)
    states[rows] = turns.states[first]
    return _FirstTurns(problem, outcome, time, error, states)


def _rate_slope_at_zero(problem: Problem, rows: IntArray, states: FloatArray) -> FloatArray:
    """How fast the rate passes zero, array (row,)."""
    inputs = [np.zeros(rows.size), *states.T, *problem.parameters[rows].T]
    return np.asarray(problem.field.rates(inputs, functions=np)[1])
