"""Branches of periodic orbits: stable solid, unstable dashed, elliptic double."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.plots import ensemble, keys, missing, style
from remanent.plots.backbones import draw_backbone
from remanent.plots.branch_marks import mark_ends, mark_special_points
from remanent.plots.footer import add_legend_and_footer
from remanent.plots.retraced import new_stretches, turning_points
from remanent.plots.stability_changes import located_names, points_of_change

__all__ = ["branch", "multipliers", "stability_legend_entries"]

#: Line styles of what multipliers say; a double line is a broad one with a core of the ground.
_STABILITY_LINE_STYLES: Final[Mapping[str, Mapping[str, Any]]] = MappingProxyType(
    {
        "stable": {"linestyle": "-", "linewidth": 1.3},
        "elliptic": {"linestyle": "-", "linewidth": 2.2},
        "saddle": {"linestyle": (0, (3.2, 1.4)), "linewidth": 1.1},
        "unstable": {"linestyle": (0, (1.0, 1.2)), "linewidth": 1.1},
        "undecided": {"linestyle": "-", "linewidth": 0.6},
    }
)
#: Dimensions of branches beside those of ``over``.
_OWN_DIMENSIONS: Final = ("branch", "point", "special", "multiplier", "end", "period")
#: Width of the core of a double line, in points.
_DOUBLE_LINE_CORE_WIDTH_POINTS: Final = 0.8
#: Room beside branches, over their width.
_MARGIN_BESIDE_BRANCHES: Final = 0.03
#: No point.
_NOWHERE: Final = np.empty((0, 2))
#: Length of a line, over the size of what is drawn, from which it is seen.
_MIN_SEEN_LENGTH: Final = 5e-3


def branch(
    dataset: xr.Dataset,
    variable: str = "amplitude",
    *,
    parameter: str | None = None,
    backbone: xr.Dataset | None = None,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw branches of periodic orbits against the parameter that was followed.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``continue_orbit`` or ``response_diagram``, with at most two dimensions
        of ``over``.
    variable : str
        What to draw: ``amplitude``, ``maximum``, ``minimum``, a state variable, or
        ``thickness_stretch`` at the beginning of each drive period, over a bifurcation diagram.
    parameter : str, optional
        Against what; by default the parameter that was followed.
    backbone : xarray.Dataset, optional
        A result of ``backbone``, drawn where the load has the frequency of its oscillations.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name lines and marks above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One for each stretch of a branch with one stability.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    multipliers : The multipliers along the same branches.
    remanent.response_diagram : All branches of forced response.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> hot, drive = rm.Actuator(temperature=350), rm.SineSquared(0.4, 1.25)
    >>> ds = rm.continue_orbit(hot, drive, "omega", (1.0, 1.6), initial=(1.433, 0.0))
    >>> len(rm.plot.branch(ds))  # one stable stretch, one unstable
    2
    >>> plt.close()
    """
    x = _followed_parameter(dataset, parameter)
    _require_values_along_branch(dataset, variable)
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax)
        ends = ["end_reason"] if "end_reason" in dataset else []
        names = [*_names_along_branches(dataset, x, variable), *ends]
        members = ensemble.split_by_colour(dataset, names, _OWN_DIMENSIONS)
        size = _extent(dataset, x, dataset[variable].values)
        artists: list[Line2D] = []
        marked: list[Line2D] = []
        for member in members:
            artists += _draw_branches(axes, member, x, variable, line, size)
            marked += mark_special_points(axes, member, x, variable, size)
            marked += mark_ends(axes, member, x, variable)
        style.label_axes(axes, style.axis_label(dataset[x]), style.axis_label(dataset[variable]))
        if variable == "amplitude":
            axes.set_ylim(bottom=0.0)
        free = draw_backbone(axes, _fitting_backbone(backbone, x), dataset, variable)
        entries = [*_drawn_stabilities(dataset, artists, size), *free, *marked]
        _finish(axes, ax, dataset, members, entries, x, variable, legend, footer)
    return artists


