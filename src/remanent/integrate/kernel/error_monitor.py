"""Error control inside a kernel: what the difference of two solutions says about their error.

Two solutions advance in lockstep.  Runge-Kutta's are one with steps of length h and one with
steps of length 2h: if the error is proportional to h**p, they differ by 2**p - 1 times the error
of the fine one.  Adams' second solution is the first with its errors amplified.  The difference,
compared after every double step, estimates the error of the fine solution at that instant, so
that a kernel knows the time up to which a tolerance was met.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce

from remanent.integrate.kernel.group import RunConstants, TrajectoryCells
from remanent.integrate.kernel.lanes import Lanes, Mask, Writer, larger, larger_or_nan
from remanent.integrate.kernel.options import KernelOptions, Method

#: Estimated error of the state, relative to one plus its size, from which on two solutions
#: have diverged, so that their extremes are no measure of each other.
_MIN_DIVERGED_RELATIVE_ERROR = 1e-2


@dataclass(frozen=True)
class ErrorMonitor:
    """Compares the two solutions of a group and keeps the largest error.

    Attributes
    ----------
    error_per_solution_difference : float
        Error of the fine solution over its difference from the coarse one.
    absolute_error_count : int
        How many of the first state variables have an absolute error.
    estimates_error_per_cycle : bool
        Whether the largest error of a cycle is all that is asked; no horizon is kept then.
    """

    writer: Writer
    run_constants: RunConstants
    trajectory_cells: TrajectoryCells
    error_per_solution_difference: float
    absolute_error_count: int | None
    estimates_error_per_cycle: bool

    @classmethod
    def for_method(
        cls,
        method: Method,
        options: KernelOptions,
        writer: Writer,
        run: RunConstants,
        cells: TrajectoryCells,
    ) -> ErrorMonitor:
        """The monitor of a kernel with this method and these options."""
        return cls(
            writer,
            run,
            cells,
            method.error_per_solution_difference,
            options.absolute_error_count,
            options.estimates_error_per_cycle,
        )

    def is_below_ceiling(self) -> Mask:
        """Where following a trajectory further still tells something about its error."""
        return self.trajectory_cells.largest_error.get() <= self.run_constants.error_ceiling

    def is_followed_from(self, time: Lanes) -> Mask:
        """Which trajectories take part in what begins at a time."""
        return self.is_below_ceiling() & (time < self.run_constants.run_end)

    def compare_states(
        self, left: Sequence[Lanes], fine: Sequence[Lanes], coarse: Sequence[Lanes], t0: Lanes
    ) -> None:
        """Compare the solutions at the end of a double step, which begins at `t0` in `left`."""
        differences = [abs(a - c) for a, c in zip(fine[: len(coarse)], coarse, strict=True)]
        count = self.absolute_error_count or len(differences)
        error = reduce(larger_or_nan, differences[:count])
        if differences[count:]:
            size = reduce(larger, map(abs, fine[count:]), self.writer.constant(1.0))
            error = larger_or_nan(error, reduce(larger_or_nan, differences[count:]) / size)
        self.record_error(
            t0 < self.run_constants.run_end, error * self.error_per_solution_difference, t0, left
        )

    def record_error(
        self, where: Mask, error: Lanes, horizon: Lanes, state: Sequence[Lanes]
    ) -> None:
        """Take an error into account; where it exceeds the tolerance, keep the horizon.

        Parameters
        ----------
        where : Mask
            Trajectories that the error concerns.
        error : Lanes
            Estimated error.
        horizon, state
            Time up to which the tolerance has been met before, and the state then.
        """
        zero = self.writer.constant(0.0)
        cells = self.trajectory_cells
        error = where.select(error, zero)
        before = cells.largest_error.get()
        if self.estimates_error_per_cycle:
            cells.largest_error.set(larger_or_nan(before, error))
            return
        # An error that is NaN fails the comparison, and so the tolerance.
        met = error <= self.run_constants.tolerance
        failing = (cells.within_tolerance.get() > 0.5).without(met)
        cells.largest_error.set(larger_or_nan(before, error))
        # A trajectory fails once, so that the branch is rare; what was known before the
        # failing step is kept, since the error of that step already is too large.
        with self.writer.builder.if_then(failing.any_lane(), likely=False):
            cells.within_tolerance.set_where(failing, zero)
            cells.horizon.set_where(failing, horizon)
            cells.error_to_horizon.set_where(failing, before)
            cells.at_horizon.set_where(failing, state)

    def has_diverged(self, fine: Sequence[Lanes], coarse: Sequence[Lanes]) -> Mask:
        """Where the two solutions differ too much to tell anything about each other.

        Extremes are compared at turning points only, and two solutions that have both left
        the motion, to a thickness stretch of nearly nothing, agree on that.
        """
        always = self.writer.constant(0.0) <= 0.0
        together = always
        for a, c in zip(fine, coarse, strict=True):
            together = together & (
                abs(a - c) * self.error_per_solution_difference
                <= (abs(a) + 1.0) * _MIN_DIVERGED_RELATIVE_ERROR
            )
        return always.without(together)
