"""Charts over two parameters or two initial values: regimes, exponents, any other quantity."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import QuadMesh
from matplotlib.colors import Normalize, to_rgb
from matplotlib.patches import Patch

from remanent._errors import InputError
from remanent._typing import FloatArray, IntArray
from remanent.plots import footer, style

__all__ = ["UNDECIDED", "map"]

UNDECIDED = "#9a9a9a"
#: Regimes of one tone; the others are shaded by what is known of them.
_TONES: Mapping[str, str] = MappingProxyType({"undecided": UNDECIDED, "escaped": "#101018"})
#: Of periodic motion by its period, 1 to 6, and longer.
_PERIODS = ("#f4f1e8", "#e9c46a", "#7fb7a6", "#e07a5f", "#81709c", "#4f8a5b", "#a8546b")
#: Shades: of tori by their rotation number, of chaos by its exponent.
_TORUS, _CHAOS = "cool", "inferno"
_COOL = ((0.04, 0.10, 0.22), (0.10, 0.33, 0.49), (0.27, 0.62, 0.68), (0.80, 0.92, 0.88))


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
    dataset
        A result with two dimensions of ``over``, such as that of ``regime_chart`` or
        ``basins``.
    variable
        ``regime`` is coloured by the period where periodic, and shaded by the exponent where
        chaotic and by the rotation number where quasi-periodic; other texts get a colour each;
        numbers get a colour bar.
    ax
        Axes to draw in; a new figure, with its footer, if None.
    legend
        Whether to draw colour bars and name colours.
    **mesh
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
        axes = style.owned_axes(ax, width=style.SINGLE, height=3.1)
        x, y = dataset[across].values, dataset[down].values
        looks = {"shading": "nearest", "rasterized": True, **mesh}
        if array.dtype.kind in "US":
            colours = _painted(dataset, variable)
            artist = axes.pcolormesh(x, y, colours, **looks)
            if legend:
                _explain(axes, dataset, variable)
        else:
            artist = axes.pcolormesh(x, y, array.values, **{"cmap": "cividis", **looks})
            if legend:
                _bar(axes, artist, style.label(array))
        axes.set(xlabel=style.label(dataset[across]), ylabel=style.label(dataset[down]))
        if ax is None:
            footer.add(axes.get_figure(root=True), dataset)  # type: ignore[arg-type]
    return artist


def _painted(dataset: xr.Dataset, variable: str) -> FloatArray:
    """Colours of every cell, array (y, x, 3)."""
    values = dataset[variable].values
    colours = np.ones((*values.shape, 3))
    if variable != "regime":
        wheel = list(style.OKABE_ITO.values())
        for k, name in enumerate(sorted(set(values.ravel().tolist()))):
            colours[values == name] = to_rgb(wheel[k % len(wheel)])
        return colours
    for name, tone in _TONES.items():
        colours[values == name] = to_rgb(tone)
    regular = {"periodic": _periods(dataset), "quasi-periodic": _tori(dataset)}
    for name, shades in {**regular, "chaotic": _chaos(dataset)}.items():
        chosen = values == name
        colours[chosen] = shades[chosen]
    return colours


def _cool(share: FloatArray) -> FloatArray:
    """Dark blue to pale green, evenly."""
    at = np.linspace(0.0, 1.0, len(_COOL))
    return np.stack([np.interp(share, at, channel) for channel in np.transpose(_COOL)], axis=-1)


def _periods(dataset: xr.Dataset) -> FloatArray:
    """By the period, all alike from one on."""
    tones = np.array([to_rgb(tone) for tone in _PERIODS])
    return np.asarray(tones[_period(dataset).clip(1, len(_PERIODS)) - 1])


def _period(dataset: xr.Dataset) -> IntArray:
    if "period" not in dataset:
        return np.ones(dataset["regime"].shape, dtype=np.int64)
    return np.asarray(dataset["period"].values, dtype=np.int64)


def _tori(dataset: xr.Dataset) -> FloatArray:
    """By the rotation number, folded at one half: turning back and forth are alike."""
    turns = dataset["rotation_number"].values if "rotation_number" in dataset else np.nan
    folded = 2.0 * np.minimum(np.mod(turns, 1.0), 1.0 - np.mod(turns, 1.0))
    shape = dataset["regime"].shape
    return _cool(np.broadcast_to(np.where(np.isfinite(folded), folded, 0.5), shape))


def _chaos(dataset: xr.Dataset) -> FloatArray:
    """By the exponent, up to its largest."""
    exponent = dataset["exponent"].values if "exponent" in dataset else np.ones(())
    shape = dataset["regime"].shape
    share = np.broadcast_to(exponent / _largest(dataset), shape).clip(0.0, 1.0)
    return np.asarray(colormaps[_CHAOS](0.35 + 0.6 * share))[..., :3]


def _largest(dataset: xr.Dataset) -> float:
    if "exponent" not in dataset:
        return 1.0
    found = dataset["exponent"].values[dataset["regime"].values == "chaotic"]
    return float(np.nanmax(found, initial=1e-3))


def _explain(axes: Axes, dataset: xr.Dataset, variable: str) -> None:
    seen = sorted(set(dataset[variable].values.ravel().tolist()))
    if variable != "regime":
        wheel = list(style.OKABE_ITO.values())
        entries = [Patch(color=wheel[k % len(wheel)], label=n) for k, n in enumerate(seen)]
        style.legend_above(axes, entries)
        return
    tones = _seen_periods(dataset) | {n: tone for n, tone in _TONES.items() if n in seen}
    entries = [
        Patch(facecolor=tone, edgecolor=style.FAINT, linewidth=0.5, label=name)
        for name, tone in tones.items()
    ]
    if entries:
        style.legend_above(axes, entries)
    if "chaotic" in seen and "exponent" in dataset:
        scale = ScalarMappable(Normalize(0.0, _largest(dataset)), _part(_CHAOS))
        _bar(axes, scale, "chaotic: exponent $\\Lambda$")
    if "quasi-periodic" in seen and "rotation_number" in dataset:
        scale = ScalarMappable(Normalize(0.0, 0.5), _part(_TORUS))
        _bar(axes, scale, "quasi-periodic: rotation number $\\nu$")


def _seen_periods(dataset: xr.Dataset) -> dict[str, str]:
    """Names and colours of the periods of a chart; of one alone, its regime is the name."""
    found = _period(dataset)[dataset["regime"].values == "periodic"].clip(1, len(_PERIODS))
    periods = [int(k) for k in np.unique(found)]
    if periods == [1]:
        return {"periodic": _PERIODS[0]}
    names = {k: f"period {k}" for k in periods} | {len(_PERIODS): f"period {len(_PERIODS)} up"}
    return {names[k]: _PERIODS[k - 1] for k in periods}


def _part(name: str) -> Any:
    from matplotlib.colors import ListedColormap

    share = np.linspace(0.0, 1.0, 256)
    if name == _TORUS:
        return ListedColormap(_cool(share))
    return ListedColormap(colormaps[name](0.35 + 0.6 * share))


def _bar(axes: Axes, artist: Any, text: str) -> None:
    figure = axes.get_figure(root=True)
    assert figure is not None
    bar = figure.colorbar(artist, ax=axes, fraction=0.05, pad=0.02, aspect=28)
    bar.set_label(text)
    bar.outline.set_linewidth(0.5)
