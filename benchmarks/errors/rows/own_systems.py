"""Equilibria of systems that users write, against mpmath in fifty digits."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

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


def _row(name: str, variable: str, kind: str) -> Row:
    return Row(name, variable, lambda rng: (one for k, one in _equilibria(rng) if k == kind))


ROWS = (
    _row("places of equilibria of own systems", "equilibria: x_error, y_error", "places"),
    _row("frequencies of own systems", "equilibria: natural_frequency_error", "frequencies"),
    _row("eigenvalues of own systems at rest", "equilibria: eigenvalues_error", "eigenvalues"),
)
