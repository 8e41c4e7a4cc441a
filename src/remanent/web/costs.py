"""About how long work takes, known before it begins."""

from __future__ import annotations

import math
from typing import Final

from remanent.models.drives.base import Drive

#: Steps of integration in each unit of time and in each period of the load, about.
_STEPS_PER_TIME, _STEPS_PER_PERIOD = 25.0, 64.0
#: Steps that a kernel takes in a second, on a slow machine.
_STEPS_PER_SECOND: Final = 1e7
#: Period that is taken where the load has none of its own.
_USUAL_PERIOD: Final = 2.0 * math.pi
#: Shares of a range at which the period is looked at.
_SHARES: Final = (0.0, 0.25, 0.5, 0.75, 1.0)


def run_seconds(
    drive: Drive,
    count: float,
    duration: float | None,
    omega_range: tuple[float, float] | None = None,
) -> float:
    """About how many seconds some runs take.

    Parameters
    ----------
    drive : Drive
    count : float
        Runs.
    duration : float or None
        Of each in units of time; None for one period of the load.
    omega_range : (float, float), optional
        Frequencies over which they are spread, in place of that of the load.

    Returns
    -------
    float
        Infinity where a period is no positive number.
    """
    periods = _periods(drive, omega_range)
    if not all(0.0 < period < math.inf for period in periods):
        return math.inf
    steps = sum(
        (period if duration is None else duration) * (_STEPS_PER_TIME + _STEPS_PER_PERIOD / period)
        for period in periods
    )
    return count * steps / len(periods) / _STEPS_PER_SECOND


def _periods(drive: Drive, omega_range: tuple[float, float] | None) -> list[float]:
    """Periods of a load over a range of frequencies, those at its ends among them."""
    own = drive.period
    if omega_range is None or "omega" not in drive.parameter_values():
        return [own if own is not None else _USUAL_PERIOD]
    low, high = omega_range
    frequencies = [low + share * (high - low) for share in _SHARES]
    return [2.0 * math.pi / omega if omega > 0.0 else math.inf for omega in frequencies]
