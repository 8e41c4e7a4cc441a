"""Special points by Newton's method on extended systems, with errors of all unknowns.

At a special point the equations of the orbit hold, and one more: a singular value or a product of
multipliers has its critical value.  Together they fix the state and the parameter, and are regular
there, which the equations of the orbit alone are not at a fold.  Where branches cross, two further
equations say that the derivatives lose a rank, and one unknown unfolds the crossing: its value
is zero, within its error, where branches do cross.

References
----------
Y. A. Kuznetsov, Elements of Applied Bifurcation Theory (Springer, 2004), section 10.3.
A. Griewank and G. W. Reddien, SIAM Journal on Numerical Analysis 21 (1984) 176.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.orbits.curves import CurveEquations
from remanent.analysis.orbits.orbit_equations import (
    IDENTITY_SIGN_OF_KIND,
    central_differences,
    places_around,
    smallest_singular_values,
)

#: Newton steps at most.
_MAX_NEWTON_STEPS = 12
#: Newton's method has converged after a step shorter than this, in scaled unknowns.
_CONVERGED_STEP = 1e-9
#: It cannot do better where a step shorter than this is no shorter than half the one before it.
_STAGNATION_STEP = 1e-6
#: A crossing is none where the unknown that unfolds it is beyond this many times its error.
_MAX_UNFOLDING_OVER_ERROR = 30.0
#: Relative change of an entry of J by which a product of multipliers is differenced.
_RELATIVE_ENTRY_CHANGE = 1e-6
#: Rounding of a number, relative to it.
_ROUNDING = 4.0 * float(np.finfo(float).eps)


@dataclass(frozen=True)
class LocatedPoint:
    """A special point, located by itself.

    Attributes
    ----------
    unknown, error : array (n + 1,)
        State and parameter, and the estimated error of each.
    null_vector : array (n + 1,)
        Of scaled unknowns: at a fold the tangent, at a doubling the direction of the multiplier
        -1, where branches cross the direction in which the parameter stays.
    """

    unknown: FloatArray
    error: FloatArray
    null_vector: FloatArray


@dataclass(frozen=True)
class _System:
    """An extended system at one point, in scaled unknowns.

    Attributes
    ----------
    value, value_error : array (m,)
    derivative : array (m, m)
    null_vector : array (n + 1,)
    """

    value: FloatArray
    value_error: FloatArray
    derivative: FloatArray
    null_vector: FloatArray


@dataclass(frozen=True)
class _Sample:
    """The equations of the orbit around one point: see :func:`places_around`.

    Attributes
    ----------
    value : array (n,)
    value_error : float
    derivative, jacobian : array (2 (n + 1) + 1, ...)
    """

    value: FloatArray
    value_error: float
    derivative: FloatArray
    jacobian: FloatArray


def locate_special_points(
    equations: CurveEquations,
    kinds: Sequence[str],
    guesses: FloatArray,
    reach: FloatArray,
    scale: FloatArray,
    *,
    judging_equations: CurveEquations | None = None,
) -> list[LocatedPoint | None]:
    """Special points near guesses, each by Newton's method, all together.

    Parameters
    ----------
    equations : callable
        Of the orbits, as :func:`~remanent.analysis.orbits.orbit_equations.build_orbit_equations`
        makes them.
    kinds : sequence of str
        ``fold``, ``period doubling``, ``Neimark-Sacker`` or ``branch point``, of each.
    guesses : array (point, n + 1)
    reach : array (point,)
        How far from its guess a point may be, in scaled unknowns.
    scale : array (n + 1,)
        Units of the unknowns.
    judging_equations : callable, optional
        The same equations with a smaller error: what they make of the points found is the error
        of these, up to the smaller one.

    Returns
    -------
    list
        None where Newton's method found no such point within reach.
    """
    searches = [
        _Search(kind, guess, guess, within)
        for kind, guess, within in zip(kinds, guesses, reach, strict=True)
    ]
    for _ in range(_MAX_NEWTON_STEPS):
        active = [k for k, search in enumerate(searches) if search.is_active]
        if not active:
            break
        samples = _sample(equations, np.array([searches[k].unknown for k in active]), scale)
        for k, sample in zip(active, samples, strict=True):
            searches[k] = searches[k].after_step(sample, scale)
    ended = [k for k, search in enumerate(searches) if search.has_converged]
    if not ended:
        return [None] * len(searches)
    located: list[LocatedPoint | None] = [None] * len(searches)
    samples = _sample(
        judging_equations or equations, np.array([searches[k].unknown for k in ended]), scale
    )
    for k, sample in zip(ended, samples, strict=True):
        located[k] = searches[k].located(sample, scale)
    return located


def _sample(equations: CurveEquations, unknown: FloatArray, scale: FloatArray) -> list[_Sample]:
    """The equations around each of some points, by one call."""
    values = equations(places_around(unknown, scale))
    count, width = len(unknown), 2 * scale.size + 1
    derivative, jacobian = (
        values.extra_arrays[name].reshape(count, width, *values.extra_arrays[name].shape[1:])
        for name in ("derivative", "jacobian")
    )
    return [
        _Sample(values.value[k * width], float(values.value_error[k * width]), a, j)
        for k, (a, j) in enumerate(zip(derivative, jacobian, strict=True))
    ]


@dataclass(frozen=True)
class _Search:
    """Newton's method on its way to one special point."""

    kind: str
    guess: FloatArray
    unknown: FloatArray
    reach: float
    unfolding: float = 0.0
    last_step: float = np.inf
    is_active: bool = True
    has_converged: bool = False

    def after_step(self, sample: _Sample, scale: FloatArray) -> _Search:
        """One step further, or ended."""
        system = _extended_system(self.kind, sample, self.unfolding, scale)
        move = _solution(system.derivative, -system.value)
        step = float(np.linalg.norm(move[: scale.size]))
        unknown = self.unknown + move[: scale.size] * scale
        if not np.linalg.norm((unknown - self.guess) / scale) <= self.reach:
            return replace(self, is_active=False)
        stagnates = step < _STAGNATION_STEP and step > 0.5 * self.last_step
        converged = step < _CONVERGED_STEP or stagnates
        return replace(
            self,
            unknown=unknown,
            unfolding=self.unfolding + float(move[scale.size :].sum()),
            last_step=step,
            is_active=not converged,
            has_converged=converged,
        )

    def located(self, sample: _Sample, scale: FloatArray) -> LocatedPoint | None:
        """The point, with its error, unless it is none."""
        system = _extended_system(self.kind, sample, self.unfolding, scale)
        with np.errstate(all="ignore"):
            inverse = np.linalg.pinv(system.derivative)
            error = np.abs(inverse @ system.value) + np.abs(inverse) @ system.value_error
        if not np.isfinite(error).all():
            return None
        extra = error[scale.size :]
        if extra.size and abs(self.unfolding) > _MAX_UNFOLDING_OVER_ERROR * float(extra[0]):
            return None
        rounding = _ROUNDING * np.abs(self.unknown)
        return LocatedPoint(
            self.unknown, error[: scale.size] * scale + rounding, system.null_vector
        )


