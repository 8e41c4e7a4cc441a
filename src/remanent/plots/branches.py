"""Branches of periodic orbits: stable solid, unstable dashed, elliptic double."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent._errors import InputError
from remanent.plots import ensemble, footer, style

__all__ = ["branch", "multipliers", "stability_legend_entries"]

#: Line styles of what multipliers say; a double line is a broad one with a white core.
_STABILITY_LINE_STYLES: Final[Mapping[str, Mapping[str, Any]]] = MappingProxyType(
    {
        "stable": {"linestyle": "-", "linewidth": 1.3},
        "elliptic": {"linestyle": "-", "linewidth": 2.2},
        "saddle": {"linestyle": (0, (3.2, 1.4)), "linewidth": 1.1},
        "unstable": {"linestyle": (0, (1.0, 1.2)), "linewidth": 1.1},
        "undecided": {"linestyle": "-", "linewidth": 0.6},
    }
)
#: Markers of special points.
_SPECIAL_POINT_MARKERS: Final[Mapping[str, str]] = MappingProxyType(
    {"fold": "o", "period doubling": "s", "Neimark-Sacker": "D", "branch point": "^"}
)
#: Width of the white core of a double line, in points.
_DOUBLE_LINE_CORE_WIDTH_POINTS: Final = 0.8


def branch(
    dataset: xr.Dataset,
    variable: str = "amplitude",
    *,
    parameter: str | None = None,
    ax: Axes | None = None,
    legend: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw branches of periodic orbits against the parameter that was followed.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``continue_orbit`` or ``response_diagram``, with at most two dimensions
        of ``over``.
    variable : str
        What to draw: ``amplitude``, ``maximum``, ``minimum`` or a state variable.
    parameter : str, optional
        Against what; by default the parameter that was followed.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure, with its footer, if None.
    legend : bool
        Whether to name lines and marks above the axes.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One for each stretch of a branch with one stability.
    """
    x = parameter or _followed_parameter(dataset)
    with style.context():
        axes = style.given_or_new_axes(ax)
        marks = [name for name in (f"special_{x}", f"special_{variable}") if name in dataset]
        names = (x, variable, "stability", "special_kind", *marks)
        members = ensemble.split_into_members(dataset, names, ("branch", "point", "special"))
        artists: list[Line2D] = []
        for member in members:
            artists += _draw_branches(axes, member, x, variable, line)
            _mark_special_points(axes, member, x, variable)
        axes.set(xlabel=style.axis_label(dataset[x]), ylabel=style.axis_label(dataset[variable]))
        axes.margins(x=0.0)
        if variable == "amplitude":
            axes.set_ylim(bottom=0.0)
        named = (
            [*ensemble.line_legend_entries(members), *stability_legend_entries(dataset)]
            if legend
            else []
        )
        footer.add_legend_and_footer(axes, ax, dataset, named, hide=(x,))
    return artists


