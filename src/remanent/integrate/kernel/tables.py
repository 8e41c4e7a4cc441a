"""The load at every node of a cycle, the same for all trajectories."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from remanent._typing import FloatArray


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
    fine, coarse = (
        _build_waveform_table(waveform, nodes, n, shift) for n in (2 * double_steps, double_steps)
    )
    return fine, coarse


class CycleTables:
    """The tables of one load, made once for each resolution.

    What changes: tables that were made are remembered, the last 256 of them.  They are the same
    however often they are asked for, and may be asked for by several threads.

    Parameters
    ----------
    waveform, shift
        See :func:`build_waveform_tables`.
    """

    def __init__(self, waveform: Callable[[FloatArray], FloatArray], shift: float = 0.0) -> None:
        @lru_cache(maxsize=256)
        def tables(nodes: tuple[float, ...], double_steps: int) -> tuple[FloatArray, FloatArray]:
            return build_waveform_tables(waveform, nodes, double_steps, shift)

        self._cached_tables = tables

    def __call__(
        self, nodes: tuple[float, ...], double_steps: int
    ) -> tuple[FloatArray, FloatArray]:
        """The tables for steps with these nodes, with so many double steps in a cycle."""
        return self._cached_tables(nodes, double_steps)


def _build_waveform_table(
    waveform: Callable[[FloatArray], FloatArray], nodes: Sequence[float], steps: int, shift: float
) -> FloatArray:
    phase = (np.arange(steps)[:, None] + np.array(nodes)) / steps + shift
    phase = np.where(phase > 1.0, phase - 1.0, phase)
    values = np.asarray(waveform(phase), dtype=float).reshape(-1, *phase.shape)
    return np.ascontiguousarray(np.concatenate([phase[None], values]).transpose(1, 2, 0))
