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
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Self

from llvmlite import ir

from remanent.integrate.kernel.error_monitor import ErrorMonitor
from remanent.integrate.kernel.extrema import (
    TimeDerivatives,
    derivative,
    hermite_coefficients,
    horner,
)
from remanent.integrate.kernel.field_code import FieldCode, Load, LoadTable
from remanent.integrate.kernel.group import Cycle, RunConstants, TrajectoryCells, VectorCells
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

#: Newton steps from a secant start, before one more with the same curvature; an extremum
#: then moves by less than round-off.
_NEWTON_STEPS = 2
#: Largest value of (s**3 - s)**3 in [-1, 1], to which the error of the polynomial between its
#: nodes is proportional.  The factor is its next coefficient; the last coefficient, which is
#: larger where steps resolve the motion, is used in its place.
_INTERPOLATION_ERROR = 0.057


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
    start : Lanes
        Time of the beginning, tau.
    diverged : Lanes
        1 where the solutions have diverged in the step, else 0.
    """

    states: StepStates
    left_load: Load
    middle_load: Load
    right_load: Load
    start: Lanes
    diverged: Lanes

    def vectors(self) -> Iterator[Sequence[Lanes]]:
        """All of it but the scalars, in the order of the attributes."""
        y = self.states
        yield from (y.left, y.middle, y.right)
        if y.coarse_left is not None and y.coarse_right is not None:
            yield from (y.coarse_left, y.coarse_right)
        yield from (self.left_load, self.middle_load, self.right_load)


@dataclass(frozen=True)
class KeptStep:
    """Cells for one double step of each trajectory, which waits to be worked out.

    Attributes
    ----------
    vectors : tuple of VectorCells
        In the order of :meth:`DoubleStep.vectors`.
    start, diverged : Cell
        As in :class:`DoubleStep`.
    waiting : Cell
        1 where a double step waits, else 0.
    """

    vectors: tuple[VectorCells, ...]
    start: Cell
    diverged: Cell
    waiting: Cell

    @classmethod
    def empty(cls, writer: Writer, states: int, columns: int, *, coarse: bool) -> Self:
        """Cells in which nothing waits."""
        zero = writer.constant(0.0)
        sizes = [states] * (5 if coarse else 3) + [columns] * 3
        vectors = tuple(VectorCells.holding(writer, [zero] * size) for size in sizes)
        return cls(vectors, *(writer.variable(zero) for _ in range(3)))

    def put(self, where: Mask, step: DoubleStep) -> None:
        """Let a double step of some trajectories wait."""
        for cells, values in zip(self.vectors, step.vectors(), strict=True):
            cells.set_where(where, values)
        self.start.set_where(where, step.start)
        self.diverged.set_where(where, step.diverged)
        self.waiting.set_where(where, self.waiting.writer.constant(1.0))

    def get(self) -> DoubleStep:
        """The double steps that wait."""
        left, middle, right, *coarse, left_load, middle_load, right_load = (
            cells.get() for cells in self.vectors
        )
        coarse_left, coarse_right = coarse or (None, None)
        return DoubleStep(
            StepStates(left, middle, right, coarse_left, coarse_right),
            left_load,
            middle_load,
            right_load,
            self.start.get(),
            self.diverged.get(),
        )

    def is_waiting(self) -> Mask:
        """Which trajectories have a double step that waits."""
        return self.waiting.get() > 0.5

    def clear(self) -> None:
        """Nothing waits any more."""
        self.waiting.set(self.waiting.writer.constant(0.0))


@dataclass(frozen=True)
class ExtremeTracker:
    """Follows the extremes of the watched observable of one group.

    Attributes
    ----------
    loads : LoadTable
        Of the fine solution.
    kept : KeptStep
        Double steps that wait to be worked out.
    """

    writer: Writer
    code: FieldCode
    run: RunConstants
    cells: TrajectoryCells
    loads: LoadTable
    monitor: ErrorMonitor
    kept: KeptStep
    coarse_solution: bool

    @classmethod
    def begin(
        cls,
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
        states = len(code.field.state_names)
        kept = KeptStep.empty(w, states, loads.columns, coarse=coarse_solution)
        state, load = cells.fine.get(), loads.row(w.integer(0))(0)
        # The end of the call before is the same instant, but the phase there may be 1 instead
        # of 0, with other last digits: what was seen there is taken up.
        saved = cells.direction.get()
        cells.direction.set((abs(saved) <= math.inf).choose(saved, code.direction(state, load)))
        return cls(w, code, run, cells, loads, monitor, kept, coarse_solution)

    def near_an_end(self, cycle: Cycle) -> ir.Value:
        """Whether one of the group begins or ends to be followed in this cycle or next to it.

        Only then must the ends be looked for in every step.
        """
        before = cycle.start - self.run.cycle
        after = cycle.start + self.run.cycle * 2.0
        well = (self.run.begin < before) & (after < self.run.end)
        return (self.writer.constant(0.0) <= 0.0).without(well).any()

    def note(
        self,
        states: StepStates,
        cycle: Cycle,
        first: ir.Value,
        second: ir.Value,
        near_an_end: ir.Value,
    ) -> None:
        """Keep a double step of every trajectory that turns, begins, ends or diverges in it.

        Parameters
        ----------
        states : StepStates
            Both solutions.
        cycle : Cycle
        first, second : ir.Value
            Numbers of the two fine steps in the cycle.
        near_an_end : ir.Value
            See :meth:`near_an_end`.
        """
        last_node = self.loads.nodes - 1
        row, end_row = self.loads.row(first), self.loads.row(second)
        right_load = end_row(last_node)
        left_load, middle_load = row(0), row(last_node)
        before = self.cells.direction.get()
        between = self.code.direction(states.middle, middle_load)
        after = self.code.direction(states.right, right_load)
        self.cells.direction.set(after)
        turned = (before * between <= 0.0) | (between * after <= 0.0)
        diverged = turned.without(turned)
        if states.coarse_right is not None:
            # Noted once: resolving it puts the error above the ceiling.
            diverged = self.monitor.diverged(states.right, states.coarse_right)
            diverged = diverged & self.monitor.below_ceiling()
        b, run = self.writer.builder, self.run
        with b.if_then(b.or_((turned | diverged).any(), near_an_end), likely=False):
            t0 = cycle.time(first)
            t2 = t0 + cycle.step + cycle.step
            inside = (run.begin < t2) & (turned | (t0 <= run.begin) | (run.end <= t2))
            event = (t0 < run.end) & (inside | diverged)
            zero, one = self.writer.constant(0.0), self.writer.constant(1.0)
            flag = diverged.choose(one, zero)
            step = DoubleStep(states, left_load, middle_load, right_load, t0, flag)
            # The place for it may hold an earlier double step of the same trajectory.
            with b.if_then((event & self.kept.is_waiting()).any(), likely=False):
                self.resolve()
            self.kept.put(event, step)

    def resolve(self) -> None:
        """Work out the double steps that wait: their extremes and the error of these."""
        step = self.kept.get()
        y = step.states
        diverged, waiting = step.diverged > 0.5, self.kept.is_waiting()
        left = self.code.watched(y.left, step.left_load)
        middle = self.code.watched(y.middle, step.middle_load)
        right = self.code.watched(y.right, step.right_load)
        polynomial = hermite_coefficients(left, middle, right, self.run.step)
        if y.coarse_left is not None and y.coarse_right is not None:
            at_left = self._difference(left, y.coarse_left, step.left_load)
            at_right = self._difference(right, y.coarse_right, step.right_load)
            error = (
                larger_or_nan(at_left, at_right) * self.monitor.scale
                + abs(polynomial[-1]) * _INTERPOLATION_ERROR
            )
            error = diverged.choose(self.writer.constant(math.inf), error)
            self.monitor.record_error(waiting, error, step.start, y.left)
        followed = waiting & (self.cells.within_tolerance.get() > 0.5)
        self._take_extremes(followed, step.start, (left, middle, right), polynomial)
        self.kept.clear()

    def _difference(self, fine: TimeDerivatives, coarse: Sequence[Lanes], load: Load) -> Lanes:
        """How much the observable of two solutions may differ within h of a known place.

        The first two terms of its Taylor series: an extremum is compared at the ends of the
        double step, not where it is.
        """
        rough = self.code.watched(coarse, load)
        value: Lanes = abs(fine.value - rough.value)
        rate: Lanes = abs(fine.rate - rough.rate)
        return value + self.run.step * rate

    def _take_extremes(
        self, where: Mask, t0: Lanes, nodes: Sequence[TimeDerivatives], polynomial: list[Any]
    ) -> None:
        """Compare the extremum of a double step, and its ends, with the extremes so far."""
        left, middle, right = nodes
        run = self.run
        centre = t0 + run.step
        in_first_half = left.rate * middle.rate <= 0.0
        near = in_first_half.choose(left.rate, middle.rate)
        far = in_first_half.choose(middle.rate, right.rate)
        shift = in_first_half.choose(self.writer.constant(-1.0), self.writer.constant(0.0))
        s = _turning_point(polynomial, near, far, shift)
        time = centre + s * run.step
        turned = (near * far <= 0.0) & (run.begin <= time) & (time <= run.end)
        self._take(where & turned, horner(polynomial, s))
        at_an_end = where & ((t0 <= run.begin) | (run.end < centre + run.step))
        with self.writer.builder.if_then(at_an_end.any(), likely=False):
            self._take_ends(at_an_end, t0, polynomial)

    def _take_ends(self, where: Mask, t0: Lanes, polynomial: list[Any]) -> None:
        """Values where the extremes begin and end to be followed, inside a double step."""
        run = self.run
        centre = t0 + run.step
        low = larger((run.begin - centre) / run.step, self.writer.constant(-1.0))
        high = smaller((run.end - centre) / run.step, self.writer.constant(1.0))
        for s in (low, high):
            bound = (s > -1.0) & (s < 1.0) | (t0 <= run.begin) & (s <= -1.0)
            self._take(where & bound, horner(polynomial, s))

    def _take(self, where: Mask, value: Lanes) -> None:
        maximum, minimum = self.cells.maximum, self.cells.minimum
        maximum.set_where(where, larger(value, maximum.get()))
        minimum.set_where(where, smaller(value, minimum.get()))


def _turning_point(polynomial: list[Any], near: Lanes, far: Lanes, shift: Lanes) -> Lanes:
    """Where the derivative vanishes in [shift, shift + 1], by Newton from a secant."""
    slope = derivative(polynomial)
    curvature = derivative(slope)
    s = reciprocal_quotient(near, near - far) + shift
    for _ in range(_NEWTON_STEPS):
        inverse = s.writer.reciprocal(horner(curvature, s))
        s = _within(s - horner(slope, s) * inverse, shift)
    # So close by now that the curvature is that of the last step.
    return _within(s - horner(slope, s) * inverse, shift)


def _within(s: Lanes, shift: Lanes) -> Lanes:
    return larger(smaller(s, shift + 1.0), shift)
