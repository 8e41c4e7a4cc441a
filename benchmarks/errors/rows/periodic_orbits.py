"""Positions and multipliers of periodic orbits, against Newton's method on heyoka's map."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import remanent as rm
from benchmarks.errors.period_map import PeriodMap
from benchmarks.errors.row import Judged, Row

#: Decades of tolerance that are asked for.
TOLERANCES = (-11.0, -3.0)


def _position(rng: np.random.Generator) -> Iterator[Judged]:
    for judged, _ in _orbits(rng):
        yield judged


def _multipliers(rng: np.random.Generator) -> Iterator[Judged]:
    for _, judged in _orbits(rng):
        yield judged


def _orbits(rng: np.random.Generator) -> Iterator[tuple[Judged, Judged]]:
    """Every orbit of one random actuator: its position and its multipliers."""
    damped = bool(rng.uniform() < 0.5)
    values = {
        "c": 10.0 ** rng.uniform(-1.0, 0.0),
        "temperature": 293.0 * rng.uniform(0.8, 1.3),
        "prestress": rng.uniform(-0.5, 1.0),
        "b": rng.uniform(0.1, 1.0),
        "omega": rng.uniform(0.5, 2.5),
    }
    eta = 10.0 ** rng.uniform(-2.0, 0.0) if damped else 0.0
    periods = int(rng.integers(1, 4))
    tolerance = 10.0 ** rng.uniform(*TOLERANCES)
    body = rm.Actuator(
        c=values["c"], temperature=values["temperature"], prestress=values["prestress"],
        dissipation=rm.Rayleigh(eta) if damped else (),
    )  # fmt: skip
    drive = rm.SineSquared(values["b"], values["omega"])
    found = rm.periodic_orbits(body, drive, orbit_period=periods, tolerance=tolerance)
    reference = PeriodMap(drive, values | {"dissipation.0.eta": eta})
    for k in range(found.sizes["orbit"]):
        one = found.isel(orbit=k)
        exact = reference.orbit(one.initial.values, periods)
        if exact is None:
            continue
        position = float(np.abs(one.initial.values - exact.state).max())
        pairs = np.abs(one.multipliers.values[:, None] - exact.multipliers)
        off = float(min(max(pairs[0, 0], pairs[1, 1]), max(pairs[0, 1], pairs[1, 0])))
        case = f"{body!r}, {drive!r}, orbit_period={periods}, orbit {k}"
        size = float(np.abs(exact.multipliers).max())
        yield (
            Judged(case, tolerance, damped, float(one.error), position),
            Judged(case, tolerance, damped, float(one.multipliers_error.max()), off, size),
        )


ROWS = (
    Row("positions of periodic orbits", "periodic_orbits: error", _position),
    Row("multipliers of periodic orbits", "periodic_orbits: multipliers_error", _multipliers),
)
