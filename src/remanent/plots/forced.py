"""Forced response: amplitude against frequency."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent._typing import FloatArray
from remanent.plots import ensemble, footer, style

__all__ = ["resonance_legend_entries", "response"]

#: Variables that are drawn beside the amplitude, where a result has them.
_RESONANCE_VARIABLES: Final = ("resonance", "resonance_error", "resonance_amplitude", "published")


def response(
    dataset: xr.Dataset,
    variable: str = "amplitude",
    *,
    ax: Axes | None = None,
    legend: bool = True,
    resonances: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw a frequency response, with its resonances and their brackets.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``frequency_response``: `variable` over ``omega`` and at most two
        more dimensions.  With the amplitude, ``resonance``, where present, is marked
        at ``resonance_amplitude`` (at the largest drawn value without it), with
        ``resonance_error`` as a horizontal bar, and the curve is led through that
        point; ``published``, where present, is marked on the upper edge.
    variable : str
        What to draw: ``amplitude``, ``maximum`` or ``minimum``.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure, with its footer, if None.
    legend : bool
        Whether to name the lines above the axes.
    resonances : bool
        Whether to mark resonances.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        The curves, one per member, in order of temperature.
    """
    marked = resonances and variable == "amplitude"
    extra = [name for name in _RESONANCE_VARIABLES if marked and name in dataset]
    with style.context():
        axes = style.given_or_new_axes(ax)
        members = ensemble.split_into_members(dataset, (variable, "omega", *extra), ("omega",))
        artists = [_draw_response(axes, member, variable, line) for member in members]
        for member in members:
            _mark_resonance(axes, member, variable)
        axes.set(
            xlabel=style.axis_label(dataset["omega"]), ylabel=style.axis_label(dataset[variable])
        )
        axes.margins(x=0.0)
        if variable == "amplitude":
            _start_axis_at_zero(axes, artists)
        entries = [
            *ensemble.line_legend_entries(members),
            *resonance_legend_entries(dataset[extra]),
        ]
        footer.add_legend_and_footer(axes, ax, dataset, entries if legend else [])
    return artists


def resonance_legend_entries(dataset: xr.Dataset) -> list[Line2D]:
    """Legend entries of the marks that :func:`response` draws."""
    looks: dict[str, Any] = {"color": style.INK_COLOUR, "mfc": "white", "linestyle": "", "ms": 4}
    named = (("resonance", "o"), ("published", "v"))
    return [
        Line2D([], [], marker=marker, label=name, **looks)
        for name, marker in named
        if name in dataset
    ]


def _draw_response(
    axes: Axes, member: ensemble.Member, variable: str, line: dict[str, Any]
) -> Line2D:
    looks = {"color": member.colour, "linestyle": member.line_style, "label": member.label, **line}
    (artist,) = axes.plot(*_curve_through_resonance(member.data, variable), **looks)
    return artist


def _curve_through_resonance(data: xr.Dataset, variable: str) -> tuple[FloatArray, FloatArray]:
    """The curve, led through its largest value where that was found between grid points."""
    x, y = data["omega"].values, data[variable].values
    if not {"resonance", "resonance_amplitude"} <= set(data):
        return x, y
    resonance, height = float(data["resonance"]), float(data["resonance_amplitude"])
    if not np.isfinite(resonance):
        return x, y
    index = np.searchsorted(x, resonance)
    return np.insert(x, index, resonance), np.insert(y, index, height)


def _start_axis_at_zero(axes: Axes, curves: list[Line2D]) -> None:
    """Start the vertical axis at zero and leave its top free, also where panels share it."""
    for curve in curves:
        curve.sticky_edges.y.append(0.0)
        axes.update_datalim([(float(np.asarray(curve.get_xdata())[0]), 0.0)])
    axes.autoscale_view()


def _mark_resonance(axes: Axes, member: ensemble.Member, variable: str) -> None:
    """Mark the resonance with its bracket, and the published one on the upper edge."""
    data = member.data
    if "published" in data:
        axes.plot(
            float(data["published"]), 1.0, marker="v", ms=5, mfc="white", mec=member.colour,
            mew=0.9, transform=axes.get_xaxis_transform(), clip_on=False, zorder=6, linestyle="",
        )  # fmt: skip
    if "resonance" not in data or not np.isfinite(data["resonance"]):
        return
    top = data["resonance_amplitude"] if "resonance_amplitude" in data else data[variable].max()
    resonance, height = float(data["resonance"]), float(top)
    bracket = float(data["resonance_error"]) if "resonance_error" in data else 0.0
    axes.errorbar(
        resonance, height, xerr=bracket or None, fmt="o", ms=3.6, color=member.colour,
        mfc="white", mew=1.0, elinewidth=0.8, capsize=1.5, zorder=5,
    )  # fmt: skip
