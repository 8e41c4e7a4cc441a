"""Forced response: amplitude against frequency."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent._typing import FloatArray
from remanent.plots import ensemble, keys, missing, style
from remanent.plots.backbones import draw_backbone
from remanent.plots.footer import add_legend_and_footer

__all__ = ["resonance_legend_entries", "response"]

#: Variables that are drawn beside the amplitude, where a result has them.
_RESONANCE_VARIABLES: Final = ("resonance", "resonance_error", "resonance_amplitude", "published")
#: Room beside a resonance, as a share of the range, below which it lies at an end.
_MIN_ROOM_BESIDE_RESONANCE: Final = 1e-6


def response(
    dataset: xr.Dataset,
    variable: str = "amplitude",
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    resonances: bool = True,
    backbone: xr.Dataset | None = None,
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
        point.  Where the amplitude is largest at an end of the range, an arrow says so: there
        may be a resonance beyond.  ``published``, where present, is marked on the upper edge.
    variable : str
        What to draw: ``amplitude``, ``maximum`` or ``minimum``.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name the lines above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    resonances : bool
        Whether to mark resonances.
    backbone : xarray.Dataset, optional
        A result of ``backbone``, drawn where the load has the frequency of its oscillations.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        The curves, one per member, in order of temperature.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    remanent.frequency_response : The result that is drawn.
    branch : The orbits behind it.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import numpy as np, remanent as rm
    >>> drive = rm.SineSquared(0.4, 1.0)
    >>> ds = rm.frequency_response(rm.Actuator(), drive, np.linspace(1.0, 1.5, 26))
    >>> len(rm.plot.response(ds))
    1
    >>> plt.close()
    """
    marked = resonances and variable == "amplitude"
    extra = [name for name in _RESONANCE_VARIABLES if marked and name in dataset]
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax)
        members = ensemble.split_into_members(dataset, (variable, "omega", *extra), ("omega",))
        artists = [_draw_response(axes, member, variable, line) for member in members]
        for member in members:
            _mark_published(axes, member)
            _mark_resonance(axes, member, variable)
        style.label_axes(
            axes, style.axis_label(dataset["omega"]), style.axis_label(dataset[variable])
        )
        axes.margins(x=0.0)
        if variable == "amplitude":
            _start_axis_at_zero(axes, artists)
        gaps = missing.mark_gaps(axes, members, "omega", variable)
        missing.write_in_empty_frame(axes, members, "omega", variable)
        if legend:
            keys.add_colour_bar(axes, members)
        free = draw_backbone(axes, backbone, dataset, variable)
        marks = resonance_legend_entries(dataset[extra], members, variable) if marked else []
        entries = [*keys.line_legend_entries(members, variable), *free, *marks, *gaps]
        add_legend_and_footer(axes, ax, dataset, entries, legend=legend, footer=footer)
    return artists


def resonance_legend_entries(
    dataset: xr.Dataset,
    members: Sequence[ensemble.Member] | None = None,
    variable: str = "amplitude",
) -> list[Line2D]:
    """Legend entries of the marks that :func:`response` draws.

    Parameters
    ----------
    dataset : xarray.Dataset
        With ``resonance`` and ``published`` where they are drawn.
    members : sequence of Member, optional
        Those that were drawn, with `variable`; by default every mark is said to occur.
    variable : str
        What was drawn.

    Returns
    -------
    list of matplotlib.lines.Line2D
    """
    looks: dict[str, Any] = {"color": style.ink_colour(), "mfc": "none", "linestyle": "", "ms": 4}
    inside = members is None or any(_has_resonance_inside(m.data, variable) for m in members)
    found = (_end_of_largest(m.data, variable) for m in members or ())
    ends = {end for end in found if end is not None}
    marker = {frozenset({"first"}): "<", frozenset({"last"}): ">"}.get(frozenset(ends), "D")
    named = (
        ("resonance", "o", "resonance" in dataset and inside),
        ("largest in range", marker, bool(ends)),
        ("published", "v", "published" in dataset),
    )
    return [Line2D([], [], marker=mark, label=name, **looks) for name, mark, is_there in named
            if is_there]  # fmt: skip


