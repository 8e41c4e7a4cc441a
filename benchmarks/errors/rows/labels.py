"""Exponents beside the labels of regimes, of motion that settles on a periodic orbit."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import remanent as rm
from benchmarks.errors.batches import random_batch
from benchmarks.errors.row import Judged, Row

#: Cases of one call.
_CASES_PER_BATCH = 40
#: Periods of the runs.
_PERIODS = 200
#: Largest period of an orbit that is looked at.
_LONGEST_ORBIT = 8


def _exponents(rng: np.random.Generator) -> Iterator[Judged]:
    """Of damped motion from rest that is called periodic: by the multipliers of heyoka's orbit."""
    batch = random_batch(rng, _CASES_PER_BATCH, damped=True, eta=(-1.5, 0.5))
    found = rm.classify(
        batch.system, batch.drive, periods=_PERIODS, over=batch.over, tolerance=batch.tolerance
    )
    near = rm.poincare_section(
        batch.system, batch.drive, periods=_PERIODS, over=batch.over, tolerance=1e-6
    )
    for k in range(batch.count):
        one, q = found.isel(case=k), int(found.period[k])
        if one.regime != "periodic" or not 0 < q <= _LONGEST_ORBIT:
            continue
        start = [float(near[name][k, -1]) for name in ("stretch", "stretch_rate")]
        orbit = batch.reference(k).orbit(start, q)
        if orbit is None:
            continue
        exact = float(np.log(np.abs(orbit.multipliers).max())) / (q * float(one.drive_period))
        off, told = abs(float(one.exponent) - exact), float(one.exponent_error)
        yield Judged(batch.described(k), batch.tolerance, True, told, off, abs(exact))


ROWS = (Row("exponents of periodic motion", "classify: exponent_error", _exponents),)
