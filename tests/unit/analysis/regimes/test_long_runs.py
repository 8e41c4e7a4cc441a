"""Points and tangents followed over many periods: horizons, escapes, blocks."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from remanent._typing import FloatArray, IntArray
from remanent.analysis.regimes.long_runs import block_lengths_in_periods, propagate_tangents
from tests.unit.analysis.regimes.iterated import ExactImage, Iterated, logistic


@dataclass(frozen=True)
class Inexact:
    """A map whose every step adds an error, and which says so."""

    exact: Iterated
    error: float
    tolerance: float

    def __call__(
        self,
        which: IntArray,
        states: FloatArray,
        tangents: FloatArray,
        periods: int,
        *,
        every: bool,
    ) -> ExactImage:
        image = self.exact(which, states, tangents, periods, every=every)
        error = np.full(len(states), self.error)
        error[~(np.abs(image.visited_states) < 1e6).all(axis=(1, 2))] = np.inf
        return replace(image, largest_period_error=error, error_bound_met=error <= self.tolerance)


def doubling(x: FloatArray, _: FloatArray) -> tuple[FloatArray, FloatArray]:
    """x <- 2 x modulo 1."""
    return (2.0 * x) % 1.0, np.full((len(x), 1, 1), 2.0)


@pytest.mark.parametrize("error", [1e-6, 1e-9, 1e-12])
def test_the_horizon_is_where_the_error_becomes_too_large(error: float) -> None:
    """x <- 2x: errors e of each step add up to e (2^n - 1) after n; 0.01 is too large."""
    advance = Inexact(Iterated(doubling, np.ones((1, 1))), error, 1.0)
    path = propagate_tangents(advance, np.array([[0.1]]), 200, directions=1, block=1)
    assert path.horizon[0] == np.floor(np.log2(0.01 / error + 1.0))


def test_what_escapes_is_trusted_and_what_is_inaccurate_is_not() -> None:
    """r = 5 leaves the interval; r = 3.9 stays, but its error is larger than allowed."""
    exact = Iterated(logistic, np.array([[5.0], [3.9]]))
    start = np.array([[0.5], [0.5]])
    far = propagate_tangents(Inexact(exact, 1e-9, 1e-8), start, 100, directions=1, every=True)
    assert far.escaped.tolist() == [True, False]
    assert far.error_bound_met.tolist() == [True, True]
    assert far.completed_periods[1] == 100
    assert np.isnan(far.visited_states[0, -1, 0])  # type: ignore[index]
    bad = propagate_tangents(Inexact(exact, 1e-7, 1e-8), start[1:], 100, directions=1)
    assert (bad.error_bound_met.tolist(), bad.completed_periods.tolist()) == ([False], [0])


@pytest.mark.parametrize(
    ("periods", "directions", "longest"), [(1000, 1, 16), (1000, 2, 4), (40, 1, 1), (100, 2, 3)]
)
def test_blocks_make_up_the_run(periods: int, directions: int, longest: int) -> None:
    """They add up to the run, are equal but for the last, and are at least 32 in number."""
    lengths = block_lengths_in_periods(periods, directions)
    assert lengths.sum() == periods
    assert (lengths[:-1] == longest).all()
    assert lengths.size >= 32