def _solution(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Of linear equations; NaN where they have none."""
    if not (np.isfinite(matrix).all() and np.isfinite(right).all()):
        return np.full(right.shape, np.nan)
    return np.asarray(np.linalg.lstsq(matrix, right, rcond=None)[0])


def _extended_system(kind: str, sample: _Sample, unfolding: float, scale: FloatArray) -> _System:
    """The equations of the orbit with those of a kind of special point."""
    if kind == "branch point":
        return _crossing_system(sample, unfolding, scale)
    jacobian = sample.jacobian[0]
    if kind in IDENTITY_SIGN_OF_KIND:
        sign = IDENTITY_SIGN_OF_KIND[kind]
        test, slope, weight = (
            part[0] for part in smallest_singular_values(sample.jacobian[None], sign, scale)
        )
        vector = _null_vectors(jacobian + sign * np.eye(len(jacobian)), 1)[0]
        null = np.concatenate([vector, np.zeros(scale.size - vector.size)]) / scale
    else:
        products = np.array([_pair_products(j) for j in sample.jacobian])
        test, slope = products[0], central_differences(products[None], scale)[0]
        weight, null = _entry_weight(jacobian), np.zeros(scale.size)
    derivative = np.concatenate([sample.derivative[0], slope[None]]) * scale
    if kind == "fold":
        null = _null_vectors(sample.derivative[0] * scale, 1)[0]
    test_error = float(weight) * sample.value_error * float(np.abs(jacobian).max())
    errors = np.append(np.full(sample.value.size, sample.value_error), test_error)
    length = float(np.linalg.norm(null))
    return _System(
        np.append(sample.value, test), errors, derivative, null / length if length else null
    )


def _crossing_system(sample: _Sample, unfolding: float, scale: FloatArray) -> _System:
    """Of a crossing of branches: f + b psi = 0, and the derivatives (A, psi; Phi, 0) lose a rank.

    The left solution (w, g) of that bordered matrix for the right-hand side (0, 1) vanishes in
    its two components g where A has two null vectors.
    """
    matrices = sample.derivative * scale
    left, _, right = np.linalg.svd(matrices[0])
    psi, border = left[:, -1], right[-2:]
    n, size = matrices[0].shape
    bordered = np.zeros((len(matrices), n + 2, n + 2))
    bordered[:, :n, :size], bordered[:, :n, -1], bordered[:, n:, :size] = matrices, psi, border
    unit = np.zeros(n + 2)
    unit[-1] = 1.0
    solved = np.linalg.solve(
        np.swapaxes(bordered, 1, 2), np.tile(unit[:, None], (len(matrices), 1, 1))
    )
    w, g = solved[0, :n, 0], solved[:, n:, 0]
    slope = central_differences(g[None], scale)[0]  # (unknown, 2)
    derivative = np.zeros((n + 2, n + 2))
    derivative[:n, :size], derivative[:n, -1] = matrices[0], psi
    derivative[n:, :size] = slope.T * scale
    jacobian = sample.jacobian[0]
    entry_error = sample.value_error * max(1.0, float(np.abs(jacobian).max()))
    g_error = np.abs(w).sum() * entry_error * np.abs(border * scale).sum(axis=1)
    value = np.concatenate([sample.value + unfolding * psi, g[0]])
    errors = np.concatenate([np.full(n, sample.value_error), g_error])
    # Of the plane of null vectors, the one along which the parameter stays.
    null = border[1, -1] * border[0] - border[0, -1] * border[1]
    return _System(value, errors, derivative, null / max(float(np.linalg.norm(null)), 1e-300))


def _null_vectors(matrix: FloatArray, count: int) -> FloatArray:
    """Right singular vectors of the smallest singular values, array (count, column)."""
    if not np.isfinite(matrix).all():  # of a motion without an image
        return np.full((count, len(matrix)), np.nan)
    return np.asarray(np.linalg.svd(matrix)[2][-count:])


def _pair_products(jacobian: FloatArray) -> float:
    """Product over all pairs of multipliers of (their product less one)."""
    values = np.linalg.eigvals(jacobian)
    factors = [values[i] * values[j] - 1.0 for i, j in combinations(range(values.size), 2)]
    return float(np.prod(factors).real) if factors else 1.0


def _entry_weight(jacobian: FloatArray) -> float:
    """By how much the product changes at most if every entry of J changes by one."""
    change = _RELATIVE_ENTRY_CHANGE * float(np.abs(jacobian).max())
    total = 0.0
    for index in np.ndindex(*jacobian.shape):
        moved = jacobian.copy()
        moved[index] += change
        total += abs(_pair_products(moved) - _pair_products(jacobian)) / change
    return total
