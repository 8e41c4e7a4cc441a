"""Pseudo-arclength continuation of many curves at once.

A kernel advances sixteen trajectories in the time of one, so points are predicted in
blocks: several ahead on each of several curves, corrected together by Newton's method,
and kept as far as they are what was predicted.  The step then grows or shrinks.

References
----------
H. B. Keller, in: Applications of Bifurcation Theory (Academic Press, 1977) 359.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.orbits.correction import correct_points
from remanent.analysis.orbits.curves import Curve, CurveEquations, CurvePoints, concatenate_points

#: Length of a correction relative to the step, beyond which a point is not what was predicted.
_MAX_CORRECTION_IN_STEPS = 0.25
#: Cosine of the turn of the tangent from point to point, at least.
_MIN_TURN_COSINE = 0.97
#: The step grows if all corrections of a block are shorter than this share of it.
_MAX_CORRECTION_IN_STEPS_FOR_GROWTH = 0.02
#: Factor by which the step grows.
_STEP_GROWTH_FACTOR = 1.5
#: Factor by which the step shrinks if less than half a block is kept.
_STEP_SHRINK_FACTOR_IF_FEW_KEPT = 0.5
#: Factor by which the step shrinks if nothing of a block is kept.
_STEP_SHRINK_FACTOR_IF_NONE_KEPT = 0.25
#: A step shorter than this share of the first ends the curve.
_MIN_STEP_SHARE_OF_FIRST = 1e-7
#: So does one shorter than this many times the error of the equations at its end: what is beyond
#: cannot be told from that error.
_MIN_STEP_OVER_ERROR = 10.0
#: Fewest points of a curve that may be back at its start.
_MIN_CLOSED_CURVE_POINTS = 10
#: Distance from the start, in steps, within which a curve may be back at it.
_MAX_CLOSURE_DISTANCE_IN_STEPS = 2.0
#: Distance from the line through the start along its tangent, in steps, at most.
_MAX_CLOSURE_OFFSET_IN_STEPS = 0.5
#: Cosine of the angle between the tangents there and at the start, at least.
_MIN_CLOSURE_TANGENT_COSINE = 0.9


@dataclass(frozen=True)
class ContinuationSettings:
    """How curves are followed.

    Attributes
    ----------
    lower_bounds, upper_bounds : array (n + 1,)
        Box that a curve stays in.
    scale : array (n + 1,)
        Units of the unknowns, in which lengths are measured.
    first_step_length, max_step_length : float
        Along a curve, in scaled unknowns.
    tolerance : float
        Of the equations.
    points_per_block : int
        Points predicted at once on each curve.
    max_points : int
        Of a curve, in each direction.
    held_unknown_indices : tuple of int
        Unknowns that do not change along a curve.
    ends_between : callable, optional
        Takes consecutive points of a curve and says between which of them, array (point - 1,),
        it ends although it could be followed further.
    """

    lower_bounds: FloatArray
    upper_bounds: FloatArray
    scale: FloatArray
    first_step_length: float = 0.01
    max_step_length: float = 0.05
    tolerance: float = 1e-10
    points_per_block: int = 8
    max_points: int = 1000
    held_unknown_indices: tuple[int, ...] = ()
    ends_between: Callable[[CurvePoints], BoolArray] | None = None


def continue_curves(
    equations: CurveEquations,
    starts: CurvePoints,
    settings: ContinuationSettings,
    *,
    both_ways: bool = True,
) -> list[Curve]:
    """Follow the curve through each of some points, all together.

    Parameters
    ----------
    equations : callable
        Of unknowns (point, n + 1).
    starts : CurvePoints
        Points of curves (one each), with tangents; one curve is made of each.
    settings : ContinuationSettings
    both_ways : bool
        Otherwise each is followed along its tangent only, and its first end is its ``start``.
    """
    if not both_ways:
        return [
            Curve(concatenate_points(arm.point_blocks), False, ("start", arm.end_reason))
            for arm in _grow_arms(equations, starts, settings)
        ]
    count = len(starts)
    heads = concatenate_points([starts, starts.with_reversed_tangents()])
    arms = _grow_arms(equations, heads, settings, paired=True)
    return [_join_arms(arms[k], arms[k + count]) for k in range(count)]


@dataclass
class _CurveArm:
    """One direction of one curve while it grows.

    Everything but `first_step_length` and `scaled_start` changes: each block appends to
    `point_blocks`, moves `point_before_last` up to the last point but one, and sets the next
    `step_length`; `end_reason` is empty until the arm stops, `came_home` true only for one that
    went all the way round a closed curve.
    """

    point_blocks: list[CurvePoints]
    step_length: float
    first_step_length: float
    point_before_last: tuple[FloatArray, FloatArray]
    scaled_start: FloatArray
    end_reason: str = ""
    point_count: int = 1
    came_home: bool = False

    @property
    def last_point(self) -> tuple[FloatArray, FloatArray]:
        """Unknowns and tangent of the last point."""
        last = self.point_blocks[-1]
        return last.unknown[-1], last.tangent[-1]

    @property
    def first_tangent(self) -> FloatArray:
        """Tangent at the start."""
        return np.asarray(self.point_blocks[0].tangent[0])


def _grow_arms(
    equations: CurveEquations,
    heads: CurvePoints,
    settings: ContinuationSettings,
    *,
    paired: bool = False,
) -> list[_CurveArm]:
    """Grow the arm from each head until it ends; paired arms k, k + count/2 are of one curve."""
    arms = [_start_arm(heads.subset(slice(k, k + 1)), settings) for k in range(len(heads))]
    half = len(arms) // 2
    while growing := [k for k, arm in enumerate(arms) if not arm.end_reason]:
        subset = [arms[k] for k in growing]
        guess, direction = _predict_points(subset, settings)
        steps = np.repeat([arm.step_length for arm in subset], settings.points_per_block)
        points, reached = correct_points(
            equations, guess, direction, scale=settings.scale, tolerance=settings.tolerance,
            reach=steps,
        )  # fmt: skip
        blocks = _inspect_blocks(subset, points, reached, guess, settings)
        for k, block in zip(growing, blocks, strict=True):
            if arms[k].end_reason:  # its other half came round just now
                continue
            _extend_arm(arms[k], points, block, settings)
            if paired and arms[k].came_home:
                arms[(k + half) % len(arms)].end_reason = "closed"
    return arms


def _start_arm(head: CurvePoints, settings: ContinuationSettings) -> _CurveArm:
    """An arm of one point; the one before it is made up, on the tangent."""
    z, t = head.unknown[0], head.tangent[0]
    before = (z - settings.first_step_length * t * settings.scale, t)
    step = settings.first_step_length
    return _CurveArm([head], step, step, before, z / settings.scale)


def _predict_points(
    arms: list[_CurveArm], settings: ContinuationSettings
) -> tuple[FloatArray, FloatArray]:
    """Points ahead of each arm on the cubic through its last two points with their tangents."""
    before, head = zip(*((arm.point_before_last, arm.last_point) for arm in arms), strict=True)
    scaled0, scaled1 = (np.array([z for z, _ in ends]) / settings.scale for ends in (before, head))
    t0, t1 = (np.array([t for _, t in ends]) for ends in (before, head))
    gap = np.maximum(np.linalg.norm(scaled1 - scaled0, axis=1), 1e-300)[:, None]
    secant = (scaled1 - scaled0) / gap
    # z(s) = z1 + s t1 + s^2 c2 + s^3 c3, s the distance from the head: z(-gap) = z0, z'(-gap) = t0.
    curve2 = ((2.0 * t1 + t0 - 3.0 * secant) / gap)[:, None]
    curve3 = ((t1 + t0 - 2.0 * secant) / gap**2)[:, None]
    steps = np.array([arm.step_length for arm in arms])[:, None]
    ahead = (steps * np.arange(1, settings.points_per_block + 1))[:, :, None]
    guess = scaled1[:, None] + ahead * (t1[:, None] + ahead * (curve2 + ahead * curve3))
    direction = t1[:, None] + ahead * (2.0 * curve2 + 3.0 * ahead * curve3)
    length = np.linalg.norm(direction, axis=2, keepdims=True)
    guess = guess * settings.scale
    for k in settings.held_unknown_indices:  # extrapolated, their rounding would grow without bound
        guess[:, :, k] = np.array([z[k] for z, _ in head])[:, None]
    size = settings.scale.size
    return guess.reshape(-1, size), (direction / np.maximum(length, 1e-300)).reshape(-1, size)


@dataclass(frozen=True)
class _BlockInspection:
    """What is seen of the points that were predicted on one arm.

    Attributes
    ----------
    first_point_index : int
        Number of the first of them among all that were corrected together.
    kept_count : int
        How many are what was predicted.
    leaves_box : bool
        The last of these is outside the box.
    count_before_closure : int or None
        How many come before the curve is back at its start.
    largest_correction : float
        Of those that are kept, in scaled unknowns.
    least_turn_cosine : float
        Of all of them.
    """

    first_point_index: int
    kept_count: int
    leaves_box: bool
    count_before_closure: int | None
    largest_correction: float
    least_turn_cosine: float


def _inspect_blocks(
    arms: list[_CurveArm],
    points: CurvePoints,
    reached: BoolArray,
    guess: FloatArray,
    settings: ContinuationSettings,
) -> list[_BlockInspection]:
    """How many points of every arm's block are what was predicted.

    Newton's method can land on another branch, or on this one far away.  A point counts only if
    it converged near its guess and its tangent is nearly that of the point before.  After the first
    that fails nothing counts.
    """
    shape = (len(arms), settings.points_per_block)
    correction = np.linalg.norm((points.unknown - guess) / settings.scale, axis=1).reshape(shape)
    heads = np.array([arm.last_point[0] for arm in arms])[:, None]
    head_tangents = np.array([arm.last_point[1] for arm in arms])[:, None]
    unknown, tangent = (a.reshape(*shape, -1) for a in (points.unknown, points.tangent))
    chain = np.concatenate([heads, unknown], axis=1) / settings.scale
    before = np.concatenate([head_tangents, tangent[:, :-1]], axis=1)
    turn_cosine = np.einsum("kij,kij->ki", before, tangent)
    step = np.array([arm.step_length for arm in arms])[:, None]
    is_close = correction < _MAX_CORRECTION_IN_STEPS * step
    good = reached.reshape(shape) & is_close & (turn_cosine > _MIN_TURN_COSINE)
    kept = np.cumprod(good, axis=1).sum(axis=1)
    inside = ((unknown >= settings.lower_bounds) & (unknown <= settings.upper_bounds)).all(axis=2)
    within = np.cumprod(inside, axis=1).sum(axis=1)
    home = _count_points_before_closure(arms, chain[:, 1:], tangent)
    blocks = []
    for i in range(len(arms)):
        outside = bool(within[i] < kept[i])
        # The first point outside is kept: the end of the curve is between it and the one before.
        count = int(within[i]) + 1 if outside else int(kept[i])
        blocks.append(
            _BlockInspection(
                first_point_index=i * settings.points_per_block,
                kept_count=count,
                leaves_box=outside,
                count_before_closure=int(home[i]) if home[i] < count and not outside else None,
                largest_correction=float(correction[i, :count].max(initial=0.0)),
                least_turn_cosine=float(turn_cosine[i].min()),
            )
        )
    return blocks


def _count_points_before_closure(
    arms: list[_CurveArm], chain: FloatArray, tangent: FloatArray
) -> IntArray:
    """How many points of each block come before the curve is back at its start.

    It is back where it passes the start in the direction of the first tangent: near it, beside
    its tangent by less than half a step, and pointing the same way.

    Parameters
    ----------
    chain, tangent : array (arm, point, n + 1)
        Of the points of the block, in scaled unknowns.
    """
    start = np.array([arm.scaled_start for arm in arms])[:, None]
    towards = np.array([arm.first_tangent for arm in arms])
    step = np.array([arm.step_length for arm in arms])[:, None]
    displacement = chain - start
    tangential = np.einsum("kij,kj->ki", displacement, towards)
    is_close = np.linalg.norm(displacement, axis=2) < _MAX_CLOSURE_DISTANCE_IN_STEPS * step
    parallel = np.einsum("kij,kj->ki", tangent, towards) > _MIN_CLOSURE_TANGENT_COSINE
    transverse = np.linalg.norm(displacement - tangential[:, :, None] * towards[:, None], axis=2)
    passed = (
        is_close
        & parallel
        & (tangential >= 0.0)
        & (transverse < _MAX_CLOSURE_OFFSET_IN_STEPS * step)
    )
    # Every curve is near its start when it begins.
    passed &= np.array([arm.point_count >= _MIN_CLOSED_CURVE_POINTS for arm in arms])[:, None]
    return np.asarray(np.where(passed.any(axis=1), passed.argmax(axis=1), chain.shape[1]))


def _extend_arm(
    arm: _CurveArm, points: CurvePoints, block: _BlockInspection, settings: ContinuationSettings
) -> None:
    """Append the points of a block that are what was predicted, and choose the next step."""
    kept = block.kept_count if block.count_before_closure is None else block.count_before_closure
    arm.came_home = block.count_before_closure is not None
    arm.end_reason = "bounds" if block.leaves_box else "closed" if arm.came_home else ""
    if kept and settings.ends_between is not None:
        ahead = points.subset(slice(block.first_point_index, block.first_point_index + kept))
        last = arm.point_blocks[-1].subset(slice(-1, None))
        ends = np.flatnonzero(settings.ends_between(concatenate_points([last, ahead])))
        if ends.size:  # the first point beyond the end is kept: the end is before it
            kept, arm.end_reason, arm.came_home = int(ends[0]) + 1, "branching", False
    if kept:
        part = points.subset(slice(block.first_point_index, block.first_point_index + kept))
        last_but_one = kept - 2
        if last_but_one >= 0:
            arm.point_before_last = (part.unknown[last_but_one], part.tangent[last_but_one])
        else:
            arm.point_before_last = arm.last_point
        arm.point_blocks.append(part)
        arm.point_count += kept
    if not arm.end_reason and arm.point_count >= settings.max_points:
        arm.end_reason = "points"
    arm.step_length = _next_step_length(arm.step_length, kept, block, settings)
    least = max(
        _MIN_STEP_SHARE_OF_FIRST * arm.first_step_length,
        _MIN_STEP_OVER_ERROR * float(arm.point_blocks[-1].residual_error[-1]),
    )
    if not arm.end_reason and arm.step_length < least:
        arm.end_reason = "lost"


def _next_step_length(
    step: float, kept: int, block: _BlockInspection, settings: ContinuationSettings
) -> float:
    """The step after a block.

    It grows only after a whole block with short corrections and gentle turns.  Less than half a
    block means that the prediction is too bold; in between the step stays, since a point
    that is lost at the end of a block costs less than a shorter step.
    """
    gentle = block.least_turn_cosine > _MIN_TURN_COSINE**0.5
    if (
        kept == settings.points_per_block
        and block.largest_correction < _MAX_CORRECTION_IN_STEPS_FOR_GROWTH * step
        and gentle
    ):
        return min(_STEP_GROWTH_FACTOR * step, settings.max_step_length)
    if kept < settings.points_per_block // 2:
        return step * (
            _STEP_SHRINK_FACTOR_IF_NONE_KEPT if kept == 0 else _STEP_SHRINK_FACTOR_IF_FEW_KEPT
        )
    return step


def _join_arms(forth: _CurveArm, back: _CurveArm) -> Curve:
    """Both arms as one curve, in the direction of the first."""
    ahead = concatenate_points(forth.point_blocks)
    if forth.came_home or back.came_home:
        # Of two arms the one that came home is the whole curve.  The other was told to stop on its
        # way, where it may have more points.
        loop = ahead if forth.came_home else concatenate_points(back.point_blocks)
        points = loop.subset(np.append(np.arange(len(loop)), 0))
        return Curve(points, True, ("closed", "closed"))
    behind = (
        concatenate_points(back.point_blocks).subset(slice(None, 0, -1)).with_reversed_tangents()
    )
    return Curve(concatenate_points([behind, ahead]), False, (back.end_reason, forth.end_reason))
