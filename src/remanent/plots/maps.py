"""Charts over two parameters or two initial values: regimes, exponents, any other quantity."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import QuadMesh
from matplotlib.colors import ListedColormap, Normalize, to_rgb
from matplotlib.patches import Patch

from remanent._errors import InputError
from remanent._typing import FloatArray, IntArray
from remanent.plots import footer, style

__all__ = ["UNDECIDED_COLOUR", "map"]

#: Colour of motion whose regime is not decided.
UNDECIDED_COLOUR: Final = "#9a9a9a"
#: Regimes of one colour; the others are shaded by what is known of them.
_UNSHADED_REGIME_COLOURS: Final[Mapping[str, str]] = MappingProxyType(
    {"undecided": UNDECIDED_COLOUR, "escaped": "#101018"}
)
#: Colours of periodic motion by its period, 1 to 6, and longer.
_PERIOD_COLOURS: Final = (
    "#f4f1e8",
    "#e9c46a",
    "#7fb7a6",
    "#e07a5f",
    "#81709c",
    "#4f8a5b",
    "#a8546b",
)
#: Matplotlib's colour map of chaos, by its exponent.
_CHAOS_COLOUR_MAP: Final = "inferno"
#: Share of that map at an exponent of zero: chaos is never as dark as an escape.
_CHAOS_COLOUR_MAP_START: Final = 0.35
#: Share of that map from an exponent of zero to the largest.
_CHAOS_COLOUR_MAP_SPAN: Final = 0.6
#: Smallest exponent at the bright end of that map, so that noise is not shown as strong chaos.
_MIN_BRIGHTEST_EXPONENT: Final = 1e-3
#: Colours of tori by their rotation number, from 0 to one half: red, green and blue channels
#: at evenly spaced places.
_TORUS_COLOUR_STOPS: Final = (
    (0.04, 0.10, 0.22),
    (0.10, 0.33, 0.49),
    (0.27, 0.62, 0.68),
    (0.80, 0.92, 0.88),
)
#: Number of colours in the colour bars of tori and of chaos.
_COLOUR_BAR_COLOUR_COUNT: Final = 256


def map(
    dataset: xr.Dataset,
    variable: str = "regime",
    *,
    ax: Axes | None = None,
    legend: bool = True,
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
        Axes to draw in; a new figure, with its footer, if None.
    legend : bool
        Whether to draw colour bars and name colours.
    **mesh : Any
        Passed to matplotlib's ``pcolormesh``.

    Returns
    -------
    matplotlib.collections.QuadMesh
    """
    if variable not in dataset or dataset[variable].ndim != 2:
        raise InputError(
            "variable",
            must="be a variable of the dataset with two dimensions",
            got=repr(variable),
            why="A chart has two axes.",
            fix="Select values first, for example dataset.isel(...).",
        )
    array = dataset[variable]
    down, across = array.dims
    with style.context():
        axes = style.given_or_new_axes(ax, width=style.SINGLE_COLUMN_WIDTH_INCHES, height=3.1)
        x, y = dataset[across].values, dataset[down].values
        looks = {"shading": "nearest", "rasterized": True, **mesh}
        if array.dtype.kind in "US":
            colours = _cell_colours(dataset, variable)
            artist = axes.pcolormesh(x, y, colours, **looks)
            if legend:
                _add_colour_legend(axes, dataset, variable)
        else:
            artist = axes.pcolormesh(x, y, array.values, **{"cmap": "cividis", **looks})
            if legend:
                _add_colour_bar(axes, artist, style.axis_label(array))
        axes.set(xlabel=style.axis_label(dataset[across]), ylabel=style.axis_label(dataset[down]))
        footer.add_legend_and_footer(axes, ax, dataset)
    return artist


def _cell_colours(dataset: xr.Dataset, variable: str) -> FloatArray:
    """Colours of every cell, array (y, x, 3)."""
    values = dataset[variable].values
    colours = np.ones((*values.shape, 3))
    if variable != "regime":
        wheel = list(style.OKABE_ITO_COLOURS.values())
        for k, name in enumerate(sorted(set(values.ravel().tolist()))):
            colours[values == name] = to_rgb(wheel[k % len(wheel)])
        return colours
    for name, tone in _UNSHADED_REGIME_COLOURS.items():
        colours[values == name] = to_rgb(tone)
    regular = {
        "periodic": _periodic_shades(dataset),
        "quasi-periodic": _quasi_periodic_shades(dataset),
    }
    for name, shades in {**regular, "chaotic": _chaotic_shades(dataset)}.items():
        cells = values == name
        colours[cells] = shades[cells]
    return colours


def _torus_colours(share: FloatArray) -> FloatArray:
    """Dark blue to pale green, evenly."""
    places = np.linspace(0.0, 1.0, len(_TORUS_COLOUR_STOPS))
    channels = np.transpose(_TORUS_COLOUR_STOPS)
    return np.stack([np.interp(share, places, channel) for channel in channels], axis=-1)


