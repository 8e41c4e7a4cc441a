"""Basins: to which attractor initial states belong, or, undamped, which islands they are on."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, QuadMesh
from matplotlib.colors import to_rgb
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from remanent._errors import InputError
from remanent._typing import BoolArray, FloatArray
from remanent.plots import colours, hatching, maps, style
from remanent.plots.footer import add_legend_and_footer

__all__ = ["basins"]

#: Share of the colour of an attractor that its basin keeps, by turns; the rest is white.
_COLOUR_SHARES: Final = (0.25, 0.6, 0.4, 0.8)
#: What sets letters off from the cells below them.
_WHITE_RIM: Final = withStroke(linewidth=1.6, foreground="white")


def basins(
    dataset: xr.Dataset,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    **mesh: Any,
) -> QuadMesh:
    """Draw basins of attraction or, without dissipation, islands.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``basins`` over two state variables; the first runs to the right.  With
        ``basin`` each attractor has a colour and a letter, its point a mark, and the legend
        its share of the initial states; initial states of no known attractor are hatched.
        Without, cells are shaded as by :func:`remanent.plots.map`: tori by their rotation
        number, chaos by its exponent.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name attractors, or to draw colour bars.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    **mesh : Any
        Passed to matplotlib's ``pcolormesh``.

    Returns
    -------
    matplotlib.collections.QuadMesh
        The coloured cells.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    remanent.basins : The result that is drawn.
    map : A chart over two parameters.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> ds = rm.basins(
    ...     rm.Actuator(dissipation=rm.Rayleigh(0.3)),
    ...     rm.SineSquared(0.4, 1.25),
    ...     {"stretch": [0.9, 1.0, 1.1], "stretch_rate": [0.0, 0.1]},
    ...     periods=200,
    ... )
    >>> rm.plot.basins(ds).get_array().shape[:2]
    (2, 3)
    >>> plt.close()
    """
    across, down = _grid_variables(dataset)
    upright = dataset.transpose(down, across, ...)
    if "basin" not in dataset:
        return maps.draw_map(
            upright, "regime", ax=ax, legend=legend, footer=footer, spread_tori=True, **mesh
        )
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax, width=style.SINGLE_COLUMN_WIDTH_INCHES, height=3.1)
        x, y = dataset[across], dataset[down]
        looks = {"shading": "nearest", "rasterized": True, **mesh}
        artist = axes.pcolormesh(x.values, y.values, _cell_colours(upright), **looks)
        lost = hatching.hatch_cells(axes, x.values, y.values, _lost_cells(upright))
        _draw_boundaries(axes, upright, x.values, y.values)
        _mark_attractors(axes, dataset, across, down)
        style.label_axes(axes, style.axis_label(x), style.axis_label(y))
        entries = [*_legend_entries(dataset), *lost]
        add_legend_and_footer(axes, ax, dataset, entries, legend=legend, footer=footer)
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
    if "basin" in dataset and dataset["basin"].dtype.kind not in "iu":
        raise InputError(
            "dataset",
            must="hold the number of an attractor for each cell",
            got=f"basin of {dataset['basin'].dtype}",
            why="Cells have the colours of their attractors.",
            fix="Pass the result of rm.basins as it is, or convert it: astype(int).",
        )
    if not dataset["regime"].size or ("basin" in dataset and not _has_state(dataset)):
        raise InputError(
            "dataset",
            must="have cells, and each attractor's values of both variables",
            got=", ".join(f"{dim}: {size}" for dim, size in dataset.sizes.items()),
            why="Cells and attractors are drawn in a plane.",
            fix="Select cells by the variables of the grid only.",
        )
    return first, second


def _has_state(dataset: xr.Dataset) -> bool:
    """Whether the state of attractors has both variables of the grid."""
    names = dataset["state"].values.tolist() if "state" in dataset.coords else []
    return set(dataset["regime"].dims) <= set(names)


def _tones(count: int) -> FloatArray:
    """Tones of basins, array (attractor, 3): pale, and each of another lightness than the last."""
    wheel = np.array([to_rgb(tone) for tone in colours.category_colours(count)]).reshape(-1, 3)
    shares = np.resize(_COLOUR_SHARES, count)[:, None]
    return np.asarray(1.0 - shares * (1.0 - wheel))


def _letter(k: int) -> str:
    """A, B … Z, A2, B2 …: what an attractor is called."""
    letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
    return letters[k % 26] + (str(k // 26 + 1) if k >= 26 else "")


def _cell_colours(dataset: xr.Dataset) -> FloatArray:
    """Colours of every cell, array (y, x, 3)."""
    basin = np.asarray(dataset["basin"].values)
    tones = np.concatenate(
        [_tones(dataset.sizes["attractor"]), np.array([to_rgb(colours.UNDECIDED_COLOUR)])]
    )
    return np.asarray(tones[np.where(basin < 0, -1, basin).astype(np.int64)])


def _lost_cells(dataset: xr.Dataset) -> dict[str, BoolArray]:
    """Cells of no known attractor, by the regime of their motion."""
    unknown = np.asarray(dataset["basin"].values) < 0
    words = sorted({str(word) for word in dataset["regime"].values[unknown]} - {""})
    named = {f"undecided: {', '.join(w for w in words if w != 'undecided')}": unknown}
    others = {name.removesuffix(": "): cells for name, cells in named.items()}
    return {name: cells for name, cells in others.items() if cells.any()}


def _draw_boundaries(axes: Axes, dataset: xr.Dataset, x: FloatArray, y: FloatArray) -> None:
    """Thin lines between cells of different basins, which a grey print shows too."""
    basin, right, up = dataset["basin"].values, hatching.edges(x), hatching.edges(y)
    row, column = np.nonzero(np.diff(basin, axis=1))
    lines = [[(right[j + 1], up[i]), (right[j + 1], up[i + 1])]
             for i, j in zip(row, column, strict=True)]  # fmt: skip
    row, column = np.nonzero(np.diff(basin, axis=0))
    lines += [[(right[j], up[i + 1]), (right[j + 1], up[i + 1])]
              for i, j in zip(row, column, strict=True)]  # fmt: skip
    axes.add_collection(
        LineCollection(lines, colors=colours.BOUNDARY_COLOUR, linewidths=0.4, zorder=1.6),
        autolim=False,
    )


def _mark_attractors(axes: Axes, dataset: xr.Dataset, across: Hashable, down: Hashable) -> None:
    """A point of each attractor and its letter, within the grid."""
    box = axes.get_xlim(), axes.get_ylim()
    points = dataset["attractor_state"].transpose("attractor", "state")
    names = points["state"].values.tolist()
    x, y = (points.values[:, names.index(name)] for name in (across, down))
    for k, tone in enumerate(colours.category_colours(len(x))):
        if not np.isfinite([x[k], y[k]]).all():
            continue
        axes.plot(x[k], y[k], "o", ms=4.0, color=tone, mec="white", mew=0.9, zorder=5)
        axes.annotate(
            _letter(k), (x[k], y[k]), xytext=(3.5, 3.5), textcoords="offset points", zorder=6,
            annotation_clip=True, color="black", path_effects=[_WHITE_RIM],
        )  # fmt: skip
    axes.set(xlim=box[0], ylim=box[1])


def _legend_entries(dataset: xr.Dataset) -> list[Artist]:
    """Legend entries: what each attractor is, and its share."""
    tones = _tones(dataset.sizes["attractor"])
    looks: dict[str, Any] = {"edgecolor": colours.BOUNDARY_COLOUR, "linewidth": 0.5}
    return [
        Patch(facecolor=tone, label=f"{_letter(k)}, {_caption(dataset.isel(attractor=k))}", **looks)
        for k, tone in enumerate(tones)
        if np.isfinite(dataset["fraction"].isel(attractor=k))
    ]


def _caption(attractor: xr.Dataset) -> str:
    kind, period = str(attractor["attractor_regime"].values), attractor["attractor_period"]
    name = f"period {int(period)}" if kind == "periodic" else kind
    share, error = (100.0 * float(attractor[n]) for n in ("fraction", "fraction_error"))
    return f"{name}: {share:.1f} ± {error:.1f} %"
