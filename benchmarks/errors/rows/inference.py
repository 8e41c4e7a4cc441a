"""Derivatives, designs, statistics, fits and functions, against heyoka and quadrature."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.errors.period_map import LONG, PeriodMap
from benchmarks.errors.row import Judged, Promise, Row
from remanent._typing import FloatArray

#: Decades of tolerance that are asked for.
TOLERANCES = (-11.0, -3.0)
#: Fields by which derivatives are taken.
FIELDS = ("c", "temperature", "prestress", "b")
#: Largest step of the reference's differences, relative; each of the levels halves it.
REFERENCE_STEP, REFERENCE_LEVELS = LONG("0.01"), 5
#: Steps of Newton's method for a field, and half the step of its differences, relative.
SOLUTION_STEPS, SOLUTION_STEP = 12, "1e-7"
#: Nodes of Gauss's rule in each uncertain field.
GAUSS_NODES = 16
#: Times at which a stretch is uncertain, and how it is computed and sampled.
STATISTICS_TIMES = (1.0, 1.7, 2.4, 3.1)
STATISTICS_TOLERANCE = 1e-9
SAMPLES = 128
#: Noise of synthetic measurements.
NOISE = 0.01


@dataclass(frozen=True)
class Body:
    """A random actuator under a random drive, as the package and as heyoka take it."""

    values: Mapping[str, float]
    eta: float
    periods: int
    tolerance: float

    @classmethod
    def drawn(cls, rng: np.random.Generator) -> Body:
        values = {
            "c": 10.0 ** rng.uniform(-1.0, 0.0),
            "temperature": 293.0 * rng.uniform(0.8, 1.3),
            "prestress": rng.uniform(0.1, 0.8),
            "b": rng.uniform(0.1, 0.8),
            "omega": rng.uniform(0.8, 2.5),
        }
        eta = float(10.0 ** rng.uniform(-2.0, 0.0)) if rng.uniform() < 0.5 else 0.0
        tolerance = float(10.0 ** rng.uniform(*TOLERANCES))
        return cls(values, eta, int(rng.integers(1, 4)), tolerance)

    @property
    def actuator(self) -> rm.Actuator:
        return rm.Actuator(
            c=self.values["c"], temperature=self.values["temperature"],
            prestress=self.values["prestress"],
            dissipation=rm.Rayleigh(self.eta) if self.eta else (),
        )  # fmt: skip

    @property
    def drive(self) -> rm.SineSquared:
        return rm.SineSquared(self.values["b"], self.values["omega"])

    @property
    def times(self) -> FloatArray:
        """Ends of the periods."""
        return np.asarray(np.pi / self.values["omega"] * np.arange(1, self.periods + 1))

    def state(self, changed: Mapping[str, Any], periods: int) -> Any:
        """The exact state from rest after some periods of the drive, extended precision."""
        values = {**self.values, "dissipation.0.eta": self.eta, **changed}
        return PeriodMap(self.drive, values).image((1, 0), periods)[0]

    def stretch_derivative(self, field: str) -> float:
        """Of the last stretch by a field: Richardson's extrapolation in extended precision."""
        centre = LONG(self.values[field])
        step = centre * REFERENCE_STEP
        table: list[Any] = []
        for level in range(REFERENCE_LEVELS):
            h = step / LONG(2) ** level
            ends = [self.state({field: centre + s * h}, self.periods)[0] for s in (1, -1)]
            row = [(ends[0] - ends[1]) / (2 * h)]
            for j, before in enumerate(table[-1] if table else []):
                row.append(row[-1] + (row[-1] - before) / (LONG(4) ** (j + 1) - 1))
            table.append(row)
        return float(table[-1][-1])

    def measure(self, of: Any, *, times: FloatArray | None = None) -> rm.Measure:
        return rm.Measure(
            rm.simulate, self.actuator, self.drive, of=of, tolerance=self.tolerance,
            times=self.times if times is None else times,
        )  # fmt: skip

    def judged(self, reported: Any, true: float, size: float, about: str = "") -> Judged:
        case = f"{self.actuator!r}, {self.drive!r}, {self.periods} periods {about}"
        return Judged(case, self.tolerance, self.eta > 0.0, float(reported), true, size)


def _derivative(rng: np.random.Generator) -> Iterator[Judged]:
    body = Body.drawn(rng)
    field = str(rng.choice(FIELDS))
    found = rm.sensitivity(body.measure("stretch", times=body.times[-1:]), parameters=field)
    exact = body.stretch_derivative(field)
    slope, error = found.derivative.values[0, 0], found.derivative_error.values[0, 0]
    if np.isfinite(slope) and np.isfinite(exact):
        yield body.judged(error, abs(slope - exact), abs(exact), f"by {field}")


