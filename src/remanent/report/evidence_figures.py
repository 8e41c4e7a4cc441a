"""Figures that [Thermal] does not have and its claims need; nothing is computed here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import product
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.lines import Line2D

from remanent import plots
from remanent.plots import energy, ensemble, footer, keys, style
from remanent.report.figures import (
    draw_panel_per_prestress,
    keep_only_outer_labels,
    make_panel_grid,
)
from remanent.report.settings import MAX_RESONANCE_MISFIT

__all__ = ["draw_landscapes", "draw_misfit_maps", "draw_solver_comparison"]

#: Largest misfit with a colour of its own: ten times that of a choice that agrees.
_LARGEST_SHOWN_MISFIT = 10.0 * MAX_RESONANCE_MISFIT
#: Colour of the converged section behind the other.
_BACKGROUND_COLOUR = "#bdbdbd"
#: Dots at choices that agree, and at the least misfit.
_AGREEING_LOOKS: Final[Mapping[str, Any]] = MappingProxyType(
    {"linestyle": "", "marker": "o", "ms": 2.2, "mew": 0.0, "color": style.INK_COLOUR}
)
_LEAST_LOOKS: Final[Mapping[str, Any]] = MappingProxyType(
    {"linestyle": "", "marker": "o", "ms": 4.5, "mew": 0.7, "mec": "white",
     "color": style.OKABE_ITO_COLOURS["vermillion"]}
)  # fmt: skip


def draw_landscapes(dataset: xr.Dataset) -> Figure:
    """Draw the potentials that explain the amplitudes of figures 2 and 3.

    Parameters
    ----------
    dataset
        As :func:`remanent.plots.landscape` takes it: ``potential`` (prestress,
        temperature, thickness_stretch); ``equilibrium_stretch``,
        ``equilibrium_potential``, ``stability`` (prestress, temperature, equilibrium);
        ``level``, ``turning_lower``, ``turning_upper`` (prestress, temperature).

    Returns
    -------
    matplotlib.figure.Figure
        One panel per prestress.
    """
    first = dataset.isel(prestress=0)
    drawn = ("potential", "level", "turning_lower", "turning_upper")
    members = ensemble.split_into_members(first, drawn, ("thickness_stretch",))
    entries = [
        *keys.line_legend_entries(members),
        *energy.equilibrium_legend_entries(dataset),
        *energy.level_legend_entries(members),
    ]
    return draw_panel_per_prestress(
        dataset, plots.landscape, (style.DOUBLE_COLUMN_WIDTH_INCHES, 3.4), entries
    )


def draw_solver_comparison(sections: xr.Dataset, drift: xr.Dataset) -> Figure:
    """Draw Poincaré sections converged and at the published tolerance, side by side.

    Parameters
    ----------
    sections
        ``thickness_stretch`` and ``thickness_stretch_rate`` (solver, prestress,
        temperature, period), with two solvers named by the string coordinate
        ``solver``, the converged one first, and the coordinate ``omega`` (prestress).
    drift
        ``energy_drift``, the energy minus its first value under constant load
        (solver, prestress, temperature, time), with the same solvers.

    Returns
    -------
    matplotlib.figure.Figure
        One row per temperature; for each prestress a pair of panels on one scale, with the
        converged section in grey behind the other; below, the size of the energy drift.
    """
    rows, columns = sections.sizes["temperature"], 2 * sections.sizes["prestress"]
    with style.context():
        figure = Figure(
            figsize=(style.DOUBLE_COLUMN_WIDTH_INCHES, 1.5 * rows + 2.4), layout="constrained"
        )
        grid = GridSpec(rows + 1, columns, figure, height_ratios=[1.0] * rows + [1.05])
        for row, column in product(range(rows), range(columns // 2)):
            _draw_section_pair(
                figure, grid, sections.isel(temperature=row, prestress=column), row, column
            )
        first = figure.add_subplot(grid[rows, :2])
        below = [first]
        for k in range(1, columns // 2):
            below.append(figure.add_subplot(grid[rows, 2 * k : 2 * k + 2], sharey=first))
        _draw_drifts(below, drift)
        for k, axes in enumerate(below):
            _write_letter(axes, rows * columns + k)
        members = ensemble.split_into_members(drift.isel(prestress=0), ("energy_drift",), ("time",))
        behind = Line2D([], [], color=_BACKGROUND_COLOUR, linestyle="", marker="o", ms=3,
                        label=f"{sections['solver'].values[0]}, behind the other")  # fmt: skip
        style.add_legend_above(figure, [*keys.line_legend_entries(members), behind])
        footer.add_footer(figure, sections)
    return figure


def draw_misfit_maps(dataset: xr.Dataset) -> Figure:
    """Draw how well each unstated choice brings back the six published resonances.

    Parameters
    ----------
    dataset
        ``misfit`` (law, window, reference_temperature, b), the largest difference from
        the published frequencies; ``law`` holds strings (mathtext is set as such).

    Returns
    -------
    matplotlib.figure.Figure
        One row per law, one column per window (laws side by side for a single window), all on
        one logarithmic scale.  Every cell is one choice, too few for contour lines: dots mark
        those that agree, a larger one the least misfit, whose value is written.
    """
    laws, windows = dataset["law"].values, dataset["window"].values
    finite = dataset["misfit"].values[np.isfinite(dataset["misfit"].values)]
    largest = min(float(finite.max()), _LARGEST_SHOWN_MISFIT)
    scale = LogNorm(float(max(finite.min(), 1e-4)), largest)
    with style.context():
        shape = (len(laws), len(windows)) if len(windows) > 1 else (1, len(laws))
        size = (style.DOUBLE_COLUMN_WIDTH_INCHES, 1.9 * shape[0] + 0.9)
        figure, grid = make_panel_grid(*shape, size, sharex=True, sharey=True)
        cases = product(enumerate(laws), enumerate(windows))
        for k, (axes, ((i, law), (j, window))) in enumerate(zip(grid.flat, cases, strict=True)):
            drawn = _draw_misfit(axes, dataset.isel(law=i, window=j), scale)
            title = f"{law},  {style.value_label(dataset['window'], window)}"
            style.set_panel_title(axes, "abcdefghijklmnopqrstuvwxyz"[k], title)
        keep_only_outer_labels(grid, x=True, y=True)
        beyond = "max" if finite.max() > largest else "neither"
        name = style.axis_label(dataset["misfit"])
        figure.colorbar(drawn, ax=grid, label=name, aspect=40, extend=beyond)
        style.add_legend_above(
            figure,
            [
                Line2D([], [], label=f"agrees within {MAX_RESONANCE_MISFIT:g}", **_AGREEING_LOOKS),
                Line2D([], [], label="least misfit", **_LEAST_LOOKS),
            ],
        )
        footer.add_footer(figure, dataset, hide=("drive", "temperature", "prestress"))
    return figure


def _draw_section_pair(
    figure: Figure, grid: GridSpec, dataset: xr.Dataset, row: int, column: int
) -> None:
    """Draw one section by both solvers, on the same scale."""
    first = figure.add_subplot(grid[row, 2 * column])
    second = figure.add_subplot(grid[row, 2 * column + 1], sharex=first, sharey=first)
    last = row == grid.nrows - 2
    temperature = style.value_label(dataset["temperature"], dataset["temperature"].item())
    rate = style.axis_label(dataset["thickness_stretch_rate"], words=False)
    plots.section(dataset.isel(solver=0), ax=second, color=_BACKGROUND_COLOUR)
    for k, ax in enumerate((first, second)):
        plots.section(dataset.isel(solver=k), ax=ax)
        ax.set(xlabel=style.axis_label(dataset["thickness_stretch"], words=False) if last else "")
        ax.set(ylabel=(f"{temperature}\n{rate}" if column == 0 else rate) if k == 0 else "")
        ax.tick_params(labelleft=k == 0, labelsize=6.5)
        _write_letter(ax, row * grid.ncols + 2 * column + k)
    if row == 0:
        coordinates = [dataset[n] for n in ("prestress", "omega") if n in dataset.coords]
        case = ", ".join(style.value_label(value, value.item()) for value in coordinates)
        first.set_title(f"{case}\n{dataset['solver'].values[0]}")
        second.set_title(f"\n{dataset['solver'].values[1]}")


def _write_letter(ax: Axes, number: int) -> None:
    """Write the letter of a panel in its corner."""
    ax.text(0.03, 0.97, f"({'abcdefghijklmnopqrstuvwxyz'[number]})", transform=ax.transAxes,
            va="top", fontsize=7.0)  # fmt: skip


def _draw_drifts(below: Sequence[Axes], drift: xr.Dataset) -> None:
    """Draw the size of the energy drift on logarithmic axes, one panel per prestress."""
    signed = drift["energy_drift"]
    sizes = np.where(signed.values != 0.0, np.abs(signed.values), np.nan)  # no size at the start
    drawn = drift.assign(energy_drift=signed.copy(data=sizes))
    for k, ax in enumerate(below):
        plots.history(drawn.isel(prestress=k), "energy_drift", ax=ax, legend=False, linewidth=0.7)
        value = drift["prestress"].values[k]
        ax.set_title(f"constant load, {style.value_label(drift['prestress'], value)}")
        symbol = style.math_symbol(drift["energy_drift"]).strip("$")
        ax.set(
            yscale="log", xlim=(0.0, None), ylabel=rf"energy drift, $|{symbol}|$" if k == 0 else ""
        )


def _draw_misfit(ax: Axes, dataset: xr.Dataset, scale: LogNorm) -> Any:
    x, y = dataset["reference_temperature"], dataset["b"]
    z = dataset["misfit"].transpose("b", "reference_temperature").values
    drawn = ax.pcolormesh(
        x.values, y.values, z, norm=scale, cmap="cividis_r", shading="nearest", rasterized=True
    )
    rows, columns = np.nonzero(z <= MAX_RESONANCE_MISFIT)
    ax.plot(x.values[columns], y.values[rows], **_AGREEING_LOOKS)
    i, j = np.unravel_index(np.nanargmin(z), z.shape)
    ax.plot(x.values[j], y.values[i], **_LEAST_LOOKS)
    ground = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.5}
    ax.text(0.03, 0.04, f"least {z[i, j]:.2g}", transform=ax.transAxes, bbox=ground)
    ax.set(xlabel=style.axis_label(x), ylabel=style.axis_label(y))
    return drawn
