"""The load at every node of a cycle, the same for all trajectories."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from remanent._typing import FloatArray, IntArray

#: Tables of cycles with more double steps than this are made in blocks: a run without a period
#: is one cycle, whose whole tables may not fit into memory.
_MOST_DOUBLE_STEPS_OF_WHOLE_TABLES = 2**18
#: Tables of at most so many double steps are short: all that are in use are remembered, in some
#: megabytes.  Of longer ones, which a run takes long to go through once, only the last are.
_MOST_DOUBLE_STEPS_OF_SHORT_TABLES = 2**11
_REMEMBERED_SHORT_TABLES = 128
_REMEMBERED_LONG_TABLES = 1
#: Steps of a table that are filled at once, so that little memory is needed beside it.
_STEPS_FILLED_AT_ONCE = 2**10
#: Double steps of a block.
_DOUBLE_STEPS_PER_BLOCK = 2**12
#: Blocks that are remembered, by all threads: parts of one block are asked for in turn.
_REMEMBERED_BLOCKS = 32


def build_waveform_tables(
    waveform: Callable[[FloatArray], FloatArray],
    nodes: Sequence[float],
    double_steps: int,
    shift: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """Phase and waveforms at the nodes of the fine and of the coarse steps.

    Parameters
    ----------
    waveform : callable
        ``waveform(phase)`` gives ``(waveform, *phase.shape)``.
    nodes : sequence of float
        Where in a step the load is needed, from 0 to 1.
    double_steps : int
        Double steps in a cycle.
    shift : float
        Phase at which the cycle begins, in [0, 1).

    Returns
    -------
    fine, coarse : array (step, node, 1 + waveform)
        The phase in [0, 1], then the waveforms.
    """
    return _build_rows(waveform, nodes, double_steps, shift, slice(0, double_steps))


@lru_cache(maxsize=4)
def cycle_tables(waveform: Callable[[FloatArray], FloatArray], shift: float) -> CycleTables:
    """The tables of a load, the same for all maps that ask for those of one waveform."""
    return CycleTables(waveform, shift)


class CycleTables:
    """The tables of one load, made once for each resolution.

    What changes: short tables that were made are remembered, and the last few of longer ones and
    of blocks.  They are the same however often they are asked for, and may be asked for by
    several threads.

    Parameters
    ----------
    waveform, shift
        See :func:`build_waveform_tables`.
    """

    def __init__(self, waveform: Callable[[FloatArray], FloatArray], shift: float = 0.0) -> None:
        def tables(nodes: tuple[float, ...], double_steps: int) -> tuple[FloatArray, FloatArray]:
            return build_waveform_tables(waveform, nodes, double_steps, shift)

        @lru_cache(maxsize=_REMEMBERED_BLOCKS)
        def block(
            nodes: tuple[float, ...], double_steps: int, number: int
        ) -> tuple[FloatArray, FloatArray]:
            begin = number * _DOUBLE_STEPS_PER_BLOCK
            part = slice(begin, min(begin + _DOUBLE_STEPS_PER_BLOCK, double_steps))
            return _build_rows(waveform, nodes, double_steps, shift, part)

        self._short_tables = lru_cache(maxsize=_REMEMBERED_SHORT_TABLES)(tables)
        self._long_tables = lru_cache(maxsize=_REMEMBERED_LONG_TABLES)(tables)
        self._cached_block = block

    def __call__(
        self, nodes: tuple[float, ...], double_steps: int
    ) -> tuple[FloatArray, FloatArray]:
        """The tables for steps with these nodes, with so many double steps in a cycle."""
        is_short = double_steps <= _MOST_DOUBLE_STEPS_OF_SHORT_TABLES
        return (self._short_tables if is_short else self._long_tables)(nodes, double_steps)

    def of_lanes(
        self, nodes: tuple[float, ...], double_steps: IntArray
    ) -> tuple[tuple[FloatArray, FloatArray], IntArray]:
        """The tables for lanes that differ in their double steps in a cycle.

        Parameters
        ----------
        nodes : tuple of float
        double_steps : array (lane,)

        Returns
        -------
        (fine, coarse) : arrays (step, node, 1 + waveform)
            Those of all numbers of double steps, one after the other.
        first_row : array (lane,)
            Of the coarse table where that of each lane begins.
        """
        of_lanes = double_steps.tolist()
        counts = sorted(set(of_lanes))
        tables = [self(nodes, count) for count in counts]
        fine, coarse = (np.concatenate(parts) for parts in zip(*tables, strict=True))
        first_rows = dict(zip(counts, itertools.accumulate(counts, initial=0), strict=False))
        return (fine, coarse), np.array([first_rows[count] for count in of_lanes])

    def rows(
        self, nodes: tuple[float, ...], double_steps: int, part: slice
    ) -> tuple[FloatArray, FloatArray]:
        """Those rows of the tables that belong to a part of the double steps of a cycle.

        Blocks have fixed places, so that no row depends on how a cycle is cut.
        """
        if double_steps <= _MOST_DOUBLE_STEPS_OF_WHOLE_TABLES:
            first, (fine, coarse) = 0, self(nodes, double_steps)
        else:
            size = _DOUBLE_STEPS_PER_BLOCK
            numbers = range(part.start // size, -(-part.stop // size))
            first = numbers.start * size
            blocks = [self._cached_block(nodes, double_steps, number) for number in numbers]
            fine, coarse = (np.concatenate(tables) for tables in zip(*blocks, strict=True))
        begin, end = part.start - first, part.stop - first
        return fine[2 * begin : 2 * end], coarse[begin:end]


def _build_rows(
    waveform: Callable[[FloatArray], FloatArray],
    nodes: Sequence[float],
    double_steps: int,
    shift: float,
    part: slice,
) -> tuple[FloatArray, FloatArray]:
    """Rows of the fine and of the coarse table that belong to some double steps."""
    fine, coarse = (
        _build_waveform_table(
            waveform, nodes, n * double_steps, shift, np.arange(n * part.start, n * part.stop)
        )
        for n in (2, 1)
    )
    return fine, coarse


def _build_waveform_table(
    waveform: Callable[[FloatArray], FloatArray],
    nodes: Sequence[float],
    steps: int,
    shift: float,
    numbers: IntArray,
) -> FloatArray:
    """Phase and waveforms at the nodes of those of the steps that have these numbers."""
    waveform_count = np.asarray(waveform(np.zeros((1, 1)))).size
    table = np.empty((numbers.size, len(nodes), 1 + waveform_count))
    for first in range(0, numbers.size, _STEPS_FILLED_AT_ONCE):
        rows = slice(first, first + _STEPS_FILLED_AT_ONCE)
        phase = (numbers[rows, None] + np.array(nodes)) / steps + shift
        phase = np.where(phase > 1.0, phase - 1.0, phase)
        table[rows, :, 0] = phase
        values = np.asarray(waveform(phase), dtype=float).reshape(waveform_count, *phase.shape)
        table[rows, :, 1:] = np.moveaxis(values, 0, -1)
    return table
