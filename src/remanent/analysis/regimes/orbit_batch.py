"""What indicators are computed from: some orbits, without the transients of damped motion."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from remanent._typing import FloatArray


@dataclass(frozen=True)
class OrbitBatch:
    """Some orbits that were followed together.

    Attributes
    ----------
    observable_values : array (orbit, iterate, observable)
        Bounded functions of the states, without the transient.
    triangular_factors : array (orbit, block, direction, direction)
        Upper triangles of the tangents' factorisations over the whole run.
    seed : int
        For what is drawn at random, the same for every orbit.
    """

    observable_values: FloatArray
    triangular_factors: FloatArray
    seed: int


#: An indicator gives a number (orbit,) for each orbit of a batch, NaN where it says nothing.
#: What it gives must not depend on the other orbits.
IndicatorFunction = Callable[[OrbitBatch], FloatArray]
