"""Figures of periodic orbits, of the jump at resonance and of chaos; nothing is computed here."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from remanent import plots
from remanent.plots import branch_marks, footer, style
from remanent.plots import branches as branch_plot
from remanent.report.figures import keep_only_outer_labels, make_panel_grid

__all__ = ["draw_chaos_map", "draw_jump_at_resonance", "draw_response_branches"]

#: Colour of the motion from rest: that of no temperature.
_FROM_REST_COLOUR = style.INK_COLOUR
#: Colours of the motions below and above the jump.
_JUMP_SIDE_COLOURS = (style.OKABE_ITO_COLOURS["blue"], style.OKABE_ITO_COLOURS["vermillion"])
#: Diameters of their points: the first shows below the second where they agree.
_JUMP_SIDE_SIZES = (3.4, 1.6)
#: Colour of the line at the jump.
_JUMP_COLOUR = style.OKABE_ITO_COLOURS["vermillion"]


def draw_response_branches(
    branches: xr.Dataset, response: xr.Dataset, orbits: xr.Dataset
) -> Figure:
    """Draw the periodic orbits behind each resonance.

    Parameters
    ----------
    branches
        A response diagram (prestress, temperature, branch, point).
    response
        The response from rest: ``amplitude`` (prestress, temperature, omega).
    orbits
        Periodic orbits at the resonances: ``amplitude`` (prestress, temperature, orbit) and
        the coordinate ``omega`` (prestress, temperature).

    Returns
    -------
    matplotlib.figure.Figure
        One row per prestress, one panel per temperature.
    """
    rows, columns = branches["prestress"].values, branches["temperature"].values
    with style.context():
        size = (style.DOUBLE_COLUMN_WIDTH_INCHES, 2.1 * len(rows) + 0.7)
        figure, grid = make_panel_grid(len(rows), len(columns), size, sharex=True, sharey=True)
        for k, axes in enumerate(grid.flat):
            at = {"prestress": k // len(columns), "temperature": k % len(columns)}
            axes.set_ylim(0.0, 1.05 * float(response["amplitude"].max()))
            _draw_resonance(axes, branches.isel(at), response.isel(at), orbits.isel(at))
            title = ", ".join(style.value_label(branches[n], branches[n].values[at[n]]) for n in at)
            style.set_panel_title(axes, "abcdefgh"[k], title)
        keep_only_outer_labels(grid, x=True, y=True)
        rest = Line2D([], [], color=_FROM_REST_COLOUR, linewidth=0.8, label="from rest")
        style.add_legend_above(
            figure, [*_branch_legend_entries(branches), rest, _orbit_legend_entry()]
        )
        footer.add_footer(figure, branches, hide=("omega",))
    return figure


def draw_jump_at_resonance(
    branches: xr.Dataset, response: xr.Dataset, sections: xr.Dataset, crossing: xr.Dataset
) -> Figure:
    """Draw why the response from rest jumps: on which side of a saddle the motion passes.

    Parameters
    ----------
    branches
        Of one actuator (branch, point).
    response
        The response from rest, ``amplitude`` (omega).
    sections
        Two motions from rest, on both sides of the jump (omega, period).
    crossing
        ``omega`` at which the motion crosses the stable manifold; the saddle's ``stretch``
        and ``stretch_rate``.

    Returns
    -------
    matplotlib.figure.Figure
        Left the response with the branches; right the two motions, strobed.
    """
    with style.context():
        figure, grid = make_panel_grid(1, 2, (style.DOUBLE_COLUMN_WIDTH_INCHES, 3.3))
        left, right = grid[0]
        plots.branch(branches, ax=left, legend=False)
        low, high = float(response["omega"].min()), float(response["omega"].max())
        left.plot(response["omega"], response["amplitude"], color=_FROM_REST_COLOUR, linewidth=0.9)
        left.axvline(float(crossing["omega"]), color=_JUMP_COLOUR, linewidth=0.8, linestyle=":")
        left.set(xlim=(low, high), ylim=(0.0, 1.1 * float(response["amplitude"].max())))
        for k, (colour, size) in enumerate(zip(_JUMP_SIDE_COLOURS, _JUMP_SIDE_SIZES, strict=True)):
            motion = sections.isel(omega=k)
            x, y = motion["stretch"].values, motion["stretch_rate"].values
            right.plot(x, y, color=colour, linewidth=0.4, alpha=0.6)
            right.plot(x, y, "o", ms=size, mew=0.0, color=colour)
        saddle = float(crossing["stretch"]), float(crossing["stretch_rate"])
        right.plot(*saddle, "X", ms=6, color=style.INK_COLOUR, mec="white", mew=0.6, zorder=5)
        right.plot(1.0, 0.0, "P", ms=5, mfc="white", mec=style.INK_COLOUR, mew=0.8, zorder=5)
        right.set(xlabel=style.axis_label(sections["stretch"]),
                  ylabel=style.axis_label(sections["stretch_rate"]))  # fmt: skip
        style.set_panel_title(left, "a", "response from rest and branches")
        style.set_panel_title(right, "b", "from rest, once per drive period")
        style.add_legend_above(
            figure,
            [
                *_entries_in_view(left, _branch_legend_entries(branches)),
                *_jump_side_legend_entries(sections["omega"], crossing),
            ],
        )
        footer.add_footer(figure, sections)
    return figure


def draw_chaos_map(chart: xr.Dataset, cases: xr.Dataset) -> Figure:
    """Draw where in the plane of frequency and load the motion from rest is chaotic.

    Parameters
    ----------
    chart
        ``regime``, ``exponent``, ``rotation_number`` (b, omega).
    cases
        ``omega`` and ``b`` (temperature) of the published motions in that plane.

    Returns
    -------
    matplotlib.figure.Figure
    """
    with style.context():
        figure, grid = make_panel_grid(1, 1, (5.4, 3.6))
        axes = grid[0, 0]
        plots.map(chart, ax=axes)
        entries: list[Artist] = []
        temperatures = cases["temperature"].values
        for colour, t in zip(style.temperature_colours(temperatures), temperatures, strict=True):
            case = cases.sel(temperature=t)
            entries += axes.plot(
                float(case["omega"]), float(case["b"]), "o", ms=4.5, color=colour, mec="white",
                mew=0.7, label=f"figure 5, {style.value_label(cases['temperature'], t)}",
            )  # fmt: skip
        axes.set(
            xlabel=r"drive frequency, $\omega/\sqrt{\theta}$",
            ylabel=r"root of the peak magnetic load, $b/\sqrt{\theta}$",
        )
        style.add_legend_above(figure, entries)
        footer.add_footer(figure, chart)
    return figure


def _draw_resonance(
    axes: Axes, branches: xr.Dataset, response: xr.Dataset, orbits: xr.Dataset
) -> None:
    colour = style.temperature_colours([float(branches["temperature"])])[0]
    axes.plot(response["omega"], response["amplitude"], color=_FROM_REST_COLOUR, linewidth=0.8)
    plots.branch(branches, ax=axes, legend=False)
    omega = float(orbits["omega"])
    axes.axvline(omega, color=style.FAINT_COLOUR, linewidth=0.5, linestyle=":")
    amplitude = orbits["amplitude"].values[np.isfinite(orbits["amplitude"].values)]
    axes.plot(
        np.full(amplitude.size, omega), amplitude, "o", ms=3.2, color=colour, mec="white", mew=0.5,
        zorder=6,
    )  # fmt: skip
    axes.set_xlim(float(branches["omega"].min()), float(branches["omega"].max()))


def _branch_legend_entries(branches: xr.Dataset) -> list[Line2D]:
    return [
        *branch_plot.stability_legend_entries(branches),
        *branch_marks.special_point_legend_entries(branches),
        *branch_marks.end_legend_entries(branches, "omega"),
    ]


def _entries_in_view(axes: Axes, entries: list[Line2D]) -> list[Line2D]:
    """Those of which something lies inside the frame: a stability by its name, a mark by its look.

    Other branches and marks of the same result lie beyond what is drawn.
    """
    low, high = np.sort([axes.get_xlim(), axes.get_ylim()], axis=1).T
    shown = set()
    for line in axes.lines:
        points = np.asarray(line.get_xydata(), dtype=np.float64)
        if ((points >= low) & (points <= high)).all(axis=1).any():
            shown |= {line.get_gid(), line.get_marker()}
    return [e for e in entries if (e.get_label() if e.get_marker() == "None" else e.get_marker())
            in shown]  # fmt: skip


def _orbit_legend_entry() -> Line2D:
    return Line2D([], [], color=style.INK_COLOUR, marker="o", mec="white", ms=4, linestyle="",
                  label="orbits at resonance")  # fmt: skip


def _jump_side_legend_entries(omega: xr.DataArray, crossing: xr.Dataset) -> list[Line2D]:
    distance = style.format_number(float(omega[1] - omega[0]) / 2.0)
    looks: dict[str, Any] = {"marker": "o", "ms": 3, "linewidth": 0.5}
    return [
        Line2D([], [], color=_FROM_REST_COLOUR, linewidth=0.9, label="from rest"),
        *(
            Line2D([], [], color=colour, label=rf"$\omega^* {sign} {distance}$", **looks)
            for colour, sign in zip(_JUMP_SIDE_COLOURS, "-+", strict=True)
        ),
        Line2D([], [], color=_JUMP_COLOUR, linewidth=0.8, linestyle=":",
               label=rf"$\omega^* = {float(crossing['omega']):.8f}$"),
        Line2D([], [], color=style.INK_COLOUR, marker="X", mec="white", ms=6, linestyle="",
               label="saddle, strobed"),
        Line2D([], [], color=style.INK_COLOUR, marker="P", mfc="white", ms=5, linestyle="",
               label="rest"),
    ]  # fmt: skip