def multipliers(
    dataset: xr.Dataset,
    *,
    parameter: str | None = None,
    ax: Axes | None = None,
    legend: bool = True,
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
        Axes to draw in; a new figure, with its footer, if None.
    legend : bool
        Whether to name lines and marks above the axes.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One for each multiplier on each stretch of a branch with one stability.
    """
    x = parameter or _followed_parameter(dataset)
    with style.context():
        axes = style.given_or_new_axes(ax, height=2.0)
        names = (x, "multipliers", "stability", "special_kind", f"special_{x}")
        members = ensemble.split_into_members(
            dataset, names, ("branch", "point", "special", "multiplier")
        )
        axes.axhline(1.0, color=style.FAINT_COLOUR, linewidth=0.5)
        artists: list[Line2D] = []
        for member in members:
            moduli = member.data.assign(multipliers=abs(member.data["multipliers"]))
            for k in range(moduli.sizes["multiplier"]):
                single = replace(member, data=moduli.isel(multiplier=k))
                artists += _draw_branches(axes, single, x, "multipliers", line)
            on_circle = replace(member, data=_with_special_multipliers_at_one(member.data))
            _mark_special_points(axes, on_circle, x, "multipliers")
        symbol = style.math_symbol(dataset["multipliers"]).strip("$")
        axes.set(
            xlabel=style.axis_label(dataset[x]), ylabel=f"modulus of multipliers, $|{symbol}|$"
        )
        axes.margins(x=0.0)
        named = (
            [*ensemble.line_legend_entries(members), *stability_legend_entries(dataset)]
            if legend
            else []
        )
        footer.add_legend_and_footer(axes, ax, dataset, named, hide=(x,))
    return artists


def _with_special_multipliers_at_one(data: xr.Dataset) -> xr.Dataset:
    """Special points are where a modulus is 1."""
    return data.assign(special_multipliers=xr.ones_like(data["special_kind"], dtype=float))


def _followed_parameter(dataset: xr.Dataset) -> str:
    """The parameter: the attribute of that name, or omega, which a response diagram follows."""
    name = str(dataset.attrs.get("parameter", "omega"))
    if name in dataset and f"special_{name}" in dataset:
        return name
    raise InputError(
        "dataset",
        must="say which parameter was followed",
        got=", ".join(map(str, dataset.data_vars)),
        why="The attribute `parameter` says it in results of continue_orbit.",
        fix="Pass parameter=..., or the result of continue_orbit or response_diagram.",
    )


def _draw_branches(
    axes: Axes, member: ensemble.Member, x: str, variable: str, line: dict[str, Any]
) -> list[Line2D]:
    data = member.data if "branch" in member.data.dims else member.data.expand_dims("branch")
    artists = []
    for k in range(data.sizes["branch"]):
        row = data.isel(branch=k)
        stabilities = row["stability"].values
        finite = np.isfinite(row[x].values)
        for first, last in _equal_stability_ranges(stabilities, int(finite.sum())):
            looks = {
                "color": member.colour,
                **_STABILITY_LINE_STYLES[str(stabilities[first])],
                **line,
            }
            # A stretch begins where the one before it ends, so that no gap is seen.
            points = slice(max(first - 1, 0), last)
            (artist,) = axes.plot(
                row[x].values[points], row[variable].values[points], solid_capstyle="butt", **looks
            )
            if stabilities[first] == "elliptic":
                artist.set_path_effects(_double_line_effects("elliptic"))
            artists.append(artist)
    return artists


def _equal_stability_ranges(stabilities: Any, count: int) -> list[tuple[int, int]]:
    """Stretches of equal stability among the first `count` points."""
    changes = np.flatnonzero(stabilities[1:count] != stabilities[: max(count - 1, 0)]) + 1
    cuts = [0, *changes.tolist(), count]
    return [(a, b) for a, b in itertools.pairwise(cuts) if b > a]


def _mark_special_points(axes: Axes, member: ensemble.Member, x: str, variable: str) -> None:
    data, name = member.data, f"special_{variable}"
    if name not in data:
        return
    for kind, marker in _SPECIAL_POINT_MARKERS.items():
        of_kind = data["special_kind"].values == kind
        axes.plot(
            data[f"special_{x}"].values[of_kind], data[name].values[of_kind], marker, ms=4.0,
            mfc="white", mec=member.colour, mew=1.0, zorder=5, linestyle="",
        )  # fmt: skip


def stability_legend_entries(dataset: xr.Dataset) -> list[Line2D]:
    """Legend entries of the kinds of stability and of special points that occur."""
    stabilities = set(np.unique(dataset["stability"].values.astype(str)))
    lines = [
        Line2D(
            [],
            [],
            color=style.INK_COLOUR,
            label=name,
            path_effects=_double_line_effects(name),
            **looks,
        )
        for name, looks in _STABILITY_LINE_STYLES.items()
        if name in stabilities
    ]
    kinds = set(np.unique(dataset["special_kind"].values.astype(str)))
    marks = [
        Line2D(
            [],
            [],
            color=style.INK_COLOUR,
            mfc="white",
            marker=marker,
            ms=4,
            linestyle="",
            label=kind,
        )
        for kind, marker in _SPECIAL_POINT_MARKERS.items()
        if kind in kinds
    ]
    return lines + marks


def _double_line_effects(name: str) -> Any:
    if name != "elliptic":
        return None
    return [
        patheffects.Normal(),
        patheffects.Stroke(linewidth=_DOUBLE_LINE_CORE_WIDTH_POINTS, foreground="white"),
    ]
