"""Where a kernel finds each number of a trajectory: names to slots."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

#: States that a kernel keeps for every trajectory: the fine solution, the compensation of its
#: rounding (Kahan), the coarse solution, and the fine one at the horizon.
STATES = ("fine", "compensation", "coarse", "at_horizon")
#: The two solutions: with steps of length h and of length 2h.
SOLUTIONS = ("fine", "coarse")
#: Past rates that are kept of each solution.
PAST = 8
#: Scalars of a trajectory that a kernel reads and leaves as they are.
CONSTANTS = (
    "step",  # length of a fine step, tau
    "cycle",  # length of a cycle (a drive period or a piece), tau
    "start",  # tau at the beginning of the piece
    "begin",  # extremes are followed from here
    "end",  # to here
    "tolerance",  # of the controlled error
    "error_ceiling",  # a trajectory is not followed once its error has been larger
)
#: Scalars of a trajectory that a kernel changes.
RESULTS = (
    "within_tolerance",  # 1 while the controlled error has met the tolerance
    "horizon",  # tau up to which it did, where it no longer does
    "error_to_horizon",  # its largest value up to the horizon, where it no longer does
    "largest_error",  # its largest value so far
    "maximum",  # extremes of the watched observable from begin to the horizon
    "minimum",
    "direction",  # sign of the rate of the observable at the end of the call; NaN before the first
)
#: Scalars that a kernel keeps for every trajectory, beside states and parameters.
SCALARS = (*CONSTANTS, *RESULTS)


def past_rate(solution: str, age: int, variable: int) -> str:
    """Name of the slot of a past rate; age 0 is the newest."""
    return f"{solution}_past.{age}.{variable}"


@dataclass(frozen=True)
class Layout:
    """Slots of one trajectory in the array ``(group, slot, lane)`` that kernels work on.

    Attributes
    ----------
    states, parameters : int
        How many there are.
    histories : tuple of int
        Indices of the state variables whose past rates are kept.
    """

    states: int
    parameters: int
    histories: tuple[int, ...] = ()

    @cached_property
    def slots(self) -> dict[str, int]:
        """The slot of every number, by its name."""
        names = [f"{kind}.{i}" for kind in STATES for i in range(self.states)]
        names += [
            past_rate(solution, age, i)
            for solution in SOLUTIONS
            for age in range(PAST)
            for i in self.histories
        ]
        names += [f"parameter.{i}" for i in range(self.parameters)]
        return {name: k for k, name in enumerate((*names, *SCALARS))}

    @property
    def size(self) -> int:
        """How many slots there are."""
        return len(self.slots)

    def group(self, kind: str) -> slice:
        """The slots of ``parameter`` values, or of one of :data:`STATES`."""
        count = self.parameters if kind == "parameter" else self.states
        first = self.slots.get(f"{kind}.0", 0)
        return slice(first, first + count)
