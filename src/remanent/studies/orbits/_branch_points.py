"""What is told of each point of a branch: multipliers, extremes, all phases, and their errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remanent._typing import FloatArray
from remanent.analysis.orbits.curve_errors import errors_at_fixed_unknown, jacobian_errors
from remanent.analysis.orbits.curves import CurvePoints
from remanent.analysis.orbits.period_chain import PeriodChain
from remanent.analysis.orbits.stability import Stability, floquet_multipliers, orbit_stability
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Outcome, Problem, Request
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.observables import evaluate_observable
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.orbits._tracing import Branch, Tracing

#: Length of the longest word for stability.
_STABILITY_DTYPE = "<U9"
#: Tolerance of the extremes along an orbit.
_EXTREMES_TOLERANCE = 1e-8
#: The same for motions of large amplitude, which have fewer digits.
_FALLBACK_EXTREMES_TOLERANCE = 1e-5
#: By how much extremes change with the state is taken at every so many points of a branch.
_POINTS_BETWEEN_SLOPES = 12
#: Distance over which extremes are differenced, in scaled unknowns.
_DIFFERENCE_STEP = 1e-4
#: Factor by which these slopes may be larger between the points where they are known.
_SLOPE_MARGIN = 2.0

#: Columns along points that have one value.
POINT_COLUMNS = (
    "stability", "amplitude", "maximum", "minimum", "amplitude_error", "maximum_error",
    "minimum_error", "residual", "error",
)  # fmt: skip
#: Columns along points that have a value for each multiplier.
MULTIPLIER_COLUMNS = ("multipliers", "multipliers_error")


def observed_names(tracing: Tracing) -> tuple[str, ...]:
    """Observables that have a value for each drive period, beside the state."""
    field = tracing.map.ensemble.vector_field
    return tuple(n for n in field.observable_and_rate_names if n not in field.state_names)


def describe_branch(tracing: Tracing, parameter: str, branch: Branch) -> dict[str, NDArray[Any]]:
    """Columns along the points of a branch, each an array (point, ...).

    Parameters
    ----------
    tracing : Tracing
    parameter : str
        That varies along the branch.
    branch : Branch
    """
    ens, points = tracing.map.ensemble, branch.curve.points
    state = points.unknown[:, :-1]
    chain = PeriodChain.along(tracing.map, state, points.unknown[:, -1:], tracing.orbit_period)
    unknown_error = _errors_along_branch(tracing, branch, chain)
    state_error = unknown_error[:, :-1]
    entry_error = jacobian_errors(
        tracing.curve_equations, points, chain.jacobian_error, state_error
    )
    values, errors = floquet_multipliers(points.extra_arrays["jacobian"], entry_error)
    kinds = orbit_stability(values, errors, conservative=ens.system.conservative)
    return {
        "parameter": points.unknown[:, -1],
        "initial": state,
        "multipliers": values,
        "multipliers_error": np.where(np.isfinite(errors), errors, np.nan),
        "stability": np.array([Stability(k).meaning for k in kinds], dtype=_STABILITY_DTYPE),
        "residual": points.residual,
        "error": state_error.max(axis=1),
        **observe_orbits(tracing, parameter, points, unknown_error),
    }


def _errors_along_branch(tracing: Tracing, branch: Branch, chain: PeriodChain) -> FloatArray:
    """Errors of the states of a branch at the parameter as it is, array (point, state + 1).

    Where the branch meets another, the equations of the orbit are singular; what is known there
    is the error of the special point.
    """
    points = branch.curve.points
    closing = {**points.extra_arrays, "value": chain.end - chain.start}
    error = errors_at_fixed_unknown(
        replace(points, extra_arrays=closing), chain.end_error, tracing.scale, -1
    )
    for special in branch.special_points:
        same = (points.unknown == special.point.unknown[0]).all(axis=1)
        error[same, :-1] = special.error[:-1]
    return error


def empty_point_columns(
    state_variables: int, orbit_period: int, observed: tuple[str, ...]
) -> dict[str, NDArray[Any]]:
    """The columns of :func:`describe_branch` without any point."""
    rows = np.empty((0, state_variables))
    return {
        "parameter": np.empty(0),
        "initial": rows,
        "multipliers": rows.astype(complex),
        "multipliers_error": rows,
        **dict.fromkeys(POINT_COLUMNS, np.empty(0)),
        "stability": np.empty(0, dtype=_STABILITY_DTYPE),
        **{name: np.empty((0, orbit_period)) for name in observed},
    }


@dataclass(frozen=True)
class _Extremes:
    """Largest and smallest value of the observable over orbits, with the error of both."""

    maximum: FloatArray
    minimum: FloatArray
    error: FloatArray
    states: FloatArray | None


def observe_orbits(
    tracing: Tracing,
    parameter: str,
    points: CurvePoints,
    unknown_error: FloatArray,
    tolerance: float = _EXTREMES_TOLERANCE,
) -> dict[str, NDArray[Any]]:
    """Extremes of the observable over each orbit, and its values after whole drive periods.

    Parameters
    ----------
    tracing : Tracing
    parameter : str
        That varies along the branch.
    points : CurvePoints
        In order along it.
    unknown_error : array (point, state + 1)
        Errors of state and parameter.
    tolerance : float
        Of the extremes.
    """
    period, ens = tracing.orbit_period, tracing.map.ensemble
    count, size = unknown_error.shape
    steps = _DIFFERENCE_STEP * tracing.scale
    sampled = np.unique(np.append(np.arange(0, count, _POINTS_BETWEEN_SLOPES), count - 1))
    moved = points.unknown[sampled][:, None] + np.diag(steps)
    unknown = np.concatenate([points.unknown, moved.reshape(-1, size)])
    on_orbits = ens.with_initial_states(unknown[:, :-1], {parameter: unknown[:, -1]})
    problem = initial_value_problem(on_orbits, period * require_drive_periods(on_orbits))
    found = _integrate_extremes(problem, period, tolerance)
    columns: dict[str, NDArray[Any]] = {}
    extremes = {"maximum": found.maximum, "minimum": found.minimum}
    for name, values in {**extremes, "amplitude": 0.5 * (found.maximum - found.minimum)}.items():
        change = (values[count:].reshape(-1, size) - values[sampled][:, None]) / steps
        slope = _between_samples(np.abs(change), sampled, count)
        columns[name] = values[:count]
        columns[f"{name}_error"] = found.error[:count] + (slope * unknown_error).sum(axis=1)
    states = points.unknown[:, None, :-1] if found.states is None else found.states[:count, :period]
    return {**columns, **_observables_at_periods(tracing, problem, count, states)}


def _between_samples(values: FloatArray, sampled: NDArray[Any], count: int) -> FloatArray:
    """Of what is known at some points the larger of the two beside each point, with a margin.

    Where it is known at every point, as at a special point, it is taken as it is.
    """
    if sampled.size == count:
        return values
    after = np.minimum(np.searchsorted(sampled, np.arange(count)), sampled.size - 1)
    before = np.maximum(after - 1, 0)
    return np.asarray(_SLOPE_MARGIN * np.fmax(values[before], values[after]))


def _integrate_extremes(problem: Problem, period: int, tolerance: float) -> _Extremes:
    """Extremes over orbits, again with a looser tolerance where the motion has fewer digits."""
    request = Request(wants_extremes=True, strobe_cycles=1 if period > 1 else 0)
    first = integrate(problem, request, tolerance=tolerance)
    missed = np.isnan(first.maximum)
    if not missed.any():
        return _Extremes(first.maximum, first.minimum, first.error, first.states)
    coarse = integrate(
        replace(problem, invalid=~missed), request, tolerance=_FALLBACK_EXTREMES_TOLERANCE
    )
    return _merge(first, coarse, missed)


def _merge(first: Outcome, coarse: Outcome, missed: NDArray[np.bool_]) -> _Extremes:
    """The first outcome, where it was missed the other one."""
    states = first.states
    if states is not None and coarse.states is not None:
        states = np.where(missed[:, None, None], coarse.states, states)
    return _Extremes(
        np.where(missed, coarse.maximum, first.maximum),
        np.where(missed, coarse.minimum, first.minimum),
        np.where(missed, coarse.error, first.error),
        states,
    )


def _observables_at_periods(
    tracing: Tracing, problem: Problem, count: int, states: FloatArray
) -> Mapping[str, FloatArray]:
    """Observables at the beginning of each drive period of the orbits, arrays (point, period)."""
    rest = np.zeros((len(problem.duration) - count, *states.shape[1:]))
    padded = np.concatenate([states, rest + states[:1]])
    times = np.zeros(padded.shape[:2])
    return {
        name: evaluate_observable(problem, name, times, padded)[:count]
        for name in observed_names(tracing)
    }
