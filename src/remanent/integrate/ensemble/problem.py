"""What an ensemble is asked and what it answers: plain arrays, trajectory first."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remanent._field import Field
from remanent._load_schedule import LoadSchedule
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble.segments import Segment

#: The error of a function of the state, by first-order propagation, over its derivatives times
#: the error of the state.  The latter is the largest over all variables and times, with a factor
#: of safety of four; a function that needs all of them at their worst at once can do without that
#: factor.  Measured by ``benchmarks.errors``.
ERROR_SHARE_IN_FUNCTIONS = 0.25
#: Extremes of the watched observable, and when they occur.
EXTREME_NAMES = ("maximum", "minimum", "maximum_time", "minimum_time")
#: Times that exceed the horizon by less than this, relative to it, are at it.
_RELATIVE_HORIZON_ROUNDING = 1e-12


@dataclass(frozen=True)
class Problem:
    """Many trajectories of one field.

    Attributes
    ----------
    field : Field
        Of the equations of motion.
    load_schedule : LoadSchedule
        How the load runs.
    parameters : array (trajectory, parameter)
        In the order of ``field.parameter_names``.
    initial_states : array (trajectory, state)
        State at tau = 0.
    duration : array (trajectory,)
        End of each trajectory, tau.
    invalid : array (trajectory,) of bool
        Trajectories that must not be computed.
    """

    field: Field
    load_schedule: LoadSchedule
    parameters: FloatArray
    initial_states: FloatArray
    duration: FloatArray
    invalid: BoolArray


@dataclass(frozen=True)
class StepWindow:
    """Consecutive steps of some trajectories, to be looked at.

    Attributes
    ----------
    indices : array (trajectory,)
        Numbers of the trajectories.
    states : array (trajectory, node, state)
        At the ends of the steps, the first at the beginning.
    segment : Segment
        Times and phases of the steps.
    phase : array (node,)
        Phase of the drive, or fraction of the piece, at the nodes.
    parameters : array (parameter, trajectory)
        In the order of ``field.parameter_names``.
    steps_in_run : array (trajectory,)
        How many of the steps belong to the run of each trajectory.
    """

    indices: IntArray
    states: FloatArray
    segment: Segment
    phase: FloatArray
    parameters: FloatArray
    steps_in_run: IntArray


@dataclass(frozen=True)
class Request:
    """What is wanted of every trajectory.

    Attributes
    ----------
    times : array (trajectory, time), optional
        When the state is wanted, ascending, tau.
    strobe_cycles : int
        If positive, the state is wanted at the start and after every `strobe_cycles` cycles.
    wants_extremes : bool
        The largest and smallest value of the watched observable are wanted.
    extremes_begin : array (trajectory,), optional
        Extremes are taken from here on; from the start by default.
    inspect_window : callable, optional
        Called with every :class:`StepWindow` of steps, from several threads; what it returns
        is gathered in ``Outcome.inspection_results``.
    """

    times: FloatArray | None = None
    strobe_cycles: int = 0
    wants_extremes: bool = False
    extremes_begin: FloatArray | None = None
    inspect_window: Callable[[StepWindow], Any] | None = None

    @property
    def is_of_extremes_alone(self) -> bool:
        """Whether no states are wanted, nor steps looked at."""
        others = self.times is not None or self.strobe_cycles or self.inspect_window is not None
        return self.wants_extremes and not others


@dataclass(frozen=True)
class Outcome:
    """What became of every trajectory.

    Attributes
    ----------
    states : array (trajectory, sample, state), optional
        At the times asked; NaN beyond the horizon.
    maximum, minimum : array (trajectory,)
        Of the watched observable; NaN unless followed to the end.
    maximum_time, minimum_time : array (trajectory,)
        When they occur, tau; of equal ones the first.
    error : array (trajectory,)
        Estimated largest error up to the horizon: of the extremes if these are wanted,
        else of the states.
    horizon : array (trajectory,)
        Time up to which the tolerance was met.
    status : array (trajectory,) of int8
        Values of :class:`~remanent._status.Status`.
    resolution : array (trajectory,)
        Double steps per cycle (or per nominal time) that were needed.
    inspection_results : tuple
        What ``Request.inspect_window`` returned, in no order.
    """

    states: FloatArray | None
    maximum: FloatArray
    minimum: FloatArray
    maximum_time: FloatArray
    minimum_time: FloatArray
    error: FloatArray
    horizon: FloatArray
    status: NDArray[np.int8]
    resolution: IntArray
    inspection_results: tuple[Any, ...] = ()

    def is_beyond_horizon(self, times: FloatArray) -> BoolArray:
        """Where `times`, array (trajectory, time), are past the horizon of their trajectory."""
        return np.asarray(times > latest_trusted_time(self.horizon)[:, None])


def latest_trusted_time(horizon: FloatArray) -> FloatArray:
    """The horizon with a margin for rounding: a time that was meant to be at it still counts."""
    return horizon * (1.0 + _RELATIVE_HORIZON_ROUNDING)


def merge_outcomes(count: int, parts: Iterable[tuple[slice | IntArray, Outcome]]) -> Outcome:
    """The outcome of `count` trajectories from those of their parts.

    Each part is put in its place and forgotten, so that memory is needed for all parts once and
    for one of them twice.  Arrays with one number for each trajectory are allocated before the
    parts are worked on.  Allocated later, they would lie between what the parts leave, and the
    memory of these could not be given back.

    Parameters
    ----------
    count : int
        Of trajectories.
    parts : iterable of (slice or array of int, Outcome)
        Which trajectories, and their outcome.
    """
    numbers = (*EXTREME_NAMES, "error", "horizon")
    columns: dict[str, Any] = {name: np.empty(count) for name in numbers}
    columns |= {"status": np.empty(count, np.int8), "resolution": np.empty(count, np.int64)}
    findings: list[Any] = []
    for part, outcome in parts:
        findings += outcome.inspection_results
        if outcome.states is not None:
            shape = (count, *outcome.states.shape[1:])
            columns.setdefault("states", np.empty(shape))[part] = outcome.states
        for name in (*numbers, "status", "resolution"):
            columns[name][part] = getattr(outcome, name)
    return Outcome(**{"states": None, **columns, "inspection_results": tuple(findings)})
