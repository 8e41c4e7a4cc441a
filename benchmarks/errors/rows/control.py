"""Metrics of step responses, residuals of commands and decrements, against heyoka."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import Any

import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.errors.row import Judged, Promise, Row, shared

#: Decades of tolerance that are asked for.
TOLERANCES = (-11.0, -3.0)
#: Relative error of a step of the reference.
PRECISION = 1e-19
#: Steps of bisection for the instant of a level.
BISECTIONS = 70
#: Share of the change that counts as settled.
BAND = 0.02
LONG = np.longdouble


@cache
def _engine() -> tuple[Any, list[Any]]:
    """The block under a constant load, with its turning points."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    c, theta, prestress, eta, m = (hy.par[k] for k in range(5))
    x2 = x * x
    x4, x7 = x2 * x2, x2 * x2 * x2 * x
    force = theta * (x4 * x4 - x2) - prestress * x7 + m * x4 + eta * v * x7
    rate = (6.0 * c * v * v - 3.0 * force) / (x7 + 2.0 * c * x)
    found: list[Any] = []

    def turned(_: Any, time: Any, __: int) -> None:
        found.append(LONG(time))

    turn = hy.nt_event(hy.make_vars("v"), turned, fp_type=LONG)
    engine = hy.taylor_adaptive(
        [(x, v), (v, rate)], np.array([1, 0], dtype=LONG), fp_type=LONG,
        tol=LONG(PRECISION), nt_events=[turn],
    )  # fmt: skip
    return engine, found


def _start(values: dict[str, float], load: Any) -> tuple[Any, list[Any]]:
    engine, found = _engine()
    found.clear()
    engine.time = LONG(0)
    engine.state[:] = [1, 0]
    theta = LONG(values["temperature"]) / 293
    engine.pars[:] = [values["c"], theta, values["prestress"], values["eta"], LONG(load)]
    return engine, found


def _thickness(engine: Any, dense: Any, time: Any) -> Any:
    return dense(LONG(time))[0] ** -2 if dense is not None else engine.state[0] ** -2


def _first_at(share: Callable[[Any], Any], level: Any, low: Any, high: Any) -> float:
    """The instant between two at which a monotonic function passes a level."""
    rises = share(high) > share(low)
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        low, high = (middle, high) if (share(middle) < level) == rises else (low, middle)
    return float((low + high) / 2)


def _rest(values: dict[str, float], load: float) -> Any:
    """The stretch at the only equilibrium, in extended precision; None where there are more."""
    theta, prestress = LONG(values["temperature"]) / 293, LONG(values["prestress"])
    force = [theta, -prestress, 0, 0, load, 0, -theta]
    roots = np.roots(np.array(force, dtype=float))
    real = roots[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0)].real
    if real.size != 1:
        return None
    x = LONG(real[0])
    for _ in range(8):  # Newton's method
        f = theta * (x**6 - 1) - prestress * x**5 + LONG(load) * x**2
        x -= f / (6 * theta * x**5 - 5 * prestress * x**4 + 2 * LONG(load) * x)
    return x


def _exact_metrics(values: dict[str, float], load: float, duration: float) -> dict[str, float]:
    """Rise and settling time, overshoot, final thickness stretch; empty if there is none."""
    x = _rest(values, load)
    if x is None:
        return {}
    final = x**-2
    engine, turns = _start(values, load)
    outcome = engine.propagate_until(LONG(duration), c_output=True)
    dense = outcome[4]

    def share(time: Any) -> Any:
        return (dense(LONG(time))[0] ** -2 - 1) / (final - 1)

    nodes = [LONG(0), *turns, LONG(duration)]
    heights = [share(time) for time in nodes]
    rise = []
    for level in (LONG(1) / 10, LONG(9) / 10):
        k = next((k for k, h in enumerate(heights) if h >= level), None)
        if k is None or k == 0:
            return {}
        rise.append(_first_at(share, level, nodes[k - 1], nodes[k]))
    outside = [k for k, h in enumerate(heights) if abs(h - 1) > LONG(BAND)]
    metrics = {
        "final": float(final),
        "rise_time": rise[1] - rise[0],
        "overshoot": max(float(max(heights) - 1), 0.0),
        "farthest": float(1 + max(heights) * (final - 1)),
    }
    k = outside[-1]
    if k + 1 < len(nodes):
        edge = 1 + (LONG(BAND) if heights[k] > 1 else -LONG(BAND))
        metrics["settling_time"] = _first_at(share, edge, nodes[k], nodes[k + 1])
    return metrics


