"""Does the search for periodic orbits list every one, and nothing else?

    python -m benchmarks.orbit_search --cases 300

Random actuators, with and without damping, orbits of periods 1 to 5.  The reference is Newton's
method from a dense grid on the period map of heyoka.py, first with rough images and, near fixed
points, with fine ones; each point is then refined in extended precision.  Points that cannot be
told from a motion that nearly closes, where det(1 - DP^n) is below 1e-10 of the largest entry of
the matrix, are left out on both sides: they are counted as undecided.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import remanent as rm
from benchmarks.errors.period_map import PeriodMap
from remanent._typing import FloatArray

RESULTS = Path(__file__).parent / "results" / "orbit_search.json"
PAGE = Path(__file__).parent.parent / "docs" / "results" / "orbit_search.md"
#: Motions that the reference engine follows together.
BATCH = 8
#: Steps of Newton's method, and the longest component of one.
NEWTON_STEPS, LONGEST_STEP = 14, 0.25
#: Residual and step at which it has converged.
RESIDUAL, STEP = 1e-9, 1e-6
#: Errors of a step of the engine far from fixed points, and near them; residual that is near.
ROUGH, FINE, NEAR = 1e-7, 1e-13, 1e-3
#: Box at phase 0 in which orbits of undamped motion are looked for.
BOX = np.array([(0.3, 4.0), (-8.0, 8.0)])
#: Points nearer to each other than this are one.
SAME = 1e-5
#: Points where det(1 - DP^n) is a smaller share of the largest entry are undecided.
NEARLY_PARABOLIC = 1e-10


@dataclass(frozen=True)
class Case:
    """A random actuator and drive, and the period of the orbits that are looked for."""

    seed: int
    values: dict[str, float]
    orbit_period: int

    @property
    def damped(self) -> bool:
        return self.values["dissipation.0.eta"] > 0.0

    @property
    def drive(self) -> rm.SineSquared:
        return rm.SineSquared(self.values["b"], self.values["omega"])

    @property
    def actuator(self) -> rm.Actuator:
        v = self.values
        return rm.Actuator(
            c=v["c"], temperature=v["temperature"], prestress=v["prestress"],
            dissipation=rm.Rayleigh(v["dissipation.0.eta"]) if self.damped else (),
        )  # fmt: skip

    @classmethod
    def random(cls, seed: int) -> Case:
        """Every second case is damped."""
        rng, damped = np.random.default_rng([13, seed]), seed % 2 == 0
        values = {
            "c": 10.0 ** rng.uniform(-3.0 if damped else -1.0, 0.0),
            "temperature": 293.0 * rng.uniform(0.8, 1.3),
            "prestress": rng.uniform(-0.5, 1.0),
            "b": rng.uniform(0.1, 1.5),
            "omega": float(np.exp(rng.uniform(np.log(0.005 if damped else 0.3), np.log(4.0)))),
            "dissipation.0.eta": 10.0 ** rng.uniform(-2.0, 0.0) if damped else 0.0,
        }
        return cls(seed, values, int(rng.integers(1, 6)))


@dataclass(frozen=True)
class Compared:
    """What a search and the reference found."""

    seed: int
    damped: bool
    orbit_period: int
    omega: float
    listed: int
    reference: int
    missed: int
    not_orbits: int
    undecided: int
    incomplete: bool
    reason: str
    seconds: float
    reference_seconds: float


def compare(case: Case) -> Compared:
    """The search beside the brute force."""
    begin = time.perf_counter()
    found = rm.periodic_orbits(case.actuator, case.drive, orbit_period=case.orbit_period)
    seconds = time.perf_counter() - begin
    begin = time.perf_counter()
    orbits, undecided = reference_orbits(case)
    ours = found.initial.values.reshape(-1, 2)
    missed = sum(
        not any(np.abs(path - one).max(axis=1).min() <= SAME for one in ours) for path in orbits
    )
    wrong = 0
    for one in ours:
        refined = refine(case, one)
        if refined is None:
            undecided += 1
        elif np.abs(refined - one).max() > SAME or closes_early(case, refined):
            wrong += 1
    return Compared(
        case.seed, case.damped, case.orbit_period, case.values["omega"], len(ours), len(orbits),
        missed, wrong, undecided, int(found.status) == rm.Status.INCOMPLETE,
        str(found.reason.values), seconds, time.perf_counter() - begin,
    )  # fmt: skip


def reference_orbits(case: Case) -> tuple[list[FloatArray], int]:
    """Points at phase 0 of each orbit that brute force finds, and how many are undecided."""
    duration = case.orbit_period * np.pi / case.values["omega"]
    counts = (32, 20) if duration < 20.0 else (20, 12) if duration < 80.0 else (16, 12)
    reach = 1.0 if duration < 80.0 else 0.25
    (low, high), (slowest, fastest) = BOX
    stretches = np.geomspace(low, high, counts[0])
    rates = reach * np.linspace(slowest, fastest, counts[1])
    x, v = np.meshgrid(stretches, rates, indexing="ij")
    points = newton(case, np.column_stack([x.ravel(), v.ravel()]))
    orbits: list[FloatArray] = []
    undecided = 0
    for point in points[np.unique(np.round(points, 6), axis=0, return_index=True)[1]]:
        if any(np.abs(path - point).max(axis=1).min() <= SAME for path in orbits):
            continue
        refined = refine(case, point)
        if refined is None:
            undecided += 1
        elif not closes_early(case, refined):
            path = [refined]
            for _ in range(case.orbit_period - 1):
                path.append(images(case, path[-1][None], 1)[0][0])
            inside = ((np.array(path) >= BOX[:, 0]) & (np.array(path) <= BOX[:, 1])).all(axis=1)
            if case.damped or inside.any():
                orbits.append(np.array(path))
    return orbits, undecided


def newton(case: Case, starts: FloatArray) -> FloatArray:
    """Fixed points that Newton's method reaches, array (point, 2).

    Rough images lead it near to them; from there fine ones have all steps once more.  What has
    come to the same point by then goes on once.
    """
    near = newton_steps(case, starts, ROUGH, NEAR, np.inf)
    return newton_steps(case, np.unique(np.round(near, 5), axis=0), FINE, RESIDUAL, STEP)


def newton_steps(
    case: Case, starts: FloatArray, tolerance: float, residual: float, longest: float
) -> FloatArray:
    """Where Newton's method converges to a residual and a last step, array (point, 2)."""
    x, found = starts.copy(), [np.empty((0, 2))]
    for _ in range(NEWTON_STEPS):
        image, jacobian = images(case, x, case.orbit_period, tolerance)
        defect, matrix = image - x, np.eye(2) - jacobian
        usable = np.asarray(np.isfinite(defect).all(axis=1) & np.isfinite(matrix).all(axis=(1, 2)))
        usable[usable] = np.linalg.det(matrix[usable]) != 0.0
        x, defect, matrix = x[usable], defect[usable], matrix[usable]
        step = np.linalg.solve(matrix, defect[..., None])[..., 0]
        size = np.abs(step).max(axis=1, initial=0.0)
        done = (np.abs(defect).max(axis=1, initial=0.0) < residual) & (size < longest)
        # A longer step than it is near may lead away.
        found.append((x + np.where(size < NEAR, step.T, 0.0).T)[done])
        x = (x + step * np.minimum(1.0, LONGEST_STEP / np.maximum(size, 1e-300))[:, None])[~done]
        x = x[(x[:, 0] > 0.02) & (x[:, 0] < 300.0) & (np.abs(x[:, 1]) < 100.0)]
        if not len(x):
            break
    return np.concatenate(found)


