"""Where a kernel finds each number of a trajectory: names to slots."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

#: States that a kernel keeps for every trajectory: the fine solution, the compensation of its
#: rounding (Kahan), the coarse solution, the fine one at the horizon, and the largest recent
#: difference of the two solutions.
STATE_VECTOR_NAMES = ("fine", "compensation", "coarse", "at_horizon", "fading_difference")
#: The two solutions: the one that is returned, and one with larger errors.
SOLUTION_NAMES = ("fine", "coarse")
#: Past rates that are kept of the fine solution.
PAST_RATE_COUNT = 8
#: Past differences of the rates of the two solutions that are kept, one for each double step.
PAST_DIFFERENCE_COUNT = 4
#: Scalars of a trajectory that a kernel reads and leaves as they are.
CONSTANT_SCALAR_NAMES = (
    "fine_step_length",  # length of a fine step, tau
    "cycle_length",  # length of a cycle (a drive period or a piece), tau
    "piece_start",  # tau at the beginning of the piece
    "extremes_begin",  # extremes are followed from here
    "run_end",  # to here
    "tolerance",  # of the controlled error
    "error_ceiling",  # a trajectory is not followed once its error has been larger
    "own_double_steps",  # in a cycle, where lanes of a group differ; else 0
    "first_row",  # of the table of the coarse steps where those of the lane begin, likewise
)
#: Scalars of a trajectory that a kernel changes.
CHANGING_SCALAR_NAMES = (
    "within_tolerance",  # 1 while the controlled error has met the tolerance
    "horizon",  # tau up to which it did, where it no longer does
    "error_to_horizon",  # its largest value up to the horizon, where it no longer does
    "largest_error",  # its largest value so far
    "maximum",  # extremes of the watched observable up to the horizon
    "minimum",
    "maximum_time",  # when they occur, tau
    "minimum_time",
    "watched_rate_sign",  # of the observable's rate at the end of the call; NaN before the first
)
#: Scalars that a kernel keeps for every trajectory, beside states and parameters.
SCALAR_NAMES = (*CONSTANT_SCALAR_NAMES, *CHANGING_SCALAR_NAMES)


def past_rate_name(age: int, variable: int) -> str:
    """Name of the slot of a past rate of the fine solution; age 0 is the newest."""
    return f"past_rate.{age}.{variable}"


def past_difference_name(age: int, variable: int) -> str:
    """Name of the slot of a past difference of the rates of the two solutions."""
    return f"past_difference.{age}.{variable}"


def backward_difference_name(age: int, variable: int) -> str:
    """Name of the slot of a backward difference of a rate and as many past ones as are kept."""
    return f"backward_difference.{age}.{variable}"


@dataclass(frozen=True)
class SlotLayout:
    """Slots of one trajectory in the array ``(group, slot, lane)`` that kernels work on.

    Attributes
    ----------
    state_count, parameter_count : int
        How many there are.
    history_variables : tuple of int
        Indices of the state variables whose past rates are kept.
    """

    state_count: int
    parameter_count: int
    history_variables: tuple[int, ...] = ()

    @cached_property
    def slot_of_name(self) -> dict[str, int]:
        """The slot of every number, by its name."""
        names = [f"{kind}.{i}" for kind in STATE_VECTOR_NAMES for i in range(self.state_count)]
        for i in self.history_variables:
            names += [past_rate_name(age, i) for age in range(PAST_RATE_COUNT)]
            names += [past_difference_name(age, i) for age in range(PAST_DIFFERENCE_COUNT)]
            names += [backward_difference_name(age, i) for age in range(2)]
        names += [f"parameter.{i}" for i in range(self.parameter_count)]
        return {name: k for k, name in enumerate((*names, *SCALAR_NAMES))}

    @property
    def slot_count(self) -> int:
        """How many slots there are."""
        return len(self.slot_of_name)

    def slots_of_vector(self, kind: str) -> slice:
        """The slots of ``parameter`` values, or of one of :data:`STATE_VECTOR_NAMES`."""
        count = self.parameter_count if kind == "parameter" else self.state_count
        first = self.slot_of_name.get(f"{kind}.0", 0)
        return slice(first, first + count)
