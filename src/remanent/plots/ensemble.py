"""A labelled ensemble as a list of lines, each with its colour, style and name."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.lines import Line2D

from remanent._errors import InputError
from remanent.plots import style

__all__ = ["Member", "handles", "members", "point_handles"]


@dataclass(frozen=True)
class Member:
    """One member of an ensemble, ready to be drawn.

    Attributes
    ----------
    data
        The Dataset with only the dimensions that are drawn along.
    colour, dashes, marker
        How it is drawn.
    colour_label, style_label
        What its colour and its line style mean; empty where they mean nothing.
    """

    data: xr.Dataset
    colour: Any
    dashes: Any
    marker: str
    colour_label: str
    style_label: str

    @property
    def label(self) -> str:
        """What tells it from the others; empty where it is alone."""
        return ", ".join(filter(None, (self.colour_label, self.style_label)))


def members(dataset: xr.Dataset, names: Iterable[str], along: Iterable[str]) -> list[Member]:
    """Split an ensemble into lines.

    Temperature is told by colour on its own map, wherever it is a coordinate.  Without
    it, the first dimension takes the colours of Okabe and Ito.  The other dimension, if
    there is one, takes line styles and markers.

    Parameters
    ----------
    dataset
        A result with any of the dimensions of ``over``.
    names
        Variables that will be drawn.
    along
        Dimensions a line runs along.

    Returns
    -------
    list of Member
        In order of temperature.

    Raises
    ------
    InputError
        A variable is missing, or more than two dimensions are left over.
    """
    chosen = _chosen(dataset, tuple(names))
    free = [dim for dim in chosen.dims if dim not in set(along)]
    if len(free) > 2:
        raise InputError(
            "dataset",
            must="have at most two dimensions beside those drawn along",
            got=", ".join(map(str, free)),
            why="Lines differ by colour and by line style, which are two.",
            fix=f"Select values first, for example dataset.isel({free[0]}=0).",
        )
    colour_dim = _colour_dim(chosen, free)
    colours = _colours(chosen, colour_dim)
    found = []
    for place in product(*(range(chosen.sizes[dim]) for dim in free)):
        at: dict[Hashable, int] = dict(zip(free, place, strict=True))
        style_dim = next((dim for dim in free if dim != colour_dim), None)
        second = at[style_dim] if style_dim is not None else 0
        found.append(
            Member(
                data=chosen.isel(at),
                colour=colours[at[colour_dim] if colour_dim is not None else 0],
                dashes=style.DASHES[second % len(style.DASHES)],
                marker=style.MARKERS[second % len(style.MARKERS)],
                colour_label=_name(chosen, colour_dim, at) if colour_dim in free else "",
                style_label=_name(chosen, style_dim, at),
            )
        )
    return sorted(found, key=_temperature)


def handles(found: Sequence[Member]) -> list[Line2D]:
    """Legend entries of lines: one per colour and, where they differ too, one per line style.

    Parameters
    ----------
    found
        Members in the order they were drawn.

    Returns
    -------
    list of matplotlib.lines.Line2D
        Empty for a single member without a name.
    """
    return [
        Line2D([], [], color=colour, linestyle=one.dashes if colour == style.INK else "-", label=n)
        for colour, one, n in _entries(found)
    ]


def point_handles(found: Sequence[Member]) -> list[Line2D]:
    """Legend entries of points: one per colour and, where they differ too, one per marker."""
    return [
        Line2D([], [], color=colour, linestyle="", ms=3.5, label=name,
               marker=one.marker if colour == style.INK else "o")
        for colour, one, name in _entries(found)
    ]  # fmt: skip


def _entries(found: Sequence[Member]) -> list[tuple[Any, Member, str]]:
    colours = {one.colour_label: one for one in found if one.colour_label}
    styles = {one.style_label: one for one in found if one.style_label}
    return [(one.colour, one, name) for name, one in colours.items()] + [
        (style.INK, one, name) for name, one in styles.items() if len(styles) > 1
    ]


def _chosen(dataset: xr.Dataset, names: tuple[str, ...]) -> xr.Dataset:
    missing = [name for name in names if name not in dataset.variables]
    if missing:
        raise InputError(
            "dataset",
            must=f"have the variables {', '.join(names)}",
            got=f"one without {', '.join(missing)}",
            why="They are what this plot draws.",
            fix="Pass the result of a verb that returns them.",
        )
    return dataset[[name for name in names if name not in dataset.dims]]


def _colour_dim(dataset: xr.Dataset, free: list[Hashable]) -> Hashable | None:
    if "temperature" in dataset.coords and dataset["temperature"].ndim == 1:
        return dataset["temperature"].dims[0]
    return free[0] if free else None


def _colours(dataset: xr.Dataset, dim: Hashable | None) -> list[Any]:
    if "temperature" in dataset.coords and dataset["temperature"].ndim <= 1:
        return list(style.temperature_colours(np.atleast_1d(dataset["temperature"].values)))
    count = dataset.sizes[dim] if dim is not None else 1
    wheel = list(style.OKABE_ITO.values())
    if count <= len(wheel):
        return wheel[:count]
    from matplotlib import colormaps

    return [colormaps["cividis"](x) for x in np.linspace(0.0, 0.85, count)]


def _name(dataset: xr.Dataset, dim: Hashable | None, at: Mapping[Hashable, int]) -> str:
    """Say where along one dimension a member is, by every coordinate that has just it."""
    if dim is None:
        return ""
    along = [array for array in dataset.coords.values() if array.dims == (dim,)]
    if not along:
        return f"{dim} {at[dim]}"
    return ", ".join(
        style.title(array, np.asarray(array.values[at[dim]]).item()) for array in along
    )


def _temperature(member: Member) -> float:
    found = member.data.coords.get("temperature")
    return float(found) if found is not None and found.ndim == 0 else 0.0
