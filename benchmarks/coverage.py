"""How often the reported error covers the true one; run with ``python -m benchmarks.coverage``.

Random trajectories under every drive, slender and stout, cold and hot, damped and not, are
integrated by the package at random tolerances and by heyoka in extended precision.  Counted
are the trajectories whose largest true error, over everything returned, is at most the
reported one, and how much larger the reported one is.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import click
import numpy as np
import xarray as xr
from scipy.stats import beta

import remanent as rm
from benchmarks import taylor
from benchmarks.coverage_page import draw, write_page
from remanent._status import Status
from remanent._typing import FloatArray
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Outcome, Request
from remanent.models.drives.base import Drive
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem

#: Results and pages are written below it.
ROOT = Path(__file__).parent.parent
#: Trajectories of a group, which go through the engine together.
GROUP_SIZE = 16
#: States of a trajectory whose error is measured.
SAMPLES = 257
#: Longest run, tau.
LONGEST = 100.0
#: Entries of a table of loads.
TABLE_ENTRIES = 33
#: Largest load of any drive but a sampled one.
LARGEST_LOAD = 3.0
#: Share of trajectories that start from rest.
AT_REST = 0.5
#: Share of groups without damping.
UNDAMPED = 0.5
#: Reference temperature, kelvin.
T0 = 293.0
#: Numeric fields by name, an array (trajectory,) each.
Values = dict[str, FloatArray]


@dataclass(frozen=True)
class Kind:
    """A drive, made at random with the fields that vary, and what is asked of the run."""

    name: str
    make: Callable[[np.random.Generator], tuple[Drive, Values]]
    extremes: bool = False


def _waves(rng: np.random.Generator) -> Values:
    """Amplitude and mean of loads of up to 3, frequencies around the natural ones."""
    mean = rng.uniform(-1.5, 1.5, GROUP_SIZE)
    m = rng.uniform(-1.0, 1.0, GROUP_SIZE) * (LARGEST_LOAD - np.abs(mean))
    return {"m": m, "mean": mean, "phase": rng.uniform(0.0, 2.0 * np.pi, GROUP_SIZE)}


def _constant(rng: np.random.Generator) -> tuple[Drive, Values]:
    return rm.Constant(0.0), {"m": rng.uniform(-LARGEST_LOAD, LARGEST_LOAD, GROUP_SIZE)}


def _squared(rng: np.random.Generator) -> tuple[Drive, Values]:
    b, phase = rng.uniform(0.0, LARGEST_LOAD**0.5, GROUP_SIZE), rng.uniform(0.0, np.pi, GROUP_SIZE)
    return rm.SineSquared(0.4, 1.0), {"b": b, "omega": _frequencies(rng), "phase": phase}


def _sine(rng: np.random.Generator) -> tuple[Drive, Values]:
    return rm.Sine(0.1, 1.0), {**_waves(rng), "omega": _frequencies(rng)}


def _chirp(rng: np.random.Generator) -> tuple[Drive, Values]:
    ends = {name: rng.uniform(0.0, 5.0, GROUP_SIZE) for name in ("start", "stop")}
    sweep = rng.uniform(0.1, 1.2, GROUP_SIZE) * LONGEST
    return rm.Chirp(0.1, 1.0, 2.0, 3.0), {**_waves(rng), **ends, "duration": sweep}


def _frequencies(rng: np.random.Generator) -> FloatArray:
    return np.asarray(10.0 ** rng.uniform(-0.5, 0.7, GROUP_SIZE))


def _table(
    kind: type[Any], largest: float
) -> Callable[[np.random.Generator], tuple[Drive, Values]]:
    def make(rng: np.random.Generator) -> tuple[Drive, Values]:
        inner = np.sort(rng.uniform(0.0, LONGEST, TABLE_ENTRIES - 2))
        even = np.linspace(0.0, LONGEST, TABLE_ENTRIES)
        times = even if kind is rm.Sampled else np.array([0.0, *inner, LONGEST])
        return kind(times, rng.uniform(-largest, largest, TABLE_ENTRIES)), {}

    return make


#: Everything that trajectories are made of; the place in it is part of a trajectory's name.
KINDS = (
    Kind("Constant", _constant),
    Kind("SineSquared", _squared),
    Kind("Sine", _sine),
    Kind("Steps", _table(rm.Steps, LARGEST_LOAD)),
    Kind("Ramp", _table(rm.Ramp, LARGEST_LOAD)),
    Kind("Chirp", _chirp),
    Kind("Sampled", _table(rm.Sampled, 2.0)),  # the spline overshoots its samples
    Kind("SineSquared, extremes", _squared, extremes=True),
    Kind("Sine, extremes", _sine, extremes=True),
)


@dataclass(frozen=True)
class Group:
    """Trajectories that share a kind of drive and a tolerance; all that is random about them.

    Attributes
    ----------
    values
        Fields that differ between trajectories, arrays (trajectory,).
    duration : array (trajectory,)
        Length of each run, tau.
    """

    kind: Kind
    actuator: rm.Actuator
    drive: Drive
    values: Values
    duration: FloatArray
    tolerance: float

    def motion(self, k: int) -> taylor.Motion:
        """Trajectory `k`, for the reference."""
        common = {**self.actuator.parameter_values(), **self.drive.parameter_values()}
        values = common | {name: float(v[k]) for name, v in self.values.items()}
        start = values["initial.stretch"], values["initial.stretch_rate"]
        return taylor.Motion(self.drive, values, start)

    def times(self) -> FloatArray:
        """Times of the states whose error is measured, array (trajectory, time)."""
        grid = np.linspace(0.0, 1.0, SAMPLES) * self.duration[:, None]
        grid[:, -1] = self.duration
        return np.asarray(grid)

    def begin(self) -> FloatArray:
        """Extremes are taken over the second half."""
        return 0.5 * self.duration

    def computed(self) -> Outcome:
        """What the package answers."""
        over = {name: xr.DataArray(v, dims="case") for name, v in self.values.items()}
        problem = initial_value_problem(
            lay_out_ensemble(self.actuator, self.drive, over), self.duration
        )
        request = Request(times=self.times())
        if self.kind.extremes:
            request = Request(wants_extremes=True, extremes_begin=self.begin())
        return integrate(problem, request, tolerance=self.tolerance)


def group(seed: int, kind: int, number: int) -> Group:
    """The same trajectories for the same three numbers."""
    rng = np.random.default_rng([seed, kind, number])
    drive, values = KINDS[kind].make(rng)
    resting = rng.uniform(size=GROUP_SIZE) < AT_REST
    values |= {
        "c": 10.0 ** rng.uniform(-3.0, 0.0, GROUP_SIZE),
        "temperature": T0 * rng.uniform(0.5, 2.0, GROUP_SIZE),
        "prestress": rng.uniform(-1.0, 3.0, GROUP_SIZE),
        "initial.stretch": np.where(resting, 1.0, rng.uniform(0.8, 1.3, GROUP_SIZE)),
        "initial.stretch_rate": np.where(resting, 0.0, rng.uniform(-0.5, 0.5, GROUP_SIZE)),
    }
    damped = rng.uniform() >= UNDAMPED
    if damped:
        values["dissipation.0.eta"] = 10.0 ** rng.uniform(-3.0, 0.0, GROUP_SIZE)
    body = rm.Actuator(
        temperature=T0, reference_temperature=T0, dissipation=rm.Rayleigh(0.1) if damped else ()
    )
    duration = rng.uniform(1.0, LONGEST, GROUP_SIZE)
    return Group(KINDS[kind], body, drive, values, duration, 10.0 ** rng.uniform(-12.0, -4.0))


@dataclass(frozen=True)
class Case:
    """One trajectory: where it comes from, its reported error and its true one.

    Attributes
    ----------
    seed, kind, group, index
        Make the trajectory again: seed of all, number in :data:`KINDS`, group, trajectory.
    horizon, duration
        Time up to which the tolerance was met, and length of the run, tau.
    resolution
        Double steps per cycle that were needed.
    reported, true
        Error as the package reports it, and against the reference.
    """

    seed: int
    kind: int
    group: int
    index: int
    tolerance: float
    status: Status
    horizon: float
    duration: float
    resolution: int
    reported: float
    true: float

    @property
    def covered(self) -> bool:
        return self.true <= self.reported


def cases(seed: int, kind: int, number: int) -> Iterator[Case]:
    """Every trajectory of a group, measured."""
    trajectories = group(seed, kind, number)
    outcome = trajectories.computed()
    for k in range(GROUP_SIZE):
        yield Case(
            seed, kind, number, k, trajectories.tolerance, Status(int(outcome.status[k])),
            float(outcome.horizon[k]), float(trajectories.duration[k]), int(outcome.resolution[k]),
            float(outcome.error[k]), true_error(trajectories, outcome, k),
        )  # fmt: skip


def true_error(trajectories: Group, outcome: Outcome, k: int) -> float:
    """Largest error of what was returned of trajectory `k`; NaN if nothing was."""
    motion = trajectories.motion(k)
    if trajectories.kind.extremes:
        if outcome.status[k] != Status.OK:
            return float("nan")
        begin, end = trajectories.begin()[k], trajectories.duration[k]
        exact = taylor.extremes(motion, float(begin), float(end))
        return float(np.abs(np.subtract((outcome.maximum[k], outcome.minimum[k]), exact)).max())
    times = trajectories.times()[k]
    times = times[times <= outcome.horizon[k]]
    if times.size < 2 or outcome.states is None:
        return float("nan")
    difference = outcome.states[k, : times.size] - taylor.states(motion, times)
    return float(np.abs(difference).max())


def summary(trajectories: list[Case]) -> dict[str, Any]:
    """Coverage, looseness and statuses of trajectories.

    Trajectories that met the tolerance to their end are judged; those that did not are
    judged apart, up to their horizon.  ``coverage_at_least`` is the lower limit of Clopper and
    Pearson at 95 % confidence.
    """
    count = len(trajectories)
    ok = [case for case in trajectories if case.status == Status.OK]
    partial = [c for c in trajectories if c.status != Status.OK and np.isfinite(c.true)]
    covered = sum(case.covered for case in ok)
    ratios = [case.reported / max(case.true, 1e-300) for case in ok]
    return {
        "cases": count,
        "ok": len(ok) / count,
        "horizon": sum(case.status == Status.HORIZON for case in trajectories) / count,
        "coverage": covered / len(ok),
        "coverage_at_least": float(beta.ppf(0.05, covered, len(ok) - covered + 1)),
        "coverage_up_to_horizon": (
            sum(case.covered for case in partial) / len(partial) if partial else None
        ),
        "median_ratio": float(np.median(ratios)),
        "uncovered": len(ok) - covered,
    }


def report(trajectories: list[Case], seed: int) -> dict[str, Any]:
    """Everything worth keeping, in plain data."""

    def where(test: Callable[[Case], bool]) -> dict[str, Any]:
        return summary([case for case in trajectories if test(case)])

    uncovered = [case for case in trajectories if np.isfinite(case.true) and not case.covered]
    points = [case for case in trajectories if case.status == Status.OK]
    return {
        "remanent": version("remanent"),
        "reference": f"heyoka.py {version('heyoka')}, extended precision",
        "seed": seed,
        "total": summary(trajectories),
        "decades": {
            f"1e{d}": where(lambda case, d=d: d <= np.log10(case.tolerance) < d + 1)  # type: ignore[misc]
            for d in range(-12, -4)
        },
        "drives": {
            kind.name: where(lambda case, k=k: case.kind == k)  # type: ignore[misc]
            for k, kind in enumerate(KINDS)
        },
        "slenderness": slenderness(trajectories),
        "uncovered": [
            _listed(case) for case in sorted(uncovered, key=lambda c: c.reported / c.true)
        ],
        # for the picture: log10 of true and of reported errors
        "points": [[_log(case.true), _log(case.reported)] for case in points],
    }


def slenderness(trajectories: list[Case]) -> dict[str, Any]:
    """Summaries by decade of the slenderness c."""
    c = {case: float(_group(case).values["c"][case.index]) for case in trajectories}
    return {
        f"1e{d}": summary([case for case in trajectories if d <= np.log10(c[case]) < d + 1])
        for d in (-3, -2, -1)
    }


@cache
def _group_again(seed: int, kind: int, number: int) -> Group:
    return group(seed, kind, number)


def _group(case: Case) -> Group:
    """The group of a trajectory, made once."""
    return _group_again(case.seed, case.kind, case.group)


def _log(error: float) -> float:
    """Decimal logarithm of an error, with two digits; no less than that of 1e-18."""
    return round(float(np.log10(max(error, 1e-18))), 2)


def _listed(case: Case) -> dict[str, Any]:
    return {
        "case": f"{case.kind}:{case.group}:{case.index}",
        "kind": KINDS[case.kind].name,
        "c": float(f"{_group(case).values['c'][case.index]:.3g}"),
        "tolerance": float(f"{case.tolerance:.3g}"),
        "status": case.status.meaning,
        "horizon": round(case.horizon, 3),
        "duration": round(case.duration, 3),
        "resolution": case.resolution,
        "reported": float(f"{case.reported:.3g}"),
        "true": float(f"{case.true:.3g}"),
    }


def measured(count: int, seed: int) -> Iterable[Case]:
    """At least `count` trajectories, as many of every kind."""
    groups = -(-count // (len(KINDS) * GROUP_SIZE))
    work = [(kind, number) for kind in range(len(KINDS)) for number in range(groups)]
    with click.progressbar(work, label="coverage") as bar:
        for kind, number in bar:
            yield from cases(seed, kind, number)


@click.command()
@click.option("--cases", "count", default=10_000, help="Least number of trajectories.")
@click.option("--seed", default=1, help="Of all random choices.")
@click.option("--one", help="Measure this case only, kind:group:index, and show it.")
@click.option("--redraw", is_flag=True, help="Only draw and write what was measured before.")
@click.option("--out", type=click.Path(path_type=Path), default=ROOT, help="Written below it.")
def main(count: int, seed: int, one: str | None, redraw: bool, out: Path) -> None:
    """Measure the coverage of the reported error."""
    results = out / "benchmarks" / "results" / "coverage.json"
    if one is not None:
        kind, number, index = map(int, one.split(":"))
        click.echo(list(cases(seed, kind, number))[index])
        click.echo(group(seed, kind, number).motion(index))
        return
    if not redraw:
        results.parent.mkdir(parents=True, exist_ok=True)
        results.write_text(json.dumps(report(list(measured(count, seed)), seed)) + "\n")
    saved = json.loads(results.read_text())
    pages = out / "docs" / "results"
    pages.mkdir(parents=True, exist_ok=True)
    draw(saved, pages / "coverage.svg")
    write_page(saved, pages / "coverage.md")
    click.echo(json.dumps(saved["total"], indent=1))


if __name__ == "__main__":
    main()
