"""Where motion from rest crosses stable manifolds, by bisection with heyoka."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.errors.batches import CASE
from benchmarks.errors.period_map import Orbit, PeriodMap
from benchmarks.errors.row import Judged, Row, shared
from remanent._typing import FloatArray

#: Cases of a batch.
CASES = 12
#: Frequencies between which the response jumps, over the natural one.
FREQUENCIES = np.linspace(0.33, 0.6, 82)
#: Length of the runs that show it, and the least rise of the amplitude in a jump.
DURATION, LEAST_JUMP = 150.0, 0.2
#: Decades of the tolerance of runs, and of the width of the last bracket.
TOLERANCES, WIDTHS = (-9.0, -5.0), (-10.0, -6.0)
#: Periods of the reference's runs, and the relative error of its steps.
PERIODS, PRECISION = 250, 1e-16
MAX_STEPS = 50_000
#: Distance from the saddle, over the first one, below which motion is near it.
NEAR = 0.1
#: The reference looks for the crossing so far from the value found, over the reported error,
#: and knows it to the last, over that error.
REACHES = (2.0, 30.0, 1000.0)
ENOUGH = 1e-3
#: Frequency of a drive whose own is not used.
UNUSED = 1.0


@cache
def _engine() -> Any:
    """The block under the square of a sine."""
    import heyoka as hy

    x, v = hy.make_vars("x", "v")
    c, theta, prestress, b, omega = (hy.par[k] for k in range(5))
    sine = b * hy.sin(omega * hy.time)
    x2 = x * x
    x4, x7 = x2 * x2, x2 * x2 * x2 * x
    force = theta * (x4 * x4 - x2) - prestress * x7 + sine * sine * x4
    rate = (6.0 * c * v * v - 3.0 * force) / (x7 + 2.0 * c * x)
    return hy.taylor_adaptive([(x, v), (v, rate)], [1.0, 0.0], tol=PRECISION)


@dataclass(frozen=True)
class Passage:
    """How motion from rest passes a saddle.

    Attributes
    ----------
    values : dict of name to float
        Fields of actuator and drive.
    saddle : array (2,)
    unstable, stable : array (2,)
        Rows that give the coordinates along these directions.
    """

    values: dict[str, float]
    saddle: FloatArray
    unstable: FloatArray
    stable: FloatArray

    @classmethod
    def of(cls, values: dict[str, float], orbit: Orbit) -> Passage:
        """Past an orbit, by the eigenvectors of its Jacobian."""
        multipliers, vectors = np.linalg.eig(orbit.jacobian.astype(float))
        rows = np.linalg.inv(vectors)[np.argsort(-np.abs(multipliers))]
        return cls(values, orbit.state.astype(float), *rows.real)

    def side(self, omega: float) -> float:
        """On which it leaves first: the sign once the unstable coordinate exceeds the other."""
        v, engine = self.values, _engine()
        engine.time, engine.state[:] = 0.0, [1.0, 0.0]
        theta = v["temperature"] / 293.0
        engine.pars[:] = [v["c"], theta, v["prestress"], v["b"], omega]
        times = np.arange(PERIODS) * np.pi / omega
        offset = engine.propagate_grid(times, max_steps=MAX_STEPS)[5] - self.saddle
        across, along = offset @ self.unstable, np.abs(offset @ self.stable)
        distance = np.hypot(across, along)
        with np.errstate(invalid="ignore"):
            near = np.flatnonzero((distance < NEAR * distance[0]) & (np.abs(across) < along))
            left = np.flatnonzero(np.abs(across) > along)
        after = left[left > near[0]] if near.size else left[:0]
        return float(np.sign(across[after[0]])) if after.size else 0.0

    def crossing(self, omega: float, error: float) -> float | None:
        """The frequency near `omega` at which the side changes; None if it is not found."""
        for reach in REACHES:
            low, high = omega - reach * error, omega + reach * error
            before, after = self.side(low), self.side(high)
            if before * after < 0.0:
                break
        else:
            return None
        while high - low > ENOUGH * error:
            middle = 0.5 * (low + high)
            if self.side(middle) == before:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)


@dataclass(frozen=True)
class Jumps:
    """Random undamped actuators, and frequencies between which their responses jump."""

    columns: dict[str, FloatArray]
    low: FloatArray
    high: FloatArray


def _jumps(rng: np.random.Generator) -> Jumps:
    """NaN where the response of an actuator does not jump."""
    alike = rng.uniform(0.97, 1.03, (3, CASES))
    columns = {
        "c": 10.0 ** rng.uniform(-0.3, 0.0) * alike[0],
        "temperature": rng.uniform(320.0, 380.0) * alike[1],
        "prestress": rng.uniform(-0.1, 0.1, CASES),
        "b": rng.uniform(0.3, 0.5) * alike[2],
    }
    body = rm.Actuator(
        c=columns["c"][0], temperature=columns["temperature"][0], prestress=columns["prestress"][0]
    )
    natural = float(rm.equilibria(body, 0.5 * columns["b"][0] ** 2).natural_frequency[0])
    over = {name: xr.DataArray(column, dims=CASE) for name, column in columns.items()}
    omega = natural * FREQUENCIES
    responses = rm.frequency_response(
        rm.Actuator(), rm.SineSquared(0.4, UNUSED), omega, duration=DURATION, over=over
    )  # fmt: skip
    rise = np.abs(responses.amplitude.transpose(CASE, "omega").diff("omega").values)
    place = np.nan_to_num(rise).argmax(axis=1)
    jumped = np.nan_to_num(rise).max(axis=1) > LEAST_JUMP
    low, high = (np.where(jumped, omega[place + k], np.nan) for k in (0, 1))
    return Jumps(columns, low, high)


@shared
def _crossings(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """Crossings of some random actuators."""
    jumps = _jumps(rng)
    for k in np.flatnonzero(np.isfinite(jumps.low)):
        values = {name: float(column[k]) for name, column in jumps.columns.items()}
        tolerance, width = 10.0 ** rng.uniform(*TOLERANCES), 10.0 ** rng.uniform(*WIDTHS)
        body = rm.Actuator(
            c=values["c"], temperature=values["temperature"], prestress=values["prestress"]
        )
        drive = rm.SineSquared(values["b"], UNUSED)
        limits = jumps.low[k], jumps.high[k]
        try:
            ds = rm.manifold_crossing(
                body, drive, "omega", limits, width=width, tolerance=tolerance
            )
        except rm.InputError:  # no saddle, or no single crossing
            continue
        yield from _judged(ds, values, f"{values}, {limits=}, {width=}", tolerance)


def _judged(
    ds: xr.Dataset, values: dict[str, float], case: str, tolerance: float
) -> Iterator[tuple[str, Judged]]:
    """The numbers of one crossing."""
    found, reported = float(ds.omega), float(ds.omega_error)
    start = [float(ds.stretch), float(ds.stretch_rate)]
    near = PeriodMap(rm.SineSquared(0.4, UNUSED), {**values, "omega": found}).orbit(start, 1)
    if near is None:
        return
    exact = Passage.of(values, near).crossing(found, reported)
    off = REACHES[-1] * reported if exact is None else abs(found - exact)
    yield "omega", Judged(case, tolerance, False, reported, off, found)
    if exact is None:
        return
    there = PeriodMap(rm.SineSquared(0.4, UNUSED), {**values, "omega": exact}).orbit(start, 1)
    if there is None:
        return
    off = float(np.abs(there.state - start).max())
    yield "state", Judged(case, tolerance, False, float(ds.error), off)
    multipliers = there.multipliers[np.argsort(-np.abs(there.multipliers))]
    for one, error, true in zip(
        ds.multipliers.values, ds.multipliers_error.values, multipliers, strict=True
    ):
        size = float(np.abs(true))
        yield (
            "multipliers",
            Judged(case, tolerance, False, float(error), float(np.abs(one - true)), size),
        )


def _of(name: str) -> Callable[[np.random.Generator], Iterator[Judged]]:
    return lambda rng: (judged for what, judged in _crossings(rng) if what == name)


ROWS = tuple(
    Row(name, f"manifold_crossing: {variable}", _of(what))
    for name, variable, what in (
        ("parameters of crossings of manifolds", "omega_error", "omega"),
        ("saddles at crossings of manifolds", "error", "state"),
        ("multipliers of saddles at crossings of manifolds", "multipliers_error", "multipliers"),
    )
)
