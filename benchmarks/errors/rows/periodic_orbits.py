"""Positions, multipliers and extremes of periodic orbits, against Newton on heyoka's map."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.errors.period_map import Orbit, PeriodMap
from benchmarks.errors.row import Judged, Row

#: Decades of tolerance that are asked for.
TOLERANCES = (-11.0, -3.0)
#: Random actuators in a batch: they share tolerance, period and kind of damping.
ACTUATORS = 12
#: Orbits of one actuator that are judged at most: tori that nearly close list many.
MAX_ORBITS = 4
#: Periods of the orbits, each as often as it stands there: few damped ones are longer than one.
DAMPED_PERIODS = (1, 1, 1, 1, 1, 1, 2, 3)
UNDAMPED_PERIODS = (1, 1, 2, 3, 5)


def _position(rng: np.random.Generator) -> Iterator[Judged]:
    for case, tolerance, damped, one, exact, _ in _orbits(int(rng.integers(2**62))):
        position = float(np.abs(one.initial.values - exact.state).max())
        yield Judged(case, tolerance, damped, float(one.error), position)


def _multipliers(rng: np.random.Generator) -> Iterator[Judged]:
    for case, tolerance, damped, one, exact, _ in _orbits(int(rng.integers(2**62))):
        pairs = np.abs(one.multipliers.values[:, None] - exact.multipliers)
        off = float(min(max(pairs[0, 0], pairs[1, 1]), max(pairs[0, 1], pairs[1, 0])))
        size = float(np.abs(exact.multipliers).max())
        reported = float(one.multipliers_error.values.max())
        yield Judged(case, tolerance, damped, reported, off, size)


def _extremes(rng: np.random.Generator) -> Iterator[Judged]:
    for case, tolerance, damped, one, _, extremes in _orbits(int(rng.integers(2**62))):
        low, high = extremes
        numbers = {"minimum": low, "maximum": high, "amplitude": 0.5 * (high - low)}
        for name, value in numbers.items():
            off = abs(float(one[name]) - value)
            yield Judged(
                f"{case}, {name}", tolerance, damped, float(one[f"{name}_error"]), off, value
            )


@cache
def _orbits(
    seed: int,
) -> list[tuple[str, float, bool, xr.Dataset, Orbit, tuple[float, float]]]:
    """Orbits of some random actuators, each with the exact one and its extremes."""
    rng = np.random.default_rng(seed)
    damped = bool(rng.uniform() < 0.5)
    values = {
        "c": 10.0 ** rng.uniform(-1.0, 0.0, ACTUATORS),
        "temperature": 293.0 * rng.uniform(0.8, 1.3, ACTUATORS),
        "prestress": rng.uniform(-0.5, 1.0, ACTUATORS),
        "b": rng.uniform(0.1, 1.0, ACTUATORS),
        "omega": rng.uniform(0.5, 2.5, ACTUATORS),
    }
    if damped:
        values["dissipation.0.eta"] = 10.0 ** rng.uniform(-2.0, 0.0, ACTUATORS)
    periods = int(rng.choice(DAMPED_PERIODS if damped else UNDAMPED_PERIODS))
    tolerance = 10.0 ** rng.uniform(*TOLERANCES)
    body = rm.Actuator(dissipation=rm.Rayleigh(0.1) if damped else ())
    drive = rm.SineSquared(0.4, 1.0)
    over = {name: xr.DataArray(column, dims="actuator") for name, column in values.items()}
    found = rm.periodic_orbits(body, drive, orbit_period=periods, tolerance=tolerance, over=over)
    judged = []
    for a in range(ACTUATORS):
        own = {name: float(column[a]) for name, column in values.items()}
        reference = PeriodMap(drive, {"dissipation.0.eta": 0.0} | own)
        for k in range(min(int(found.orbits[a]), MAX_ORBITS)):
            one = found.isel(actuator=a, orbit=k)
            exact = reference.orbit(one.initial.values, periods)
            if exact is not None:
                case = f"{own!r}, orbit_period={periods}, orbit {k}"
                extremes = reference.extremes(exact.state, periods)
                judged.append((case, tolerance, damped, one, exact, extremes))
    return judged


ROWS = (
    Row("positions of periodic orbits", "periodic_orbits: error", _position),
    Row("multipliers of periodic orbits", "periodic_orbits: multipliers_error", _multipliers),
    Row(
        "extremes of periodic orbits",
        "periodic_orbits: maximum_error, minimum_error, amplitude_error",
        _extremes,
    ),
)
