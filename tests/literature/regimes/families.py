"""The 1000 cases: which systems, which parameters, which starts; drawn with a fixed seed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import heyoka as hy
import numpy as np

from remanent._typing import FloatArray
from tests.literature.auto import systems
from tests.literature.regimes import flows

SEED = 16
GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


@dataclass(frozen=True)
class Case:
    """One case; `truth` and `period` are set where they follow from its construction."""

    family: str
    group: str
    parameters: tuple[float, ...]
    initial: tuple[float, float]
    dissipative: bool
    truth: str | None = None
    period: int | None = None


def _pair(values: FloatArray) -> tuple[float, float]:
    """Two numbers, as Python's."""
    return float(values[0]), float(values[1])


@dataclass(frozen=True)
class Family:
    """An equation with the names of its parameters, and how to look at its states."""

    names: tuple[str, ...]
    #: Rates of a flow by phase, or None for a map.
    rates: flows.Rates | None
    equation: str
    observables: Callable[[FloatArray], FloatArray]
    lost: Callable[[FloatArray], Any]
    resting: tuple[tuple[float, ...], tuple[float, float]] = field(default=((), (0.0, 0.0)))
    #: A full turn, where x is an angle.
    turn: float | None = None


def plain(states: FloatArray) -> FloatArray:
    """The states themselves."""
    return states


def rolled(states: FloatArray) -> FloatArray:
    """cos x, sin x and the rate, for an angle x."""
    x, v = states.T
    return np.column_stack([np.cos(x), np.sin(x), v])


def rolled_twice(states: FloatArray) -> FloatArray:
    """Cosine and sine of both, for a point of a torus."""
    return np.column_stack([np.cos(states), np.sin(states)])


def far(states: FloatArray) -> Any:
    """Beyond 10^6."""
    return ~(np.max(np.abs(states), axis=-1) < 1e6)


def stretched(states: FloatArray) -> Any:
    """Stretch beyond 100 or below 1/1000."""
    return ~((states[..., 0] < 100.0) & (states[..., 0] > 1e-3))


def pendulum(x: Any, v: Any, s: Any, par: Sequence[Any]) -> tuple[Any, Any]:
    """x'' + d x' + sin x = F cos(omega t); omega, d, F."""
    omega, d, strength = par
    period = 2.0 * hy.pi / omega
    return period * v, period * (strength * hy.cos(2.0 * hy.pi * s) - d * v - hy.sin(x))


FAMILIES = {
    "actuator": Family(
        ("omega", "theta", "S", "b", "c", "eta"), systems.actuator,
        "equation (16) with eta x' inside its bracket, m = (b sin(omega tau))^2; "
        "x stretch, v its rate; strobed every pi/omega",
        plain, stretched, ((1.0, 1.0, 0.0, 0.0, 1.0, 0.1), (1.0, 0.0)),
    ),
    "oscillator": Family(
        ("omega", "d", "g", "a", "e", "k", "F"), systems.oscillator,
        "x'' + (d + g x^2) x' + (a + e cos(omega t)) x + k x^3 = F cos(omega t), v = x'; "
        "strobed every 2 pi/omega",
        plain, far, ((1.0, 0.1, 0.0, 1.0, 0.0, 0.0, 0.0), (0.0, 0.0)),
    ),
    "pendulum": Family(
        ("omega", "d", "F"), pendulum,
        "x'' + d x' + sin x = F cos(omega t), v = x'; observed as cos x, sin x, v; "
        "strobed every 2 pi/omega",
        rolled, far, ((1.0, 0.1, 0.0), (0.0, 0.0)), 2 * np.pi,
    ),
    "standard": Family(
        ("K",), None, "v <- v + K sin x, x <- x + v; observed as cos and sin of x and v",
        rolled_twice, lambda states: ~np.isfinite(states).all(axis=-1),
    ),
    "logistic": Family(("r",), None, "x <- r x (1 - x); v = 0", plain, far),
    "henon": Family(("a", "b"), None, "x <- 1 - a x^2 + v, v <- b x", plain, far),
}  # fmt: skip


def cases() -> list[Case]:
    """All 1000, in order."""
    rng = np.random.default_rng(SEED)
    found = [
        *_actuators(rng, "undamped", 150, strong=False, damped=False),
        *_actuators(rng, "undamped, strong", 80, strong=True, damped=False),
        *_periodic_actuators(rng, 40),
        *_actuators(rng, "damped", 140, strong=False, damped=True),
        *_actuators(rng, "damped, strong", 130, strong=True, damped=True),
        *_oscillators(rng),
        *_linear(rng),
        *_mathieu(rng, 40),
        *_pendulums(rng),
        *_maps(rng),
    ]
    if len(found) != 1000:
        raise AssertionError(f"{len(found)} cases")
    return found


