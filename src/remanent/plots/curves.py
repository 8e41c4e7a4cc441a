"""Any variable against any coordinate, with its band where it has one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from remanent.plots import colours, ensemble, keys, missing, style
from remanent.plots.equilibria import equilibria
from remanent.plots.footer import add_legend_and_footer

__all__ = ["curve"]

#: Opacity of the band between the outermost quantiles.
_BAND_OPACITY: Final = 0.22
#: The same on a dark ground, where a faint shade is not seen.
_BAND_OPACITY_ON_DARK: Final = 0.5
#: Dimensions whose entries are numbered anew at each value of anything else.
_NUMBERED_DIMENSIONS: Final = frozenset({"orbit", "attractor", "peak", "special", "fold", "snap"})
#: Diameter of a point.
_POINT_SIZE_POINTS: Final = 2.5


def curve(
    dataset: xr.Dataset,
    variable: str,
    x: str,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    log: bool = False,
    **line: Any,
) -> list[Line2D]:
    """Draw a variable against a coordinate.

    Parameters
    ----------
    dataset : xarray.Dataset
        With `variable` over the dimension of `x` and at most two more.  Along a dimension
        ``quantile`` the outermost values bound a band, and the middle one is the line.
        Equilibria are drawn as by :func:`remanent.plots.equilibria`.  Orbits, attractors,
        peaks and special points, which are numbered anew at each value of `x`, are points:
        a line through those of one number would join different solutions.
    variable, x : str
        What to draw, and against what.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name the lines above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    log : bool
        Whether the vertical axis is logarithmic.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One per member.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    equilibria : Equilibria against a parameter.
    response : A frequency response.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> ds = rm.shape_commands(rm.Actuator(), 1.5, over={"temperature": [250.0, 350.0]})
    >>> len(rm.plot.curve(ds, "switch_time", "temperature"))
    1
    >>> plt.close()
    """
    if variable in dataset and "equilibrium" in dataset[variable].dims and x != "equilibrium":
        lines = equilibria(dataset, variable, x, ax=ax, legend=legend, footer=footer, **line)
        if log and lines and lines[0].axes is not None:
            lines[0].axes.set_yscale("log")
        return lines
    along = str(dataset[x].dims[-1]) if x in dataset.variables and dataset[x].ndim else x
    numbered = sorted(_NUMBERED_DIMENSIONS - {along})
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax)
        members = ensemble.split_into_members(
            dataset, (variable, x), (along, "quantile", *numbered)
        )
        artists = [_draw_curve_and_band(axes, member, variable, x, line) for member in members]
        style.label_axes(axes, style.axis_label(dataset[x]), style.axis_label(dataset[variable]))
        if log:
            axes.set_yscale("log")
        axes.margins(x=0.0)
        gaps = missing.mark_gaps(axes, members, x, variable)
        missing.write_in_empty_frame(axes, members, x, variable)
        if legend:
            keys.add_colour_bar(axes, members)
        names = [
            *keys.line_legend_entries(members, variable),
            *_quantile_entries(members, variable),
        ]
        entries = [*names, *gaps]
        add_legend_and_footer(axes, ax, dataset, entries, legend=legend, footer=footer)
    return artists


def _quantile_entries(members: Sequence[ensemble.Member], variable: str) -> list[Artist]:
    """Legend entries of the line in the middle and of the band, where there are quantiles."""
    if "quantile" not in members[0].data[variable].dims:
        return []
    quantiles = np.sort(members[0].data[variable]["quantile"].values)
    percent = [f"{100.0 * q:.4g}" for q in (quantiles[quantiles.size // 2], *quantiles[[0, -1]])]
    middle = "median" if percent[0] == "50" else f"{percent[0]} %"
    tone = members[0].colour if len(members) == 1 else style.ink_colour()
    band = Patch(
        color=tone, alpha=_band_opacity(), linewidth=0.0, label=f"{percent[1]}–{percent[2]} %"
    )
    return [Line2D([], [], color=tone, label=middle), band]


def _band_opacity() -> float:
    return _BAND_OPACITY_ON_DARK if colours.is_ground_dark() else _BAND_OPACITY


def _draw_curve_and_band(
    axes: Axes, member: ensemble.Member, variable: str, x: str, line: dict[str, Any]
) -> Line2D:
    values, at = member.data[variable], member.data[x].values
    if "quantile" in values.dims:
        values = values.sortby("quantile")
        low, high = values.isel(quantile=0), values.isel(quantile=-1)
        axes.fill_between(at, low, high, color=member.colour, alpha=_band_opacity(), linewidth=0.0)
        values = values.isel(quantile=values.sizes["quantile"] // 2)
    looks = {"color": member.colour, "linestyle": member.line_style, "label": member.label}
    if _NUMBERED_DIMENSIONS & set(values.dims) - set(member.data[x].dims):
        across, up = xr.broadcast(member.data[x], values)
        looks |= {"linestyle": "", "marker": member.marker, "ms": _POINT_SIZE_POINTS}
        (artist,) = axes.plot(np.ravel(across), np.ravel(up), **(looks | line))
        return artist
    (artist,) = axes.plot(at, np.asarray(values), **(looks | line))
    return artist
