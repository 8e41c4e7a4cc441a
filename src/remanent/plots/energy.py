"""The potential that the thickness stretch moves in."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent.plots import ensemble, footer, style

__all__ = ["landscape", "mark_handles"]

_EXTRA = (
    "equilibrium_stretch",
    "equilibrium_potential",
    "stability",
    "level",
    "turning_lower",
    "turning_upper",
)


def landscape(
    dataset: xr.Dataset, *, ax: Axes | None = None, legend: bool = True, **line: Any
) -> list[Line2D]:
    """Draw the potential energy with its equilibria and the energy of a motion.

    A motion at energy ``level`` runs where the potential lies below it, between its
    turning points: the amplitude can be read off the picture.

    Parameters
    ----------
    dataset
        ``potential`` over the coordinate ``thickness_stretch``, and at most two more
        dimensions.  Drawn where present, with the same more dimensions:
        ``equilibrium_stretch``, ``equilibrium_potential`` and ``stability`` (the words
        ``stable`` or ``unstable``) over ``equilibrium``, NaN where there are fewer;
        ``level``, the energy of a motion, between ``turning_lower`` and
        ``turning_upper``.
    ax
        Axes to draw in; a new figure, with its footer, if None.
    legend
        Whether to name the lines above the axes.
    **line
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        The potentials, one per member, in order of temperature.
    """
    extra = [name for name in _EXTRA if name in dataset]
    along = ("thickness_stretch", "equilibrium")
    with style.context():
        axes = style.owned_axes(ax, height=2.9)
        found = ensemble.members(dataset, ("potential", "thickness_stretch", *extra), along)
        artists = [_curve(axes, one, line) for one in found]
        for one in sorted(found, key=_reach, reverse=True):  # the shorter on the longer
            _level(axes, one)
            _equilibria(axes, one)
        _name_level(axes, found)
        axes.set(
            xlabel=style.label(dataset["thickness_stretch"]),
            ylabel=style.label(dataset["potential"]),
        )
        _limits(axes, found)
        if legend:
            style.legend_above(axes, [*ensemble.handles(found), *mark_handles(dataset)])
        if ax is None:
            footer.add(axes.get_figure(root=True), dataset)  # type: ignore[arg-type]
    return artists


def _curve(axes: Axes, one: ensemble.Member, line: dict[str, Any]) -> Line2D:
    looks = {"color": one.colour, "linestyle": one.dashes, "label": one.label, **line}
    x, y = one.data["thickness_stretch"].values, one.data["potential"].values
    (artist,) = axes.plot(x, y, **looks)
    return artist


def mark_handles(dataset: xr.Dataset) -> list[Line2D]:
    """Legend entries of the kinds of equilibria that :func:`landscape` draws."""
    words = set(np.ravel(dataset["stability"].values)) if "stability" in dataset else set()
    looks: dict[str, Any] = {"color": style.INK, "linestyle": "", "marker": "o", "ms": 4.2}
    inside = {"stable": style.INK, "unstable": "white"}
    return [
        Line2D([], [], mfc=colour, label=f"{word} equilibrium", **looks)
        for word, colour in inside.items()
        if word in words
    ]


def _reach(one: ensemble.Member) -> float:
    """How far apart the turning points are."""
    if not _has_level(one):
        return 0.0
    return float(one.data["turning_upper"]) - float(one.data["turning_lower"])


def _has_level(one: ensemble.Member) -> bool:
    return {"level", "turning_lower", "turning_upper"} <= set(one.data)


def _level(axes: Axes, one: ensemble.Member) -> None:
    """Draw the energy of the motion and its turning points."""
    if not _has_level(one):
        return
    ends = [float(one.data["turning_lower"]), float(one.data["turning_upper"])]
    height = float(one.data["level"])
    axes.plot(ends, [height, height], color=one.colour, lw=1.6, zorder=1.6, solid_capstyle="butt")
    axes.plot(ends, [height, height], "|", color=one.colour, ms=7, mew=1.2, zorder=4)


def _name_level(axes: Axes, found: list[ensemble.Member]) -> None:
    """Write the symbol of the energy outside the widest well."""
    widest = max(found, key=_reach)
    if _has_level(widest):
        axes.annotate(
            f"${widest.data['level'].attrs['symbol']}$",
            (float(widest.data["turning_upper"]), float(widest.data["level"])),
            xytext=(5, -1), textcoords="offset points", va="top",
        )  # fmt: skip


def _equilibria(axes: Axes, one: ensemble.Member) -> None:
    """Mark equilibria: a full circle where stable, an empty one where not."""
    if "equilibrium_stretch" not in one.data:
        return
    x = np.atleast_1d(one.data["equilibrium_stretch"].values)
    y = np.atleast_1d(one.data["equilibrium_potential"].values)
    words = np.atleast_1d(one.data["stability"].values)
    for px, py, word in zip(x, y, words, strict=True):
        inside = one.colour if word == "stable" else "white"
        axes.plot(px, py, "o", ms=4.2, mfc=inside, mec=one.colour, mew=0.9, zorder=5)


def _limits(axes: Axes, found: list[ensemble.Member]) -> None:
    """Show the wells: up to somewhat above the energy levels, not up the walls."""
    if not all("level" in one.data for one in found):
        return
    bottom = min(float(one.data["potential"].min()) for one in found)
    top = max(float(one.data["level"]) for one in found)
    room = 0.9 * max(top - bottom, 1e-12)
    axes.set_ylim(bottom - 0.12 * (top - bottom + room), top + room)
    ends = [float(one.data[n]) for one in found for n in ("turning_lower", "turning_upper")
            if n in one.data]  # fmt: skip
    if ends:
        wide = 0.3 * (max(ends) - min(ends))
        axes.set_xlim(min(ends) - wide, max(ends) + wide)
    axes.locator_params(axis="x", nbins=7)
