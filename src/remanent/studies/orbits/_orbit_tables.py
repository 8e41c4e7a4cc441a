"""What is told of periodic orbits: multipliers, stability, extremes of the thickness."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remanent._typing import FloatArray
from remanent.analysis.orbits.errors import OrbitErrors
from remanent.analysis.orbits.stability import Stability, floquet_multipliers, orbit_stability
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.problem import initial_value_problem

#: Dimensions that results about orbits have of their own.
ORBIT_DIMENSIONS = frozenset(
    {
        "orbit", "state", "multiplier", "branch", "point", "special", "end", "peak", "harmonic",
        "period",
    }
)  # fmt: skip
#: Length of the longest word for stability.
_STABILITY_DTYPE = "<U9"
#: Tolerance of the extremes along an orbit: below that of Adams steps, whose errors are told less
#: sharply over a single period.
_EXTREMES_TOLERANCE = 5e-11
#: The same for motions of large amplitude, which have fewer digits.
_FALLBACK_EXTREMES_TOLERANCE = 1e-5
#: Smallest step of the state that tells how an extreme depends on it.
_MIN_DIFFERENCE_STEP = 1e-6
#: What is told of the thickness stretch along an orbit.
_EXTREMES_COLUMNS = (
    "maximum", "minimum", "amplitude", "maximum_error", "minimum_error", "amplitude_error",
)  # fmt: skip


def describe_orbits(
    ens: Ensemble, orbits: OrbitErrors, period: int, varied: Mapping[str, FloatArray]
) -> dict[str, NDArray[Any]]:
    """Columns about some orbits of one system, each an array (orbit, ...).

    Parameters
    ----------
    ens : Ensemble
        Of one trajectory.
    orbits : OrbitErrors
    period : int
        Of the orbits, in drive periods.
    varied : mapping of name to array (orbit,)
        Fields whose values differ between the orbits.
    """
    values, errors = floquet_multipliers(orbits.jacobian, orbits.jacobian_error)
    # Where no orbit is confirmed near the point, nothing is known of the multipliers either.
    errors[~orbits.is_confirmed] = np.nan
    kinds = orbit_stability(values, errors, conservative=ens.system.conservative)
    return {
        "initial": orbits.state,
        "multipliers": values,
        "multipliers_error": errors,
        "stability": np.array([Stability(k).meaning for k in kinds], dtype=_STABILITY_DTYPE),
        **_thickness_extremes(ens, orbits, period, varied),
        "residual": orbits.residual,
        "error": orbits.error,
    }


def empty_orbit_columns(state_variables: int) -> dict[str, NDArray[Any]]:
    """The columns of :func:`describe_orbits` without any orbit."""
    rows = np.empty((0, state_variables))
    return {
        "initial": rows,
        "multipliers": rows.astype(complex),
        "multipliers_error": rows,
        "stability": np.empty(0, dtype=_STABILITY_DTYPE),
        **dict.fromkeys((*_EXTREMES_COLUMNS, "residual", "error"), np.empty(0)),
    }


def _thickness_extremes(
    ens: Ensemble, orbits: OrbitErrors, period: int, varied: Mapping[str, FloatArray]
) -> dict[str, FloatArray]:
    """Extremes of the thickness stretch over one period of each orbit, and their errors.

    The error of an extreme is that of the integration, and the error of each variable of the
    orbit's state times the change that a small step of that variable makes.
    """
    count, d = orbits.state.shape
    if not count:
        return dict.fromkeys(_EXTREMES_COLUMNS, np.empty(0))
    steps = np.fmax(orbits.state_error, _MIN_DIFFERENCE_STEP)
    places = np.concatenate([np.zeros((1, d)), np.eye(d)])
    states = (orbits.state[:, None, :] + steps[:, None, :] * places).reshape(-1, d)
    repeated = {name: np.repeat(v, d + 1) for name, v in varied.items()}
    columns = _extremes_of_motion(ens, states, period, repeated)
    maximum, minimum, error = (column.reshape(count, d + 1) for column in columns)
    weight = orbits.state_error / steps

    def error_of(extreme: FloatArray) -> FloatArray:
        change = np.abs(extreme[:, 1:] - extreme[:, :1])
        return np.asarray(error[:, 0] + (weight * change).sum(axis=1))

    extremes = {
        "maximum": maximum, "minimum": minimum, "amplitude": 0.5 * (maximum - minimum),
    }  # fmt: skip
    return {name: values[:, 0] for name, values in extremes.items()} | {
        f"{name}_error": error_of(values) for name, values in extremes.items()
    }


def _extremes_of_motion(
    ens: Ensemble, states: FloatArray, period: int, varied: Mapping[str, FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Largest and smallest thickness stretch over a period from each state, and their error."""
    runs = ens.with_initial_states(states, varied)
    problem = initial_value_problem(runs, period * require_drive_periods(runs))
    outcome = integrate(problem, Request(wants_extremes=True), tolerance=_EXTREMES_TOLERANCE)
    columns = outcome.maximum, outcome.minimum, outcome.error
    missed = np.isnan(outcome.maximum)
    if not missed.any():
        return columns
    coarse = integrate(
        replace(problem, invalid=~missed),
        Request(wants_extremes=True),
        tolerance=_FALLBACK_EXTREMES_TOLERANCE,
    )
    others = coarse.maximum, coarse.minimum, coarse.error
    maximum, minimum, error = (
        np.where(missed, other, column) for other, column in zip(others, columns, strict=True)
    )
    return maximum, minimum, error
