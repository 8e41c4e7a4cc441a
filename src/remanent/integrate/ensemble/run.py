"""What all chunks of a run have in common, and what becomes of one of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble.problem import Problem, Request
from remanent.integrate.ensemble.work_sizes import DEFAULT_WORK_SIZES, WorkSizes
from remanent.integrate.kernel.compile import KernelPair
from remanent.integrate.kernel.tables import CycleTables

#: Errors from this on are outside the asymptotic range: they no longer follow the order of the
#: method.
ASYMPTOTIC_ERROR_LIMIT = 1e-2


@dataclass(frozen=True)
class Run:
    """What every chunk of a run is integrated with.

    Attributes
    ----------
    problem : Problem
    request : Request
    kernel_pair : KernelPair
        For the start of a piece and for the rest.
    tolerance : float
        Of the controlled error, absolute.
    cycle_tables : CycleTables
        Of the load.
    work_sizes : WorkSizes
        Of chunks and segments.
    """

    problem: Problem
    request: Request
    kernel_pair: KernelPair
    tolerance: float
    cycle_tables: CycleTables
    work_sizes: WorkSizes = DEFAULT_WORK_SIZES

    @property
    def error_ceiling(self) -> float:
        """An error from which on a trajectory tells nothing more about its resolution."""
        return max(self.tolerance, ASYMPTOTIC_ERROR_LIMIT)

    @property
    def records_every_step(self) -> bool:
        """Whether the state after every step is looked at."""
        return self.request.times is not None or self.request.inspect_window is not None


@dataclass(frozen=True)
class Chunk:
    """Trajectories that one thread integrates together.

    Attributes
    ----------
    resolution : int or array (trajectory,)
        Double steps per cycle, or per nominal time where the load has no period.  Of an array
        they may differ.
    indices : array (trajectory,)
        Numbers of the trajectories; those of one resolution have equally many double steps in
        every piece.
    """

    resolution: int | IntArray
    indices: IntArray


@dataclass(frozen=True)
class Attempt:
    """What became of the trajectories of a chunk at its resolution.

    Attributes
    ----------
    within_tolerance : array (trajectory,) of bool
        Whether the controlled error met the tolerance up to the end.
    horizon, error_to_horizon : array (trajectory,)
        Where it did not: time up to which it did, and its largest value until then.
    largest_error : array (trajectory,)
        Largest value of the controlled error.
    maximum, minimum : array (trajectory,)
        Extremes of the watched observable, up to the horizon.
    maximum_time, minimum_time : array (trajectory,)
        When they occur, tau.
    last_state : array (trajectory, state)
        State at the end, or at the horizon.
    states : array (trajectory, sample, state), optional
        At the times of the request.
    inspection_results : list
        What ``Request.inspect_window`` returned.
    """

    within_tolerance: BoolArray
    horizon: FloatArray
    error_to_horizon: FloatArray
    largest_error: FloatArray
    maximum: FloatArray
    minimum: FloatArray
    maximum_time: FloatArray
    minimum_time: FloatArray
    last_state: FloatArray
    states: FloatArray | None
    inspection_results: list[Any]

    @property
    def state_size(self) -> FloatArray:
        """Largest component of the last state, array (trajectory,)."""
        return np.asarray(np.abs(self.last_state).max(axis=1))