def _solution(rng: np.random.Generator) -> Iterator[Judged]:
    """The field at which a stretch is what heyoka has for it; the search starts 1 % away.

    The stretch swings with the field, so that there may be another solution near the one from
    which the target comes: the one nearest to what was found counts.
    """
    body = Body.drawn(rng)
    field = str(rng.choice(FIELDS))
    target = body.state({}, body.periods)[0]
    exact = body.values[field]
    measure = body.measure(lambda ds: ds.stretch.isel(time=-1), times=body.times)
    start = exact * (1.0 + rng.uniform(-0.01, 0.01))
    found = rm.design(measure, float(target), {field: start})
    if int(found.status) != rm.Status.OK:
        return
    solution = LONG(found.solution[0])
    true = min(abs(solution - exact), abs(solution - _solution_near(body, field, target, solution)))
    if true < 0.05 * abs(exact):  # not one that is far away
        yield body.judged(found.solution_error[0], float(true), exact, f"by {field}")


def _solution_near(body: Body, field: str, target: Any, start: Any) -> Any:
    """The value of a field nearest to another with a stretch; infinite where none is found."""

    def missed(value: Any) -> Any:
        return body.state({field: value}, body.periods)[0] - target

    x, h = start, LONG(SOLUTION_STEP) * abs(start)
    for _ in range(SOLUTION_STEPS):
        step = -2 * h * missed(x) / (missed(x + h) - missed(x - h))
        x = x + step
        if not abs(step) > LONG(1e-17) * abs(x):
            break
    return x if abs(step) < LONG(1e-14) * abs(x) else LONG(np.inf)


#: Functions of a history of the state that measures are made of.
FUNCTIONS: tuple[Callable[[Any, Any], Any], ...] = (
    lambda x, _: x[..., -1],
    lambda _, v: v[..., -1],
    lambda x, v: x[..., -1] ** 2 + 0.1 * v[..., -1],
    lambda x, _: x[..., 0] - x[..., -1] if x.shape[-1] > 1 else x[..., 0] ** -2,
    lambda x, v: x.max(axis=-1) - v.min(axis=-1),
    lambda x, v: (x * v).sum(axis=-1),
)


def _function(rng: np.random.Generator) -> Iterator[Judged]:
    """Functions of the states at the ends of periods, of many samples at once."""
    body = Body.drawn(rng)
    number = int(rng.integers(len(FUNCTIONS)))
    function = FUNCTIONS[number]

    def of(ds: xr.Dataset) -> xr.DataArray:
        states = (
            ds[name].transpose("sample", "time").values for name in ("stretch", "stretch_rate")
        )
        return xr.DataArray(function(*states), dims="sample")

    field = str(rng.choice(FIELDS))
    at = body.values[field] * rng.uniform(0.9, 1.1, 4)
    values, errors = body.measure(of).at({field: at})
    for value, error, x in zip(values.values, errors.values, at, strict=True):
        path = np.array([body.state({field: x}, k + 1) for k in range(body.periods)])
        exact = float(function(path[:, 0], path[:, 1]))
        if np.isfinite(value) and np.isfinite(exact):
            about = f"function {number}, {field} = {x}"
            yield body.judged(error, abs(value - exact), abs(exact), about)


@dataclass(frozen=True)
class Exact:
    """Statistics of a history under two uniform fields, by Gauss's rule, arrays (time,)."""

    average: FloatArray
    deviation: FloatArray
    first: FloatArray
    total: FloatArray

    @classmethod
    def of(cls, measure: rm.Measure, ranges: Mapping[str, tuple[float, float]]) -> Exact:
        nodes, weights = np.polynomial.legendre.leggauss(GAUSS_NODES)
        w = weights / 2.0
        columns = [lo + (hi - lo) * (nodes + 1.0) / 2.0 for lo, hi in ranges.values()]
        mesh = [m.ravel() for m in np.meshgrid(*columns, indexing="ij")]
        values = measure.values_at(dict(zip(ranges, mesh, strict=True))).values
        table = values.reshape(GAUSS_NODES, GAUSS_NODES, -1)
        mean = np.einsum("i,j,ijt->t", w, w, table)
        variance = np.einsum("i,j,ijt->t", w, w, (table - mean) ** 2)
        by_first = np.einsum("i,it->t", w, (np.einsum("j,ijt->it", w, table) - mean) ** 2)
        by_second = np.einsum("j,jt->t", w, (np.einsum("i,ijt->jt", w, table) - mean) ** 2)
        alone = np.stack([by_first, by_second]) / variance
        return cls(mean, np.sqrt(variance), alone, 1.0 - alone[::-1])


