"""Samples of a function at points, and cells with a sample at each centre."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray

#: Limits of that error.
ERROR_LIMITS = (1e-10, 1e-3)
#: Larger errors than this share of the largest component, or larger than this, tell nothing.
MAX_ERROR_SHARE = 0.1
#: Largest change of D over a cell, relative to D, up to which Newton's method is trusted.
MAX_DERIVATIVE_CHANGE = 0.5


@dataclass(frozen=True)
class Sample:
    """A function at some points.

    Attributes
    ----------
    value : array (point, component)
        The first components, as many as the point has coordinates, are those whose zeros are
        sought.  Others are known to vanish where these do.
    derivative : array (point, component, coordinate)
    error : array (point,)
        Of the value, and of the derivative relative to its largest entry.
    effort : array (point,) of int
        That was needed; it is passed on to points near by.
    """

    value: FloatArray
    derivative: FloatArray
    error: FloatArray
    effort: IntArray

    @classmethod
    def unknown(cls, points: int, components: int, coordinates: int) -> Sample:
        """A sample of nothing, to be updated."""
        return cls(
            np.full((points, components), np.nan),
            np.full((points, components, coordinates), np.nan),
            np.full(points, np.inf),
            np.zeros(points, dtype=np.int64),
        )

    @property
    def total_effort(self) -> float:
        """Of all points, each at least 1."""
        return float(np.maximum(self.effort, 1).sum())

    def update(self, indices: IntArray, part: Sample) -> None:
        """Put the function at some of the points in place."""
        self.value[indices], self.derivative[indices] = part.value, part.derivative
        self.error[indices], self.effort[indices] = part.error, part.effort

    def followed_by(self, other: Sample) -> Sample:
        """The function at these points and at others."""
        return Sample(
            np.concatenate([self.value, other.value]),
            np.concatenate([self.derivative, other.derivative]),
            np.concatenate([self.error, other.error]),
            np.concatenate([self.effort, other.effort]),
        )

    def subset(self, indices: IntArray | BoolArray) -> Sample:
        """The function at some of the points."""
        return Sample(
            self.value[indices], self.derivative[indices], self.error[indices],
            self.effort[indices],
        )  # fmt: skip


class SampledFunction(Protocol):
    """A function with its derivative, at many points."""

    def __call__(self, points: FloatArray, tolerance: float, effort: IntArray | None, /) -> Sample:
        """Compute it to an error of `tolerance`, beginning with an effort for each point."""


@dataclass(frozen=True)
class Cells:
    """Boxes with the function at their centres.

    Attributes
    ----------
    centre, half_width : array (cell, coordinate)
    sample : Sample
    curvature : array (cell, component, coordinate, coordinate)
        Sizes of second derivatives.
    divisions : array (cell,) of int
        How many times a first cell was divided.
    """

    centre: FloatArray
    half_width: FloatArray
    sample: Sample
    curvature: FloatArray
    divisions: IntArray

    def subset(self, indices: IntArray | BoolArray) -> Cells:
        """Some of the cells."""
        return Cells(
            self.centre[indices], self.half_width[indices], self.sample.subset(indices),
            self.curvature[indices], self.divisions[indices],
        )  # fmt: skip


def is_known(sample: Sample) -> BoolArray:
    """Whether the function was computed to a few digits at least, array (point,)."""
    with np.errstate(all="ignore"):
        size = np.abs(sample.value[:, : sample.derivative.shape[2]]).max(axis=1)
        limit = np.maximum(MAX_ERROR_SHARE * np.minimum(size, 1.0), ERROR_LIMITS[1])
        known = np.isfinite(sample.value).all(axis=1) & (sample.error <= limit)
    return np.asarray(known & np.isfinite(sample.derivative).all(axis=(1, 2)))
