"""The potential that the thickness stretch moves in."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent._typing import FloatArray
from remanent.plots import ensemble, keys, missing, style
from remanent.plots.footer import add_legend_and_footer

__all__ = ["equilibrium_legend_entries", "landscape", "level_legend_entries"]

#: Variables that are drawn beside the potential, where a result has them.
_VARIABLES_DRAWN_IF_PRESENT: Final = (
    "equilibrium_stretch",
    "equilibrium_potential",
    "stability",
    "level",
    "turning_lower",
    "turning_upper",
)

#: Width of the thinnest and of the thickest level, in points.
_LEVEL_WIDTHS_POINTS: Final = (1.2, 3.6)
#: Room above the highest level, in depths of the well.
_MARGIN_ABOVE_LEVEL: Final = 0.9
#: Room below the well, over the height of what is shown.
_MARGIN_BELOW_WELL: Final = 0.12
#: Room beside the turning points, over their distance.
_MARGIN_BESIDE_TURNING_POINTS: Final = 0.3
#: Depth that a well has at least, so that the axis has a height.
_MIN_WELL_DEPTH: Final = 1e-12


def landscape(
    dataset: xr.Dataset,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw the potential energy with its equilibria and the energy of a motion.

    A motion at energy ``level`` runs where the potential lies below it, between its
    turning points: the amplitude can be read off the picture.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``potential`` over the coordinate ``thickness_stretch``, and at most two more
        dimensions.  Drawn where present, with the same more dimensions:
        ``equilibrium_stretch``, ``equilibrium_potential`` and ``stability`` (the words
        ``stable`` or ``unstable``) over ``equilibrium``, NaN where there are fewer;
        ``level``, the energy of a motion, between ``turning_lower`` and
        ``turning_upper``.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name the lines above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        The potentials, one per member, in order of temperature.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    remanent.equilibria : The result that is drawn.
    equilibria : Equilibria against a parameter.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> ds = rm.equilibria(rm.Actuator(), 0.16, over={"temperature": [250.0, 400.0]})
    >>> len(rm.plot.landscape(ds))
    2
    >>> plt.close()
    """
    extra = [name for name in _VARIABLES_DRAWN_IF_PRESENT if name in dataset]
    along = ("thickness_stretch", "equilibrium")
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax, height=2.9)
        members = ensemble.split_into_members(
            dataset, ("potential", "thickness_stretch", *extra), along
        )
        artists = [_draw_potential(axes, member, line) for member in members]
        # Shorter levels lie on longer ones and are thinner, so that all are seen.
        by_length = sorted(members, key=_distance_between_turning_points, reverse=True)
        widths = np.linspace(*_LEVEL_WIDTHS_POINTS, len(members))[::-1] if len(members) > 1 else [
            _LEVEL_WIDTHS_POINTS[0]]  # fmt: skip
        for member, width in zip(by_length, widths, strict=True):
            _draw_level(axes, member, float(width))
            _draw_equilibria(axes, member)
        style.label_axes(
            axes,
            style.axis_label(dataset["thickness_stretch"]),
            style.axis_label(dataset["potential"]),
        )
        missing.write_in_empty_frame(axes, members, "thickness_stretch", "potential")
        _limit_axes(axes, members)
        if legend:
            keys.add_colour_bar(axes, members)
        names = keys.line_legend_entries(members, "potential")
        entries = [*names, *equilibrium_legend_entries(dataset), *level_legend_entries(members)]
        add_legend_and_footer(axes, ax, dataset, entries, legend=legend, footer=footer)
    return artists


def _draw_potential(axes: Axes, member: ensemble.Member, line: dict[str, Any]) -> Line2D:
    looks = {"color": member.colour, "linestyle": member.line_style, "label": member.label, **line}
    x, y = member.data["thickness_stretch"].values, member.data["potential"].values
    (artist,) = axes.plot(x, y, **looks)
    return artist


