"""Random actuators under random loads, many in one call of a verb."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, SupportsIndex

import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.errors.period_map import PeriodMap

#: Decades of tolerance that are asked for.
TOLERANCES = (-11.0, -3.0)
#: The dimension along which cases lie.
CASE = "case"


@dataclass(frozen=True)
class Batch:
    """Random cases, all damped or none.

    Attributes
    ----------
    system : Actuator
    drive : SineSquared
    over : dict of name to DataArray (case,)
        What the cases differ in.
    damped : bool
    tolerance : float
    """

    system: rm.Actuator
    drive: rm.SineSquared
    over: dict[str, xr.DataArray]
    damped: bool
    tolerance: float

    @property
    def count(self) -> int:
        return int(self.over["c"].size)

    def values(self, k: SupportsIndex) -> dict[str, float]:
        """The fields of one case."""
        return {name: float(column[int(k)]) for name, column in self.over.items()}

    def reference(self, k: SupportsIndex) -> PeriodMap:
        """The period map of one case by heyoka."""
        return PeriodMap(self.drive, self.values(k))

    def described(self, k: SupportsIndex) -> str:
        """Text that makes the case again."""
        return ", ".join(f"{name}={value!r}" for name, value in self.values(k).items())


def random_batch(
    rng: np.random.Generator,
    count: int,
    *,
    damped: bool | None = None,
    eta: tuple[float, float] = (-2.0, 0.0),
    b: tuple[float, float] = (0.1, 1.0),
) -> Batch:
    """Random cases; `eta` is the range of decades of the viscosity, `b` that of the load."""
    damped = bool(rng.uniform() < 0.5) if damped is None else damped
    columns: dict[str, Any] = {
        "c": 10.0 ** rng.uniform(-1.0, 0.0, count),
        "temperature": 293.0 * rng.uniform(0.8, 1.3, count),
        "prestress": rng.uniform(-0.5, 1.0, count),
        "b": rng.uniform(*b, count),
        "omega": rng.uniform(0.5, 2.5, count),
    }
    if damped:
        columns["dissipation.0.eta"] = 10.0 ** rng.uniform(*eta, count)
    return Batch(
        rm.Actuator(dissipation=rm.Rayleigh(0.1) if damped else ()),
        rm.SineSquared(0.4, 1.25),
        {name: xr.DataArray(column, dims=CASE) for name, column in columns.items()},
        damped,
        10.0 ** rng.uniform(*TOLERANCES),
    )