def _statistics(rng: np.random.Generator, *, sobol: bool) -> tuple[Body, xr.Dataset, Exact]:
    """An uncertain stretch at some times."""
    body = Body.drawn(rng)
    fields = rng.choice(FIELDS, 2, replace=False)
    ranges = {
        str(f): (
            float(body.values[f] * (1.0 - rng.uniform(0.02, 0.3))),
            float(body.values[f] * (1.0 + rng.uniform(0.02, 0.3))),
        )
        for f in fields
    }
    measure = rm.Measure(
        rm.simulate, body.actuator, body.drive, of="stretch", times=STATISTICS_TIMES,
        tolerance=STATISTICS_TOLERANCE,
    )  # fmt: skip
    found = rm.uncertainty(
        measure, parameter_ranges=ranges, samples=SAMPLES, sobol=sobol, quantiles=[0.5],
        rng=int(rng.integers(2**31)),
    )  # fmt: skip
    return body, found, Exact.of(measure, ranges)


def _average(rng: np.random.Generator) -> Iterator[Judged]:
    body, found, exact = _statistics(rng, sobol=False)
    k = int(rng.integers(len(STATISTICS_TIMES)))  # one: errors at all times are alike
    true = abs(float(found.average[k]) - exact.average[k])
    yield body.judged(found.average_error[k], true, exact.average[k], f"time {k}")


def _deviation(rng: np.random.Generator) -> Iterator[Judged]:
    body, found, exact = _statistics(rng, sobol=False)
    k = int(rng.integers(len(STATISTICS_TIMES)))
    true = abs(float(found.deviation[k]) - exact.deviation[k])
    yield body.judged(found.deviation_error[k], true, exact.deviation[k], f"time {k}")


def _index(rng: np.random.Generator) -> Iterator[Judged]:
    body, found, exact = _statistics(rng, sobol=True)
    k, field = int(rng.integers(len(STATISTICS_TIMES))), int(rng.integers(2))
    shares = {"first_index": exact.first, "total_index": exact.total}
    name = str(rng.choice(list(shares)))
    true = abs(float(found[name][field, k]) - shares[name][field, k])
    yield body.judged(found[f"{name}_error"][field, k], true, 1.0, f"{name} {field}, time {k}")


def _estimate(rng: np.random.Generator) -> Iterator[Judged]:
    """Fits to noisy histories, one noise after another."""
    eta, load = float(10.0 ** rng.uniform(-1.5, -0.3)), float(rng.uniform(0.1, 0.4))
    true = rm.Actuator(c=float(rng.uniform(0.2, 1.0)), dissipation=rm.Rayleigh(eta))
    drive, times = rm.Constant(load), np.linspace(0.0, 10.0, 80)
    run = rm.simulate(true, drive, times=times)[["thickness_stretch"]]
    exact = {"dissipation.0.eta": eta, "m": load}
    for k in range(8):
        data = run + rng.normal(0.0, NOISE, times.size)
        if k % 2:
            data = data.assign(thickness_stretch_error=("time", np.full(times.size, NOISE)))
        found = rm.fit(true, drive, data, exact, tolerance=1e-7)
        for name, value in exact.items():
            one = found.sel(parameter=name)
            error = abs(float(one.estimate) - value)
            case = f"{true!r}, {drive!r}, {name}, noise {k}"
            yield Judged(case, 1e-7, True, float(one.estimate_error), error, value)


def _rows() -> Sequence[Row]:
    bound, standard = Promise.BOUND, Promise.STANDARD
    return (
        Row("derivatives by fields", "sensitivity: derivative_error", _derivative, bound),
        Row("fields of designs", "design: solution_error", _solution, bound),
        Row("measures by functions", "Measure: error", _function, bound),
        Row("averages over uncertain fields", "uncertainty: average_error", _average, standard),
        Row("deviations by uncertain fields", "uncertainty: deviation_error", _deviation, standard),
        Row("Sobol indices", "uncertainty: first_index_error, total_index_error", _index, standard),
        Row("parameters of fits", "fit: estimate_error", _estimate, standard),
    )


ROWS = tuple(_rows())
