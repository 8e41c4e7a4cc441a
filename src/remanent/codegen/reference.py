"""A Field evaluated with NumPy, one trajectory a row: slow and obviously right.

It is the reference for compiled kernels in tests, and what :func:`remanent.rates` gives.
"""

from __future__ import annotations

import numpy as np

from remanent._field import Field, Program
from remanent._typing import ArrayLike, FloatArray


def evaluate_rates(
    field: Field, phase: ArrayLike, y: FloatArray, p: FloatArray, u: ArrayLike
) -> FloatArray:
    """Rates of the state variables.

    Parameters
    ----------
    field
        The vector field.
    phase : float or array (trajectory,)
        Phase of the drive, or fraction of the current piece, in [0, 1).
    y : array (trajectory, state)
        States.
    p : array (trajectory, parameter)
        Parameters, in the order of ``field.parameter_names``.
    u : array (waveform,) or (waveform, trajectory)
        Waveforms of the drive at that phase.

    Returns
    -------
    array (trajectory, state)
    """
    return _evaluate_program(field, field.rates, phase, y, p, u)


def evaluate_observable_and_rates(
    field: Field, phase: ArrayLike, y: FloatArray, p: FloatArray, u: ArrayLike
) -> FloatArray:
    """The watched observable, two rates, and the sign of the first: array (trajectory, 4)."""
    return _evaluate_program(field, field.observable_and_rates, phase, y, p, u)


def evaluate_observables(
    field: Field, phase: ArrayLike, y: FloatArray, p: FloatArray, u: ArrayLike
) -> dict[str, FloatArray]:
    """Every observable by name, arrays (trajectory,).

    Parameters
    ----------
    field, phase, y, p, u
        The vector field, and phase, states, parameters and waveforms, as :func:`evaluate_rates`
        takes them.
    """
    return {
        name: _evaluate_program(field, program, phase, y, p, u)[:, 0]
        for name, program in field.observables.items()
    }


def _evaluate_program(
    field: Field, program: Program, phase: ArrayLike, y: FloatArray, p: FloatArray, u: ArrayLike
) -> FloatArray:
    if y.shape[1:] != (len(field.state_names),) or p.shape != (len(y), len(field.parameter_names)):
        raise ValueError(f"shapes {y.shape} and {p.shape} do not fit {field.input_names}")
    values = [np.asarray(phase), *y.T, *p.T, *np.asarray(u)]
    columns = program(values, functions=np)
    return np.stack([np.broadcast_to(column, len(y)) for column in columns], axis=1)
