"""Motion: against time, in the phase plane, and once per drive period."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, Final, TypeVar

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.lines import Line2D

from remanent.plots import ensemble, footer, style

__all__ = ["history", "phase", "section"]

#: Lines with more points than this are drawn as pixels: as vectors they only make files heavy.
_MAX_POINTS_OF_VECTOR_LINE: Final = 20_000
#: Area of all points of a cloud together, in square points: few points are drawn large.
_TOTAL_POINT_AREA: Final = 900.0
#: Smallest area of a point, in square points, at which it can still be seen.
_MIN_POINT_AREA: Final = 0.6
#: Largest area of a point, in square points, that still shows structure.
_MAX_POINT_AREA: Final = 6.0
#: Dimensions along which a motion runs.
_TIME_DIMENSIONS: Final = ("time", "cycle")

_Artist = TypeVar("_Artist", Line2D, PathCollection)


def history(
    dataset: xr.Dataset,
    variable: str = "thickness_stretch",
    *,
    ax: Axes | None = None,
    legend: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw a variable against time.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``simulate``: `variable` over ``time`` (or over ``cycle``, with
        ``time`` a two-dimensional coordinate) and at most two more dimensions.
        One line per member, coloured by temperature.
    variable : str
        What to draw.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure, with its footer, if None.
    legend : bool
        Whether to name the lines above the axes.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One per member, in order of temperature.
    """
    with style.context():
        axes = style.given_or_new_axes(ax, width=style.DOUBLE_COLUMN_WIDTH_INCHES, height=2.2)
        members, artists = _draw_members(
            axes, dataset, "time", variable, _TIME_DIMENSIONS, _draw_line, line
        )
        axes.margins(x=0.0)
        footer.add_legend_and_footer(
            axes, ax, dataset, ensemble.line_legend_entries(members) if legend else []
        )
    return artists


def phase(
    dataset: xr.Dataset,
    x: str = "thickness_stretch",
    y: str = "thickness_stretch_rate",
    *,
    ax: Axes | None = None,
    legend: bool = True,
    start: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw orbits in the phase plane.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``simulate`` with `x` and `y` along ``time`` or ``cycle``.
    x, y : str
        The variables of the plane.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure, with its footer, if None.
    legend : bool
        Whether to name members above the axes.
    start : bool
        Whether to mark where each orbit starts.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One per member, in order of temperature.
    """
    with style.context():
        axes = style.given_or_new_axes(ax, height=3.1)
        members, artists = _draw_members(axes, dataset, x, y, _TIME_DIMENSIONS, _draw_line, line)
        if start:
            # In the order of the members: that of a set of NaN would change from run to run.
            starts = dict.fromkeys((float(m.data[x][0]), float(m.data[y][0])) for m in members)
            for point in starts:
                axes.plot(*point, "o", ms=3.2, mfc="white", mec=style.INK_COLOUR, mew=0.7, zorder=5)
        footer.add_legend_and_footer(
            axes, ax, dataset, ensemble.line_legend_entries(members) if legend else []
        )
    return artists


def section(
    dataset: xr.Dataset,
    x: str = "thickness_stretch",
    y: str = "thickness_stretch_rate",
    *,
    ax: Axes | None = None,
    legend: bool = True,
    **points: Any,
) -> list[PathCollection]:
    """Draw a stroboscopic (Poincaré) section, its clouds of points as pixels.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``poincare_section`` or ``bifurcation_diagram``: `y` along ``period``.
    x, y : str
        The variables of the plane; `x` may be the parameter of a ``bifurcation_diagram``.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure, with its footer, if None.
    legend : bool
        Whether to name members above the axes.
    **points : Any
        Passed to matplotlib's ``scatter``.

    Returns
    -------
    list of matplotlib.collections.PathCollection
        One per member, in order of temperature.
    """
    with style.context():
        axes = style.given_or_new_axes(ax, height=3.1)
        along = {"period", x} & set(map(str, dataset.dims))
        members, artists = _draw_members(axes, dataset, x, y, along, _draw_points, points)
        footer.add_legend_and_footer(
            axes, ax, dataset, ensemble.point_legend_entries(members) if legend else []
        )
    return artists


def _draw_members(
    axes: Axes,
    dataset: xr.Dataset,
    x: str,
    y: str,
    along: Iterable[str],
    draw: Callable[[Axes, ensemble.Member, str, str, dict[str, Any]], _Artist],
    looks: dict[str, Any],
) -> tuple[list[ensemble.Member], list[_Artist]]:
    """Draw `y` against `x` for every member, and label the axes: what all three plots share."""
    members = ensemble.split_into_members(dataset, (y, x), along)
    artists = [draw(axes, member, x, y, looks) for member in members]
    axes.set(xlabel=style.axis_label(dataset[x]), ylabel=style.axis_label(dataset[y]))
    return members, artists


def _draw_line(axes: Axes, member: ensemble.Member, x: str, y: str, line: dict[str, Any]) -> Line2D:
    looks = {"color": member.colour, "linestyle": member.line_style, "label": member.label, **line}
    (artist,) = axes.plot(member.data[x].values, member.data[y].values, **looks)
    if member.data[y].size > _MAX_POINTS_OF_VECTOR_LINE:
        artist.set_rasterized(True)
    return artist


def _draw_points(
    axes: Axes, member: ensemble.Member, x: str, y: str, points: dict[str, Any]
) -> PathCollection:
    across, up = xr.broadcast(member.data[x], member.data[y])
    area = float(np.clip(_TOTAL_POINT_AREA / max(up.size, 1), _MIN_POINT_AREA, _MAX_POINT_AREA))
    looks: dict[str, Any] = {
        "s": area,
        "color": member.colour,
        "marker": member.marker,
        "linewidths": 0.0,
        "label": member.label,
        "rasterized": True,
        **points,
    }
    return axes.scatter(across.values, up.values, **looks)
