"""States between steps: a shorter step from the end of the last whole one.

Its local error is that of a whole step or less, whatever the motion does in between, so
that the error bound at the ends of steps holds between them too.  (A polynomial through
several ends of steps needs no further rates, but its error in a fast stretch of the
motion can exceed that of the steps by orders of magnitude.)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from remanent._field import Field
from remanent._typing import FloatArray
from remanent.integrate.kernel.compile import compiled_partial_steps
from remanent.integrate.methods.runge_kutta import RungeKuttaMethod


def partial_step(
    field: Field,
    method: RungeKuttaMethod,
    waveform: Callable[[FloatArray], FloatArray],
    *,
    states: FloatArray,
    parameters: Sequence[FloatArray],
    phase: FloatArray,
    span: FloatArray,
    time: FloatArray,
) -> FloatArray:
    """The states within a step, by one shorter step for each.

    Parameters
    ----------
    field : Field
        What moves.
    method : RungeKuttaMethod
        How it is integrated.
    waveform : callable
        ``waveform(phase)``: the field's waveforms, array (waveform, *phase.shape).
    states : array (sample, state)
        To start from.
    parameters : sequence of array (sample,)
        In the order of ``field.parameter_names``.
    phase, span : array (sample,)
        Phase of the drive at the start, and its change.
    time : array (sample,)
        Length of the step, tau; where it is 0 the state stays exactly as it is.

    Returns
    -------
    array (sample, state)
    """
    phases = (phase + float(node) * span for node in method.nodes)
    loads = [np.concatenate([s[None], waveform(s)]) for s in phases]
    moved = compiled_partial_steps(field, method)(time, loads, states, parameters)
    return np.where((time == 0.0)[:, None], states, moved)
