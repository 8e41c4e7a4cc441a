"""When the states of a run are returned."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._checks import require_increasing
from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray
from remanent.results.build import Labelled
from remanent.studies.ensemble.durations import trajectory_durations
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.memory import BYTES_PER_SAMPLE, require_memory
from remanent.studies.ensemble.quantities import without_unit

#: Points of the default time grid per unit of tau.
_DEFAULT_POINTS_PER_TAU = 20
#: Least number of intervals of the default time grid.
_FEWEST_DEFAULT_INTERVALS = 200
#: Largest number of intervals of the default time grid.
_MOST_DEFAULT_INTERVALS = 20_000
#: A run has to last: that of the one time 0 lasts this long.
_SHORTEST_DURATION = float(np.finfo(np.float64).tiny)


@dataclass(frozen=True)
class TimeGrid:
    """Times at which states are returned.

    Attributes
    ----------
    times : array (trajectory, time)
        In tau, each row increasing.
    is_shared : bool
        Whether all trajectories have the same times.
    """

    times: FloatArray
    is_shared: bool

    @property
    def durations(self) -> FloatArray:
        """Length of every trajectory, up to the last of its times, array (trajectory,)."""
        return np.maximum(self.times[:, -1], _SHORTEST_DURATION)

    @property
    def time_dimension(self) -> str:
        """The dimension along which times lie: ``cycle`` where they differ."""
        return "time" if self.is_shared else "cycle"

    def time_coordinate(self, ens: Ensemble) -> Labelled:
        """The coordinate ``time``: one row where all share it, else one for each trajectory."""
        if self.is_shared:
            return (self.time_dimension,), self.times[0]
        return (*ens.dims, self.time_dimension), ens.reshape_to_dims(self.times)


def time_grid(
    ens: Ensemble, duration: float | None, periods: int | None, times: ArrayLike | None
) -> TimeGrid:
    """The times that a verb was asked for, by exactly one of its three arguments.

    Parameters
    ----------
    ens : Ensemble
    duration : float, optional
        Length of the run in tau; the grid is uniform from 0 to its end.
    periods : int, optional
        Length of the run in drive periods.
    times : array_like (time,), optional
        The times themselves.
    """
    if times is not None:
        return _grid_of_given_times(ens, times)
    end = trajectory_durations(ens, duration, periods)
    counts = ~ens.is_invalid if not ens.is_invalid.all() else np.isfinite(end)
    longest = float(np.nanmax(np.where(counts, end, 0.0), initial=0.0))
    intervals = np.clip(
        np.ceil(_DEFAULT_POINTS_PER_TAU * longest),
        _FEWEST_DEFAULT_INTERVALS,
        _MOST_DEFAULT_INTERVALS,
    )
    points = int(intervals) + 1
    require_memory_for_samples("over", ens, points)
    grid = np.linspace(0.0, 1.0, points) * end[:, None]
    grid[:, -1] = end  # the product may differ from it in the last digit
    return TimeGrid(grid, is_shared=bool(np.all(end == end[0])))


def _grid_of_given_times(ens: Ensemble, times: ArrayLike) -> TimeGrid:
    instants = require_increasing(
        "times",
        without_unit("times", times, "time", ens.system),
        what="instants in tau",
        why="The state is returned at each of them.",
    )
    if instants[0] < 0.0:
        raise InputError(
            "times",
            must="not be negative",
            got=float(instants[0]),
            why="The motion starts at tau = 0.",
            fix="Pass times from 0 on.",
        )
    require_memory_for_samples("times", ens, instants.size)
    return TimeGrid(np.tile(instants, (ens.trajectory_count, 1)), is_shared=True)


def require_memory_for_samples(name: str, ens: Ensemble, samples: int) -> None:
    """Refuse more samples of each trajectory than memory holds, by the argument at fault."""
    require_memory(
        name,
        BYTES_PER_SAMPLE * ens.trajectory_count * samples,
        f"{ens.trajectory_count} x {samples} states",
    )
