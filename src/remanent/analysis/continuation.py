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
#: Steps shorter than this share of the first end a curve.
_TOO_SHORT = 1e-7


@dataclass(frozen=True)
class Evaluated:
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
Equations = Callable[[FloatArray], Evaluated]


@dataclass(frozen=True)
class Points:
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

    def taken(self, which: slice | IntArray | BoolArray) -> Points:
        """Some of the points, in the order asked."""
        extra = {name: values[which] for name, values in self.extra.items()}
        return Points(
            self.unknown[which], self.tangent[which], self.residual[which], self.error[which], extra
        )


@dataclass(frozen=True)
class Curve:
    """A curve, and why it ended: ``closed``, ``bounds``, ``points`` or ``lost``."""

    points: Points
    closed: bool
    ends: tuple[str, str]


@dataclass(frozen=True)
class Settings:
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


def tangents(derivative: FloatArray, like: FloatArray, scale: FloatArray) -> FloatArray:
    """Unit null vectors of the scaled derivatives, on the side of `like`."""
    _, _, right = np.linalg.svd(derivative * scale)
    t = right[:, -1, :]
    side = np.sign(np.einsum("ij,ij->i", t, like))
    return np.asarray(t * np.where(side == 0.0, 1.0, side)[:, None])


def corrected(
    equations: Equations,
    guess: FloatArray,
    direction: FloatArray,
    *,
    scale: FloatArray,
    tolerance: float,
) -> tuple[Points, BoolArray]:
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
    z = guess.copy()
    size = z.shape[1]
    for step in range(_CORRECTIONS):
        here = equations(z)
        with np.errstate(all="ignore"):
            residual = np.abs(here.value).max(axis=1)
        reached = residual <= np.maximum(tolerance, 4.0 * here.error)
        finite = np.isfinite(here.derivative).all(axis=(1, 2)) & np.isfinite(residual)
        if step == _CORRECTIONS - 1 or (reached | ~finite).all():
            break
        matrix = np.concatenate([here.derivative * scale, direction[:, None, :]], axis=1)
        matrix[~finite] = np.eye(size)
        offset = np.einsum("ij,ij->i", direction, (guess - z) / scale)
        right = np.concatenate([-here.value, offset[:, None]], axis=1)
        z = z + np.where((finite & ~reached)[:, None], _solved(matrix, right) * scale, 0.0)
    derivative = np.where(finite[:, None, None], here.derivative, 0.0)
    tangent = tangents(derivative, direction, scale)
    return Points(z, tangent, residual, here.error, here.extra), reached & finite


def _solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    with np.errstate(all="ignore"):
        try:
            return np.asarray(np.linalg.solve(matrix, right[..., None])[..., 0])
        except np.linalg.LinAlgError:
            return np.asarray((np.linalg.pinv(matrix) @ right[..., None])[..., 0])


def follow(equations: Equations, starts: Points, settings: Settings) -> list[Curve]:
    """Follow the curve through each of some points, both ways, together.

    Parameters
    ----------
    starts
        Points of curves (one each), with tangents; one curve is made of each.
    """
    count = len(starts)
    both = starts.taken(np.concatenate([np.arange(count), np.arange(count)]))
    turned = np.concatenate([starts.tangent, -starts.tangent])
    heads = Points(both.unknown, turned, both.residual, both.error, both.extra)
    arms = _arms(equations, heads, settings)
    return [_curve(arms[k], arms[k + count]) for k in range(count)]


@dataclass
class _Arm:
    """One direction of one curve while it grows."""

    parts: list[Points]
    step: float
    first: float
    before: tuple[FloatArray, FloatArray]
    end: str = ""
    total: int = 1

    @property
    def head(self) -> tuple[FloatArray, FloatArray]:
        last = self.parts[-1]
        return last.unknown[-1], last.tangent[-1]


def _arms(equations: Equations, heads: Points, settings: Settings) -> list[_Arm]:
    arms = []
    for k in range(len(heads)):
        z, t = heads.unknown[k], heads.tangent[k]
        before = (z - settings.step * t * settings.scale, t)
        arms.append(_Arm([heads.taken(slice(k, k + 1))], settings.step, settings.step, before))
    half = len(arms) // 2
    while growing := [k for k, arm in enumerate(arms) if not arm.end]:
        guesses = [_predicted(arms[k], settings) for k in growing]
        guess = np.concatenate([g for g, _ in guesses])
        direction = np.concatenate([d for _, d in guesses])
        points, reached = corrected(
            equations, guess, direction, scale=settings.scale, tolerance=settings.tolerance
        )
        for i, k in enumerate(growing):
            if arms[k].end:  # its other half came round just now
                continue
            block = slice(i * settings.block, (i + 1) * settings.block)
            _grown(arms[k], points.taken(block), reached[block], guess[block], settings)
            if arms[k].end == "closed":
                arms[(k + half) % len(arms)].end = "closed"
    return arms


