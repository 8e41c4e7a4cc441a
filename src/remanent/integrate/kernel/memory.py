"""The array ``(group, slot, lane)`` that kernels work on, by the names of its numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np

from remanent._typing import FloatArray
from remanent.integrate.kernel.layout import Layout


@dataclass(frozen=True)
class LaneMemory:
    """The numbers of some trajectories, in groups of neighbours that are advanced together.

    What changes: kernels and :meth:`set_column` write into `values`.

    Attributes
    ----------
    values : array (group, slot, lane)
        The last group is filled up with copies of the last trajectory.
    layout : Layout
        The slot of each number, by its name.
    count : int
        How many trajectories there are, without the copies.
    """

    values: FloatArray
    layout: Layout
    count: int

    @classmethod
    def filled(
        cls,
        layout: Layout,
        width: int,
        vectors: Mapping[str, FloatArray],
        scalars: Mapping[str, FloatArray | float],
    ) -> Self:
        """A new array.

        Parameters
        ----------
        layout : Layout
        width : int
            Trajectories per group.
        vectors : mapping of str to array (trajectory, component)
            ``parameter`` and the states of :data:`~remanent.integrate.kernel.layout.STATES`;
            zero by default.
        scalars : mapping of str to array (trajectory,) or float
            Values of :data:`~remanent.integrate.kernel.layout.SCALARS`; zero by default.
        """
        count = vectors["parameter"].shape[0]
        groups = -(-count // width)
        flat = np.zeros((groups * width, layout.size))
        for kind, vector in vectors.items():
            flat[:count, layout.group(kind)] = vector
        for name, value in scalars.items():
            flat[:count, layout.slots[name]] = value
        flat[count:] = flat[count - 1]
        grouped = flat.reshape(groups, width, layout.size)
        return cls(np.ascontiguousarray(grouped.transpose(0, 2, 1)), layout, count)

    def column(self, name: str) -> FloatArray:
        """The number called `name` of every trajectory, array (trajectory,)."""
        return self.values[:, self.layout.slots[name], :].reshape(-1)[: self.count]

    def set_column(self, name: str, column: FloatArray) -> None:
        """Replace the number called `name` of every trajectory."""
        groups, _, width = self.values.shape
        padded = np.full(groups * width, column[-1])
        padded[: column.size] = column
        self.values[:, self.layout.slots[name], :] = padded.reshape(groups, width)

    def vectors(self, kind: str) -> FloatArray:
        """The state called `kind`, array (trajectory, component)."""
        return self.by_trajectory(self.snapshot(kind))[:, 0]

    def parameters(self) -> FloatArray:
        """Array (parameter, trajectory), each row contiguous."""
        groups, _, width = self.values.shape
        columns = self.values[:, self.layout.group("parameter"), :].transpose(1, 0, 2)
        return columns.reshape(self.layout.parameters, groups * width)[:, : self.count]

    def snapshot(self, kind: str) -> FloatArray:
        """The same as one record, array (1, group, component, lane)."""
        return self.values[:, self.layout.group(kind), :][None]

    def by_trajectory(self, record: FloatArray) -> FloatArray:
        """From (record, group, component, lane) to (trajectory, record, component)."""
        moved = record.transpose(1, 3, 0, 2)
        padded = moved.shape[0] * moved.shape[1]
        return moved.reshape(padded, *moved.shape[2:])[: self.count]

    def parts(self, groups: int) -> Iterator[FloatArray]:
        """Parts of the array with at most so many groups, as views of it."""
        for first in range(0, self.values.shape[0], groups):
            yield self.values[first : first + groups]
