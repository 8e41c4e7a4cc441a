"""The state of rest that a motion tends to, found by following the motion."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np

from remanent._field import Role
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.statics._rest_states import RestStates, rest_states_of_cases, thickness_errors
from remanent.studies.statics._static_ensemble import StaticEnsemble
from remanent.studies.statics._static_state import StaticState

#: Length of the first stretch of time in which a motion is followed on.
_FIRST_SPAN = 20.0
#: Factor from each such length to the next.
_SPAN_GROWTH = 2.0
#: How many of them there are.
_MAX_SPANS = 12
#: Rate of a state of a body with a heat balance, relative to it, below which it is at rest.
_SETTLED_RELATIVE_RATE = 1e-8
#: Largest strain energy of a motion, in units of 1 and its load.
_UNDAMPED_HEAT_FACTOR = 4.0
#: Why there is no state of rest that a motion tends to.
LOST_REASON = "the motion could not be followed to a state of rest within the tolerance"
CONSERVED_REASON = "the motion passes over a barrier and nothing takes energy out of it"
SLOW_REASON = "the motion has not decided for a state of rest within 80000 units of time"


@dataclass(frozen=True)
class FinalRests:
    """The state of rest that every motion tends to.

    Attributes
    ----------
    bodies : list of StaticState or None
        None where there is none or it is not known.
    thickness_error : array (trajectory,)
    reasons : list of str
        Why there is none; empty where there is one.
    """

    bodies: list[StaticState | None]
    thickness_error: FloatArray
    reasons: list[str]


def find_final_rests(
    ens: Ensemble, states: FloatArray, errors: FloatArray, tolerance: float
) -> FinalRests:
    """Follow motions under constant loads until each is caught about a state of rest.

    Parameters
    ----------
    ens : Ensemble
        Under a constant load; its initial states are not used.
    states : array (trajectory, state)
        Where the motions are; NaN where that is not known.
    errors : array (trajectory,)
        Of these states.
    tolerance : float
        Of the motion from there on.
    """
    count = ens.trajectory_count
    dissipates = np.broadcast_to(ens.system.where_dissipative(ens.parameter_values), count)
    static = StaticEnsemble(ens)
    pending = np.flatnonzero(~ens.is_invalid & np.isfinite(states).all(axis=1))
    known: list[RestStates | None] = [None] * count
    found: dict[int, int] = {}
    reasons = ["" if invalid else LOST_REASON for invalid in ens.is_invalid]
    span, states, errors = _FIRST_SPAN, states.copy(), errors.copy()
    for _ in range(_MAX_SPANS + 1):
        settled = ~dissipates[pending] | _heat_has_settled(ens, states, pending)
        static = _at_followed_temperature(static, states)
        for k, rests in _rest_states(static, known, pending[settled]):
            known[k] = rests
            energy = _upper_energy(static, k, states[k], errors[k])
            number = rests.well_of(states[k], energy)
            if number is not None:
                found[k], reasons[k] = number, ""
            else:
                reasons[k] = SLOW_REASON if dissipates[k] else CONSERVED_REASON
        pending = np.array([k for k in pending if k not in found and dissipates[k]], dtype=np.int64)
        if not pending.size:
            break
        states, errors = _followed(ens, states, errors, pending, span, tolerance)
        lost = ~np.isfinite(states[pending]).all(axis=1)
        for k in pending[lost]:
            reasons[k] = LOST_REASON
        pending, span = pending[~lost], _SPAN_GROWTH * span
    error = np.full(count, np.nan)
    bodies: list[StaticState | None] = [None] * count
    chosen = [(rests, found[k]) for k, rests in enumerate(known) if rests and k in found]
    for (rests, number), off in zip(chosen, thickness_errors(chosen), strict=True):
        k, body = rests.case_index, rests.body(number)
        bodies[k], error[k] = body, off
        if not dissipates[k]:
            error[k] += _undamped_heat_error(ens, k) * body.thickness()
        elif _is_adiabatic(ens)[k]:
            # The temperature that it has come to is known to the error of the motion.
            error[k] += errors[k] + _SETTLED_RELATIVE_RATE
    return FinalRests(bodies, error, reasons)


def _rest_states(
    static: StaticEnsemble, known: list[RestStates | None], pending: IntArray
) -> Iterable[tuple[int, RestStates]]:
    """States of rest of trajectories; those that were found stay as they are."""
    varies = _is_adiabatic(static.ensemble)
    new = np.array([k for k in pending if known[k] is None or varies[k]], dtype=np.int64)
    fresh = dict(zip(new.tolist(), rest_states_of_cases(static, new), strict=True))
    rests = [(int(k), fresh.get(int(k)) or known[k]) for k in pending]
    return [(k, one) for k, one in rests if one is not None]


def _is_adiabatic(ens: Ensemble) -> BoolArray:
    """Where the temperature is a state that nothing brings back to that of the surroundings."""
    if not ens.vector_field.indices_of_roles(Role.TEMPERATURE):
        return np.zeros(ens.trajectory_count, dtype=np.bool_)
    return np.asarray(ens.parameter_values["heat.exchange"] == 0.0)


def _at_followed_temperature(static: StaticEnsemble, states: FloatArray) -> StaticEnsemble:
    """The ensemble at rest at the temperatures that adiabatic bodies have come to."""
    ens = static.ensemble
    adiabatic = _is_adiabatic(ens)
    if not adiabatic.any():
        return static
    (index,) = ens.vector_field.indices_of_roles(Role.TEMPERATURE)
    changed = adiabatic & np.isfinite(states[:, index])
    temperature = np.where(changed, states[:, index], ens.parameter_values["temperature"])
    values = ens.parameter_values | {"temperature": temperature}
    return StaticEnsemble(replace(ens, parameter_values=values))


def _heat_has_settled(ens: Ensemble, states: FloatArray, pending: IntArray) -> BoolArray:
    """Where nothing moves any more that could warm or cool the body, array (pending,)."""
    if not ens.vector_field.indices_of_roles(Role.TEMPERATURE) or not pending.size:
        return np.ones(pending.size, dtype=np.bool_)
    inputs = [np.zeros(pending.size), *states[pending].T]
    inputs += [ens.parameter_values[name][pending] for name in ens.vector_field.parameter_names]
    rates = np.column_stack(
        [np.broadcast_to(r, pending.size) for r in ens.vector_field.rates(inputs, functions=np)]
    )
    limit = _SETTLED_RELATIVE_RATE * (1.0 + np.abs(states[pending]))
    return np.asarray((np.abs(rates) <= limit).all(axis=1))


def _undamped_heat_error(ens: Ensemble, k: int) -> float:
    """Share by which a rest may differ from that at the temperature of the motion.

    An adiabatic body that nothing damps warms and cools with its strain energy, by the share
    coupling times it; in a motion under a load m that is of the order of 1 + |m|.
    """
    if not _is_adiabatic(ens)[k]:
        return 0.0
    coupling, load = (float(ens.parameter_values[name][k]) for name in ("heat.coupling", "m"))
    return _UNDAMPED_HEAT_FACTOR * coupling * (1.0 + abs(load))


def _upper_energy(static: StaticEnsemble, k: int, state: FloatArray, error: float) -> float:
    """The energy of a state, and what the error of each variable may add to it."""
    ens = static.ensemble
    changes = error * np.vstack([np.zeros(state.size), np.eye(state.size), -np.eye(state.size)])
    rows = state + changes
    inputs = [np.zeros(len(rows)), *rows.T]
    inputs += [
        np.full(len(rows), ens.parameter_values[n][k]) for n in ens.vector_field.parameter_names
    ]
    (energy,) = ens.vector_field.observables["energy"](inputs, functions=np)
    return float(energy[0] + np.abs(energy[1:] - energy[0]).sum())


def _followed(
    ens: Ensemble,
    states: FloatArray,
    errors: FloatArray,
    pending: IntArray,
    span: float,
    tolerance: float,
) -> tuple[FloatArray, FloatArray]:
    """States a `span` of time later, and their errors, of the pending trajectories."""
    part = replace(
        ens,
        dimension_sizes={"trajectory": pending.size},
        coords={},
        parameter_values={name: column[pending] for name, column in ens.parameter_values.items()},
        initial_states=states[pending],
        is_invalid=np.zeros(pending.size, dtype=np.bool_),
    )
    problem = initial_value_problem(part, np.full(pending.size, span))
    outcome = integrate(problem, Request(times=problem.duration[:, None]), tolerance=tolerance)
    assert outcome.states is not None
    states, errors = states.copy(), errors.copy()
    states[pending] = outcome.states[:, 0]
    errors[pending] += outcome.error
    return states, errors
