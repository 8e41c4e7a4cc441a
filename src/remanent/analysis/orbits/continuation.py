"""Pseudo-arclength continuation of many curves at once.

A kernel advances sixteen trajectories in the time of one, so points are predicted in
blocks: several ahead on each of several curves, corrected together by Newton's method,
and kept as far as they are what was predicted.  The step then grows or shrinks.

References
----------
H. B. Keller, in: Applications of Bifurcation Theory (Academic Press, 1977) 359.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.curves import Curve, CurveEquations, CurvePoints, concatenate_points

#: Length of a correction relative to the step, beyond which a point is not what was predicted.
_MAX_CORRECTION = 0.25
#: Cosine of the turn of the tangent from point to point, at least.
_MIN_TURN_COSINE = 0.97
#: Distance of neighbouring points relative to the step, at least.
_MIN_GAP = 0.5
#: Distance of neighbouring points relative to the step, at most.
_MAX_GAP = 2.0
#: The step grows if all corrections of a block are shorter than this share of it.
_SMALL_CORRECTION = 0.02
#: Factor by which the step grows.
_GROWTH = 1.5
#: Factor by which the step shrinks if less than half a block is kept.
_SHRINKAGE = 0.5
#: Factor by which the step shrinks if nothing of a block is kept.
_STRONG_SHRINKAGE = 0.25
#: A step shorter than this share of the first ends the curve.
_MIN_STEP_SHARE = 1e-7
#: Fewest points of a curve that may be back at its start.
_MIN_POINTS_OF_LOOP = 10
#: Distance from the start, in steps, within which a curve may be back at it.
_HOME_DISTANCE = 2.0
#: Distance from the line through the start along its tangent, in steps, at most.
_HOME_OFFSET = 0.5
#: Cosine of the angle between the tangents there and at the start, at least.
_HOME_COSINE = 0.9


@dataclass(frozen=True)
class ContinuationSettings:
    """How curves are followed.

    Attributes
    ----------
    lower, upper : array (n + 1,)
        Box that a curve stays in.
    scale : array (n + 1,)
        Units of the unknowns, in which lengths are measured.
    first_step, max_step : float
        Along a curve, in scaled unknowns.
    tolerance : float
        Of the equations.
    block : int
        Points predicted at once on each curve.
    max_points : int
        Of a curve, in each direction.
    held : tuple of int
        Unknowns that do not change along a curve.
    """

    lower: FloatArray
    upper: FloatArray
    scale: FloatArray
    first_step: float = 0.01
    max_step: float = 0.05
    tolerance: float = 1e-10
    block: int = 8
    max_points: int = 1000
    held: tuple[int, ...] = ()


def continue_curves(
    equations: CurveEquations, starts: CurvePoints, settings: ContinuationSettings
) -> list[Curve]:
    """Follow the curve through each of some points, both ways, all together.

    Parameters
    ----------
    equations : callable
        Of unknowns (point, n + 1).
    starts : CurvePoints
        Points of curves (one each), with tangents; one curve is made of each.
    settings : ContinuationSettings
    """
    count = len(starts)
    heads = concatenate_points([starts, starts.reversed_tangents()])
    arms = _grow_arms(equations, heads, settings)
    return [_join_arms(arms[k], arms[k + count]) for k in range(count)]


@dataclass
class _Arm:
    """One direction of one curve while it grows.

    Everything but `first_step` and `origin` changes: each block appends to `parts`, moves
    `before` up to the last point but one, and sets the next `step`; `end` is empty until the
    arm stops.
    """

    parts: list[CurvePoints]
    step: float
    first_step: float
    before: tuple[FloatArray, FloatArray]
    origin: FloatArray
    end: str = ""
    total: int = 1

    @property
    def head(self) -> tuple[FloatArray, FloatArray]:
        """Unknowns and tangent of the last point."""
        last = self.parts[-1]
        return last.unknown[-1], last.tangent[-1]

    @property
    def first_tangent(self) -> FloatArray:
        """Tangent at the start."""
        return np.asarray(self.parts[0].tangent[0])


def _grow_arms(
    equations: CurveEquations, heads: CurvePoints, settings: ContinuationSettings
) -> list[_Arm]:
    """Grow the arm from each head until it ends; arms k and k + count/2 are of one curve."""
    arms = [_new_arm(heads.subset(slice(k, k + 1)), settings) for k in range(len(heads))]
    half = len(arms) // 2
    while growing := [k for k, arm in enumerate(arms) if not arm.end]:
        subset = [arms[k] for k in growing]
        guess, direction = _predict(subset, settings)
        points, reached = correct_points(
            equations, guess, direction, scale=settings.scale, tolerance=settings.tolerance
        )
        blocks = _inspect(subset, points, reached, guess, settings)
        for k, block in zip(growing, blocks, strict=True):
            if arms[k].end:  # its other half came round just now
                continue
            _extend(arms[k], points, block, settings)
            if arms[k].end == "closed":
                arms[(k + half) % len(arms)].end = "closed"
    return arms


def _new_arm(head: CurvePoints, settings: ContinuationSettings) -> _Arm:
    """An arm of one point; the one before it is made up, on the tangent."""
    z, t = head.unknown[0], head.tangent[0]
    before = (z - settings.first_step * t * settings.scale, t)
    step = settings.first_step
    return _Arm([head], step, step, before, z / settings.scale)


def _predict(arms: list[_Arm], settings: ContinuationSettings) -> tuple[FloatArray, FloatArray]:
    """Points ahead of each arm on the cubic through its last two points with their tangents."""
    before, head = zip(*((arm.before, arm.head) for arm in arms), strict=True)
    scaled0, scaled1 = (np.array([z for z, _ in ends]) / settings.scale for ends in (before, head))
    t0, t1 = (np.array([t for _, t in ends]) for ends in (before, head))
    gap = np.maximum(np.linalg.norm(scaled1 - scaled0, axis=1), 1e-300)[:, None]
    secant = (scaled1 - scaled0) / gap
    # z(s) = z1 + s t1 + s^2 c2 + s^3 c3, s the distance from the head: z(-gap) = z0, z'(-gap) = t0.
    curve2 = ((2.0 * t1 + t0 - 3.0 * secant) / gap)[:, None]
    curve3 = ((t1 + t0 - 2.0 * secant) / gap**2)[:, None]
    steps = np.array([arm.step for arm in arms])[:, None]
    ahead = (steps * np.arange(1, settings.block + 1))[:, :, None]
    guess = scaled1[:, None] + ahead * (t1[:, None] + ahead * (curve2 + ahead * curve3))
    direction = t1[:, None] + ahead * (2.0 * curve2 + 3.0 * ahead * curve3)
    length = np.linalg.norm(direction, axis=2, keepdims=True)
    guess = guess * settings.scale
    for k in settings.held:  # extrapolated, their rounding would grow without bound
        guess[:, :, k] = np.array([z[k] for z, _ in head])[:, None]
    size = settings.scale.size
    return guess.reshape(-1, size), (direction / np.maximum(length, 1e-300)).reshape(-1, size)


@dataclass(frozen=True)
class _Block:
    """What is seen of the points that were predicted on one arm.

    Attributes
    ----------
    first : int
        Number of the first of them among all that were corrected together.
    kept : int
        How many are what was predicted.
    outside : bool
        The last of these is outside the box.
    home : int or None
        How many come before the curve is back at its start.
    largest_correction : float
        Of those that are kept, in scaled unknowns.
    least_turn_cosine : float
        Of all of them.
    """

    first: int
    kept: int
    outside: bool
    home: int | None
    largest_correction: float
    least_turn_cosine: float


def _inspect(
    arms: list[_Arm],
    points: CurvePoints,
    reached: BoolArray,
    guess: FloatArray,
    settings: ContinuationSettings,
) -> list[_Block]:
    """How many points of every arm's block are what was predicted.

    Newton's method can land on another branch, or on this one far away.  A point counts only if
    it converged near its guess, its tangent is nearly that of the point before, and the
    distance from that point is about a step.  After the first that fails nothing counts.
    """
    shape = (len(arms), settings.block)
    correction = np.linalg.norm((points.unknown - guess) / settings.scale, axis=1).reshape(shape)
    heads = np.array([arm.head[0] for arm in arms])[:, None]
    head_tangents = np.array([arm.head[1] for arm in arms])[:, None]
    unknown, tangent = (a.reshape(*shape, -1) for a in (points.unknown, points.tangent))
    chain = np.concatenate([heads, unknown], axis=1) / settings.scale
    before = np.concatenate([head_tangents, tangent[:, :-1]], axis=1)
    gap = np.linalg.norm(np.diff(chain, axis=1), axis=2)
    turn_cosine = np.einsum("kij,kij->ki", before, tangent)
    step = np.array([arm.step for arm in arms])[:, None]
    near = correction < _MAX_CORRECTION * step
    even = (gap > _MIN_GAP * step) & (gap < _MAX_GAP * step)
    good = reached.reshape(shape) & near & (turn_cosine > _MIN_TURN_COSINE) & even
    kept = np.cumprod(good, axis=1).sum(axis=1)
    inside = ((unknown >= settings.lower) & (unknown <= settings.upper)).all(axis=2)
    within = np.cumprod(inside, axis=1).sum(axis=1)
    home = _points_before_home(arms, chain[:, 1:], tangent)
    blocks = []
    for i in range(len(arms)):
        outside = bool(within[i] < kept[i])
        # The first point outside is kept: the end of the curve is between it and the one before.
        count = int(within[i]) + 1 if outside else int(kept[i])
        blocks.append(
            _Block(
                first=i * settings.block,
                kept=count,
                outside=outside,
                home=int(home[i]) if home[i] < count and not outside else None,
                largest_correction=float(correction[i, :count].max(initial=0.0)),
                least_turn_cosine=float(turn_cosine[i].min()),
            )
        )
    return blocks


def _points_before_home(arms: list[_Arm], chain: FloatArray, tangent: FloatArray) -> IntArray:
    """How many points of each block come before the curve is back at its start.

    It is back where it passes the start in the direction of the first tangent: near it, beside
    its tangent by less than half a step, and pointing the same way.

    Parameters
    ----------
    chain, tangent : array (arm, point, n + 1)
        Of the points of the block, in scaled unknowns.
    """
    start = np.array([arm.origin for arm in arms])[:, None]
    towards = np.array([arm.first_tangent for arm in arms])
    step = np.array([arm.step for arm in arms])[:, None]
    away = chain - start
    along = np.einsum("kij,kj->ki", away, towards)
    near = np.linalg.norm(away, axis=2) < _HOME_DISTANCE * step
    parallel = np.einsum("kij,kj->ki", tangent, towards) > _HOME_COSINE
    across = np.linalg.norm(away - along[:, :, None] * towards[:, None], axis=2)
    passed = near & parallel & (along >= 0.0) & (across < _HOME_OFFSET * step)
    # Every curve is near its start when it begins.
    passed &= np.array([arm.total >= _MIN_POINTS_OF_LOOP for arm in arms])[:, None]
    return np.asarray(np.where(passed.any(axis=1), passed.argmax(axis=1), chain.shape[1]))


def _extend(arm: _Arm, points: CurvePoints, block: _Block, settings: ContinuationSettings) -> None:
    """Append the points of a block that are what was predicted, and choose the next step."""
    kept = block.kept if block.home is None else block.home
    arm.end = "bounds" if block.outside else "closed" if block.home is not None else ""
    if kept:
        part = points.subset(slice(block.first, block.first + kept))
        last_but_one = kept - 2
        if last_but_one >= 0:
            arm.before = (part.unknown[last_but_one], part.tangent[last_but_one])
        else:
            arm.before = arm.head
        arm.parts.append(part)
        arm.total += kept
    if not arm.end and arm.total >= settings.max_points:
        arm.end = "points"
    arm.step = _next_step(arm.step, kept, block, settings)
    if not arm.end and arm.step < _MIN_STEP_SHARE * arm.first_step:
        arm.end = "lost"


def _next_step(step: float, kept: int, block: _Block, settings: ContinuationSettings) -> float:
    """The step after a block.

    It grows only after a whole block with short corrections and gentle turns.  Less than half a
    block means that the prediction is too bold; in between the step stays, since a point
    that is lost at the end of a block costs less than a shorter step.
    """
    gentle = block.least_turn_cosine > _MIN_TURN_COSINE**0.5
    if kept == settings.block and block.largest_correction < _SMALL_CORRECTION * step and gentle:
        return min(_GROWTH * step, settings.max_step)
    if kept < settings.block // 2:
        return step * (_STRONG_SHRINKAGE if kept == 0 else _SHRINKAGE)
    return step


def _join_arms(forth: _Arm, back: _Arm) -> Curve:
    """Both arms as one curve, in the direction of the first."""
    closed = forth.end == "closed" and back.end == "closed" and forth.total > 1
    ahead = concatenate_points(forth.parts)
    if closed:
        # Each arm went all the way round, or was told that the other did: the longer one did.
        loop = ahead if forth.total >= back.total else concatenate_points(back.parts)
        points = loop.subset(np.append(np.arange(len(loop)), 0))
        return Curve(points, True, ("closed", "closed"))
    behind = concatenate_points(back.parts).subset(slice(None, 0, -1)).reversed_tangents()
    return Curve(concatenate_points([behind, ahead]), False, (back.end, forth.end))
