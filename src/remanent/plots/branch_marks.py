"""Marks on branches of periodic orbits: special points, and ends within the range."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent._typing import FloatArray
from remanent.plots import style
from remanent.plots.ensemble import Member

__all__ = ["end_legend_entries", "mark_ends", "mark_special_points", "special_point_legend_entries"]

#: Markers of special points, by precedence where two lie at one place.
_SPECIAL_POINT_MARKERS: Final[Mapping[str, str]] = MappingProxyType(
    {"branch point": "^", "period doubling": "s", "Neimark-Sacker": "D", "fold": "o"}
)
#: Mark of an end.
_END_LOOKS: Final[Mapping[str, Any]] = MappingProxyType(
    {"marker": "x", "ms": 4.5, "mew": 1.1, "linestyle": ""}
)
#: What is said of the end of a branch, by its reason.
_END_WORDS: Final[Mapping[str, str]] = MappingProxyType(
    {"max_points": "end: max_points", "lost": "end: branch lost"}
)
#: Distance of two special points, over the size of what is drawn, below which they are one.
_COINCIDENCE_DISTANCE: Final = 1e-4


def mark_special_points(
    axes: Axes, member: Member, x: str, variable: str, size: FloatArray
) -> list[Line2D]:
    """Mark special points, one mark where several kinds coincide, and return legend entries.

    A branch of doubled period runs there and back through the point where it starts: the turn
    is no fold.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What branches were drawn in.
    member : Member
        With ``special_kind`` and what is drawn, ``special_<name>``.
    x, variable : str
        Against what, and what is drawn.
    size : array (2,)
        Width and height of what is drawn.

    Returns
    -------
    list of matplotlib.lines.Line2D
    """
    data, name = member.data, f"special_{variable}"
    if name not in data:
        return []
    places: list[FloatArray] = []
    entries = []
    for kind, marker in _SPECIAL_POINT_MARKERS.items():
        of_kind = data["special_kind"].values == kind
        found = np.stack([data[f"special_{x}"].values[of_kind], data[name].values[of_kind]], axis=1)
        found = found[np.isfinite(found).all(axis=1)]
        alone = [p for p in found if not _is_near(p / size, [q / size for q in places])]
        places += alone
        if alone:
            looks: dict[str, Any] = {"ms": 4.0, "mew": 1.0, "linestyle": "", "marker": marker}
            axes.plot(*np.transpose(alone), mfc=axes.get_facecolor(), mec=member.colour, zorder=5,
                      **looks)  # fmt: skip
            ink = style.ink_colour()
            entries.append(Line2D([], [], color=ink, mfc="none", label=kind, **looks))
    return entries


def _is_near(place: FloatArray, others: list[FloatArray]) -> bool:
    return any(np.abs(place - other).max() < _COINCIDENCE_DISTANCE for other in others)


def mark_ends(axes: Axes, member: Member, x: str, variable: str) -> list[Line2D]:
    """Mark ends within the range of the parameter, and return legend entries with the reason.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What branches were drawn in.
    member : Member
        With ``end_reason``; without, there is nothing to mark.
    x, variable : str
        Against what, and what is drawn.

    Returns
    -------
    list of matplotlib.lines.Line2D
    """
    data = member.data
    if "end_reason" not in data:
        return []
    data = data if "branch" in data.dims else data.expand_dims("branch")
    entries = []
    for k in range(data.sizes["branch"]):
        row = data.isel(branch=k)
        for place, words in _early_ends(row, x):
            height = np.ravel(row[variable].isel(point=place).values)[0]
            spot = float(row[x].values[place]), float(height)
            axes.plot(*spot, color=member.colour, zorder=6, **_END_LOOKS)
            entries.append(_end_entry(words))
    return entries


def end_legend_entries(dataset: xr.Dataset, x: str) -> list[Line2D]:
    """Legend entries of the ends that :func:`mark_ends` marks.

    Parameters
    ----------
    dataset : xarray.Dataset
        Branches, with any dimensions of ``over``.
    x : str
        Against what they are drawn.

    Returns
    -------
    list of matplotlib.lines.Line2D
    """
    if "end_reason" not in dataset:
        return []
    rows = dataset[[x, "end_reason"]].stack(row=[d for d in dataset[x].dims if d != "point"])
    each = (rows.isel(row=k) for k in range(rows.sizes["row"]))
    found = dict.fromkeys(words for row in each for _, words in _early_ends(row, x))
    return [_end_entry(words) for words in found]


def _early_ends(row: xr.Dataset, x: str) -> list[tuple[int, str]]:
    """The points at which one branch ends for a reason that is said, and the reason."""
    finite = np.flatnonzero(np.isfinite(row[x].values))
    reasons = row["end_reason"].values
    if not finite.size or reasons.shape != (2,):  # of one end alone it is not said which it is
        return []
    ends = zip(finite[[0, -1]], reasons, strict=True)
    bounds = _parameter_bounds(row, x)
    said = [(int(k), _end_words(str(why), float(row[x].values[k]), bounds)) for k, why in ends]
    return [(place, words) for place, words in said if words]


def _end_entry(words: str) -> Line2D:
    return Line2D([], [], color=style.ink_colour(), label=words, **_END_LOOKS)


def _parameter_bounds(data: xr.Dataset, x: str) -> FloatArray:
    """The range that was asked for, where the attributes say it; empty otherwise."""
    bounds = data.attrs.get("parameter_range")
    if bounds is None or isinstance(bounds, str) or x != data.attrs.get("parameter", "omega"):
        return np.empty(0)
    return np.ravel(np.asarray(bounds, dtype=np.float64))


def _end_words(reason: str, at: float, bounds: FloatArray) -> str:
    """Why a branch ends where it does; empty where nothing is to be said."""
    if reason == "bounds" and bounds.size:
        tolerance = _COINCIDENCE_DISTANCE * float(np.ptp(bounds))
        return "" if np.abs(bounds - at).min() <= tolerance else "edge of the state box"
    return _END_WORDS.get(reason, "")


def special_point_legend_entries(dataset: xr.Dataset) -> list[Line2D]:
    """Legend entries of the kinds of special points that occur."""
    kinds = set(np.unique(dataset["special_kind"].values.astype(str)))
    looks: dict[str, Any] = {"mfc": "none", "ms": 4, "linestyle": ""}
    return [
        Line2D([], [], color=style.ink_colour(), marker=marker, label=kind, **looks)
        for kind, marker in _SPECIAL_POINT_MARKERS.items()
        if kind in kinds
    ]
