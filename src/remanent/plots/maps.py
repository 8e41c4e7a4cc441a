"""Charts over two parameters or two initial values: regimes, exponents, any other quantity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import BoundaryNorm, ListedColormap, Normalize, to_rgb
from matplotlib.patches import Patch

from remanent._errors import InputError, shortened_repr
from remanent._status import Status
from remanent._typing import BoolArray, FloatArray
from remanent.plots import colour_bars, colours, hatching, missing, regimes, style
from remanent.plots.footer import add_legend_and_footer

__all__ = ["map"]

#: Most whole numbers that get a colour and a tick each.
_MAX_COUNT_COLOURS: Final = 10
#: Matplotlib's colour map of numbers of both signs.
_SIGNED_COLOUR_MAP: Final = "PuOr_r"
#: Share of the numbers of a chart that its scale holds; a few outliers would take all colours.
_SCALE_QUANTILES: Final = (0.01, 0.99)


def map(
    dataset: xr.Dataset,
    variable: str = "regime",
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    **mesh: Any,
) -> QuadMesh:
    """Draw a chart over two parameters.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result with two dimensions of ``over``, such as that of ``regime_chart`` or
        ``basins``.
    variable : str
        ``regime`` is coloured by the period where periodic, and shaded by the exponent where
        chaotic and by the rotation number where quasi-periodic; other texts get a colour each;
        numbers get a colour bar.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to draw colour bars and name colours.
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
    remanent.regime_chart : A chart of regimes.
    basins : The same over initial states.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> ds = rm.regime_chart(
    ...     rm.Actuator(), rm.SineSquared(0.4, 1.25), {"b": [0.2, 0.3], "omega": [1.7, 2.0]}
    ... )
    >>> rm.plot.map(ds).get_array().shape[:2]
    (2, 2)
    >>> plt.close()
    """
    return draw_map(
        dataset, variable, ax=ax, legend=legend, footer=footer, spread_tori=False, **mesh
    )


def _require_plane(dataset: xr.Dataset, variable: str) -> None:
    """Refuse what has another number of dimensions than a chart has axes."""
    planes = [str(name) for name, array in dataset.data_vars.items() if array.ndim == 2]
    if variable not in dataset:
        raise InputError(
            "variable",
            must="be a variable of the dataset with two dimensions",
            got=shortened_repr(variable),
            why="A chart has two axes.",
            fix=f"Name one that has: {', '.join(planes) or 'there is none here'}.",
        )
    dims = [str(dim) for dim in dataset[variable].dims]
    if len(dims) != 2:
        raise InputError(
            "dataset",
            must=f"have {variable} along two dimensions",
            got=f"one with it along {', '.join(dims)}" if dims else "one with a single value of it",
            why="A chart has two axes.",
            fix="Select values of the others first, for example dataset.isel(...)."
            if len(dims) > 2
            else "Vary two fields by over={...: ..., ...: ...}; rm.regime_chart does.",
        )


def draw_map(
    dataset: xr.Dataset,
    variable: str,
    *,
    ax: Axes | None,
    legend: bool,
    footer: bool,
    spread_tori: bool,
    **mesh: Any,
) -> QuadMesh:
    """Draw a chart; `spread_tori` gives its rotation numbers all colours, see :func:`map`."""
    _require_plane(dataset, variable)
    array = dataset[variable]
    down, across = array.dims
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax, width=style.SINGLE_COLUMN_WIDTH_INCHES, height=3.1)
        x, y = dataset[across].values, dataset[down].values
        looks = {"shading": "nearest", "rasterized": True, **mesh}
        entries: list[Patch] = []
        lost = _lost_cells(dataset, array)
        bars: list[_Bar]
        if variable == "regime":
            tones = regimes.regime_colours(dataset, spread_tori=spread_tori)
            artist = axes.pcolormesh(x, y, tones, **looks)
            entries = _colour_entries(regimes.regime_names(dataset))
            scales = regimes.regime_bars(dataset, spread_tori=spread_tori)
            bars = [(source, text, None) for source, text in scales]
        elif array.dtype.kind in "USO":
            words = _word_colours(array.values)
            artist = axes.pcolormesh(x, y, _colours_of_words(array.values, words), **looks)
            entries, bars = _colour_entries(words), []
        else:
            is_zero = _is_within_error(dataset, array)
            artist, bars = _draw_numbers(axes, array, is_zero, looks)
            entries = _entries_of_zero(array, is_zero)
        entries += hatching.hatch_cells(axes, x, y, lost)
        style.label_axes(axes, style.axis_label(dataset[across]), style.axis_label(dataset[down]))
        if legend:
            for source, text, ticks in bars:
                colour_bars.add_colour_bar(axes, source, text, ticks)
        add_legend_and_footer(axes, ax, dataset, entries, legend=legend, footer=footer)
    return artist


#: A colour bar: what it shows, its label and its ticks, None for Matplotlib's.
_Bar = tuple[Any, str, Sequence[float] | None]


def _lost_cells(dataset: xr.Dataset, array: xr.DataArray) -> dict[str, BoolArray]:
    """Cells without an answer by their name, arrays (y, x)."""
    values = array.values
    status = dataset.get("status")
    codes = None if status is None or status.dims != array.dims else status.values
    if array.dtype.kind in "USO":
        empty = (
            ~np.isin(values, list(regimes.KNOWN_REGIMES))
            if array.name == "regime"
            else values == ""
        )
        undecided = (values == "undecided") if array.name == "regime" else np.zeros_like(empty)
    else:
        empty, undecided = ~np.isfinite(values.astype(np.float64)), np.zeros(values.shape, bool)
    named = {"undecided": undecided} | _no_result_cells(np.asarray(empty, dtype=np.bool_), codes)
    if codes is not None:
        early = (codes == int(Status.INCOMPLETE)) & ~empty
        named[Status.INCOMPLETE.meaning] = early
    return {name: cells for name, cells in named.items() if cells.any()}


def _no_result_cells(empty: BoolArray, codes: Any) -> dict[str, BoolArray]:
    """Empty cells, with the words of their status in the name."""
    words = "" if codes is None else missing.status_words(np.ravel(codes[empty]))
    return {f"no result: {words}" if words else "no result": empty}


def _draw_numbers(
    axes: Axes, array: xr.DataArray, is_zero: BoolArray, looks: dict[str, Any]
) -> tuple[QuadMesh, list[_Bar]]:
    """A chart of numbers: counts in steps, signed ones about 0, others in one direction."""
    down, across = array.dims
    x, y = array[across].values, array[down].values
    values = np.ma.masked_invalid(array.values.astype(np.float64))
    text, finite = style.axis_label(array), values.compressed()
    own = {"cmap", "norm", "vmin", "vmax"} & set(looks)
    if own or not finite.size:
        artist = axes.pcolormesh(x, y, values, **{"cmap": "cividis", **looks})
        return artist, [(artist, text, None)] if finite.size else []
    counts = np.unique(finite)
    if counts.size <= _MAX_COUNT_COLOURS and (counts == np.round(counts)).all():
        steps = np.arange(counts[0], counts[-1] + 1.0)
        if steps.size <= _MAX_COUNT_COLOURS:
            norm = BoundaryNorm(np.append(steps, steps[-1] + 1.0) - 0.5, steps.size)
            tones = ListedColormap(colormaps["cividis"](np.linspace(0.0, 1.0, steps.size)))
            artist = axes.pcolormesh(x, y, values, cmap=tones, norm=norm, **looks)
            return artist, [(artist, text, steps.tolist())]
    if finite.min() < 0.0 < finite.max():
        known = values[~is_zero].compressed()
        if known.size == 0:
            artist = axes.pcolormesh(x, y, 0.0 * values, cmap=_SIGNED_COLOUR_MAP,
                                     norm=Normalize(-1.0, 1.0), **looks)  # fmt: skip
            return artist, []
        high = float(np.abs(np.quantile(known, _SCALE_QUANTILES)).max())
        values = np.ma.array(np.where(is_zero, 0.0, values), mask=values.mask)
        scale = Normalize(-high, high)
        artist = axes.pcolormesh(x, y, values, cmap=_SIGNED_COLOUR_MAP, norm=scale, **looks)
    else:
        low, high = (float(v) for v in np.quantile(finite, _SCALE_QUANTILES))
        scale = Normalize(low, high)
        artist = axes.pcolormesh(x, y, values, cmap="cividis", norm=scale, **looks)
    return artist, [(artist, text, None)]


def _is_within_error(dataset: xr.Dataset, array: xr.DataArray) -> BoolArray:
    """Cells of a signed number that is smaller than its error, array (y, x)."""
    error, values = dataset.get(f"{array.name}_error"), array.values
    if error is None or error.dims != array.dims or not ((values < 0) & np.isfinite(values)).any():
        return np.zeros(array.shape, dtype=np.bool_)
    return np.asarray(np.abs(values) < error.values)


def _entries_of_zero(array: xr.DataArray, is_zero: BoolArray) -> list[Patch]:
    """Legend entry of cells whose number is 0 within its error, where there are any."""
    if not is_zero.any():
        return []
    tone = colormaps[_SIGNED_COLOUR_MAP](0.5)
    return _colour_entries({f"{style.math_symbol(array) or array.name} is 0 within error": tone})


def _colours_of_words(values: Any, words: Mapping[str, str]) -> FloatArray:
    """Colours of every cell, array (y, x, 3)."""
    cells = np.ones((*values.shape, 3))
    for name, tone in words.items():
        cells[values == name] = to_rgb(tone)
    return cells


def _word_colours(values: Any) -> dict[str, str]:
    """A colour for each word that occurs."""
    words = sorted(set(values.ravel().astype(str).tolist()) - {""})
    return dict(zip(words, colours.category_colours(len(words)), strict=True))


def _colour_entries(names: Mapping[str, Any]) -> list[Patch]:
    """Legend entries of colours by name."""
    looks: dict[str, Any] = {"edgecolor": style.FAINT_COLOUR, "linewidth": 0.5}
    return [Patch(facecolor=tone, label=name, **looks) for name, tone in names.items()]
