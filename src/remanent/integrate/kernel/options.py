"""What a kernel integrates with, what it follows, and the slots that this takes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from remanent._field import Field
from remanent.integrate.kernel.layout import SlotLayout
from remanent.integrate.methods.adams import AdamsMethod, rate_variable_indices
from remanent.integrate.methods.runge_kutta import RungeKuttaMethod

#: What trajectories do that take fewer steps in a cycle than others of their group.
OwnStepsKind = Literal["none", "waiting", "going on"]
#: What a kernel can integrate with.
Method = RungeKuttaMethod | AdamsMethod


@dataclass(frozen=True)
class KernelOptions:
    """What a kernel follows.

    Attributes
    ----------
    follows_extremes : bool
        Follow the extremes of the watched observable, and control their error; else
        control the error of the state.
    has_coarse_solution : bool
        Advance the coarse solution too.  Without it no error is estimated.
    estimates_error_per_cycle : bool
        Start the coarse solution anew from the fine one in every cycle, so that the
        largest error that a single cycle adds is estimated; the run goes on however large
        that is.  Only for methods that need no past.
    absolute_error_count : int, optional
        How many of the first state variables have an absolute error (all by default); that
        of the others is divided by the largest of them, where above 1.
    coarse_variable_count : int, optional
        How many of the first state variables the coarse solution has (all by default): these
        must not depend on the others, whose error is then not estimated.  Only with
        `estimates_error_per_cycle`.
    own_steps : {"none", "waiting", "going on"}
        Whether trajectories of one group may differ in how many double steps they take in a
        cycle.  "waiting": those that need fewer wait for the others at its end, where alone
        states are recorded; only for methods that need no past, and not with
        `follows_extremes`.  "going on": each goes on into its next cycle; no states of theirs
        are recorded.
    """

    follows_extremes: bool = False
    has_coarse_solution: bool = True
    estimates_error_per_cycle: bool = False
    absolute_error_count: int | None = None
    coarse_variable_count: int | None = None
    own_steps: OwnStepsKind = "none"


def build_slot_layout(field: Field, options: KernelOptions) -> SlotLayout:
    """Slots of the trajectories of a field, the same whatever the method."""
    histories = tuple(
        i for i, partner in enumerate(rate_variable_indices(field)) if partner is None
    )
    if options.estimates_error_per_cycle:  # no method that needs a past
        histories = ()
    return SlotLayout(len(field.state_names), len(field.parameter_names), histories)
