"""Many trajectories of one system under one drive, in plain arrays."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from remanent._field import Field
from remanent._typing import BoolArray, FloatArray
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results.build import Labelled

#: Trajectories that are worked on together where their results are all that is kept.
TRAJECTORIES_PER_BATCH = 2**14


@dataclass(frozen=True)
class Ensemble:
    """Trajectories on the outer product of the values in ``over``.

    Attributes
    ----------
    system : System
    drive : Drive
    vector_field : Field
        Their equations of motion.
    dimension_sizes : dict of name to int
        Length of each dimension, in order; empty for a single trajectory.
    coords : dict of name to Labelled
        Values of the varied fields, labelled.
    parameter_values : dict of name to array (trajectory,)
        Every numeric field of system and drive.
    initial_states : array (trajectory, state)
        Initial states.
    is_invalid : array (trajectory,) of bool
        Where a value breaks a rule.  Nothing is computed there.
    labels : dict of name to Labelled
        Labels of the dimensions that the caller named, where they have some.
    """

    system: System
    drive: Drive
    vector_field: Field
    dimension_sizes: dict[str, int]
    coords: dict[str, Labelled]
    parameter_values: dict[str, FloatArray]
    initial_states: FloatArray
    is_invalid: BoolArray
    labels: dict[str, Labelled] = field(default_factory=dict)

    @property
    def trajectory_count(self) -> int:
        """Number of trajectories."""
        return math.prod(self.dimension_sizes.values())

    @property
    def dims(self) -> tuple[str, ...]:
        """Names of the dimensions, in order."""
        return tuple(self.dimension_sizes)

    def reshape_to_dims(self, values: Any) -> Any:
        """From (trajectory, ...) to one axis for each dimension of the ensemble."""
        return np.reshape(values, (*self.dimension_sizes.values(), *np.shape(values)[1:]))

    def drive_periods(self) -> FloatArray | None:
        """Smallest period of the load of every trajectory, or None where it has none."""
        periods = load_periods_for_values(self.drive, self.parameter_values)
        return (
            None
            if periods is None
            else np.broadcast_to(periods, (self.trajectory_count,)).astype(float)
        )

    def single_member(self, k: int) -> Ensemble:
        """Trajectory `k` as an ensemble of its own, without dimensions."""
        return replace(self._take_slice(slice(k, k + 1)), dimension_sizes={}, coords={}, labels={})

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
        values = {
            name: np.broadcast_to(v, count).copy() for name, v in self.parameter_values.items()
        }
        return replace(
            self,
            dimension_sizes={"point": count},
            coords={},
            labels={},
            parameter_values=values | dict(varied),
            initial_states=states,
            is_invalid=np.zeros(count, dtype=np.bool_),
        )

    def batches(self, size: int = TRAJECTORIES_PER_BATCH) -> Iterator[tuple[slice, Ensemble]]:
        """The trajectories `size` at a time, so that work on them takes memory for a batch only."""
        for part in batch_slices(self.trajectory_count, size):
            yield (
                part,
                replace(
                    self._take_slice(part), dimension_sizes={"trajectory": part.stop - part.start}
                ),
            )

    def _take_slice(self, part: slice) -> Ensemble:
        return replace(
            self,
            parameter_values={name: column[part] for name, column in self.parameter_values.items()},
            initial_states=self.initial_states[part],
            is_invalid=self.is_invalid[part],
        )


def batch_slices(count: int, size: int = TRAJECTORIES_PER_BATCH) -> Iterator[slice]:
    """Consecutive slices of at most `size` that make up `count`."""
    return (slice(k, min(k + size, count)) for k in range(0, count, size))


def load_periods_for_values(drive: Drive, values: Mapping[str, FloatArray]) -> FloatArray | None:
    """Smallest period of the load for values of its fields, or None where it has none.

    Values that break a rule give infinity or NaN, without a warning.
    """
    with np.errstate(all="ignore"):
        return drive.periods(values)
