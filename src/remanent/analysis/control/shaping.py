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
TerminalResidualAndJacobianFunction = Callable[
    [FloatArray, FloatArray], tuple[FloatArray, FloatArray, FloatArray]
]

#: Directions that the input moves less than this, relative to others, are not controllable.
_CONTROLLABILITY_RANK_TOLERANCE = 1e-7
#: Factor between the durations of a solution and those of the guess, at most.
_MAX_DURATION_CHANGE_FACTOR = 3.0
#: Roots that differ by less than this, relative to their size, are one.
_MIN_RELATIVE_ROOT_DISTANCE = 1e-6
#: Poles with a smaller imaginary part, relative to their size, do not oscillate.
_MIN_OSCILLATORY_IMAGINARY_SHARE = 1e-6
#: Relative change of the unknowns at which least squares stop.
_LEAST_SQUARES_XTOL = 1e-15
#: Evaluations of least squares, at most.
_MAX_LEAST_SQUARES_EVALUATIONS = 30


@dataclass(frozen=True)
class StepSequence:
    """Steps before the last one, which holds from then on.

    Attributes
    ----------
    loads, durations : array (step,)
    largest_terminal_residual : float
        Largest condition that is left.
    total_duration_error : float
        Of the sum of the durations, for conditions known to the tolerance.
    residual, residual_error : float
        Distance of the state from rest at the end, and its error; NaN until it is worked out.
    """

    loads: FloatArray
    durations: FloatArray
    largest_terminal_residual: float = np.inf
    total_duration_error: float = np.inf
    residual: float = np.nan
    residual_error: float = np.nan


def controllable_poles(a: FloatArray, b: FloatArray) -> ComplexArray:
    """Eigenvalues of y' = a y + b u on the states that the input u can reach.

    Modes that the input does not move have no part in the motion; their poles are left out.

    Parameters
    ----------
    a : array (state, state)
    b : array (state,)

    Returns
    -------
    array (pole,) of complex
        None where the input moves nothing, or by numbers that floats do not hold.
    """
    # Kalman's controllability matrix b, a b, a^2 b ...: its columns span these states.
    columns = []
    with np.errstate(all="ignore"):
        column = b
        for _ in range(len(b)):
            size = float(np.linalg.norm(column))
            if not 0.0 < size < np.inf:
                break
            columns.append(column / size)
            column = a @ columns[-1]
    if not columns or not np.isfinite(a).all():
        return np.empty(0, dtype=np.complex128)
    basis = orth(np.column_stack(columns), rcond=_CONTROLLABILITY_RANK_TOLERANCE)
    return np.asarray(np.linalg.eigvals(basis.T @ a @ basis), dtype=np.complex128)


def default_impulse_spacing(poles: ComplexArray) -> float:
    """Half the period of the slowest oscillation; without one, the longest time constant.

    Parameters
    ----------
    poles : array (pole,) of complex
        Of a linear system.

    Returns
    -------
    float
        NaN without poles, infinity where nothing comes to rest.
    """
    if not poles.size:
        return np.nan
    size = np.abs(poles)
    frequencies = np.abs(poles.imag[np.abs(poles.imag) > _MIN_OSCILLATORY_IMAGINARY_SHARE * size])
    if frequencies.size:
        return float(np.pi / frequencies.min())
    with np.errstate(all="ignore"):
        return float(1.0 / np.abs(poles.real).min())


def zero_vibration_impulse_amplitudes(
    poles: ComplexArray, spacing: float, multiplicity: int = 1
) -> FloatArray:
    """Parts of a step, `spacing` apart, after which a linear system is at rest.

    Equation: parts A_i at times i T leave a mode s alone where sum A_i z^i = 0,
    z = exp(-s T): the A_i are the coefficients of the polynomial with these roots, divided
    by their sum (Tuttle and Seering 1994).  Two imaginary poles with T half their period
    give 1/2, 1/2; with a double root 1/4, 1/2, 1/4 (Singer and Seering 1990).

    Parameters
    ----------
    poles : array (pole,) of complex
        Of the linear system.
    spacing : float
        The time T between two parts.
    multiplicity : int
        Of each root.  With multiplicity r the first r - 1 derivatives of the residual motion by
        the pole vanish too, so that it is insensitive to an error of the pole.

    Returns
    -------
    array (part,)
        Their sum is 1.
    """
    roots = np.exp(-poles * spacing)
    # Poles of equal oscillators give equal roots, of which the polynomial needs one.
    distinct = [
        z
        for i, z in enumerate(roots)
        if (np.abs(roots[:i] - z) > _MIN_RELATIVE_ROOT_DISTANCE * abs(z)).all()
    ]
    parts = np.real(np.poly(np.repeat(distinct, multiplicity)))[::-1]
    return np.asarray(parts / parts.sum())


def solve_step_sequence(
    arrive: TerminalResidualAndJacobianFunction,
    guess: StepSequence,
    *,
    scale: float,
    tolerance: float,
) -> StepSequence:
    """Loads and durations from which the system arrives at rest, near a guess.

    Nonlinear least squares in the loads and, where these are fewer than the conditions, in the
    logarithms of the durations.  The durations stay within a factor of three of the guess,
    since there are commands of many periods too.

    Parameters
    ----------
    arrive : callable
        The conditions at the end, and their derivatives.
    guess : StepSequence
    scale : float
        Unit of the loads.
    tolerance : float
        Error of a condition.

    Returns
    -------
    StepSequence
        The guess itself where its motion is not known.
    """
    n = guess.loads.size

    def unpack(z: FloatArray) -> tuple[FloatArray, FloatArray]:
        times = np.exp(z[n:]) if z.size > n else guess.durations
        return z[:n] * scale, times

    @lru_cache(maxsize=1)  # conditions and derivatives are asked for one after the other
    def arrival(z: bytes) -> tuple[FloatArray, FloatArray, FloatArray]:
        return arrive(*unpack(np.frombuffer(z)))

    def jacobian(z: FloatArray) -> FloatArray:
        _, by_load, by_duration = arrival(z.tobytes())
        return np.hstack([by_load * scale, by_duration * unpack(z)[1]])[:, : z.size]

    def conditions(z: FloatArray) -> FloatArray:
        return arrival(z.tobytes())[0]

    at_guess = arrive(guess.loads, guess.durations)[0]
    if not np.isfinite(at_guess).all():
        return guess
    start = np.concatenate([guess.loads / scale, np.log(guess.durations)])
    reach = np.repeat([np.inf, np.log(_MAX_DURATION_CHANGE_FACTOR)], n)
    if n >= at_guess.size:  # the loads alone can meet all conditions
        start, reach = start[:n], reach[:n]
    solution = least_squares(
        conditions,
        start,
        jac=jacobian,
        bounds=(start - reach, start + reach),
        xtol=_LEAST_SQUARES_XTOL,
        ftol=None,
        gtol=None,
        max_nfev=_MAX_LEAST_SQUARES_EVALUATIONS,
    )
    loads, durations = unpack(solution.x)
    # The pseudoinverse says how each unknown moves with each condition; the rows of durations
    # come after those of the loads.
    by_condition = np.linalg.pinv(jacobian(solution.x))[n:]
    error = float(np.abs(durations[: len(by_condition)] @ by_condition).sum()) * tolerance
    return StepSequence(loads, durations, float(np.abs(solution.fun).max()), error)
