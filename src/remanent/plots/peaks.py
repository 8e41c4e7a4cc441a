"""Resonances by their order, over a response or alone."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent.plots import ensemble, keys, missing, style
from remanent.plots.footer import add_legend_and_footer

__all__ = ["resonances"]

#: Markers by the kind of a resonance.
_MARKERS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "primary": "o",
        "superharmonic": "^",
        "subharmonic": "s",
        "ultrasubharmonic": "D",
        "parametric": "P",
        "undecided": "X",
    }
)
#: Room above the highest peak for its order, over its height.
_ROOM_ABOVE: Final = 0.12
#: Room beside the peaks, over their distance.
_MARGIN: Final = 0.08


def resonances(
    dataset: xr.Dataset,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    **marks: Any,
) -> list[Line2D]:
    """Mark resonances with their order, such as 1:1 or 2:1.

    Meant to be drawn over :func:`response` or :func:`branch`, in the same axes.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``resonances``, with at most two dimensions of ``over``.  A marker for each
        kind, full where the orbit is stable and open where it is not; beside it the oscillations
        in so many drive periods, ``order_p``:``order_q``.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name marks above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    **marks : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One for each peak, in order of temperature and frequency.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    response : What the marks are drawn over.
    remanent.resonances : The result that is drawn.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> damped = rm.Actuator(dissipation=rm.Rayleigh(0.2))
    >>> ds = rm.resonances(damped, rm.SineSquared(0.3, 1.0), (0.9, 1.4))
    >>> (mark,) = rm.plot.resonances(ds)
    >>> plt.close()
    """
    names = ("amplitude", "omega", "resonance_kind", "order_p", "order_q", "stability")
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax)
        members = ensemble.split_by_colour(dataset, names, ("peak",))
        artists = [mark for member in members for mark in _mark_peaks(axes, member, marks)]
        style.label_axes(
            axes, style.axis_label(dataset["omega"]), style.axis_label(dataset["amplitude"])
        )
        missing.write_in_empty_frame(axes, members, "omega", "amplitude")
        if ax is None and artists:
            axes.margins(x=_MARGIN)
            axes.set_ylim(bottom=0.0)
        if legend:
            keys.add_colour_bar(axes, members)
        entries = [*keys.point_legend_entries(members, "amplitude"), *_kind_entries(dataset)]
        add_legend_and_footer(axes, ax, dataset, entries, legend=legend, footer=footer)
    return artists


def _mark_peaks(axes: Axes, member: ensemble.Member, given: Mapping[str, Any]) -> list[Line2D]:
    """A mark for each peak of a member, with its order."""
    artists = []
    for k in range(member.data.sizes["peak"]):
        peak = member.data.isel(peak=k)
        x, y = float(peak["omega"]), float(peak["amplitude"])
        if not np.isfinite([x, y]).all():  # padded, or without a value
            continue
        inside = member.colour if str(peak["stability"].values) == "stable" else "none"
        looks = {
            "color": member.colour,
            "mfc": inside,
            "ms": 5.0,
            "mew": 1.0,
            "linestyle": "",
            "marker": _MARKERS.get(str(peak["resonance_kind"].values), "X"),
            "zorder": 5.5,
        }
        artists += axes.plot(x, y, **{**looks, **given})  # fmt: skip
        order = (int(peak["order_p"]), int(peak["order_q"]))
        if all(order):
            axes.annotate(
                "{}:{}".format(*order), (x, y), xytext=(0.0, 4.0), textcoords="offset points",
                ha="center", va="bottom", color=style.ink_colour(), zorder=6,
            )  # fmt: skip
            axes.update_datalim([(x, (1.0 + _ROOM_ABOVE) * y)])
    axes.autoscale_view()
    return artists


def _kind_entries(dataset: xr.Dataset) -> list[Line2D]:
    """Legend entries of the kinds that occur, and of open marks where there are any."""
    known = np.isfinite(dataset["amplitude"].values)
    kinds, stabilities = (np.unique(dataset[name].values[known].astype(str)).tolist()
                          for name in ("resonance_kind", "stability"))  # fmt: skip
    looks: dict[str, Any] = {"color": style.ink_colour(), "linestyle": "", "ms": 4.5}
    entries = [
        Line2D([], [], marker=marker, label=kind, **looks)
        for kind, marker in _MARKERS.items() if kind in kinds
    ]  # fmt: skip
    if set(stabilities) - {"stable"}:
        entries.append(Line2D([], [], marker="o", mfc="none", label="open: not stable", **looks))
    return entries
