"""Equilibria, natural frequencies, folds and thresholds, against mpmath in fifty digits."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import mpmath as mp
import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.errors.row import EPS, Judged, Row, shared

#: Actuators of one call.
BATCH = 20
#: Digits of the reference.
DIGITS = 50
#: Relative distance of the two places with which its search begins.
NEAR = 1e-12


class Block:
    """The undamped block of [Thermal, eq. 16] in rational numbers; Gent's where `jm` is given."""

    def __init__(self, values: dict[str, float], jm: float | None = None) -> None:
        self.c = mp.mpf(values["c"])
        self.theta = mp.mpf(values["temperature"]) / 293
        self.s = mp.mpf(values["prestress"])
        self.jm = None if jm is None else mp.mpf(jm)

    def force(self, x: Any, m: Any) -> Any:
        """Half the derivative of the potential by the stretch."""
        stiff = 1 if self.jm is None else 1 / (1 - (2 * x**2 + x**-4 - 3) / self.jm)
        return self.theta * stiff * (x - x**-5) - self.s + m * x**-3

    def slope(self, x: Any, m: Any) -> Any:
        """Derivative of the force by the stretch."""
        return mp.diff(lambda y: self.force(y, m), x)

    def potential(self, x: Any, m: Any, difference: Any = 0) -> Any:
        """The energy of a block at rest; its edges may differ by twice a difference."""
        area = x**2 - difference**2
        stretched = 2 * x**2 + 2 * difference**2 + area**-2 - 3  # I1 - 3
        if self.jm is not None:
            stretched = -self.jm * mp.log(1 - stretched / self.jm)
        return self.theta * stretched / 2 - 2 * self.s * (x - 1) - m / area

    def rise_from_rest(self, m: Any) -> Callable[[Any], Any]:
        """How much larger the energy is at a stretch than at rest."""
        return lambda x: self.potential(x, m) - self.potential(mp.mpf(1), m)

    def transverse_stiffness(self, x: Any, m: Any) -> Any:
        """Square of the frequency of a small difference, whose kinetic energy is q'^2/3."""
        return mp.diff(lambda q: self.potential(x, m, q), 0, 2) * 3 / 2

    def load(self, x: Any) -> Any:
        """The load under which `x` is an equilibrium."""
        return -(x**3) * self.force(x, 0)

    def load_slope(self, x: Any) -> Any:
        """Derivative of that load by the stretch."""
        return mp.diff(self.load, x)


def _random_values(rng: np.random.Generator, prestress: tuple[float, float]) -> dict[str, Any]:
    columns = {
        "c": 10.0 ** rng.uniform(-2.0, 0.0, BATCH),
        "temperature": 293.0 * rng.uniform(0.7, 1.4, BATCH),
        "prestress": rng.uniform(*prestress, BATCH),
    }
    return {name: xr.DataArray(column, dims="case") for name, column in columns.items()}


def _number(case: xr.Dataset, name: str, exact: Any, what: str) -> Judged:
    true = float(abs(mp.mpf(float(case[name])) - exact))
    error = float(case[f"{name}_error"])
    return Judged(f"{what}: {name}", EPS, False, error, true, abs(float(exact)))