def refine(case: Case, point: FloatArray) -> FloatArray | None:
    """The orbit near a point in extended precision; None where it is nearly parabolic."""
    reference = PeriodMap(case.drive, case.values)
    state = np.asarray(point, dtype=np.longdouble)
    for _ in range(8):
        image, jacobian = reference.image(state, case.orbit_period)
        if not np.isfinite(jacobian.astype(float)).all():
            return None
        matrix = np.eye(2) - jacobian.astype(float)
        if abs(np.linalg.det(matrix)) < NEARLY_PARABOLIC * max(1.0, float(np.abs(matrix).max())):
            return None
        step = np.linalg.solve(matrix, (image - state).astype(float))
        state = state + step * min(1.0, 0.05 / max(float(np.abs(step).max()), 1e-300))
        if np.abs(step).max() < 1e-10:
            return state.astype(float)
    return None


def closes_early(case: Case, point: FloatArray) -> bool:
    """Whether the least period is a divisor of that which was asked for."""
    divisors = [j for j in range(1, case.orbit_period) if case.orbit_period % j == 0]
    return any(np.abs(images(case, point[None], j)[0] - point).max() < SAME for j in divisors)


def images(
    case: Case, states: FloatArray, periods: int, tolerance: float = FINE
) -> tuple[FloatArray, FloatArray]:
    """States some periods later, array (point, 2), and derivatives, (point, 2, 2)."""
    import heyoka as hy

    engine, v = _engine(tolerance), case.values
    image, jacobian = np.full((len(states), 2), np.nan), np.full((len(states), 2, 2), np.nan)
    theta = v["temperature"] / 293.0
    row = [v["c"], theta, v["prestress"], v["dissipation.0.eta"], v["omega"], v["b"]]
    engine.pars[:] = np.array(row)[:, None]
    for first in range(0, len(states), BATCH):
        part = np.arange(first, min(first + BATCH, len(states)))
        lanes = np.resize(part, BATCH)
        engine.set_time(0.0)
        engine.state[:2] = states[lanes].T
        engine.state[2:] = np.array([1.0, 0.0, 0.0, 1.0])[:, None]
        engine.propagate_until(np.full(BATCH, periods * np.pi / v["omega"]), max_steps=200_000)
        done = [outcome[0] == hy.taylor_outcome.time_limit for outcome in engine.propagate_res]
        good = part[np.array(done)[: len(part)]]
        image[good] = engine.state[:2, good - first].T
        jacobian[good] = engine.state[2:, good - first].T.reshape(-1, 2, 2)
    return image, jacobian


