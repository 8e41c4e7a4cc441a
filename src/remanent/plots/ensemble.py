"""A labelled ensemble as a list of lines, each with its colour, style and name."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.lines import Line2D

from remanent._errors import InputError
from remanent.plots import style

__all__ = ["Member", "line_legend_entries", "point_legend_entries", "split_into_members"]

#: Share of the colour map that many members use: its end is too light for lines on white.
_MEMBER_COLOUR_MAP_END: Final = 0.85


@dataclass(frozen=True)
class Member:
    """One member of an ensemble, ready to be drawn.

    Attributes
    ----------
    data : xarray.Dataset
        The Dataset with only the dimensions that are drawn along.
    colour, line_style, marker : Any, Any, str
        How it is drawn, as Matplotlib understands it.
    colour_label, style_label : str
        What its colour and its line style mean; empty where they mean nothing.
    """

    data: xr.Dataset
    colour: Any
    line_style: Any
    marker: str
    colour_label: str
    style_label: str

    @property
    def label(self) -> str:
        """What tells it from the others; empty where it is alone."""
        return ", ".join(filter(None, (self.colour_label, self.style_label)))


def split_into_members(
    dataset: xr.Dataset, names: Iterable[str], along: Iterable[str]
) -> list[Member]:
    """Split an ensemble into lines.

    Temperature is told by colour on its own map, wherever it is a coordinate.  Without
    it, the first dimension takes the colours of Okabe and Ito.  The other dimension, if
    there is one, takes line styles and markers.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result with any of the dimensions of ``over``.
    names : iterable of str
        Variables that will be drawn.
    along : iterable of str
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
    subset = _select_variables(dataset, tuple(names))
    free = [dim for dim in subset.dims if dim not in set(along)]
    if len(free) > 2:
        raise InputError(
            "dataset",
            must="have at most two dimensions beside those drawn along",
            got=", ".join(map(str, free)),
            why="Lines differ by colour and by line style, which are two.",
            fix=f"Select values first, for example dataset.isel({free[0]}=0).",
        )
    colour_dim = _colour_dimension(subset, free)
    style_dim = next((dim for dim in free if dim != colour_dim), None)
    colours = _member_colours(subset, colour_dim)
    drawn = []
    for numbers in product(*(range(subset.sizes[dim]) for dim in free)):
        indices: dict[Hashable, int] = dict(zip(free, numbers, strict=True))
        second = indices[style_dim] if style_dim is not None else 0
        drawn.append(
            Member(
                data=subset.isel(indices),
                colour=colours[indices[colour_dim] if colour_dim is not None else 0],
                line_style=style.LINE_STYLES[second % len(style.LINE_STYLES)],
                marker=style.MARKERS[second % len(style.MARKERS)],
                colour_label=_coordinate_label(subset, colour_dim, indices)
                if colour_dim in free
                else "",
                style_label=_coordinate_label(subset, style_dim, indices),
            )
        )
    return sorted(drawn, key=_member_temperature)


def line_legend_entries(drawn: Sequence[Member]) -> list[Line2D]:
    """Legend entries of lines: one per colour and, where they differ too, one per line style.

    Parameters
    ----------
    drawn : sequence of Member
        In the order they were drawn.

    Returns
    -------
    list of matplotlib.lines.Line2D
        Empty for a single member without a name.
    """
    return [
        Line2D([], [], color=colour, label=name,
               linestyle=member.line_style if colour == style.INK_COLOUR else "-")
        for colour, member, name in _distinct_colours_and_styles(drawn)
    ]  # fmt: skip


def point_legend_entries(drawn: Sequence[Member]) -> list[Line2D]:
    """Legend entries of points: one per colour and, where they differ too, one per marker."""
    return [
        Line2D([], [], color=colour, linestyle="", ms=3.5, label=name,
               marker=member.marker if colour == style.INK_COLOUR else "o")
        for colour, member, name in _distinct_colours_and_styles(drawn)
    ]  # fmt: skip


def _distinct_colours_and_styles(drawn: Sequence[Member]) -> list[tuple[Any, Member, str]]:
    """Colour, member and name of each colour, then of each style where there are several."""
    colours = {member.colour_label: member for member in drawn if member.colour_label}
    styles = {member.style_label: member for member in drawn if member.style_label}
    return [(member.colour, member, name) for name, member in colours.items()] + [
        (style.INK_COLOUR, member, name) for name, member in styles.items() if len(styles) > 1
    ]


def _select_variables(dataset: xr.Dataset, names: tuple[str, ...]) -> xr.Dataset:
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


def _colour_dimension(dataset: xr.Dataset, free: list[Hashable]) -> Hashable | None:
    if "temperature" in dataset.coords and dataset["temperature"].ndim == 1:
        return dataset["temperature"].dims[0]
    return free[0] if free else None


def _member_colours(dataset: xr.Dataset, dim: Hashable | None) -> list[Any]:
    if "temperature" in dataset.coords and dataset["temperature"].ndim <= 1:
        return list(style.temperature_colours(np.atleast_1d(dataset["temperature"].values)))
    count = dataset.sizes[dim] if dim is not None else 1
    wheel = list(style.OKABE_ITO_COLOURS.values())
    if count <= len(wheel):
        return wheel[:count]
    from matplotlib import colormaps

    return [colormaps["cividis"](x) for x in np.linspace(0.0, _MEMBER_COLOUR_MAP_END, count)]


def _coordinate_label(
    dataset: xr.Dataset, dim: Hashable | None, indices: Mapping[Hashable, int]
) -> str:
    """Say where along one dimension a member is, by every coordinate that has just it."""
    if dim is None:
        return ""
    coords = [array for array in dataset.coords.values() if array.dims == (dim,)]
    if not coords:
        return f"{dim} {indices[dim]}"
    return ", ".join(
        style.value_label(array, np.asarray(array.values[indices[dim]]).item()) for array in coords
    )


def _member_temperature(member: Member) -> float:
    coordinate = member.data.coords.get("temperature")
    return float(coordinate) if coordinate is not None and coordinate.ndim == 0 else 0.0
