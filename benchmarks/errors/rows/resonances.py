"""Peaks of branches of forced response, against Newton's method on heyoka's orbits."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

import remanent as rm
from benchmarks.errors.period_map import PeriodMap
from benchmarks.errors.row import Judged, Row, shared
from benchmarks.errors.rows.backbone import return_frequency
from remanent._typing import ComplexArray

#: Decades of the tolerance of the residual.
TOLERANCES = (-11.0, -6.0)
#: Relative error of a step of the reference.
PRECISION = 1e-19
#: Steps of Newton's method onto an orbit, and the size of the last.
NEWTON_STEPS = 12
CONVERGED = 1e-15
#: Steps of the secant method for the top of a peak, and the change that ends it.
SECANT_STEPS = 30
ENOUGH = 1e-14
#: Samples of an orbit for its harmonics, and how many of these results have beside the mean.
SAMPLES = 256
HARMONIC_COUNT = 12
#: Frequencies of the drive over the natural one, where its square resonates, and where twice that
#: does; and how often the second are taken.
BANDS = ((0.36, 0.55), (0.22, 0.3))
SUPERHARMONIC_SHARE = 0.2
LONG = np.longdouble


@dataclass(frozen=True)
class Orbit:
    """An orbit under the square of a sine.

    Attributes
    ----------
    state : array (2,)
    amplitude, slope : float
        Of the thickness stretch, and its derivative by omega along the branch.
    samples : array (sample,)
        Of the thickness stretch over one period.
    """

    state: Any
    amplitude: float
    slope: float
    samples: Any


@cache
def _engine() -> tuple[Any, list[Any]]:
    """The block with derivatives by its state and by omega, and its turning points."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    c, theta, prestress, eta, b, omega = (hy.par[k] for k in range(6))
    sine = b * hy.sin(omega * hy.time)
    x2 = x * x
    x4, x7 = x2 * x2, x2 * x2 * x2 * x
    force = theta * (x4 * x4 - x2) - prestress * x7 + sine * sine * x4 + eta * v * x7
    rate = (6.0 * c * v * v - 3.0 * force) / (x7 + 2.0 * c * x)
    system = hy.var_ode_sys([(x, v), (v, rate)], [x, v, omega], order=1)
    found: list[Any] = []

    def turned(engine: Any, time: Any, _: int) -> None:
        engine.update_d_output(time)
        found.append(engine.d_output[:5].copy())

    turn = hy.nt_event(hy.make_vars("v"), turned, fp_type=LONG)
    start = np.array([1, 0, 1, 0, 0, 0, 1, 0], dtype=LONG)
    engine = hy.taylor_adaptive(
        system, start[:2], fp_type=LONG, tol=LONG(PRECISION), nt_events=[turn]
    )
    return engine, found


def _flow(values: dict[str, float], omega: Any, state: Any) -> tuple[Any, list[Any], Any]:
    """The state after a period with its derivatives, turning points, and samples."""
    engine, found = _engine()
    found.clear()
    engine.time = LONG(0)
    engine.state[:] = [state[0], state[1], 1, 0, 0, 0, 1, 0]
    theta = LONG(values["temperature"]) / 293
    engine.pars[:] = [
        values["c"], theta, values["prestress"], values["eta"], values["b"], LONG(omega),
    ]  # fmt: skip
    period = np.arctan(LONG(1)) * 4 / LONG(omega)
    outcome = engine.propagate_until(period, c_output=True)
    dense = outcome[4]
    samples = np.array([dense(period * k / SAMPLES)[0] ** -2 for k in range(SAMPLES)])
    return engine.state.copy(), list(found), samples


