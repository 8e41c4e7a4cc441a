"""The decay of a sampled oscillation, from its turning points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.stats import linregress

from remanent._typing import FloatArray

#: Fewest swings through whose logarithms a line with an error can be laid.
_MIN_SWING_COUNT = 3


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
    motion turns.  Turning points are those of a cubic spline.

    Parameters
    ----------
    time, values : array (sample,)
        Evenly spaced or not.
    prominence : float
        Swings smaller than this share of the largest one are left out, and all that follow.
    """
    spline = CubicSpline(time, values)
    turns = np.unique(np.concatenate([spline.derivative().roots(extrapolate=False)]))
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