def equilibrium_legend_entries(dataset: xr.Dataset) -> list[Line2D]:
    """Legend entries of the kinds of equilibria that :func:`landscape` draws."""
    words = set(np.ravel(dataset["stability"].values)) if "stability" in dataset else set()
    looks: dict[str, Any] = {"color": style.ink_colour(), "linestyle": "", "marker": "o", "ms": 4.2}
    inside = {"stable": style.ink_colour(), "unstable": "none"}
    return [
        Line2D([], [], mfc=colour, label=f"{word} equilibrium", **looks)
        for word, colour in inside.items()
        if word in words
    ]


def _distance_between_turning_points(member: ensemble.Member) -> float:
    """How far apart the turning points are."""
    if not _has_level(member):
        return 0.0
    return float(np.nan_to_num(member.data["turning_upper"] - member.data["turning_lower"]))


def _has_level(member: ensemble.Member) -> bool:
    return {"level", "turning_lower", "turning_upper"} <= set(member.data)


def _draw_level(axes: Axes, member: ensemble.Member, width: float) -> None:
    """Draw the energy of the motion and its turning points."""
    if not _has_level(member):
        return
    ends = [float(member.data["turning_lower"]), float(member.data["turning_upper"])]
    levels = 2 * [float(member.data["level"])]
    axes.plot(ends, levels, color=member.colour, lw=width, zorder=1.6, solid_capstyle="butt")
    axes.plot(ends, levels, "|", color=member.colour, ms=7, mew=1.2, zorder=4)


def level_legend_entries(members: list[ensemble.Member]) -> list[Line2D]:
    """Legend entry of the energies of motions, where there are any."""
    known = [m for m in members if _has_level(m) and np.isfinite(m.data["turning_upper"])]
    if not known:
        return []
    text = style.axis_label(known[0].data["level"])
    return [
        Line2D([], [], color=style.ink_colour(), lw=_LEVEL_WIDTHS_POINTS[0], marker="|", ms=6,
               label=text)
    ]  # fmt: skip


def _draw_equilibria(axes: Axes, member: ensemble.Member) -> None:
    """Mark equilibria: a full circle where stable, an empty one where not."""
    if "equilibrium_stretch" not in member.data:
        return
    x = np.atleast_1d(member.data["equilibrium_stretch"].values)
    y = np.atleast_1d(member.data["equilibrium_potential"].values)
    stabilities = np.atleast_1d(member.data["stability"].values)
    for stretch, potential, stability in zip(x, y, stabilities, strict=True):
        inside = member.colour if stability == "stable" else axes.get_facecolor()
        axes.plot(stretch, potential, "o", ms=4.2, mfc=inside, mec=member.colour, mew=0.9, zorder=5)


def _limit_axes(axes: Axes, members: list[ensemble.Member]) -> None:
    """Show the wells and every equilibrium: up to somewhat above the levels, not up the walls."""
    axes.locator_params(axis="x", nbins=7)
    depths = _finite_values(members, ("potential", "equilibrium_potential"))
    levels = _finite_values(members, ("level", "equilibrium_potential"))
    ends = _finite_values(members, ("turning_lower", "turning_upper", "equilibrium_stretch"))
    has_level = any("level" in member.data for member in members)
    if not (has_level and levels.size and depths.size):
        return
    # The smallest room keeps the axis from having no height at rest.
    bottom, top = float(depths.min()), float(levels.max())
    room = _MARGIN_ABOVE_LEVEL * max(top - bottom, _MIN_WELL_DEPTH)
    axes.set_ylim(bottom - _MARGIN_BELOW_WELL * (top - bottom + room), top + room)
    if ends.size:
        width = float(np.ptp(ends)) or float(ends.max())
        margin = _MARGIN_BESIDE_TURNING_POINTS * width
        axes.set_xlim(max(ends.min() - margin, 0.0), ends.max() + margin)


def _finite_values(members: list[ensemble.Member], names: Sequence[str]) -> FloatArray:
    """All finite values of some variables."""
    values = [np.ravel(m.data[n].values) for m in members for n in names if n in m.data]
    together = np.concatenate([np.empty(0), *values]).astype(np.float64)
    return np.asarray(together[np.isfinite(together)])
