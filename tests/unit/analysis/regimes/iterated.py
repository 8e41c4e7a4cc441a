"""Maps with tangents, to be followed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.long_runs import LongRun, propagate_tangents

#: (state (point, d), parameters (point, p)) to image and Jacobian (point, d, d).
Step = Callable[[FloatArray, FloatArray], tuple[FloatArray, FloatArray]]


@dataclass(frozen=True)
class ExactImage:
    """Points and tangents after some steps of a map; rounding counts as no error."""

    visited_states: FloatArray
    tangents: FloatArray
    largest_period_error: FloatArray
    error_bound_met: BoolArray


@dataclass(frozen=True)
class Iterated:
    """Follows points of a map that differ in their parameters."""

    step: Step
    parameters: FloatArray

    def __call__(
        self,
        which: IntArray,
        states: FloatArray,
        tangents: FloatArray,
        periods: int,
        *,
        every: bool,
    ) -> ExactImage:
        seen = np.empty((len(states), periods, states.shape[1]))
        with np.errstate(all="ignore"):
            for n in range(periods):
                states, jacobian = self.step(states, self.parameters[which])
                tangents = np.einsum("pij,pkj->pki", jacobian, tangents)
                seen[:, n] = states
        count = len(states)
        visited = seen if every else seen[:, -1:]
        return ExactImage(visited, tangents, np.zeros(count), np.ones(count, dtype=np.bool_))

    def iterate(
        self, which: IntArray, states: FloatArray, periods: int
    ) -> tuple[FloatArray, FloatArray]:
        """Image and Jacobian after a number of steps."""
        unit = np.tile(np.eye(states.shape[1]), (len(states), 1, 1))
        image = self(which, states, unit, periods, every=False)
        return image.visited_states[:, -1], np.moveaxis(image.tangents, 1, 2)


def logistic(x: FloatArray, r: FloatArray) -> tuple[FloatArray, FloatArray]:
    """x <- r x (1 - x)."""
    return r * x * (1.0 - x), (r * (1.0 - 2.0 * x))[:, :, None]


def standard(y: FloatArray, k: FloatArray) -> tuple[FloatArray, FloatArray]:
    """v <- v + K sin x, x <- x + v, both modulo 2 pi."""
    x, v = y.T
    slope = k[:, 0] * np.cos(x)
    v = v + k[:, 0] * np.sin(x)
    one = np.ones_like(x)
    jacobian = np.stack([np.stack([1.0 + slope, one], 1), np.stack([slope, one], 1)], 1)
    return np.column_stack([x + v, v]) % (2.0 * np.pi), jacobian


def henon(y: FloatArray, p: FloatArray) -> tuple[FloatArray, FloatArray]:
    """x <- 1 - a x^2 + v, v <- b x."""
    x, v = y.T
    a, b = p.T
    jacobian = np.stack(
        [np.stack([-2.0 * a * x, np.ones_like(x)], 1), np.stack([b, 0.0 * x], 1)], 1
    )
    return np.column_stack([1.0 - a * x * x + v, b * x]), jacobian


def rolled(y: FloatArray) -> FloatArray:
    """Cosine and sine of both coordinates of a torus."""
    return np.concatenate([np.cos(y), np.sin(y)], axis=-1)


def run(
    step: Step, y0: FloatArray, par: FloatArray, periods: int, *, every: bool = False
) -> LongRun:
    """A point of a map with all its tangents; or several, one parameter each."""
    start, advance = np.atleast_2d(y0), Iterated(step, np.atleast_2d(par))
    return propagate_tangents(advance, start, periods, directions=start.shape[1], every=every)
