"""When a trajectory is accepted, refined or given up: a decision without side effects.

Every attempt integrates a trajectory once, at one resolution.  It either meets the tolerance up
to the end (accept), or up to a horizon.  Then there are three reasons for the horizon, which
call for different answers:

* The steps were too long.  A finer attempt reaches further: refine.
* The motion magnifies errors (chaos), so that the horizon is set by round-off and hardly moves,
  however fine the steps are: give up and report the horizon.
* The motion escapes or is singular: give up and say so.

They are told apart by how the horizon and the error move from attempt to attempt.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from remanent._status import Status
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble.resolution import MAX_RESOLUTION, refine_resolution
from remanent.integrate.ensemble.run import ASYMPTOTIC_ERROR_LIMIT


@dataclass(frozen=True)
class TrajectoryScales:
    """What of some trajectories does not depend on how they are resolved.

    Attributes
    ----------
    duration : array (trajectory,)
        Of the run, tau.
    capped_cycle_length : array (trajectory,)
        Length of a cycle, at most the nominal time, tau.
    drive_slowness : array (trajectory,)
        How many times longer a drive period is than the nominal time, from 1 up to a limit.
    """

    duration: FloatArray
    capped_cycle_length: FloatArray
    drive_slowness: FloatArray


@dataclass(frozen=True)
class AttemptHistory:
    """What earlier attempts of some trajectories came to.

    Attributes
    ----------
    horizon : array (trajectory,)
        Of the attempt that reached furthest; NaN before the first one.
    resolution : array (trajectory,)
        Of the same attempt; 0 before the first one.
    largest_error : array (trajectory,)
        Of the last attempt; NaN before the first one.
    stall_counts : array (trajectory,)
        Attempts in a row that were finer and neither reached further nor had a smaller error.
    status : array (trajectory,) of int8
        Values of :class:`~remanent._status.Status`.
    """

    horizon: FloatArray
    resolution: IntArray
    largest_error: FloatArray
    stall_counts: IntArray
    status: NDArray[np.int8]


@dataclass(frozen=True)
class AttemptSummary:
    """What one attempt of some trajectories, at one resolution, came to.

    Attributes
    ----------
    resolution : int or array (trajectory,)
        Double steps per cycle, or per nominal time.
    within_tolerance : array (trajectory,) of bool
        Whether the tolerance was met up to the end.
    horizon : array (trajectory,)
        Time up to which the tolerance was met where it was not met to the end.
    error_to_horizon : array (trajectory,)
        Largest error until then.
    largest_error : array (trajectory,)
        Largest error of the whole attempt.
    state_size : array (trajectory,)
        Largest component of the state at the end, or at the horizon.
    """

    resolution: int | IntArray
    within_tolerance: BoolArray
    horizon: FloatArray
    error_to_horizon: FloatArray
    largest_error: FloatArray
    state_size: FloatArray


@dataclass(frozen=True)
class RefinementDecision:
    """What follows from an attempt.

    Attributes
    ----------
    is_improvement : array (trajectory,) of bool
        The attempt is the best so far: its results are kept.
    must_refine : array (trajectory,) of bool
        The trajectory is tried again.
    next_resolution : array (trajectory,)
        How finely.
    horizon : array (trajectory,)
        Time up to which this attempt met the tolerance.
    stall_counts : array (trajectory,)
    status : array (trajectory,) of int8
        As in :class:`AttemptHistory`, with this attempt.
    """

    is_improvement: BoolArray
    must_refine: BoolArray
    next_resolution: IntArray
    horizon: FloatArray
    stall_counts: IntArray
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
    max_stalled_horizon_growth_factor : float
        A horizon that grows by less than this factor has stalled.
    min_telling_refinement_factor : float
        A stalled attempt counts only if it is finer than the best one by this factor: steps
        that are hardly shorter reach hardly further, whatever the motion does.
    max_stalls : int
        Refinement is given up after so many stalled attempts in a row ...
    max_late_stalls : int
        ... or so many where the horizon lies late in the run, so that little is lacking.
    late_horizon_share_of_run : float
        The horizon is late past this share of the run.
    early_horizon_cycles : float
        Nothing is given up while the horizon lies within so many cycles, in which a fast
        stretch of time may just not be resolved.
    jump_error_share_of_tolerance : float
        An attempt does not count as stalled where the error was below this share of the
        tolerance until it exceeded it.  An error that *jumps* past the tolerance tells of
        steps too long for a fast stretch of the motion; one that *grows* past it, of a motion
        that magnifies errors.
    smaller_error_ratio : float
        Nor does one whose largest error is smaller than that of the attempt before by this
        factor.  Extremes are compared at turning points only, and of a run for those of its
        second half the horizon lies at the first turn there until it has reached the end.
    escape_state_size : float
        A state beyond this has left the range of any actuator.
    """

    tolerance: float
    order: int
    max_resolution: int = MAX_RESOLUTION
    max_stalled_horizon_growth_factor: float = 1.05
    min_telling_refinement_factor: float = 1.5
    max_stalls: int = 1
    max_late_stalls: int = 2
    late_horizon_share_of_run: float = 0.8
    early_horizon_cycles: float = 3.0
    jump_error_share_of_tolerance: float = 0.05
    smaller_error_ratio: float = 0.5
    escape_state_size: float = 1e6

    def decide(
        self, trajectories: TrajectoryScales, history: AttemptHistory, summary: AttemptSummary
    ) -> RefinementDecision:
        """What follows from an attempt, for every trajectory by itself.

        Parameters
        ----------
        trajectories : TrajectoryScales
        history : AttemptHistory
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
        stalled = horizon <= self.max_stalled_horizon_growth_factor * history.horizon
        stalls = self._count_stalls(stalled, history, summary)
        improved = met | (history.resolution == 0) | (horizon > history.horizon)
        # Steps that are too long run away as well, but not twice to the same time.
        escaped = ~met & stalled & (summary.state_size > self.escape_state_size)
        singular = ~met & (horizon <= 0.0) & np.isnan(summary.largest_error)
        in_vain = ~met & self._is_exhausted(trajectories, horizon, stalls)
        unfinished = ~met & ~in_vain & ~escaped
        resolution = self._next_resolution(summary)
        affordable = resolution <= self.max_resolution * trajectories.drive_slowness
        status = np.where(improved, np.where(met, Status.OK, Status.HORIZON), history.status)
        status = np.where(escaped, Status.ESCAPED, status)
        status = np.where(singular, Status.SINGULAR, status)
        # Where the largest resolution is reached: a run that had stalled ends with its horizon,
        # since it would soon have been given up; of another the resolution is what is lacking.
        furthest = np.where(improved, horizon, history.horizon)
        early = ~(furthest > self.early_horizon_cycles * trajectories.capped_cycle_length)
        capped = unfinished & ~affordable & (early | (stalls == 0))
        status = np.where(capped & (status != Status.SINGULAR), Status.MAX_STEPS, status)
        return RefinementDecision(
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
            asymptotic_limit=ASYMPTOTIC_ERROR_LIMIT,
        )

    def _count_stalls(
        self, stalled: BoolArray, history: AttemptHistory, summary: AttemptSummary
    ) -> IntArray:
        """How many attempts in a row have stalled and tell something."""
        jumped = summary.error_to_horizon < self.jump_error_share_of_tolerance * self.tolerance
        finer = summary.resolution >= self.min_telling_refinement_factor * history.resolution
        # The attempt before may have lost the motion, so that its error is infinite or NaN.
        smaller = summary.largest_error < np.fmin(
            self.smaller_error_ratio * history.largest_error, ASYMPTOTIC_ERROR_LIMIT
        )
        telling = stalled & ~jumped & finer
        return np.asarray(np.where(stalled & ~smaller, history.stall_counts + telling, 0))

    def _is_exhausted(
        self, trajectories: TrajectoryScales, horizon: FloatArray, stalls: IntArray
    ) -> BoolArray:
        """Where so many attempts have stalled that no finer one will reach the end."""
        late = horizon > self.late_horizon_share_of_run * trajectories.duration
        shown = horizon > self.early_horizon_cycles * trajectories.capped_cycle_length
        allowed = np.where(late, self.max_late_stalls, self.max_stalls)
        return np.asarray(shown & (stalls >= allowed))