def _near_rest(rng: np.random.Generator) -> tuple[float, float]:
    """Rest, or near it."""
    if rng.random() < 0.5:
        return 1.0, 0.0
    return 1.0 + float(rng.uniform(-0.2, 0.2)), float(rng.uniform(-0.2, 0.2))


def _actuators(
    rng: np.random.Generator, group: str, count: int, *, strong: bool, damped: bool
) -> list[Case]:
    found = []
    for _ in range(count):
        par = (
            rng.uniform(0.5, 3.0), rng.uniform(0.8, 1.4), rng.uniform(-0.5, 1.5),
            rng.uniform(1.0, 2.5) if strong else rng.uniform(0.1, 1.5),
            10 ** rng.uniform(-2.0, 0.0),
            10 ** rng.uniform(np.log10(0.005), np.log10(0.3)) if damped else 0.0,
        )  # fmt: skip
        case = Case("actuator", group, tuple(map(float, par)), _near_rest(rng), damped)
        found.append(case)
    return found


def _periodic_actuators(rng: np.random.Generator, count: int) -> list[Case]:
    """Starts on elliptic orbits at rest at phase 0: periodic by construction."""
    found: list[Case] = []
    ta = flows.integrator(systems.actuator, 6)
    while len(found) < count:
        draw = _actuators(rng, "undamped, on a periodic orbit", 1, strong=False, damped=False)[0]
        period = 1 + len(found) % 3
        stretch = _symmetric_orbit(ta, draw.parameters, period)
        if stretch is not None:
            found.append(replace(draw, initial=(stretch, 0.0), truth="periodic", period=period))
    return found


def _symmetric_orbit(ta: Any, parameters: tuple[float, ...], period: int) -> float | None:
    """A stretch from which half the period leads to rest again, if the orbit is elliptic."""

    def halfway(stretches: FloatArray) -> FloatArray:
        values = np.empty_like(stretches)
        for begin in range(0, len(stretches), flows.LANES):
            part = stretches[begin : begin + flows.LANES]
            values[begin : begin + flows.LANES] = _map(ta, parameters, part, period / 2)[1]
        return values

    grid = np.geomspace(0.6, 1.8, 5 * flows.LANES)
    rates = halfway(grid)
    brackets = [
        (a, b) for a, b, f, g in zip(grid, grid[1:], rates, rates[1:], strict=False) if f * g < 0
    ]
    for low, high in brackets:
        a, b = low, high
        side = float(np.sign(halfway(np.full(flows.LANES, low))[0]))
        for _ in range(18):
            points = np.linspace(a, b, flows.LANES + 2)
            same = [True, *(np.sign(halfway(points[1:-1])) == side), False]
            k = same.index(False)
            a, b = float(points[k - 1]), float(points[k])
        stretch = float(0.5 * (a + b))
        if _elliptic(ta, parameters, stretch, period):
            return stretch
    return None


def _map(ta: Any, parameters: tuple[float, ...], stretches: FloatArray, end: float) -> FloatArray:
    """State (4, lane) at phase `end` from rest, tangents (1, 0)."""
    ta.pars[:] = np.array(parameters)[:, None]
    ta.state[:] = np.array([0.0, 0.0, 1.0, 0.0])[:, None]
    ta.state[0] = stretches
    ta.set_time(0.0)
    ta.propagate_until([end] * flows.LANES)
    return np.array(ta.state)


def _elliptic(ta: Any, parameters: tuple[float, ...], stretch: float, period: int) -> bool:
    """Whether the orbit is new for its period, closes, and has |trace| well below 2."""
    for shorter in range(1, period):
        if period % shorter == 0:
            end = _map(ta, parameters, np.full(flows.LANES, stretch), float(shorter))
            if abs(end[0, 0] - stretch) + abs(end[1, 0]) < 1e-4:
                return False
    ta.pars[:] = np.array(parameters)[:, None]
    ta.state[:] = np.array([stretch, 0.0, 0.0, 1.0])[:, None]
    ta.state[2:, 0] = [1.0, 0.0]
    ta.set_time(0.0)
    ta.propagate_until([float(period)] * flows.LANES)
    closes = abs(ta.state[0, 0] - stretch) + abs(ta.state[1, 0]) < 1e-11
    return bool(closes and abs(ta.state[2, 0] + ta.state[3, 1]) < 1.9)


def _oscillator(group: str, initial: Any, *, dissipative: bool, **par: float) -> Case:
    names = FAMILIES["oscillator"].names
    values = tuple(float(par.get(name, 0.0)) for name in names)
    return Case("oscillator", group, values, _pair(initial), dissipative)


