"""The decay of a sampled oscillation, from its turning points.

A record without noise is passed through by a spline, whose turning points fall off on a line of
their logarithms.  A record with noise turns at many samples: it is smoothed first, by a spline
with a few knots in each cycle, whose errors follow from the noise that it leaves.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import BSpline, CubicSpline, PPoly, make_lsq_spline
from scipy.optimize import least_squares
from scipy.stats import chi2, linregress

from remanent._typing import FloatArray

#: Fewest swings through whose logarithms a line with an error can be laid.
_MIN_SWING_COUNT = 3
#: Degree of the smoothing spline, and its knots in each cycle.
_SMOOTHING_DEGREE = 5
_KNOTS_PER_CYCLE = 8
#: Fewest samples for each coefficient of that spline.
_MIN_SAMPLES_PER_COEFFICIENT = 3.0
#: What the spline leaves of a record, over its largest swing, that is noise and no curvature.
_LEAST_RELATIVE_NOISE = 3e-5
#: A swing counts if it is larger than this many times the error of a turning point.
_LEAST_SWING_IN_ERRORS = 5.0
#: Turning points in each cycle beyond which a record turns for noise.
_MAX_TURNS_PER_CYCLE = 3.0
#: The fit is worse than noise explains where chance would make it so in less than this share.
_LEAST_CHANCE = 0.01
#: Factor by which a spectrum is sampled more closely than the record's length resolves.
_SPECTRUM_OVERSAMPLING = 8


@dataclass(frozen=True)
class DecayFit:
    """A straight line through the logarithms of successive swings.

    Attributes
    ----------
    logarithmic_decrement, logarithmic_decrement_error : float
        Of the logarithm per cycle, and its standard error about the line.
    angular_frequency, angular_frequency_error : float
        Angular frequency, from the instants of the turning points.
    swing_count : int
        Half cycles that were used.
    """

    logarithmic_decrement: float
    logarithmic_decrement_error: float
    angular_frequency: float
    angular_frequency_error: float
    swing_count: int


def fit_exponential_decay(
    time: FloatArray, values: FloatArray, *, prominence: float
) -> DecayFit | None:
    """Fit an exponential to the swings between turning points; None for fewer than three.

    A swing, from one turning point to the next, does not depend on the level about which the
    motion turns.

    Parameters
    ----------
    time, values : array (sample,)
        Evenly spaced or not.
    prominence : float
        Swings smaller than this share of the largest one are left out, and all that follow.
    """
    if time.size < _MIN_SWING_COUNT + 1:
        return None
    spline = CubicSpline(time, values)
    turns = np.unique(spline.derivative().roots(extrapolate=False))
    smooth = _smoothed(time, values)
    if smooth is not None and smooth.is_needed(turns.size):
        return _fit_of_noisy_turns(smooth, prominence)
    heights = spline(turns)
    swings = np.abs(np.diff(heights))
    small = np.flatnonzero(swings < prominence * swings.max(initial=0.0))
    count = int(small[0]) if small.size else swings.size
    if count < _MIN_SWING_COUNT:
        return None
    number = np.arange(count)
    line = linregress(number, np.log(swings[:count]))
    clock = linregress(np.arange(count + 1), turns[: count + 1])
    frequency = np.pi / clock.slope
    return DecayFit(
        logarithmic_decrement=-2.0 * float(line.slope),
        logarithmic_decrement_error=2.0 * float(line.stderr),
        angular_frequency=float(frequency),
        angular_frequency_error=float(frequency * clock.stderr / clock.slope),
        swing_count=count,
    )


@dataclass(frozen=True)
class _SmoothRecord:
    """A spline of few knots through a record.

    Attributes
    ----------
    spline : BSpline
    noise : float
        Standard deviation of the samples about it.
    covariance : array (coefficient, coefficient)
        Of its coefficients, for noise of unit variance.
    swing : float
        Largest value less the smallest.
    cycles : float
        Of the record.
    """

    spline: BSpline
    noise: float
    covariance: FloatArray
    swing: float
    cycles: float

    def is_needed(self, turn_count: int) -> bool:
        """Whether the record has noise, by what is left or by how often it turns."""
        turns_too_often = turn_count > _MAX_TURNS_PER_CYCLE * self.cycles + 2.0
        return turns_too_often or self.noise > _LEAST_RELATIVE_NOISE * self.swing

    def turning_points(self) -> FloatArray:
        """Where it turns, between the first and the last sample."""
        first, last = self.spline.t[[_SMOOTHING_DEGREE, -_SMOOTHING_DEGREE - 1]]
        slope = self.spline.derivative()
        pieces: Any = PPoly.from_spline((slope.t, slope.c, slope.k))
        roots = pieces.roots(extrapolate=False)
        return np.asarray(np.unique(roots[(roots > first) & (roots < last)]))

    def error(self, places: FloatArray, derivative: int = 0) -> FloatArray:
        """Standard error of its value, or of a derivative, at some places."""
        basis = BSpline(self.spline.t, np.eye(len(self.covariance)), _SMOOTHING_DEGREE)
        rows = np.asarray(basis(places, nu=derivative))
        variance = np.einsum("ij,jk,ik->i", rows, self.covariance, rows)
        return np.asarray(self.noise * np.sqrt(variance))


def _smoothed(time: FloatArray, values: FloatArray) -> _SmoothRecord | None:
    """The record smoothed; None where there are too few samples in a cycle."""
    span = float(time[-1] - time[0])
    cycles = _cycle_count(time, values)
    intervals = int(np.ceil(_KNOTS_PER_CYCLE * cycles))
    count = intervals + _SMOOTHING_DEGREE
    if not np.isfinite(span) or time.size < _MIN_SAMPLES_PER_COEFFICIENT * count:
        return None
    inner = time[0] + span * np.arange(1, intervals) / intervals
    ends = [np.full(_SMOOTHING_DEGREE + 1, end) for end in (time[0], time[-1])]
    knots = np.concatenate([ends[0], inner, ends[1]])
    try:
        spline = make_lsq_spline(time, values, knots, k=_SMOOTHING_DEGREE)
    except (ValueError, np.linalg.LinAlgError):  # samples leave a gap of several knots
        return None
    design = BSpline.design_matrix(time, knots, _SMOOTHING_DEGREE).toarray()
    covariance = np.asarray(np.linalg.pinv(design.T @ design), dtype=np.float64)
    left = values - spline(time)
    noise = float(np.sqrt((left**2).sum() / (time.size - count)))
    return _SmoothRecord(spline, noise, covariance, float(np.ptp(values)), cycles)


def _cycle_count(time: FloatArray, values: FloatArray) -> float:
    """How many cycles of the strongest oscillation a record has, by its spectrum."""
    even = np.interp(np.linspace(time[0], time[-1], time.size), time, values)
    even = (even - even.mean()) * np.hanning(even.size)
    power = np.abs(np.fft.rfft(even, _SPECTRUM_OVERSAMPLING * even.size))
    # Less than one cycle is a trend.
    first = _SPECTRUM_OVERSAMPLING
    return float(first + np.argmax(power[first:])) / _SPECTRUM_OVERSAMPLING


def _fit_of_noisy_turns(record: _SmoothRecord, prominence: float) -> DecayFit | None:
    """Heights of the turning points of a smoothed record as c + (-1)^k a exp(-k delta/2).

    Their errors follow from the noise; those of the fit are larger where it is worse than that.
    """
    turns = record.turning_points()
    heights, errors = record.spline(turns), record.error(turns)
    swings = np.abs(np.diff(heights))
    least = np.maximum(
        prominence * swings.max(initial=0.0),
        _LEAST_SWING_IN_ERRORS * np.hypot(errors[1:], errors[:-1]),
    )
    small = np.flatnonzero(swings < least)
    count = int(small[0]) if small.size else swings.size
    if count < _MIN_SWING_COUNT:
        return None
    turns, heights, errors = (column[: count + 1] for column in (turns, heights, errors))
    number = np.arange(count + 1)
    sign = np.where(number % 2 == 0, 1.0, -1.0)

    def misfit(p: FloatArray) -> FloatArray:
        return np.asarray((p[0] + sign * p[1] * np.exp(-0.5 * number * p[2]) - heights) / errors)

    rate = -2.0 * float(linregress(np.arange(count), np.log(swings[:count])).slope)
    start = [heights.mean(), 0.5 * (heights[0] - heights[1]), rate]
    decay: Any = least_squares(
        misfit, start, x_scale=np.maximum(np.abs(start), 1e-3 * record.swing)
    )
    acceleration = np.abs(record.spline(turns, nu=2))
    clock_errors = record.error(turns, derivative=1) / acceleration
    rows = np.column_stack([np.ones(count + 1), number]) / clock_errors[:, None]
    clock, *_ = np.linalg.lstsq(rows, turns / clock_errors, rcond=None)
    late = rows @ clock - turns / clock_errors
    frequency = np.pi / float(clock[1])
    clock_error = float(np.sqrt(np.linalg.inv(rows.T @ rows)[1, 1])) * _inflation(late, 2)
    decay_error = float(np.sqrt(np.linalg.pinv(decay.jac.T @ decay.jac)[2, 2]))
    return DecayFit(
        logarithmic_decrement=float(decay.x[2]),
        logarithmic_decrement_error=decay_error * _inflation(decay.fun, 3),
        angular_frequency=frequency,
        angular_frequency_error=frequency * clock_error / float(clock[1]),
        swing_count=count,
    )


def _inflation(misfit: FloatArray, parameters: int) -> float:
    """Factor of standard errors where a fit is worse than its errors explain, else 1."""
    freedom = misfit.size - parameters
    square = float((misfit**2).sum())
    if freedom < 1 or chi2.sf(square, freedom) > _LEAST_CHANCE:
        return 1.0
    return float(np.sqrt(square / freedom))
