"""Basins: to which attractor initial states belong, or, undamped, which islands they are on."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

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

#: Basins are this much paler than the marks of their attractors.
_PALE = 0.45


def basins(
    dataset: xr.Dataset, *, ax: Axes | None = None, legend: bool = True, **mesh: Any
) -> QuadMesh:
    """Draw basins of attraction or, without dissipation, islands.

    Parameters
    ----------
    dataset
        A result of ``basins`` over two state variables; the first runs to the right.  With
        ``basin`` each attractor has a colour, its point a mark, and the legend its share of
        the initial states; initial states of no known attractor are grey.  Without, cells
        are shaded as by :func:`remanent.plots.map`: tori by their rotation number, chaos by
        its exponent.
    ax
        Axes to draw in; a new figure, with its footer, if None.
    legend
        Whether to name attractors, or to draw colour bars.
    **mesh
        Passed to matplotlib's ``pcolormesh``.

    Returns
    -------
    matplotlib.collections.QuadMesh
    """
    across, down = _plane(dataset)
    upright = dataset.transpose(down, across, ...)
    if "basin" not in dataset:
        return maps.map(upright, ax=ax, legend=legend, **mesh)
    with style.context():
        axes = style.owned_axes(ax, width=style.SINGLE, height=3.1)
        x, y = dataset[across], dataset[down]
        looks = {"shading": "nearest", "rasterized": True, **mesh}
        artist = axes.pcolormesh(x.values, y.values, _painted(upright), **looks)
        _marked(axes, dataset, across, down)
        axes.set(xlabel=style.label(x), ylabel=style.label(y))
        if legend:
            style.legend_above(axes, _entries(dataset))
        if ax is None:
            footer.add(axes.get_figure(root=True), dataset)  # type: ignore[arg-type]
    return artist


def _plane(dataset: xr.Dataset) -> tuple[Hashable, Hashable]:
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


def _colours(count: int) -> FloatArray:
    wheel = [to_rgb(tone) for tone in style.OKABE_ITO.values()]
    if count <= len(wheel):
        return np.array(wheel[:count]).reshape(count, 3)
    return np.asarray(colormaps["turbo"](np.linspace(0.05, 0.95, count)))[:, :3]


def _painted(dataset: xr.Dataset) -> FloatArray:
    """Colours of every cell, array (y, x, 3)."""
    basin = dataset["basin"].values
    tones = 1.0 - _PALE * (1.0 - _colours(dataset.sizes["attractor"]))
    unknown = np.array([to_rgb(maps.UNDECIDED)])
    return np.asarray(np.concatenate([tones, unknown])[basin])


def _marked(axes: Axes, dataset: xr.Dataset, across: Hashable, down: Hashable) -> None:
    """A point of each attractor, within the grid."""
    box = axes.get_xlim(), axes.get_ylim()
    points = dataset["attractor_state"].transpose("attractor", "state")
    names = points["state"].values.tolist()
    x, y = (points.values[:, names.index(name)] for name in (across, down))
    for k, tone in enumerate(_colours(len(x))):
        axes.plot(x[k], y[k], "o", ms=5.0, color=tone, mec="white", mew=0.9, zorder=5)
    axes.set(xlim=box[0], ylim=box[1])


def _entries(dataset: xr.Dataset) -> list[Artist]:
    """Legend entries: what each attractor is, and its share."""
    tones = _colours(dataset.sizes["attractor"])
    found: list[Artist] = [
        Patch(color=tone, label=_said(dataset.isel(attractor=k))) for k, tone in enumerate(tones)
    ]
    if (dataset["basin"].values < 0).any():
        found.append(Patch(color=maps.UNDECIDED, label="undecided or escaped"))
    return found


def _said(attractor: xr.Dataset) -> str:
    kind, period = str(attractor["attractor_regime"].values), int(attractor["attractor_period"])
    name = f"period {period}" if kind == "periodic" else kind
    share, error = (100.0 * float(attractor[n]) for n in ("fraction", "fraction_error"))
    return f"{name}: {share:.1f} ± {error:.1f} %"
