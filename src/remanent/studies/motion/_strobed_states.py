"""States at whole drive periods, whatever became of the trajectories."""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray
from remanent.integrate.ensemble.problem import Outcome


def strobed_states(outcome: Outcome, count: int) -> FloatArray:
    """The first states of a strobed run, array (trajectory, count, state).

    A run has as many strobes as its longest valid trajectory has periods.  Where none is valid
    there may be fewer than `count`, and NaN stands in place of the rest.
    """
    assert outcome.states is not None
    states = outcome.states[:, :count]
    missing = count - states.shape[1]
    if missing > 0:
        states = np.pad(states, ((0, 0), (0, missing), (0, 0)), constant_values=np.nan)
    return states
