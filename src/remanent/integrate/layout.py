"""Where a kernel finds each number of a trajectory: names to slots."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

#: States that a kernel keeps for every trajectory: two solutions, what rounding cut off
#: from each, and the finer one at the horizon.
STATES = ("fine", "coarse", "fine_rest", "coarse_rest", "last")
#: Scalars that a kernel keeps for every trajectory, beside states and parameters.
SCALARS = (
    "step",  # length of a fine step, tau
    "cycle",  # length of a cycle (a drive period or a piece), tau
    "start",  # tau at the beginning of the call
    "begin",  # extremes are followed from here
    "end",  # to here
    "tolerance",  # of the controlled error
    "hopeless",  # a trajectory is not followed once its error has been larger
    "alive",  # 1 while the controlled error has met the tolerance
    "horizon",  # tau up to which it did
    "error",  # its largest value up to the horizon
    "total",  # its largest value up to the end; the last one once hopeless, NaN included
    "watched_error",  # largest error of the watched observable up to the horizon
    "maximum",  # extremes of the watched observable from begin to the horizon
    "minimum",
)


@dataclass(frozen=True)
class Layout:
    """Slots of one trajectory in the array ``(group, slot, lane)`` that kernels work on."""

    states: int
    parameters: int

    @cached_property
    def slots(self) -> dict[str, int]:
        names = [f"{kind}.{i}" for kind in STATES for i in range(self.states)]
        names += [f"parameter.{i}" for i in range(self.parameters)]
        return {name: k for k, name in enumerate((*names, *SCALARS))}

    @property
    def size(self) -> int:
        return len(self.slots)

    def group(self, kind: str) -> slice:
        """The slots of ``parameter`` values, or of one of :data:`STATES`."""
        count = self.parameters if kind == "parameter" else self.states
        first = self.slots.get(f"{kind}.0", 0)
        return slice(first, first + count)