def _predicted(arm: _Arm, settings: Settings) -> tuple[FloatArray, FloatArray]:
    """Points ahead on the cubic through the last two points with their tangents."""
    (z0, t0), (z1, t1) = arm.before, arm.head
    scaled0, scaled1 = z0 / settings.scale, z1 / settings.scale
    gap = max(float(np.linalg.norm(scaled1 - scaled0)), 1e-300)
    ahead = arm.step * np.arange(1, settings.block + 1)[:, None]
    secant = (scaled1 - scaled0) / gap
    curve2 = (2.0 * t1 + t0 - 3.0 * secant) / gap
    curve3 = (t1 + t0 - 2.0 * secant) / gap**2
    guess = scaled1 + ahead * (t1 + ahead * (curve2 + ahead * curve3))
    direction = t1 + ahead * (2.0 * curve2 + 3.0 * ahead * curve3)
    length = np.linalg.norm(direction, axis=1, keepdims=True)
    guess = guess * settings.scale
    for k in settings.held:  # extrapolated, their rounding would grow without bound
        guess[:, k] = z1[k]
    return guess, direction / np.maximum(length, 1e-300)


def _grown(
    arm: _Arm, points: Points, reached: BoolArray, guess: FloatArray, settings: Settings
) -> None:
    """Keep the points of a block that are what was predicted, and choose the next step."""
    correction = np.linalg.norm((points.unknown - guess) / settings.scale, axis=1)
    z, t = arm.head
    chain = np.vstack([z, points.unknown]) / settings.scale
    gap = np.linalg.norm(np.diff(chain, axis=0), axis=1)
    turned = np.einsum("ij,ij->i", np.vstack([t, points.tangent[:-1]]), points.tangent)
    even = (gap > 0.5 * arm.step) & (gap < 2.0 * arm.step)
    good = reached & (correction < _FAR * arm.step) & (turned > _TURN) & even
    kept = int(np.cumprod(good).sum())
    box = (points.unknown[:kept] >= settings.lower) & (points.unknown[:kept] <= settings.upper)
    out = np.flatnonzero(~np.all(box, axis=1))
    if out.size:
        kept, arm.end = int(out[0]) + 1, "bounds"
    home = _home(arm, chain[1 : kept + 1], points.tangent[:kept], settings)
    if home is not None and not arm.end:
        kept, arm.end = home, "closed"
    if kept:
        chosen = points.taken(slice(0, kept))
        whole = np.vstack([z, chosen.unknown]), np.vstack([t, chosen.tangent])
        arm.before = whole[0][-2], whole[1][-2]
        arm.parts.append(chosen)
        arm.total += kept
    if not arm.end and arm.total >= settings.most:
        arm.end = "points"
    worst = float(correction[:kept].max(initial=0.0))
    if kept == settings.block and worst < _CLOSE * arm.step and turned.min() > _TURN**0.5:
        arm.step = min(1.5 * arm.step, settings.longest)
    elif kept < settings.block // 2:
        arm.step *= 0.25 if kept == 0 else 0.5
    if not arm.end and arm.step < _TOO_SHORT * arm.first:
        arm.end = "lost"


def _home(arm: _Arm, chain: FloatArray, tangent: FloatArray, settings: Settings) -> int | None:
    """How many points of a block are left when the curve has come back to its start."""
    if arm.total < 10 or not len(chain):
        return None
    start = arm.parts[0]
    away = chain - start.unknown[0] / settings.scale
    along = away @ start.tangent[0]
    near = np.linalg.norm(away, axis=1) < 2.0 * arm.step
    same = tangent @ start.tangent[0] > 0.9
    across = np.linalg.norm(away - np.outer(along, start.tangent[0]), axis=1)
    passed = np.flatnonzero(near & same & (along >= 0.0) & (across < 0.5 * arm.step))
    return int(passed[0]) if passed.size else None


def _curve(forth: _Arm, back: _Arm) -> Curve:
    """Both arms as one curve, in the direction of the first."""
    closed = forth.end == "closed" and back.end == "closed" and forth.total > 1
    ahead = joined(forth.parts)
    if closed:
        whole = ahead if forth.total >= back.total else joined(back.parts)
        return Curve(whole.taken(np.append(np.arange(len(whole)), 0)), True, ("closed", "closed"))
    behind = joined(back.parts).taken(slice(None, 0, -1))
    flipped = Points(behind.unknown, -behind.tangent, behind.residual, behind.error, behind.extra)
    return Curve(joined([flipped, ahead]), False, (back.end, forth.end))


def joined(parts: list[Points]) -> Points:
    """Some stretches of points as one."""
    return Points(
        np.concatenate([part.unknown for part in parts]),
        np.concatenate([part.tangent for part in parts]),
        np.concatenate([part.residual for part in parts]),
        np.concatenate([part.error for part in parts]),
        {name: np.concatenate([part.extra[name] for part in parts]) for name in parts[0].extra},
    )
