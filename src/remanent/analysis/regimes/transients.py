"""Whether chaos of damped motion lasts: transients can look chaotic for longer than a run.

A transient ends at random, at any time.  Many trials see more of that than one long run, and
a kernel advances sixteen motions in the time of one.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.long_runs import LongRun

#: Number of the loosest tolerance; 0 is the finest.
LOOSEST_TOLERANCE_INDEX = 2
#: Further runs in which damped motion has to stay chaotic.
_LASTING_CHAOS_RUN_COUNT = 2
#: Motions that start beside it, the motion itself included, and have to stay chaotic too.
_NEARBY_START_COUNT = 16
#: Neighbour k starts at (1 + k times this) times the state.
_RELATIVE_NEARBY_START_OFFSET = 1e-9
#: Neighbours followed at once.
_NEIGHBOURS_PER_BATCH = 4096


class ToleranceRunFunction(Protocol):
    """Follows some orbits at one of three tolerances."""

    def __call__(
        self, orbits: IntArray, tolerance: int, states: FloatArray | None = None, /
    ) -> LongRun:
        """Follow orbits.

        Parameters
        ----------
        orbits : array (orbit,) of int
            Their numbers.
        tolerance : int
            Number of the tolerance: 0 for the finest, 2 for the loosest.
        states : array (orbit, state), optional
            To start from; by default where each orbit starts.
        """


def chaos_lasts(
    run: ToleranceRunFunction, orbits: IntArray, states: FloatArray, min_half_growth: float
) -> BoolArray:
    """Whether chaos goes on in every motion that starts beside each orbit.

    Neighbours part at once, since motion is chaotic, and end their transients, if that is what
    they are, independently of each other.

    Parameters
    ----------
    run : ToleranceRunFunction
    orbits : array (orbit,) of int
        Their numbers.
    states : array (orbit, state)
        Where their runs ended.
    min_half_growth : float
        Logarithm of the growth of tangents in the second half of each run, at least.

    Returns
    -------
    array (orbit,) of bool
    """
    lasts = np.ones(orbits.size, dtype=np.bool_)
    factors = 1.0 + _RELATIVE_NEARBY_START_OFFSET * np.arange(_NEARBY_START_COUNT)
    neighbours = (
        np.repeat(states, _NEARBY_START_COUNT, axis=0) * np.tile(factors, orbits.size)[:, None]
    )
    for _ in range(_LASTING_CHAOS_RUN_COUNT):
        # One neighbour that settles is enough: the others of that orbit are not followed again.
        remaining = np.flatnonzero(np.repeat(lasts, _NEARBY_START_COUNT))
        batches = -(-remaining.size // _NEIGHBOURS_PER_BATCH)
        for batch in np.array_split(remaining, batches) if remaining.size else ():
            orbit = batch // _NEARBY_START_COUNT
            outcome = run(orbits[orbit], LOOSEST_TOLERANCE_INDEX, neighbours[batch])
            growth = outcome.log_growth[..., 0]
            late = growth[:, growth.shape[1] // 2 :].sum(axis=1)
            chaotic = outcome.error_bound_met & ~outcome.escaped & (late >= min_half_growth)
            lasts[orbit[~chaotic]] = False
            neighbours[batch] = outcome.last_state
    return lasts
