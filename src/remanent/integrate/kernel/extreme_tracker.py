"""Extremes of the watched observable inside a kernel, and their error.

An observable turns where its rate changes sign, which is seen at the ends and in the middle of
every double step.  Such a double step is *kept*, and worked out later: a Hermite polynomial
through its three states gives the extremum, and the same observable of the coarse solution its
error.  Working it out costs as much as many steps and would be done for all lanes of a group
even if one alone turns.  Turns of different trajectories rarely fall into one step, so that
they wait until one of the trajectories turns again, and are worked out together.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Self

from llvmlite import ir

from remanent.integrate.kernel.error_monitor import ErrorMonitor
from remanent.integrate.kernel.extrema import (
    TimeDerivatives,
    derivative_coefficients,
    horner,
    three_node_hermite_coefficients,
)
from remanent.integrate.kernel.field_code import FieldCode, LoadTable, PhaseAndWaveforms
from remanent.integrate.kernel.group import RunConstants, TrajectoryCells, VectorCells
from remanent.integrate.kernel.lanes import (
    Cell,
    Lanes,
    Mask,
    Writer,
    larger,
    larger_or_nan,
    reciprocal_quotient,
    smaller,
)
from remanent.integrate.kernel.lockstep import DoubleStepLoads
from remanent.integrate.kernel.options import Method

#: Newton steps from a secant start, before one more with the same curvature; an extremum
#: then moves by less than round-off.
_NEWTON_STEP_COUNT = 2
#: What is left of the largest difference of two solutions after a double step.
_FADING = 0.97
#: Largest value of (s**3 - s)**3 in [-1, 1], to which the error of the polynomial between its
#: nodes is proportional.  The factor is its next coefficient; the last coefficient, which is
#: larger where steps resolve the motion, is used in its place.
_INTERPOLATION_ERROR_FACTOR = 0.057


@dataclass(frozen=True)
class StepStates:
    """Both solutions in a double step.

    Attributes
    ----------
    left, middle, right : sequence of Lanes
        The fine solution at the beginning, in the middle and at the end.
    coarse_left, coarse_right : sequence of Lanes, optional
        The coarse solution at the beginning and at the end, where there is one.
    """

    left: Sequence[Lanes]
    middle: Sequence[Lanes]
    right: Sequence[Lanes]
    coarse_left: Sequence[Lanes] | None
    coarse_right: Sequence[Lanes] | None


@dataclass(frozen=True)
class DoubleStep:
    """All that the extremes of a double step are worked out from.

    Attributes
    ----------
    states : StepStates
        Of both solutions.
    left_load, middle_load, right_load : list of Lanes
        Phase and waveforms at the beginning, in the middle and at the end.
    start_time : Lanes
        Time of the beginning, tau.
    diverged_flag : Lanes
        1 where the solutions have diverged in the step, else 0.
    recent_difference : sequence of Lanes
        What counts, in the error of an extremum, of the differences of the two solutions up to
        here, for each of the variables in question.
    """

    states: StepStates
    left_load: PhaseAndWaveforms
    middle_load: PhaseAndWaveforms
    right_load: PhaseAndWaveforms
    start_time: Lanes
    diverged_flag: Lanes
    recent_difference: Sequence[Lanes]

    def vectors(self) -> Iterator[Sequence[Lanes]]:
        """All of it but the scalars, in the order of the attributes."""
        y = self.states
        yield from (y.left, y.middle, y.right)
        if y.coarse_left is not None and y.coarse_right is not None:
            yield from (y.coarse_left, y.coarse_right)
        yield from (self.left_load, self.middle_load, self.right_load, self.recent_difference)


@dataclass(frozen=True)
class KeptStep:
    """Cells for one double step of each trajectory, which waits to be worked out.

    Attributes
    ----------
    vectors : tuple of VectorCells
        In the order of :meth:`DoubleStep.vectors`.
    start_time, diverged_flag : Cell
        As in :class:`DoubleStep`.
    waiting_flag : Cell
        1 where a double step waits, else 0.
    """

    vectors: tuple[VectorCells, ...]
    start_time: Cell
    diverged_flag: Cell
    waiting_flag: Cell

    @classmethod
    def empty(
        cls, writer: Writer, states: int, columns: int, watched: int, *, coarse: bool
    ) -> Self:
        """Cells in which nothing waits."""
        zero = writer.constant(0.0)
        sizes = [states] * (5 if coarse else 3) + [columns] * 3 + [watched]
        vectors = tuple(VectorCells.with_values(writer, [zero] * size) for size in sizes)
        return cls(vectors, *(writer.new_cell_with(zero) for _ in range(3)))

    def keep(self, where: Mask, step: DoubleStep) -> None:
        """Let a double step of some trajectories wait."""
        for cells, values in zip(self.vectors, step.vectors(), strict=True):
            cells.set_where(where, values)
        self.start_time.set_where(where, step.start_time)
        self.diverged_flag.set_where(where, step.diverged_flag)
        self.waiting_flag.set_where(where, self.waiting_flag.writer.constant(1.0))

    def double_step(self) -> DoubleStep:
        """The double steps that wait."""
        left, middle, right, *coarse, left_load, middle_load, right_load, recent_difference = (
            cells.get() for cells in self.vectors
        )
        coarse_left, coarse_right = coarse or (None, None)
        return DoubleStep(
            StepStates(left, middle, right, coarse_left, coarse_right),
            left_load,
            middle_load,
            right_load,
            self.start_time.get(),
            self.diverged_flag.get(),
            recent_difference,
        )

    def is_waiting(self) -> Mask:
        """Which trajectories have a double step that waits."""
        return self.waiting_flag.get() > 0.5

    def clear(self) -> None:
        """Nothing waits any more."""
        self.waiting_flag.set(self.waiting_flag.writer.constant(0.0))


@dataclass(frozen=True)
class ExtremeTracker:
    """Follows the extremes of the watched observable of one group.

    Attributes
    ----------
    fine_loads : LoadTable
        Of the fine solution.
    kept_step : KeptStep
        Double steps that wait to be worked out.
    """

    method: Method
    writer: Writer
    field_code: FieldCode
    run_constants: RunConstants
    trajectory_cells: TrajectoryCells
    fine_loads: LoadTable
    error_monitor: ErrorMonitor
    kept_step: KeptStep
    has_coarse_solution: bool

    @classmethod
    def at_call_begin(
        cls,
        method: Method,
        code: FieldCode,
        run: RunConstants,
        cells: TrajectoryCells,
        loads: LoadTable,
        monitor: ErrorMonitor,
        *,
        coarse_solution: bool,
    ) -> Self:
        """A tracker at the beginning of a call."""
        w = code.writer
        states, watched = len(code.field.variables), len(_fading_variables(method, code))
        kept = KeptStep.empty(w, states, loads.column_count, watched, coarse=coarse_solution)
        state, load = cells.fine.get(), loads.load_at(w.integer_constant(0), 0, 0)
        # The end of the call before is the same instant, but the phase there may be 1 instead
        # of 0, with other last digits: what was seen there is taken up.
        saved = cells.watched_rate_sign.get()
        cells.watched_rate_sign.set(
            (abs(saved) <= math.inf).select(saved, code.watched_rate_sign(state, load))
        )
        return cls(method, w, code, run, cells, loads, monitor, kept, coarse_solution)

    def any_lane_near_tracking_limit(self, time: Lanes) -> ir.Value:
        """Whether one of the group begins or ends to be followed within two cycles of a time.

        It is true as well if one is not followed at that time.  Only then must the ends be looked
        for in every step.
        """
        before = time - self.run_constants.cycle_length * 2.0
        after = time + self.run_constants.cycle_length * 2.0
        well = (self.run_constants.extremes_begin < before) & (after < self.run_constants.run_end)
        return (self.writer.constant(0.0) <= 0.0).without(well).any_lane()

    def keep_eventful_step(
        self,
        states: StepStates,
        double_step: ir.Value,
        loads: DoubleStepLoads,
        start_time: Callable[[], Lanes],
        near_an_end: ir.Value,
    ) -> None:
        """Keep a double step of every trajectory that turns, begins, ends or diverges in it.

        Parameters
        ----------
        states : StepStates
            Both solutions.
        double_step : ir.Value
            Its number in the cycle.
        loads : DoubleStepLoads
            The load in it.
        start_time : callable
            Gives the time of its beginning, tau.
        near_an_end : ir.Value
            See :meth:`any_lane_near_tracking_limit`.
        """
        last_node = self.fine_loads.node_count - 1
        middle_load, right_load = loads.first(last_node), loads.second(last_node)
        before = self.trajectory_cells.watched_rate_sign.get()
        between = self.field_code.watched_rate_sign(states.middle, middle_load)
        after = self.field_code.watched_rate_sign(states.right, right_load)
        self.trajectory_cells.watched_rate_sign.set(after)
        turned = (before * between <= 0.0) | (between * after <= 0.0)
        diverged = turned.without(turned)
        if states.coarse_right is not None:
            # Noted once: resolving it puts the error above the ceiling.
            diverged = self.error_monitor.has_diverged(states.right, states.coarse_right)
            diverged = diverged & self.error_monitor.is_below_ceiling()
            self._update_fading_difference(states.right, states.coarse_right)
        b, run = self.writer.builder, self.run_constants
        with b.if_then(b.or_((turned | diverged).any_lane(), near_an_end), likely=False):
            t0 = start_time()
            t2 = t0 + run.fine_step_length + run.fine_step_length
            inside = (run.extremes_begin < t2) & (
                turned | (t0 <= run.extremes_begin) | (run.run_end <= t2)
            )
            event = (t0 < run.run_end) & (inside | diverged)
            zero, one = self.writer.constant(0.0), self.writer.constant(1.0)
            flag = diverged.select(one, zero)
            left_load = self.fine_loads.load_at(double_step, 0, 0)
            share = self.method.recent_share_at_extremes
            recent = [cell.get() * share for _, cell in self._fading_cells()]
            step = DoubleStep(states, left_load, middle_load, right_load, t0, flag, recent)
            # The place for it may hold an earlier double step of the same trajectory.
            with b.if_then((event & self.kept_step.is_waiting()).any_lane(), likely=False):
                self.resolve_kept_step()
            self.kept_step.keep(event, step)

    def resolve_kept_step(self) -> None:
        """Work out the double steps that wait: their extremes and the error of these."""
        step = self.kept_step.double_step()
        y = step.states
        diverged, waiting = step.diverged_flag > 0.5, self.kept_step.is_waiting()
        left = self.field_code.watched_derivatives(y.left, step.left_load)
        middle = self.field_code.watched_derivatives(y.middle, step.middle_load)
        right = self.field_code.watched_derivatives(y.right, step.right_load)
        polynomial = three_node_hermite_coefficients(
            left, middle, right, self.run_constants.fine_step_length
        )
        if y.coarse_left is not None and y.coarse_right is not None:
            at_left = self._observable_difference(left, y.coarse_left, step.left_load)
            at_right = self._observable_difference(right, y.coarse_right, step.right_load)
            difference = larger_or_nan(at_left, at_right)
            difference = difference + self._recent_observable_difference(right, step)
            error = (
                difference * self.error_monitor.error_per_solution_difference
                + abs(polynomial[-1]) * _INTERPOLATION_ERROR_FACTOR
            )
            error = diverged.select(self.writer.constant(math.inf), error)
            self.error_monitor.record_error(waiting, error, step.start_time, y.left)
        followed = waiting & (self.trajectory_cells.within_tolerance.get() > 0.5)
        self._update_extremes(followed, step.start_time, (left, middle, right), polynomial)
        self.kept_step.clear()

    def _observable_difference(
        self, fine: TimeDerivatives, coarse: Sequence[Lanes], load: PhaseAndWaveforms
    ) -> Lanes:
        """How much the observable of two solutions may differ near a known place.

        The first two terms of its Taylor series: an extremum is compared at the ends of the
        double step, not where it is, and the error of its value may pass through zero there.
        """
        rough = self.field_code.watched_derivatives(coarse, load)
        value: Lanes = abs(fine.value - rough.value)
        rate: Lanes = abs(fine.rate - rough.rate)
        return value + self.run_constants.fine_step_length * (
            rate * self.method.rate_steps_at_extremes
        )

    def _fading_cells(self) -> list[tuple[int, Cell]]:
        """Of the variables whose recent differences count, with their numbers."""
        cells = self.trajectory_cells.fading_difference.cells
        return [(k, cells[k]) for k in _fading_variables(self.method, self.field_code)]

    def _update_fading_difference(self, fine: Sequence[Lanes], coarse: Sequence[Lanes]) -> None:
        """Take the difference of the solutions after a double step into account."""
        for k, cell in self._fading_cells():
            cell.set(larger(cell.get() * _FADING, abs(fine[k] - coarse[k])))

    def _recent_observable_difference(self, at_end: TimeDerivatives, step: DoubleStep) -> Lanes:
        """By how much the observable varies with what counts of recent differences."""
        state, total = step.states.right, self.writer.constant(0.0)
        for (k, _), difference in zip(self._fading_cells(), step.recent_difference, strict=True):
            moved = list(state)
            moved[k] = state[k] + difference
            there = self.field_code.watched_derivatives(moved, step.right_load)
            total = total + abs(there.value - at_end.value)
        return total

    def _update_extremes(
        self, where: Mask, t0: Lanes, nodes: Sequence[TimeDerivatives], polynomial: list[Any]
    ) -> None:
        """Compare the extremum of a double step, and its ends, with the extremes so far."""
        left, middle, right = nodes
        run = self.run_constants
        centre = t0 + run.fine_step_length
        in_first_half = left.rate * middle.rate <= 0.0
        first_rate = in_first_half.select(left.rate, middle.rate)
        second_rate = in_first_half.select(middle.rate, right.rate)
        shift = in_first_half.select(self.writer.constant(-1.0), self.writer.constant(0.0))
        s = _turning_point(polynomial, first_rate, second_rate, shift)
        time = centre + s * run.fine_step_length
        turned = (
            (first_rate * second_rate <= 0.0) & (run.extremes_begin <= time) & (time <= run.run_end)
        )
        self._update_extremes_with_value(where & turned, horner(polynomial, s), time)
        at_an_end = where & (
            (t0 <= run.extremes_begin) | (run.run_end < centre + run.fine_step_length)
        )
        with self.writer.builder.if_then(at_an_end.any_lane(), likely=False):
            self._update_extremes_at_tracking_limits(at_an_end, t0, polynomial)

    def _update_extremes_at_tracking_limits(
        self, where: Mask, t0: Lanes, polynomial: list[Any]
    ) -> None:
        """Values where the extremes begin and end to be followed, inside a double step."""
        run = self.run_constants
        centre = t0 + run.fine_step_length
        low = larger(
            (run.extremes_begin - centre) / run.fine_step_length, self.writer.constant(-1.0)
        )
        high = smaller((run.run_end - centre) / run.fine_step_length, self.writer.constant(1.0))
        for s in (low, high):
            bound = (s > -1.0) & (s < 1.0) | (t0 <= run.extremes_begin) & (s <= -1.0)
            time = centre + s * run.fine_step_length
            self._update_extremes_with_value(where & bound, horner(polynomial, s), time)

    def _update_extremes_with_value(self, where: Mask, value: Lanes, time: Lanes) -> None:
        cells = self.trajectory_cells
        higher, lower = where & (value > cells.maximum.get()), where & (value < cells.minimum.get())
        for which, extreme, when in (
            (higher, cells.maximum, cells.maximum_time),
            (lower, cells.minimum, cells.minimum_time),
        ):
            extreme.set_where(which, value)
            when.set_where(which, time)


def _fading_variables(method: Method, code: FieldCode) -> tuple[int, ...]:
    """Numbers of the variables whose recent differences count in the error of an extremum."""
    return code.field.watched_variables if method.recent_share_at_extremes > 0.0 else ()


def _turning_point(
    polynomial: list[Any], first_rate: Lanes, second_rate: Lanes, shift: Lanes
) -> Lanes:
    """Where the derivative vanishes in [shift, shift + 1], by Newton from a secant."""
    slope = derivative_coefficients(polynomial)
    curvature = derivative_coefficients(slope)
    s = reciprocal_quotient(first_rate, first_rate - second_rate) + shift
    for _ in range(_NEWTON_STEP_COUNT):
        inverse = s.writer.reciprocal(horner(curvature, s))
        s = _clamp_to_half_interval(s - horner(slope, s) * inverse, shift)
    # So close by now that the curvature is that of the last step.
    return _clamp_to_half_interval(s - horner(slope, s) * inverse, shift)


def _clamp_to_half_interval(s: Lanes, shift: Lanes) -> Lanes:
    return larger(smaller(s, shift + 1.0), shift)
