"""Branches of periodic orbits, their special points and curves of them, against heyoka's map."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.errors.period_map import PeriodMap
from benchmarks.errors.row import Judged, Row, shared
from benchmarks.errors.special_points import at, special_point
from remanent._typing import ArrayLike

#: Decades of tolerance that are asked for.
TOLERANCES = (-11.0, -3.0)
#: Points of a branch or curve that are judged.
POINTS = 12
#: A solution farther from the point than this is another one.
SAME = 1e-2


@dataclass(frozen=True)
class Case:
    """A random block under a random drive, with a branch over the drive's frequency."""

    values: dict[str, float]
    limits: tuple[float, float]
    tolerance: float

    @property
    def damped(self) -> bool:
        return self.values["dissipation.0.eta"] > 0.0

    @property
    def body(self) -> rm.Actuator:
        v = self.values
        return rm.Actuator(
            c=v["c"], temperature=v["temperature"], prestress=v["prestress"],
            dissipation=rm.Rayleigh(v["dissipation.0.eta"]) if self.damped else (),
        )  # fmt: skip

    @property
    def drive(self) -> rm.SineSquared:
        return rm.SineSquared(self.values["b"], self.values["omega"])

    @property
    def reference(self) -> PeriodMap:
        return PeriodMap(self.drive, self.values)

    def branch(self, initial: ArrayLike = (1.0, 0.0), max_points: int = 1000) -> xr.Dataset | None:
        """The branch through the orbit that Newton's method reaches, from rest or elsewhere."""
        try:
            return rm.continue_orbit(
                self.body, self.drive, "omega", self.limits, initial=initial,
                tolerance=self.tolerance, max_points=max_points,
            )  # fmt: skip
        except rm.InputError:  # it reaches none
            return None

    def judged(self, what: str, reported: float, true: float, scale: float = 1.0) -> Judged:
        name = f"{self.body!r}, {self.drive!r}, {self.limits}: {what}"
        return Judged(name, self.tolerance, self.damped, float(reported), float(true), float(scale))


def random_case(rng: np.random.Generator, *, bifurcating: bool = False) -> Case:
    """Where bifurcations are wanted, weak damping, strong loads and a wide range."""
    damped = bool(rng.uniform() < 0.5)
    eta = rng.uniform(-3.0, -1.5) if bifurcating else rng.uniform(-2.0, 0.0)
    low, width = (0.8, 1.8) if bifurcating else (rng.uniform(0.5, 2.0), 0.4)
    values = {
        "c": 10.0 ** rng.uniform(-1.0, 0.0),
        "temperature": 293.0 * rng.uniform(0.8, 1.3),
        "prestress": rng.uniform(-0.5, 1.0),
        "b": rng.uniform(0.3 if bifurcating else 0.1, 1.0),
        "omega": low + width * rng.uniform(0.05, 0.95),
        "dissipation.0.eta": 10.0**eta if damped else 0.0,
    }
    return Case(values, (low, low + width), 10.0 ** rng.uniform(*TOLERANCES))


def _chosen(rng: np.random.Generator, count: int) -> np.ndarray:
    return rng.choice(count, min(count, POINTS), replace=False)


@shared
def _points(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """Points of one branch: state, multipliers and extremes at the frequency as it is."""
    case = random_case(rng)
    branch = case.branch()
    if branch is None:
        return
    for k in _chosen(rng, branch.sizes["point"]):
        one = branch.isel(point=int(k))
        if not np.isfinite(one.omega):
            continue
        state = np.array([float(one.stretch), float(one.stretch_rate)])
        reference = at(case.reference, "omega", float(one.omega))
        exact = reference.orbit(state, 1)
        if exact is None or np.abs(state - exact.state).max() > SAME:
            continue
        pairs = np.abs(one.multipliers.values[:, None] - exact.multipliers)
        off = float(min(max(pairs[0, 0], pairs[1, 1]), max(pairs[0, 1], pairs[1, 0])))
        distance = np.abs(state - exact.state).max()
        yield "state", case.judged(f"point {k}", one.error, distance)
        size = np.abs(exact.multipliers).max()
        yield (
            "multipliers",
            case.judged(f"point {k}", float(one.multipliers_error.max()), off, size),
        )
        low, high = reference.extremes(exact.state, 1)
        extremes = {"minimum": low, "maximum": high, "amplitude": 0.5 * (high - low)}
        for name, number in extremes.items():
            apart = abs(float(one[name]) - number)
            about = f"{name} of point {k}"
            yield "extremes", case.judged(about, float(one[f"{name}_error"]), apart, number)


def _specials(rng: np.random.Generator, kind: str) -> Iterator[tuple[Case, xr.Dataset]]:
    """Special points of one branch."""
    case = random_case(rng, bifurcating=True)
    branch = case.branch()
    if branch is None:
        return
    for k in np.flatnonzero(branch.special_kind.values == kind):
        yield case, branch.isel(special=int(k))


@shared
def _curve_points(rng: np.random.Generator) -> Iterator[tuple[Judged, Judged, Judged]]:
    """Points of a curve of bifurcations: the state, omega at b as it is, b at omega."""
    kind = str(rng.choice(["fold", "period doubling"]))
    for case, one in _specials(rng, kind):
        ranges = [case.limits, (0.2, 1.2)]
        start = [float(one[f"special_{n}"]) for n in ("stretch", "stretch_rate")]
        try:
            curve = rm.continue_bifurcation(
                case.body, case.drive.replace(omega=float(one.special_omega)), kind,
                ("omega", "b"), ranges, initial=start, tolerance=case.tolerance, max_points=40,
            )  # fmt: skip
        except rm.InputError:
            continue
        for k in _chosen(rng, curve.sizes["point"]):
            point = curve.isel(point=int(k))
            x, v, omega, b = (float(point[n]) for n in ("stretch", "stretch_rate", "omega", "b"))
            at_b = special_point(at(case.reference, "b", b), kind, "omega", [x, v, omega], 1)
            at_omega = special_point(at(case.reference, "omega", omega), kind, "b", [x, v, b], 1)
            if at_b is None or at_omega is None:
                continue
            off_b, off_omega = np.abs(at_b - [x, v, omega]), np.abs(at_omega - [x, v, b])
            if max(off_b.max(), off_omega.max()) > SAME:
                continue
            state = max(off_b[:2].max(), off_omega[:2].max())
            name = f"{kind} {k}"
            yield (
                case.judged(name, point.error, state),
                case.judged(name, point.omega_error, off_b[2]),
                case.judged(name, point.b_error, off_omega[2]),
            )
        return


def _of(what: str) -> Callable[[np.random.Generator], Iterator[Judged]]:
    return lambda rng: (judged for name, judged in _points(rng) if name == what)


ROWS = (
    Row("positions of points of branches", "continue_orbit: error", _of("state")),
    Row("multipliers along branches", "continue_orbit: multipliers_error", _of("multipliers")),
    Row(
        "extremes along branches",
        "continue_orbit: maximum_error, minimum_error, amplitude_error",
        _of("extremes"),
    ),
    Row(
        "states along curves of bifurcations", "continue_bifurcation: error",
        lambda rng: (one[0] for one in _curve_points(rng)),
    ),
    Row(
        "first parameters along curves of bifurcations", "continue_bifurcation: omega_error",
        lambda rng: (one[1] for one in _curve_points(rng)),
    ),
    Row(
        "second parameters along curves of bifurcations", "continue_bifurcation: b_error",
        lambda rng: (one[2] for one in _curve_points(rng)),
    ),
)  # fmt: skip
