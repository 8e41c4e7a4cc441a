"""What an ensemble is asked and what it answers: plain arrays, trajectory first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from remanent._field import Field
from remanent._timeline import Timeline
from remanent._typing import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class Problem:
    """Many trajectories of one field.

    Attributes
    ----------
    field
        Of the equations of motion.
    timeline
        How the load runs.
    parameters : array (trajectory, parameter)
        In the order of ``field.parameters``.
    initial : array (trajectory, state)
        State at tau = 0.
    duration : array (trajectory,)
        End of each trajectory, tau.
    invalid : array (trajectory,) of bool
        Trajectories that must not be computed.
    """

    field: Field
    timeline: Timeline
    parameters: FloatArray
    initial: FloatArray
    duration: FloatArray
    invalid: BoolArray


@dataclass(frozen=True)
class Request:
    """What is wanted of every trajectory.

    Attributes
    ----------
    times : array (trajectory, time), optional
        When the state is wanted, ascending, tau.
    strobe : int
        If positive, the state is wanted at the start and after every `strobe` cycles.
    extremes : bool
        The largest and smallest value of the watched observable are wanted.
    begin : array (trajectory,), optional
        Extremes are taken from here on; from the start by default.
    """

    times: FloatArray | None = None
    strobe: int = 0
    extremes: bool = False
    begin: FloatArray | None = None


@dataclass(frozen=True)
class Outcome:
    """What became of every trajectory.

    Attributes
    ----------
    states : array (trajectory, sample, state), optional
        At the times asked; NaN beyond the horizon.
    maximum, minimum : array (trajectory,)
        Of the watched observable; NaN unless followed to the end.
    error : array (trajectory,)
        Estimated largest error up to the horizon: of the extremes if these are wanted,
        else of the states.
    horizon : array (trajectory,)
        Time up to which the tolerance was met.
    status : array (trajectory,) of int8
        Values of :class:`~remanent.integrate.status.Status`.
    resolution : array (trajectory,)
        Double steps per cycle (or per nominal time) that were needed.
    """

    states: FloatArray | None
    maximum: FloatArray
    minimum: FloatArray
    error: FloatArray
    horizon: FloatArray
    status: NDArray[np.int8]
    resolution: IntArray
