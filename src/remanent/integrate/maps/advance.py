"""The period map as something that follows trajectories, each with steps of its own."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble.resolution import MAX_RESOLUTION, round_up_resolution
from remanent.integrate.maps.period_map import PeriodMap, PeriodMapImage

#: Tangents enter with this size: their errors are controlled relative to the larger of their
#: size and 1, and an exponent needs fewer of their digits than of the state's.
_INITIAL_TANGENT_SIZE = 1e-3
#: States up to this have an absolute error, larger ones an error relative to them.
_MAX_STATE_SIZE_WITH_ABSOLUTE_ERROR = 10.0
#: After so many periods a resolution may fall again to what the errors of these asked for.
_RESOLUTION_MEMORY_PERIODS = 64
#: Resolution aims this factor below the tolerance.
_TOLERANCE_SHARE_AIMED_AT = 0.3
#: Double steps per period of the first block.
_FIRST_BLOCK_RESOLUTION = 8
#: Fewest double steps per period.
_MIN_RESOLUTION = 6
#: Errors count as no smaller than this share of the aim: a smaller one is round-off.
_MIN_ERROR_SHARE_OF_AIM = 1e-8


@dataclass(frozen=True)
class BlockImage:
    """What became of trajectories in one block; a `TangentImage` of the analysis.

    Attributes
    ----------
    visited_states : array (trajectory, period, state)
        The state after each period, or after the last one.
    tangents : array (trajectory, column, state)
        After the last period.
    largest_period_error : array (trajectory,)
        Estimated largest error that one period adds.
    error_bound_met : array (trajectory,) of bool
        Whether it met the tolerance.
    """

    visited_states: FloatArray
    tangents: FloatArray
    largest_period_error: FloatArray
    error_bound_met: BoolArray


@dataclass
class BlockAdvancer:
    """Advances trajectories that differ in parameters and in the steps they need.

    Resolution is kept from block to block, raised where the error of a period exceeds the
    tolerance, and lowered where a few blocks in a row could do with less.  What a trajectory
    undergoes depends on itself alone.

    What changes: with each call `resolution_history` grows, and the resolution of the next
    block is learnt.

    Attributes
    ----------
    period_map : PeriodMap
    parameters : array (trajectory, parameter)
    period_lengths : array (trajectory,)
        Of a period, tau.
    tolerance : float
        Of the error of a period.
    max_resolution : int
        Most double steps per period.
    resolution_history : list of array (trajectory,)
        Resolutions of each block so far.
    """

    period_map: PeriodMap
    parameters: FloatArray
    period_lengths: FloatArray
    tolerance: float
    max_resolution: int = MAX_RESOLUTION
    resolution_history: list[NDArray[np.int16]] = field(default_factory=list, repr=False)
    _resolution: IntArray = field(init=False, repr=False)
    _needed_resolution: FloatArray = field(init=False, repr=False)
    _periods_since_lowering: IntArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        count = self.period_lengths.size
        self._resolution = np.full(count, _FIRST_BLOCK_RESOLUTION, dtype=np.int64)
        # Largest resolution needed, and periods advanced, since it was last lowered.
        self._needed_resolution, self._periods_since_lowering = (
            np.zeros(count),
            np.zeros(count, dtype=np.int64),
        )

    def __call__(
        self,
        indices: IntArray,
        states: FloatArray,
        tangents: FloatArray,
        periods: int,
        *,
        every: bool,
    ) -> BlockImage:
        """Advance some of the trajectories by so many periods.

        Parameters
        ----------
        indices : array (trajectory,)
            Their numbers.
        states : array (trajectory, state)
        tangents : array (trajectory, column, state)
        periods : int
        every : bool
            Keep the state after each period.
        """
        # Far away a digit is worth more: what escapes must be followed until it has.
        size = np.abs(states).max(axis=1)
        tolerance = self.tolerance * np.maximum(size / _MAX_STATE_SIZE_WITH_ABSOLUTE_ERROR, 1.0)
        image = self.period_map(
            states,
            self.parameters[indices],
            self.period_lengths[indices],
            tolerance=tolerance,
            cycles=periods,
            tangent=_INITIAL_TANGENT_SIZE * tangents,
            resolution=self._resolution[indices],
            max_resolution=self.max_resolution,
            visited=every,
        )
        self.resolution_history.append(self._block_resolution(indices, image.resolution))
        self._learn_resolution(indices, image, tolerance, periods)
        trusted = np.asarray(image.largest_period_error <= tolerance)
        return BlockImage(
            _visited_states(image),
            image.tangents / _INITIAL_TANGENT_SIZE,
            image.largest_period_error,
            trusted,
        )

    def _block_resolution(self, indices: IntArray, resolution: IntArray) -> NDArray[np.int16]:
        """Resolutions of this block, those of trajectories that are not in it as they were."""
        block = self._resolution.astype(np.int16)
        block[indices] = resolution
        return block

    def _learn_resolution(
        self, indices: IntArray, image: PeriodMapImage, tolerance: FloatArray, periods: int
    ) -> None:
        """Keep the resolution, and lower it where the last periods needed less."""
        with np.errstate(all="ignore"):
            share = np.maximum(
                image.largest_period_error / (_TOLERANCE_SHARE_AIMED_AT * tolerance),
                _MIN_ERROR_SHARE_OF_AIM,
            )
            needed = image.resolution * share ** (1.0 / self.period_map.order)
        self._needed_resolution[indices] = np.fmax(self._needed_resolution[indices], needed)
        self._resolution[indices] = image.resolution
        self._periods_since_lowering[indices] += periods
        due = indices[self._periods_since_lowering[indices] >= _RESOLUTION_MEMORY_PERIODS]
        needed = np.clip(self._needed_resolution[due], _MIN_RESOLUTION, self.max_resolution)
        self._resolution[due] = np.minimum(self._resolution[due], round_up_resolution(needed))
        self._needed_resolution[due], self._periods_since_lowering[due] = 0.0, 0


@dataclass
class CoarseReplay:
    """Advances trajectories once more, with steps twice as long as in an earlier run.

    What the two runs have in common does not come from the steps.  No error is estimated.

    What changes: calls are counted, since each replays one block of the earlier run.

    Attributes
    ----------
    period_map : PeriodMap
        A map that controls no error.
    parameters : array (trajectory, parameter)
    period_lengths : array (trajectory,)
        Of a period, tau.
    resolution_history : list of array (trajectory,)
        Resolutions of each block of the earlier run, in the same order.
    """

    period_map: PeriodMap
    parameters: FloatArray
    period_lengths: FloatArray
    resolution_history: list[NDArray[np.int16]]
    _next_block_number: int = field(init=False, default=0, repr=False)

    def __call__(
        self,
        indices: IntArray,
        states: FloatArray,
        tangents: FloatArray,
        periods: int,
        *,
        every: bool,
    ) -> BlockImage:
        """Advance some of the trajectories by so many periods."""
        last = len(self.resolution_history) - 1
        resolution = self.resolution_history[min(self._next_block_number, last)][indices]
        self._next_block_number += 1
        image = self.period_map(
            states,
            self.parameters[indices],
            self.period_lengths[indices],
            tolerance=np.inf,
            cycles=periods,
            tangent=_INITIAL_TANGENT_SIZE * tangents,
            resolution=round_up_resolution(0.5 * resolution.astype(np.float64)),
            visited=every,
        )
        finite = np.asarray(np.isfinite(image.state).all(axis=1))
        unknown = np.zeros(indices.size)
        return BlockImage(
            _visited_states(image), image.tangents / _INITIAL_TANGENT_SIZE, unknown, finite
        )


def _visited_states(image: PeriodMapImage) -> FloatArray:
    """The states after each period, or after the last one."""
    return image.state[:, None] if image.visited_states is None else image.visited_states