def _oscillators(rng: np.random.Generator) -> list[Case]:
    found = []
    for _ in range(30):
        found.append(
            _oscillator(
                "Duffing, two wells",
                rng.uniform(-1, 1, 2),
                dissipative=True,
                omega=rng.uniform(0.8, 1.4),
                d=rng.uniform(0.1, 0.3),
                a=-1.0,
                k=1.0,
                F=rng.uniform(0.1, 0.5),
            )
        )
    for _ in range(30):
        found.append(
            _oscillator(
                "Duffing, hard",
                rng.uniform(-1, 1, 2),
                dissipative=True,
                omega=1.0,
                d=rng.uniform(0.05, 0.2),
                k=1.0,
                F=rng.uniform(1.0, 13.0),
            )
        )
    for _ in range(40):
        found.append(
            _oscillator(
                "Duffing, undamped",
                rng.uniform(-1, 1, 2),
                dissipative=False,
                omega=rng.uniform(0.5, 3.0),
                a=1.0,
                k=1.0,
                F=rng.uniform(0.05, 3.0),
            )
        )
    for _ in range(50):
        mu = rng.uniform(0.1, 2.0)
        found.append(
            _oscillator(
                "van der Pol",
                rng.uniform(-1, 1, 2),
                dissipative=True,
                omega=rng.uniform(0.5, 2.0),
                d=-mu,
                g=mu,
                a=1.0,
                F=rng.uniform(0.1, 2.0),
            )
        )
    return found


def _linear(rng: np.random.Generator) -> list[Case]:
    """Forced linear oscillators: free and forced motion add, so all is known."""
    found = []
    for i in range(60):
        omega, strength = rng.uniform(0.5, 2.0), rng.uniform(0.1, 1.0)
        initial = rng.uniform(-1, 1, 2)
        if i < 25:
            # A noble ratio: the worst to mistake for a rational one.
            ratio = GOLDEN
            for term in rng.integers(1, 5, 3):
                ratio = 1.0 / (int(term) + ratio)
            ratio += float(rng.integers(0, 2))
            truth, period = "quasi-periodic", None
        elif i < 45:
            q = int(rng.integers(2, 13))
            p = int(rng.choice([k for k in range(1, 2 * q) if np.gcd(k, q) == 1]))
            ratio, truth, period = p / q, "periodic", q
        else:
            ratio, truth, period = rng.uniform(0.3, 1.8), "periodic", 1
        damping = rng.uniform(0.02, 0.3) if i >= 45 else 0.0
        case = _oscillator(
            "linear", initial, dissipative=damping > 0, omega=omega, d=damping,
            a=(ratio * omega) ** 2, F=strength,
        )  # fmt: skip
        found.append(replace(case, truth=truth, period=period))
    return found


def _mathieu(rng: np.random.Generator, count: int) -> list[Case]:
    """Mathieu's equation: Floquet's theorem decides between tori and escape."""
    ta = flows.integrator(systems.oscillator, 7)
    found: list[Case] = []
    while len(found) < count:
        unstable = len(found) % 5 == 4
        case = _oscillator(
            "Mathieu", rng.uniform(-1, 1, 2), dissipative=False, omega=1.0,
            a=rng.uniform(0.1, 3.0), e=rng.uniform(0.05, 1.2),
        )  # fmt: skip
        ta.pars[:] = np.array(case.parameters)[:, None]
        ta.state[:] = np.array([0.0, 0.0, 0.0, 1.0])[:, None]
        ta.state[2:, 0] = [1.0, 0.0]
        ta.set_time(0.0)
        ta.propagate_until([1.0] * flows.LANES)
        trace = abs(float(ta.state[2, 0] + ta.state[3, 1]))
        if unstable and trace > 2.1:
            found.append(replace(case, truth="escaped"))
        elif not unstable and trace < 1.95:
            found.append(replace(case, truth="quasi-periodic"))
    return found


def _pendulums(rng: np.random.Generator) -> list[Case]:
    found = []
    for i in range(70):
        damped = i < 50
        par = (
            (rng.uniform(0.5, 0.9), rng.uniform(0.1, 0.6), rng.uniform(0.3, 1.6))
            if damped
            else (rng.uniform(0.5, 3.0), 0.0, rng.uniform(0.05, 1.0))
        )
        group = "pendulum, damped" if damped else "pendulum, undamped"
        start = rng.uniform(-1, 1, 2)
        values = tuple(map(float, par))
        found.append(Case("pendulum", group, values, _pair(start), damped))
    return found


def _maps(rng: np.random.Generator) -> list[Case]:
    found = []
    for i in range(60):
        K = rng.uniform(0.1, 1.2) if i < 35 else rng.uniform(1.2, 6.0)
        start = rng.uniform(0, 2 * np.pi, 2)
        found.append(Case("standard", "standard map", (float(K),), _pair(start), False))
    for _ in range(40):
        r, x = float(rng.uniform(2.9, 4.0)), float(rng.uniform(0.1, 0.9))
        found.append(Case("logistic", "logistic map", (r,), (x, 0.0), True))
    for _ in range(40):
        par = (float(rng.uniform(0.9, 1.45)), 0.3)
        start = rng.uniform(-0.1, 0.1, 2)
        found.append(Case("henon", "Henon map", par, _pair(start), True))
    return found
