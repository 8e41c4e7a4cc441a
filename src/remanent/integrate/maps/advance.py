"""The period map as something that follows trajectories, each with steps of its own."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.integrate.ensemble.ensemble import MAX_RESOLUTION
from remanent.integrate.ensemble.resolution import ladder
from remanent.integrate.maps.period_map import Image, PeriodMap

#: Tangents enter with this size: their errors are controlled relative to the larger of their
#: size and 1, and an exponent needs fewer of their digits than of the state's.
_SIZE = 1e-3
#: States up to this have their error counted as it is, larger ones relative to it.
_NEAR = 10.0
#: Resolution may fall again to what was wanted in so many periods.
_MEMORY = 64
#: It aims this factor below the tolerance.
_AIM = 0.3


@dataclass(frozen=True)
class Step:
    """What became of trajectories in one block; it is a `TangentImage` of `analysis`."""

    visited: FloatArray
    tangents: FloatArray
    error: FloatArray
    trusted: BoolArray


@dataclass
class Advancer:
    """Advances trajectories that differ in parameters and in the steps they need.

    Resolution is kept from block to block, raised where the error of a period exceeds the
    tolerance, and lowered where a few blocks in a row could do with less.  What a trajectory
    undergoes depends on itself alone.

    Attributes
    ----------
    parameters : array (trajectory, parameter)
    lengths : array (trajectory,)
        Of a period.
    tolerance
        Of the error of a period.
    taken : list of array (trajectory,)
        Resolutions of each block so far.
    """

    flow: PeriodMap
    parameters: FloatArray
    lengths: FloatArray
    tolerance: float
    finest: int = MAX_RESOLUTION
    taken: list[NDArray[np.int16]] = field(default_factory=list, repr=False)
    _level: IntArray = field(init=False, repr=False)
    _wanted: FloatArray = field(init=False, repr=False)
    _since: IntArray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        count = self.lengths.size
        self._level = np.full(count, 8, dtype=np.int64)
        self._wanted, self._since = np.zeros(count), np.zeros(count, dtype=np.int64)

    def __call__(
        self,
        which: IntArray,
        states: FloatArray,
        tangents: FloatArray,
        periods: int,
        *,
        every: bool,
    ) -> Step:
        """Advance some of the trajectories by so many periods."""
        # Far away a digit is worth more: what escapes must be followed until it has.
        asked = self.tolerance * np.maximum(np.abs(states).max(axis=1) / _NEAR, 1.0)
        image = self.flow(
            states,
            self.parameters[which],
            self.lengths[which],
            tolerance=asked,
            cycles=periods,
            tangent=_SIZE * tangents,
            resolution=self._level[which],
            finest=self.finest,
            visited=every,
        )
        self.taken.append(self._taken(which, image.resolution))
        self._learn(which, image, asked, periods)
        visited = image.state[:, None] if image.visited is None else image.visited
        trusted = image.error <= asked
        return Step(visited, image.tangent / _SIZE, image.error, np.asarray(trusted))

    def _taken(self, which: IntArray, resolution: IntArray) -> NDArray[np.int16]:
        """Resolutions of this block, those of trajectories that are not in it as they were."""
        taken = self._level.astype(np.int16)
        taken[which] = resolution
        return taken

    def _learn(self, which: IntArray, image: Image, asked: FloatArray, periods: int) -> None:
        with np.errstate(all="ignore"):
            share = image.error / (_AIM * asked)
            wanted = image.resolution * np.maximum(share, 1e-8) ** (1.0 / self.flow.order)
        self._wanted[which] = np.fmax(self._wanted[which], wanted)
        self._level[which] = image.resolution
        self._since[which] += periods
        due = which[self._since[which] >= _MEMORY]
        lower = ladder(np.clip(self._wanted[due], 6, self.finest))
        self._level[due] = np.minimum(self._level[due], lower)
        self._wanted[due], self._since[due] = 0.0, 0


@dataclass
class Retrace:
    """Advances trajectories once more, with steps twice as long as in an earlier run.

    What the two runs have in common does not come from the steps.  No error is known.

    Attributes
    ----------
    flow
        A map that judges nothing.
    parameters, lengths
        As of :class:`Advancer`.
    taken
        Resolutions of each block of the earlier run, in the same order.
    """

    flow: PeriodMap
    parameters: FloatArray
    lengths: FloatArray
    taken: list[NDArray[np.int16]]
    _block: int = field(init=False, default=0, repr=False)

    def __call__(
        self,
        which: IntArray,
        states: FloatArray,
        tangents: FloatArray,
        periods: int,
        *,
        every: bool,
    ) -> Step:
        """Advance some of the trajectories by so many periods."""
        levels = self.taken[min(self._block, len(self.taken) - 1)][which]
        self._block += 1
        image = self.flow(
            states,
            self.parameters[which],
            self.lengths[which],
            tolerance=np.inf,
            cycles=periods,
            tangent=_SIZE * tangents,
            resolution=ladder(0.5 * levels.astype(np.float64)),
            visited=every,
        )
        visited = image.state[:, None] if image.visited is None else image.visited
        finite = np.asarray(np.isfinite(image.state).all(axis=1))
        return Step(visited, image.tangent / _SIZE, np.zeros(which.size), finite)
