"""Amplitudes and resonances of forced response, against heyoka with events."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import remanent as rm
from benchmarks.errors.row import Judged, Row, shared

#: Decades of tolerance that are asked for.
TOLERANCES = (-11.0, -3.0)
#: Length of each run.
DURATION = 40.0
#: Relative error of a step of the reference.
PRECISION = 1e-19
#: Steps of the secant method for the place of a maximum, and what ends it, over the width asked.
MAX_STEPS = 60
ENOUGH = 1e-5
#: First step uphill to it, over that width, and the largest.
FIRST_STEP = 1e-3
LARGEST_STEP = 1e-2
LONG = np.longdouble


@dataclass(frozen=True)
class Excursion:
    """Half the difference of the extremes of a run, and its derivative by the frequency."""

    amplitude: float
    slope: float


@cache
def _engine() -> Any:
    """The block under the square of a sine, with derivatives by omega and all turning points."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    c, theta, prestress, eta, b, omega = (hy.par[k] for k in range(6))
    sine = b * hy.sin(omega * hy.time)
    x2 = x * x
    x4, x7 = x2 * x2, x2 * x2 * x2 * x
    force = theta * (x4 * x4 - x2) - prestress * x7 + sine * sine * x4 + eta * v * x7
    rate = (6.0 * c * v * v - 3.0 * force) / (x7 + 2.0 * c * x)
    system = hy.var_ode_sys([(x, v), (v, rate)], [omega], order=1)
    found: list[tuple[Any, Any]] = []

    def turned(engine: Any, time: Any, _: int) -> None:
        engine.update_d_output(time)
        found.append((engine.d_output[0], engine.d_output[2]))

    turn = hy.nt_event(hy.make_vars("v"), turned, fp_type=LONG)
    engine = hy.taylor_adaptive(
        system, np.array([1, 0], dtype=LONG), fp_type=LONG, tol=LONG(PRECISION), nt_events=[turn]
    )
    return engine, found


def excursion(values: dict[str, float], omega: float) -> Excursion | None:
    """Of the thickness stretch in a run from rest; None where the motion is lost."""
    engine, found = _engine()
    found.clear()
    engine.time = LONG(0)
    engine.state[:] = [1, 0, 0, 0]
    engine.pars[:] = [
        values["c"], LONG(values["temperature"]) / 293, values["prestress"], values["eta"],
        values["b"], omega,
    ]  # fmt: skip
    outcome = engine.propagate_until(LONG(DURATION), max_steps=1_000_000)
    if "time_limit" not in str(outcome[0]) or not engine.state[0] > 0:
        return None
    ends = [(LONG(1), LONG(0)), (engine.state[0], engine.state[2])]
    points = np.array([*ends, *found], dtype=LONG)
    thickness = points[:, 0] ** -2
    slopes = -2 * points[:, 0] ** -3 * points[:, 1]
    high, low = np.argmax(thickness), np.argmin(thickness)
    amplitude = (thickness[high] - thickness[low]) / 2
    return Excursion(float(amplitude), float((slopes[high] - slopes[low]) / 2))


def _values(rng: np.random.Generator) -> dict[str, float]:
    damped = rng.uniform() < 0.5
    return {
        "c": 10.0 ** rng.uniform(-1.0, 0.0),
        "temperature": 293.0 * rng.uniform(0.8, 1.3),
        "prestress": rng.uniform(-0.5, 0.5),
        "eta": 10.0 ** rng.uniform(-2.0, 0.0) if damped else 0.0,
        "b": rng.uniform(0.05, 0.6),
    }


def _response(values: dict[str, float], omega: Any, **options: Any) -> Any:
    body = rm.Actuator(
        c=values["c"], temperature=values["temperature"], prestress=values["prestress"],
        dissipation=rm.Rayleigh(values["eta"]),
    )  # fmt: skip
    return rm.frequency_response(
        body, rm.SineSquared(values["b"], 1.0), omega, duration=DURATION, **options
    )


