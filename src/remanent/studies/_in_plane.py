"""Equilibria of two in-plane stretches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr

from remanent._typing import FloatArray, IntArray
from remanent.analysis.maps import Mapped
from remanent.analysis.orbits import distinct, newton
from remanent.integrate.status import Status
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies._at_rest import AtRest
from remanent.studies._ensemble import Ensemble

#: Stretches from which equilibria of two coordinates are sought, and how many.
_STRETCHES = np.geomspace(0.1, 10.0, 24)
#: Largest acceleration, relative to the loads', of what counts as an equilibrium.
_STILL = 1e-12


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
