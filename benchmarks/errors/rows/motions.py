"""Crossings, energies and losses of single motions, against heyoka in extended precision."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import remanent as rm
from benchmarks.errors.batches import Batch, random_batch
from benchmarks.errors.motion import Motion
from benchmarks.errors.row import Judged, Row, shared

#: Cases of one call.
_CASES_PER_BATCH = 20
#: Length of the runs, tau.
_DURATION = 30.0
#: Crossings of one case that are judged.
_CROSSINGS_PER_CASE = 4


def _crossing_times(rng: np.random.Generator) -> Iterator[Judged]:
    for judged, _ in _crossings(rng):
        yield judged


def _crossing_states(rng: np.random.Generator) -> Iterator[Judged]:
    for _, judged in _crossings(rng):
        yield judged


@shared
def _crossings(rng: np.random.Generator) -> Iterator[tuple[Judged, Judged]]:
    """Of the stretch, at a value near rest."""
    batch = random_batch(rng, _CASES_PER_BATCH)
    value = float(rng.uniform(0.9, 1.1))
    found = rm.crossings(
        batch.system, batch.drive, "stretch", value, duration=_DURATION, over=batch.over,
        tolerance=batch.tolerance,
    )  # fmt: skip
    for k in range(batch.count):
        one = found.isel(case=k)
        count = min(int(one.crossings), _CROSSINGS_PER_CASE)
        one = one.isel(crossing=np.linspace(0, max(int(one.crossings) - 1, 0), count).astype(int))
        times, states = Motion(batch.reference(k)).passages(one.crossing_time.values, value)
        for j in range(count):
            here = one.isel(crossing=j)
            if int(here.direction) == 0:
                continue  # a touch: Newton's method for a passage does not judge it
            case = f"{batch.described(k)}, value={value!r}, crossing {j}"
            off = float(abs(float(here.crossing_time) - times[j]))
            seen = np.array([float(here.stretch), float(here.stretch_rate)])
            apart = float(np.abs(seen - states[j]).max())
            yield (
                _judged(case, batch, float(here.crossing_time_error), off, _DURATION),
                _judged(case, batch, float(here.state_error), apart),
            )


def _judged(case: str, batch: Batch, reported: float, true: float, scale: float = 1.0) -> Judged:
    return Judged(case, batch.tolerance, batch.damped, reported, true, scale)


def _energies(rng: np.random.Generator) -> Iterator[Judged]:
    """The largest error of each column of a balance over its times."""
    batch = random_batch(rng, _CASES_PER_BATCH)
    times = np.linspace(0.0, _DURATION, 16)
    found = rm.energy_balance(
        batch.system, batch.drive, times=times, over=batch.over, tolerance=batch.tolerance
    )
    for k in range(batch.count):
        one, motion = found.isel(case=k), Motion(batch.reference(k))
        if int(one.status) != rm.Status.OK:
            continue
        exact = motion.states(times)
        with np.errstate(invalid="ignore", divide="ignore"):
            mean = np.where(times > 0.0, exact[:, 4] / times, 1.0)
        columns = {
            "drive_work": exact[:, 2], "dissipated_energy": exact[:, 3],
            "mean_thickness_stretch": mean, "stored_energy": motion.stored_energy(exact),
            "balance": 0.0,
        }  # fmt: skip
        for name, values in columns.items():
            if name == "dissipated_energy" and not batch.damped:
                continue  # exactly 0
            off = float(np.abs(one[name].values - values).max())
            case = f"{batch.described(k)}, {name}"
            size = float(np.abs(values).max())
            yield _judged(case, batch, float(one[f"{name}_error"]), off, size)


def _losses(rng: np.random.Generator) -> Iterator[Judged]:
    """The largest error of the work, and of the losses, of each drive period."""
    batch = random_batch(rng, _CASES_PER_BATCH, damped=True)
    periods = int(rng.integers(2, 16))
    found = rm.cycle_losses(
        batch.system, batch.drive, periods=periods, over=batch.over, tolerance=batch.tolerance
    )
    for k in range(batch.count):
        one, reference = found.isel(case=k), batch.reference(k)
        if int(one.status) != rm.Status.OK:
            continue
        sums = Motion(reference).states(np.arange(periods + 1) * reference.period)
        for name, column in (("drive_work", 2), ("dissipated_energy", 3)):
            off = float(np.abs(one[name].values - np.diff(sums[:, column])).max())
            case = f"{batch.described(k)}, periods={periods}, {name}"
            yield _judged(case, batch, float(one[f"{name}_error"]), off)


def _transverse_exponents(rng: np.random.Generator) -> Iterator[Judged]:
    for judged, _ in _transverse(rng):
        yield judged


def _transverse_multipliers(rng: np.random.Generator) -> Iterator[Judged]:
    for _, judged in _transverse(rng):
        yield judged


@shared
def _transverse(rng: np.random.Generator) -> Iterator[tuple[Judged, Judged]]:
    """Of damped motion from rest that settles: exponents and multipliers over heyoka's orbit."""
    batch = random_batch(rng, _CASES_PER_BATCH, damped=True, eta=(-1.5, 0.3))
    found = rm.symmetry_check(
        batch.system, batch.drive, periods=200, over=batch.over, tolerance=batch.tolerance
    )
    near = rm.poincare_section(
        batch.system, batch.drive, periods=200, over=batch.over, tolerance=1e-6
    )
    for k in range(batch.count):
        one, reference = found.isel(case=k), batch.reference(k)
        q = int(one.settled_period)
        if not q:
            continue
        start = [float(near[name][k, -1]) for name in ("stretch", "stretch_rate")]
        orbit = reference.orbit(start, q)
        if orbit is None:
            continue
        jacobian = Motion(reference, tuple(orbit.state)).transverse_jacobian(q).astype(float)
        multipliers = np.linalg.eigvals(jacobian)
        exact = np.log(np.abs(multipliers).max()) / (q * float(one.drive_period))
        off = abs(float(one.transverse_exponent) - exact)
        pairs = np.abs(one.transverse_multipliers.values[:, None] - multipliers)
        apart = float(min(max(pairs[0, 0], pairs[1, 1]), max(pairs[0, 1], pairs[1, 0])))
        reported = float(one.transverse_multipliers_error.values.max())
        case = batch.described(k)
        yield (
            _judged(case, batch, float(one.transverse_exponent_error), off),
            _judged(case, batch, reported, apart),
        )


ROWS = (
    Row("times of crossings", "crossings: crossing_time_error", _crossing_times),
    Row("states at crossings", "crossings: state_error", _crossing_states),
    Row(
        "energies and works",
        "energy_balance: drive_work_error, dissipated_energy_error, "
        "mean_thickness_stretch_error, stored_energy_error, balance_error",
        _energies,
    ),
    Row(
        "losses of a period",
        "cycle_losses: drive_work_error, dissipated_energy_error",
        _losses,
    ),
    Row("transverse exponents", "symmetry_check: transverse_exponent_error", _transverse_exponents),
    Row(
        "transverse multipliers",
        "symmetry_check: transverse_multipliers_error",
        _transverse_multipliers,
    ),
)
