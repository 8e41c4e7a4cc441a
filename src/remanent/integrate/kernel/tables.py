"""The load at every node of a cycle, the same for all trajectories."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from remanent._typing import FloatArray


def waveform_tables(
    waveform: Callable[[FloatArray], FloatArray],
    nodes: Sequence[float],
    doubles: int,
    shift: float = 0.0,
) -> tuple[FloatArray, FloatArray]:
    """Phase and waveforms at the nodes of the fine and of the coarse steps.

    Parameters
    ----------
    waveform
        ``waveform(phase)`` gives ``(waveform, *phase.shape)``.
    nodes
        Where in a step the load is needed, from 0 to 1.
    doubles
        Double steps in a cycle.
    shift
        Phase at which the cycle begins, in [0, 1).

    Returns
    -------
    fine, coarse : array (step, node, 1 + waveform)
        The phase in [0, 1], then the waveforms.
    """
    fine, coarse = (_table(waveform, nodes, n, shift) for n in (2 * doubles, doubles))
    return fine, coarse


def _table(
    waveform: Callable[[FloatArray], FloatArray], nodes: Sequence[float], steps: int, shift: float
) -> FloatArray:
    phase = (np.arange(steps)[:, None] + np.array(nodes)) / steps + shift
    phase = np.where(phase > 1.0, phase - 1.0, phase)
    values = np.asarray(waveform(phase), dtype=float).reshape(-1, *phase.shape)
    return np.ascontiguousarray(np.concatenate([phase[None], values]).transpose(1, 2, 0))
