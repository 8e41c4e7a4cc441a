"""Frequencies of free oscillations, against the return to rest of heyoka's motion."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import remanent as rm
from benchmarks.errors.period_map import CONVERGED, LONG, MAX_NEWTON_STEPS, PeriodMap
from benchmarks.errors.row import Judged, Row, shared
from benchmarks.errors.special_points import at

#: Decades of tolerance that are asked for.
TOLERANCES = (-11.0, -3.0)
#: Oscillations of one actuator.
OSCILLATIONS = 20
#: Relative difference of the two frequencies with which the search begins.
FIRST_DIFFERENCE = 1e-6


@shared
def _oscillations(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """Free oscillations of one random actuator under a random constant load: what, and how."""
    values = {
        "c": 10.0 ** rng.uniform(-1.0, 0.0),
        "temperature": 293.0 * rng.uniform(0.8, 1.3),
        "prestress": rng.uniform(-0.5, 1.0),
        "m": 0.0,
        "mean": rng.uniform(-1.0, 1.0),
    }
    body = rm.Actuator(
        c=values["c"], temperature=values["temperature"], prestress=values["prestress"]
    )
    stretches = np.sort(rng.uniform(0.7, 3.0, OSCILLATIONS))
    tolerance = 10.0 ** rng.uniform(*TOLERANCES)
    found = rm.backbone(body, stretches, m=values["mean"], tolerance=tolerance)
    motion = PeriodMap(rm.Sine(0.0, 1.0, mean=values["mean"]), values)
    for k, stretch in enumerate(stretches):
        one = found.isel({"initial.stretch": k})
        frequency = return_frequency(motion, float(stretch), float(one.frequency))
        if frequency is None:
            continue
        low, high = at(motion, "omega", frequency).extremes([LONG(stretch), LONG(0)], 1)
        exact = {"frequency": frequency, "amplitude": (high - low) / 2}
        case = f"{body!r}, stretch {stretch}, m {values['mean']}"
        for name, number in exact.items():
            off = float(abs(float(one[name]) - number))
            error = float(one[f"{name}_error"])
            yield name, Judged(case, tolerance, False, error, off, float(number))


def return_frequency(motion: PeriodMap, stretch: Any, near: float) -> Any:
    """The frequency at which the block is at rest again after one period, by secants."""
    if not np.isfinite(near):
        return None

    def rate(frequency: Any) -> Any:
        return at(motion, "omega", frequency).image([stretch, 0.0], 1)[0][1]

    one, two = np.longdouble(near), np.longdouble(near * (1.0 + FIRST_DIFFERENCE))
    at_one, at_two = rate(one), rate(two)
    for _ in range(MAX_NEWTON_STEPS):
        if at_two == at_one or not np.isfinite(float(at_two)):
            return None
        one, two, at_one = two, two - at_two * (two - one) / (at_two - at_one), at_two
        if abs(float(two - one)) < CONVERGED:
            return two
        at_two = rate(two)
    return None


def _of(name: str) -> Callable[[np.random.Generator], Iterator[Judged]]:
    return lambda rng: (judged for what, judged in _oscillations(rng) if what == name)


ROWS = (
    Row("frequencies of free oscillations", "backbone: frequency_error", _of("frequency")),
    Row("amplitudes of free oscillations", "backbone: amplitude_error", _of("amplitude")),
)
