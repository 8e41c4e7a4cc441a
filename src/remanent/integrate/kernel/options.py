"""What a kernel integrates with, what it follows, and the slots that this takes."""

from __future__ import annotations

from dataclasses import dataclass

from remanent._field import Field
from remanent.integrate.kernel.layout import Layout
from remanent.integrate.methods.adams import Adams, partners
from remanent.integrate.methods.runge_kutta import RungeKutta

#: What a kernel can integrate with.
Method = RungeKutta | Adams


@dataclass(frozen=True)
class Options:
    """What a kernel follows.

    Attributes
    ----------
    extremes : bool
        Follow the extremes of the watched observable, and control their error; else
        control the error of the state.
    safety : float
        Factor between the estimate from two step sizes and the error reported.
    coarse_solution : bool
        Advance the coarse solution too.  Without it no error is estimated.
    error_per_cycle : bool
        Start the coarse solution anew from the fine one in every cycle, so that the
        largest error that a single cycle adds is estimated; the run goes on however large
        that is.  Only for methods that need no past.
    absolute_errors : int, optional
        How many of the first state variables have an absolute error (all by default); that
        of the others is divided by the largest of them, where above 1.
    coarse_variables : int, optional
        How many of the first state variables the coarse solution has (all by default): these
        must not depend on the others, whose error is then not estimated.  Only with
        `error_per_cycle`.
    """

    extremes: bool = False
    safety: float = 4.0
    coarse_solution: bool = True
    error_per_cycle: bool = False
    absolute_errors: int | None = None
    coarse_variables: int | None = None


def layout_of(field: Field, options: Options) -> Layout:
    """Slots of the trajectories of a field, the same whatever the method."""
    histories = tuple(i for i, partner in enumerate(partners(field)) if partner is None)
    if options.error_per_cycle:  # no method that needs a past
        histories = ()
    return Layout(len(field.state_names), len(field.parameters), histories)
