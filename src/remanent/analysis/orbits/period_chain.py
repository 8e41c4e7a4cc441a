"""Points followed over some periods, with what becomes of the error of each period.

The error that a period adds is carried on by the Jacobian of the periods after it.  A period adds
that of the integration, which two solutions tell, and rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.orbits.maps import Map, MapImage

#: Rounding of a period, in units of the last place of the states at its two ends.
_ROUNDING_OF_PERIOD = 4.0 * float(np.finfo(float).eps)
#: Rounding of the Jacobian of a period, the same of the largest entry of each column.
_ROUNDING_OF_JACOBIAN = 4.0 * float(np.finfo(float).eps)
#: An entry is as uncertain as this share of the most uncertain one beside it: the difference of
#: two solutions may pass through zero where the error does not.
_MIN_ERROR_OVER_LARGEST = 0.1


@dataclass(frozen=True)
class PeriodChain:
    """Points followed over some periods one by one.

    Attributes
    ----------
    start, end : array (point, state)
        Before the first period and after the last.
    jacobian : array (point, state, state)
        Of all periods together.
    later : array (point, period, state, state)
        For each period the Jacobian of all periods after it.
    state_errors, roundings : array (point, period, state)
        What each period adds to the error, with its sign, and by rounding.
    jacobian_error : array (point, state, state)
        Of `jacobian` as the derivative at the point, as a bound.
    """

    start: FloatArray
    end: FloatArray
    jacobian: FloatArray
    later: FloatArray
    state_errors: FloatArray
    roundings: FloatArray
    jacobian_error: FloatArray

    @property
    def end_error(self) -> FloatArray:
        """Of `end`, as a bound, array (point, state)."""
        carried_on = np.abs(matrices_times_vectors(self.later, self.state_errors))
        rounding = matrices_times_vectors(np.abs(self.later), self.roundings)
        error = (carried_on + rounding).sum(axis=1)
        largest = error.max(axis=1, keepdims=True)
        return np.asarray(np.maximum(error, _MIN_ERROR_OVER_LARGEST * largest))

    @classmethod
    def along(cls, map_: Map, x: FloatArray, parameters: FloatArray, iterate: int) -> PeriodChain:
        """Follow points over `iterate` periods."""
        images, roundings, state = [], [], x
        for _ in range(iterate):
            image = map_(state, parameters, 1)
            images.append(image)
            size = matrices_times_vectors(np.abs(image.jacobian), np.abs(state)) + np.abs(
                image.state
            )
            roundings.append(_ROUNDING_OF_PERIOD * size)
            state = image.state
        jacobians = [image.jacobian for image in images]
        earlier = _products(jacobians)
        later = _products([m.swapaxes(1, 2) for m in jacobians[::-1]])
        later = [m.swapaxes(1, 2) for m in later[::-1]]
        jacobian = images[-1].jacobian @ earlier[-1]
        errors = [_signed_errors(image) for image in images]
        jacobian_error = np.zeros_like(jacobian)
        for before, after, image, (_, entries) in zip(earlier, later, images, errors, strict=True):
            jacobian_error += np.abs(after @ entries @ before)
            largest = np.abs(image.jacobian).max(axis=1, keepdims=True)
            jacobian_error += _ROUNDING_OF_JACOBIAN * (
                np.abs(after) @ (0.0 * entries + largest) @ np.abs(before)
            )
        largest = jacobian_error.max(axis=1, keepdims=True)
        jacobian_error = np.maximum(jacobian_error, _MIN_ERROR_OVER_LARGEST * largest)
        state_errors = np.stack([vector for vector, _ in errors], axis=1)
        return cls(
            x, state, jacobian, np.stack(later, axis=1), state_errors,
            np.stack(roundings, axis=1), jacobian_error,
        )  # fmt: skip


def _signed_errors(image: MapImage) -> tuple[FloatArray, FloatArray]:
    """Errors of the state and of the Jacobian; bounds without a sign where no more is known."""
    state, jacobian = image.state_error, image.jacobian_error
    if state is None:
        state = np.broadcast_to(image.error[:, None], image.state.shape)
    if jacobian is None:
        largest = np.abs(image.jacobian).max(axis=(1, 2), keepdims=True)
        jacobian = np.broadcast_to(image.error[:, None, None] * largest, image.jacobian.shape)
    return state, jacobian


def _products(matrices: Sequence[FloatArray]) -> list[FloatArray]:
    """For each matrix the product of all before it, the last of them on the left."""
    products = [np.broadcast_to(np.eye(matrices[0].shape[-1]), matrices[0].shape)]
    for matrix in matrices[:-1]:
        products.append(matrix @ products[-1])
    return products


def matrices_times_vectors(matrices: FloatArray, vectors: FloatArray) -> FloatArray:
    """Of each point, array (point, ..., state)."""
    return np.asarray((matrices @ vectors[..., None])[..., 0])
