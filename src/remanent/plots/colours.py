"""Colours with meanings: temperatures, ordered numbers, words, regimes.

Temperature is drawn on one sequential map everywhere: *plasma* from its dark end to
where a thin line still has a contrast of 3 with white.  It is perceptually uniform and its
lightness only rises, so the order survives a grey print and every common colour vision; it
runs from blue to orange, so cold looks cold and hot looks hot.  The scale is the same in
every figure (240 K to 410 K, wider where the data need it), so that a colour means a
temperature and not a place in a legend.

Other numbers, from three values on, take *viridis*, cut in the same way.  Words take the
colours of Okabe and Ito (2008), of which sky is darkened for lines on white, and purple and
orange, which becomes a brown, differ from green and vermillion for every reader; words are told
apart by line style, marker or letter too.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from types import MappingProxyType
from typing import Final

import matplotlib as mpl
import numpy as np
from matplotlib.colors import Colormap, LinearSegmentedColormap, LogNorm, Normalize, to_rgb

__all__ = [
    "BOUNDARY_COLOUR",
    "CHAOS_COLOUR_MAP",
    "ESCAPED_COLOUR",
    "MAX_NAMED_NUMBER_COUNT",
    "OKABE_ITO_COLOURS",
    "PERIOD_COLOURS",
    "TORUS_COLOUR_MAP",
    "UNDECIDED_COLOUR",
    "category_colours",
    "is_ground_dark",
    "number_colour_map",
    "number_colours",
    "number_scale",
    "temperature_colour_map",
    "temperature_colours",
    "temperature_scale",
]

_Rgba = tuple[float, ...]

#: Colours of words, after Okabe and Ito, without yellow (too light for lines on white).
OKABE_ITO_COLOURS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "blue": "#0072B2",
        "vermillion": "#D55E00",
        "green": "#009E73",
        "purple": "#C478AC",
        "brown": "#8C5A00",
        "sky": "#2F8FD0",
        "black": "#000000",
    }
)
#: Matplotlib's colour map of temperature.
_TEMPERATURE_COLOUR_MAP: Final = "plasma"
#: Part of that map that is used, up to a contrast of 3 with white.
_TEMPERATURE_COLOUR_MAP_RANGE: Final = (0.03, 0.64)
#: Temperatures at its ends, K, so that a colour means a temperature in every figure.
_TEMPERATURE_SCALE_KELVIN: Final = (240.0, 410.0)
#: Temperatures that differ by less, K, are told apart on a scale of their own.
_MIN_TEMPERATURE_SPREAD_KELVIN: Final = 40.0
#: Matplotlib's colour map of other numbers.
_NUMBER_COLOUR_MAP: Final = "viridis"
#: Part of that map that is used, up to a contrast of 3 with white.
_NUMBER_COLOUR_MAP_RANGE: Final = (0.0, 0.6)
#: Part of either map that is used on a dark ground, where its dark end could not be seen.
_DARK_GROUND_RANGE: Final = (0.4, 1.0)
#: Mean of red, green and blue below which a ground is dark.
_DARK_GROUND_BRIGHTNESS: Final = 0.35
#: Number of colours in a map that is cut from another one.
_MAP_COLOUR_COUNT: Final = 256
#: Most numbers that are named one by one; of more, neighbours differ by less than 10 in lightness,
#: and get a colour bar.
MAX_NAMED_NUMBER_COUNT: Final = 4
#: Ratio of the largest to the smallest number from which a scale is logarithmic.
_MIN_LOGARITHMIC_RATIO: Final = 30.0

#: Colours of periodic motion by its period, 1 to 6, and longer.  Found by a search: of any two,
#: also of one of them and chaos or a torus, the distance is at least 20 (CIE 1976) to a reader
#: with deuteranopia, and lightness changes by at least 10 from each period to the next.
PERIOD_COLOURS: Final = (
    "#f6f3ea",
    "#d8c78c",
    "#4269d1",
    "#5fa779",
    "#8a4462",
    "#2b1b8d",
    "#c6a6f6",
)
#: Colours of chaos by its exponent, from 0 to the largest.
CHAOS_COLOUR_MAP: Final = LinearSegmentedColormap.from_list(
    "remanent.chaos", ["#7a0012", "#c4241c", "#f2701d", "#ffc21a"]
)
#: Colours of tori by their rotation number, from 0 to one half.
TORUS_COLOUR_MAP: Final = LinearSegmentedColormap.from_list(
    "remanent.torus", ["#0b1c3a", "#1a547d", "#45a0a5", "#8cc8c4"]
)
#: Colour under the hatching of motion whose regime is not decided.
UNDECIDED_COLOUR: Final = "#9a9a9a"
#: Colour of lines between cells.
BOUNDARY_COLOUR: Final = "#303030"
#: Colour of motion that left every bound.
ESCAPED_COLOUR: Final = "#101018"


def temperature_colours(temperatures: Iterable[float]) -> list[_Rgba]:
    """Colour each temperature on the one map.

    Parameters
    ----------
    temperatures : iterable of float
        In kelvin, in any order.

    Returns
    -------
    list of RGBA
        Lightness rises with temperature.
    """
    values = list(temperatures)
    scale, colours = temperature_scale(values), temperature_colour_map()
    return [tuple(map(float, colours(float(scale(t))))) for t in values]


def temperature_colour_map() -> Colormap:
    """The colour map of temperature, from the cold end of its scale to the hot one."""
    part = _DARK_GROUND_RANGE if is_ground_dark() else _TEMPERATURE_COLOUR_MAP_RANGE
    return _cut_colour_map(_TEMPERATURE_COLOUR_MAP, part)


def temperature_scale(temperatures: Sequence[float]) -> Normalize:
    """The scale of temperature in a figure: the usual one wherever it tells the values apart.

    Parameters
    ----------
    temperatures : sequence of float
        In kelvin; NaN are passed over.

    Returns
    -------
    matplotlib.colors.Normalize
    """
    finite = np.asarray(temperatures, dtype=np.float64)
    finite = finite[np.isfinite(finite)]
    low, high = _TEMPERATURE_SCALE_KELVIN
    if finite.size == 0:
        return Normalize(low, high)
    first, last = float(finite.min()), float(finite.max())
    inside = low <= first and last <= high
    if inside and 0.0 < last - first < _MIN_TEMPERATURE_SPREAD_KELVIN:
        return Normalize(first, last)
    return Normalize(min(first, low), max(last, high))


def number_colours(values: Sequence[float]) -> list[_Rgba]:
    """Colour ordered numbers, from dark to light; a few of them evenly, by their rank.

    Parameters
    ----------
    values : sequence of float
        In any order.

    Returns
    -------
    list of RGBA
    """
    colours = number_colour_map()
    if len(values) > MAX_NAMED_NUMBER_COUNT:
        scale = number_scale(values)
        return [tuple(map(float, colours(float(scale(x))))) for x in values]
    ranks = np.argsort(np.argsort(values)).tolist()
    return [tuple(map(float, colours(k / max(len(ranks) - 1, 1)))) for k in ranks]


def number_scale(values: Sequence[float]) -> Normalize:
    """The scale of many numbers: logarithmic where they are positive and span decades.

    Parameters
    ----------
    values : sequence of float
        In any order; NaN are passed over.

    Returns
    -------
    matplotlib.colors.Normalize
    """
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if low > 0.0 and high / low >= _MIN_LOGARITHMIC_RATIO:
        return LogNorm(low, high)
    return Normalize(low, high)


def number_colour_map() -> Colormap:
    """The colour map of ordered numbers other than temperatures, dark to light."""
    part = _DARK_GROUND_RANGE if is_ground_dark() else _NUMBER_COLOUR_MAP_RANGE
    return _cut_colour_map(_NUMBER_COLOUR_MAP, part)


def category_colours(count: int) -> list[str]:
    """Colours of `count` words; they repeat after the seventh, which a second cue must tell.

    Parameters
    ----------
    count : int
        How many words there are.

    Returns
    -------
    list of str
    """
    wheel = list(OKABE_ITO_COLOURS.values())
    if is_ground_dark():
        wheel[-1] = "#ffffff"
    return [wheel[k % len(wheel)] for k in range(count)]


def is_ground_dark() -> bool:
    """Whether the style in force draws on a dark ground."""
    rgb = to_rgb(mpl.rcParams["axes.facecolor"])
    return sum(rgb) / 3.0 < _DARK_GROUND_BRIGHTNESS


def _cut_colour_map(name: str, part: tuple[float, float]) -> Colormap:
    return LinearSegmentedColormap.from_list(
        f"remanent.{name}", mpl.colormaps[name](np.linspace(*part, _MAP_COLOUR_COUNT))
    )
