"""Where stability changes along a branch: at the special point between two computed points."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._typing import FloatArray

__all__ = ["located_names", "points_of_change"]

#: Way from one point of a branch to the next by a special point, over the straight one, up to
#: which the special point lies between the two: an arc of a curve that turns back is not longer.
_MAX_DETOUR: Final = 1.6


def located_names(dataset: xr.Dataset) -> list[str]:
    """Names of numbers that are known along branches and at their special points alike.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``continue_orbit`` or ``response_diagram``.

    Returns
    -------
    list of str
        Of errors none: they do not say where on the branch a point lies.
    """
    return [
        name
        for name in map(str, dataset.variables)
        if not name.endswith("error")
        and {"point"} <= set(dataset[name].dims) <= {"point", "branch", *dataset["stability"].dims}
        and dataset[name].dtype.kind == "f"
        and f"special_{name}" in dataset
    ]


def points_of_change(
    row: xr.Dataset, x: str, variable: str, points: FloatArray
) -> dict[int, FloatArray]:
    """The special points of one branch at which its stability changes, as they are drawn.

    Parameters
    ----------
    row : xarray.Dataset
        One branch, with its ``stability`` and :func:`located_names`, those of special points too.
    x, variable : str
        Against what, and what is drawn.
    points : array (point, 2)
        What is drawn of the branch.

    Returns
    -------
    dict of int to array (1, 2)
        By the number of the first point that follows.  A variable that special points do not have
        is taken from the straight line between the two neighbours.  A change that no special
        point explains is left out.
    """
    names = located_names(row)
    if not names:
        return {}
    along = np.stack([row[name].values for name in names], axis=1)
    special = np.stack([row[f"special_{name}"].values for name in names], axis=1)
    size = np.array([_extent(column) for column in along.T])
    found = {}
    stabilities = row["stability"].values[: len(points)]
    for k in np.flatnonzero(stabilities[1:] != stabilities[:-1]):
        place, share = _special_point_between(along[k] / size, along[k + 1] / size, special / size)
        if place is not None:
            at = row[f"special_{x}"].values[place]
            height = _value_at(row, variable, place, share, points[k : k + 2, 1])
            found[int(k) + 1] = np.array([[at, height]])
    return found


def _extent(values: NDArray[Any]) -> float:
    known = values[np.isfinite(values)]
    return float(np.ptp(known)) or 1.0 if known.size else 1.0


def _special_point_between(
    start: FloatArray, end: FloatArray, special: FloatArray
) -> tuple[int | None, float]:
    """The special point between two points, or None; and its share of the way."""
    before = np.linalg.norm(special - start, axis=1)
    way = before + np.linalg.norm(special - end, axis=1)
    straight = np.linalg.norm(end - start)
    near = np.flatnonzero(way <= _MAX_DETOUR * straight)
    if not near.size or not straight:
        return None, 0.0
    place = int(near[np.argmin(way[near])])
    return place, float(before[place] / way[place])


def _value_at(
    row: xr.Dataset, variable: str, place: int, share: float, beside: FloatArray
) -> float:
    """What is drawn at a special point, between the values of its two neighbours."""
    if f"special_{variable}" in row:
        return float(row[f"special_{variable}"].values[place])
    low, high = beside
    # Of the multipliers, those that reach the unit circle between the two are on it.
    if variable == "multipliers" and np.abs(beside - 1.0).min() <= abs(high - low):
        return 1.0
    return float(low + share * (high - low))