def _draw_response(
    axes: Axes, member: ensemble.Member, variable: str, line: dict[str, Any]
) -> Line2D:
    looks = {"color": member.colour, "linestyle": member.line_style, "label": member.label, **line}
    (artist,) = axes.plot(*_curve_through_resonance(member.data, variable), **looks)
    return artist


def _curve_through_resonance(data: xr.Dataset, variable: str) -> tuple[FloatArray, FloatArray]:
    """The curve, led through its largest value where that was found between grid points."""
    x, y = data["omega"].values, data[variable].values
    if "resonance_amplitude" not in data or not _has_resonance_inside(data, variable):
        return x, y
    resonance, height = float(data["resonance"]), float(data["resonance_amplitude"])
    index = np.searchsorted(x, resonance)
    return np.insert(x, index, resonance), np.insert(y, index, height)


def _drawn_range(data: xr.Dataset, variable: str) -> tuple[float, float]:
    """The first and the last frequency with a value; NaN where there is none."""
    at = data["omega"].values[np.isfinite(data[variable].values)]
    return (float(at.min()), float(at.max())) if at.size else (np.nan, np.nan)


def _has_resonance_inside(data: xr.Dataset, variable: str) -> bool:
    """Whether there is a resonance that lies inside the range by more than its bracket.

    A largest value at an end of what was computed is no maximum: the amplitude may go on
    rising beyond.
    """
    if "resonance" not in data or not np.isfinite(float(data["resonance"])):
        return False
    first, last = _drawn_range(data, variable)
    bracket = float(data["resonance_error"]) if "resonance_error" in data else 0.0
    room = max(bracket, _MIN_ROOM_BESIDE_RESONANCE * (last - first))
    return bool(first + room < float(data["resonance"]) < last - room)


def _end_of_largest(data: xr.Dataset, variable: str) -> str | None:
    """At which end of the range the amplitude is largest; None where a resonance is inside."""
    values = data[variable].values
    if "resonance" not in data or not np.isfinite(values).any():
        return None
    if _has_resonance_inside(data, variable):
        return None
    first, last = _drawn_range(data, variable)
    largest = float(data["omega"].values[np.nanargmax(values)])
    return {first: "first", last: "last"}.get(largest)


def _start_axis_at_zero(axes: Axes, curves: list[Line2D]) -> None:
    """Start the vertical axis at zero and leave its top free, also where panels share it."""
    for curve in curves:
        curve.sticky_edges.y.append(0.0)
        axes.update_datalim([(float(np.asarray(curve.get_xdata())[0]), 0.0)])
    axes.autoscale_view()


def _mark_published(axes: Axes, member: ensemble.Member) -> None:
    """Mark the published resonance on the upper edge."""
    if "published" in member.data:
        axes.plot(
            float(member.data["published"]), 1.0, marker="v", ms=5, mfc=axes.get_facecolor(),
            mec=member.colour, mew=0.9, transform=axes.get_xaxis_transform(), clip_on=False,
            zorder=6, linestyle="",
        )  # fmt: skip


def _mark_resonance(axes: Axes, member: ensemble.Member, variable: str) -> None:
    """Mark the resonance with its bracket, or the end beyond which the amplitude may rise."""
    data, ground = member.data, axes.get_facecolor()
    end = _end_of_largest(data, variable)
    if end is not None:
        at = _drawn_range(data, variable)[end == "last"]
        axes.plot(
            at, float(data[variable].max()), "<" if end == "first" else ">", ms=4.5, mfc=ground,
            mec=member.colour, mew=1.0, clip_on=False, zorder=6, linestyle="",
        )  # fmt: skip
    if not _has_resonance_inside(data, variable):
        return
    top = data["resonance_amplitude"] if "resonance_amplitude" in data else data[variable].max()
    bracket = float(data["resonance_error"]) if "resonance_error" in data else 0.0
    axes.errorbar(
        float(data["resonance"]), float(top), xerr=bracket or None, fmt="o", ms=3.6,
        color=member.colour, mfc=ground, mew=1.0, elinewidth=0.8, capsize=1.5, zorder=5,
    )  # fmt: skip
