"""Equilibria, folds and thresholds of systems that users write, against mpmath in fifty digits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.errors.row import Judged, Row, shared

#: Digits of the reference.
_DIGITS = 50
#: Half-width of the box of coordinates.
_REACH = 2.0


def _system(rng: np.random.Generator) -> tuple[rm.LagrangianSystem, dict[str, float]]:
    """Two coupled masses on springs that may push away from the middle, with a dashpot."""
    names = ("mass", "coupling", "first", "second", "hard", "eta")
    low, high = (0.5, -0.4, -1.0, 0.3, 0.2, 0.0), (2.0, 0.4, -0.2, 1.5, 1.0, 0.5)
    p = dict(zip(names, map(float, rng.uniform(low, high)), strict=True))
    p["eta"] = 0.0 if rng.random() < 0.5 else p["eta"]
    system = rm.LagrangianSystem(
        coordinates=("x", "y"),
        kinetic="(mass*x_rate**2 + y_rate**2)/2 + 0.3*x_rate*y_rate*cos(x)",
        potential="first*x**2/2 + hard*x**4/4 + second*y**2/2 + coupling*x*y - load*sin(x + y)",
        dissipation="eta*(x_rate - y_rate)**2/2",
        parameters=p,
    )
    return system, p


def _exact(place: Any, p: dict[str, float], m: float) -> tuple[Any, Any, Any]:
    """The equilibrium near a place, its eigenvalues, and squares of natural frequencies."""
    import mpmath as mp

    first, second, hard = (mp.mpf(p[name]) for name in ("first", "second", "hard"))
    coupling, load, eta = mp.mpf(p["coupling"]), mp.mpf(m), mp.mpf(p["eta"])

    def slopes(x: Any, y: Any) -> list[Any]:
        pull = load * mp.cos(x + y)
        return [first * x + hard * x**3 + coupling * y - pull, second * y + coupling * x - pull]

    x, y = mp.findroot(slopes, tuple(map(mp.mpf, place)))
    bend, off = load * mp.sin(x + y), mp.mpf("0.3") * mp.cos(x)
    stiffness = mp.matrix([[first + 3 * hard * x**2 + bend, coupling + bend],
                           [coupling + bend, second + bend]])  # fmt: skip
    inverse = mp.matrix([[mp.mpf(p["mass"]), off], [off, 1]]) ** -1
    spring, dashpot = -inverse * stiffness, -inverse * mp.matrix([[eta, -eta], [-eta, eta]])
    whole = mp.zeros(4)
    for i in range(2):
        whole[i, 2 + i] = 1
        for j in range(2):
            whole[2 + i, j], whole[2 + i, 2 + j] = spring[i, j], dashpot[i, j]
    eigenvalues = mp.eig(whole, left=False, right=False)
    return (x, y), eigenvalues, mp.eig(-spring, left=False, right=False)


def _nearest(value: Any, exact: Any) -> Any:
    """The exact value nearest to a computed one."""
    return min(exact, key=lambda one: abs(one - complex(value)))


@shared
def _equilibria(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """Numbers of all equilibria of one system, each with the kind that tells its row."""
    import mpmath as mp

    system, p = _system(rng)
    m = float(rng.uniform(-0.5, 0.5))
    box = {"x": (-_REACH, _REACH), "y": (-_REACH, _REACH)}
    found = rm.equilibria(system, m, state_box=box)
    for k in range(found.sizes["equilibrium"]):
        one = found.isel(equilibrium=k)
        with mp.workdps(_DIGITS):
            place, eigenvalues, squares = _exact((float(one.x), float(one.y)), p, m)
            numbers = [("places", one.x, one.x_error, place[0]),
                       ("places", one.y, one.y_error, place[1])]  # fmt: skip
            for j, value in enumerate(one.eigenvalues.values):
                nearest = _nearest(value, eigenvalues)
                numbers.append(("eigenvalues", value, one.eigenvalues_error[j], nearest))
            for j, value in enumerate(one.natural_frequency.values):
                if np.isfinite(value):
                    roots = [mp.sqrt(mp.re(s)) for s in squares if mp.re(s) > 0]
                    nearest = _nearest(value, roots)
                    error = one.natural_frequency_error[j]
                    numbers.append(("frequencies", value, error, nearest))
            for kind, value, error, exact in numbers:
                true = float(abs(mp.mpc(complex(value)) - exact))
                case, size = f"{p}, m={m!r}, equilibrium={k}", float(abs(exact))
                yield kind, Judged(case, 1e-12, p["eta"] > 0.0, float(error), true, size)


@shared
def _folds(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """Folds of two masses along the load, where the determinant of the stiffness vanishes."""
    import mpmath as mp

    system, p = _system(rng)
    box = {"x": (-_REACH, _REACH), "y": (-_REACH, _REACH)}
    found = rm.snap_through(system, "m", (-2.0, 2.0), state_box=box)
    first, second, hard, coupling = (
        mp.mpf(p[name]) for name in ("first", "second", "hard", "coupling")
    )

    def conditions(x: Any, y: Any, load: Any) -> list[Any]:
        pull, bend = load * mp.cos(x + y), load * mp.sin(x + y)
        return [
            first * x + hard * x**3 + coupling * y - pull,
            second * y + coupling * x - pull,
            (first + 3 * hard * x**2 + bend) * (second + bend) - (coupling + bend) ** 2,
        ]

    for k in range(found.sizes["fold"]):
        one = found.isel(fold=k)
        with mp.workdps(_DIGITS):
            names = ("fold_x", "fold_y", "fold_m")
            exact = mp.findroot(conditions, tuple(mp.mpf(float(one[name])) for name in names))
            for name, value in zip(names, exact, strict=True):
                yield "folds", _judged(f"{p}, fold={k}", one, name, value)


@shared
def _crossings(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """Where a symmetric pair buckles: k = -coupling^2/second, both at their middle."""
    names = ("shift", "second", "coupling", "hard")
    p = dict(zip(names, map(float, rng.uniform((-0.5, 0.4, 0.1, 0.3), (0.5, 1.5, 0.6, 1.0))),
                 strict=True))  # fmt: skip
    system = rm.LagrangianSystem(
        coordinates=("x", "y"),
        kinetic="(x_rate**2 + y_rate**2)/2",
        potential="-k*(x - shift)**2/2 + hard*(x - shift)**4/4 + second*y**2/2"
        " + coupling*(x - shift)*y - load*(x - shift)**2/2",
        parameters={**p, "k": 1.0},
    )
    box = {"x": (-_REACH, _REACH), "y": (-_REACH, _REACH)}
    found = rm.snap_through(system, "k", (-2.0, 1.9), state_box=box)
    exact = {"k": -(p["coupling"] ** 2) / p["second"], "x": p["shift"], "y": 0.0}
    for k in range(found.sizes["branch_point"]):
        one = found.isel(branch_point=k)
        for name, value in exact.items():
            yield "crossings", _judged(f"{p}", one, f"branch_point_{name}", value)


@shared
def _snaps(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """Loads at which motion from rest just reaches an unstable equilibrium."""
    import mpmath as mp

    p = dict(zip(("first", "second", "third", "start"),
                 map(float, rng.uniform((0.6, -0.2, -1.0, -0.5), (1.5, 0.2, -0.3, 0.5))),
                 strict=True))  # fmt: skip
    system = rm.LagrangianSystem(
        coordinates="x",
        kinetic="x_rate**2/2 + x_rate**2*x**2/10",
        potential="first*x**2/2 + second*x**3/3 + third*x**4/4 - load*sin(x)",
        observable="exp(x)",
        parameters={name: p[name] for name in ("first", "second", "third")},
    )
    found = rm.snap_through(
        system, "m", (-1.5, 1.5), initial=p["start"], state_box={"x": (-_REACH, _REACH)}
    )
    first, second, third, start = map(mp.mpf, p.values())

    def energy(x: Any, load: Any) -> Any:
        return first * x**2 / 2 + second * x**3 / 3 + third * x**4 / 4 - load * mp.sin(x)

    def conditions(x: Any, load: Any) -> list[Any]:
        slope = first * x + second * x**2 + third * x**3 - load * mp.cos(x)
        return [slope, energy(x, load) - energy(start, load)]

    for k in range(found.sizes["snap"]):
        one = found.isel(snap=k)
        with mp.workdps(_DIGITS):
            if float(one.snap_x) == p["start"]:
                continue  # a closed form
            names = ("snap_x", "snap_m")
            x, load = mp.findroot(conditions, tuple(mp.mpf(float(one[n])) for n in names))
            exact = {"snap_x": x, "snap_m": load, "snap_observable": mp.exp(x)}
            for name, value in exact.items():
                yield "snaps", _judged(f"{p}, snap={k}", one, name, value)


def _judged(case: str, one: xr.Dataset, name: str, exact: Any) -> Judged:
    """A number of a result beside the exact one."""
    import mpmath as mp

    true = float(abs(mp.mpf(float(one[name])) - exact))
    return Judged(case, 1e-12, False, float(one[f"{name}_error"]), true, float(abs(exact)))


_NUMBERS = {
    "places": _equilibria, "frequencies": _equilibria, "eigenvalues": _equilibria,
    "folds": _folds, "crossings": _crossings, "snaps": _snaps,
}  # fmt: skip


def _row(name: str, variable: str, kind: str) -> Row:
    return Row(name, variable, lambda rng: (one for k, one in _NUMBERS[kind](rng) if k == kind))


ROWS = (
    _row("places of equilibria of own systems", "equilibria: x_error, y_error", "places"),
    _row("frequencies of own systems", "equilibria: natural_frequency_error", "frequencies"),
    _row("eigenvalues of own systems at rest", "equilibria: eigenvalues_error", "eigenvalues"),
    _row("folds of own systems", "snap_through: fold_x_error, fold_y_error, fold_m_error", "folds"),
    _row(
        "branch points of own systems",
        "snap_through: branch_point_k_error, branch_point_x_error, branch_point_y_error",
        "crossings",
    ),
    _row(
        "thresholds of own systems",
        "snap_through: snap_x_error, snap_m_error, snap_observable_error",
        "snaps",
    ),
)
