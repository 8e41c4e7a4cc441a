"""Pictures of results in the house style; nothing is computed here."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from remanent.plots import style
from remanent.plots.maps import map

#: Colour and marker of a tool; Okabe and Ito's colours, ours in blue.
_LOOK = {
    "remanent": ("blue", "o", "-"),
    "remanent-fixed": ("sky", "D", "-"),
    "heyoka": ("vermillion", "s", "--"),
    "scipy": ("green", "^", ":"),
}


def precision(data: Any, path: Path) -> None:
    """Time against error, worst and median."""
    titles = {"worst": "worst of all frequencies", "median": "median of all frequencies"}
    with style.context():
        figure = Figure(figsize=(style.DOUBLE_COLUMN_WIDTH_INCHES, 3.6), layout="constrained")
        panels = figure.subplots(1, 2, sharey=True)
        for letter, (key, title), axes in zip("ab", titles.items(), panels, strict=True):
            lines = [_curve(axes, tool, curve, key) for tool, curve in data["curves"].items()]
            axes.set(
                xscale="log", yscale="log", xlabel="error of $\\lambda_3$, smaller to the right"
            )
            axes.invert_xaxis()
            style.set_panel_title(axes, letter, title)
        panels[0].set_ylabel(r"µs per trajectory and unit of $\tau$")
        style.add_legend_above(figure, lines)
        style.save_figure(figure, path)


def _curve(axes: Axes, tool: str, curve: Any, key: str) -> Any:
    colour, marker, dashes = _LOOK[tool]
    points = curve["points"]
    (line,) = axes.plot(
        [p[key] for p in points], [p["microseconds"] for p in points], dashes,
        color=style.OKABE_ITO_COLOURS[colour], marker=marker, markersize=3.5, label=curve["name"],
    )  # fmt: skip
    hollow = [p for p in points if p["missing"]]
    axes.plot(
        [p[key] for p in hollow], [p["microseconds"] for p in hollow], marker, markersize=3.5,
        color=style.OKABE_ITO_COLOURS[colour], markerfacecolor="white",
    )  # fmt: skip
    return line


def growth(data: Any, path: Path) -> None:
    """Time and memory against the number of trajectories."""
    rows = data["rows"]
    count = [row["trajectories"] for row in rows]
    with style.context():
        figure = Figure(figsize=(style.DOUBLE_COLUMN_WIDTH_INCHES, 2.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        blue, red = style.OKABE_ITO_COLOURS["blue"], style.OKABE_ITO_COLOURS["vermillion"]
        seconds = [row["seconds"] for row in rows]
        left.loglog(count, seconds, "D-", color=style.INK_COLOUR, markersize=3.5)
        left.set(xlabel="trajectories", ylabel="time (s)")
        parts = (("result", "the result", blue, "o-"), ("beyond", "beyond the result", red, "s--"))
        for key, label, colour, form in parts:
            right.loglog(
                count, [max(row[key], 1) / 2**20 for row in rows], form, color=colour, label=label,
                markersize=3.5,
            )  # fmt: skip
        right.set(xlabel="trajectories", ylabel="memory (MiB)")
        style.set_panel_title(left, "a", "time")
        style.set_panel_title(right, "b", "memory")
        right.legend(loc="lower right")
        style.save_figure(figure, path)


def chart(dataset: xr.Dataset, folds: xr.Dataset, path: Path) -> None:
    """Regimes over two parameters, and the curve on which orbits are born."""
    with style.context():
        figure = Figure(figsize=(style.DOUBLE_COLUMN_WIDTH_INCHES, 4.6), layout="constrained")
        axes = figure.subplots()
        map(dataset, ax=axes)
        axes.plot(folds.omega, folds.b, color="white", linewidth=1.2)
        axes.plot(folds.omega, folds.b, color=style.OKABE_ITO_COLOURS["vermillion"], linewidth=0.7)
        axes.set(xlim=dataset.omega.values[[0, -1]], ylim=dataset.b.values[[0, -1]])
        style.save_figure(figure, path)
