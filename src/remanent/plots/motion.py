"""Motion: against time, in the phase plane, and once per drive period."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Final, TypeVar

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.collections import PathCollection
from matplotlib.lines import Line2D

from remanent.plots import ensemble, keys, missing, style
from remanent.plots.envelopes import (
    add_last_oscillations,
    draw_as_bands,
    extent_of,
    oscillation_count,
)
from remanent.plots.footer import add_legend_and_footer
from remanent.results.provenance import observable_name

__all__ = ["history", "phase", "section"]

#: Lines with more points than this are drawn as pixels: as vectors they only make files heavy.
_MAX_POINTS_OF_VECTOR_LINE: Final = 20_000
#: Clouds with more points than this are drawn as pixels.
_MAX_POINTS_OF_VECTOR_CLOUD: Final = 5_000
#: Squares of the diameters of all points of a cloud together, over the area of the axes: few
#: points are drawn large.
_CLOUD_AREA_SHARE: Final = 0.05
#: Square of the smallest diameter, in points, at which a point can still be seen.
_MIN_POINT_AREA: Final = 1.0
#: Square of the largest diameter, in points, that still shows structure.
_MAX_POINT_AREA: Final = 6.0
#: How much larger an open point is than a full one that may lie on it.
_OPEN_POINT_AREA_RATIO: Final = 4.0
#: Width of the line around an open point, in points.
_OPEN_POINT_LINE_WIDTH: Final = 0.6
#: Width of a line with few oscillations, of one with very many, in points, and its opacity there.
_USUAL_LINE_WIDTH: Final = 1.0
_MIN_LINE_WIDTH: Final = 0.3
_MIN_OPACITY: Final = 0.6
#: Oscillations of a history for each point of width, and of an orbit in a plane, from which lines
#: are drawn thinner.
_MANY_OSCILLATIONS_PER_POINT: Final = 0.25
_MANY_OSCILLATIONS_IN_PLANE: Final = 20.0
#: Dimensions along which a motion runs.
_TIME_DIMENSIONS: Final = ("time", "cycle")

_Artist = TypeVar("_Artist", Line2D, PathCollection)


def history(
    dataset: xr.Dataset,
    variable: str | None = None,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    envelope: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw a variable against time.

    Of a motion of some hundred oscillations none is seen for itself: the motion is drawn as the
    band between its extremes, and a new figure has the last ten beside it.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``simulate``: `variable` over ``time`` (or over ``cycle``, with
        ``time`` a two-dimensional coordinate) and at most two more dimensions.
        One line per member, coloured by temperature.
    variable : str, optional
        What to draw; by default the thickness stretch, or the observable of one's own system.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name the lines above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    envelope : bool
        Whether motions whose oscillations would run into a solid block are drawn as bands.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One per member, in order of temperature; of a band the outline.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    phase : The same motion in the phase plane.
    remanent.simulate : The result that is drawn.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> temperatures = {"temperature": [250.0, 400.0]}
    >>> ds = rm.simulate(rm.Actuator(), rm.Constant(0.16), duration=20, over=temperatures)
    >>> len(rm.plot.history(ds))
    2
    >>> plt.close()
    """
    variable = observable_name(dataset) if variable is None else variable
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax, width=style.DOUBLE_COLUMN_WIDTH_INCHES, height=2.2)
        members, artists = _draw_members(
            axes, dataset, "time", variable, _TIME_DIMENSIONS, _draw_line, line
        )
        before = draw_as_bands(axes, artists, line, _axes_width(axes)) if envelope else []
        if not before:
            _thin_crowded(artists, line, _MANY_OSCILLATIONS_PER_POINT * _axes_width(axes))
        axes.margins(x=0.0)
        if ax is None:
            add_last_oscillations(axes, before)
        ends = missing.mark_ends(axes, members, "time", variable)
        _add_keys(
            axes,
            ax,
            dataset,
            members,
            [*keys.line_legend_entries(members, variable), *ends],
            legend,
            footer,
        )
    return artists


