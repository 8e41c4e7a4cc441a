"""Curves of solutions of n equations in n + 1 unknowns: their points, and what is between."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class EquationValues:
    """Equations at some points.

    Attributes
    ----------
    value : array (point, equation)
    derivative : array (point, equation, unknown)
    value_error : array (point,)
        Estimated error of the value.
    extra_arrays : mapping of name to array (point, ...)
        Whatever else is to be kept with each point.
    """

    value: FloatArray
    derivative: FloatArray
    value_error: FloatArray
    extra_arrays: Mapping[str, FloatArray]

    def with_replaced_rows(self, indices: IntArray, rows: EquationValues) -> EquationValues:
        """The equations with their values at some points replaced."""

        def put(values: FloatArray, new: FloatArray) -> FloatArray:
            changed = values.copy()
            changed[indices] = new
            return changed

        return EquationValues(
            put(self.value, rows.value),
            put(self.derivative, rows.derivative),
            put(self.value_error, rows.value_error),
            {
                name: put(values, rows.extra_arrays[name])
                for name, values in self.extra_arrays.items()
            },
        )


#: ``equations(unknowns)`` with unknowns (point, n + 1).
CurveEquations = Callable[[FloatArray], EquationValues]


@dataclass(frozen=True)
class CurvePoints:
    """Points of a curve, or of several.

    Attributes
    ----------
    unknown : array (point, n + 1)
    tangent : array (point, n + 1)
        Of unit length in scaled unknowns.
    residual, residual_error : array (point,)
        Largest defect of the equations, and its estimated error.
    extra_arrays : mapping of name to array (point, ...)
        What the equations keep with each point.
    """

    unknown: FloatArray
    tangent: FloatArray
    residual: FloatArray
    residual_error: FloatArray
    extra_arrays: Mapping[str, FloatArray]

    def __len__(self) -> int:
        return int(self.unknown.shape[0])

    def subset(self, indices: slice | IntArray | BoolArray) -> CurvePoints:
        """Some of the points, in the order of the indices."""
        return CurvePoints(
            self.unknown[indices],
            self.tangent[indices],
            self.residual[indices],
            self.residual_error[indices],
            {name: values[indices] for name, values in self.extra_arrays.items()},
        )

    def with_reversed_tangents(self) -> CurvePoints:
        """The same points, to be passed in the other direction."""
        return replace(self, tangent=-self.tangent)


@dataclass(frozen=True)
class Curve:
    """A curve, and why it ends.

    Attributes
    ----------
    points : CurvePoints
        In order along the curve; the first is repeated as the last where it is closed.
    is_closed : bool
    end_reasons : two str
        Why the curve ends before its first and after its last point: ``closed``; ``bounds``,
        it leaves the box; ``points``, as many as were asked for; ``lost``, the step became
        too short; ``branching``, it ends on another curve; ``start``, it was followed from
        there in one direction only.
    bounded_unknowns : two int
        Number of the unknown that reached its bound at each end; -1 where none did.
    """

    points: CurvePoints
    is_closed: bool
    end_reasons: tuple[str, str]
    bounded_unknowns: tuple[int, int] = (-1, -1)

    def reversed(self) -> Curve:
        """The same curve in the other order; its tangents still point the way they did."""
        return replace(
            self,
            points=self.points.subset(slice(None, None, -1)),
            end_reasons=(self.end_reasons[1], self.end_reasons[0]),
            bounded_unknowns=(self.bounded_unknowns[1], self.bounded_unknowns[0]),
        )


def concatenate_points(parts: Sequence[CurvePoints]) -> CurvePoints:
    """The points of several parts of a curve, one part after the other."""
    return CurvePoints(
        np.concatenate([part.unknown for part in parts]),
        np.concatenate([part.tangent for part in parts]),
        np.concatenate([part.residual for part in parts]),
        np.concatenate([part.residual_error for part in parts]),
        {
            name: np.concatenate([part.extra_arrays[name] for part in parts])
            for name in parts[0].extra_arrays
        },
    )


def interpolate_curve(
    points: CurvePoints, segment: IntArray, fraction: FloatArray, scale: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Places on the cubics through two neighbouring points with their tangents.

    Parameters
    ----------
    points : CurvePoints
    segment : array (place,) of int
        Number of the point before each place.
    fraction : array (place,)
        Of the way to the next point, from 0 to 1.
    scale : array (n + 1,)
        Units of the unknowns.

    Returns
    -------
    unknown : array (place, n + 1)
    direction : array (place, n + 1)
        Of unit length in scaled unknowns, interpolated linearly.
    """
    a, b = points.unknown[segment] / scale, points.unknown[segment + 1] / scale
    ta, tb = points.tangent[segment], points.tangent[segment + 1]
    gap = np.linalg.norm(b - a, axis=1)[:, None]
    s = fraction[:, None]
    # Hermite's cubic; arclength is replaced by the distance of the points.
    h01 = s * s * (3.0 - 2.0 * s)
    unknown = a + h01 * (b - a) + gap * s * (1.0 - s) * ((1.0 - s) * ta - s * tb)
    direction = (1.0 - s) * ta + s * tb
    return unknown * scale, direction / np.linalg.norm(direction, axis=1)[:, None]
