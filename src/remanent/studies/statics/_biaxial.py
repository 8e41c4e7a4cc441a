"""Equilibria of two in-plane stretches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import xarray as xr
from scipy.ndimage import maximum_filter

from remanent._status import Status
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.maps import Mapped
from remanent.analysis.orbits import distinct, newton
from remanent.results import build, provenance
from remanent.results.build import Labelled
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.statics._static_ensemble import AtRest, farthest_inside

#: Equilibria of two coordinates are sought up to this stretch and down to its inverse, in so
#: many directions from rest and at so many distances along each.
_FARTHEST, _DIRECTIONS, _DISTANCES = 1000.0, 96, 96
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
    attributes = provenance.attributes(ens.system, ens.drive, None, over=ens.coords)
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

    An equilibrium is a fixed point of the map that adds the accelerations to the logarithms
    of the stretches, which keeps these positive.
    """
    map_ = _Pushed(still, k)
    guesses = _guesses(still, k)
    bounds = np.log(2.0 * _FARTHEST) * np.array([[-1.0, 1.0]] * 2)
    none = np.empty((len(guesses), 0))
    orbits = newton(map_, guesses, none, iterate=1, tolerance=_STILL, bounds=bounds)
    found = np.exp(distinct(map_, orbits, np.empty(0), iterate=1).state)
    return np.asarray(found[np.lexsort(found.T[::-1])])


def _guesses(still: AtRest, k: int) -> FloatArray:
    """Corners of the cells in which both accelerations change sign, and of those beside them."""
    nodes = _nodes(still, k)
    case = np.full(nodes.shape[:2], k)
    pushed = np.stack(still.accelerations(case, *np.moveaxis(np.exp(nodes), -1, 0)))
    corners = [np.roll(pushed, -i, axis=1)[..., j : j - 1 or None] for i in (0, 1) for j in (0, 1)]
    low, high = np.fmin.reduce(corners), np.fmax.reduce(corners)
    changes = ((low <= 0.0) & (high >= 0.0)).all(axis=0)
    chosen = maximum_filter(changes, 3, mode=("wrap", "nearest"))
    used = np.zeros(nodes.shape[:2], dtype=np.bool_)
    for i, j in ((0, 0), (0, 1), (1, 0), (1, 1)):
        used[:, j : j - 1 or None] |= np.roll(chosen, i, axis=0)
    return np.asarray(nodes[used])


def _nodes(still: AtRest, k: int) -> FloatArray:
    """Logarithms of stretches, (direction, distance, 2), from rest up to the limits.

    Where the material has a limit, 1 less the share of the way to it falls with the fourth
    power: forces grow without bound there, so that equilibria lie close to it.
    """
    angle = np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False)
    towards = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    reach = np.log(_FARTHEST) / np.abs(towards).max(axis=1)

    def inside(distance: FloatArray, row: IntArray) -> BoolArray:
        stretches = np.exp(distance[..., None] * towards[row])
        return still.reachable(np.full(row.shape, k), stretches[..., 0], stretches[..., 1])

    limited = np.flatnonzero(~inside(reach, np.arange(angle.size)))
    share = np.linspace(0.0, 1.0, _DISTANCES)
    shares = np.tile(share, (angle.size, 1))
    if limited.size:
        reach[limited] = farthest_inside(inside, 0.0 * reach[limited], reach[limited], limited)
        shares[limited] = 1.0 - (1.0 - share) ** 4
    return np.asarray((reach[:, None] * shares)[..., None] * towards[:, None])


@dataclass(frozen=True)
class _Pushed:
    """Logarithms of stretches plus accelerations, as a map."""

    still: AtRest
    case: int
    dimension: int = 2

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> Mapped:
        case, stretches = np.full(len(states), self.case), np.exp(states)
        moved = np.stack(self.still.accelerations(case, *stretches.T), axis=1)
        matrix = _slopes(self.still, case, *stretches.T) * stretches[:, None] + np.eye(2)
        rounding = 4.0 * np.finfo(float).eps * (1.0 + np.abs(matrix).max(axis=(1, 2)))
        return Mapped(states + moved, matrix, np.zeros((len(states), 2, 0)), rounding)