def phase(
    dataset: xr.Dataset,
    x: str | None = None,
    y: str | None = None,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    start: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw orbits in the phase plane.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``simulate`` with `x` and `y` along ``time`` or ``cycle``.
    x, y : str, optional
        The variables of the plane; by default the thickness stretch and its rate, or the
        observable of one's own system and its rate.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name members above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    start : bool
        Whether to mark where each orbit starts.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One per member, in order of temperature.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    history : The same motion against time.
    section : Its points once per period.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> ds = rm.simulate(rm.Actuator(), rm.Constant(0.16), duration=20)
    >>> len(rm.plot.phase(ds))
    1
    >>> plt.close()
    """
    x, y = _plane(dataset, x, y)
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax, height=3.1)
        members, artists = _draw_members(axes, dataset, x, y, _TIME_DIMENSIONS, _draw_line, line)
        _thin_crowded(artists, line, _MANY_OSCILLATIONS_IN_PLANE)
        if start:
            # In the order of the members: that of a set of NaN would change from run to run.
            begun = [m for m in members if m.data[x].size]
            starts = dict.fromkeys((float(m.data[x][0]), float(m.data[y][0])) for m in begun)
            for point in starts:
                axes.plot(*point, "o", ms=3.2, mfc=axes.get_facecolor(), mec=style.ink_colour(),
                          mew=0.7, zorder=5)  # fmt: skip
        ends = missing.mark_ends(axes, members, x, y)
        _add_keys(
            axes,
            ax,
            dataset,
            members,
            [*keys.line_legend_entries(members, x, y), *ends],
            legend,
            footer,
        )
    return artists


def section(
    dataset: xr.Dataset,
    x: str | None = None,
    y: str | None = None,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    **points: Any,
) -> list[PathCollection]:
    """Draw a stroboscopic (Poincaré) section.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``poincare_section`` or ``bifurcation_diagram``: `y` along ``period``, or
        along ``crossing``.
    x, y : str, optional
        The variables of the plane, by default as of :func:`phase`; `x` may be the parameter
        of a ``bifurcation_diagram``.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name members above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    **points : Any
        Passed to matplotlib's ``scatter``.

    Returns
    -------
    list of matplotlib.collections.PathCollection
        One per member, in order of temperature.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    phase : The motion between the points.
    remanent.poincare_section : The result that is drawn.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> ds = rm.poincare_section(rm.Actuator(), rm.SineSquared(0.4, 1.25), periods=50)
    >>> len(rm.plot.section(ds)[0].get_offsets())  # the start and 50 points
    51
    >>> plt.close()
    """
    x, y = _plane(dataset, x, y)
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax, height=3.1)
        present = {"period", "crossing", x} & set(map(str, dataset.dims))
        along = present or ("period", "crossing")  # the message says that there is neither
        members, artists = _draw_members(axes, dataset, x, y, along, _draw_points, points)
        if x in along:
            lost = missing.mark_gaps(axes, members, x, y)
        else:
            lost = missing.cut_cloud_entries(members, x, y)
        entries = [*keys.point_legend_entries(members, x, y), *lost]
        _add_keys(axes, ax, dataset, members, entries, legend, footer)
    return artists


def _plane(dataset: xr.Dataset, x: str | None, y: str | None) -> tuple[str, str]:
    """The two variables of a plane: by default the observable and its rate."""
    name = observable_name(dataset)
    return name if x is None else x, f"{name}_rate" if y is None else y


def _add_keys(
    axes: Axes,
    given: Axes | None,
    dataset: xr.Dataset,
    members: list[ensemble.Member],
    entries: list[Line2D],
    legend: bool,
    footer: bool,
) -> None:
    """Add colour bar, legend and footer."""
    if legend:
        keys.add_colour_bar(axes, members)
    add_legend_and_footer(axes, given, dataset, entries, legend=legend, footer=footer)


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
    style.label_axes(axes, style.axis_label(dataset[x]), style.axis_label(dataset[y]))
    missing.write_in_empty_frame(axes, members, x, y)
    return members, artists


def _draw_line(axes: Axes, member: ensemble.Member, x: str, y: str, line: dict[str, Any]) -> Line2D:
    looks = {"color": member.colour, "linestyle": member.line_style, "label": member.label, **line}
    (artist,) = axes.plot(member.data[x].values, member.data[y].values, **looks)
    if member.data[y].size > _MAX_POINTS_OF_VECTOR_LINE:
        artist.set_rasterized(True)
    return artist


def _thin_crowded(artists: Sequence[Line2D], given: Mapping[str, Any], many: float) -> None:
    """Draw lines of many oscillations thin and light, and small motions over large ones.

    Parameters
    ----------
    artists : sequence of matplotlib.lines.Line2D
        What was drawn.
    given : mapping
        What the user says of lines, which stays.
    many : float
        Oscillations from which a line gets thinner.
    """
    crowding = max((oscillation_count(artist) for artist in artists), default=0) / many
    if crowding <= 1.0:
        return
    sizes = [float(np.prod(extent_of(artist))) for artist in artists]
    for rank, k in enumerate(np.argsort(sizes)[::-1]):
        if not {"zorder"} & set(given):
            artists[k].set_zorder(2.0 + 0.5 * rank / len(artists))
        if not {"lw", "linewidth", "alpha"} & set(given):
            width = max(_USUAL_LINE_WIDTH / crowding, _MIN_LINE_WIDTH)
            artists[k].set(linewidth=width, alpha=max(1.0 / crowding, _MIN_OPACITY))


def _draw_points(
    axes: Axes, member: ensemble.Member, x: str, y: str, points: dict[str, Any]
) -> PathCollection:
    across, up = xr.broadcast(member.data[x], member.data[y])
    room = _CLOUD_AREA_SHARE * _axes_area(axes) / max(up.size, 1)
    area = float(np.clip(room, _MIN_POINT_AREA, _MAX_POINT_AREA))
    # Of words, the first is drawn open and larger, so that it shows where others lie on it.
    is_open = member.word_number == 0 and bool(member.label)
    looks: dict[str, Any] = {
        "s": _OPEN_POINT_AREA_RATIO * area if is_open else area,
        "color": member.colour,
        "marker": member.marker,
        "linewidths": _OPEN_POINT_LINE_WIDTH if is_open else 0.0,
        "label": member.label,
        "rasterized": up.size > _MAX_POINTS_OF_VECTOR_CLOUD,
        **points,
    }
    if is_open and "color" not in points and "facecolors" not in points:
        looks |= {"facecolors": "none", "edgecolors": looks.pop("color")}
    return axes.scatter(across.values, up.values, **looks)


def _axes_width(axes: Axes) -> float:
    """Width of axes in points, before room for labels is made."""
    figure = axes.get_figure(root=True)
    assert figure is not None
    return float(72.0 * figure.get_figwidth() * axes.get_position().width)


def _axes_area(axes: Axes) -> float:
    """Area of axes in square points, before room for labels is made."""
    figure, place = axes.get_figure(root=True), axes.get_position()
    assert figure is not None
    return float(np.prod(72.0 * figure.get_size_inches()) * place.width * place.height)
