"""Motion: against time, in the phase plane, and once per drive period."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.lines import Line2D

from remanent.plots import ensemble, footer, style

__all__ = ["history", "phase", "section"]

#: Lines with more points than this are drawn as pixels: as vectors they only make files heavy.
_MANY = 20_000


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
    dataset
        A result of ``simulate``: `variable` over ``time`` (or over ``cycle``, with
        ``time`` a two-dimensional coordinate) and at most two more dimensions.
        One line per member, coloured by temperature.
    variable
        What to draw.
    ax
        Axes to draw in; a new figure, with its footer, if None.
    legend
        Whether to name the lines above the axes.
    **line
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One per member, in order of temperature.
    """
    with style.context():
        axes = style.owned_axes(ax, width=style.DOUBLE, height=2.2)
        found = ensemble.members(dataset, (variable, "time"), ("time", "cycle"))
        artists = [_line(axes, one, "time", variable, line) for one in found]
        axes.set(xlabel=style.label(dataset["time"]), ylabel=style.label(dataset[variable]))
        axes.margins(x=0.0)
        _finish(axes, ax, dataset, ensemble.handles(found) if legend else [])
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
    dataset
        A result of ``simulate`` with `x` and `y` along ``time`` or ``cycle``.
    x, y
        The variables of the plane.
    ax, legend
        As in :func:`history`.
    start
        Whether to mark where each orbit starts.
    **line
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One per member, in order of temperature.
    """
    with style.context():
        axes = style.owned_axes(ax, height=3.1)
        found = ensemble.members(dataset, (x, y), ("time", "cycle"))
        artists = [_line(axes, one, x, y, line) for one in found]
        if start:
            for place in {(float(o.data[x][0]), float(o.data[y][0])) for o in found}:
                axes.plot(*place, "o", ms=3.2, mfc="white", mec=style.INK, mew=0.7, zorder=5)
        axes.set(xlabel=style.label(dataset[x]), ylabel=style.label(dataset[y]))
        _finish(axes, ax, dataset, ensemble.handles(found) if legend else [])
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
    dataset
        A result of ``poincare_section`` or ``bifurcation_diagram``: `y` along ``period``.
    x, y
        The variables of the plane; `x` may be the parameter of a ``bifurcation_diagram``.
    ax, legend
        As in :func:`history`.
    **points
        Passed to matplotlib's ``scatter``.

    Returns
    -------
    list of matplotlib.collections.PathCollection
        One per member, in order of temperature.
    """
    with style.context():
        axes = style.owned_axes(ax, height=3.1)
        found = ensemble.members(dataset, (x, y), {"period", x} & set(dataset.dims))
        artists = [_cloud(axes, one, x, y, points) for one in found]
        axes.set(xlabel=style.label(dataset[x]), ylabel=style.label(dataset[y]))
        _finish(axes, ax, dataset, ensemble.point_handles(found) if legend else [])
    return artists


def _line(axes: Axes, one: ensemble.Member, x: str, y: str, line: dict[str, Any]) -> Line2D:
    looks = {"color": one.colour, "linestyle": one.dashes, "label": one.label, **line}
    (artist,) = axes.plot(one.data[x].values, one.data[y].values, **looks)
    if one.data[y].size > _MANY:
        artist.set_rasterized(True)
    return artist


def _cloud(
    axes: Axes, one: ensemble.Member, x: str, y: str, points: dict[str, Any]
) -> PathCollection:
    # Area of a point in square points: small enough to show structure, large enough to see few.
    across, up = xr.broadcast(one.data[x], one.data[y])
    area = float(np.clip(900.0 / max(up.size, 1), 0.6, 6.0))
    looks: dict[str, Any] = {
        "s": area,
        "color": one.colour,
        "marker": one.marker,
        "linewidths": 0.0,
        "label": one.label,
        "rasterized": True,
        **points,
    }
    return axes.scatter(across.values, up.values, **looks)


def _finish(axes: Axes, given: Axes | None, dataset: xr.Dataset, marks: list[Line2D]) -> None:
    """Add the legend and, to a figure of our own, the footer."""
    style.legend_above(axes, marks)
    if given is None:
        footer.add(axes.get_figure(root=True), dataset)  # type: ignore[arg-type]
