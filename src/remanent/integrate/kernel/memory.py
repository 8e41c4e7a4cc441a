"""The array ``(group, slot, lane)`` that kernels work on, by the names of its numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from remanent._typing import FloatArray
from remanent.integrate.kernel.layout import SlotLayout


@dataclass(frozen=True)
class LaneMemory:
    """The numbers of some trajectories, in groups of neighbours that are advanced together.

    What changes: kernels and :meth:`set_column` write into `slots`.

    Attributes
    ----------
    slots : array (group, slot, lane)
        The last group is filled up with copies of the last trajectory.
    layout : SlotLayout
        The slot of each number, by its name.
    trajectory_count : int
        How many trajectories there are, without the copies.
    """

    slots: FloatArray
    layout: SlotLayout
    trajectory_count: int

    @classmethod
    def with_values(
        cls,
        layout: SlotLayout,
        lane_count: int,
        vectors: Mapping[str, FloatArray],
        scalars: Mapping[str, FloatArray | float],
    ) -> Self:
        """A new array.

        Parameters
        ----------
        layout : SlotLayout
        lane_count : int
            Trajectories per group.
        vectors : mapping of str to array (trajectory, component)
            ``parameter`` and the states of
            :data:`~remanent.integrate.kernel.layout.STATE_VECTOR_NAMES`; zero by default.
        scalars : mapping of str to array (trajectory,) or float
            Values of :data:`~remanent.integrate.kernel.layout.SCALAR_NAMES`; zero by default.
        """
        count = vectors["parameter"].shape[0]
        groups = -(-count // lane_count)
        slots = np.zeros((groups, layout.slot_count, lane_count))
        # The last group is filled up with the last trajectory.
        members = np.arange(groups * lane_count).clip(max=count - 1).reshape(groups, lane_count)
        for kind, vector in vectors.items():
            slots[:, layout.slots_of_vector(kind)] = vector[members].transpose(0, 2, 1)
        for name, value in scalars.items():
            column = value[members] if isinstance(value, np.ndarray) else value
            slots[:, layout.slot_of_name[name]] = column
        return cls(slots, layout, count)

    def column(self, name: str) -> FloatArray:
        """The number called `name` of every trajectory, array (trajectory,)."""
        return self.slots[:, self.layout.slot_of_name[name], :].reshape(-1)[: self.trajectory_count]

    def set_column(self, name: str, column: FloatArray) -> None:
        """Replace the number called `name` of every trajectory."""
        groups, _, lane_count = self.slots.shape
        padded = np.full(groups * lane_count, column[-1])
        padded[: column.size] = column
        self.slots[:, self.layout.slot_of_name[name], :] = padded.reshape(groups, lane_count)

    def state_vectors(self, kind: str) -> FloatArray:
        """The state called `kind`, array (trajectory, component)."""
        return self.by_trajectory(self.vectors_as_record(kind))[:, 0]

    def parameters(self) -> FloatArray:
        """Array (parameter, trajectory), each row contiguous."""
        groups, _, lane_count = self.slots.shape
        columns = self.slots[:, self.layout.slots_of_vector("parameter"), :].transpose(1, 0, 2)
        return columns.reshape(self.layout.parameter_count, groups * lane_count)[
            :, : self.trajectory_count
        ]

    def vectors_as_record(self, kind: str) -> FloatArray:
        """The same as one record, array (1, group, component, lane)."""
        return self.slots[:, self.layout.slots_of_vector(kind), :][None]

    def by_trajectory(self, record: FloatArray) -> FloatArray:
        """From (record, group, component, lane) to (trajectory, record, component)."""
        moved = record.transpose(1, 3, 0, 2)
        padded = moved.shape[0] * moved.shape[1]
        return moved.reshape(padded, *moved.shape[2:])[: self.trajectory_count]
