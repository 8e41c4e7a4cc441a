"""Colours of regimes: periods, tori by their rotation number, chaos by its exponent."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

import numpy as np
import xarray as xr
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_hex, to_rgb

from remanent._typing import FloatArray, IntArray
from remanent.plots import colours
from remanent.plots.labels import axis_label, format_number

__all__ = ["KNOWN_REGIMES", "regime_bars", "regime_colours", "regime_names"]

#: The longest period that has a colour of its own, and longer ones.
_LONGEST_PERIOD: Final = len(colours.PERIOD_COLOURS)
#: Regimes of one colour; the others are shaded by what is known of them.
_UNSHADED_REGIME_COLOURS: Final[Mapping[str, str]] = MappingProxyType(
    {"undecided": colours.UNDECIDED_COLOUR, "escaped": colours.ESCAPED_COLOUR}
)
#: Regimes that have a name and a look here.
KNOWN_REGIMES: Final = frozenset({"periodic", "quasi-periodic", "chaotic", "undecided", "escaped"})
#: Smallest exponent at the bright end of its map, so that noise is not shown as strong chaos.
_MIN_BRIGHTEST_EXPONENT: Final = 1e-3


def regime_colours(dataset: xr.Dataset, *, spread_tori: bool = False) -> FloatArray:
    """Colours of every cell of a chart, array (y, x, 3); white where there is no regime.

    Parameters
    ----------
    dataset : xarray.Dataset
        ``regime`` (y, x), and ``period``, ``exponent`` and ``rotation_number`` where known.
    spread_tori : bool
        Whether rotation numbers of these cells, instead of 0 to one half, take all colours.

    Returns
    -------
    array (y, x, 3) of float
    """
    values = dataset["regime"].values
    cells = np.ones((*values.shape, 3))
    for name, tone in _UNSHADED_REGIME_COLOURS.items():
        cells[values == name] = to_rgb(tone)
    shades = {
        "periodic": _periodic_shades(dataset),
        "quasi-periodic": _quasi_periodic_shades(dataset, spread_tori),
        "chaotic": _chaotic_shades(dataset),
    }
    for name, own in shades.items():
        cells[values == name] = own[values == name]
    return cells


def regime_names(dataset: xr.Dataset) -> dict[str, str]:
    """Names and colours of what has one colour, by name.

    Parameters
    ----------
    dataset : xarray.Dataset
        As for :func:`regime_colours`.

    Returns
    -------
    dict of str to str
    """
    values = dataset["regime"].values
    tones = _colours_by_period_name(dataset)
    if "escaped" in values:
        tones |= {"escaped": colours.ESCAPED_COLOUR}
    if "chaotic" in values and "exponent" not in dataset:
        tones |= {"chaotic": to_hex(colours.CHAOS_COLOUR_MAP(1.0))}
    if "quasi-periodic" in values and "rotation_number" not in dataset:
        tones |= {"quasi-periodic": to_hex(colours.TORUS_COLOUR_MAP(0.5))}
    lone = _lone_exponent(dataset)
    if lone is not None:
        number = format_number(float(f"{lone:.2g}"))
        tones |= {rf"chaotic, $\Lambda = {number}$": to_hex(colours.CHAOS_COLOUR_MAP(1.0))}
    return tones


def regime_bars(
    dataset: xr.Dataset, *, spread_tori: bool = False
) -> list[tuple[ScalarMappable, str]]:
    """Scales and labels of chaos and of tori, where there are any; one exponent needs no scale.

    Parameters
    ----------
    dataset, spread_tori : xarray.Dataset, bool
        As for :func:`regime_colours`.

    Returns
    -------
    list of (matplotlib.cm.ScalarMappable, str)
    """
    values = dataset["regime"].values
    bars = []
    if "chaotic" in values and "exponent" in dataset and _lone_exponent(dataset) is None:
        scale = Normalize(0.0, _largest_chaotic_exponent(dataset))
        source = ScalarMappable(scale, colours.CHAOS_COLOUR_MAP)
        exponent = axis_label(dataset["exponent"], words=False)
        bars.append((source, f"chaotic: exponent, {exponent}"))
    if "quasi-periodic" in values and "rotation_number" in dataset:
        source = ScalarMappable(_torus_scale(dataset, spread_tori), colours.TORUS_COLOUR_MAP)
        bars.append((source, "quasi-periodic: rotation number, $\\nu$"))
    return bars


def _colours_by_period_name(dataset: xr.Dataset) -> dict[str, str]:
    """Names and colours of the periods of a chart; of one alone, its regime is the name."""
    periodic = dataset["regime"].values == "periodic"
    shown = _period_of_each_cell(dataset)[periodic].clip(1, _LONGEST_PERIOD)
    periods = [int(k) for k in np.unique(shown)]
    if periods == [1]:
        return {"periodic": colours.PERIOD_COLOURS[0]}
    names = {k: f"period {k}" for k in periods} | {_LONGEST_PERIOD: f"period {_LONGEST_PERIOD} up"}
    return {names[k]: colours.PERIOD_COLOURS[k - 1] for k in periods}


def _periodic_shades(dataset: xr.Dataset) -> FloatArray:
    """By the period, all alike from one on."""
    tones = np.array([to_rgb(tone) for tone in colours.PERIOD_COLOURS])
    return np.asarray(tones[_period_of_each_cell(dataset).clip(1, _LONGEST_PERIOD) - 1])


def _period_of_each_cell(dataset: xr.Dataset) -> IntArray:
    if "period" not in dataset:
        return np.ones(dataset["regime"].shape, dtype=np.int64)
    return np.asarray(np.nan_to_num(dataset["period"].values), dtype=np.int64)


def _quasi_periodic_shades(dataset: xr.Dataset, spread_tori: bool) -> FloatArray:
    """By the rotation number, folded at one half: turning back and forth are alike."""
    scale = _torus_scale(dataset, spread_tori)
    turns = np.broadcast_to(_folded_turns(dataset), dataset["regime"].shape)
    share = np.where(np.isfinite(turns), scale(turns), 0.5)
    return np.asarray(colours.TORUS_COLOUR_MAP(share))[..., :3]


def _folded_turns(dataset: xr.Dataset) -> FloatArray:
    """Rotation numbers from 0 to one half."""
    turns = dataset["rotation_number"].values if "rotation_number" in dataset else np.nan
    return np.asarray(np.minimum(np.mod(turns, 1.0), 1.0 - np.mod(turns, 1.0)))


def _torus_scale(dataset: xr.Dataset, spread_tori: bool) -> Normalize:
    """From 0 to one half, or by the data."""
    turns = np.broadcast_to(_folded_turns(dataset), dataset["regime"].shape)
    found = turns[(dataset["regime"].values == "quasi-periodic") & np.isfinite(turns)]
    if not spread_tori or found.size == 0 or np.ptp(found) == 0.0:
        return Normalize(0.0, 0.5)
    return Normalize(float(found.min()), float(found.max()))


def _chaotic_shades(dataset: xr.Dataset) -> FloatArray:
    """By the exponent, up to its largest."""
    exponent = dataset["exponent"].values if "exponent" in dataset else np.ones(())
    shape = dataset["regime"].shape
    share = np.broadcast_to(exponent / _largest_chaotic_exponent(dataset), shape)
    return np.asarray(colours.CHAOS_COLOUR_MAP(np.nan_to_num(share).clip(0.0, 1.0)))[..., :3]


def _lone_exponent(dataset: xr.Dataset) -> float | None:
    """The exponent of chaotic cells where all have the same; None where there is none."""
    if "exponent" not in dataset:
        return None
    exponents = np.unique(dataset["exponent"].values[dataset["regime"].values == "chaotic"])
    is_lone = exponents.size == 1 and exponents[0] >= _MIN_BRIGHTEST_EXPONENT
    return float(exponents[0]) if is_lone else None


def _largest_chaotic_exponent(dataset: xr.Dataset) -> float:
    if "exponent" not in dataset:
        return 1.0
    exponents = dataset["exponent"].values[dataset["regime"].values == "chaotic"]
    return float(np.nanmax(exponents, initial=_MIN_BRIGHTEST_EXPONENT))
