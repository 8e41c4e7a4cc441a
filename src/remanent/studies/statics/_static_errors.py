"""Errors of equilibria and thresholds: what rounding in the forces makes of their places."""

from __future__ import annotations

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.analysis.statics.equilibria import force_slope
from remanent.analysis.statics.rounding import Rounded, RoundedDual
from remanent.studies.statics._static_ensemble import StaticEnsemble

#: Half the relative change of a stretch over which a second derivative is a difference.
_RELATIVE_HALF_STEP = 1e-5


def largest(number: Rounded) -> FloatArray:
    """Largest size that the exact number may have."""
    return np.asarray(np.abs(number.value) + number.bound)


def least(number: Rounded) -> FloatArray:
    """Least size that the exact number may have."""
    return np.asarray(np.maximum(np.abs(number.value) - number.bound, 0.0))


def stretch_error(
    static: StaticEnsemble, case: IntArray, stretch: FloatArray, force: RoundedDual | None = None
) -> FloatArray:
    """Error of zeros of the force: the force that may be left, over its slope.

    Parameters
    ----------
    static : StaticEnsemble
    case, stretch : array (point,)
    force : RoundedDual, optional
        There, where it is known.
    """
    force = force or static.first_acceleration_with_rounding(case, stretch)
    with np.errstate(all="ignore"):
        return np.asarray(largest(force.value) / least(force.slope))


def thickness_error(
    static: StaticEnsemble, case: IntArray, stretch: FloatArray, error: FloatArray
) -> FloatArray:
    """Error of the thickness stretch where the stretch has an `error`."""
    thickness = static.thickness_with_rounding(case, stretch)
    with np.errstate(all="ignore"):
        return np.asarray(thickness.value.bound + largest(thickness.slope) * error)


def squared_frequency_error(
    static: StaticEnsemble,
    case: IntArray,
    stretch: FloatArray,
    error: FloatArray,
    force: RoundedDual,
) -> FloatArray:
    """Error of the slope of the `force` where the stretch has an `error`."""
    step = _RELATIVE_HALF_STEP * stretch
    ends = np.stack([stretch - step, stretch + step])
    low, high = force_slope(static.first_acceleration, np.stack([case, case]), ends)
    with np.errstate(all="ignore"):
        return np.asarray(force.slope.bound + np.abs(high - low) / (2.0 * step) * error)


def balancing_parameter_error(
    static: StaticEnsemble, name: str, case: IntArray, stretch: FloatArray, value: FloatArray
) -> FloatArray:
    """Error of the parameter that balances the force at an exact stretch."""
    force = static.first_acceleration_with_rounding(
        case, stretch, along=name, changed={name: value}
    )
    with np.errstate(all="ignore"):
        return np.asarray(largest(force.value) / least(force.slope))


def square_root_error(root: FloatArray, squared_error: FloatArray) -> FloatArray:
    """Error of a square root: half that of the square over the root, at most its own root."""
    with np.errstate(all="ignore"):
        error = np.minimum(squared_error / root, np.sqrt(squared_error))
    return np.asarray(error + np.finfo(float).eps * root)
