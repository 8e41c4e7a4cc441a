"""When a trajectory is accepted, refined or given up: a decision without side effects.

Every attempt integrates a trajectory once, at one resolution.  It either meets the tolerance up
to the end (accept), or up to a horizon.  Then there are three reasons for the horizon, which
call for different answers:

* The steps were too long.  A finer attempt reaches further: refine.
* The motion magnifies errors (chaos), so that the horizon is set by round-off and hardly moves,
  however fine the steps are: give up and report the horizon.
* The motion escapes or is singular: give up and say so.

They are told apart by how the horizon moves from attempt to attempt.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from remanent._status import Status
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble.resolution import MAX_RESOLUTION, refine_resolution
from remanent.integrate.ensemble.run import ASYMPTOTIC_LIMIT


@dataclass(frozen=True)
class Trajectories:
    """What of some trajectories does not depend on how they are resolved.

    Attributes
    ----------
    duration : array (trajectory,)
        Of the run, tau.
    cycle : array (trajectory,)
        Length of a cycle, at most the nominal time, tau.
    slowness : array (trajectory,)
        How many times longer a drive period is than the nominal time, from 1 up to a limit.
    """

    duration: FloatArray
    cycle: FloatArray
    slowness: FloatArray


@dataclass(frozen=True)
class History:
    """What earlier attempts of some trajectories came to.

    Attributes
    ----------
    horizon : array (trajectory,)
        Of the attempt that reached furthest; NaN before the first one.
    resolution : array (trajectory,)
        Of the same attempt; 0 before the first one.
    stalls : array (trajectory,)
        Attempts in a row that were finer and reached no further.
    status : array (trajectory,) of int8
        Values of :class:`~remanent._status.Status`.
    """

    horizon: FloatArray
    resolution: IntArray
    stalls: IntArray
    status: NDArray[np.int8]


@dataclass(frozen=True)
class AttemptSummary:
    """What one attempt of some trajectories, at one resolution, came to.

    Attributes
    ----------
    resolution : int
        Double steps per cycle, or per nominal time.
    within_tolerance : array (trajectory,) of bool
        Whether the tolerance was met up to the end.
    horizon : array (trajectory,)
        Time up to which the tolerance was met where it was not met to the end.
    error_to_horizon : array (trajectory,)
        Largest error until then.
    largest_error : array (trajectory,)
        Largest error of the whole attempt.
    size : array (trajectory,)
        Largest component of the state at the end, or at the horizon.
    """

    resolution: int
    within_tolerance: BoolArray
    horizon: FloatArray
    error_to_horizon: FloatArray
    largest_error: FloatArray
    size: FloatArray


@dataclass(frozen=True)
class Decision:
    """What follows from an attempt.

    Attributes
    ----------
    improved : array (trajectory,) of bool
        The attempt is the best so far: its results are kept.
    refine : array (trajectory,) of bool
        The trajectory is tried again.
    resolution : array (trajectory,)
        How finely.
    horizon : array (trajectory,)
        Time up to which this attempt met the tolerance.
    stalls : array (trajectory,)
    status : array (trajectory,) of int8
        As in :class:`History`, with this attempt.
    """

    improved: BoolArray
    refine: BoolArray
    resolution: IntArray
    horizon: FloatArray
    stalls: IntArray
    status: NDArray[np.int8]


@dataclass(frozen=True)
class RefinementPolicy:
    """Decides what follows from an attempt.

    Attributes
    ----------
    tolerance : float
        Of the controlled error, absolute.
    order : int
        Of the global error of the method.
    max_resolution : int
        Largest resolution tried; larger in proportion for a slow drive.
    stall_growth : float
        A horizon that grows by less than this factor has stalled.
    telling_refinement : float
        A stalled attempt counts only if it is finer than the best one by this factor: steps
        that are hardly shorter reach hardly further, whatever the motion does.
    stalls_allowed : int
        Refinement is given up after so many stalled attempts in a row ...
    late_stalls_allowed : int
        ... or so many where the horizon lies late in the run, so that little is lacking.
    late_share : float
        The horizon is late past this share of the run.
    early_cycles : float
        Nothing is given up while the horizon lies within so many cycles, in which a fast
        stretch of time may just not be resolved.
    jump_share : float
        An attempt does not count as stalled where the error was below this share of the
        tolerance until it exceeded it.  An error that *jumps* past the tolerance tells of
        steps too long for a fast stretch of the motion; one that *grows* past it, of a motion
        that magnifies errors.
    escape_size : float
        A state beyond this has left the range of any actuator.
    """

    tolerance: float
    order: int
    max_resolution: int = MAX_RESOLUTION
    stall_growth: float = 1.05
    telling_refinement: float = 1.5
    stalls_allowed: int = 1
    late_stalls_allowed: int = 2
    late_share: float = 0.8
    early_cycles: float = 3.0
    jump_share: float = 0.05
    escape_size: float = 1e6

    def decide(
        self, trajectories: Trajectories, history: History, summary: AttemptSummary
    ) -> Decision:
        """What follows from an attempt, for every trajectory by itself.

        Parameters
        ----------
        trajectories : Trajectories
        history : History
            Before the attempt.
        summary : AttemptSummary
            Of the attempt.

        Returns
        -------
        Decision
        """
        met = summary.within_tolerance
        horizon = np.where(met, trajectories.duration, summary.horizon)
        # Before the first attempt the horizon is NaN, so that nothing has stalled.
        stalled = horizon <= self.stall_growth * history.horizon
        stalls = self._stalls(stalled, history, summary)
        improved = met | (history.resolution == 0) | (horizon > history.horizon)
        # Steps that are too long run away as well, but not twice to the same time.
        escaped = ~met & stalled & (summary.size > self.escape_size)
        singular = ~met & (horizon <= 0.0) & np.isnan(summary.largest_error)
        in_vain = ~met & self._exhausted(trajectories, horizon, stalls)
        unfinished = ~met & ~in_vain & ~escaped
        resolution = self._next_resolution(summary)
        affordable = resolution <= self.max_resolution * trajectories.slowness
        status = np.where(improved, np.where(met, Status.OK, Status.HORIZON), history.status)
        status = np.where(escaped, Status.ESCAPED, status)
        status = np.where(singular, Status.SINGULAR, status)
        # Where the largest resolution is reached: a run that had stalled ends with its horizon,
        # since it would soon have been given up; of another the resolution is what is lacking.
        furthest = np.where(improved, horizon, history.horizon)
        early = ~(furthest > self.early_cycles * trajectories.cycle)
        capped = unfinished & ~affordable & (early | (stalls == 0))
        status = np.where(capped & (status != Status.SINGULAR), Status.MAX_STEPS, status)
        return Decision(
            np.asarray(improved),
            np.asarray(unfinished & affordable),
            resolution,
            np.asarray(horizon),
            stalls,
            status.astype(np.int8),
        )

    def _next_resolution(self, summary: AttemptSummary) -> IntArray:
        """What the order of the method predicts from the error of the attempt."""
        return refine_resolution(
            summary.resolution,
            summary.largest_error,
            self.tolerance,
            self.order,
            asymptotic_limit=ASYMPTOTIC_LIMIT,
        )

    def _stalls(self, stalled: BoolArray, history: History, summary: AttemptSummary) -> IntArray:
        """How many attempts in a row have stalled and tell something."""
        jumped = summary.error_to_horizon < self.jump_share * self.tolerance
        finer = summary.resolution >= self.telling_refinement * history.resolution
        telling = stalled & ~jumped & finer
        return np.asarray(np.where(stalled, history.stalls + telling, 0))

    def _exhausted(
        self, trajectories: Trajectories, horizon: FloatArray, stalls: IntArray
    ) -> BoolArray:
        """Where so many attempts have stalled that no finer one will reach the end."""
        late = horizon > self.late_share * trajectories.duration
        shown = horizon > self.early_cycles * trajectories.cycle
        allowed = np.where(late, self.late_stalls_allowed, self.stalls_allowed)
        return np.asarray(shown & (stalls >= allowed))
