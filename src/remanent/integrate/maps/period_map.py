"""The map over whole drive periods, with its derivatives: what analysis works on.

Unlike an ensemble's run, a map is applied again and again to states that analysis chooses
(Newton's guesses, renormalised tangents), so the error that counts is that of each period.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import numpy as np

from remanent._field import Field
from remanent._typing import FloatArray, IntArray
from remanent.integrate.ensemble.ensemble import MAX_RESOLUTION
from remanent.integrate.ensemble.resolution import finer, ladder
from remanent.integrate.kernel.compile import Kernel, compiled
from remanent.integrate.kernel.kernel import Options
from remanent.integrate.kernel.tables import waveform_tables
from remanent.integrate.methods.runge_kutta import default_method
from remanent.integrate.variations import tangent

Judged = Literal["all", "state", "nothing"]
#: Groups of trajectories in one task of a thread.
_GROUPS = 32
#: Double steps per period to begin with.
_FIRST = 8


@dataclass(frozen=True)
class Image:
    """What a map made of some states.

    Attributes
    ----------
    state : array (point, state)
        After the last period.
    tangent : array (point, column, state)
        Derivatives, those along directions first, then those by parameters.
    error : array (point,)
        Estimated largest error that one period adds: of the state absolute, of the
        tangents, where they are judged, relative to the largest of them.
    resolution : array (point,)
        Double steps per period.
    visited : array (point, period, state), optional
        The state after each period.
    """

    state: FloatArray
    tangent: FloatArray
    error: FloatArray
    resolution: IntArray
    visited: FloatArray | None


class PeriodMap:
    """A field over whole periods of its load.

    Parameters
    ----------
    field
        Of the motion.
    waveform
        ``waveform(phase)``: the field's waveforms, array (waveform, *phase.shape).
    directions
        How many directions of the initial state are carried along.
    parameters
        Parameters with respect to which derivatives are carried along, or
        :data:`~remanent.integrate.variations.LOG_PERIOD`.
    phase
        Of the load where a period begins, in [0, 1).
    judged
        Whose error counts: "all", that of the derivatives too; "state", of the state alone,
        which takes less time; or "nothing", so that the map takes the steps it is told.
    """

    def __init__(
        self,
        field: Field,
        waveform: Callable[[FloatArray], FloatArray],
        *,
        directions: int = 0,
        parameters: Sequence[str] = (),
        phase: float = 0.0,
        judged: Judged = "all",
    ) -> None:
        self.field, self.dimension = field, len(field.state)
        self.directions, self.columns = directions, directions + len(parameters)
        carried = tangent(field, directions=directions, parameters=parameters)
        method = default_method()
        options = Options(
            local=True,
            companion=judged != "nothing",
            absolute=self.dimension,
            followed=self.dimension if judged == "state" and self.columns else None,
        )
        self.kernel: Kernel = compiled(carried if self.columns else field, method, options)
        self.order = method.order

        @lru_cache(maxsize=64)
        def tables(doubles: int) -> tuple[FloatArray, FloatArray]:
            return waveform_tables(waveform, method.nodes, doubles, phase)

        self._tables = tables

    def __call__(
        self,
        states: FloatArray,
        parameters: FloatArray,
        length: FloatArray,
        *,
        tolerance: FloatArray | float,
        cycles: int = 1,
        half: bool = False,
        tangent: FloatArray | None = None,
        resolution: IntArray | int = _FIRST,
        finest: int = MAX_RESOLUTION,
        visited: bool = False,
    ) -> Image:
        """Apply the map to many states.

        Parameters
        ----------
        states : array (point, state)
        parameters : array (point, parameter)
            In the order of ``field.parameters``.
        length : array (point,)
            Of a period, tau.
        tolerance : array (point,) or float
            Of the error that one period adds.
        cycles
            Periods.
        half
            Half a period more.
        tangent : array (point, column, state), optional
            To start from; by default unit directions, and nothing along parameters.
        resolution : array (point,) or int
            Double steps per period to begin with; an :class:`Image` says which were enough.
        finest
            Most double steps per period; points that need more keep the error they have.
        visited
            Keep the state after each period.
        """
        count = states.shape[0]
        start = self._start(states, tangent)
        levels = np.broadcast_to(ladder(np.asarray(resolution)), (count,)).copy()
        levels += levels % 2 if half else 0
        asked = np.broadcast_to(np.asarray(tolerance, dtype=np.float64), (count,))
        ends, error = np.full(start.shape, np.nan), np.full(count, np.inf)
        path = np.full((count, cycles, self.dimension), np.nan) if visited else None
        pending = np.arange(count)
        while pending.size:
            for level in np.unique(levels[pending]):
                some = pending[levels[pending] == level]
                ends[some], error[some], seen = self._run(
                    start[some], parameters[some], length[some], int(level), cycles, half, visited
                )
                if path is not None and seen is not None:
                    path[some] = seen
            missed = pending[~(error[pending] <= asked[pending])]
            wanted = self._finer(error[missed], asked[missed], levels[missed], half)
            pending = missed[wanted <= finest]
            levels[pending] = wanted[wanted <= finest]
        d = self.dimension
        columns = ends[:, d:].reshape(count, self.columns, d)
        return Image(ends[:, :d], columns, error, levels, path)

    def _start(self, states: FloatArray, tangent: FloatArray | None) -> FloatArray:
        count = states.shape[0]
        if tangent is None:
            tangent = np.zeros((count, self.columns, self.dimension))
            for k in range(self.directions):
                tangent[:, k, k] = 1.0
        return np.concatenate([states, tangent.reshape(count, -1)], axis=1)

    def _finer(
        self, error: FloatArray, tolerance: FloatArray, levels: IntArray, half: bool
    ) -> IntArray:
        wanted = finer(levels, error, tolerance, self.order, meaningless=1.0)
        return np.asarray(wanted + (wanted % 2 if half else 0))

    def _run(
        self,
        start: FloatArray,
        parameters: FloatArray,
        length: FloatArray,
        level: int,
        cycles: int,
        half: bool,
        visited: bool,
    ) -> tuple[FloatArray, FloatArray, FloatArray | None]:
        lanes = self._lanes(start, parameters, length, level, cycles + 1)
        pieces = [lanes[i : i + _GROUPS] for i in range(0, lanes.shape[0], _GROUPS)]

        def advance(piece: FloatArray) -> FloatArray | None:
            return self._advance(piece, level, cycles, half, visited)

        if len(pieces) == 1:
            records = [advance(pieces[0])]
        else:
            with ThreadPoolExecutor(os.cpu_count()) as pool:
                records = list(pool.map(advance, pieces))
        flat = lanes.transpose(0, 2, 1).reshape(-1, lanes.shape[1])[: start.shape[0]]
        layout = self.kernel.layout
        seen = None
        if visited:
            whole = np.concatenate([r for r in records if r is not None], axis=1)
            seen = whole.transpose(1, 3, 0, 2).reshape(-1, cycles, whole.shape[2])
            seen = seen[: start.shape[0], :, : self.dimension]
        return flat[:, layout.group("fine")], flat[:, layout.slots["total"]], seen

    def _advance(
        self, lanes: FloatArray, level: int, cycles: int, half: bool, visited: bool
    ) -> FloatArray | None:
        """Advance some groups in place; the states after each period where asked."""
        fine, coarse = self._tables(level)
        record = None
        if cycles:
            if visited:
                shape = (cycles, lanes.shape[0], self.kernel.layout.states, lanes.shape[2])
                record = np.empty(shape)
            every = 2 * level if visited else 0
            self.kernel(lanes, (fine, coarse), record, cycles=cycles, every=every)
        if half:
            self.kernel(lanes, (fine[:level], coarse[: level // 2]), None, cycles=1)
        return record

    def _lanes(
        self,
        start: FloatArray,
        parameters: FloatArray,
        length: FloatArray,
        level: int,
        cycles: int,
    ) -> FloatArray:
        """The array (group, slot, lane), padded with copies of the last point."""
        layout, width = self.kernel.layout, self.kernel.width
        count = start.shape[0]
        groups = -(-count // width)
        flat = np.zeros((groups * width, layout.size))
        slots = layout.slots
        flat[:count, layout.group("fine")] = start
        flat[:count, layout.group("coarse")] = start
        flat[:count, layout.group("parameter")] = parameters
        flat[:count, slots["cycle"]] = length
        flat[:count, slots["step"]] = length / (2 * level)
        flat[:count, slots["end"]] = 2.0 * cycles * length
        flat[count:] = flat[count - 1]
        flat[:, slots["tolerance"]] = flat[:, slots["hopeless"]] = np.inf
        flat[:, slots["alive"]] = 1.0
        return np.ascontiguousarray(flat.reshape(groups, width, -1).transpose(0, 2, 1))