def _orbit(values: dict[str, float], omega: Any, state: Any) -> Orbit | None:
    """The orbit near a state, by Newton's method."""
    x = np.asarray(state, dtype=LONG)
    period = np.arctan(LONG(1)) * 4 / LONG(omega)
    for _ in range(NEWTON_STEPS):
        end, turns, samples = _flow(values, omega, x)
        jacobian = np.array([[end[2], end[3]], [end[5], end[6]]])
        matrix = np.eye(2, dtype=LONG) - jacobian
        determinant = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
        inverse = np.array([[matrix[1, 1], -matrix[0, 1]], [-matrix[1, 0], matrix[0, 0]]])
        step = inverse @ (end[:2] - x) / determinant
        x = x + step
        if not x[0] > 0 or not np.isfinite(float(x[0])):
            return None
        if np.abs(step).max() < CONVERGED:
            break
    else:
        return None
    # The period shortens as omega grows: d(end)/d(omega) is not at a fixed time.
    x_, v_ = end[0], end[1]
    theta = LONG(values["temperature"]) / 293
    force = theta * (x_**8 - x_**2) - LONG(values["prestress"]) * x_**7
    force += LONG(values["eta"]) * v_ * x_**7  # the load vanishes at phase 0
    rate = (6 * LONG(values["c"]) * v_ * v_ - 3 * force) / (x_**7 + 2 * LONG(values["c"]) * x_)
    by_omega = np.array([end[4], end[7]]) - np.array([v_, rate]) * period / LONG(omega)
    moved = inverse @ by_omega / determinant
    thickness = np.array([t[0] ** -2 for t in turns])
    slopes = np.array([
        -2 * t[0] ** -3 * (t[2] * moved[0] + t[3] * moved[1] + t[4]) for t in turns
    ])  # fmt: skip
    if not turns:
        return None
    high, low = np.argmax(thickness), np.argmin(thickness)
    amplitude = (thickness[high] - thickness[low]) / 2
    return Orbit(x, float(amplitude), float((slopes[high] - slopes[low]) / 2), samples)


def _top(values: dict[str, float], omega: float, state: Any) -> tuple[float, Orbit] | None:
    """The frequency of a peak, where the amplitude is level along the branch, and the orbit."""
    first = _orbit(values, omega, state)
    if first is None:
        return None
    before, after = LONG(omega), LONG(omega) + LONG(1e-7)
    second = _orbit(values, after, first.state)
    for _ in range(SECANT_STEPS):
        if second is None or second.slope == first.slope:
            return None
        step = -second.slope * (after - before) / (second.slope - first.slope)
        before, first, after = after, second, after + step
        second = _orbit(values, after, first.state)
        if abs(step) < ENOUGH and second is not None:
            return float(after), second
    return None


def _harmonics(orbit: Orbit) -> ComplexArray:
    """Amplitudes of the harmonics that results have, the mean first."""
    spectrum = np.fft.rfft(orbit.samples.astype(float))[: HARMONIC_COUNT + 1] / SAMPLES
    spectrum[1:] *= 2.0
    return np.asarray(spectrum)


def _free_frequency(values: dict[str, float], amplitude: float, near: float) -> float | None:
    """Of the undamped oscillation of an amplitude under the mean load, from its turning points."""
    theta, prestress = LONG(values["temperature"]) / 293, LONG(values["prestress"])
    mean = LONG(values["b"]) ** 2 / 2

    def potential(x: Any) -> Any:
        return theta * (2 * x**2 + x**-4 - 3) / 2 - 2 * prestress * (x - 1) - mean * x**-2

    def force(x: Any) -> Any:
        return 2 * (theta * (x - x**-5) - prestress + mean * x**-3)

    def ends(middle: Any) -> tuple[Any, Any]:
        return (middle + amplitude) ** LONG(-0.5), (middle - amplitude) ** LONG(-0.5)

    middle = LONG(1)
    for _ in range(NEWTON_STEPS):  # first for the rest, then for equal energies about it
        x = middle ** LONG(-0.5)
        middle -= force(x) / (2 * (theta * (1 + 5 * x**-6) - 3 * mean * x**-4) * -(x**3) / 2)
    for _ in range(NEWTON_STEPS):
        if not middle > amplitude:
            return None
        low, high = ends(middle)
        slope = (force(high) * high**3 - force(low) * low**3) / -2
        middle -= (potential(high) - potential(low)) / slope
    motion = PeriodMap(
        rm.Sine(0.0, 1.0),
        {**values, "dissipation.0.eta": 0.0, "m": 0.0, "mean": float(mean), "omega": 1.0},
    )
    found = return_frequency(motion, ends(middle)[1], near)
    return None if found is None else float(found)


