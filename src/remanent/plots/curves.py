"""Any variable against any coordinate, with its band where it has one."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent.plots import ensemble, footer, style

__all__ = ["curve"]

#: Opacity of the band between the outermost quantiles.
_BAND_OPACITY: Final = 0.22


def curve(
    dataset: xr.Dataset,
    variable: str,
    x: str,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    log: bool = False,
    **line: Any,
) -> list[Line2D]:
    """Draw a variable against a coordinate.

    Parameters
    ----------
    dataset : xarray.Dataset
        With `variable` over the dimension of `x` and at most two more.  Along a dimension
        ``quantile`` the outermost values bound a band, and the middle one is the line.
    variable, x : str
        What to draw, and against what.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure, with its footer, if None.
    legend : bool
        Whether to name the lines above the axes.
    log : bool
        Whether the vertical axis is logarithmic.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One per member.
    """
    along = str(dataset[x].dims[-1]) if x in dataset.variables else x
    with style.context():
        axes = style.given_or_new_axes(ax)
        members = ensemble.split_into_members(dataset, (variable, x), (along, "quantile"))
        artists = [_draw_curve_and_band(axes, member, variable, x, line) for member in members]
        axes.set(xlabel=style.axis_label(dataset[x]), ylabel=style.axis_label(dataset[variable]))
        if log:
            axes.set_yscale("log")
        axes.margins(x=0.0)
        footer.add_legend_and_footer(
            axes, ax, dataset, ensemble.line_legend_entries(members) if legend else []
        )
    return artists


def _draw_curve_and_band(
    axes: Axes, member: ensemble.Member, variable: str, x: str, line: dict[str, Any]
) -> Line2D:
    values, at = member.data[variable], member.data[x].values
    if "quantile" in values.dims:
        values = values.sortby("quantile")
        low, high = values.isel(quantile=0), values.isel(quantile=-1)
        axes.fill_between(at, low, high, color=member.colour, alpha=_BAND_OPACITY, linewidth=0.0)
        values = values.isel(quantile=values.sizes["quantile"] // 2)
    looks = {"color": member.colour, "linestyle": member.line_style, "label": member.label, **line}
    (artist,) = axes.plot(at, np.asarray(values), **looks)
    return artist
