"""Where curves end: cut exactly at their bounds; and whether a point is on a curve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.orbits.continuation import ContinuationSettings
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.curves import (
    Curve,
    CurveEquations,
    CurvePoints,
    concatenate_points,
    interpolate_curve,
)

#: A point nearer to a curve than this, in scaled unknowns, is on it.
_MAX_DISTANCE_ON_CURVE = 3e-4
#: Chords of a curve, nearest to a point, on whose arcs it is looked for.
_NEAREST_CHORD_COUNT = 3


def curve_contains(curve: Curve, point: FloatArray, scale: FloatArray) -> bool:
    """Whether a curve passes through a point, array (n + 1,)."""
    points = curve.points
    if len(points) < 2:
        return bool(np.linalg.norm((points.unknown[0] - point) / scale) < _MAX_DISTANCE_ON_CURVE)
    chain = points.unknown / scale
    chord = np.diff(chain, axis=0)
    away = point / scale - chain[:-1]
    square = np.maximum(np.einsum("ij,ij->i", chord, chord), 1e-300)
    part = (np.einsum("ij,ij->i", away, chord) / square).clip(0.0, 1.0)
    distance = np.linalg.norm(away - part[:, None] * chord, axis=1)
    # Between its points a curve bends away from the chord by more than the distance that
    # counts as on it, so the point is compared with the cubic, across its direction.
    nearest = np.argsort(distance)[:_NEAREST_CHORD_COUNT]
    guess, direction = interpolate_curve(points, nearest, part[nearest], scale)
    offset = (point - guess) / scale
    along = np.einsum("ij,ij->i", offset, direction)
    across = np.linalg.norm(offset - along[:, None] * direction, axis=1)
    is_beside = np.abs(along) < np.sqrt(square[nearest])
    return bool((is_beside & (across < _MAX_DISTANCE_ON_CURVE)).any())


def clip_to_bounds(
    equations: CurveEquations, curve: Curve, settings: ContinuationSettings
) -> Curve:
    """The curve up to the bounds exactly, where it left them, and which unknown reached them."""
    if curve.end_reasons[1] == "bounds":
        curve = _clip_last_point(equations, curve, settings)
    if curve.end_reasons[0] == "bounds":
        curve = _clip_last_point(equations, curve.reversed(), settings).reversed()
    return curve


def replace_last_point(curve: Curve, end: CurvePoints) -> Curve:
    """The curve with another last point, whose tangent is turned the way the curve runs."""
    inner = curve.points.subset(slice(0, -1))
    if not len(inner):
        return replace(curve, points=end)
    side = 1.0 if end.tangent[0] @ inner.tangent[-1] >= 0.0 else -1.0
    end = replace(end, tangent=side * end.tangent)
    return replace(curve, points=concatenate_points([inner, end]))


def _clip_last_point(
    equations: CurveEquations, curve: Curve, settings: ContinuationSettings
) -> Curve:
    """Move the last point back to where the curve crosses the bounds."""
    points = curve.points
    last = points.unknown[-1]
    before = points.unknown[-2] if len(points) > 1 else last
    wall = np.where(last > settings.upper_bounds, settings.upper_bounds, settings.lower_bounds)
    outside = (last > settings.upper_bounds) | (last < settings.lower_bounds)
    with np.errstate(all="ignore"):
        part = np.where(outside, (wall - before) / (last - before), np.inf)
    i = int(np.argmin(part))  # the unknown whose bound is crossed first
    curve = replace(curve, bounded_unknowns=(curve.bounded_unknowns[0], i))
    if len(points) < 2:
        return curve
    guess = before + np.clip(part[i], 0.0, 1.0) * (last - before)
    guess[i] = wall[i]
    direction = np.zeros((1, last.size))
    direction[0, i] = 1.0
    end, reached = correct_points(
        equations, guess[None], direction, scale=settings.scale, tolerance=settings.tolerance
    )
    if not reached[0]:
        return replace(curve, points=points.subset(slice(0, -1)))
    return replace_last_point(curve, end)