def _amplitude(rng: np.random.Generator) -> Iterator[Judged]:
    """Amplitudes of one random actuator at some frequencies."""
    values, tolerance = _values(rng), 10.0 ** rng.uniform(*TOLERANCES)
    omega = np.sort(rng.uniform(0.3, 2.5, 8))
    ds = _response(values, omega, tolerance=tolerance)
    for k, w in enumerate(omega):
        exact = excursion(values, float(w))
        if exact is None or not np.isfinite(ds.amplitude[k]):
            continue
        true = abs(float(ds.amplitude[k]) - exact.amplitude)
        case = f"{values}, omega={w!r}"
        yield Judged(case, tolerance, values["eta"] > 0.0, float(ds.amplitude_error[k]), true)


def _true_maximum(values: dict[str, float], found: float, width: float) -> float | None:
    """The frequency of the maximum to which the amplitude rises from a given one.

    A root of the slope, or the place of a jump: steps uphill that double until the amplitude no
    longer rises, then the secant method and halves.
    """
    start = excursion(values, found)
    if start is None:
        return None
    uphill = 1.0 if start.slope > 0.0 else -1.0
    low, first, step = found, start, FIRST_STEP * width
    while True:
        high = found + uphill * step
        second = excursion(values, high)
        if second is None or step > LARGEST_STEP:
            return None
        if second.slope * uphill <= 0.0 or second.amplitude < first.amplitude:
            break
        low, first, step = high, second, 2.0 * step
    for k in range(MAX_STEPS):
        middle = 0.5 * (low + high)
        if k % 3 < 2 and first.slope * second.slope < 0.0:
            middle = low + (high - low) * first.slope / (first.slope - second.slope)
        new = excursion(values, middle)
        if new is None:
            return None
        if abs(high - low) < ENOUGH * width or new.slope == 0.0:
            return middle
        if new.slope * uphill > 0.0 and new.amplitude >= first.amplitude:
            low, first = middle, new
        else:
            high, second = middle, new
    return 0.5 * (low + high)


@shared
def _resonance(
    rng: np.random.Generator, width: float, decades: tuple[float, float]
) -> Iterator[tuple[str, Judged]]:
    """The resonance of one random actuator, near its natural frequency: place and amplitude."""
    values, tolerance = _values(rng), 10.0 ** rng.uniform(*decades)
    body = rm.Actuator(
        c=values["c"], temperature=values["temperature"], prestress=values["prestress"]
    )
    rest = rm.equilibria(body, 0.5 * values["b"] ** 2)
    natural = float(rest.natural_frequency[0])
    if not np.isfinite(natural):
        return
    omega = np.linspace(0.3, 0.7, 41) * natural
    ds = _response(values, omega, tolerance=tolerance, resonance_width=width)
    if int(ds.resonance_status) != rm.Status.OK:
        return
    found, damped = float(ds.resonance), values["eta"] > 0.0
    exact = _true_maximum(values, found, width)
    there = None if exact is None else excursion(values, exact)
    if exact is not None and there is not None:
        case = f"{values}, resonance_width={width}"
        off, size = abs(float(ds.resonance_amplitude) - there.amplitude), there.amplitude
        yield (
            "place",
            Judged(case, tolerance, damped, float(ds.resonance_error), abs(found - exact)),
        )
        yield (
            "amplitude",
            Judged(case, tolerance, damped, float(ds.resonance_amplitude_error), off, size),
        )


def _resonance_of(
    what: str, width: float, decades: tuple[float, float]
) -> Callable[[np.random.Generator], Iterator[Judged]]:
    return lambda rng: (judged for name, judged in _resonance(rng, width, decades) if name == what)


ROWS = (
    Row("amplitudes of forced response", "frequency_response: amplitude_error", _amplitude),
    Row(
        "resonances of forced response",
        "frequency_response: resonance_error",
        _resonance_of("place", 1e-6, TOLERANCES),
    ),
    Row(
        "amplitudes at resonances of forced response",
        "frequency_response: resonance_amplitude_error",
        _resonance_of("amplitude", 1e-6, TOLERANCES),
    ),
    Row(
        "narrow brackets of resonances",
        "frequency_response: resonance_error",
        _resonance_of("place", 1e-9, TOLERANCES),
    ),
)
