"""Branches and special points of forced oscillators by AUTO-07p, refined by shooting.

``python -m tests.literature.auto.make_reference`` from the root of the repository writes
``reference/*.json`` beside this file; README.md says what is in them.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import heyoka as hy
import mpmath as mp
import numpy as np
from scipy.interpolate import BarycentricInterpolator
from scipy.optimize import brentq

from remanent._typing import FloatArray
from tests.literature.auto import runner, shooting, systems
from tests.literature.auto.runner import Run, Solution
from tests.literature.auto.shooting import Flow

OUT = Path(__file__).parent / "reference"
NODES = np.linspace(0.0, 1.0, 401)
POINTS = 80
#: Grid points along each side of the box that is searched for orbits.
SIDE = 80
#: A second reference at this tolerance shows what the first is worth.
LOOSER = 1e-16


@dataclass(frozen=True)
class System:
    """An equation, its parameters by name and the one that varies."""

    rates: shooting.Rates
    equations: str
    par: dict[str, float]
    free: str
    text: str

    @property
    def bvp(self) -> bool:
        """AUTO's file has the phase as a state and starts at phase 0."""
        return self.equations == "actuator"

    def flow(self, tolerance: float = shooting.TOLERANCE) -> Flow:
        return Flow.build(self.rates, list(self.par), self.free, tolerance=tolerance)

    def at(self, value: float) -> FloatArray:
        return np.array(list({**self.par, self.free: value}.values()))


# ------------------------------------------------------------------ from and to AUTO


def start(system: System, flow: Flow, executable: Path, value: float, guess: Any) -> Any:
    """Write an orbit for AUTO to start from; its initial state comes back."""
    par = system.at(value)
    state, _, _ = shooting.orbit(flow, par, guess)
    path = flow.path(state, par, NODES)
    angle = 2 * np.pi * NODES
    if system.bvp:
        rest, extra = [NODES], list(par)
    else:
        rest, extra = [np.cos(angle), -np.sin(angle)], [*par, 2 * np.pi / par[0]]
    runner.write_start(executable.parent, extra, np.column_stack([NODES, path, *rest]))
    return state