@cache
def _engine(tolerance: float) -> Any:
    """The equation of motion with its variational equations, several motions at once."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    c, theta, prestress, eta, omega, size = (hy.par[k] for k in range(6))
    m = (size * hy.sin(omega * hy.time)) ** 2
    x2 = x * x
    x4, x7 = x2 * x2, x2 * x2 * x2 * x
    force = theta * (x4 * x4 - x2) - prestress * x7 + m * x4 + eta * v * x7
    rate = (6.0 * c * v * v - 3.0 * force) / (x7 + 2.0 * c * x)
    system = hy.var_ode_sys([(x, v), (v, rate)], hy.var_args.vars, order=1)
    return hy.taylor_adaptive_batch(
        system, np.ones((2, BATCH)), tol=tolerance, pars=np.zeros((6, BATCH))
    )


def summary(compared: list[Compared]) -> dict[str, Any]:
    """Counts over some cases."""
    silent = [one for one in compared if one.missed and not one.incomplete]
    return {
        "cases": len(compared),
        "orbits": sum(one.reference for one in compared),
        "listed": sum(one.listed for one in compared),
        "missed in silence": sum(one.missed for one in silent),
        "missed, said so": sum(one.missed for one in compared) - sum(one.missed for one in silent),
        "not orbits": sum(one.not_orbits for one in compared),
        "undecided": sum(one.undecided for one in compared),
        "incomplete": sum(one.incomplete for one in compared),
    }


def report_of(compared: list[Compared]) -> dict[str, Any]:
    """What is kept of some cases."""
    return {
        "damped": summary([one for one in compared if one.damped]),
        "undamped": summary([one for one in compared if not one.damped]),
        "cases": [asdict(one) for one in compared],
    }


def page(report: dict[str, Any]) -> str:
    """The part of the documentation, in Markdown."""
    columns = list(report["damped"])
    lines = ["| | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    for name in ("damped", "undamped"):
        cells = [f"{report[name][column]:.3g}" for column in columns]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    text = (
        "Orbits of periods 1 to 5 of random actuators, beside Newton's method from a grid on the "
        "period map of heyoka.py: 32 by 20 guesses in the box of stretches from 0.3 to 4 and rates "
        "from −8 to 8, 20 by 12 where the orbit lasts longer than 20 τ, and beyond 80 τ 16 by 12 "
        "with rates from −2 to 2. "
        "`undecided` counts points of either side at which det(1 − DPⁿ) is below 1e-10 of the "
        "largest entry of the matrix, which this reference cannot tell from motion that nearly "
        "closes. Orbits that are listed beyond those that brute force found are such, or were not "
        "reached from its guesses: each of those is confirmed by Newton's method from its point."
    )
    return "\n".join([text, "", *lines, ""])


def main() -> None:
    """Run the study and write its results."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=300)
    parser.add_argument("--first", type=int, default=10_000)
    parser.add_argument("--out", type=Path, default=RESULTS)
    parser.add_argument("--page", type=Path, default=None)
    options = parser.parse_args()
    compared = []
    for seed in range(options.first, options.first + options.cases):
        compared.append(compare(Case.random(seed)))
        print(asdict(compared[-1]), flush=True)
        options.out.write_text(json.dumps(report_of(compared), indent=1) + "\n")
    if options.page is not None:
        options.page.write_text(page(report_of(compared)))


if __name__ == "__main__":
    main()
