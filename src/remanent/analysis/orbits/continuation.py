"""Curves of solutions of n equations in n + 1 unknowns: pseudo-arclength, many at once.

A kernel advances sixteen trajectories in the time of one, so points are predicted in
blocks: several ahead on each of several curves, corrected together by Newton's method,
and kept as far as they are what was predicted.  The step then grows or shrinks.

References
----------
H. B. Keller, in: Applications of Bifurcation Theory (Academic Press, 1977) 359.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray

#: Newton steps at most.
_CORRECTIONS = 6
#: A correction longer than this share of the step, or a turn of the tangent by more than
#: this cosine, makes the step shorter.
_FAR, _TURN = 0.25, 0.97
#: The step grows if corrections were shorter than this share of it.
_CLOSE = 0.02
#: Points that a curve has before it may be back at its start.
_BEGUN = 10
#: Steps shorter than this share of the first end a curve.
_TOO_SHORT = 1e-7


@dataclass(frozen=True)
class EquationValues:
    """Equations at some points.

    Attributes
    ----------
    value : array (point, equation)
    derivative : array (point, equation, unknown)
    error : array (point,)
        Estimated error of the value.
    extra : mapping of name to array (point, ...)
        Whatever else is to be kept with each point.
    """

    value: FloatArray
    derivative: FloatArray
    error: FloatArray
    extra: Mapping[str, FloatArray]


#: ``equations(unknowns)`` with unknowns (point, n + 1).
CurveEquations = Callable[[FloatArray], EquationValues]


@dataclass(frozen=True)
class CurvePoints:
    """Points of a curve.

    Attributes
    ----------
    unknown : array (point, n + 1)
    tangent : array (point, n + 1)
        Of unit length in scaled unknowns.
    residual, error : array (point,)
        Largest defect of the equations, and its estimated error.
    extra : mapping of name to array (point, ...)
    """

    unknown: FloatArray
    tangent: FloatArray
    residual: FloatArray
    error: FloatArray
    extra: Mapping[str, FloatArray]

    def __len__(self) -> int:
        return int(self.unknown.shape[0])

    def taken(self, which: slice | IntArray | BoolArray) -> CurvePoints:
        """Some of the points, in the order asked."""
        extra = {name: values[which] for name, values in self.extra.items()}
        return CurvePoints(
            self.unknown[which], self.tangent[which], self.residual[which], self.error[which], extra
        )


@dataclass(frozen=True)
class Curve:
    """A curve, and why it ended: ``closed``, ``bounds``, ``points`` or ``lost``."""

    points: CurvePoints
    closed: bool
    ends: tuple[str, str]


@dataclass(frozen=True)
class ContinuationSettings:
    """How curves are followed.

    Attributes
    ----------
    lower, upper : array (n + 1,)
        Box that a curve stays in.
    scale : array (n + 1,)
        Lengths are measured in these units.
    step, longest : float
        First and longest step along a curve, scaled.
    tolerance : float
        Of the equations.
    block : int
        Points predicted at once on each curve.
    most : int
        Points of a curve, in each direction.
    held : tuple of int
        Unknowns that do not change along a curve.
    """

    lower: FloatArray
    upper: FloatArray
    scale: FloatArray
    step: float = 0.01
    longest: float = 0.05
    tolerance: float = 1e-10
    block: int = 8
    most: int = 1000
    held: tuple[int, ...] = ()


def unit_tangents(derivative: FloatArray, like: FloatArray, scale: FloatArray) -> FloatArray:
    """Unit null vectors of the scaled derivatives, on the side of `like`."""
    _, _, right = np.linalg.svd(derivative * scale)
    t = right[:, -1, :]
    side = np.sign(np.einsum("ij,ij->i", t, like))
    return np.asarray(t * np.where(side == 0.0, 1.0, side)[:, None])


def correct_points(
    equations: CurveEquations,
    guess: FloatArray,
    direction: FloatArray,
    *,
    scale: FloatArray,
    tolerance: float,
) -> tuple[CurvePoints, BoolArray]:
    """Points of curves nearest to guesses, in planes across given directions.

    Parameters
    ----------
    guess, direction : array (point, n + 1)
        The direction is of scaled unknowns.

    Returns
    -------
    points, reached
        Whether Newton's method converged, for each.
    """
    z, here = guess.copy(), equations(guess)
    for _ in range(_CORRECTIONS - 1):
        residual, reached, finite = _judged(here, tolerance)
        moving = np.flatnonzero(finite & ~reached)
        if not moving.size:
            break
        matrix = np.concatenate(
            [here.derivative[moving] * scale, direction[moving, None, :]], axis=1
        )
        offset = np.einsum("ij,ij->i", direction[moving], (guess - z)[moving] / scale)
        right = np.concatenate([-here.value[moving], offset[:, None]], axis=1)
        z[moving] += _solved(matrix, right) * scale
        here = _with(here, equations(z[moving]), moving)
    residual, reached, finite = _judged(here, tolerance)
    derivative = np.where(finite[:, None, None], here.derivative, 0.0)
    tangent = unit_tangents(derivative, direction, scale)
    return CurvePoints(z, tangent, residual, here.error, here.extra), reached & finite


def _judged(here: EquationValues, tolerance: float) -> tuple[FloatArray, BoolArray, BoolArray]:
    """Residuals, where they are small enough, and where all is finite."""
    with np.errstate(all="ignore"):
        residual = np.abs(here.value).max(axis=1)
    finite = np.isfinite(here.derivative).all(axis=(1, 2)) & np.isfinite(residual)
    return residual, residual <= np.maximum(tolerance, 4.0 * here.error), finite


def _with(whole: EquationValues, part: EquationValues, which: IntArray) -> EquationValues:
    """The equations at some points put in."""

    def put(into: FloatArray, values: FloatArray) -> FloatArray:
        new = into.copy()
        new[which] = values
        return new

    return EquationValues(
        put(whole.value, part.value),
        put(whole.derivative, part.derivative),
        put(whole.error, part.error),
        {name: put(values, part.extra[name]) for name, values in whole.extra.items()},
    )


def _solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    with np.errstate(all="ignore"):
        try:
            return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
        except np.linalg.LinAlgError:
            return np.asarray((np.linalg.pinv(matrix) @ right[..., None])[..., 0])


def continue_curves(
    equations: CurveEquations, starts: CurvePoints, settings: ContinuationSettings
) -> list[Curve]:
    """Follow the curve through each of some points, both ways, together.

    Parameters
    ----------
    starts
        Points of curves (one each), with tangents; one curve is made of each.
    """
    count = len(starts)
    both = starts.taken(np.concatenate([np.arange(count), np.arange(count)]))
    turned = np.concatenate([starts.tangent, -starts.tangent])
    heads = CurvePoints(both.unknown, turned, both.residual, both.error, both.extra)
    arms = _arms(equations, heads, settings)
    return [_curve(arms[k], arms[k + count]) for k in range(count)]


@dataclass
class _Arm:
    """One direction of one curve while it grows."""

    parts: list[CurvePoints]
    step: float
    first: float
    before: tuple[FloatArray, FloatArray]
    origin: FloatArray
    end: str = ""
    total: int = 1

    @property
    def head(self) -> tuple[FloatArray, FloatArray]:
        last = self.parts[-1]
        return last.unknown[-1], last.tangent[-1]


def _arms(
    equations: CurveEquations, heads: CurvePoints, settings: ContinuationSettings
) -> list[_Arm]:
    arms = []
    for k in range(len(heads)):
        z, t = heads.unknown[k], heads.tangent[k]
        before = (z - settings.step * t * settings.scale, t)
        first = heads.taken(slice(k, k + 1))
        arms.append(_Arm([first], settings.step, settings.step, before, z / settings.scale))
    half = len(arms) // 2
    while growing := [k for k, arm in enumerate(arms) if not arm.end]:
        some = [arms[k] for k in growing]
        guess, direction = _predicted(some, settings)
        points, reached = correct_points(
            equations, guess, direction, scale=settings.scale, tolerance=settings.tolerance
        )
        blocks = _looked_at(some, points, reached, guess, settings)
        for i, k in enumerate(growing):
            if arms[k].end:  # its other half came round just now
                continue
            _grown(arms[k], points, blocks[i], settings)
            if arms[k].end == "closed":
                arms[(k + half) % len(arms)].end = "closed"
    return arms


def _predicted(arms: list[_Arm], settings: ContinuationSettings) -> tuple[FloatArray, FloatArray]:
    """Points ahead of each arm on the cubic through its last two points with their tangents."""
    before, head = zip(*((arm.before, arm.head) for arm in arms), strict=True)
    scaled0, scaled1 = (np.array([z for z, _ in ends]) / settings.scale for ends in (before, head))
    t0, t1 = (np.array([t for _, t in ends]) for ends in (before, head))
    gap = np.maximum(np.linalg.norm(scaled1 - scaled0, axis=1), 1e-300)[:, None]
    secant = (scaled1 - scaled0) / gap
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
    """What is seen of the points that were predicted on one arm."""

    first: int
    kept: int
    out: bool
    home: int | None
    worst: float
    bend: float


def _looked_at(
    arms: list[_Arm],
    points: CurvePoints,
    reached: BoolArray,
    guess: FloatArray,
    settings: ContinuationSettings,
) -> list[_Block]:
    """How many points of every arm's block are what was predicted."""
    shape = (len(arms), settings.block)
    correction = np.linalg.norm((points.unknown - guess) / settings.scale, axis=1).reshape(shape)
    heads, turns = (np.array(one)[:, None] for one in zip(*(arm.head for arm in arms), strict=True))
    unknown, tangent = (a.reshape(*shape, -1) for a in (points.unknown, points.tangent))
    chain = np.concatenate([heads, unknown], axis=1) / settings.scale
    before = np.concatenate([turns, tangent[:, :-1]], axis=1)
    gap = np.linalg.norm(np.diff(chain, axis=1), axis=2)
    turned = np.einsum("kij,kij->ki", before, tangent)
    step = np.array([arm.step for arm in arms])[:, None]
    even = (gap > 0.5 * step) & (gap < 2.0 * step)
    good = reached.reshape(shape) & (correction < _FAR * step) & (turned > _TURN) & even
    kept = np.cumprod(good, axis=1).sum(axis=1)
    inside = ((unknown >= settings.lower) & (unknown <= settings.upper)).all(axis=2)
    within = np.cumprod(inside, axis=1).sum(axis=1)
    home = _homes(arms, chain[:, 1:], tangent)
    blocks = []
    for i in range(len(arms)):
        out = bool(within[i] < kept[i])
        some = int(within[i]) + 1 if out else int(kept[i])
        worst = float(correction[i, :some].max(initial=0.0))
        came = int(home[i]) if home[i] < some and not out else None
        blocks.append(_Block(i * shape[1], some, out, came, worst, float(turned[i].min())))
    return blocks


