"""Where a quantity passes through a value: sections of any motion, periodic load or not."""

from __future__ import annotations

import numpy as np
import xarray as xr

from remanent._checks import finite, require_choice, require_real
from remanent._typing import ArrayLike, IntArray
from remanent.integrate import events
from remanent.integrate.ensemble.ensemble import Progress
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectory, to_dataset
from remanent.studies.ensemble.durations import durations, require_one
from remanent.studies.ensemble.ensemble import Over, ensemble, problem, require_memory

_VALUE = finite("It is the value that is passed.")
_DIRECTIONS = {"both": (-1, 0, 1), "up": (1,), "down": (-1,)}


def crossings(
    system: Actuator,
    drive: Drive,
    variable: str,
    value: float,
    *,
    direction: str = "both",
    duration: float | None = None,
    periods: int | None = None,
    initial: ArrayLike | None = None,
    over: Over | None = None,
    tolerance: float = 1e-9,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Find every instant at which a variable passes through a value.

    Parameters
    ----------
    system, drive
        What moves, and the magnetic load on it.
    variable
        ``"thickness_stretch"``, ``"thickness_stretch_rate"``, or a state variable.
    value
        That it passes.  Rates that pass through 0 are extremes of the motion.
    direction
        ``"up"``, ``"down"``, or ``"both"``, which includes touches.
    duration, periods
        Length of the run, in tau or in drive periods; exactly one.
    initial, over, tolerance, progress
        As for :func:`remanent.simulate`.

    Returns
    -------
    xarray.Dataset
        Against ``crossing``: ``crossing_time``, NaN where a trajectory has fewer, the state
        there, and ``direction``: 1 upwards, −1 downwards, 0 a touch; ``crossings``, how many
        there are; ``error`` of the states, ``horizon``, ``status`` per trajectory.

    Raises
    ------
    InputError
        A bad argument; the message says which and what to do.

    Notes
    -----
    Bracketed roots of the dense output, to the last digit of the time within the step.  Two
    passages within one step are told apart by the extremum between them; an extremum within
    the tolerance of the value counts as a touch.  A start on the value is not a passage.

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
    require_one(duration=duration, periods=periods)
    require_tolerance(tolerance)
    value = require_real("value", value, _VALUE)
    require_choice("direction", direction, list(_DIRECTIONS))
    ens = ensemble(system, drive, over, initial)
    known = ["thickness_stretch", "thickness_stretch_rate", *ens.field.state]
    require_choice("variable", variable, known)
    asked = problem(ens, durations(ens, duration, periods))
    found, outcome = events.find_crossings(
        asked, variable, value, tolerance=tolerance, progress=progress
    )
    wanted = np.isin(found.direction, _DIRECTIONS[direction])
    row = found.trajectory[wanted]
    count = np.bincount(row, minlength=ens.count)
    most = int(count.max(initial=0))
    require_memory(8.0 * ens.count * most * (2 + len(ens.field.state)), "the crossings")
    column = np.arange(row.size) - (np.cumsum(count) - count)[row]

    def table(values: np.ndarray, missing: float) -> PerTrajectory:
        padded = np.full((ens.count, most), missing, dtype=values.dtype)
        padded[row, column] = values[wanted]
        return ("crossing",), padded

    variables: dict[str, PerTrajectory] = {"crossing_time": table(found.time, np.nan)}
    for k, name in enumerate(ens.field.state):
        variables[name] = table(found.states[:, k], np.nan)
    variables["direction"] = table(found.direction.astype(np.int8), 0)
    variables["crossings"] = count
    numbers: IntArray = np.arange(most)
    coords: dict[str, Labelled] = {"crossing": (("crossing",), numbers)}
    return to_dataset(
        ens, variables, coords=coords, outcome=outcome, tolerance=tolerance,
        variable=variable, value=value, direction=direction, duration=duration, periods=periods,
    )  # fmt: skip
