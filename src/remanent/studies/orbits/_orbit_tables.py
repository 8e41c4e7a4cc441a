"""What is told of periodic orbits: multipliers, stability, extremes of the thickness."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remanent._typing import FloatArray
from remanent.analysis.orbits.periodic_orbits import PeriodicOrbits
from remanent.analysis.orbits.stability import Stability, floquet_multipliers, orbit_stability
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Request
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.problem import initial_value_problem

#: Dimensions that results about orbits have of their own.
ORBIT_DIMENSIONS = frozenset(
    {"orbit", "state", "multiplier", "branch", "point", "special", "end", "peak", "harmonic"}
)
#: Length of the longest word for stability.
_STABILITY_DTYPE = "<U9"
#: Tolerance of the extremes along an orbit.
_EXTREMES_TOLERANCE = 1e-8
#: The same for motions of large amplitude, which have fewer digits.
_FALLBACK_EXTREMES_TOLERANCE = 1e-5


def describe_orbits(
    ens: Ensemble, orbits: PeriodicOrbits, period: int, varied: Mapping[str, FloatArray]
) -> dict[str, NDArray[Any]]:
    """Columns about some orbits of one system, each an array (orbit, ...).

    Parameters
    ----------
    ens : Ensemble
        Of one trajectory.
    orbits : PeriodicOrbits
    period : int
        Of the orbits, in drive periods.
    varied : mapping of name to array (orbit,)
        Fields whose values differ between the orbits.
    """
    values, errors = floquet_multipliers(orbits.jacobian, orbits.image_error)
    kinds = orbit_stability(values, errors, conservative=ens.system.conservative)
    maximum, minimum = _thickness_extremes(ens, orbits.state, period, varied)
    return {
        "initial": orbits.state,
        "multipliers": values,
        "multipliers_error": errors,
        "stability": np.array([Stability(k).meaning for k in kinds], dtype=_STABILITY_DTYPE),
        "maximum": maximum,
        "minimum": minimum,
        "amplitude": 0.5 * (maximum - minimum),
        "residual": orbits.residual,
        "error": orbits.image_error,
    }


def empty_orbit_columns(state_variables: int) -> dict[str, NDArray[Any]]:
    """The columns of :func:`describe_orbits` without any orbit."""
    rows = np.empty((0, state_variables))
    return {
        "initial": rows,
        "multipliers": rows.astype(complex),
        "multipliers_error": rows,
        "stability": np.empty(0, dtype=_STABILITY_DTYPE),
        **dict.fromkeys(("maximum", "minimum", "amplitude", "residual", "error"), np.empty(0)),
    }


def _thickness_extremes(
    ens: Ensemble, states: FloatArray, period: int, varied: Mapping[str, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Largest and smallest thickness stretch over one period of each orbit."""
    if not len(states):
        return np.empty(0), np.empty(0)
    on_orbits = ens.with_initial_states(states, varied)
    problem = initial_value_problem(on_orbits, period * require_drive_periods(on_orbits))
    outcome = integrate(problem, Request(wants_extremes=True), tolerance=_EXTREMES_TOLERANCE)
    maximum, minimum = outcome.maximum, outcome.minimum
    missed = np.isnan(maximum)
    if missed.any():
        coarse = integrate(
            replace(problem, invalid=~missed),
            Request(wants_extremes=True),
            tolerance=_FALLBACK_EXTREMES_TOLERANCE,
        )
        maximum = np.where(missed, coarse.maximum, maximum)
        minimum = np.where(missed, coarse.minimum, minimum)
    return maximum, minimum