def at_phase_zero(solution: Solution) -> FloatArray:
    """State at phase 0 of the drive, from AUTO's polynomial on the interval that holds it."""
    u, t, n = solution.u, solution.t, solution.ncol
    if u.shape[1] == 3:
        return u[0, :2]
    angle = np.unwrap(np.arctan2(-u[:, 3], u[:, 2])) / (2 * np.pi)
    target = np.ceil(angle[0] - 1e-13)
    candidates: list[FloatArray] = []
    while target < angle[-1] - 1e-9 or not candidates:
        k = min(max(int(np.searchsorted(angle, target)) - 1, 0) // n * n, len(t) - 1 - n)
        piece = slice(k, k + n + 1)
        polynomial = BarycentricInterpolator(t[piece], u[piece])

        def phase(time: float, polynomial: Any = polynomial, target: float = target) -> float:
            value = polynomial(time)
            raw = np.arctan2(-value[3], value[2]) / (2 * np.pi) - target
            return float(raw - np.round(raw))

        when = brentq(phase, t[k], t[k + n], xtol=1e-15) if phase(t[k]) < 0 else t[k]
        candidates.append(polynomial(when)[:2])
        target += 1
    return np.asarray(min(candidates, key=lambda state: float(state[0])))


# ------------------------------------------------------------------ refinement


def extremes(flow: Flow, state: Any, par: Any, period: int) -> tuple[float, float]:
    """Smallest and largest x over the orbit."""
    nodes = np.linspace(0.0, float(period), 240 * period + 1)
    x, v = flow.path(state, par, nodes).T
    span = np.ptp(x)
    values = [float(x[0])]
    for k in np.flatnonzero(np.diff(np.sign(v)) != 0):
        near = x[k : k + 2]
        if near.max() < x.max() - 0.02 * span and near.min() > x.min() + 0.02 * span:
            continue

        def rate(s: float) -> float:
            return float(flow.jet(state, par, s)[0][1])

        ends = [rate(nodes[k]), rate(nodes[k + 1])]
        if ends[0] * ends[1] < 0:
            s = brentq(rate, nodes[k], nodes[k + 1], xtol=1e-10)
            values.append(float(flow.jet(state, par, s)[0][0]))
        else:
            values.extend(float(z) for z in near)
    return min(values), max(values)


def branch(system: System, flow: Flow, run: Run, name: str, *, period: int = 1) -> dict[str, Any]:
    """Points of a run, thinned, each solved again by shooting at AUTO's parameter."""
    index = list(system.par).index(system.free)
    regular = [q for q in run.solutions if q.kind in {"", "EP", "UZ"}]
    chosen = np.unique(np.linspace(0, len(regular) - 1, POINTS).astype(int))
    columns: dict[str, list[Any]] = {key: [] for key in KEYS}
    for q in (regular[i] for i in chosen):
        value, found = float(q.par[index]), at_phase_zero(q)
        state, matrix, _ = shooting.orbit(flow, system.at(value), found, period=period)
        low, high = extremes(flow, state, system.at(value), period)
        factors = shooting.multipliers(matrix)
        row = [value, *map(float, state), complex_list(factors), low, high, *map(float, found)]
        for key, entry in zip(KEYS, row, strict=True):
            columns[key].append(entry)
    refined = np.array([columns["x"], columns["v"]])
    auto = np.array([columns["auto_x"], columns["auto_v"]])
    return {
        "name": name,
        "period": period,
        "points_by_auto": run.points,
        "largest_difference_from_auto": float(np.max(np.abs(refined - auto))),
        "points": {system.free: columns.pop("value"), **columns},
    }


KEYS = ("value", "x", "v", "multipliers", "minimum", "maximum", "auto_x", "auto_v")


def complex_list(values: Any) -> list[list[float]]:
    """Complex numbers as [real, imaginary], the larger modulus first."""
    ordered = sorted(values, key=lambda z: (-round(float(abs(z)), 14), float(z.imag)))
    return [[float(z.real), float(z.imag)] for z in ordered]


Solver = Callable[[Flow, Any, Any], tuple[Any, Any, Any, float]]


def special(
    system: System, flow: Flow, looser: Flow, found: Solution, kind: str, solver: Solver
) -> dict[str, Any]:
    """A special point by AUTO and refined, with what a looser reference makes of it."""
    index = list(system.par).index(system.free)
    value, state = float(found.par[index]), at_phase_zero(found)
    return refined_special(
        system, flow, looser, kind, solver, (value, state),
        auto={system.free: value, "x": float(state[0]), "v": float(state[1])},
    )  # fmt: skip


def refined_special(
    system: System,
    flow: Flow,
    looser: Flow,
    kind: str,
    solver: Solver,
    guess: tuple[float, Any],
    *,
    auto: Mapping[str, float] | None,
) -> dict[str, Any]:
    """The same from a guess that need not be AUTO's."""
    value, state, factors, step = solver(flow, system.at(guess[0]), guess[1])
    other, _, _, _ = solver(looser, system.at(guess[0]), guess[1])
    entry: dict[str, Any] = {
        "kind": kind,
        system.free: float(value),
        "digits": f"{value:.20g}",
        "x": float(state[0]),
        "v": float(state[1]),
        "multipliers": complex_list(factors),
        "accuracy": {"last_step": step, "looser_tolerance": abs(float(value - other))},
        "auto": auto,
    }
    if auto is not None:
        entry["accuracy"]["auto_differs_by"] = abs(float(value) - auto[system.free])
    print(f"  {kind} {entry['digits']}  auto {auto}  {entry['accuracy']}")
    return entry


def general(kind: str, *, period: float = 1.0, image: int = 1) -> Solver:
    """A fold, period doubling or torus point of any orbit."""

    def solver(flow: Flow, par: Any, state: Any) -> tuple[Any, Any, Any, float]:
        return shooting.special(flow, par, state, kind, period=period, image=image)

    return solver


def symmetric(kind: str) -> Solver:
    """The same for an orbit symmetric in time."""

    def solver(flow: Flow, par: Any, state: Any) -> tuple[Any, Any, Any, float]:
        return shooting.symmetric_special(flow, par, state[0], kind)

    return solver


def write(name: str, system: System, **content: Any) -> None:
    """One file, one row a branch's column."""
    head = {
        "equation": system.text,
        "parameters": {key: value for key, value in system.par.items() if key != system.free},
        "free": system.free,
        "versions": {"auto": runner.AUTO_VERSION, "heyoka": version("heyoka")},
    }
    text = json.dumps({**head, **content}, indent=1)
    OUT.mkdir(exist_ok=True)
    (OUT / f"{name}.json").write_text(compact(text) + "\n")


def compact(text: str) -> str:
    """Put arrays of numbers on one line each."""
    lines: list[str] = []
    depth = 0
    for line in text.split("\n"):
        bare = line.strip()
        if depth == 0:
            lines.append(line)
        else:
            lines[-1] += bare if bare[0] in "]" else (" " if lines[-1][-1] == "," else "") + bare
        if bare.endswith("[") and not bare.startswith(('"branches"', '"special"')):
            depth += 1
        elif bare.startswith("]") and depth:
            depth -= 1
    return "\n".join(lines)


# ------------------------------------------------------------------ the systems

ACTUATOR = {"omega": 0.0, "theta": 350.0 / 293.0, "S": 0.0, "b": 0.4, "c": 1.0, "eta": 0.0}
OSCILLATOR = {"omega": 0.0, "d": 0.0, "g": 0.0, "a": 1.0, "e": 0.0, "k": 0.0, "F": 0.0}
SECOND = "x'' + (d + g x^2) x' + (a + e cos(omega t)) x + k x^3 = F cos(omega t)"


def actuator(scratch: Path) -> None:
    """Period-1 branches of equation (16), undamped."""
    text = "equation (16), m = (b sin(omega tau))^2, drive period pi/omega; x = stretch"
    system = System(systems.actuator, "actuator", ACTUATOR, "omega", text)
    flow, looser = system.flow(), system.flow(LOOSER)
    executable = runner.compile_equations("actuator", scratch)
    starts = {
        "upper": (1.6, 0.965, -0.01, 0.01),
        "superharmonic": (0.6, 1.0023, 0.01, 0.02),
        "main": (0.6, 1.9189, 0.01, 0.02),
    }
    branches, points = [], []
    for name, (omega, stretch, ds, largest) in starts.items():
        start(system, flow, executable, omega, [stretch, 0.0])
        run = runner.run(executable, "actuator", DS=ds, DSMAX=largest, dat="start")
        branches.append(branch(system, flow, run, name))
        for q in run.solutions:
            if q.kind == "LP":
                found = special(system, flow, looser, q, "LP", symmetric("LP"))
                points.append({"branch": name, **found})
    # Undamped, the multipliers stay on the unit circle but for tiny windows that AUTO's
    # test functions, made for damped systems, do not see.
    for kind, guess in (("PD", 0.88), ("PD*", 0.885)):
        found = refined_special(
            system, flow, looser, "PD", symmetric(kind), (guess, [1.0095, 0.0]), auto=None
        )
        points.append({"branch": "main", **found})
    points.sort(key=lambda point: float(point["omega"]))
    write("actuator", system, branches=branches, special=points, search=search(system, flow))


def damped_actuator(scratch: Path) -> None:
    """The same with a Rayleigh dashpot: one branch, two folds."""
    text = (
        "equation (16) with eta x' added inside its bracket, m = (b sin(omega tau))^2, "
        "drive period pi/omega; x = stretch"
    )
    par = {**ACTUATOR, "eta": 0.02}
    system = System(systems.actuator, "actuator", par, "omega", text)
    flow, looser = system.flow(), system.flow(LOOSER)
    executable = runner.compile_equations("actuator", scratch)
    start(system, flow, executable, 0.6, [1.0023, 0.0])
    run = runner.run(executable, "actuator", DS=0.002, DSMAX=0.02, dat="start", SP=["TR0"])
    branches = [branch(system, flow, run, "main")]
    points = [
        special(system, flow, looser, q, q.kind, general(q.kind))
        for q in run.solutions
        if q.kind in {"LP", "PD"}
    ]
    write("actuator_damped", system, branches=branches, special=points,
          search=search(system, flow))  # fmt: skip


def search(system: System, flow: Flow) -> dict[str, Any]:
    """Every orbit in a box at some omega: [x, v] for each.

    The displacement after one period is computed on a fine grid; Newton's method starts from
    the middle of every cell over whose corners both components change sign.
    """
    found: dict[str, Any] = {}
    xs, vs = np.geomspace(0.3, 4.0, SIDE), np.linspace(-3.0, 3.0, SIDE)
    grid = np.stack(np.meshgrid(xs, vs, indexing="ij"))
    for omega in (0.65, 0.8, 1.15, 1.25, 1.4):
        par = system.at(omega)
        signs = np.sign(_ends(system, par, grid) - grid)
        cells = sum(signs[:, i : SIDE - 1 + i, j : SIDE - 1 + j] for i in (0, 1) for j in (0, 1))
        orbits: list[FloatArray] = []
        for i, j in np.argwhere((np.abs(cells) < 4).all(axis=0)):
            middle = [np.sqrt(xs[i] * xs[i + 1]), (vs[j] + vs[j + 1]) / 2]
            try:
                state, _, _ = shooting.orbit(flow, par, middle, iterations=10)
            except ArithmeticError:
                continue
            inside = 0.3 <= state[0] <= 4.0 and abs(state[1]) < 3.0
            if inside and all(np.max(np.abs(state - o)) > 1e-8 for o in orbits):
                orbits.append(state)
        found[f"{omega}"] = sorted([float(o[0]), float(o[1])] for o in orbits)
        print("  orbits at", omega, found[f"{omega}"])
    return found


def _ends(system: System, par: FloatArray, grid: FloatArray) -> FloatArray:
    """States after one period from the states (2, SIDE, SIDE)."""
    x, v = hy.make_vars("x", "v")
    dx, dv = system.rates(x, v, hy.time, [hy.par[i] for i in range(len(par))])
    lanes = 8
    ta = hy.taylor_adaptive_batch(
        [(x, dx), (v, dv)], np.zeros((2, lanes)), pars=np.tile(par[:, None], lanes), tol=1e-12
    )
    starts = grid.reshape(2, -1, lanes)
    ends = np.empty_like(starts)
    for k in range(starts.shape[1]):
        ta.set_time(0.0)
        ta.state[:] = starts[:, k]
        ta.propagate_until([1.0] * lanes)
        ends[:, k] = ta.state
    return ends.reshape(grid.shape)


def oscillator(par: dict[str, float], free: str, note: str) -> System:
    """One of the textbook equations."""
    text = f"{SECOND}; drive period 2 pi/omega; {note}"
    return System(systems.oscillator, "oscillator", {**OSCILLATOR, **par}, free, text)


def duffing(scratch: Path) -> None:
    """Folds of the forced Duffing oscillator's response."""
    system = oscillator({"d": 0.1, "k": 1.0, "F": 1.0}, "omega", "Duffing")
    flow, looser = system.flow(), system.flow(LOOSER)
    executable = runner.compile_equations("oscillator", scratch)
    start(system, flow, executable, 4.0, [-0.06, 0.0])
    run = runner.run(executable, "oscillator", DS=-0.01, DSMAX=0.1, dat="start",
                     UZSTOP={1: [0.5, 4.0]})  # fmt: skip
    branches = [branch(system, flow, run, "response")]
    points = []
    for q in run.solutions:
        if q.kind == "LP":
            points.append(special(system, flow, looser, q, "LP", general("LP")))
        elif q.kind == "BP":
            solver = general("PD", period=0.5, image=-1)
            points.append(special(system, flow, looser, q, "BP", solver))
    write("duffing", system, branches=branches, special=points)


def van_der_pol(scratch: Path) -> None:
    """Torus points of the forced van der Pol oscillator."""
    system = oscillator({"d": -0.4, "g": 0.4, "F": 1.0}, "omega", "van der Pol, mu = 0.4")
    flow, looser = system.flow(), system.flow(LOOSER)
    executable = runner.compile_equations("oscillator", scratch)
    branches, points = [], []
    for name, ds in (("up", 0.01), ("down", -0.01)):
        start(system, flow, executable, 1.0, [-0.70443139, 2.478259])
        run = runner.run(executable, "oscillator", DS=ds, dat="start", UZSTOP={1: [0.5, 2.0]})
        branches.append(branch(system, flow, run, name))
        points += [
            {"branch": name, **special(system, flow, looser, q, "TR", general("TR"))}
            for q in run.solutions
            if q.kind == "TR"
        ]
    write("van_der_pol", system, branches=branches, special=points)


def double_well(scratch: Path) -> None:
    """Period doublings of the two-well Duffing oscillator, and the branches they start."""
    par = {"omega": 1.0, "d": 0.25, "a": -1.0, "k": 1.0}
    system = oscillator(par, "F", "two wells")
    flow, looser = system.flow(), system.flow(LOOSER)
    executable = runner.compile_equations("oscillator", scratch)
    start(system, flow, executable, 0.0, [1.0, 0.0])
    common: dict[str, Any] = {"ICP": [7, 11], "DSMAX": 0.02}
    run = runner.run(executable, "oscillator", DS=0.01, dat="start", UZSTOP={7: [-0.1, 0.4]},
                     **common)  # fmt: skip
    branches = [branch(system, flow, run, "period 1")]
    points = [
        {"branch": "period 1", **special(system, flow, looser, q, q.kind, general(q.kind))}
        for q in run.solutions
        if q.kind in {"LP", "PD"}
    ]
    period = 1
    while period < 4:
        doubling = next(q for q in run.solutions if q.kind == "PD")
        restart = (executable.parent / "fort.8").read_text()
        period *= 2
        name = f"period {period}"
        run = runner.run(executable, "oscillator", restart=restart, IRS=doubling.label,
                         ISW=-1, DS=0.005, NTST=100 * period, NMX=60 if period == 2 else 25,
                         UZSTOP={7: [-0.1, 0.4]}, **common)  # fmt: skip
        kept = Run([q for q in run.solutions if q.number > 2], run.seconds, run.points,
                   run.directory)  # fmt: skip
        branches.append(branch(system, flow, kept, name, period=period))
        points += [
            {
                "branch": name,
                **special(system, flow, looser, q, q.kind, general(q.kind, period=period)),
            }
            for q in run.solutions
            if q.kind in {"LP", "PD"}
        ]
    write("double_well", system, branches=branches, special=points)


# ------------------------------------------------------------------ Mathieu's equation


def hill(a: float, e: float, d: float, *, half: bool, terms: int = 24) -> Any:
    """Root in a, near `a`, of Hill's determinant: period 2 pi, or 4 pi with `half`."""
    mp.mp.dps = 40
    shift = mp.mpf(1) / 2 if half else mp.mpf(0)
    orders = [n + shift for n in range(-terms, terms if half else terms + 1)]

    def determinant(value: Any) -> Any:
        before, now = mp.mpc(0), mp.mpc(1)
        previous = mp.mpf(1)
        for nu in orders:
            scale = 1 + nu * nu
            entry = (value - nu * nu + 1j * mp.mpf(d) * nu) / scale
            coupling = (mp.mpf(e) / 2) ** 2 / (scale * previous)
            before, now, previous = now, entry * now - coupling * before, scale
        return now.real

    return mp.findroot(determinant, mp.mpf(a))


def mathieu(scratch: Path) -> None:
    """Boundaries of the first two tongues of the damped Mathieu equation."""
    system = oscillator({"omega": 1.0, "d": 0.1, "e": 0.5}, "a", "Mathieu; the orbit is x = 0")
    flow = system.flow()
    executable = runner.compile_equations("oscillator", scratch)
    points = []
    for e in (0.3, 0.5, 0.75, 1.0, 1.25, 1.5):
        here = System(system.rates, system.equations, {**system.par, "e": e}, "a", system.text)
        start(here, flow, executable, -0.6, [0.0, 0.0])
        run = runner.run(executable, "oscillator", ICP=[4, 11], DS=0.005, DSMAX=0.02,
                         dat="start", UZSTOP={4: [-0.7, 2.5]})  # fmt: skip
        for q in run.solutions:
            if q.kind in {"PD", "BP"}:
                points.append(tongue(here, flow, q, e))
    write("mathieu", system, special=points)


def tongue(system: System, flow: Flow, found: Solution, e: float) -> dict[str, Any]:
    """A boundary by AUTO, by shooting and by Hill's determinant."""
    a = float(found.par[3])
    sign = 1 if found.kind == "PD" else -1

    def equations(z: Any) -> tuple[Any, Any]:
        _, first, second = flow.jet([0, 0], system.at(z[0]))
        d, change = first[:, :2], second[:, :2, 2]
        trace, det = d[0, 0] + d[1, 1], d[0, 0] * d[1, 1] - d[0, 1] * d[1, 0]
        ddet = (
            change[0, 0] * d[1, 1] + d[0, 0] * change[1, 1]
            - change[0, 1] * d[1, 0] - d[0, 1] * change[1, 0]
        )  # fmt: skip
        slope = sign * (change[0, 0] + change[1, 1]) + ddet
        return np.array([1 + sign * trace + det]), np.array([[slope]])

    shot = shooting.newton(equations, [a])[0][0]
    exact = hill(a, e, system.par["d"], half=found.kind == "PD")
    entry = {
        "kind": found.kind, "e": e, "a": float(exact), "digits": mp.nstr(exact, 25),
        "accuracy": {"auto_differs_by": abs(a - float(exact)),
                     "shooting_differs_by": abs(float(shot) - float(exact))},
        "auto": {"a": a},
    }  # fmt: skip
    print(" ", entry)
    return entry


def main(names: Sequence[str] = ()) -> None:
    """Make the files named, or all."""
    makers = {m.__name__: m for m in (actuator, damped_actuator, duffing, van_der_pol,
                                      double_well, mathieu)}  # fmt: skip
    for name in names or makers:
        print(name)
        with tempfile.TemporaryDirectory() as scratch:
            makers[name](Path(scratch))


if __name__ == "__main__":
    import sys

    main(sys.argv[1:])
