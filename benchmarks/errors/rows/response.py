"""Amplitudes and resonances of forced response, against heyoka with events."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import xarray as xr
from scipy.optimize import brentq

import remanent as rm
from benchmarks.errors.batches import CASE
from benchmarks.errors.row import Judged, Row, shared
from remanent._typing import FloatArray

#: Decades of tolerance that are asked for.
TOLERANCES = (-11.0, -3.0)
#: Lengths of runs.
DURATIONS = (40.0, 100.0)
#: Cases of a batch, and how far their fields are apart, as a share.
CASES = 16
SPREAD = 0.05
#: Relative error of a step of the reference, in extended precision, and in double for the way to
#: a maximum, whose place is then known to some 1e-13.
PRECISIONS = {np.longdouble: 1e-19, np.float64: 1e-16}
#: Frequencies among which a resonance is searched at first.
TABLES = (13, 61)
#: How well the place of a maximum is known, over the width asked.
ENOUGH = 1e-5
#: Change of an amplitude that is more than rounding in double precision.
NOISE = 1e-12
#: First step uphill to it, over that width, and the largest.
FIRST_STEP = 1e-2
LARGEST_STEP = 1e-2
#: Frequencies among which the highest maximum is looked for, again about the best of them.
SAMPLES, ZOOMS = 601, 3
#: A last bracket for which no resonance is searched.
WIDEST = 10.0
LONG = np.longdouble


@dataclass(frozen=True)
class Excursion:
    """Half the difference of the extremes of a run, and its derivative by the frequency."""

    amplitude: float
    slope: float


@cache
def _engine(fp_type: Any) -> Any:
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

    turn = hy.nt_event(hy.make_vars("v"), turned, fp_type=fp_type)
    start, precision = np.array([1, 0], dtype=fp_type), fp_type(PRECISIONS[fp_type])
    engine = hy.taylor_adaptive(system, start, fp_type=fp_type, tol=precision, nt_events=[turn])
    return engine, found


def excursion(values: dict[str, float], omega: float, fp_type: Any = LONG) -> Excursion | None:
    """Of the thickness stretch in a run from rest; None where the motion is lost."""
    engine, found = _engine(fp_type)
    found.clear()
    engine.time = fp_type(0)
    engine.state[:] = [1, 0, 0, 0]
    engine.pars[:] = [
        values["c"], fp_type(values["temperature"]) / 293, values["prestress"], values["eta"],
        values["b"], omega,
    ]  # fmt: skip
    outcome = engine.propagate_until(fp_type(values["duration"]), max_steps=1_000_000)
    if "time_limit" not in str(outcome[0]) or not engine.state[0] > 0:
        return None
    ends = [(fp_type(1), fp_type(0)), (engine.state[0], engine.state[2])]
    points = np.array([*ends, *found], dtype=fp_type)
    thickness = points[:, 0] ** -2
    slopes = -2 * points[:, 0] ** -3 * points[:, 1]
    high, low = np.argmax(thickness), np.argmin(thickness)
    amplitude = (thickness[high] - thickness[low]) / 2
    return Excursion(float(amplitude), float((slopes[high] - slopes[low]) / 2))


@dataclass(frozen=True)
class Batch:
    """Random actuators and loads, all damped or none, whose natural frequencies are alike.

    Attributes
    ----------
    columns : dict of name to array (case,)
        Fields in which the cases differ.
    middle : float
        Of the natural frequencies under the mean loads.
    duration : float
        Of each run.
    """

    columns: dict[str, Any]
    middle: float
    duration: float
    damped: bool

    def values(self, k: int) -> dict[str, float]:
        """The fields of one case."""
        fields = {name: float(column[k]) for name, column in self.columns.items()}
        return {**fields, "duration": self.duration}

    def case(self, k: int) -> Batch:
        """One of the cases alone."""
        columns = {name: column[k : k + 1] for name, column in self.columns.items()}
        return replace(self, columns=columns)

    def response(self, omega: Any, **options: Any) -> Any:
        """Of all cases, by :func:`remanent.frequency_response`."""
        names = {"eta": "dissipation.0.eta"} if self.damped else {"eta": ""}
        over = {
            name: xr.DataArray(column, dims=CASE)
            for key, column in self.columns.items()
            if (name := names.get(key, key))
        }
        body = rm.Actuator(dissipation=rm.Rayleigh(0.1) if self.damped else ())
        drive = rm.SineSquared(0.4, 1.0)
        return rm.frequency_response(
            body, drive, omega, duration=self.duration, over=over, **options
        )


def _batch(rng: np.random.Generator) -> Batch | None:
    """None where the one in the middle has no natural frequency."""
    damped = rng.uniform() < 0.5
    alike = rng.uniform(1.0 - SPREAD, 1.0 + SPREAD, (2, CASES))
    columns = {
        "c": 10.0 ** rng.uniform(-1.0, 0.0) * alike[0],
        "temperature": 293.0 * rng.uniform(0.8, 1.3) * alike[1],
        "prestress": rng.uniform(-0.5, 0.5) + rng.uniform(-SPREAD, SPREAD, CASES),
        "eta": 10.0 ** rng.uniform(-2.0, 0.0, CASES) if damped else np.zeros(CASES),
        "b": rng.uniform(0.05, 0.6) * rng.uniform(1.0 - SPREAD, 1.0 + SPREAD, CASES),
    }
    first = {name: float(column[0]) for name, column in columns.items()}
    body = rm.Actuator(c=first["c"], temperature=first["temperature"], prestress=first["prestress"])
    natural = rm.equilibria(body, 0.5 * first["b"] ** 2).natural_frequency
    middle = float(natural[0]) if natural.size else np.nan
    duration = float(rng.choice(DURATIONS))
    return Batch(columns, middle, duration, damped) if np.isfinite(middle) else None


def _amplitude(rng: np.random.Generator) -> Iterator[Judged]:
    """Amplitudes of random actuators at some frequencies."""
    batch, tolerance = _batch(rng), 10.0 ** rng.uniform(*TOLERANCES)
    if batch is None:
        return
    omega = np.sort(rng.uniform(0.3, 2.5, 4))
    ds = batch.response(omega, tolerance=tolerance)
    for k in range(CASES):
        values = batch.values(k)
        for w in omega:
            one = ds.isel({CASE: k}).sel(omega=w)
            exact = excursion(values, float(w))
            if exact is None or not np.isfinite(one.amplitude):
                continue
            true = abs(float(one.amplitude) - exact.amplitude)
            case = f"{values}, omega={w!r}"
            yield Judged(case, tolerance, batch.damped, float(one.amplitude_error), true)


def _true_maximum(values: dict[str, float], found: float, width: float) -> float | None:
    """The frequency of the maximum to which the amplitude rises from a given one.

    A root of the slope, or the place of a jump: steps uphill that grow until the amplitude no
    longer rises, then Brent's method, or halves where the slope has no root.
    """

    def at(omega: float) -> Excursion:
        there = excursion(values, omega, np.float64)
        return Excursion(np.nan, np.nan) if there is None else there

    low, first, step = found, at(found), FIRST_STEP * width
    uphill = 1.0 if first.slope > 0.0 else -1.0
    while True:
        high = found + uphill * step
        second = at(high)
        if not np.isfinite(first.slope + second.slope) or step > LARGEST_STEP:
            return None
        if second.slope * uphill <= 0.0:
            return float(brentq(lambda omega: at(omega).slope, low, high, xtol=ENOUGH * width))
        if second.amplitude < first.amplitude - NOISE:
            break
        low, first, step = high, second, 3.0 * step
    while abs(high - low) > ENOUGH * width:
        middle = 0.5 * (low + high)
        low, high = (
            (middle, high) if at(middle).amplitude >= first.amplitude - NOISE else (low, middle)
        )
    return 0.5 * (low + high)


def _highest_sampled(batch: Batch, k: int, omega: FloatArray) -> float | None:
    """The frequency of the largest of many amplitudes between two others, in one case.

    Many again about that one, and so on: beside a jump there are ripples.
    """
    low, high, best = omega[0], omega[-1], None
    for _ in range(ZOOMS):
        at = np.linspace(low, high, SAMPLES)
        amplitude = batch.case(k).response(at, resonance_width=WIDEST).amplitude.values[0]
        if not np.isfinite(amplitude).any():
            break
        i = int(np.nanargmax(amplitude))
        low, best, high = at[max(i - 3, 0)], float(at[i]), at[min(i + 3, SAMPLES - 1)]
    return best


@shared
def _resonance(
    rng: np.random.Generator, width: float, decades: tuple[float, float]
) -> Iterator[tuple[str, Judged]]:
    """Resonances of random actuators, near their natural frequencies: places and amplitudes."""
    batch, tolerance = _batch(rng), 10.0 ** rng.uniform(*decades)
    if batch is None:
        return
    omega = np.linspace(0.35, 0.65, int(rng.choice(TABLES))) * batch.middle
    ds = batch.response(omega, tolerance=tolerance, resonance_width=width)
    for k in range(CASES):
        one, values = ds.isel({CASE: k}), batch.values(k)
        if int(one.resonance_status) != rm.Status.OK:
            continue
        found = float(one.resonance)
        maxima = [
            _maximum_beside(values, place, width)
            for place in (found, _highest_sampled(batch, k, omega))
        ]
        if maxima[0] is None:
            continue
        exact, there = max(filter(None, maxima), key=lambda pair: pair[1].amplitude)
        case = f"{values}, resonance_width={width}"
        pairs = {
            "resonance": (abs(found - exact), 1.0),
            "resonance_amplitude": (
                abs(float(one.resonance_amplitude) - there.amplitude), there.amplitude,
            ),
        }  # fmt: skip
        for name, (true, size) in pairs.items():
            error = float(one[f"{name}_error"])
            yield name, Judged(case, tolerance, batch.damped, error, true, size)


def _maximum_beside(
    values: dict[str, float], place: float | None, width: float
) -> tuple[float, Excursion] | None:
    """The maximum to which the amplitude rises from a frequency; None where it is not found."""
    exact = None if place is None else _true_maximum(values, place, width)
    there = None if exact is None or not np.isfinite(exact) else excursion(values, exact)
    return None if exact is None or there is None else (exact, there)


def _resonance_of(
    what: str, width: float, decades: tuple[float, float]
) -> Callable[[np.random.Generator], Iterator[Judged]]:
    return lambda rng: (judged for name, judged in _resonance(rng, width, decades) if name == what)


ROWS = (
    Row("amplitudes of forced response", "frequency_response: amplitude_error", _amplitude),
    Row(
        "resonances of forced response",
        "frequency_response: resonance_error",
        _resonance_of("resonance", 1e-6, TOLERANCES),
    ),
    Row(
        "amplitudes at resonances of forced response",
        "frequency_response: resonance_amplitude_error",
        _resonance_of("resonance_amplitude", 1e-6, TOLERANCES),
    ),
    Row(
        "narrow brackets of resonances",
        "frequency_response: resonance_error",
        _resonance_of("resonance", 1e-9, TOLERANCES),
    ),
)
