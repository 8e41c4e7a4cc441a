"""Where a quantity passes through a value: sections of any motion, periodic load or not."""

from __future__ import annotations

import numpy as np
import xarray as xr

from remanent._checks import finite_rule, require_choice, require_real
from remanent._typing import ArrayLike
from remanent.integrate import events
from remanent.models.system import System
from remanent.studies.ensemble.checks import DriveArgument, require_tolerance
from remanent.studies.ensemble.durations import require_exactly_one_argument, trajectory_durations
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.ensemble.quantities import without_unit
from remanent.studies.motion._passages import passages_dataset

_PASSED_VALUE_RULE = finite_rule("It is the value that is passed.")
#: Energies whose passages are found too.
_ENERGY_NAMES = ("energy", "stored_energy")
#: Signs of the passages that each `direction` stands for; 0 is a touch.
_SIGNS_OF_DIRECTION = {"both": (-1, 0, 1), "up": (1,), "down": (-1,)}


def crossings(
    system: System,
    drive: DriveArgument,
    variable: str,
    value: float,
    *,
    direction: str = "both",
    duration: float | None = None,
    periods: int | None = None,
    initial: ArrayLike | None = None,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Find every instant at which a variable passes through a value.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        The magnetic load on it.
    variable : str
        ``"thickness_stretch"``, ``"thickness_stretch_rate"``, a state variable, ``"energy"``
        or ``"stored_energy"``.
    value : float
        That it passes.  Rates that pass through 0 are extremes of the motion.
    direction : str
        ``"up"``, ``"down"``, or ``"both"``, which includes touches.
    duration : float, str or quantity, optional
        Length of the run in units of tau; with a unit, ``"60 ms"``, where
        the actuator has SI sizes.
    periods : int, optional
        Length of the run in smallest periods of the load.  Exactly one of `duration` and
        `periods` must be given.
    initial : array_like (2,), (4,) or (state,), optional
        State to start from; rest by default, as for :func:`remanent.simulate`.
    over : mapping of str to array_like or DataArray, optional
        Values of numeric fields; they become dimensions of the result.
    tolerance : float
        Largest error of the state that is allowed, at any of the times; absolute.
    progress : bool or callable, optional
        True draws a bar; a function is called with the share that is done.

    Returns
    -------
    xarray.Dataset
        Against ``crossing``: ``crossing_time`` and ``crossing_time_error``, NaN where a
        trajectory has fewer; the state there and ``state_error``, the largest over its
        variables, which counts the error of the time too; ``direction``: 1 upwards, −1
        downwards, 0 a touch.  ``crossings``, how many there are: a count, that of the motion
        within its error; ``error`` of the states at given times, ``horizon``, ``status`` per
        trajectory.

    Raises
    ------
    InputError
        A bad argument; the message says which and what to do.

    See Also
    --------
    poincare_section : The state at one phase of every period.
    step_response : Overshoot and settling after a step.

    Notes
    -----
    Bracketed roots of the dense output, to the last digit of the time within the step.  Two
    passages within one step are told apart by the extremum between them; an extremum within
    the tolerance of the value counts as a touch.  A start on the value is not a passage.
    While the motion stays as near to the value as the tolerance, it passes it as its error
    does: such passages count as the one, or the touch, that is left of them, and as none where
    the motion comes to rest on the value.  An energy that jumps past the value with a step of
    the load does not pass through it.

    With an error d of the variable, and r and a the sizes of its first and second derivative
    there, the error of the time is t with d = r t − a t²/2, or (1 + √2) √(2 d/a) where the
    motion may turn first.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.crossings(
    ...     rm.Actuator(),
    ...     rm.Constant(0.16),
    ...     "thickness_stretch_rate",
    ...     0.0,
    ...     direction="down",
    ...     duration=20,
    ... )
    >>> ds.sizes["crossing"], float(ds.crossing_time[0].round(3))
    (8, 1.318)
    """
    require_exactly_one_argument(duration=duration, periods=periods)
    tolerance = require_tolerance(tolerance, "the global error of the state")
    duration = without_unit("duration", duration, "time", system)
    value = require_real("value", value, _PASSED_VALUE_RULE)
    require_choice("direction", direction, list(_SIGNS_OF_DIRECTION))
    report = as_progress(progress)
    ens = lay_out_ensemble(system, drive, over, initial)
    require_choice(
        "variable",
        variable,
        [
            *ens.vector_field.observable_and_rate_names,
            *ens.vector_field.state_names,
            *(name for name in _ENERGY_NAMES if name in ens.vector_field.observables),
        ],
    )
    problem = initial_value_problem(ens, trajectory_durations(ens, duration, periods))
    passages, outcome = events.find_crossings(
        problem, variable, value, tolerance=tolerance, progress=report
    )
    return passages_dataset(
        ens,
        passages.subset(np.isin(passages.direction, _SIGNS_OF_DIRECTION[direction])),
        outcome,
        tolerance=tolerance,
        variable=variable,
        value=value,
        direction=direction,
        duration=duration,
        periods=periods,
    )
