"""Branches of periodic orbits: stable solid, unstable dashed, elliptic double."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent._errors import InputError
from remanent.plots import ensemble, footer, style

__all__ = ["branch", "entries", "multipliers"]

#: Line styles of what multipliers say; a double line is a broad one with a white core.
_LOOKS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "stable": {"linestyle": "-", "linewidth": 1.3},
        "elliptic": {"linestyle": "-", "linewidth": 2.2},
        "saddle": {"linestyle": (0, (3.2, 1.4)), "linewidth": 1.1},
        "unstable": {"linestyle": (0, (1.0, 1.2)), "linewidth": 1.1},
        "undecided": {"linestyle": "-", "linewidth": 0.6},
    }
)
_MARKS = MappingProxyType(
    {"fold": "o", "period doubling": "s", "Neimark-Sacker": "D", "branch point": "^"}
)
_CORE = 0.8


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
    dataset
        A result of ``continue_orbit`` or ``response_diagram``, with at most two dimensions
        of ``over``.
    variable
        What to draw: ``amplitude``, ``maximum``, ``minimum`` or a state variable.
    parameter
        Against what; by default the parameter that was followed.
    ax
        Axes to draw in; a new figure, with its footer, if None.
    legend
        Whether to name lines and marks above the axes.
    **line
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One for each stretch of a branch with one stability.
    """
    x = parameter or _followed(dataset)
    with style.context():
        axes = style.owned_axes(ax)
        marks = [name for name in (f"special_{x}", f"special_{variable}") if name in dataset]
        names = (x, variable, "stability", "special_kind", *marks)
        found = ensemble.members(dataset, names, ("branch", "point", "special"))
        artists: list[Line2D] = []
        for one in found:
            artists += _drawn(axes, one, x, variable, line)
            _marked(axes, one, x, variable)
        axes.set(xlabel=style.label(dataset[x]), ylabel=style.label(dataset[variable]))
        axes.margins(x=0.0)
        if variable == "amplitude":
            axes.set_ylim(bottom=0.0)
        if legend:
            style.legend_above(axes, [*ensemble.handles(found), *entries(dataset)])
        if ax is None:
            footer.add(axes.get_figure(root=True), dataset, hide=(x,))  # type: ignore[arg-type]
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
    dataset, parameter, ax, legend
        As for :func:`branch`.
    **line
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        One for each multiplier on each stretch of a branch with one stability.
    """
    x = parameter or _followed(dataset)
    with style.context():
        axes = style.owned_axes(ax, height=2.0)
        names = (x, "multipliers", "stability", "special_kind", f"special_{x}")
        found = ensemble.members(dataset, names, ("branch", "point", "special", "multiplier"))
        axes.axhline(1.0, color=style.FAINT, linewidth=0.5)
        artists: list[Line2D] = []
        for one in found:
            sizes = one.data.assign(multipliers=abs(one.data["multipliers"]))
            for k in range(sizes.sizes["multiplier"]):
                own = replace(one, data=sizes.isel(multiplier=k))
                artists += _drawn(axes, own, x, "multipliers", line)
            _marked(axes, replace(one, data=_on_circle(one.data)), x, "multipliers")
        symbol = dataset["multipliers"].attrs["symbol"]
        axes.set(xlabel=style.label(dataset[x]), ylabel=f"modulus of multipliers, $|{symbol}|$")
        axes.margins(x=0.0)
        if legend:
            style.legend_above(axes, [*ensemble.handles(found), *entries(dataset)])
        if ax is None:
            footer.add(axes.get_figure(root=True), dataset, hide=(x,))  # type: ignore[arg-type]
    return artists


def _on_circle(data: xr.Dataset) -> xr.Dataset:
    """Special points are where a modulus is 1."""
    return data.assign(special_multipliers=xr.ones_like(data["special_kind"], dtype=float))


def _followed(dataset: xr.Dataset) -> str:
    """The parameter: the attribute of that name, or omega, which a response diagram follows."""
    name = str(dataset.attrs.get("parameter", "omega"))
    if name in dataset and f"special_{name}" in dataset:
        return name
    raise InputError(
        "dataset",
        must="be branches of orbits",
        got=", ".join(map(str, dataset.data_vars)),
        why="It has no parameter with special points.",
        fix="Pass the result of continue_orbit or response_diagram.",
    )


def _drawn(
    axes: Axes, one: ensemble.Member, x: str, variable: str, line: dict[str, Any]
) -> list[Line2D]:
    data = one.data if "branch" in one.data.dims else one.data.expand_dims("branch")
    artists = []
    for k in range(data.sizes["branch"]):
        row = data.isel(branch=k)
        kinds = row["stability"].values
        finite = np.isfinite(row[x].values)
        for first, last in _runs(kinds, int(finite.sum())):
            looks = {"color": one.colour, **_LOOKS[str(kinds[first])], **line}
            # A stretch begins where the one before it ends, so that no gap is seen.
            some = slice(max(first - 1, 0), last)
            (artist,) = axes.plot(
                row[x].values[some], row[variable].values[some], solid_capstyle="butt", **looks
            )
            if kinds[first] == "elliptic":
                artist.set_path_effects(_double("elliptic"))
            artists.append(artist)
    return artists


def _runs(kinds: Any, count: int) -> list[tuple[int, int]]:
    """Stretches of equal stability among the first `count` points."""
    edges = np.flatnonzero(kinds[1:count] != kinds[: max(count - 1, 0)]) + 1
    cuts = [0, *edges.tolist(), count]
    return [(a, b) for a, b in itertools.pairwise(cuts) if b > a]


def _marked(axes: Axes, one: ensemble.Member, x: str, variable: str) -> None:
    data, name = one.data, f"special_{variable}"
    if name not in data:
        return
    for kind, marker in _MARKS.items():
        chosen = data["special_kind"].values == kind
        where, height = data[f"special_{x}"].values[chosen], data[name].values[chosen]
        axes.plot(
            where, height, marker, ms=4.0, mfc="white",
            mec=one.colour, mew=1.0, zorder=5, linestyle="",
        )  # fmt: skip


def entries(dataset: xr.Dataset) -> list[Line2D]:
    """Legend entries of the kinds of stability and of special points that occur."""
    seen = set(np.unique(dataset["stability"].values.astype(str)))
    lines = [
        Line2D([], [], color=style.INK, label=name, path_effects=_double(name), **looks)
        for name, looks in _LOOKS.items()
        if name in seen
    ]
    kinds = set(np.unique(dataset["special_kind"].values.astype(str)))
    marks = [
        Line2D([], [], color=style.INK, mfc="white", marker=marker, ms=4, linestyle="", label=kind)
        for kind, marker in _MARKS.items()
        if kind in kinds
    ]
    return lines + marks


def _double(name: str) -> Any:
    if name != "elliptic":
        return None
    return [patheffects.Normal(), patheffects.Stroke(linewidth=_CORE, foreground="white")]
