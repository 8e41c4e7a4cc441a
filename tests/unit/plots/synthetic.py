"""Results of equation (16) made with SciPy, so that plots can be looked at without the engine."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, Literal

import numpy as np
import xarray as xr
from scipy.integrate import solve_ivp

import remanent as rm
from remanent._typing import FloatArray
from remanent.results import build, provenance

T0 = 293.0
TEMPERATURES = np.array([250.0, 350.0, 400.0])
PRESTRESSES = np.array([0.0, 1.0])
ACTUATOR = rm.Actuator()
LOOSE: dict[str, Any] = {"method": "RK45", "rtol": 1e-3, "atol": 1e-6}
Load = Callable[[float], FloatArray | float]


def solve(
    theta: FloatArray,
    s: FloatArray,
    load: Load,
    times: FloatArray,
    *,
    method: Literal["DOP853", "RK45"] = "DOP853",
    rtol: float = 1e-8,
    atol: float = 1e-10,
) -> tuple[FloatArray, FloatArray]:
    """Solve equation (16) with c = 1 from rest for many members at once; arrays (member, time)."""
    n = theta.size

    def rates(tau: float, y: FloatArray) -> FloatArray:
        x, v = y[:n], y[n:]
        force = 3 * (theta * (x**8 - x**2) - s * x**7 + load(tau) * x**4)
        return np.concatenate([v, (6 * v**2 - force) / (x**7 + 2 * x)])

    start = np.repeat(np.array([1.0, 0.0]), n)
    found = solve_ivp(
        rates, (0.0, float(times[-1])), start, method=method, t_eval=times, rtol=rtol, atol=atol
    )
    return found.y[:n], found.y[n:]


def observed(stretch: FloatArray, rate: FloatArray) -> dict[str, FloatArray]:
    """Thickness stretch and its rate."""
    return {"thickness_stretch": stretch**-2, "thickness_stretch_rate": -2 * stretch**-3 * rate}


def energy(
    stretch: FloatArray, rate: FloatArray, theta: FloatArray, s: FloatArray, m: float
) -> FloatArray:
    """Energy per 8 H L^2 mu with c = 1."""
    kinetic = (1 + 2 * stretch**-6) * rate**2 / 3
    elastic = theta * (2 * stretch**2 + stretch**-4 - 3) / 2
    return kinetic + elastic - 2 * s * (stretch - 1) - m * stretch**-2


def _grid() -> tuple[FloatArray, FloatArray]:
    s, t = np.meshgrid(PRESTRESSES, TEMPERATURES, indexing="ij")
    return t.ravel() / T0, s.ravel()


def _coords(**more: build.Labelled) -> dict[str, build.Labelled]:
    return {
        "prestress": (("prestress",), PRESTRESSES),
        "temperature": (("temperature",), TEMPERATURES),
        **more,
    }


@cache
def constant(duration: float = 20.0, points: int = 1001) -> xr.Dataset:
    """Make the set-up of figures 2 and 3: (prestress, temperature, time)."""
    theta, s = _grid()
    times = np.linspace(0.0, duration, points)
    found = observed(*solve(theta, s, lambda _: 0.16, times))
    dims = ("prestress", "temperature", "time")
    return build.dataset(
        {name: (dims, values.reshape(2, 3, -1)) for name, values in found.items()},
        _coords(time=(("time",), times)),
        provenance.attributes(ACTUATOR, rm.Constant(0.16), 1e-9, over=["prestress", "temperature"]),
    )


@cache
def frequency_response(points: int = 61, duration: float = 50.0) -> xr.Dataset:
    """Make the set-up of figure 4: (prestress, temperature, omega)."""
    omega = np.linspace(0.5, 2.0, points)
    theta, s = (np.repeat(x, points) for x in _grid())
    w = np.tile(omega, 6)
    times = np.linspace(0.0, duration, int(20 * duration))
    stretch, _ = solve(theta, s, lambda tau: (0.4 * np.sin(w * tau)) ** 2, times, rtol=1e-7)
    x = stretch**-2
    amplitude = ((x.max(axis=1) - x.min(axis=1)) / 2).reshape(2, 3, points)
    at = omega[amplitude.argmax(axis=-1)]
    two = ("prestress", "temperature")
    return build.dataset(
        {
            "amplitude": ((*two, "omega"), amplitude),
            "maximum": ((*two, "omega"), x.max(axis=1).reshape(2, 3, points)),
            "minimum": ((*two, "omega"), x.min(axis=1).reshape(2, 3, points)),
            "resonance": (two, at),
            "resonance_error": (two, np.full((2, 3), 0.004)),
            "published": (two, np.array([[1.05, 1.25, 1.35], [0.85, 1.08, 1.19]])),
        },
        _coords(omega=(("omega",), omega)),
        provenance.attributes(
            ACTUATOR, rm.SineSquared(0.4, 1.0), 1e-9,
            over=["prestress", "temperature"], duration=duration,
        ),
    )  # fmt: skip


def drive(omega: float) -> Load:
    """Return the published load at one frequency."""
    return lambda tau: (0.4 * np.sin(omega * tau)) ** 2


@cache
def forced(prestress: float, omega: float, duration: float = 100.0) -> xr.Dataset:
    """Make the history of figures 5 and 6: (temperature, time)."""
    times = np.linspace(0.0, duration, int(duration * 20) + 1)
    s = np.full(3, prestress)
    found = observed(*solve(TEMPERATURES / T0, s, drive(omega), times))
    return build.dataset(
        {name: (("temperature", "time"), values) for name, values in found.items()},
        {"time": (("time",), times), "temperature": (("temperature",), TEMPERATURES),
         "prestress": ((), np.array(prestress)), "omega": ((), np.array(omega))},
        provenance.attributes(
            ACTUATOR.replace(prestress=prestress),
            rm.SineSquared(0.4, omega), 1e-9, over=["temperature"],
        ),
    )  # fmt: skip


@cache
def sections(prestress: float, omega: float, periods: int = 200) -> xr.Dataset:
    """Make the section of figures 5 and 6, every drive period: (temperature, period)."""
    numbers = np.arange(periods + 1)
    times = np.linspace(0.0, periods * np.pi / omega, periods + 1)
    s = np.full(3, prestress)
    found = observed(*solve(TEMPERATURES / T0, s, drive(omega), times))
    return build.dataset(
        {name: (("temperature", "period"), values) for name, values in found.items()},
        {"period": (("period",), numbers), "temperature": (("temperature",), TEMPERATURES),
         "prestress": ((), np.array(prestress)), "omega": ((), np.array(omega))},
        provenance.attributes(
            ACTUATOR.replace(prestress=prestress),
            rm.SineSquared(0.4, omega), 1e-9, over=["temperature"],
            periods=periods,
        ),
    )  # fmt: skip


def _potential(x: FloatArray, theta: FloatArray, s: FloatArray, m: float) -> FloatArray:
    return theta * (2 / x + x**2 - 3) / 2 - 2 * s * (x**-0.5 - 1) - m * x


@cache
def potential(m: float = 0.16) -> xr.Dataset:
    """Make the potentials of figure 2: (prestress, temperature, thickness_stretch)."""
    x = np.linspace(0.15, 1.8, 1651)
    theta = (TEMPERATURES / T0)[None, :, None]
    u = _potential(x, theta, PRESTRESSES[:, None, None], m)
    well = u.argmin(axis=-1)
    inside = u <= -m + 1e-9
    two = ("prestress", "temperature")
    lowest = np.take_along_axis(u, well[..., None], axis=-1)
    last = x[x.size - 1 - inside[..., ::-1].argmax(axis=-1)]
    return build.dataset(
        {
            "potential": ((*two, "thickness_stretch"), u),
            "level": (two, np.full((2, 3), -m)),
            "turning_lower": (two, x[inside.argmax(axis=-1)]),
            "turning_upper": (two, last),
            "equilibrium_stretch": ((*two, "equilibrium"), x[well][..., None]),
            "equilibrium_potential": ((*two, "equilibrium"), lowest),
            "stability": ((*two, "equilibrium"), np.full((2, 3, 1), "stable")),
        },
        _coords(thickness_stretch=(("thickness_stretch",), x)),
        provenance.attributes(ACTUATOR, rm.Constant(m), 1e-9),
    )


def solvers() -> Sequence[str]:
    """Name the two integrations of the tolerance story."""
    return ("converged ($10^{-9}$)", "ode45 default ($10^{-3}$)")


@cache
def two_tolerances(periods: int = 200) -> xr.Dataset:
    """Make sections, converged and not: (solver, prestress, temperature, period)."""
    out = np.empty((2, 2, 2, 3, periods + 1))
    for j, (s, omega) in enumerate(((0.0, 1.25), (1.0, 1.08))):
        times = np.linspace(0.0, periods * np.pi / omega, periods + 1)
        for k, options in enumerate(({}, LOOSE)):
            for i, t in enumerate(TEMPERATURES / T0):
                y = solve(np.array([t]), np.array([s]), drive(omega), times, **options)
                found = observed(*y)
                out[0, k, j, i] = found["thickness_stretch"]
                out[1, k, j, i] = found["thickness_stretch_rate"]
    dims = ("solver", "prestress", "temperature", "period")
    return build.dataset(
        {"thickness_stretch": (dims, out[0]), "thickness_stretch_rate": (dims, out[1])},
        _coords(
            solver=(("solver",), np.array(solvers())),
            period=(("period",), np.arange(periods + 1)),
            omega=(("prestress",), np.array([1.25, 1.08])),
        ),
        provenance.attributes(ACTUATOR, rm.SineSquared(0.4, 1.0), None,
                              over=["prestress", "temperature", "omega"], periods=periods),
    )  # fmt: skip


@cache
def drift(duration: float = 100.0) -> xr.Dataset:
    """Make the energy drift under constant load: (solver, prestress, temperature, time)."""
    times = np.linspace(0.0, duration, 501)
    out = np.empty((2, 2, 3, times.size))
    for k, options in enumerate(({}, LOOSE)):
        for j, s in enumerate(PRESTRESSES):
            for i, t in enumerate(TEMPERATURES / T0):
                theta, prestress = np.array([t]), np.array([s])
                y = solve(theta, prestress, lambda _: 0.16, times, **options)
                e = energy(*y, theta, prestress, 0.16)[0]
                out[k, j, i] = e - e[0]
    return build.dataset(
        {"energy_drift": (("solver", "prestress", "temperature", "time"), out)},
        _coords(solver=(("solver",), np.array(solvers())), time=(("time",), times)),
        provenance.attributes(ACTUATOR, rm.Constant(0.16), None),
    )


def valley() -> xr.Dataset:
    """Make a misfit that looks like the real one: (law, window, reference_temperature, b)."""
    laws = np.array([r"$(b_0\sin\omega\tau)^2$", r"$(b_0\cos\omega\tau)^2$"])
    windows, t0 = np.array([50.0, 80.0, 100.0]), np.linspace(280.0, 310.0, 31)
    b = np.linspace(0.3, 0.5, 41)
    law = np.array([0.0, 0.02])[:, None, None, None]
    w = windows[None, :, None, None]
    ridge = (t0[:, None] - 293.0) / 80.0 + (b[None, :] - 0.4) * 1.2 + (w - 100.0) * 2e-3
    misfit = np.hypot(0.0075 + law, ridge) + 0.1 * np.abs(b - 0.4)
    return build.dataset(
        {"misfit": (("law", "window", "reference_temperature", "b"), misfit)},
        {
            "law": (("law",), laws),
            "window": (("window",), windows),
            "reference_temperature": (("reference_temperature",), t0),
            "b": (("b",), b),
        },
        provenance.attributes(ACTUATOR, rm.SineSquared(0.4, 1.0), 1e-6,
                              over=["b", "reference_temperature"]),
    )  # fmt: skip


def two_wells() -> xr.Dataset:
    """Make a potential with two stable equilibria and an unstable one between them."""
    x, m, s = np.linspace(0.2, 3.2, 901), 2.2, 2.08
    u = _potential(x, np.array(1.0), np.array(s), m)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(u)))) + 1
    words = np.where(np.diff(u, 2)[turns - 1] > 0, "stable", "unstable")
    return build.dataset(
        {
            "potential": (("thickness_stretch",), u),
            "equilibrium_stretch": (("equilibrium",), x[turns]),
            "equilibrium_potential": (("equilibrium",), u[turns]),
            "stability": (("equilibrium",), words),
        },
        {"thickness_stretch": (("thickness_stretch",), x), "prestress": ((), np.array(s))},
        provenance.attributes(ACTUATOR, rm.Constant(m), 1e-9),
    )


def basins_of_two() -> xr.Dataset:
    """Two attractors: left of stretch 1 and right of it, one initial state undecided."""
    x, v = np.linspace(0.6, 1.4, 9), np.linspace(-1.0, 1.0, 5)
    basin = np.where(x[:, None] < 1.0, 0, 1) * np.ones(v.size, dtype=int)
    basin[0, 0] = -1
    grid = ("initial.stretch", "initial.stretch_rate")
    found = build.dataset(
        {
            "basin": (grid, basin),
            "regime": (grid, np.where(basin < 0, "undecided", "periodic")),
            "attractor_regime": (("attractor",), np.array(["periodic", "chaotic"])),
            "attractor_period": (("attractor",), np.array([3, 0])),
            "attractor_state": (("attractor", "state"), np.array([[0.7, 0.1], [1.2, -0.5]])),
            "fraction": (("attractor",), np.array([0.4, 0.58])),
            "fraction_error": (("attractor",), np.array([0.01, 0.02])),
        },
        {
            grid[0]: ((grid[0],), x),
            grid[1]: ((grid[1],), v),
            "state": (("state",), np.array(["stretch", "stretch_rate"])),
        },
        provenance.attributes(ACTUATOR, rm.SineSquared(0.4, 1.2), 1e-9, over=grid),
    )
    return found.rename({name: name.removeprefix("initial.") for name in grid})


def fold() -> xr.Dataset:
    """A branch with multipliers 1 + s and 1/2, s = amplitude - 1: a fold at omega = 1 - s^2."""
    s = np.linspace(-0.5, 0.5, 41)
    pair = np.stack([1.0 + s, np.full_like(s, 0.5)], axis=1).astype(complex)
    kinds = np.where(s < 0.0, "stable", "saddle")
    return build.dataset(
        {
            "omega": (("point",), 1.0 - s**2),
            "amplitude": (("point",), 1.0 + s),
            "multipliers": (("point", "multiplier"), pair),
            "stability": (("point",), kinds),
            "special_kind": (("special",), np.array(["fold"])),
            "special_omega": (("special",), np.array([1.0])),
            "special_amplitude": (("special",), np.array([1.0])),
        },
        {},
        provenance.attributes(ACTUATOR, rm.SineSquared(0.4, 1.0), 1e-9),
    )


def diagram() -> xr.Dataset:
    """A fold at omega = 1.2 for every prestress and temperature."""
    s = np.linspace(-0.5, 0.5, 41)
    cases = (PRESTRESSES.size, TEMPERATURES.size)
    along = ("prestress", "temperature", "branch", "point")
    spot = ("prestress", "temperature", "special")

    def everywhere(values: Any, ndim: int) -> Any:
        one = np.asarray(values)
        return np.broadcast_to(one, (*cases, *(1,) * (ndim - one.ndim), *one.shape))

    return build.dataset(
        {
            "omega": (along, everywhere(1.2 - s**2, 2)),
            "amplitude": (along, everywhere(0.6 + s, 2)),
            "stability": (along, everywhere(np.where(s < 0.0, "elliptic", "saddle"), 2)),
            "special_kind": (spot, everywhere(["fold"], 1)),
            "special_omega": (spot, everywhere([1.2], 1)),
            "special_amplitude": (spot, everywhere([0.6], 1)),
        },
        _coords(),
        provenance.attributes(ACTUATOR, rm.SineSquared(0.4, 1.0), 1e-9),
    )


def resonance_orbits() -> xr.Dataset:
    """Two orbits at a resonance near 1.15, the third missing."""
    at = ("prestress", "temperature")
    return build.dataset(
        {"amplitude": ((*at, "orbit"), np.tile([0.4, 0.8, np.nan], (2, 3, 1)))},
        _coords(omega=(at, np.full((2, 3), 1.15))),
        provenance.attributes(ACTUATOR, rm.SineSquared(0.4, 1.0), 1e-9),
    )


def beside_a_saddle() -> xr.Dataset:
    """Two motions that part at (1.4, 0)."""
    t = np.linspace(-3.0, 3.0, 30)
    x = np.stack([1.4 - 0.4 * np.tanh(t) ** 2, 1.4 + 0.4 * np.sinh(t) / 10.0])
    return build.dataset(
        {"stretch": (("omega", "period"), x), "stretch_rate": (("omega", "period"), 1.4 - x)},
        {"omega": (("omega",), 1.15 + 1e-6 * np.array([-1.0, 1.0])),
         "period": (("period",), np.arange(30))},
        provenance.attributes(ACTUATOR, rm.SineSquared(0.4, 1.0), 1e-6, over=("omega",)),
    )  # fmt: skip


def crossing() -> xr.Dataset:
    """Where they part."""
    values = {"omega": 1.15, "omega_error": 1e-9, "stretch": 1.4, "stretch_rate": 0.0}
    return build.dataset({n: ((), np.array(v)) for n, v in values.items()}, {}, {})


def regimes() -> xr.Dataset:
    """A chart with every kind of cell but one."""
    names = ["quasi-periodic", "undecided", "chaotic", "quasi-periodic"]
    at = ("b", "omega")
    return build.dataset(
        {
            "regime": (at, np.array([names, names[::-1]])),
            "exponent": (at, np.array([[0.0, 0.0, 0.1, 0.0], [0.0, 0.05, 0.0, 0.0]])),
            "rotation_number": (at, np.array([[0.1, np.nan, np.nan, 0.4]] * 2)),
        },
        {"b": (("b",), np.array([0.5, 3.0])), "omega": (("omega",), np.arange(1.0, 5.0))},
        provenance.attributes(ACTUATOR, rm.SineSquared(0.4, 1.0), 1e-6, over=at),
    )


def cases() -> xr.Dataset:
    """The published places in such a chart."""
    return build.dataset(
        {"omega": (("temperature",), 1.25 * np.sqrt(T0 / TEMPERATURES)),
         "b": (("temperature",), 0.4 * np.sqrt(T0 / TEMPERATURES))},
        {"temperature": (("temperature",), TEMPERATURES)}, {},
    )  # fmt: skip


def with_scales(dataset: xr.Dataset) -> xr.Dataset:
    """Add the scales of the physics page's realistic set."""
    scales = {"time_s": 7.07e-4, "frequency_hz": 225.1, "load_T": 0.879, "stress_pa": 1e5}
    return dataset.assign_attrs(scales=json.dumps(scales))
