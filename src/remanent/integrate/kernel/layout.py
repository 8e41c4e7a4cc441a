"""Where a kernel finds each number of a trajectory: names to slots."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

#: States that a kernel keeps for every trajectory: the finer solution, what rounding
#: cut off from it, the coarser solution, and the finer one at the horizon.
STATES = ("fine", "fine_rest", "coarse", "last")
#: The two solutions, and how many past rates are kept of each.
SOLUTIONS = ("fine", "coarse")
PAST = 8
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
    "horizon",  # tau up to which it did, where not alive
    "error",  # its largest value up to the horizon, where not alive
    "total",  # its largest value so far
    "maximum",  # extremes of the watched observable from begin to the horizon
    "minimum",
)


def past(kind: str, age: int, variable: int) -> str:
    """Name of the slot of a past rate; age 0 is the newest."""
    return f"{kind}_past.{age}.{variable}"


@dataclass(frozen=True)
class Layout:
    """Slots of one trajectory in the array ``(group, slot, lane)`` that kernels work on.

    Attributes
    ----------
    states, parameters
        How many there are.
    pasts
        Indices of the state variables whose past rates are kept.
    """

    states: int
    parameters: int
    pasts: tuple[int, ...] = ()

    @cached_property
    def slots(self) -> dict[str, int]:
        names = [f"{kind}.{i}" for kind in STATES for i in range(self.states)]
        names += [
            past(kind, age, i) for kind in SOLUTIONS for age in range(PAST) for i in self.pasts
        ]
        names += [f"parameter.{i}" for i in range(self.parameters)]
        return {name: k for k, name in enumerate((*names, *SCALARS))}

    @cached_property
    def past(self) -> frozenset[str]:
        """Names of the slots of past rates."""
        return frozenset(
            past(kind, age, i) for kind in SOLUTIONS for age in range(PAST) for i in self.pasts
        )

    @property
    def size(self) -> int:
        return len(self.slots)

    def group(self, kind: str) -> slice:
        """The slots of ``parameter`` values, or of one of :data:`STATES`."""
        count = self.parameters if kind == "parameter" else self.states
        first = self.slots.get(f"{kind}.0", 0)
        return slice(first, first + count)
