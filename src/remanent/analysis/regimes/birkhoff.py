"""Weighted Birkhoff averages: how fast time averages settle tells order from chaos.

References
----------
S. Das, Y. Saiki, E. Sander and J. A. Yorke, Nonlinearity 30 (2017) 4111.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import FloatArray

#: Digits of two numbers that are equal.
MAX_CONVERGENCE_DIGITS = 16.0
#: An orbit encircles a centre if no gap between the directions to its points is wider, turns.
_MAX_ANGLE_GAP_IN_TURNS = 0.5
#: Windows of two thirds whose averages tell the error of a rotation number.
_WINDOWS_FOR_ERROR = 9
#: That error over the largest difference of these averages from that of all.  Measured.
_ERROR_OVER_WINDOW_DIFFERENCE = 3.0


def weighted_birkhoff_average(values: FloatArray) -> FloatArray:
    """Average along the last axis with the smooth weight exp(-1/(s(1 - s))).

    Along a quasi-periodic orbit its error falls faster than any power of the number of
    values; along a chaotic one as its inverse square root.  The reason is that the weight and
    all its derivatives vanish at both ends: an average with equal weights has an error of 1/n
    from the two ends alone, where the orbit is cut off in the middle of a turn.

    Parameters
    ----------
    values : array (..., sample)

    Returns
    -------
    array (...)
    """
    s = np.arange(1, values.shape[-1] + 1) / (values.shape[-1] + 1)
    weight = np.exp(-1.0 / (s * (1.0 - s)))
    # Contiguous, so that the order of summation does not depend on how many orbits there are.
    values = np.ascontiguousarray(values)
    return np.asarray(np.sum(values * (weight / weight.sum()), axis=-1))


def birkhoff_convergence_digits(values: FloatArray) -> FloatArray:
    """Decimal digits on which the averages of the first and the last two thirds agree.

    Windows of two thirds overlap, but their weights lie apart; and slow angles turn more often
    within them than within halves.

    Parameters
    ----------
    values : array (..., sample)
        Of one observable along an orbit, at equal intervals.

    Returns
    -------
    array (...)
        -log10 of the difference of the averages, relative to the standard deviation of the
        values; at most 16; NaN where a value is.
    """
    first, last = _first_and_last_averages(values)
    spread = np.std(np.ascontiguousarray(values), axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        digits = -np.log10(np.abs(first - last) / spread)
    return np.asarray(
        np.where(spread == 0.0, MAX_CONVERGENCE_DIGITS, np.minimum(digits, MAX_CONVERGENCE_DIGITS))
    )


def _first_and_last_averages(values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Weighted averages over the first and the last two thirds."""
    window = -(-2 * values.shape[-1] // 3)
    return weighted_birkhoff_average(values[..., :window]), weighted_birkhoff_average(
        values[..., -window:]
    )


@dataclass(frozen=True)
class RotationNumbers:
    """How fast orbits turn about a centre.

    Attributes
    ----------
    turns_per_iterate : array (orbit,)
        Turns per iterate, clockwise, in [0, 1); NaN where the orbit does not encircle
        its centre.
    error : array (orbit,)
        Of the number: what the orbit is too short for.
    converged_digits : array (orbit,)
        Decimal digits on which the first and the last two thirds of the orbit agree.
    """

    turns_per_iterate: FloatArray
    error: FloatArray
    converged_digits: FloatArray


def rotation_numbers(points: FloatArray, centre: FloatArray | None = None) -> RotationNumbers:
    """Rotation numbers by weighted averages of the angle from each iterate to the next.

    The angle from a point to its image is known up to whole turns.  On a curve about the
    centre it is a continuous function of the point, so the cut between representatives is
    laid where no angle falls: in the widest gap between the angles found.  The average,
    modulo 1, then does not depend on where.  Clockwise is the sense in which a point
    (x, x') turns.

    An orbit that swings to and fro beside the centre turns by whole turns only.  So does,
    within its error, one that is too short to show its turning: neither has a number.

    The first and the last two thirds may agree by chance, where a slow angle turns by a whole
    turn from one to the other.  Several windows between them do not, and their differences from
    the average over all tell its error.

    Parameters
    ----------
    points : array (orbit, iterate, 2)
        Two coordinates along each orbit.
    centre : array (orbit, 2), optional
        By default the weighted average of the points.

    Returns
    -------
    Rotation
    """
    if centre is None:
        centre = weighted_birkhoff_average(np.moveaxis(points, 1, -1))
    displacement = points - centre[:, None]
    size = np.std(np.ascontiguousarray(np.moveaxis(displacement, 1, -1)), axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        # Scaled, so that flat curves are as good as round ones.
        angle = -np.arctan2(
            displacement[..., 1] / size[:, None, 1], displacement[..., 0] / size[:, None, 0]
        )
    turn = angle / (2.0 * np.pi)
    step = np.diff(turn, axis=1) % 1.0
    # A fixed cut, at 0 say, could fall among the angles and split equal ones by a whole turn.
    cut, _ = _widest_gap_on_circle(step)
    step = (step - cut[:, None]) % 1.0 + cut[:, None]
    first, last = _first_and_last_averages(step)
    with np.errstate(divide="ignore"):
        digits = np.minimum(-np.log10(np.abs(first - last)), MAX_CONVERGENCE_DIGITS)
    average = weighted_birkhoff_average(step)
    error = _ERROR_OVER_WINDOW_DIFFERENCE * _largest_window_difference(step, average)
    number = average % 1.0
    with np.errstate(invalid="ignore"):
        turns_round = np.minimum(number, 1.0 - number) > error
        encircles = _widest_gap_on_circle(turn % 1.0)[1] <= _MAX_ANGLE_GAP_IN_TURNS
    encircles = encircles & np.isfinite(first + last)
    return RotationNumbers(
        np.where(encircles & turns_round, number, np.nan),
        np.where(encircles & turns_round, error, np.nan),
        np.where(encircles, digits, 0.0),
    )


def _largest_window_difference(values: FloatArray, average: FloatArray) -> FloatArray:
    """Largest distance of averages over windows of two thirds from that over all values."""
    samples = values.shape[-1]
    length = -(-2 * samples // 3)
    starts = np.linspace(0, samples - length, _WINDOWS_FOR_ERROR).round().astype(int)
    averages = [weighted_birkhoff_average(values[..., k : k + length]) for k in starts]
    return np.asarray(np.abs(np.array(averages) - average).max(axis=0))


def _widest_gap_on_circle(turns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Middle and width of the widest interval of the circle [0, 1) without a value."""
    ordered = np.sort(turns, axis=1)
    gaps = np.diff(ordered, axis=1, append=ordered[:, :1] + 1.0)
    widest = np.argmax(np.where(np.isnan(gaps), -1.0, gaps), axis=1)[:, None]
    width = np.take_along_axis(gaps, widest, 1)[:, 0]
    return np.take_along_axis(ordered, widest, 1)[:, 0] + 0.5 * width, width
