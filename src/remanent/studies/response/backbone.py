"""Free oscillations: how their frequency depends on amplitude and energy."""

from __future__ import annotations

import numpy as np
import xarray as xr

from remanent._checks import as_float_array
from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray, IntArray
from remanent.integrate import events
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Problem, Request
from remanent.models.actuator import Actuator
from remanent.models.drives.waves import Constant
from remanent.studies.ensemble.checks import require_actuator, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectory, to_dataset
from remanent.studies.ensemble.layout import Over, lay_out, require_over
from remanent.studies.ensemble.observables import observe
from remanent.studies.ensemble.problem import initial_value_problem

#: A half-period is looked for up to this time, then this much longer, so many times.
_FIRST, _LONGER, _TRIES = 8.0, 4.0, 5


def backbone(
    actuator: Actuator,
    stretch: ArrayLike,
    *,
    m: float = 0.0,
    over: Over | None = None,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """Frequency of the free oscillations that start at rest from given stretches.

    Parameters
    ----------
    actuator
        With one coordinate, without dissipation and heat balance.
    stretch : array (initial.stretch,)
        Turning points λ(0), increasing.
    m
        Constant magnetic load.
    over
        Values of numeric fields; they become dimensions of the result.
    tolerance
        Asked of the state at the other turning point.

    Returns
    -------
    xarray.Dataset
        Against ``initial.stretch``: ``frequency`` with ``frequency_error``, ``energy``,
        ``maximum``, ``minimum`` and ``amplitude`` of the thickness stretch; ``error``,
        ``horizon``, ``status``.

    Raises
    ------
    InputError
        A bad argument, or an actuator with dissipation, heat or two coordinates: two have
        free oscillations of several kinds, most of which have no period.

    Notes
    -----
    Half a period passes from one turning point to the other, which is a root of the rate in
    the dense output.  A forced response bends along this curve: drive periods of
    ``SineSquared`` are half its flux's, so its resonance ω is half the frequency.

    Examples
    --------
    >>> import numpy as np, remanent as rm
    >>> ds = rm.backbone(rm.Actuator(), np.linspace(1.0001, 3.0, 9))
    >>> bool(abs(ds.frequency[0] - 6**0.5) < 1e-6)
    True
    """
    require_tolerance(tolerance, "the error of the state at the other turning point")
    require_actuator("actuator", actuator)
    if not actuator.conservative or actuator.coordinates > 1:
        raise InputError(
            "actuator",
            must="have one coordinate, no dissipation and no heat balance",
            got=actuator,
            why="Only free oscillations of one coordinate all have a period.",
            fix="Pass one number as prestress, no edges, dissipation=() and heat=None.",
        )
    require_over(over)
    stretches = as_float_array(
        "stretch",
        stretch,
        what="in-plane stretches",
        why="An oscillation starts from each.",
        fix="Pass for example numpy.linspace(1.01, 1.5, 50).",
        least=1,
    )
    ens = lay_out(
        actuator,
        Constant(m),
        {**(over or {}), "initial.stretch": stretches},
        system_argument="actuator",
    )
    half, error = np.full(ens.count, np.nan), np.full(ens.count, np.nan)
    duration = _FIRST
    for _ in range(_TRIES):
        missing = np.isnan(half) & ~ens.invalid
        if not missing.any():
            break
        asked = initial_value_problem(ens, np.full(ens.count, duration))
        found, outcome = events.crossings(asked, "stretch_rate", 0.0, tolerance=tolerance)
        rows, first = np.unique(found.trajectory, return_index=True)
        acceleration = _acceleration(asked, rows, found.states[first])
        half[rows] = found.time[first]
        error[rows] = outcome.error[rows] / np.abs(acceleration)
        duration *= _LONGER
    whole = initial_value_problem(ens, np.where(np.isfinite(half), 2.0 * half, 1.0))
    outcome = integrate(whole, Request(extremes=True), tolerance=tolerance)
    start = observe(whole, "energy", np.zeros((ens.count, 1)), ens.initial[:, None])[:, 0]
    with np.errstate(all="ignore"):
        frequency = np.pi / half
    variables: dict[str, PerTrajectory] = {
        "frequency": frequency,
        "frequency_error": frequency * error / half,
        "energy": start,
        "maximum": outcome.maximum,
        "minimum": outcome.minimum,
        "amplitude": 0.5 * (outcome.maximum - outcome.minimum),
    }
    return to_dataset(ens, variables, outcome=outcome, tolerance=tolerance)


def _acceleration(asked: Problem, rows: IntArray, states: FloatArray) -> FloatArray:
    """How fast the rate passes zero."""
    inputs = [np.zeros(rows.size), *states.T, *asked.parameters[rows].T]
    return np.asarray(asked.field.rates(inputs, functions=np)[1])
