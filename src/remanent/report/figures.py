"""Figures 2 to 6 of [Thermal], in its arrangement, from Datasets; nothing is computed here.

Every Dataset is labelled by :mod:`remanent.results.build`, and its attributes make the
footer.  Panels are lettered as in [Thermal].
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from remanent import plots
from remanent.plots import ensemble, footer, forced, keys, style

__all__ = [
    "draw_figure_2",
    "draw_figure_3",
    "draw_figure_4",
    "draw_figure_5_or_6",
    "draw_panel_per_prestress",
    "keep_only_outer_labels",
    "make_panel_grid",
]

#: Colour of points at odd drive periods.
_ODD_PERIOD_COLOUR = style.OKABE_ITO_COLOURS["blue"]


def draw_figure_2(dataset: xr.Dataset) -> Figure:
    """Draw figure 2, the thickness stretch against time under constant load.

    Parameters
    ----------
    dataset
        ``thickness_stretch`` (prestress, temperature, time).

    Returns
    -------
    matplotlib.figure.Figure
        Panel (a), (b) ... per prestress, one below the other.
    """
    names = keys.line_legend_entries(_members_of_first_panel(dataset, "thickness_stretch", "time"))
    return draw_panel_per_prestress(
        dataset, plots.history, (style.DOUBLE_COLUMN_WIDTH_INCHES, 4.1), names, stacked=True
    )


def draw_figure_3(dataset: xr.Dataset) -> Figure:
    """Draw figure 3, phase planes under constant load.

    Parameters
    ----------
    dataset
        ``thickness_stretch`` and ``thickness_stretch_rate`` (prestress, temperature,
        time): the Dataset of figure 2.

    Returns
    -------
    matplotlib.figure.Figure
        Panel (a), (b) ... per prestress, side by side.
    """
    names = keys.line_legend_entries(_members_of_first_panel(dataset, "thickness_stretch", "time"))
    return draw_panel_per_prestress(
        dataset, plots.phase, (style.DOUBLE_COLUMN_WIDTH_INCHES, 3.6), names
    )


def draw_figure_4(dataset: xr.Dataset) -> Figure:
    """Draw figure 4, frequency responses with their resonances.

    Parameters
    ----------
    dataset
        ``amplitude`` (prestress, temperature, omega); ``resonance``,
        ``resonance_error`` and, where they are to be drawn, ``resonance_amplitude`` and
        ``published`` (prestress, temperature).

    Returns
    -------
    matplotlib.figure.Figure
        Panel (a), (b) ... per prestress, side by side, on one scale.
    """
    names = keys.line_legend_entries(_members_of_first_panel(dataset, "amplitude", "omega"))
    entries = [*names, *forced.resonance_legend_entries(dataset)]
    return draw_panel_per_prestress(
        dataset, plots.response, (style.DOUBLE_COLUMN_WIDTH_INCHES, 3.4), entries, sharey=True
    )


def draw_figure_5_or_6(history: xr.Dataset, section: xr.Dataset) -> Figure:
    """Draw figure 5 or 6, and beside it the section at every drive period.

    The load repeats every pi/omega, the field every 2 pi/omega; [Thermal] does not say
    at which it strobes.  Its two columns are drawn with every second drive period; a
    third shows every one, odd periods open.

    Parameters
    ----------
    history
        ``thickness_stretch`` and ``thickness_stretch_rate`` (temperature, time).
    section
        The same variables (temperature, period) at every drive period (``every=1``),
        ``period`` counting drive periods from the start.

    Returns
    -------
    matplotlib.figure.Figure
        One row per temperature: history (a, c, e), phase plane with section (b, d, f),
        section at every drive period.  Each column has one scale, so that amplitudes compare.
    """
    temperatures = np.sort(history["temperature"].values)
    with style.context():
        size = (style.DOUBLE_COLUMN_WIDTH_INCHES, 1.85 * len(temperatures) + 0.5)
        figure, grid = make_panel_grid(
            len(temperatures), 3, size, width_ratios=(1.75, 1, 1), sharex="col", sharey="col"
        )
        for row, (temperature, axes) in enumerate(zip(temperatures, grid, strict=True)):
            at = {"temperature": temperature}
            _draw_motion_row(axes, history.sel(at), section.sel(at))
            name = style.value_label(history["temperature"], temperature)
            style.set_panel_title(axes[0], _panel_letter(2 * row), name)
            style.set_panel_title(
                axes[1], _panel_letter(2 * row + 1), r"strobed every $2\pi/\omega$"
            )
            # The article has no third column: its letters go on after those of the article.
            letter = _panel_letter(2 * len(temperatures) + row)
            style.set_panel_title(axes[2], letter, r"strobed every $\pi/\omega$")
        keep_only_outer_labels(grid, x=True, y=False)
        style.add_legend_above(figure, _even_and_odd_period_legend_entries())
        footer.add_footer(figure, section)
    return figure


def make_panel_grid(
    rows: int, columns: int, size: tuple[float, float], **options: Any
) -> tuple[Figure, np.ndarray[Any, Any]]:
    """Make a figure of its own, outside pyplot, with a grid of axes (rows, columns)."""
    figure = Figure(figsize=size, layout="constrained")
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def keep_only_outer_labels(grid: np.ndarray[Any, Any], *, x: bool, y: bool) -> None:
    """Keep axis labels in the last row (`x`) and the first column (`y`) only."""
    for axes in grid[:-1].flat if x else ():
        axes.set_xlabel("")
    for axes in grid[:, 1:].flat if y else ():
        axes.set_ylabel("")


def draw_panel_per_prestress(
    dataset: xr.Dataset,
    draw: Callable[..., Any],
    size: tuple[float, float],
    entries: Sequence[Line2D],
    *,
    stacked: bool = False,
    sharey: bool = False,
) -> Figure:
    """Draw one panel per prestress, with a common legend and footer."""
    values = dataset["prestress"].values
    shape = (len(values), 1) if stacked else (1, len(values))
    with style.context():
        figure, grid = make_panel_grid(*shape, size, sharex=stacked, sharey=sharey)
        for k, (value, axes) in enumerate(zip(values, grid.flat, strict=True)):
            draw(dataset.sel(prestress=value), ax=axes, legend=False)
            style.set_panel_title(
                axes, _panel_letter(k), style.value_label(dataset["prestress"], value)
            )
        keep_only_outer_labels(grid, x=stacked, y=not stacked)
        style.add_legend_above(figure, entries)
        figure.align_ylabels()
        footer.add_footer(figure, dataset)
    return figure


def _members_of_first_panel(
    dataset: xr.Dataset, variable: str, dimension: str
) -> list[ensemble.Member]:
    """Members of the first panel, which stand for all in the legend."""
    return ensemble.split_into_members(dataset.isel(prestress=0), (variable,), (dimension,))


def _draw_motion_row(axes: Sequence[Axes], history: xr.Dataset, section: xr.Dataset) -> None:
    """History; phase plane with every second point of the section; section with all."""
    plots.history(history, ax=axes[0], linewidth=0.8)
    plots.phase(history, ax=axes[1], start=False, linewidth=0.4, alpha=0.55)
    second = section["period"].values % 2 == 0
    even, odd = section.isel(period=second), section.isel(period=~second)
    plots.section(even, ax=axes[1], color=style.INK_COLOUR, zorder=4)
    plots.section(
        odd,
        ax=axes[2],
        color=None,
        facecolors="none",
        edgecolors=_ODD_PERIOD_COLOUR,
        s=4.5,
        linewidths=0.5,
    )
    plots.section(even, ax=axes[2], color=style.INK_COLOUR, s=1.5, zorder=4)
    axes[2].set_ylabel("")


def _even_and_odd_period_legend_entries() -> list[Line2D]:
    looks: dict[str, Any] = {"linestyle": "", "marker": "o"}
    return [
        Line2D([], [], color=style.INK_COLOUR, ms=2.2, label="even drive periods", **looks),
        Line2D(
            [], [], color=_ODD_PERIOD_COLOUR, mfc="none", ms=4, label="odd drive periods", **looks
        ),
    ]


def _panel_letter(k: int) -> str:
    return "abcdefghijklmnopqrstuvwxyz"[k]
