"""Sequences of steps after which a system is at rest: the linear design, then the exact one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import orth
from scipy.optimize import least_squares

from remanent._typing import ComplexArray, FloatArray

#: ``arrive(loads, durations)``: how far from rest the system is after steps of these loads
#: and durations, arrays (step,), an array (condition,), and the derivatives by the loads and
#: by the durations, arrays (condition, step).
TerminalResidual = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray, FloatArray]]

#: Directions that the input moves less than this, relative to others, are not moved.
_RANK = 1e-7
#: Durations change by less than this factor from a guess.
_STRETCHED = 3.0
#: Roots nearer to each other than this are one.
_SAME = 1e-6


@dataclass(frozen=True)
class StepSequence:
    """Steps before the last one, which holds from then on.

    Attributes
    ----------
    loads, durations : array (step,)
    residual : float
        Largest condition that is left.
    error : float
        Of the sum of the durations, for conditions known to the tolerance.
    """

    loads: FloatArray
    durations: FloatArray
    residual: float = np.inf
    error: float = np.inf


def controllable_poles(a: FloatArray, b: FloatArray) -> ComplexArray:
    """Eigenvalues of y' = a y + b u on the states that the input u can reach.

    Parameters
    ----------
    a : array (state, state)
    b : array (state,)
    """
    columns = [b / np.linalg.norm(b)]
    for _ in range(len(b) - 1):
        following = a @ columns[-1]
        columns.append(following / max(float(np.linalg.norm(following)), 1e-300))
    basis = orth(np.column_stack(columns), rcond=_RANK)
    return np.asarray(np.linalg.eigvals(basis.T @ a @ basis), dtype=np.complex128)


def impulse_spacing(found: ComplexArray) -> float:
    """Half the period of the slowest oscillation; without one, the longest time constant."""
    turning = np.abs(found.imag[np.abs(found.imag) > _SAME * np.abs(found)])
    if turning.size:
        return float(np.pi / turning.min())
    return float(1.0 / np.abs(found.real).min())


def impulse_amplitudes(found: ComplexArray, spacing: float, multiplicity: int = 1) -> FloatArray:
    """Parts of a step, `spacing` apart, after which a linear system is at rest.

    Equation: parts A_i at times i T leave a mode s alone where sum A_i z^i = 0,
    z = exp(-s T): the A_i are the coefficients of the polynomial with these roots, divided
    by their sum (Tuttle and Seering 1994).  Two imaginary poles with T half their period
    give 1/2, 1/2; with a double root 1/4, 1/2, 1/4 (Singer and Seering 1990).

    Parameters
    ----------
    multiplicity
        Of each root: so many derivatives by the pole, less one, vanish too.

    Returns
    -------
    array (part,)
        Their sum is 1.
    """
    roots = np.exp(-found * spacing)
    different = [z for i, z in enumerate(roots) if (np.abs(roots[:i] - z) > _SAME * abs(z)).all()]
    parts = np.real(np.poly(np.repeat(different, multiplicity)))[::-1]
    return np.asarray(parts / parts.sum())


def solve_step_sequence(
    arrive: TerminalResidual, guess: StepSequence, *, scale: float, tolerance: float
) -> StepSequence:
    """Loads and durations from which the system arrives at rest, near a guess.

    Nonlinear least squares in the loads, over `scale`, and, where these are fewer than the
    conditions, in the logarithms of the durations, which stay within a factor of three: there
    are commands of many periods too.  The guess itself where its motion is not known.
    `tolerance` is the error of a condition.
    """
    n = guess.loads.size

    def unpack(z: FloatArray) -> tuple[FloatArray, FloatArray]:
        times = np.exp(z[n:]) if z.size > n else guess.durations
        return z[:n] * scale, times

    @lru_cache(maxsize=1)  # conditions and derivatives are asked for one after the other
    def arrived(z: bytes) -> tuple[FloatArray, FloatArray, FloatArray]:
        return arrive(*unpack(np.frombuffer(z)))

    def jacobian(z: FloatArray) -> FloatArray:
        _, by_load, by_time = arrived(z.tobytes())
        return np.hstack([by_load * scale, by_time * unpack(z)[1]])[:, : z.size]

    def conditions(z: FloatArray) -> FloatArray:
        return arrived(z.tobytes())[0]

    known = arrive(guess.loads, guess.durations)[0]
    if not np.isfinite(known).all():
        return guess
    start = np.concatenate([guess.loads / scale, np.log(guess.durations)])
    within = np.repeat([np.inf, np.log(_STRETCHED)], n)
    if n >= known.size:
        start, within = start[:n], within[:n]
    found = least_squares(
        conditions,
        start,
        jac=jacobian,
        bounds=(start - within, start + within),
        xtol=1e-15,
        ftol=None,
        gtol=None,
        max_nfev=30,
    )
    loads, durations = unpack(found.x)
    by_condition = np.linalg.pinv(jacobian(found.x))[n:]
    error = float(np.abs(durations[: len(by_condition)] @ by_condition).sum()) * tolerance
    return StepSequence(loads, durations, float(np.abs(found.fun).max()), error)