def _start(peak: Any) -> tuple[float, float]:
    """Stretch and its rate at phase 0, as the harmonics have them."""
    turns = 2j * float(peak.omega) * np.arange(HARMONIC_COUNT + 1)  # sin^2 has half the period
    thickness = float(peak.harmonics.values.sum().real)
    rate = float((turns * peak.harmonics.values).sum().real)
    return thickness**-0.5, -0.5 * thickness**-1.5 * rate


@shared
def _peaks(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """Numbers of the peaks of one random actuator, with their names."""
    values = {
        "c": 10.0 ** rng.uniform(-1.0, 0.0),
        "temperature": 293.0 * rng.uniform(0.8, 1.3),
        "prestress": rng.uniform(-0.3, 0.5),
        "eta": 10.0 ** rng.uniform(-1.3, -0.3),
        "b": rng.uniform(0.05, 0.4),
    }
    tolerance = 10.0 ** rng.uniform(*TOLERANCES)
    body = rm.Actuator(
        c=values["c"], temperature=values["temperature"], prestress=values["prestress"],
        dissipation=rm.Rayleigh(values["eta"]),
    )  # fmt: skip
    natural = float(rm.equilibria(body, 0.5 * values["b"] ** 2).natural_frequency[0])
    share = BANDS[int(rng.uniform() < SUPERHARMONIC_SHARE)]
    drive, limits = rm.SineSquared(values["b"], 1.0), tuple(natural * x for x in share)
    ds = rm.resonances(body, drive, limits, slices=1, tolerance=tolerance)
    for k in range(ds.sizes["peak"]):
        one = ds.isel(peak=k)
        top = _top(values, float(one.omega), _start(one))
        if top is None:
            continue
        omega, exact = top
        if abs(exact.amplitude - float(one.amplitude)) > 1e-4 * exact.amplitude:
            continue  # another orbit
        case = f"{values}, peak {k}"
        numbers = {"omega": omega, "amplitude": exact.amplitude}
        harmonics = _harmonics(exact)
        off = np.abs(one.harmonics.values - harmonics).max()
        size = float(np.abs(harmonics).max())
        yield "harmonics", Judged(case, tolerance, True, float(one.harmonics_error), off, size)
        number = int(one.order_p)
        if number:
            # sin^2 = (1 - cos)/2: the load's first harmonic points the other way
            lag = number * np.pi - np.angle(harmonics[number])
            found = float(one.phase_lag)
            numbers["phase_lag"] = found + float(np.angle(np.exp(1j * (lag - found))))
            powers = np.abs(harmonics[1:]) ** 2
            numbers["share"] = float(powers[number - 1] / powers.sum())
            free = _free_frequency(values, exact.amplitude, float(one.free_frequency))
            if free is not None:
                numbers["free_frequency"] = free
                numbers["detuning"] = number * 2.0 * omega / free - 1.0
        for name, number_ in numbers.items():
            true = abs(float(one[name]) - number_)
            error = float(one[f"{name}_error"])
            yield name, Judged(case, tolerance, True, error, true, abs(number_))


def _of(name: str) -> Callable[[np.random.Generator], Iterator[Judged]]:
    return lambda rng: (judged for what, judged in _peaks(rng) if what == name)


ROWS = tuple(
    Row(f"{words} of resonances", f"resonances: {name}_error", _of(name))
    for name, words in (
        ("omega", "frequencies"),
        ("amplitude", "amplitudes"),
        ("phase_lag", "phase lags"),
        ("harmonics", "harmonics"),
        ("share", "shares of harmonics"),
        ("free_frequency", "free frequencies"),
        ("detuning", "detunings"),
    )
)
