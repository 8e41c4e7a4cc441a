"""Any variable against any coordinate, with its band where it has one."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent.plots import ensemble, footer, style

__all__ = ["curve"]


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
    dataset
        With `variable` over the dimension of `x` and at most two more.  Along a dimension
        ``quantile`` the outermost values bound a band, and the middle one is the line.
    variable, x
        What to draw, and against what.
    ax
        Axes to draw in; a new figure, with its footer, if None.
    legend
        Whether to name the lines above the axes.
    log
        Whether the vertical axis is logarithmic.
    **line
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One per member.
    """
    along = str(dataset[x].dims[-1]) if x in dataset.variables else x
    with style.context():
        axes = style.owned_axes(ax)
        found = ensemble.members(dataset, (variable, x), (along, "quantile"))
        artists = [_curve(axes, one, variable, x, line) for one in found]
        axes.set(xlabel=style.label(dataset[x]), ylabel=style.label(dataset[variable]))
        if log:
            axes.set_yscale("log")
        axes.margins(x=0.0)
        if legend:
            style.legend_above(axes, ensemble.handles(found))
        if ax is None:
            footer.add(axes.get_figure(root=True), dataset)  # type: ignore[arg-type]
    return artists


def _curve(axes: Axes, one: ensemble.Member, variable: str, x: str, line: dict[str, Any]) -> Line2D:
    values, at = one.data[variable], one.data[x].values
    if "quantile" in values.dims:
        values = values.sortby("quantile")
        low, high = values.isel(quantile=0), values.isel(quantile=-1)
        axes.fill_between(at, low, high, color=one.colour, alpha=0.22, linewidth=0.0)
        values = values.isel(quantile=values.sizes["quantile"] // 2)
    looks = {"color": one.colour, "linestyle": one.dashes, "label": one.label, **line}
    (artist,) = axes.plot(at, np.asarray(values), **looks)
    return artist