@shared
def _equilibria(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """Every number of the equilibria of some actuators, with its kind."""
    jm = None if rng.uniform() < 0.5 else float(10.0 ** rng.uniform(0.7, 2.0))
    over = _random_values(rng, (-1.0, 3.0))
    over["m"] = xr.DataArray(rng.uniform(-3.0, 3.0, BATCH), dims="case")
    material = rm.NeoHookean() if jm is None else rm.Gent(jm)
    found = rm.equilibria(rm.Actuator(material=material), over=over)
    with mp.workdps(DIGITS):
        for k in range(BATCH):
            values = {name: float(column[k]) for name, column in over.items()}
            block, m = Block(values, jm), mp.mpf(values["m"])
            what = f"{values}, jm={jm}"
            for i in range(found.sizes["equilibrium"]):
                one = found.isel(case=k, equilibrium=i)
                start = float(one.stretch)
                if not np.isfinite(start):
                    continue
                x = mp.findroot(lambda y, b=block, m=m: b.force(y, m), mp.mpf(start))
                yield "position", _number(one, "stretch", x, what)
                yield "position", _number(one, "equilibrium_stretch", x**-2, what)
                energy, stiffness = block.potential(x, m), block.transverse_stiffness(x, m)
                yield "potential", _number(one, "equilibrium_potential", energy, what)
                yield "transverse", _number(one, "transverse_stiffness", stiffness, what)
                square = 3 * block.slope(x, m) / (1 + 2 * block.c * x**-6)
                if square > 0 and np.isfinite(one.natural_frequency):
                    yield "frequency", _number(one, "natural_frequency", mp.sqrt(square), what)
            one = found.isel(case=k)
            for name in ("turning_lower", "turning_upper"):
                if not np.isfinite(one[name]) or float(one[name]) == 1.0:  # rest itself
                    continue
                near = mp.mpf(float(one[name])) ** -0.5
                x = mp.findroot(block.rise_from_rest(m), (near, near * (1 + NEAR)))
                yield "turning", _number(one, name, x**-2, what)


@shared
def _thresholds(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    """Folds and dynamic thresholds of some actuators along the load, with their kind."""
    over = _random_values(rng, (2.2, 3.0))
    pulled = rm.equilibria(rm.Actuator(), 0.0, over=over)
    for k in range(0, BATCH, 4):
        values: dict[str, Any] = {name: float(column[k]) for name, column in over.items()}
        start = float(pulled.stretch.isel(case=k, equilibrium=0))
        body = rm.Actuator(**values)
        ds = rm.snap_through(body, "m", (-1.0, 8.0), initial=start)
        what = f"{values}, initial={start}"
        with mp.workdps(DIGITS):
            block = Block(values)
            for i in range(ds.sizes["fold"]):
                one = ds.isel(fold=i)
                x = mp.findroot(block.load_slope, mp.mpf(float(one.fold_stretch)))
                yield "fold", _number(one, "fold_stretch", x, what)
                yield "fold", _number(one, "fold_thickness_stretch", x**-2, what)
                yield "fold", _number(one, "fold_m", block.load(x), what)
            for i in range(ds.sizes["snap"]):
                one, begin = ds.isel(snap=i), mp.mpf(start)

                def rise(y: Any, block: Block = block, begin: Any = begin) -> Any:
                    m = block.load(y)
                    return block.potential(y, m) - block.potential(begin, m)

                x = mp.findroot(rise, mp.mpf(float(one.snap_stretch)))
                yield "snap", _number(one, "snap_stretch", x, what)
                yield "snap", _number(one, "snap_thickness_stretch", x**-2, what)
                yield "snap", _number(one, "snap_m", block.load(x), what)


def _of(
    kind: str, numbers: Callable[[np.random.Generator], Iterable[tuple[str, Judged]]]
) -> Callable[[np.random.Generator], Iterator[Judged]]:
    return lambda rng: (judged for what, judged in numbers(rng) if what == kind)


ROWS = (
    Row(
        "positions of equilibria",
        "equilibria: stretch_error, equilibrium_stretch_error",
        _of("position", _equilibria),
    ),
    Row(
        "natural frequencies of equilibria",
        "equilibria: natural_frequency_error",
        _of("frequency", _equilibria),
    ),
    Row(
        "potentials of equilibria",
        "equilibria: equilibrium_potential_error",
        _of("potential", _equilibria),
    ),
    Row(
        "transverse stiffnesses of equilibria",
        "equilibria: transverse_stiffness_error",
        _of("transverse", _equilibria),
    ),
    Row(
        "turning points of motions from rest",
        "equilibria: turning_lower_error, turning_upper_error",
        _of("turning", _equilibria),
    ),
    Row(
        "folds of equilibria",
        "snap_through: fold_m_error, fold_stretch_error, fold_thickness_stretch_error",
        _of("fold", _thresholds),
    ),
    Row(
        "thresholds of snaps",
        "snap_through: snap_m_error, snap_stretch_error, snap_thickness_stretch_error",
        _of("snap", _thresholds),
    ),
)