def multipliers(
    dataset: xr.Dataset,
    *,
    parameter: str | None = None,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw the moduli of Floquet multipliers against the parameter that was followed.

    Meant to stand under :func:`branch`, with the same axis: an orbit is stable while all
    moduli are below 1, and special points lie where one of them reaches it.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``continue_orbit`` or ``response_diagram``, with at most two dimensions
        of ``over``.
    parameter : str, optional
        Against what; by default the parameter that was followed.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name lines and marks above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One for each multiplier on each stretch of a branch with one stability.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    branch : The branches themselves.
    remanent.continue_orbit : The result that is drawn.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> hot, drive = rm.Actuator(temperature=350), rm.SineSquared(0.4, 1.25)
    >>> ds = rm.continue_orbit(hot, drive, "omega", (1.0, 1.6), initial=(1.433, 0.0))
    >>> len(rm.plot.multipliers(ds))  # two multipliers on each of two stretches
    4
    >>> plt.close()
    """
    x = _followed_parameter(dataset, parameter)
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax, height=2.0)
        names = _names_along_branches(dataset, x, "multipliers")
        members = ensemble.split_by_colour(dataset, names, _OWN_DIMENSIONS)
        size = _extent(dataset, x, abs(dataset["multipliers"].values))
        axes.axhline(1.0, color=style.FAINT_COLOUR, linewidth=0.5)
        artists: list[Line2D] = []
        marked: list[Line2D] = []
        for member in members:
            moduli = member.data.assign(multipliers=abs(member.data["multipliers"]))
            for k in range(moduli.sizes["multiplier"]):
                single = replace(member, data=moduli.isel(multiplier=k))
                artists += _draw_branches(axes, single, x, "multipliers", line, size)
            on_circle = replace(member, data=_with_special_multipliers_at_one(member.data))
            marked += mark_special_points(axes, on_circle, x, "multipliers", size)
        symbol = style.math_symbol(dataset["multipliers"]).strip("$")
        style.label_axes(
            axes, style.axis_label(dataset[x]), f"modulus of multipliers, $|{symbol}|$"
        )
        entries = [*_drawn_stabilities(dataset, artists, size), *marked]
        _finish(axes, ax, dataset, members, entries, x, "multipliers", legend, footer)
    return artists


def _names_along_branches(dataset: xr.Dataset, x: str, variable: str) -> list[str]:
    """What is drawn, and what says where its special points lie."""
    located = located_names(dataset)
    special = [f"special_{name}" for name in (x, variable, *located)]
    names = [x, variable, "stability", "special_kind", *located]
    return list(dict.fromkeys([*names, *(name for name in special if name in dataset)]))


def _extent(dataset: xr.Dataset, x: str, up: FloatArray) -> FloatArray:
    """Width and height of what is drawn, array (2,); 1 where there is none."""
    sizes = [np.ptp(v[np.isfinite(v)]) if np.isfinite(v).any() else 0.0
             for v in (dataset[x].values, up)]  # fmt: skip
    return np.array([size or 1.0 for size in sizes])


def _finish(
    axes: Axes,
    given: Axes | None,
    dataset: xr.Dataset,
    members: list[ensemble.Member],
    entries: list[Line2D],
    x: str,
    variable: str,
    legend: bool,
    footer: bool,
) -> None:
    """Margins, so that no mark lies on the frame; legend, colour bar and footer."""
    axes.margins(x=_MARGIN_BESIDE_BRANCHES)
    missing.write_in_empty_frame(axes, members, x, variable)
    if legend:
        keys.add_colour_bar(axes, members)
    named = [*keys.line_legend_entries(members, variable), *entries]
    add_legend_and_footer(axes, given, dataset, named, legend=legend, footer=footer, hide=(x,))


def _with_special_multipliers_at_one(data: xr.Dataset) -> xr.Dataset:
    """Special points are where a modulus is 1."""
    return data.assign(special_multipliers=xr.ones_like(data["special_kind"], dtype=float))


def _followed_parameter(dataset: xr.Dataset, given: str | None) -> str:
    """What is given, the attribute of that name, or omega, which a response diagram follows."""
    name = given or str(dataset.attrs.get("parameter", "omega"))
    if name in dataset and f"special_{name}" in dataset:
        return name
    raise InputError(
        "parameter" if given else "dataset",
        must="be the parameter that was followed" if given else "say which parameter was followed",
        got=repr(given) if given else ", ".join(map(str, dataset.data_vars)),
        why="The attribute `parameter` says it in results of continue_orbit.",
        fix="Pass parameter=..., or the result of continue_orbit or response_diagram.",
    )


def _fitting_backbone(backbone: xr.Dataset | None, x: str) -> xr.Dataset | None:
    """The backbone, refused where the axis is no frequency."""
    if backbone is not None and x != "omega":
        raise InputError(
            "backbone",
            must="be left out where the axis is no frequency",
            got=f"one over {x}",
            why="A backbone is a frequency for each amplitude.",
            fix="Pass it with a branch that was followed in omega.",
        )
    return backbone


def _require_values_along_branch(dataset: xr.Dataset, variable: str) -> None:
    """Refuse what a branch does not have real values of, at each point."""
    values = dataset[variable] if variable in dataset.variables else None
    if values is not None and ("point" not in values.dims or values.dtype.kind == "c"):
        raise InputError(
            "variable",
            must="have a real value at each point of the branch",
            got=f"{variable!r}, {values.dtype} along {', '.join(map(str, values.dims)) or 'none'}",
            why="The branch is drawn at its values.",
            fix="Pass for example 'amplitude'; rm.plot.multipliers draws those.",
        )


def _draw_branches(
    axes: Axes,
    member: ensemble.Member,
    x: str,
    variable: str,
    line: dict[str, Any],
    size: FloatArray,
) -> list[Line2D]:
    """Draw each stretch of equal stability, and none twice."""
    data = member.data if "branch" in member.data.dims else member.data.expand_dims("branch")
    artists = []
    drawn: dict[str, list[FloatArray]] = {}
    for k in range(data.sizes["branch"]):
        row = data.isel(branch=k)
        stabilities = row["stability"].values
        for column in _columns(row[variable]):
            points = np.stack([row[x].values, column], axis=1).astype(np.float64)
            count = int(np.isfinite(points[:, 0]).sum())
            changes = points_of_change(row, x, variable, points[:count])
            for first, last in _equal_stability_ranges(stabilities, count):
                name = str(stabilities[first])
                looks = {"color": member.colour, **_STABILITY_LINE_STYLES[name], **line}
                # A stretch begins where the one before it ends, so that no gap is seen: at the
                # special point between them, or at the last point of that one.
                before = changes.get(first, points[max(first - 1, 0) : first])
                stretch = np.concatenate([before, points[first:last], changes.get(last, _NOWHERE)])
                for piece in _pieces_not_drawn(stretch, drawn.setdefault(name, []), size):
                    (artist,) = axes.plot(*piece.T, solid_capstyle="butt", gid=name, **looks)
                    if name == "elliptic":
                        artist.set_path_effects(_double_line_effects(name, axes.get_facecolor()))
                    artists.append(artist)
    return artists


def _columns(variable: xr.DataArray) -> FloatArray:
    """What is drawn along a branch, a row for each drive period where it has one for each."""
    return variable.transpose(..., "point").values.reshape(-1, variable.sizes["point"])


def _pieces_not_drawn(
    stretch: FloatArray, drawn: list[FloatArray], size: FloatArray
) -> list[FloatArray]:
    """What of a stretch is new, whole where all of it is; `drawn` grows by it."""
    cuts = [0, *turning_points(stretch[:, 0]), len(stretch) - 1]
    arms = [stretch[a : b + 1] for a, b in itertools.pairwise(cuts) if b > a]
    pieces = []
    for arm in arms:
        pieces.append([arm[part] for part in new_stretches(arm, drawn, size)])
        drawn.append(arm)
    whole = all(len(parts) == 1 and len(parts[0]) == len(arm)
                for parts, arm in zip(pieces, arms, strict=True))  # fmt: skip
    return [stretch] if whole else list(itertools.chain.from_iterable(pieces))


def _equal_stability_ranges(stabilities: Any, count: int) -> list[tuple[int, int]]:
    """Stretches of equal stability among the first `count` points."""
    changes = np.flatnonzero(stabilities[1:count] != stabilities[: max(count - 1, 0)]) + 1
    cuts = [0, *changes.tolist(), count]
    return [(a, b) for a, b in itertools.pairwise(cuts) if b > a]


def stability_legend_entries(dataset: xr.Dataset) -> list[Line2D]:
    """Legend entries of the kinds of stability that occur."""
    stabilities = set(np.unique(dataset["stability"].values.astype(str)))
    ground = str(mpl.rcParams["axes.facecolor"])
    return [
        Line2D([], [], color=style.ink_colour(), label=name,
               path_effects=_double_line_effects(name, ground), **looks)
        for name, looks in _STABILITY_LINE_STYLES.items()
        if name in stabilities
    ]  # fmt: skip


def _drawn_stabilities(
    dataset: xr.Dataset, artists: list[Line2D], size: FloatArray
) -> list[Line2D]:
    """Legend entries of the kinds of stability of which there is more than a spot to see."""
    seen = {
        artist.get_gid()
        for artist in artists
        if np.nanmax(np.ptp(artist.get_xydata(), axis=0) / size) >= _MIN_SEEN_LENGTH
    }
    names = seen or {artist.get_gid() for artist in artists}
    return [e for e in stability_legend_entries(dataset) if e.get_label() in names]


def _double_line_effects(name: str, ground: Any) -> Any:
    if name != "elliptic":
        return None
    return [
        patheffects.Normal(),
        patheffects.Stroke(linewidth=_DOUBLE_LINE_CORE_WIDTH_POINTS, foreground=ground),
    ]
