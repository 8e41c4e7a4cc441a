"""One attempt: trajectories that share a resolution, run from start to end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from remanent._field import BINARY
from remanent._timeline import Timeline
from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble import dense
from remanent.integrate.ensemble.problem import Problem, Request, Window, latest_trusted_time
from remanent.integrate.kernel.compile import Kernel, Kernels
from remanent.integrate.kernel.layout import PAST
from remanent.integrate.methods.runge_kutta import default_method

#: Without a period, resolution counts double steps per this time (about one oscillation).
NOMINAL = 2.5
#: Errors above this no longer follow the order of the method.
NONLINEAR = 1e-2
#: Instructions of all trajectories in one call of a kernel: hundredths of a second, so that
#: calls cost little and a run is cancelled within a fifth of a second.
_WORK_PER_CALL = 2**28
#: Instructions that a function such as ``exp`` stands for.
_FUNCTION = 20
#: Fine steps of all trajectories in one call whose states are all recorded: memory.
_RECORDED_PER_CALL = 2**17
#: The least and the most fine steps of one trajectory in a call.
_STEPS_PER_CALL = (64, 2**15)
#: More cycles than anybody waits for; representable.
_ENDLESS = 2**53
#: Samples computed together between steps: few enough to stay in the processor's cache.
_SAMPLES_AT_ONCE = 8192
#: The end is moved by this factor so that rounding cannot put it past the last step.
_INWARD = 1.0 - 2.0**-50


@dataclass(frozen=True)
class Stretch:
    """A run of equal cycles, or a part of one: one call of a kernel.

    Attributes
    ----------
    length : array (trajectory,)
        Of one cycle, tau.
    start : array (trajectory,)
        When the stretch begins.
    cycles, first : int
        How many cycles; how many came before them.
    resolution : int
        Double steps in a whole cycle.
    part : slice
        Those double steps of the cycle that are taken: all of them if ``cycles > 1``.
    past : bool
        Whether rates of enough earlier steps are known.
    parameters : dict of name to array
        That hold during this stretch.
    """

    length: FloatArray
    start: FloatArray
    cycles: int
    first: int
    resolution: int
    part: slice
    past: bool
    parameters: dict[str, FloatArray]

    @property
    def end(self) -> int:
        """Whole cycles that are over when the stretch ends; -1 within a cycle."""
        return self.first + self.cycles if self.part.stop == self.resolution else -1

    @property
    def doubles(self) -> int:
        """Double steps taken in each cycle."""
        return int(self.part.stop - self.part.start)

    @property
    def step(self) -> FloatArray:
        """Length of a fine step, tau, array (trajectory,)."""
        return self.length / (2 * self.resolution)

    def phase(self, steps: IntArray | int) -> FloatArray:
        """Phase of the cycle after so many fine steps of the stretch."""
        within = steps if self.cycles == 1 else np.remainder(steps, 2 * self.doubles)
        return np.asarray((2 * self.part.start + within) / (2 * self.resolution))

    def tables(self, whole: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Those rows of the tables of a whole cycle that belong to the part."""
        fine, coarse = whole
        return fine[2 * self.part.start : 2 * self.part.stop], coarse[self.part]


@dataclass
class Attempt:
    """Raw results for the trajectories of one chunk.

    ``values`` maps the names of :data:`~remanent.integrate.kernel.layout.SCALARS` to arrays
    (trajectory,); ``last`` is the state at the horizon.
    """

    values: dict[str, FloatArray]
    last: FloatArray
    states: FloatArray | None
    findings: list[Any]


def hopeless(tolerance: float) -> float:
    """An error from which on a trajectory teaches nothing more about its resolution."""
    return max(tolerance, NONLINEAR)


def double_steps(
    timeline: Timeline, resolution: int, which: IntArray | slice = slice(None)
) -> IntArray:
    """Double steps in every piece, array (piece, trajectory), at a resolution."""
    lengths = timeline.lengths[:, which]
    if timeline.periodic:
        return np.full(lengths.shape, resolution, dtype=np.int64)
    with np.errstate(over="ignore"):
        count = np.ceil(lengths * (resolution / NOMINAL) - 1e-9)
    return np.asarray(np.clip(count, 1, 2**40), dtype=np.int64)


def cycle_counts(problem: Problem, which: IntArray | slice = slice(None)) -> IntArray:
    """How many cycles each of some trajectories takes, array (trajectory,)."""
    duration = problem.duration[which]
    if not problem.timeline.periodic:
        return np.ones(duration.shape, dtype=np.int64)
    with np.errstate(over="ignore"):
        ratio = duration / problem.timeline.lengths[0, which]
    return np.asarray(np.ceil(ratio * (1 - 1e-12)).clip(1, _ENDLESS), dtype=np.int64)


