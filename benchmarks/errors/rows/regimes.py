"""Exponents, attractors and rotation numbers of long runs."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import remanent as rm
from benchmarks.errors.batches import Batch, random_batch
from benchmarks.errors.long_run import long_run_exponents, rotation_numbers
from benchmarks.errors.row import Judged, Promise, Row

#: Cases of one call.
_CASES_PER_BATCH = 40
#: Periods of the runs.
_PERIODS = 200
#: Largest period of an orbit that is looked at.
_LONGEST_ORBIT = 8
#: Exponent per tau above which motion is chaotic: of orbits that are weakly damped it is below 0.
_LEAST_OF_CHAOS = 1e-3
#: Loads that often make it so.
_B_OF_CHAOS = (1.0, 3.0)


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


def _regular_exponents(rng: np.random.Generator) -> Iterator[Judged]:
    """Of regular motion from rest that has not settled: 0, or that of a much longer run."""
    damped = bool(rng.uniform() < 0.3)
    batch = random_batch(rng, _CASES_PER_BATCH, damped=damped, eta=(-3.0, -2.0), b=(0.1, 1.5))
    return (one for one, exact in _mean_exponents(rng, batch) if exact <= _LEAST_OF_CHAOS)


def _chaotic_exponents(rng: np.random.Generator) -> Iterator[Judged]:
    """Of chaotic motion from rest: against a much longer run by heyoka."""
    batch = random_batch(rng, _CASES_PER_BATCH, damped=False, b=_B_OF_CHAOS)
    return (one for one, exact in _mean_exponents(rng, batch) if exact > _LEAST_OF_CHAOS)


def _mean_exponents(rng: np.random.Generator, batch: Batch) -> Iterator[tuple[Judged, float]]:
    """Of motion that ends on no orbit, with what a much longer run says."""
    periods = int(rng.integers(100, 400))
    found = rm.lyapunov(
        batch.system, batch.drive, periods=periods, over=batch.over, tolerance=batch.tolerance
    )
    is_mean = (found.settled_period.values == 0) & (found.status.values == rm.Status.OK)
    means = np.flatnonzero(is_mean)
    exponents = long_run_exponents([batch.reference(k) for k in means])
    for k, exact in zip(means, exponents, strict=True):
        one = found.isel(case=k)
        if np.isfinite(exact):
            yield Judged(
                f"{batch.described(k)}, periods={periods}", batch.tolerance, batch.damped,
                float(one.exponent_error), abs(float(one.exponent) - exact), abs(exact),
            ), exact  # fmt: skip


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
    on_tori = (found.regime.values == "quasi-periodic") & np.isfinite(found.rotation_number.values)
    turning = np.flatnonzero(on_tori)
    numbers = rotation_numbers([batch.reference(k) for k in turning])
    for k, exact in zip(turning, numbers, strict=True):
        one = found.isel(case=k)
        off = abs(float(one.rotation_number) - exact)
        yield Judged(
            batch.described(k), batch.tolerance, False, float(one.rotation_number_error),
            min(off, 1.0 - off),
        )  # fmt: skip


ROWS = (
    Row("exponents of motion that settles", "lyapunov: exponent_error", _orbit_exponents),
    Row("exponents of regular motion", "lyapunov: exponent_error", _regular_exponents),
    Row(
        "exponents of chaotic motion",
        "lyapunov: exponent_error",
        _chaotic_exponents,
        Promise.STANDARD,
    ),
    Row("points of attractors", "basins: attractor_state_error", _attractor_states),
    Row("rotation numbers", "classify: rotation_number_error", _rotation_numbers),
)