def _values(rng: np.random.Generator, *, damped: bool) -> dict[str, float]:
    return {
        "c": 10.0 ** rng.uniform(-1.0, 0.0),
        "temperature": 293.0 * rng.uniform(0.8, 1.3),
        "prestress": rng.uniform(-0.3, 0.8),
        "eta": 10.0 ** rng.uniform(-1.0, 0.3) if damped else 0.0,
    }


def _body(values: dict[str, float]) -> rm.Actuator:
    return rm.Actuator(
        c=values["c"], temperature=values["temperature"], prestress=values["prestress"],
        dissipation=rm.Rayleigh(values["eta"]),
    )  # fmt: skip


@shared
def _steps(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """Metrics of one step from rest, with their names."""
    values = _values(rng, damped=bool(rng.uniform() < 0.8))
    load, tolerance = rng.uniform(-0.5, 2.0), 10.0 ** rng.uniform(*TOLERANCES)
    duration = 60.0
    ds = rm.step_response(_body(values), rm.Constant(load), duration=duration, tolerance=tolerance)
    for name, exact in _exact_metrics(values, load, duration).items():
        found, error = float(ds[name]), float(ds[f"{name}_error"])
        if np.isfinite(found):
            yield name, Judged(
                f"{values}, Constant({load!r})", tolerance, values["eta"] > 0.0, error,
                abs(found - exact), abs(exact),
            )  # fmt: skip


def _vibration(rng: np.random.Generator) -> Iterator[Judged]:
    """Energy and amplitude of what two steps leave, from heyoka's state right after them."""
    values = _values(rng, damped=bool(rng.uniform() < 0.5))
    first, last = rng.uniform(-0.5, 2.0, 2)
    time, tolerance = rng.uniform(0.3, 6.0), 10.0 ** rng.uniform(*TOLERANCES)
    x = _rest(values, last)
    if x is None:
        return
    drive = rm.Steps((0.0, time), (first, last))
    ds = rm.step_response(_body(values), drive, duration=time + 5.0, tolerance=tolerance)
    engine, _ = _start(values, first)
    engine.propagate_until(LONG(time))
    stretch, rate = engine.state
    theta, prestress = LONG(values["temperature"]) / 293, LONG(values["prestress"])

    def potential(y: Any) -> Any:
        return theta * (2 * y**2 + y**-4 - 3) / 2 - 2 * prestress * (y - 1) - LONG(last) * y**-2

    kinetic = (2 * rate**2 + LONG(values["c"]) * (2 * rate / stretch**3) ** 2) / 6
    energy = kinetic + potential(stretch) - potential(x)
    # The load that holds a stretch y is -y^3 [theta (y - y^-5) - S].
    slope = -theta * (4 * x**3 + 2 * x**-3) + 3 * prestress * x**2
    stiffness = -slope * x**3 / 2
    exact = {"residual_energy": energy, "residual_amplitude": np.sqrt(2 * energy / stiffness)}
    for name, number in exact.items():
        off, size = float(abs(float(ds[name]) - number)), float(abs(number))
        case, damped = f"{values}, {drive!r}: {name}", values["eta"] > 0.0
        yield Judged(case, tolerance, damped, float(ds[f"{name}_error"]), off, size)


def _of(
    name: str, numbers: Callable[[np.random.Generator], Iterable[tuple[str, Judged]]] = _steps
) -> Callable[[np.random.Generator], Iterator[Judged]]:
    return lambda rng: (judged for what, judged in numbers(rng) if what == name)


def _residual(rng: np.random.Generator) -> Iterator[Judged]:
    """How far from rest a command leaves its actuator: what it says, and what heyoka finds."""
    values = _values(rng, damped=bool(rng.uniform() < 0.5))
    values["prestress"], tolerance = 0.0, 10.0 ** rng.uniform(-11.0, -6.0)
    values["eta"] = min(values["eta"], 0.3)
    target = rng.uniform(1.02, 1.6)
    over = {"c": xr.DataArray([values["c"]], dims="case")}
    ds = rm.shape_commands(_body(values), target, over=over, tolerance=tolerance).isel(case=0)
    if int(ds.status) != rm.Status.OK:
        return
    times, loads = (ds[name].values[np.isfinite(ds[name])] for name in ("step_time", "step_load"))
    engine, _ = _start(values, loads[0])
    for k in range(1, len(times)):
        engine.propagate_until(LONG(times[k]))
        engine.pars[4] = LONG(loads[k])
    rest = LONG(target) ** (-LONG(1) / 2)
    exact = float(max(abs(engine.state[0] - rest), abs(engine.state[1])))
    true = abs(float(ds.residual) - exact)
    case = f"{values}, target={target!r}"
    yield Judged(case, tolerance, values["eta"] > 0.0, float(ds.residual_error), true)


def _switch_times(rng: np.random.Generator) -> Iterator[Judged]:
    """Of two steps without prestress and damping, whose first load has a closed form.

    Under m = theta (x - 1)(x + 2)/(2 x) the motion from rest turns at the thickness stretch x.
    """
    values = {**_values(rng, damped=False), "prestress": 0.0}
    target, tolerance = rng.uniform(1.02, 1.6), 10.0 ** rng.uniform(-11.0, -6.0)
    over = {"c": xr.DataArray([values["c"]], dims="case")}
    ds = rm.shape_commands(_body(values), target, over=over, tolerance=tolerance).isel(case=0)
    if int(ds.status) != rm.Status.OK:
        return
    x = LONG(target)
    load = LONG(values["temperature"]) / 293 * (x - 1) * (x + 2) / (2 * x)
    engine, turns = _start(values, load)
    engine.propagate_until(LONG(1.5 * float(ds.switch_time)))
    later = [float(time) for time in turns if time > 0.5 * float(ds.switch_time)]
    if later:
        true = abs(float(ds.switch_time) - later[0])
        case = f"{values}, target={target!r}"
        yield Judged(case, tolerance, False, float(ds.switch_time_error), true, later[0])


@shared
def _ring_downs(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """Ring-downs of a linear oscillator with noise of equal variance, with what is judged."""
    for _ in range(10):
        delta, omega = 10.0 ** rng.uniform(-1.5, -0.2), rng.uniform(0.5, 5.0)
        cycles, count = rng.uniform(4.0, 12.0), int(rng.integers(300, 3000))
        time = np.linspace(0.0, 2.0 * np.pi * cycles / omega, count)
        noise = 10.0 ** rng.uniform(-4.0, -1.3)
        motion = np.exp(-delta * omega * time / (2.0 * np.pi)) * np.cos(
            omega * time + rng.uniform(0.0, 2.0 * np.pi)
        )
        motion += 1.0 + noise * rng.standard_normal(count)
        record = xr.Dataset({"thickness_stretch": ("time", motion)}, coords={"time": time})
        found = rm.logarithmic_decrement(record)
        exact = {
            "decrement": delta, "frequency": omega,
            "damping_ratio": delta / np.hypot(2.0 * np.pi, delta),
        }  # fmt: skip
        for name, number in exact.items():
            if np.isfinite(found[name]):
                case = f"delta={delta!r}, omega={omega!r}, noise={noise!r}"
                error, off = float(found[f"{name}_error"]), abs(float(found[name]) - number)
                yield name, Judged(case, noise, True, error, off, number)


ROWS = (
    *(
        Row(f"{words} of steps", f"step_response: {name}_error", _of(name))
        for name, words in (
            ("final", "final stretches"),
            ("rise_time", "rise times"),
            ("settling_time", "settling times"),
            ("overshoot", "overshoots"),
            ("farthest", "farthest stretches"),
        )
    ),
    Row(
        "vibrations that steps leave",
        "step_response: residual_energy_error, residual_amplitude_error",
        _vibration,
    ),
    Row("residuals of commands", "shape_commands: residual_error", _residual),
    Row("switching times of commands", "shape_commands: switch_time_error", _switch_times),
    *(
        Row(
            f"{words} of noisy records",
            f"logarithmic_decrement: {name}_error",
            _of(name, _ring_downs),
            Promise.STANDARD,
        )
        for name, words in (
            ("decrement", "decrements"),
            ("frequency", "frequencies"),
            ("damping_ratio", "damping ratios"),
        )
    ),
)
