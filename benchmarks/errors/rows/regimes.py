"""Exponents, attractors and rotation numbers of long runs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import remanent as rm
from benchmarks.errors.batches import random_batch
from benchmarks.errors.long_run import long_run_exponent, rotation_number
from benchmarks.errors.row import Judged, Promise, Row

#: Cases of one call.
_CASES_PER_BATCH = 40
#: Periods of the runs.
_PERIODS = 200
#: Largest period of an orbit that is looked at.
_LONGEST_ORBIT = 8


def _orbit_exponents(rng: np.random.Generator) -> Iterator[Judged]:
    """Of damped motion from rest that settles: from the multipliers of heyoka's orbit."""
    batch = random_batch(rng, _CASES_PER_BATCH, damped=True, eta=(-1.5, 0.5))
    count = int(rng.integers(1, 3))
    found = rm.lyapunov(
        batch.system, batch.drive, periods=_PERIODS, count=count, over=batch.over,
        tolerance=batch.tolerance,
    )  # fmt: skip
    near = rm.poincare_section(
        batch.system, batch.drive, periods=_PERIODS, over=batch.over, tolerance=1e-6
    )
    for k in range(batch.count):
        one = found.isel(case=k)
        q = int(one.settled_period)
        if not 0 < q <= _LONGEST_ORBIT:
            continue
        start = [float(near[name][k, -1]) for name in ("stretch", "stretch_rate")]
        orbit = batch.reference(k).orbit(start, q)
        if orbit is None:
            continue
        length = q * float(one.drive_period)
        exact = np.sort(np.log(np.abs(orbit.multipliers)))[::-1] / length
        off = np.abs(np.atleast_1d(one.exponent.values) - exact[:count])
        errors = np.atleast_1d(one.exponent_error.values)
        for j in range(count):
            yield Judged(
                f"{batch.described(k)}, exponent {j} of {count}", batch.tolerance, True,
                float(errors[j]), float(off[j]), abs(float(exact[j])),
            )  # fmt: skip


def _mean_exponents(rng: np.random.Generator) -> Iterator[Judged]:
    """Of motion from rest that settles on no orbit: against a much longer run by heyoka."""
    damped = bool(rng.uniform() < 0.3)
    batch = random_batch(rng, _CASES_PER_BATCH, damped=damped, eta=(-3.0, -2.0), largest_b=1.5)
    periods = int(rng.integers(100, 400))
    found = rm.lyapunov(
        batch.system, batch.drive, periods=periods, over=batch.over, tolerance=batch.tolerance
    )
    for k in range(batch.count):
        one = found.isel(case=k)
        if int(one.settled_period) or int(one.status) != rm.Status.OK:
            continue
        exact = long_run_exponent(batch.reference(k))
        if exact is None:
            continue
        yield Judged(
            f"{batch.described(k)}, periods={periods}", batch.tolerance, damped,
            float(one.exponent_error), abs(float(one.exponent) - exact), abs(exact),
        )  # fmt: skip


def _attractor_states(rng: np.random.Generator) -> Iterator[Judged]:
    """Of the attractor that motion from rest ends on, by Newton's method on heyoka's map."""
    batch = random_batch(rng, _CASES_PER_BATCH, damped=True, eta=(-1.5, 0.5))
    found = rm.basins(
        batch.system, batch.drive, {"stretch": [1.0]}, periods=_PERIODS, over=batch.over,
        tolerance=batch.tolerance,
    )  # fmt: skip
    for k in range(batch.count if "attractor_state" in found else 0):
        one = found.isel(case=k, stretch=0, attractor=0)
        q = int(one.attractor_period)
        if not 0 < q <= _LONGEST_ORBIT:
            continue
        orbit = batch.reference(k).orbit(one.attractor_state.values, q)
        if orbit is None:
            continue
        off = float(np.abs(one.attractor_state.values - orbit.state).max())
        yield Judged(
            batch.described(k), batch.tolerance, True, float(one.attractor_state_error.max()), off
        )


def _rotation_numbers(rng: np.random.Generator) -> Iterator[Judged]:
    """Of undamped motion on a torus: against a much longer run by heyoka."""
    batch = random_batch(rng, _CASES_PER_BATCH, damped=False)
    found = rm.classify(
        batch.system, batch.drive, periods=int(rng.integers(100, 500)), over=batch.over,
        tolerance=batch.tolerance,
    )  # fmt: skip
    for k in range(batch.count):
        one = found.isel(case=k)
        if one.regime != "quasi-periodic" or not np.isfinite(one.rotation_number):
            continue
        exact = rotation_number(batch.reference(k))
        off = abs(float(one.rotation_number) - exact)
        yield Judged(
            batch.described(k), batch.tolerance, False, float(one.rotation_number_error),
            min(off, 1.0 - off),
        )  # fmt: skip


ROWS = (
    Row("exponents of motion that settles", "lyapunov: exponent_error", _orbit_exponents),
    Row("mean exponents", "lyapunov: exponent_error", _mean_exponents, Promise.STANDARD),
    Row("points of attractors", "basins: attractor_state_error", _attractor_states),
    Row("rotation numbers", "classify: rotation_number_error", _rotation_numbers),
)
