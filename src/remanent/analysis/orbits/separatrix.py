"""On which side of a saddle motions pass: which side of its stable manifold they start on.

Near a saddle of a map motion comes in along the stable direction and leaves along the
unstable one.  The side on which it leaves is that of the stable manifold it was on.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray

#: Motion has left the saddle when its coordinate along the unstable direction exceeds the rest
#: of its displacement by this factor.
_MIN_DEPARTURE_RATIO = 2.0
#: Least distance from the saddle relative to that at the start, for motion that comes near it.
_MAX_APPROACH_DISTANCE_RATIO = 0.6
#: The sign of a coordinate counts if it exceeds its error by this factor.
_MIN_UNSTABLE_COORDINATE_OVER_ERROR = 10.0


@dataclass(frozen=True)
class SaddlePassage:
    """How motions pass a saddle for the first time.

    Attributes
    ----------
    side_relative_to_start : array (trajectory,)
        1 where motion leaves on the side of the saddle from which it started, −1 where on
        the other, 0 where it does not come near, does not leave within the run, or where an
        error could change the sign.
    departure_iterate : array (trajectory,)
        At which it has left.
    least_distance_before_departure : array (trajectory,)
        Least distance from the saddle until then.
    """

    side_relative_to_start: IntArray
    departure_iterate: IntArray
    least_distance_before_departure: FloatArray


def unstable_directions(jacobian: FloatArray) -> tuple[FloatArray, FloatArray, BoolArray]:
    """The unstable direction of saddles, and the linear form that measures along it.

    Parameters
    ----------
    jacobian : array (trajectory, state, state)
        Of the map at its fixed points.

    Returns
    -------
    direction, form : array (trajectory, state)
    saddle : array (trajectory,) of bool
        Exactly one multiplier is outside the unit circle, and real.
    """
    values, right = np.linalg.eig(jacobian)
    row = np.arange(len(values))
    k = np.abs(values).argmax(axis=1)
    largest = values[row, k]
    saddle = (np.abs(largest.imag) == 0.0) & ((np.abs(values) > 1.0).sum(axis=1) == 1)
    left = np.linalg.pinv(right)
    return right[row, :, k].real, left[row, k].real, np.asarray(saddle)


def find_first_saddle_passages(
    visited: FloatArray, saddle: FloatArray, jacobian: FloatArray, error: FloatArray
) -> SaddlePassage:
    """See on which side of a saddle motions pass it.

    Near the saddle motion is the sum of a part along the unstable direction, which grows, and a
    rest, which shrinks.  Once the first exceeds the second its sign is settled.

    Parameters
    ----------
    visited : array (trajectory, iterate, state)
        From the start on; NaN where unknown.
    saddle : array (trajectory, state)
        The saddle of each trajectory's map.
    jacobian : array (trajectory, state, state)
        Of that map there.
    error : array (trajectory,)
        Of the states visited and of the saddle.
    """
    direction, form, _ = unstable_directions(jacobian)
    displacement = visited - saddle[:, None]
    unstable_coordinate = np.einsum("ij,itj->it", form, displacement)
    remainder = np.linalg.norm(
        displacement - unstable_coordinate[..., None] * direction[:, None], axis=2
    )
    unstable_coordinate *= np.where(
        unstable_coordinate[:, :1] < 0.0, -1.0, 1.0
    )  # positive on the side of the start
    distance = np.linalg.norm(displacement, axis=2)
    with np.errstate(invalid="ignore"):
        departed = _has_approached(distance) & (
            np.abs(unstable_coordinate) > _MIN_DEPARTURE_RATIO * remainder
        )
    first = departed.argmax(axis=1)
    row = np.arange(len(visited))
    sure = departed[row, first] & (
        np.abs(unstable_coordinate[row, first]) > _MIN_UNSTABLE_COORDINATE_OVER_ERROR * error
    )
    side = np.where(sure, np.sign(unstable_coordinate[row, first]), 0.0).astype(np.int64)
    return SaddlePassage(side, first, np.fmin.accumulate(distance, axis=1)[row, first])


def _has_approached(distance: FloatArray) -> BoolArray:
    """From the first near local minimum of the distance on, array (trajectory, iterate)."""
    least = np.zeros(distance.shape, dtype=np.bool_)
    inner = distance[:, 1:-1]
    least[:, 1:-1] = (inner < distance[:, :-2]) & (inner <= distance[:, 2:])
    least &= distance < _MAX_APPROACH_DISTANCE_RATIO * distance[:, :1]
    return np.logical_or.accumulate(least, axis=1)
