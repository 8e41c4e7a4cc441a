"""Basins: to which attractor initial states belong, or, undamped, which islands they are on."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import to_rgb
from matplotlib.patches import Patch

from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.plots import footer, maps, style

__all__ = ["basins"]

#: Share of the colour of an attractor that its basin keeps; the rest is white.
_ATTRACTOR_COLOUR_SHARE: Final = 0.45


def basins(
    dataset: xr.Dataset, *, ax: Axes | None = None, legend: bool = True, **mesh: Any
) -> QuadMesh:
    """Draw basins of attraction or, without dissipation, islands.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``basins`` over two state variables; the first runs to the right.  With
        ``basin`` each attractor has a colour, its point a mark, and the legend its share of
        the initial states; initial states of no known attractor are grey.  Without, cells
        are shaded as by :func:`remanent.plots.map`: tori by their rotation number, chaos by
        its exponent.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure, with its footer, if None.
    legend : bool
        Whether to name attractors, or to draw colour bars.
    **mesh : Any
        Passed to matplotlib's ``pcolormesh``.

    Returns
    -------
    matplotlib.collections.QuadMesh
    """
    across, down = _grid_variables(dataset)
    upright = dataset.transpose(down, across, ...)
    if "basin" not in dataset:
        return maps.map(upright, ax=ax, legend=legend, **mesh)
    with style.context():
        axes = style.given_or_new_axes(ax, width=style.SINGLE_COLUMN_WIDTH_INCHES, height=3.1)
        x, y = dataset[across], dataset[down]
        looks = {"shading": "nearest", "rasterized": True, **mesh}
        artist = axes.pcolormesh(x.values, y.values, _cell_colours(upright), **looks)
        _mark_attractors(axes, dataset, across, down)
        axes.set(xlabel=style.axis_label(x), ylabel=style.axis_label(y))
        footer.add_legend_and_footer(axes, ax, dataset, _legend_entries(dataset) if legend else [])
    return artist


def _grid_variables(dataset: xr.Dataset) -> tuple[Hashable, Hashable]:
    """The two state variables of the grid."""
    if "regime" not in dataset or dataset["regime"].ndim != 2:
        raise InputError(
            "dataset",
            must="have regimes over two state variables",
            got=", ".join(map(str, dataset.sizes)),
            why="Basins are drawn in a plane.",
            fix="Pass rm.basins(...) of a grid with two variables, or select values of others.",
        )
    first, second = dataset["regime"].dims
    return first, second


def _attractor_colours(count: int) -> FloatArray:
    wheel = [to_rgb(tone) for tone in style.OKABE_ITO_COLOURS.values()]
    if count <= len(wheel):
        return np.array(wheel[:count]).reshape(count, 3)
    return np.asarray(colormaps["turbo"](np.linspace(0.05, 0.95, count)))[:, :3]


def _cell_colours(dataset: xr.Dataset) -> FloatArray:
    """Colours of every cell, array (y, x, 3)."""
    basin = dataset["basin"].values
    tones = 1.0 - _ATTRACTOR_COLOUR_SHARE * (1.0 - _attractor_colours(dataset.sizes["attractor"]))
    unknown = np.array([to_rgb(maps.UNDECIDED_COLOUR)])
    return np.asarray(np.concatenate([tones, unknown])[basin])


def _mark_attractors(axes: Axes, dataset: xr.Dataset, across: Hashable, down: Hashable) -> None:
    """A point of each attractor, within the grid."""
    box = axes.get_xlim(), axes.get_ylim()
    points = dataset["attractor_state"].transpose("attractor", "state")
    names = points["state"].values.tolist()
    x, y = (points.values[:, names.index(name)] for name in (across, down))
    for k, tone in enumerate(_attractor_colours(len(x))):
        axes.plot(x[k], y[k], "o", ms=5.0, color=tone, mec="white", mew=0.9, zorder=5)
    axes.set(xlim=box[0], ylim=box[1])


def _legend_entries(dataset: xr.Dataset) -> list[Artist]:
    """Legend entries: what each attractor is, and its share."""
    tones = _attractor_colours(dataset.sizes["attractor"])
    entries: list[Artist] = [
        Patch(color=tone, label=_attractor_caption(dataset.isel(attractor=k)))
        for k, tone in enumerate(tones)
    ]
    if (dataset["basin"].values < 0).any():
        entries.append(Patch(color=maps.UNDECIDED_COLOUR, label="undecided or escaped"))
    return entries


def _attractor_caption(attractor: xr.Dataset) -> str:
    kind, period = str(attractor["attractor_regime"].values), int(attractor["attractor_period"])
    name = f"period {period}" if kind == "periodic" else kind
    share, error = (100.0 * float(attractor[n]) for n in ("fraction", "fraction_error"))
    return f"{name}: {share:.1f} ± {error:.1f} %"
