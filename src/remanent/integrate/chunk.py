"""One attempt: trajectories that share a resolution, run from start to end."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from remanent._timeline import Timeline
from remanent._typing import FloatArray, IntArray
from remanent.integrate import dense
from remanent.integrate.compile import Kernel
from remanent.integrate.problem import Problem, Request
from remanent.integrate.tables import waveform_tables

#: Without a period, resolution counts double steps per this time (about one oscillation).
NOMINAL = 2.5
#: Errors above this no longer follow the order of the method.
NONLINEAR = 1e-2
#: Error of rounding allowed for, in units of the last place per root of a step.
import os
ROUND_OFF = float(os.environ.get("RO","1.0"))
#: Fine steps in one call of the kernel: short enough to cancel soon.
_STEPS_PER_CALL = 2048
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
    parameters : dict of name to array
        That hold during this stretch.
    """

    length: FloatArray
    start: FloatArray
    cycles: int
    first: int
    resolution: int
    part: slice
    parameters: dict[str, FloatArray]

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
        within = np.remainder(steps, 2 * self.doubles)
        return np.asarray((2 * self.part.start + within) / (2 * self.resolution))

    def tables(self, whole: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
        """Those rows of the tables of a whole cycle that belong to the part."""
        fine, coarse = whole
        return fine[2 * self.part.start : 2 * self.part.stop], coarse[self.part]


@dataclass
class Attempt:
    """Raw results for the trajectories of one chunk.

    ``values`` maps the names of :data:`~remanent.integrate.layout.SCALARS` to arrays
    (trajectory,); ``last`` is the state at the horizon.
    """

    values: dict[str, FloatArray]
    last: FloatArray
    states: FloatArray | None


def hopeless(tolerance: float) -> float:
    """An error from which on a trajectory teaches nothing more about its resolution."""
    return max(tolerance, NONLINEAR)


def double_steps(timeline: Timeline, resolution: int) -> IntArray:
    """Double steps in every piece, array (piece, trajectory), at a resolution."""
    if timeline.periodic:
        return np.full(timeline.lengths.shape, resolution, dtype=np.int64)
    count = np.ceil(timeline.lengths * (resolution / NOMINAL) - 1e-9)
    return np.asarray(np.clip(count, 1, 2**40), dtype=np.int64)


def cycle_counts(problem: Problem) -> IntArray:
    """How many cycles each trajectory takes, array (trajectory,)."""
    if not problem.timeline.periodic:
        return np.ones(problem.duration.shape, dtype=np.int64)
    ratio = problem.duration / problem.timeline.lengths[0]
    safe = np.where(np.isfinite(ratio), ratio, 1.0)
    return np.asarray(np.ceil(safe * (1 - 1e-12)), dtype=np.int64).clip(1)


def step_counts(problem: Problem, resolution: int) -> FloatArray:
    """Fine steps of each trajectory, array (trajectory,)."""
    steps = double_steps(problem.timeline, resolution).sum(axis=0)
    return np.asarray(2.0 * steps * cycle_counts(problem))


def stretches(
    timeline: Timeline, which: IntArray, doubles: IntArray, cycles: int, strobe: int
) -> Iterator[Stretch]:
    """Cut the run of some trajectories into calls of the kernel."""
    start = np.zeros(which.size)
    for k, lengths in enumerate(timeline.lengths[:, which]):
        parameters = {name: v[k, which] for name, v in timeline.parameters.items()}
        total = cycles if timeline.periodic else 1
        for first, count, part in _calls(total, int(doubles[k]), strobe):
            begin = start + (first + part.start / doubles[k]) * lengths
            yield Stretch(lengths, begin, count, first, int(doubles[k]), part, parameters)
        start = start + lengths


def _calls(cycles: int, doubles: int, strobe: int) -> Iterator[tuple[int, int, slice]]:
    """Cycles before each call, cycles in it, and the part of the cycle that is taken."""
    per_call = _STEPS_PER_CALL // (2 * doubles)
    if strobe:
        per_call = strobe * max(1, per_call // strobe)
    if per_call:
        for first in range(0, cycles, per_call):
            yield first, min(per_call, cycles - first), slice(0, doubles)
        return
    for first in range(cycles):
        for begin in range(0, doubles, _STEPS_PER_CALL // 2):
            yield first, 1, slice(begin, min(begin + _STEPS_PER_CALL // 2, doubles))


def attempt(
    problem: Problem,
    request: Request,
    kernel: Kernel,
    tolerance: float,
    resolution: int,
    which: IntArray,
    keep_going: Callable[[], bool],
) -> Attempt:
    """Integrate the trajectories `which` once, at one resolution.

    All of them must have the same number of double steps in every piece.
    """
    doubles = double_steps(problem.timeline, resolution)[:, which[0]]
    cycles = int(cycle_counts(problem)[which].max())
    lanes = _lanes(problem, request, kernel, tolerance, resolution, which)
    sampler = _Sampler(problem, request, kernel, which, cycles)
    tables: dict[int, tuple[FloatArray, FloatArray]] = {}
    for stretch in stretches(problem.timeline, which, doubles, cycles, request.strobe):
        if not keep_going():
            break
        if stretch.resolution not in tables:
            tables[stretch.resolution] = waveform_tables(
                problem.timeline.waveform, kernel.method, stretch.resolution
            )
        _set_stretch(lanes, kernel, problem, stretch)
        sampler.run(lanes, stretch.tables(tables[stretch.resolution]), stretch)
        if not (_column(lanes, kernel, "total")[: which.size] <= hopeless(tolerance)).any():
            break
    return _collect(lanes, kernel, which.size, sampler.states)


def _lanes(
    problem: Problem,
    request: Request,
    kernel: Kernel,
    tolerance: float,
    resolution: int,
    which: IntArray,
) -> FloatArray:
    """The array (group, slot, lane) of a chunk, padded with copies of its last trajectory."""
    layout, width = kernel.layout, kernel.width
    groups = -(-which.size // width)
    padded = np.concatenate([which, np.full(groups * width - which.size, which[-1])])
    flat = np.zeros((padded.size, layout.size))
    for kind in ("fine", "coarse", "last"):
        flat[:, layout.group(kind)] = problem.initial[padded]
    flat[:, layout.group("coarse")] += _displacement(problem, kernel, resolution)[padded]
    flat[:, layout.group("parameter")] = problem.parameters[padded]
    scalars: dict[str, FloatArray | float] = {
        "begin": 0.0 if request.begin is None else request.begin[padded] * _INWARD,
        "end": problem.duration[padded] * _INWARD,
        "tolerance": tolerance,
        "hopeless": hopeless(tolerance),
        "alive": 1.0,
        "maximum": -np.inf,
        "minimum": np.inf,
    }
    for name, value in scalars.items():
        flat[:, layout.slots[name]] = value
    grouped = flat.reshape(groups, width, layout.size)
    return np.ascontiguousarray(grouped.transpose(0, 2, 1))


def _displacement(problem: Problem, kernel: Kernel, resolution: int) -> FloatArray:
    """How far from the initial state the coarse solution starts, array (trajectory, state).

    Rounding makes errors that both solutions may share.  They are replaced by one error
    at the start, as large as all of them together: what the motion makes of it is then
    part of the difference of the solutions, and so of the error reported.
    """
    size = ROUND_OFF * np.finfo(float).eps * np.sqrt(1.0 + step_counts(problem, resolution))
    sign = np.where(np.arange(problem.initial.shape[1]) % 2, -1.0, 1.0)
    scale = np.maximum(1.0, np.abs(problem.initial))
    return np.asarray(sign * scale * size[:, None] / kernel.error_factor)


def _column(lanes: FloatArray, kernel: Kernel, name: str) -> FloatArray:
    return lanes[:, kernel.layout.slots[name], :].reshape(-1)


def _set_column(lanes: FloatArray, slot: int, values: FloatArray) -> None:
    padded = np.full(lanes.shape[0] * lanes.shape[2], values[-1])
    padded[: values.size] = values
    lanes[:, slot, :] = padded.reshape(lanes.shape[0], lanes.shape[2])


def _set_stretch(lanes: FloatArray, kernel: Kernel, problem: Problem, stretch: Stretch) -> None:
    slots = kernel.layout.slots
    _set_column(lanes, slots["cycle"], stretch.length)
    _set_column(lanes, slots["step"], stretch.step)
    _set_column(lanes, slots["start"], stretch.start)
    for name, values in stretch.parameters.items():
        index = problem.field.parameters.index(name)
        _set_column(lanes, slots[f"parameter.{index}"], values)


def _collect(
    lanes: FloatArray, kernel: Kernel, count: int, states: FloatArray | None
) -> Attempt:
    flat = lanes.transpose(0, 2, 1).reshape(-1, kernel.layout.size)[:count]
    names = ("alive", "horizon", "error", "total", "watched_error", "maximum", "minimum")
    values = {name: flat[:, kernel.layout.slots[name]].copy() for name in names}
    return Attempt(values, flat[:, kernel.layout.group("last")].copy(), states)


class _Sampler:
    """Runs stretches and picks the states that are wanted from each."""

    def __init__(
        self, problem: Problem, request: Request, kernel: Kernel, which: IntArray, cycles: int
    ) -> None:
        self.problem, self.kernel, self.strobe = problem, kernel, request.strobe
        self.times = None if request.times is None else request.times[which]
        self.count = which.size
        self.cycles = cycle_counts(problem)[which]
        self.states: FloatArray | None = None
        self.done = 0
        samples = None
        if self.strobe:
            samples = cycles // self.strobe + 1
        elif self.times is not None:
            samples = self.times.shape[1]
        if samples is not None:
            self.states = np.full((which.size, samples, kernel.layout.states), np.nan)
            if self.strobe:
                self.states[:, 0] = problem.initial[which]

    def run(
        self, lanes: FloatArray, tables: tuple[FloatArray, FloatArray], stretch: Stretch
    ) -> None:
        """Advance by one stretch."""
        every = self._every(stretch)
        if not every:
            self.kernel(lanes, tables, cycles=stretch.cycles)
            return
        before = self._flat(lanes[:, self.kernel.layout.group("fine"), :][None].copy())
        count = 2 * stretch.doubles * stretch.cycles // every
        record = np.full(
            (count, lanes.shape[0], self.kernel.layout.states, self.kernel.width), np.nan
        )
        self.kernel(lanes, tables, record, cycles=stretch.cycles, every=every)
        after = self._flat(record)
        assert self.states is not None
        if self.strobe:
            self.states[:, self.done + 1 : self.done + 1 + count] = after
            self.done += count
        else:
            self._interpolate(np.concatenate([before, after], axis=1), lanes, stretch)

    def _every(self, stretch: Stretch) -> int:
        if self.strobe:
            return 2 * stretch.doubles * self.strobe if stretch.cycles >= self.strobe else 0
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
        return moved.reshape(-1, *moved.shape[2:])[: self.count]

    def _interpolate(self, states: FloatArray, lanes: FloatArray, stretch: Stretch) -> None:
        assert self.times is not None
        assert self.states is not None
        steps = 2 * stretch.doubles * (self.cycles - stretch.first).clip(0, stretch.cycles)
        with np.errstate(all="ignore"):  # a piece may be empty for some trajectories
            position = (self.times - stretch.start[:, None]) / stretch.step[:, None]
            near = np.rint(position)
            position = np.where(np.abs(position - near) < 1e-9, near, position)
            inside = (position >= 0.0) & (position <= steps[:, None])
        horizon = _column(lanes, self.kernel, "horizon")[: self.count]
        trusted = self.times <= horizon[:, None] * (1.0 + 1e-12)
        trajectory, sample = np.nonzero(inside & trusted & (steps > 0)[:, None])
        parameters = lanes[:, self.kernel.layout.group("parameter"), :]
        flat = parameters.transpose(1, 0, 2).reshape(parameters.shape[1], -1)
        for first in range(0, trajectory.size, _SAMPLES_AT_ONCE):
            some = slice(first, first + _SAMPLES_AT_ONCE)
            row, column = trajectory[some], sample[some]
            whole = np.floor(position[row, column]).astype(np.int64)
            part = position[row, column] - whole
            self.states[row, column] = dense.between(
                self.problem.field,
                self.kernel.method,
                self.problem.timeline.waveform,
                states=states[row, whole],
                parameters=list(flat[:, row]),
                phase=stretch.phase(whole),
                span=part / (2 * stretch.resolution),
                time=part * stretch.step[row],
            )