def _periodic_shades(dataset: xr.Dataset) -> FloatArray:
    """By the period, all alike from one on."""
    tones = np.array([to_rgb(tone) for tone in _PERIOD_COLOURS])
    return np.asarray(tones[_period_of_each_cell(dataset).clip(1, len(_PERIOD_COLOURS)) - 1])


def _period_of_each_cell(dataset: xr.Dataset) -> IntArray:
    if "period" not in dataset:
        return np.ones(dataset["regime"].shape, dtype=np.int64)
    return np.asarray(dataset["period"].values, dtype=np.int64)


def _quasi_periodic_shades(dataset: xr.Dataset) -> FloatArray:
    """By the rotation number, folded at one half: turning back and forth are alike."""
    turns = dataset["rotation_number"].values if "rotation_number" in dataset else np.nan
    folded = 2.0 * np.minimum(np.mod(turns, 1.0), 1.0 - np.mod(turns, 1.0))
    shape = dataset["regime"].shape
    return _torus_colours(np.broadcast_to(np.where(np.isfinite(folded), folded, 0.5), shape))


def _chaotic_shades(dataset: xr.Dataset) -> FloatArray:
    """By the exponent, up to its largest."""
    exponent = dataset["exponent"].values if "exponent" in dataset else np.ones(())
    shape = dataset["regime"].shape
    share = np.broadcast_to(exponent / _largest_chaotic_exponent(dataset), shape).clip(0.0, 1.0)
    return np.asarray(
        colormaps[_CHAOS_COLOUR_MAP](_CHAOS_COLOUR_MAP_START + _CHAOS_COLOUR_MAP_SPAN * share)
    )[..., :3]


def _largest_chaotic_exponent(dataset: xr.Dataset) -> float:
    if "exponent" not in dataset:
        return 1.0
    exponents = dataset["exponent"].values[dataset["regime"].values == "chaotic"]
    return float(np.nanmax(exponents, initial=_MIN_BRIGHTEST_EXPONENT))


def _add_colour_legend(axes: Axes, dataset: xr.Dataset, variable: str) -> None:
    values = sorted(set(dataset[variable].values.ravel().tolist()))
    if variable != "regime":
        wheel = list(style.OKABE_ITO_COLOURS.values())
        entries = [Patch(color=wheel[k % len(wheel)], label=n) for k, n in enumerate(values)]
        style.add_legend_above(axes, entries)
        return
    plain = {name: colour for name, colour in _UNSHADED_REGIME_COLOURS.items() if name in values}
    entries = [
        Patch(facecolor=colour, edgecolor=style.FAINT_COLOUR, linewidth=0.5, label=name)
        for name, colour in (_colours_by_period_name(dataset) | plain).items()
    ]
    if entries:
        style.add_legend_above(axes, entries)
    if "chaotic" in values and "exponent" in dataset:
        scale = ScalarMappable(
            Normalize(0.0, _largest_chaotic_exponent(dataset)), _chaos_colour_map()
        )
        _add_colour_bar(axes, scale, "chaotic: exponent $\\Lambda$")
    if "quasi-periodic" in values and "rotation_number" in dataset:
        scale = ScalarMappable(Normalize(0.0, 0.5), _torus_colour_map())
        _add_colour_bar(axes, scale, "quasi-periodic: rotation number $\\nu$")


def _colours_by_period_name(dataset: xr.Dataset) -> dict[str, str]:
    """Names and colours of the periods of a chart; of one alone, its regime is the name."""
    shown = _period_of_each_cell(dataset)[dataset["regime"].values == "periodic"].clip(
        1, len(_PERIOD_COLOURS)
    )
    periods = [int(k) for k in np.unique(shown)]
    if periods == [1]:
        return {"periodic": _PERIOD_COLOURS[0]}
    names = {k: f"period {k}" for k in periods} | {
        len(_PERIOD_COLOURS): f"period {len(_PERIOD_COLOURS)} up"
    }
    return {names[k]: _PERIOD_COLOURS[k - 1] for k in periods}


def _torus_colour_map() -> ListedColormap:
    return ListedColormap(_torus_colours(np.linspace(0.0, 1.0, _COLOUR_BAR_COLOUR_COUNT)))


def _chaos_colour_map() -> ListedColormap:
    share = np.linspace(0.0, 1.0, _COLOUR_BAR_COLOUR_COUNT)
    return ListedColormap(
        colormaps[_CHAOS_COLOUR_MAP](_CHAOS_COLOUR_MAP_START + _CHAOS_COLOUR_MAP_SPAN * share)
    )


def _add_colour_bar(axes: Axes, artist: Any, text: str) -> None:
    figure = axes.get_figure(root=True)
    assert figure is not None
    bar = figure.colorbar(artist, ax=axes, fraction=0.05, pad=0.02, aspect=28)
    bar.set_label(text)
    bar.outline.set_linewidth(0.5)
