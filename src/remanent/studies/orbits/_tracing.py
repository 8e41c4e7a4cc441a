"""Branches of periodic orbits of one actuator: followed, clipped, each kept once."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.orbits.bifurcations import SpecialPoint, find_special_points
from remanent.analysis.orbits.continuation import ContinuationSettings, continue_curves
from remanent.analysis.orbits.correction import correct_points, unit_tangents
from remanent.analysis.orbits.curves import (
    Curve,
    CurveEquations,
    CurvePoints,
    concatenate_points,
    interpolate_curve,
)
from remanent.analysis.orbits.orbit_equations import orbit_equations
from remanent.analysis.orbits.periodic_orbits import Orbits
from remanent.studies.orbits._period_map import StroboscopicMap
from remanent.studies.orbits._search import Search, all_orbits

#: A point nearer to a curve than this, in scaled unknowns, is on it.
_ON = 1e-3
#: First and longest step along a branch, in scaled unknowns.
_STEP, _LONGEST = 0.005, 0.02
#: Points predicted at once: on one curve, on many.
_ALONE, _TOGETHER = 16, 8


@dataclass(frozen=True)
class Branch:
    """A branch with its special points."""

    curve: Curve
    special: list[SpecialPoint]


@dataclass(frozen=True)
class Tracing:
    """How branches are followed: the map's one parameter varies within its bounds."""

    map: StroboscopicMap
    box: FloatArray
    bounds: tuple[float, float]
    period: int
    tolerance: float
    most: int
    conservative: bool

    @property
    def equations(self) -> CurveEquations:
        return orbit_equations(self.map, self.period)

    @property
    def settings(self) -> ContinuationSettings:
        lower, upper = (np.append(self.box[:, k], self.bounds[k]) for k in (0, 1))
        scale = np.append(np.ones(len(self.box)), self.bounds[1] - self.bounds[0])
        return ContinuationSettings(
            lower, upper, scale, first_step=_STEP, max_step=_LONGEST,
            tolerance=0.1 * self.tolerance, max_points=self.most,
        )  # fmt: skip


def through(tracing: Tracing, orbits: Orbits, values: FloatArray) -> list[Branch]:
    """The branches through some orbits, each once.

    Parameters
    ----------
    values : array (orbit,)
        Of the parameter, at which the orbits were found.
    """
    if not len(values):
        return []
    equations, settings = tracing.equations, tracing.settings
    unknown = np.column_stack([orbits.state, values])
    here = equations(unknown)
    along = np.zeros(unknown.shape)
    along[:, -1] = 1.0
    starts = CurvePoints(
        unknown,
        unit_tangents(here.derivative, along, settings.scale),
        np.abs(here.value).max(axis=1),
        here.error,
        here.extra,
    )
    block = _ALONE if len(values) == 1 else _TOGETHER
    curves = continue_curves(
        equations, starts, ContinuationSettings(**{**vars(settings), "block": block})
    )
    kept: list[Curve] = []
    for curve, start in zip(curves, unknown, strict=True):
        if not any(passes(other, start, settings.scale) for other in kept):
            kept.append(_clipped(equations, curve, settings))
    return [
        Branch(
            curve,
            find_special_points(
                equations,
                curve.points,
                scale=settings.scale,
                tolerance=settings.tolerance,
                conservative=tracing.conservative,
            ),
        )
        for curve in kept
    ]


def everywhere(tracing: Tracing, search: Search, slices: int) -> list[Branch]:
    """All branches that pass through one of several evenly spaced values of the parameter."""
    low, high = tracing.bounds
    values = low + (high - low) * (np.arange(slices) + 0.5) / slices
    found = all_orbits(search, values[:, None])
    # From the middle outwards: most branches pass there, and are followed together.
    branches: list[Branch] = []
    scale = tracing.settings.scale
    for k in np.argsort(np.abs(values - values.mean()), kind="stable"):
        orbits = found[k]
        new = [
            i
            for i, state in enumerate(orbits.state)
            if not any(passes(b.curve, np.append(state, values[k]), scale) for b in branches)
        ]
        some = Orbits(*(getattr(orbits, name)[new] for name in vars(orbits)))
        branches += through(tracing, some, np.full(len(new), values[k]))
    return branches


def passes(curve: Curve, point: FloatArray, scale: FloatArray) -> bool:
    """Whether a curve passes through a point."""
    points = curve.points
    if len(points) < 2:
        return bool(np.linalg.norm((points.unknown[0] - point) / scale) < _ON)
    chain = points.unknown / scale
    chord = np.diff(chain, axis=0)
    away = point / scale - chain[:-1]
    square = np.maximum(np.einsum("ij,ij->i", chord, chord), 1e-300)
    part = (np.einsum("ij,ij->i", away, chord) / square).clip(0.0, 1.0)
    distance = np.linalg.norm(away - part[:, None] * chord, axis=1)
    nearest = np.argsort(distance)[:3]
    guess, _ = interpolate_curve(points, nearest, part[nearest], scale)
    return bool((np.linalg.norm((guess - point) / scale, axis=1) < _ON).any())


def _clipped(equations: CurveEquations, curve: Curve, settings: ContinuationSettings) -> Curve:
    """The curve up to the bounds exactly, where it left them."""
    points = curve.points
    if curve.ends[1] == "bounds":
        points = _end_on_bounds(equations, points, settings)
    if curve.ends[0] == "bounds":
        turned = points.subset(np.arange(len(points))[::-1])
        points = _end_on_bounds(equations, turned, settings)
        points = points.subset(np.arange(len(points))[::-1])
    return Curve(points, curve.closed, curve.ends)


def _end_on_bounds(
    equations: CurveEquations, points: CurvePoints, settings: ContinuationSettings
) -> CurvePoints:
    """Move the last point back to where the curve crosses the bounds."""
    if len(points) < 2:
        return points
    before, last = points.unknown[-2], points.unknown[-1]
    wall = np.where(last > settings.upper, settings.upper, settings.lower)
    out = (last > settings.upper) | (last < settings.lower)
    with np.errstate(all="ignore"):
        part = np.where(out, (wall - before) / (last - before), np.inf)
    i = int(np.argmin(part))
    guess = before + np.clip(part[i], 0.0, 1.0) * (last - before)
    guess[i] = wall[i]
    across = np.zeros((1, last.size))
    across[0, i] = 1.0
    end, reached = correct_points(
        equations, guess[None], across, scale=settings.scale, tolerance=settings.tolerance
    )
    inner = points.subset(slice(0, -1))
    side = np.sign(end.tangent[0] @ inner.tangent[-1])
    end = replace(end, tangent=side * end.tangent)
    return concatenate_points([inner, end]) if reached[0] else inner