def _grown(arm: _Arm, points: CurvePoints, block: _Block, settings: ContinuationSettings) -> None:
    """Keep the points of a block that are what was predicted, and choose the next step."""
    kept = block.kept if block.home is None else block.home
    arm.end = "bounds" if block.out else "closed" if block.home is not None else ""
    if kept:
        chosen = points.taken(slice(block.first, block.first + kept))
        (z, t), last = arm.head, kept - 2
        arm.before = (chosen.unknown[last], chosen.tangent[last]) if last >= 0 else (z, t)
        arm.parts.append(chosen)
        arm.total += kept
    if not arm.end and arm.total >= settings.most:
        arm.end = "points"
    if kept == settings.block and block.worst < _CLOSE * arm.step and block.bend > _TURN**0.5:
        arm.step = min(1.5 * arm.step, settings.longest)
    elif kept < settings.block // 2:
        arm.step *= 0.25 if kept == 0 else 0.5
    if not arm.end and arm.step < _TOO_SHORT * arm.first:
        arm.end = "lost"


def _homes(arms: list[_Arm], chain: FloatArray, tangent: FloatArray) -> IntArray:
    """How many points of each block come before the curve is back at its start."""
    start = np.array([arm.origin for arm in arms])[:, None]
    towards = np.array([arm.parts[0].tangent[0] for arm in arms])
    step = np.array([arm.step for arm in arms])[:, None]
    away = chain - start
    along = np.einsum("kij,kj->ki", away, towards)
    near = np.linalg.norm(away, axis=2) < 2.0 * step
    same = np.einsum("kij,kj->ki", tangent, towards) > 0.9
    across = np.linalg.norm(away - along[:, :, None] * towards[:, None], axis=2)
    passed = near & same & (along >= 0.0) & (across < 0.5 * step)
    passed &= np.array([arm.total >= _BEGUN for arm in arms])[:, None]
    return np.asarray(np.where(passed.any(axis=1), passed.argmax(axis=1), chain.shape[1]))


def _curve(forth: _Arm, back: _Arm) -> Curve:
    """Both arms as one curve, in the direction of the first."""
    closed = forth.end == "closed" and back.end == "closed" and forth.total > 1
    ahead = concatenate_points(forth.parts)
    if closed:
        whole = ahead if forth.total >= back.total else concatenate_points(back.parts)
        return Curve(whole.taken(np.append(np.arange(len(whole)), 0)), True, ("closed", "closed"))
    behind = concatenate_points(back.parts).taken(slice(None, 0, -1))
    flipped = CurvePoints(
        behind.unknown, -behind.tangent, behind.residual, behind.error, behind.extra
    )
    return Curve(concatenate_points([flipped, ahead]), False, (back.end, forth.end))


def concatenate_points(parts: list[CurvePoints]) -> CurvePoints:
    """Some stretches of points as one."""
    return CurvePoints(
        np.concatenate([part.unknown for part in parts]),
        np.concatenate([part.tangent for part in parts]),
        np.concatenate([part.residual for part in parts]),
        np.concatenate([part.error for part in parts]),
        {name: np.concatenate([part.extra[name] for part in parts]) for name in parts[0].extra},
    )
