"""Actuators at rest: forces on the stretches, and equilibria of two of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from remanent._field import Program
from remanent._typing import FloatArray, IntArray
from remanent.analysis.maps import Mapped
from remanent.analysis.orbits import distinct, newton
from remanent.integrate.status import Status
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies._ensemble import Ensemble, at_rest

#: Stretches from which equilibria of two coordinates are sought, and how many.
_STRETCHES = np.geomspace(0.1, 10.0, 24)
#: Largest acceleration, relative to the loads', of what counts as an equilibrium.
_STILL = 1e-12


@dataclass(frozen=True)
class AtRest:
    """The field of an ensemble at zero rates, branches relaxed, at the surroundings' temperature.

    Stretches are given for each coordinate, arrays (point,); differences of stretches
    that the state holds as well are 1.
    """

    ens: Ensemble

    def force(self, case: IntArray, *stretches: FloatArray) -> FloatArray:
        """Acceleration of the first coordinate."""
        return np.asarray(self.accelerations(case, *stretches)[0])

    def accelerations(self, case: IntArray, *stretches: Any) -> list[Any]:
        """Acceleration of each coordinate."""
        rates = self.run(self.ens.field.rates, case, *stretches)
        return [r for r, n in zip(rates, self.ens.field.state, strict=True) if _is_speed(n)]

    def thickness(self, case: IntArray, *stretches: FloatArray) -> FloatArray:
        (found,) = self.run(self.ens.field.observables["thickness_stretch"], case, *stretches)
        return np.asarray(found)

    def potential(self, case: IntArray, *stretches: FloatArray) -> FloatArray:
        (found,) = self.run(self.ens.field.observables["energy"], case, *stretches)
        return np.asarray(found)

    def run(self, program: Program, case: IntArray, *stretches: Any) -> list[Any]:
        """Outputs of a program of the field, each an array (point,)."""
        values = {name: column[case] for name, column in self.ens.values.items()}
        state = [self._value(name, stretches, values) for name in self.ens.field.state]
        columns = [values[name] for name in self.ens.field.parameters]
        with np.errstate(all="ignore"):
            found = program([0.0, *state, *columns], functions=np)
        return [np.broadcast_to(value, np.shape(stretches[0])) for value in found]

    def _value(self, name: str, stretches: Sequence[Any], values: dict[str, FloatArray]) -> Any:
        if name.startswith("parting."):
            return np.full(np.shape(stretches[0]), 0.0 if name.endswith("_rate") else 1.0)
        if name.endswith("_rate"):
            return 0.0 * stretches[0]
        if "stretch" not in name:
            return at_rest(name, values)
        return stretches[-1] if name.endswith("_2") else stretches[0]


def _is_speed(name: str) -> bool:
    return name.startswith("stretch") and name.endswith("_rate")


def in_plane(ens: Ensemble) -> xr.Dataset:
    """All equilibria of two coordinates, labelled."""
    still = AtRest(ens)
    found = [np.empty((0, 2)) if ens.invalid[k] else _of_one(still, k) for k in range(ens.count)]
    most = max((len(rows) for rows in found), default=0)
    stretches = np.full((ens.count, most, 2), np.nan)
    for k, rows in enumerate(found):
        stretches[k, : len(rows)] = rows
    case = np.repeat(np.arange(ens.count), most).reshape(ens.count, most)
    pair = stretches[..., 0], stretches[..., 1]
    matrix = _slopes(still, case, *pair)
    exists = np.isfinite(pair[0])
    values = np.linalg.eigvals(np.where(exists[..., None, None], -matrix, np.eye(2)))
    squared = np.sort(np.where(exists[..., None], values.real, np.nan), axis=-1)
    with np.errstate(invalid="ignore"):
        frequency = np.sqrt(np.where(squared > 0.0, squared, np.nan))
        stable = np.where((squared > 0.0).all(axis=-1), "stable", "unstable")
    dims = (*ens.dims, "equilibrium")
    along = {
        "equilibrium_stretch": still.thickness(case, *pair),
        "stretch_1": pair[0],
        "stretch_2": pair[1],
        "equilibrium_potential": still.potential(case, *pair),
        "stability": np.where(exists, stable, ""),
    }
    variables: dict[str, Labelled] = {k: (dims, ens.shaped(v)) for k, v in along.items()}
    variables["natural_frequency"] = ((*dims, "mode"), ens.shaped(frequency))
    status = np.where(ens.invalid, Status.INVALID, Status.OK).astype(np.int8)
    variables["status"] = (ens.dims, ens.shaped(status))
    coords: dict[str, Labelled] = {
        **ens.coords,
        "equilibrium": (("equilibrium",), np.arange(most)),
        "mode": (("mode",), np.arange(2)),
    }
    attributes = provenance.attributes(ens.actuator, ens.drive, None, over=ens.coords)
    return build.dataset(variables, coords, attributes)


def _slopes(still: AtRest, case: IntArray, one: FloatArray, two: FloatArray) -> FloatArray:
    """Derivatives of the accelerations by the stretches, by complex steps: (..., 2, 2)."""
    step = 1e-100
    columns = [
        np.stack(still.accelerations(case, one + 1j * step * e, two + 1j * step * (1 - e)), -1)
        for e in (1, 0)
    ]
    return np.asarray(np.stack(columns, axis=-1).imag / step)


def _of_one(still: AtRest, k: int) -> FloatArray:
    """Stretches of the equilibria of one actuator, (equilibrium, 2).

    An equilibrium is a fixed point of the map that adds the accelerations to the stretches.
    """
    guesses = np.stack(np.meshgrid(_STRETCHES, _STRETCHES, indexing="ij"), -1).reshape(-1, 2)
    map_ = _Pushed(still, k)
    bounds = np.array([[0.5 * _STRETCHES[0], 2.0 * _STRETCHES[-1]]] * 2)
    none = np.empty((len(guesses), 0))
    orbits = newton(map_, guesses, none, iterate=1, tolerance=_STILL, bounds=bounds)
    found = distinct(map_, orbits, np.empty(0), iterate=1).state
    return np.asarray(found[np.lexsort(found.T[::-1])])


@dataclass(frozen=True)
class _Pushed:
    """Stretches plus accelerations, as a map."""

    still: AtRest
    case: int
    dimension: int = 2

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> Mapped:
        case = np.full(len(states), self.case)
        moved = np.stack(self.still.accelerations(case, *states.T), axis=1)
        matrix = _slopes(self.still, case, *states.T) + np.eye(2)
        rounding = 4.0 * np.finfo(float).eps * (1.0 + np.abs(matrix).max(axis=(1, 2)))
        return Mapped(states + moved, matrix, np.zeros((len(states), 2, 0)), rounding)
