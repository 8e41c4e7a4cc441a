"""A field and a method become one function over groups of trajectories.

The kernel advances two solutions in lockstep, one with steps of length h and one
with steps of length 2h.  Their difference after each double step, divided by
2**(counted order) - 1 and multiplied by a safety factor, estimates the error of the finer
one at that instant, so the bound costs half as much as the solution, needs no
memory, and gives the time up to which the tolerance was met.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import chain
from typing import Any

from llvmlite import ir

from remanent._field import Field, Program
from remanent.integrate.kernel.extrema import Jet, derivative, hermite_coefficients, horner
from remanent.integrate.kernel.lanes import (
    DOUBLE,
    INTEGER,
    LaneFunctions,
    Lanes,
    Mask,
    Variable,
    Writer,
    larger,
    quotient,
    smaller,
)
from remanent.integrate.kernel.layout import SOLUTIONS, Layout
from remanent.integrate.kernel.outline import LONG, Outlined
from remanent.integrate.methods.adams import Adams, partners
from remanent.integrate.methods.runge_kutta import RungeKutta, carried
from remanent.integrate.methods.stepping import AdamsSteps, RungeKuttaSteps, Stepper

NAME = "kernel"
#: Newton steps from a secant start, before one more with the same curvature; an extremum
#: then moves by less than round-off.
_NEWTON_STEPS = 2
#: The polynomial between steps errs by its next coefficient times (s**3 - s)**3, at most
#: this in [-1, 1]; its last coefficient is larger than the next, where steps resolve the motion.
_BETWEEN = 0.057
#: Estimated error of the state, relative to one plus its size, from which on two solutions
#: have parted, so that their extremes are no measure of each other.
_PARTED = 1e-2


@dataclass(frozen=True)
class Options:
    """What a kernel follows.

    Attributes
    ----------
    extremes
        Follow the extremes of the watched observable, and control their error; else
        control the error of the state.
    safety
        Factor between the estimate from two step sizes and the error reported.
    companion
        Advance the coarser solution too.  Without it nothing is known of the error.
    local
        Start the coarser solution anew from the finer one in every cycle, so that the
        largest error of a cycle by itself is known; the run goes on whatever that is.
        Only for methods that need no past.
    absolute
        How many of the first state variables have their error counted as it is (all by
        default); that of the others is divided by the largest of them, where above 1.
    followed
        How many of the first state variables the companion has (all by default): these
        must not depend on the others, whose error is then not known.  Only with `local`.
    """

    extremes: bool = False
    safety: float = 4.0
    companion: bool = True
    local: bool = False
    absolute: int | None = None
    followed: int | None = None


#: What a kernel can integrate with.
Method = RungeKutta | Adams


def layout_of(field: Field, options: Options) -> Layout:
    """Slots of the trajectories of a field, the same whatever the method."""
    pasts = tuple(i for i, partner in enumerate(partners(field)) if partner is None)
    if options.local:  # no method that needs a past
        pasts = ()
    return Layout(len(field.state), len(field.parameters), pasts)


def kernel_source(
    field: Field, method: Method, options: Options, width: int, *, estimates: bool = False
) -> str:
    """LLVM assembly of the kernel ``void kernel(...)``.

    Its arguments are pointers to doubles ``lanes (group, slot, lane)`` (see
    :class:`~remanent.integrate.kernel.layout.Layout`), ``fine`` and ``coarse`` (waveform
    tables, see :func:`~remanent.integrate.kernel.tables.waveform_tables`), ``record``
    ``(record, group, state, lane)``, and integers: number of groups, cycles, double
    steps per cycle, fine steps between records (0: none).  With `estimates` the code is for a
    processor that estimates reciprocals of eight numbers at once.
    """
    module = ir.Module(name="remanent")
    pointer = DOUBLE.as_pointer()
    signature = ir.FunctionType(ir.VoidType(), [pointer] * 4 + [INTEGER] * 4)
    function = ir.Function(module, signature, NAME)
    builder = ir.IRBuilder(function.append_basic_block("entry"))
    begin = function.append_basic_block("begin")
    builder.branch(begin)
    builder.position_at_end(begin)
    writer = Writer(builder, width, estimates)
    _Kernel(field, method, options, writer, function.args).write()
    builder.ret_void()
    return str(module)


class _Kernel:
    """The pieces of one kernel while it is being written."""

    def __init__(
        self, field: Field, method: Method, options: Options, writer: Writer, args: Any
    ) -> None:
        self.field, self.method, self.options, self.w = field, method, options, writer
        self.lanes, self.fine, self.coarse, self.record = args[:4]
        self.groups, self.cycles, self.doubles, self.every = args[4:]
        self.layout = layout_of(field, options)
        self.functions = LaneFunctions(writer)
        self.followed = options.followed or len(field.state)
        called = len(field.rates.code) > LONG and isinstance(method, RungeKutta)
        sizes = {len(field.state), self.followed} if called else set()
        self.outlined = {size: Outlined(field, writer, size) for size in sorted(sizes)}
        kinds = SOLUTIONS if options.companion else SOLUTIONS[:1]
        self.stepper: Stepper = (
            RungeKuttaSteps(method, self._rates, self.layout.pasts, kinds, writer)
            if isinstance(method, RungeKutta)
            else AdamsSteps(method, self._rates, partners(field), kinds, writer)
        )

    def write(self) -> None:
        with self.w.loop(self.groups) as (group, _):
            self.group = group
            self._load()
            with self.w.loop(self.cycles) as (cycle, leave_if):
                self.cycle_start = self.start + self.w.spread_integer(cycle) * self.cycle
                leave_if(self.w.builder.not_(self._active().any()))
                if self.options.local:
                    self._set_state("coarse", self._state("fine")[: self.followed])
                if self.options.extremes:
                    self.at_edge = self._near_an_end()
                with self.w.loop(self.doubles) as (double, _):
                    self._double_step(cycle, double)
            if self.options.extremes:
                self._resolve()
            self._save()

    # state of a group ---------------------------------------------------------------

    def _index(self, slot: int) -> ir.Value:
        b, w = self.w.builder, self.w
        base = b.mul(self.group, w.integer(self.layout.size * w.width))
        return b.add(base, w.integer(slot * w.width))

    def _read(self, name: str) -> Lanes:
        return self.w.load(self.lanes, self._index(self.layout.slots[name]))

    def _load(self) -> None:
        own = {*(f"parameter.{i}" for i in range(self.layout.parameters)), *self.layout.past}
        names = [n for n in self.layout.slots if n not in own]
        fixed = ("step", "cycle", "start", "begin", "end", "tolerance", "hopeless")
        constants = {n: self._read(n) for n in fixed}
        self.h, self.cycle, self.start, self.begin, self.end = list(constants.values())[:5]
        self.tolerance, self.hopeless = constants["tolerance"], constants["hopeless"]
        self.parameters = [self._read(f"parameter.{i}") for i in range(len(self.field.parameters))]
        for outlined in self.outlined.values():
            outlined.prepare(self.parameters)
        self.v: dict[str, Variable] = {
            n: self.w.variable(self._read(n)) for n in names if n not in constants
        }
        self.stepper.load(self._read)
        if self.options.extremes:
            self._prepare_extremes()

    def _save(self) -> None:
        for name, variable in self.v.items():
            self._write(name, variable.get())
        last = self.w.builder.sub(self.doubles, self.w.integer(1))
        last_fine = self.w.builder.add(last, self.doubles)
        ends = {"fine": self._row(self.fine, last_fine), "coarse": self._row(self.coarse, last)}
        self.stepper.save(self._write, ends)

    def _write(self, name: str, value: Lanes) -> None:
        self.w.store(value, self.lanes, self._index(self.layout.slots[name]))

    def _state(self, kind: str) -> list[Lanes]:
        count = self.followed if kind == "coarse" else len(self.field.state)
        return [self.v[f"{kind}.{i}"].get() for i in range(count)]

    def _set_state(self, kind: str, y: list[Lanes]) -> None:
        for i, y_i in enumerate(y):
            self.v[f"{kind}.{i}"].set(y_i)

    def _active(self) -> Mask:
        """Where there is more to learn."""
        return (self.v["total"].get() <= self.hopeless) & (self.cycle_start < self.end)

    # field ----------------------------------------------------------------------------

    def _row(self, table: ir.Value, step: ir.Value) -> Callable[[int], list[Lanes]]:
        """Phase and waveforms at a node of a step, as functions of the node."""
        columns = 1 + len(self.field.waveforms)
        row = len(self.method.nodes) * columns
        base = self.w.builder.mul(step, self.w.integer(row))

        def at(node: int) -> list[Lanes]:
            index = (self.w.integer(node * columns + k) for k in range(columns))
            return [
                self.w.spread(self.w.load_scalar(table, self.w.builder.add(base, k))) for k in index
            ]

        return at

    def _run(
        self,
        program: Program,
        y: Sequence[Lanes],
        load: list[Lanes],
        divide: Callable[[Any, Any], Any] = quotient,
    ) -> list[Lanes]:
        return program(
            [load[0], *y, *self.parameters, *load[1:]],
            functions=self.functions,
            constant=self.w.constant,
            divide=divide,
        )

    def _rates(
        self,
        y: Sequence[Lanes],
        load: list[Lanes],
        divide: Callable[[Any, Any], Any] = quotient,
    ) -> list[Lanes]:
        """The rates of all state variables, or of the first ones, on which no others act."""
        if self.outlined:
            return self.outlined[len(y)](load[0], y, load[1:])
        absent = [self.w.constant(0.0)] * (len(self.field.state) - len(y))
        return self._run(self.field.rates, [*y, *absent], load, divide)[: len(y)]

    def _fine_step(self, step: ir.Value) -> list[Lanes]:
        """A step of h; what rounding cuts off is carried on, where many digits are wanted."""
        y, loads = self._state("fine"), self._row(self.fine, step)
        change = self.stepper.increment("fine", y, self.h, loads)
        if self.method.compensated:
            y, rest = carried(y, change, self._state("fine_rest"))
            self._set_state("fine_rest", rest)
        else:
            y = [a + b for a, b in zip(y, change, strict=True)]
        self._set_state("fine", y)
        self.stepper.settle("fine", y, loads)
        return y

    def _coarse_step(self, step: ir.Value) -> list[Lanes]:
        """A step of 2h, rounded to fewer digits.

        Errors of rounding grow along the motion like any other.  Those of the coarser
        solution are made as much larger as its truncation error is, so that their
        share in the difference of the solutions is what the finer one makes.
        """
        y, loads = self._state("coarse"), self._row(self.coarse, step)
        change = self.stepper.increment("coarse", y, self.h + self.h, loads)
        moved = [_rounded(a + b, self.method.lost_bits) for a, b in zip(y, change, strict=True)]
        self._set_state("coarse", moved)
        self.stepper.settle("coarse", moved, loads)
        return moved

    # one double step ------------------------------------------------------------------

    def _double_step(self, cycle: ir.Value, double: ir.Value) -> None:
        b, w = self.w.builder, self.w
        first = b.mul(double, w.integer(2))
        second = b.add(first, w.integer(1))
        left, before = self._state("fine"), self._state("coarse")
        middle = self._fine_step(first)
        right = self._fine_step(second)
        coarse = self._coarse_step(double) if self.options.companion else None
        if self.options.extremes:
            known = (before, coarse) if coarse else ()
            self._note_turns((left, middle, right, *known), first, second)
        elif coarse:
            self._judge_state(left, right, coarse, self._time(first))
        count = b.add(b.mul(cycle, b.mul(self.doubles, w.integer(2))), first)
        self._write_record(b.add(count, w.integer(1)), middle)
        self._write_record(b.add(count, w.integer(2)), right)

    @property
    def _scale(self) -> float:
        """Error of the finer solution over its difference from the coarser one."""
        return self.options.safety / float(2**self.method.counted_order - 1)

    def _time(self, step: ir.Value) -> Lanes:
        """tau at the beginning of a fine step of the cycle."""
        return self.cycle_start + self.w.spread_integer(step) * self.h

    def _judge_state(
        self, left: list[Lanes], fine: list[Lanes], coarse: list[Lanes], t0: Lanes
    ) -> None:
        """Compare the two solutions at the end of the double step that begins at `t0`."""
        parts = [abs(a - c) for a, c in zip(fine[: len(coarse)], coarse, strict=True)]
        count = self.options.absolute or len(parts)
        error = reduce(_worse, parts[:count])
        if parts[count:]:
            size = reduce(larger, map(abs, fine[count:]), self.w.constant(1.0))
            error = _worse(error, reduce(_worse, parts[count:]) / size)
        self._judge(t0 < self.end, error * self._scale, t0, left)

    def _judge(self, where: Mask, error: Lanes, before: Lanes, left: list[Lanes]) -> None:
        """Take an error into account; past the tolerance, note how far it was met.

        Parameters
        ----------
        where
            Trajectories that the error concerns.
        before, left
            Time up to which the tolerance is known to have been met, and the state then.
        """
        zero = self.w.constant(0.0)
        error = where.choose(error, zero)
        known = self.v["total"].get()
        if self.options.local:
            self.v["total"].set(_worse(known, error))
            return
        met = error <= self.tolerance
        dies = (self.v["alive"].get() > 0.5).without(met)
        self.v["total"].set(_worse(known, error))
        with self.w.builder.if_then(dies.any(), likely=False):
            self._update("alive", dies, zero)
            self._update("horizon", dies, before)
            self._update("error", dies, known)
            for i, y_i in enumerate(left):
                self._update(f"last.{i}", dies, y_i)

    def _update(self, name: str, where: Mask, value: Lanes) -> None:
        self.v[name].set(where.choose(value, self.v[name].get()))

    def _write_record(self, count: ir.Value, y: list[Lanes]) -> None:
        b, w = self.w.builder, self.w
        with b.if_then(b.icmp_signed("!=", self.every, w.integer(0)), likely=False):
            due = b.icmp_signed("==", b.srem(count, self.every), w.integer(0))
            with b.if_then(due, likely=False):
                self._write_state(b.sub(b.sdiv(count, self.every), w.integer(1)), y)

    def _write_state(self, number: ir.Value, y: list[Lanes]) -> None:
        b, w = self.w.builder, self.w
        base = b.add(b.mul(number, self.groups), self.group)
        base = b.mul(base, w.integer(len(y) * w.width))
        for i, y_i in enumerate(y):
            w.store(y_i, self.record, b.add(base, w.integer(i * w.width)))

    # extremes -------------------------------------------------------------------------

    def _prepare_extremes(self) -> None:
        """Cells for one turn of each trajectory that waits to be worked out.

        Turns of different trajectories rarely fall into one step.  They are kept until
        one of them turns again, and worked out together.
        """
        zero = self.w.constant(0.0)
        states, load = len(self.field.state), 1 + len(self.field.waveforms)
        count = self._nodes * states + 3 * load + 2
        self.kept = [self.w.variable(zero) for _ in range(count)]
        self.waiting = self.w.variable(zero)
        self.turn = self.w.variable(
            self._turn(self._state("fine"), self._row(self.fine, self.w.integer(0))(0))
        )

    @property
    def _nodes(self) -> int:
        """States kept of a turn: three of the solution, two of its companion."""
        return 5 if self.options.companion else 3

    def _turn(self, y: list[Lanes], load: list[Lanes]) -> Lanes:
        """A quantity with the sign of the watched observable's rate."""
        return self._run(self.field.watched, y, load)[3]

    def _note_turns(
        self, nodes: tuple[list[Lanes], ...], first: ir.Value, second: ir.Value
    ) -> None:
        """Keep the double step for every trajectory that turns, begins, ends or parts in it."""
        last = len(self.method.nodes) - 1
        row, end = self._row(self.fine, first), self._row(self.fine, second)(last)
        loads = (row(0), row(last), end)
        turns = (self.turn.get(), self._turn(nodes[1], loads[1]), self._turn(nodes[2], end))
        self.turn.set(turns[2])
        turned = (turns[0] * turns[1] <= 0.0) | (turns[1] * turns[2] <= 0.0)
        parted = turned.without(turned)
        if self.options.companion:
            parted = self._parted(nodes[2], nodes[4]) & (self.v["total"].get() <= self.hopeless)
        b = self.w.builder
        with b.if_then(b.or_((turned | parted).any(), self.at_edge), likely=False):
            t0 = self._time(first)
            t2 = t0 + self.h + self.h
            inside = (self.begin < t2) & (turned | (t0 <= self.begin) | (self.end <= t2))
            event = (t0 < self.end) & (inside | parted)
            zero, one = self.w.constant(0.0), self.w.constant(1.0)
            self._keep(event, [*chain(*nodes, *loads), t0, parted.choose(one, zero)])

    def _keep(self, event: Mask, values: list[Lanes]) -> None:
        """Let a double step wait to be worked out, after the one that has waited."""
        with self.w.builder.if_then((event & (self.waiting.get() > 0.5)).any(), likely=False):
            self._resolve()
        for cell, value in zip(self.kept, values, strict=True):
            cell.set(event.choose(value, cell.get()))
        self.waiting.set(event.choose(self.w.constant(1.0), self.waiting.get()))

    def _near_an_end(self) -> ir.Value:
        """Whether one of the group begins or ends to be followed in this cycle or next to it."""
        before, after = self.cycle_start - self.cycle, self.cycle_start + self.cycle * 2.0
        well = (self.begin < before) & (after < self.end)
        return (self.w.constant(0.0) <= 0.0).without(well).any()

    def _parted(self, fine: list[Lanes], coarse: list[Lanes]) -> Mask:
        """Where the two solutions differ too much to tell anything about each other.

        Extremes are compared at turns only, and two solutions that have both left the
        motion, to a thickness stretch of nearly nothing, agree on that.
        """
        always = self.w.constant(0.0) <= 0.0
        together = always
        for a, c in zip(fine, coarse, strict=True):
            together = together & (abs(a - c) * self._scale <= (abs(a) + 1.0) * _PARTED)
        return always.without(together)

    def _resolve(self) -> None:
        """Work out the turns that wait: their extremes and the error of these."""
        states, load = len(self.field.state), 1 + len(self.field.waveforms)
        cells = iter([cell.get() for cell in self.kept])
        nodes = [[next(cells) for _ in range(states)] for _ in range(self._nodes)]
        loads = [[next(cells) for _ in range(load)] for _ in range(3)]
        t0, parted = next(cells), next(cells) > 0.5
        waiting = self.waiting.get() > 0.5
        left, middle, right = (self._jet(y, u) for y, u in zip(nodes[:3], loads, strict=True))
        polynomial = hermite_coefficients(left, middle, right, self.h)
        if self.options.companion:
            apart = [
                self._apart(jet, self._jet(y, load))
                for jet, y, load in ((left, nodes[3], loads[0]), (right, nodes[4], loads[2]))
            ]
            error = _worse(*apart) * self._scale + abs(polynomial[-1]) * _BETWEEN
            endless = self.w.constant(math.inf)
            self._judge(waiting, parted.choose(endless, error), t0, nodes[0])
        alive = waiting & (self.v["alive"].get() > 0.5)
        self._take_extremes(alive, t0, (left, middle, right), polynomial)
        self.waiting.set(self.w.constant(0.0))

    def _apart(self, fine: Jet, coarse: Jet) -> Lanes:
        """How far two solutions may be apart within a step of a place where both are known."""
        value: Lanes = abs(fine[0] - coarse[0])
        rate: Lanes = abs(fine[1] - coarse[1])
        return value + self.h * rate

    def _jet(self, y: list[Lanes], load: list[Lanes]) -> Jet:
        value, rate, acceleration, _ = self._run(self.field.watched, y, load)
        return value, rate, acceleration

    def _take_extremes(
        self, where: Mask, t0: Lanes, jets: tuple[Jet, Jet, Jet], polynomial: list[Any]
    ) -> None:
        left, middle, right = jets
        centre = t0 + self.h
        first_half = left[1] * middle[1] <= 0.0
        near = first_half.choose(left[1], middle[1])
        far = first_half.choose(middle[1], right[1])
        shift = first_half.choose(self.w.constant(-1.0), self.w.constant(0.0))
        s = _turning_point(polynomial, near, far, shift)
        at = centre + s * self.h
        turned = (near * far <= 0.0) & (self.begin <= at) & (at <= self.end)
        self._take(where & turned, horner(polynomial, s))
        at_edge = where & ((t0 <= self.begin) | (self.end < centre + self.h))
        with self.w.builder.if_then(at_edge.any(), likely=False):
            self._take_edges(at_edge, t0, polynomial)

    def _take_edges(self, where: Mask, t0: Lanes, polynomial: list[Any]) -> None:
        """Values where the extremes begin and end to be followed, inside a double step."""
        centre = t0 + self.h
        low = larger((self.begin - centre) / self.h, self.w.constant(-1.0))
        high = smaller((self.end - centre) / self.h, self.w.constant(1.0))
        for at in (low, high):
            bound = (at > -1.0) & (at < 1.0) | (t0 <= self.begin) & (at <= -1.0)
            self._take(where & bound, horner(polynomial, at))

    def _take(self, where: Mask, value: Lanes) -> None:
        self._update("maximum", where, larger(value, self.v["maximum"].get()))
        self._update("minimum", where, smaller(value, self.v["minimum"].get()))


def _worse(a: Lanes, b: Lanes) -> Lanes:
    """The larger of two errors, NaN where one is."""
    return ((b <= a) | a.is_nan()).choose(a, b)


def _rounded(x: Lanes, bits: int) -> Lanes:
    """`x` without its last `bits` bits, to the nearest."""
    large = x * 2.0**bits
    return (x + large) - large


def _turning_point(polynomial: list[Any], near: Lanes, far: Lanes, shift: Lanes) -> Lanes:
    """Where the derivative vanishes in [shift, shift + 1], by Newton from a secant."""
    slope = derivative(polynomial)
    curvature = derivative(slope)
    s = quotient(near, near - far) + shift
    for _ in range(_NEWTON_STEPS):
        inverse = s.writer.reciprocal(horner(curvature, s))
        s = _within(s - horner(slope, s) * inverse, shift)
    # So close by now that the curvature is that of the last step.
    return _within(s - horner(slope, s) * inverse, shift)


def _within(s: Lanes, shift: Lanes) -> Lanes:
    return larger(smaller(s, shift + 1.0), shift)
