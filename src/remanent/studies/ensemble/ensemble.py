"""Many trajectories of one system under one drive, in plain arrays."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from remanent._field import Field
from remanent._typing import BoolArray, FloatArray
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results.build import Labelled

#: Trajectories that are worked on together where their results are all that is kept.
BATCH_SIZE = 2**14


@dataclass(frozen=True)
class Ensemble:
    """Trajectories on the outer product of the values in ``over``.

    Attributes
    ----------
    system : System
    drive : Drive
    field : Field
        Their equations of motion.
    sizes : dict of name to int
        Length of each dimension, in order; empty for a single trajectory.
    coords : dict of name to Labelled
        Values of the varied fields, labelled.
    values : dict of name to array (trajectory,)
        Every numeric field of system and drive.
    initial : array (trajectory, state)
        Initial states.
    invalid : array (trajectory,) of bool
        Where a value breaks a rule.  Nothing is computed there.
    """

    system: System
    drive: Drive
    field: Field
    sizes: dict[str, int]
    coords: dict[str, Labelled]
    values: dict[str, FloatArray]
    initial: FloatArray
    invalid: BoolArray

    @property
    def count(self) -> int:
        """Number of trajectories."""
        return math.prod(self.sizes.values())

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions, in order."""
        return tuple(self.sizes)

    def reshape_to_dims(self, values: Any) -> Any:
        """From (trajectory, ...) to one axis for each dimension of the ensemble."""
        return np.reshape(values, (*self.sizes.values(), *np.shape(values)[1:]))

    def drive_periods(self) -> FloatArray | None:
        """Smallest period of the load of every trajectory, or None where it has none."""
        periods = load_periods(self.drive, self.values)
        return None if periods is None else np.broadcast_to(periods, (self.count,)).astype(float)

    def single_member(self, k: int) -> Ensemble:
        """Trajectory `k` as an ensemble of its own, without dimensions."""
        return replace(self._sliced(slice(k, k + 1)), sizes={}, coords={})

    def with_initial_states(self, states: FloatArray, varied: Mapping[str, FloatArray]) -> Ensemble:
        """Many trajectories like this single one, from other states and with some other values.

        Parameters
        ----------
        states : array (point, state)
            Where each starts.
        varied : mapping of name to array (point,)
            Values of the fields in which they differ.

        Returns
        -------
        Ensemble
            With the one dimension ``point``; all its trajectories count as valid.
        """
        count = len(states)
        values = {name: np.broadcast_to(v, count).copy() for name, v in self.values.items()}
        return replace(
            self,
            sizes={"point": count},
            coords={},
            values=values | dict(varied),
            initial=states,
            invalid=np.zeros(count, dtype=np.bool_),
        )

    def batches(self, size: int = BATCH_SIZE) -> Iterator[tuple[slice, Ensemble]]:
        """The trajectories `size` at a time, so that work on them takes memory for a batch only."""
        for part in batch_slices(self.count, size):
            yield part, replace(self._sliced(part), sizes={"trajectory": part.stop - part.start})

    def _sliced(self, part: slice) -> Ensemble:
        return replace(
            self,
            values={name: column[part] for name, column in self.values.items()},
            initial=self.initial[part],
            invalid=self.invalid[part],
        )


def batch_slices(count: int, size: int = BATCH_SIZE) -> Iterator[slice]:
    """Consecutive slices of at most `size` that make up `count`."""
    return (slice(k, min(k + size, count)) for k in range(0, count, size))


def load_periods(drive: Drive, values: Mapping[str, FloatArray]) -> FloatArray | None:
    """Smallest period of the load for values of its fields, or None where it has none.

    Values that break a rule give infinity or NaN, without a warning.
    """
    with np.errstate(all="ignore"):
        return drive.periods(values)