def step_counts(
    problem: Problem, resolution: int, which: IntArray | slice = slice(None)
) -> FloatArray:
    """Fine steps of each trajectory, array (trajectory,)."""
    steps = double_steps(problem.timeline, resolution, which).sum(axis=0)
    return np.asarray(2.0 * steps * cycle_counts(problem, which))


def steps_per_call(kernel: Kernel, trajectories: int, *, recorded: bool) -> int:
    """Fine steps of each of so many trajectories in one call of a kernel."""
    code = kernel.field.rates.code
    work = sum(1 if operation in BINARY else _FUNCTION for operation, *_ in code)
    steps = _WORK_PER_CALL // max(kernel.method.evaluations * work, 1)
    together = -(-trajectories // kernel.width) * kernel.width
    most = min(steps, _RECORDED_PER_CALL) if recorded else steps
    return int(np.clip(most // together, *_STEPS_PER_CALL))


def stretches(
    timeline: Timeline,
    which: IntArray,
    doubles: IntArray,
    cycles: int,
    strobe: int,
    longest: int,
) -> Iterator[Stretch]:
    """Cut the run of some trajectories into calls of a kernel of at most `longest` fine steps.

    The cuts change nothing in what a trajectory undergoes.
    """
    start = np.zeros(which.size)
    for k, lengths in enumerate(timeline.lengths[:, which]):
        parameters = {name: v[k, which] for name, v in timeline.parameters.items()}
        total = cycles if timeline.periodic else 1
        for first, count, part, past in _calls(
            total, int(doubles[k]), strobe, longest, single=not timeline.periodic
        ):
            begin = start + (first + part.start / doubles[k]) * lengths
            yield Stretch(lengths, begin, count, first, int(doubles[k]), part, past, parameters)
        start = start + lengths


#: Cycles before a call, cycles in it, the part of the cycle that is taken, and whether
#: rates of enough earlier steps are known.
_Call = tuple[int, int, slice, bool]


def _calls(
    cycles: int, doubles: int, strobe: int, longest: int, *, single: bool
) -> Iterator[_Call]:
    """The calls of one piece: a start, the rest of the cycle it ends in, whole cycles.

    How a step is made must not depend on how many cycles follow, which other
    trajectories decide; a `single` piece is the same for all.
    """
    warm = PAST - 1
    begun = -(-warm // doubles)  # cycles that the start takes part in
    if single and doubles < 3 * warm:
        yield 0, 1, slice(0, doubles), False
        return
    if begun > 1:
        yield 0, min(begun, cycles), slice(0, doubles), False
    else:
        yield 0, 1, slice(0, warm), False
        yield from ((0, 1, part, True) for part in _parts(warm, doubles, longest))
    per_call = max(1, longest // (2 * doubles))
    if strobe and begun % strobe and begun < cycles:
        aligned = min(strobe - begun % strobe, cycles - begun)
        yield begun, aligned, slice(0, doubles), True
        begun += aligned
    if strobe:
        per_call = strobe * max(1, per_call // strobe)
    for first in range(begun, cycles, per_call):
        if 2 * doubles <= longest or strobe:
            yield first, min(per_call, cycles - first), slice(0, doubles), True
        else:
            yield from ((first, 1, part, True) for part in _parts(0, doubles, longest))


def _parts(first: int, doubles: int, longest: int) -> Iterator[slice]:
    """Parts of a cycle that are short enough for one call."""
    size = longest // 2
    for begin in range(first, doubles, size):
        yield slice(begin, min(begin + size, doubles))


#: ``tables(nodes, resolution)`` gives the waveforms of a whole cycle.
Tables = Callable[[tuple[float, ...], int], tuple[FloatArray, FloatArray]]


def attempt(
    problem: Problem,
    request: Request,
    kernels: Kernels,
    tolerance: float,
    resolution: int,
    which: IntArray,
    tables: Tables,
    keep_going: Callable[[], bool],
) -> Attempt:
    """Integrate the trajectories `which` once, at one resolution.

    All of them must have the same number of double steps in every piece.
    """
    doubles = double_steps(problem.timeline, resolution, which[:1])[:, 0]
    cycles = int(cycle_counts(problem, which).max())
    lanes = _lanes(problem, request, kernels, tolerance, which)
    sampler = _Sampler(problem, request, kernels, which, cycles, keep_going)
    recorded = request.times is not None or request.inspect is not None
    longest = steps_per_call(kernels.run, which.size, recorded=recorded)
    for stretch in stretches(problem.timeline, which, doubles, cycles, request.strobe, longest):
        if not keep_going():
            break
        _set_stretch(lanes, kernels, problem, stretch)
        kernel = kernels.run if stretch.past else kernels.start
        whole = tables(kernel.method.nodes, stretch.resolution)
        sampler.run(lanes, stretch.tables(whole), stretch)
        if not (_column(lanes, kernels, "total")[: which.size] <= hopeless(tolerance)).any():
            break
    return _collect(lanes, kernels, which.size, sampler)


def _lanes(
    problem: Problem, request: Request, kernels: Kernels, tolerance: float, which: IntArray
) -> FloatArray:
    """The array (group, slot, lane) of a chunk, padded with copies of its last trajectory."""
    layout, width = kernels.layout, kernels.width
    groups = -(-which.size // width)
    padded = np.concatenate([which, np.full(groups * width - which.size, which[-1])])
    flat = np.zeros((padded.size, layout.size))
    for kind in ("fine", "coarse", "last"):
        flat[:, layout.group(kind)] = problem.initial[padded]
    flat[:, layout.group("parameter")] = problem.parameters[padded]
    scalars: dict[str, FloatArray | float] = {
        "begin": 0.0 if request.begin is None else request.begin[padded] * _INWARD,
        "end": problem.duration[padded] * _INWARD,
        "tolerance": tolerance,
        "hopeless": hopeless(tolerance),
        "alive": 1.0,
        "horizon": np.inf,
        "maximum": -np.inf,
        "minimum": np.inf,
    }
    for name, value in scalars.items():
        flat[:, layout.slots[name]] = value
    grouped = flat.reshape(groups, width, layout.size)
    return np.ascontiguousarray(grouped.transpose(0, 2, 1))


def _column(lanes: FloatArray, kernels: Kernels, name: str) -> FloatArray:
    return lanes[:, kernels.layout.slots[name], :].reshape(-1)


def _set_column(lanes: FloatArray, slot: int, values: FloatArray) -> None:
    padded = np.full(lanes.shape[0] * lanes.shape[2], values[-1])
    padded[: values.size] = values
    lanes[:, slot, :] = padded.reshape(lanes.shape[0], lanes.shape[2])


def _set_stretch(lanes: FloatArray, kernels: Kernels, problem: Problem, stretch: Stretch) -> None:
    slots = kernels.layout.slots
    _set_column(lanes, slots["cycle"], stretch.length)
    _set_column(lanes, slots["step"], stretch.step)
    _set_column(lanes, slots["start"], stretch.start)
    for name, values in stretch.parameters.items():
        index = problem.field.parameters.index(name)
        _set_column(lanes, slots[f"parameter.{index}"], values)


def _collect(lanes: FloatArray, kernels: Kernels, count: int, sampler: _Sampler) -> Attempt:
    flat = lanes.transpose(0, 2, 1).reshape(-1, kernels.layout.size)[:count]
    names = ("alive", "horizon", "error", "total", "maximum", "minimum")
    values = {name: flat[:, kernels.layout.slots[name]].copy() for name in names}
    ends = [flat[:, kernels.layout.group(kind)] for kind in ("fine", "last")]
    last = np.where((values["alive"] > 0.5)[:, None], *ends)
    return Attempt(values, last, sampler.states, sampler.findings)


class _Sampler:
    """Runs stretches and picks the states that are wanted from each."""

    def __init__(
        self,
        problem: Problem,
        request: Request,
        kernels: Kernels,
        which: IntArray,
        cycles: int,
        keep_going: Callable[[], bool],
    ) -> None:
        self.keep_going = keep_going
        self.problem, self.kernels, self.strobe = problem, kernels, request.strobe
        self.times = None if request.times is None else request.times[which]
        self.which, self.inspect = which, request.inspect
        self.findings: list[Any] = []
        self.count = which.size
        self.cycles = cycle_counts(problem, which)
        self.states: FloatArray | None = None
        self.done = 0
        samples = None
        if self.strobe:
            samples = cycles // self.strobe + 1
        elif self.times is not None:
            samples = self.times.shape[1]
        if samples is not None:
            self.states = np.full((which.size, samples, kernels.layout.states), np.nan)
            if self.strobe:
                self.states[:, 0] = problem.initial[which]

    def run(
        self, lanes: FloatArray, tables: tuple[FloatArray, FloatArray], stretch: Stretch
    ) -> None:
        """Advance by one stretch."""
        kernel = self.kernels.run if stretch.past else self.kernels.start
        every = self._every(stretch)
        before = lanes[:, self.kernels.layout.group("fine"), :][None].copy()
        count = 2 * stretch.doubles * stretch.cycles // every if every else 0
        record = np.full((count, *before.shape[1:]), np.nan)
        kernel(lanes, tables, record, cycles=stretch.cycles, every=every)
        if self.strobe:
            self._strobe(lanes, record, every, stretch)
        elif count:
            states = self._flat(np.concatenate([before, record]))
            if self.inspect is not None:
                self.findings.append(self.inspect(self._window(states, lanes, stretch)))
            if self.times is not None:
                self._interpolate(states, lanes, stretch)

    def _window(self, states: FloatArray, lanes: FloatArray, stretch: Stretch) -> Window:
        nodes = np.arange(states.shape[1])
        return Window(
            self.which,
            states,
            stretch.start,
            stretch.step,
            stretch.phase(nodes),
            1.0 / (2 * stretch.resolution),
            self._parameters(lanes)[:, : self.count],
            self._steps(stretch),
        )

    def _steps(self, stretch: Stretch) -> IntArray:
        """Steps of the stretch that belong to the run of each trajectory."""
        cycles = (self.cycles - stretch.first).clip(0, stretch.cycles)
        return np.asarray(2 * stretch.doubles * cycles)

    def _parameters(self, lanes: FloatArray) -> FloatArray:
        """Array (parameter, trajectory)."""
        found = lanes[:, self.kernels.layout.group("parameter"), :]
        groups, fields, width = found.shape
        return found.transpose(1, 0, 2).reshape(fields, groups * width)

    def _strobe(self, lanes: FloatArray, record: FloatArray, every: int, stretch: Stretch) -> None:
        """Keep the state after every so many cycles, recorded or at the end of a stretch."""
        assert self.states is not None
        if every == 1 and stretch.end > 0:  # the start: every step was recorded
            record = record[2 * stretch.doubles - 1 :: 2 * stretch.doubles]
            wanted = np.arange(1, stretch.cycles + 1) % self.strobe == 0
            record = record[wanted]
        elif every <= 1:
            at_end = stretch.end > 0 and stretch.end % self.strobe == 0
            record = lanes[:, self.kernels.layout.group("fine"), :][None][: int(at_end)].copy()
        found = self._flat(record)
        self.states[:, self.done + 1 : self.done + 1 + found.shape[1]] = found
        self.done += found.shape[1]

    def _every(self, stretch: Stretch) -> int:
        if self.strobe and not stretch.past:
            return 1
        if self.strobe:
            whole = stretch.doubles == stretch.resolution and stretch.first % self.strobe == 0
            return (
                2 * stretch.doubles * self.strobe if whole and stretch.cycles >= self.strobe else 0
            )
        if self.inspect is not None:
            return 1
        if self.times is None:
            return 0
        slack = 1e-9 * stretch.step
        begin = stretch.start - slack
        end = stretch.start + stretch.step * (2 * stretch.doubles * stretch.cycles) + slack
        wanted = (self.times >= begin[:, None]) & (self.times <= end[:, None])
        return int(wanted.any())

    def _flat(self, record: FloatArray) -> FloatArray:
        """From (record, group, state, lane) to (trajectory, record, state)."""
        moved = record.transpose(1, 3, 0, 2)
        trajectories = moved.shape[0] * moved.shape[1]
        return moved.reshape(trajectories, *moved.shape[2:])[: self.count]

    def _interpolate(self, states: FloatArray, lanes: FloatArray, stretch: Stretch) -> None:
        assert self.times is not None
        assert self.states is not None
        steps = self._steps(stretch)
        with np.errstate(all="ignore"):  # a piece may be empty for some trajectories
            position = (self.times - stretch.start[:, None]) / stretch.step[:, None]
            near = np.rint(position)
            position = np.where(np.abs(position - near) < 1e-9, near, position)
            inside = (position >= 0.0) & (position <= steps[:, None])
        horizon = _column(lanes, self.kernels, "horizon")[: self.count]
        trusted = self.times <= latest_trusted_time(horizon)[:, None]
        trajectory, sample = np.nonzero(inside & trusted & (steps > 0)[:, None])
        flat = self._parameters(lanes)
        for first in range(0, trajectory.size, _SAMPLES_AT_ONCE):
            if not self.keep_going():
                return
            some = slice(first, first + _SAMPLES_AT_ONCE)
            row, column = trajectory[some], sample[some]
            whole = np.floor(position[row, column]).astype(np.int64)
            part = position[row, column] - whole
            self.states[row, column] = dense.between(
                self.problem.field,
                default_method(),
                self.problem.timeline.waveform,
                states=states[row, whole],
                parameters=list(flat[:, row]),
                phase=stretch.phase(whole),
                span=part / (2 * stretch.resolution),
                time=part * stretch.step[row],
            )
