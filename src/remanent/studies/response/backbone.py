"""Free oscillations: how their frequency depends on amplitude and energy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from remanent._checks import as_float_array
from remanent._field import Role
from remanent._status import Status
from remanent._typing import ArrayLike
from remanent.models.system import System
from remanent.studies.ensemble.checks import require_system, require_tolerance
from remanent.studies.ensemble.constant_drive import ConstantLoadArgument, constant_drive
from remanent.studies.ensemble.dataset import to_dataset
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble, require_over
from remanent.studies.ensemble.observables import evaluate_observable
from remanent.studies.response._free_oscillations import (
    free_oscillations,
    require_free_oscillations,
)

#: Words for a frequency that is missing.
_STILL_REASON = "it starts at an equilibrium, where nothing moves"
_NO_TURN_REASON = "no other turning point was found in the time that was looked at"


def backbone(
    actuator: System,
    stretch: ArrayLike,
    *,
    m: ConstantLoadArgument = 0.0,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """Frequency of the free oscillations that start at rest from given stretches.

    Parameters
    ----------
    actuator : System
        An actuator, or a system of one's own, with one coordinate and without dissipation and
        heat balance.
    stretch : array (initial.stretch,)
        Turning points λ(0), or of the one coordinate, increasing.
    m : float, or mapping of str to float
        Constant magnetic load; of a system of one's own its load, or its loads by their names, 0
        where they are left out.
    over : mapping of name to values, optional
        Values of numeric fields; they become dimensions of the result.
    tolerance : float
        Of the state at the other turning point.

    Returns
    -------
    xarray.Dataset
        Against ``initial.stretch`` (or ``initial.`` and the coordinate): ``frequency`` with
        ``frequency_error``, ``energy``,
        ``maximum``, ``minimum`` and ``amplitude`` of the thickness stretch with
        ``amplitude_error``; ``error``, ``horizon``, ``status``.  At an equilibrium there is no
        oscillation: NaN, and ``singular``; where no other turning point was found,
        ``incomplete``; ``reason`` says so.  The energy is a closed form of the start.

    Raises
    ------
    InputError
        A bad argument, or an actuator with dissipation, heat or two coordinates: two have
        free oscillations of several kinds, most of which have no period.

    See Also
    --------
    response_diagram : Forced response, which bends along this curve.
    resonances : Which free oscillation resonates at each peak.

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
    tolerance = require_tolerance(tolerance, "the error of the state at the other turning point")
    actuator = require_system("actuator", actuator)
    drive = constant_drive(actuator, m)
    single = lay_out_ensemble(actuator, drive, system_argument="actuator")
    require_free_oscillations(single, "actuator")
    (coordinate,) = single.vector_field.names_of_roles(Role.COORDINATE)
    require_over(over)
    stretches = as_float_array(
        "stretch",
        stretch,
        what="stretches, or values of the coordinate,",
        why="An oscillation starts from each.",
        fix="Pass for example numpy.linspace(1.01, 1.5, 50).",
        least=1,
    )
    ens = lay_out_ensemble(
        actuator,
        drive,
        {**(over or {}), f"initial.{coordinate}": stretches},
        system_argument="actuator",
    )
    free = free_oscillations(ens, tolerance)
    start = np.zeros((ens.trajectory_count, 1))
    missing = free.frequency_is_missing & (free.outcome.status == Status.OK)
    still = missing & ((free.acceleration == 0.0) | (free.amplitude <= free.outcome.error))
    reasons = np.where(missing, np.where(still, _STILL_REASON, _NO_TURN_REASON), "")
    status = np.where(
        missing, np.where(still, Status.SINGULAR, Status.INCOMPLETE), free.outcome.status
    ).astype(np.int8)
    energy = evaluate_observable(free.problem, "energy", start, ens.initial_states[:, None])[:, 0]
    return to_dataset(
        ens,
        {
            "frequency": free.frequency,
            "frequency_error": free.frequency_error,
            "energy": np.where(ens.is_invalid, np.nan, energy),
            "maximum": free.outcome.maximum,
            "minimum": free.outcome.minimum,
            "amplitude": free.amplitude,
            "amplitude_error": np.where(np.isnan(free.amplitude), np.nan, free.outcome.error),
            "reason": reasons,
        },
        outcome=replace(free.outcome, status=status),
        tolerance=tolerance,
    )
