"""Fractions of initial states that end on an attractor, against many more initial states."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.errors.row import Judged, Promise, Row

#: A block with two stable equilibria, and a small load that keeps it near one of them.
_BODY = rm.Actuator(prestress=2.2, c=0.2, dissipation=rm.Rayleigh(0.5))
_DRIVE = rm.Sine(0.02, 3.0, mean=2.3)
#: Stretches from which motions start, at rest.
_STRETCHES = (0.6, 2.4)
#: Length of the runs.
_PERIODS = 120
#: Initial states that tell the true fractions.
_TRUE_COUNT = 4000
#: Calls of one batch.
_CALLS = 10
_TOLERANCE = 1e-6


def _basins(stretches: np.ndarray) -> xr.Dataset:
    """Where motions at rest from some stretches end."""
    grid = {"stretch": np.sort(stretches), "stretch_rate": np.zeros(1)}
    return rm.basins(_BODY, _DRIVE, grid, periods=_PERIODS, tolerance=_TOLERANCE)


@cache
def _truth() -> list[tuple[np.ndarray, float]]:
    """A point of each attractor, and the fraction of a fine grid that ends there."""
    found = _basins(np.linspace(*_STRETCHES, _TRUE_COUNT))
    return [
        (found.attractor_state.values[k], float(found.fraction[k]))
        for k in range(found.sizes["attractor"])
    ]


def _fractions(rng: np.random.Generator) -> Iterator[Judged]:
    """Of few initial states drawn at random."""
    for _ in range(_CALLS):
        stretches = rng.uniform(*_STRETCHES, int(rng.integers(2, 40)))
        found = _basins(stretches)
        for point, exact in _truth()[:1]:  # the other fraction is what this one leaves
            distance = np.abs(found.attractor_state.values - point).max(axis=1)
            k = int(distance.argmin())
            if distance[k] < 1e-3:
                off, told = abs(float(found.fraction[k]) - exact), float(found.fraction_error[k])
                yield Judged(f"{stretches.tolist()}", _TOLERANCE, True, told, off)


ROWS = (Row("fractions of basins", "basins: fraction_error", _fractions, Promise.STANDARD),)
