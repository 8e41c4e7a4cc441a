"""The house style: colours, sizes, fonts, axis labels, saving.  Nothing global is changed.

Temperature is drawn on one sequential map everywhere: *plasma* from its dark end to
three quarters.  It is perceptually uniform and its lightness only rises, so the order
survives a grey print and every common colour vision; it runs from blue to orange, so
cold looks cold and hot looks hot; and the cut keeps its lightest tone readable on white.
The scale is the same in every figure (240 K to 410 K, wider where the data need it),
so that a colour means a temperature and not a place in a legend.

Everything else that is a choice among few takes the colours of Okabe and Ito (2008).
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import matplotlib as mpl
import numpy as np
import xarray as xr
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from remanent._errors import InputError
from remanent.results.schema import describe

__all__ = [
    "DOUBLE_COLUMN_WIDTH_INCHES",
    "OKABE_ITO_COLOURS",
    "SINGLE_COLUMN_WIDTH_INCHES",
    "axis_label",
    "context",
    "given_or_new_axes",
    "math_symbol",
    "save_figure",
    "temperature_colours",
    "value_label",
]

#: Width of a journal's single column, in inches (89 mm).
SINGLE_COLUMN_WIDTH_INCHES: Final = 3.5
#: Width of a journal's double column, in inches (183 mm).
DOUBLE_COLUMN_WIDTH_INCHES: Final = 7.2

#: Okabe and Ito's colours, without yellow (too light for lines on white).
OKABE_ITO_COLOURS: Final[Mapping[str, str]] = MappingProxyType(
    {
        "blue": "#0072B2",
        "vermillion": "#D55E00",
        "green": "#009E73",
        "purple": "#CC79A7",
        "orange": "#E69F00",
        "sky": "#56B4E9",
        "black": "#000000",
    }
)

#: Line styles for a second dimension of an ensemble; solid first.
LINE_STYLES: Final = ("-", (0, (4, 1.6)), (0, (1, 1.2)), (0, (5, 1.4, 1, 1.4)))
#: Markers for the same.
MARKERS: Final = ("o", "D", "s", "^")
#: Colour of text, axes and what belongs to no member.
INK_COLOUR: Final = "#1a1a1a"
#: Colour of what is read last: the footer, lines of reference.
FAINT_COLOUR: Final = "#767676"

#: Width of a letter in a legend, in points.
_LEGEND_LETTER_WIDTH_POINTS: Final = 3.6
#: Width of a sample with its space in a legend, in points.
_LEGEND_SAMPLE_WIDTH_POINTS: Final = 24.0
#: Matplotlib's colour map of temperature.
_TEMPERATURE_COLOUR_MAP: Final = "plasma"
#: Part of that map that is used, from its dark end to the lightest tone readable on white.
_TEMPERATURE_COLOUR_MAP_RANGE: Final = (0.03, 0.76)
#: Temperatures at its ends, K, so that a colour means a temperature in every figure.
_TEMPERATURE_SCALE_KELVIN: Final = (240.0, 410.0)
#: Temperatures that differ by less, K, are told apart on a scale of their own.
_MIN_TEMPERATURE_SPREAD_KELVIN: Final = 40.0

#: Matplotlib's settings of the house style.
_MATPLOTLIB_SETTINGS: Final[Mapping[str, Any]] = MappingProxyType(
    {
        "font.family": "STIXGeneral",
        "mathtext.fontset": "stix",
        "font.size": 8.5,
        "axes.labelsize": 8.5,
        "axes.titlesize": 8.5,
        "xtick.labelsize": 7.5,
        "ytick.labelsize": 7.5,
        "legend.fontsize": 8.0,
        "legend.frameon": False,
        "legend.handlelength": 1.7,
        "legend.columnspacing": 1.4,
        "axes.linewidth": 0.6,
        "axes.edgecolor": INK_COLOUR,
        "axes.labelcolor": INK_COLOUR,
        "axes.titlelocation": "left",
        "axes.titlepad": 4.0,
        "axes.unicode_minus": True,
        "axes.formatter.useoffset": False,
        "text.color": INK_COLOUR,
        "xtick.color": INK_COLOUR,
        "ytick.color": INK_COLOUR,
        "xtick.direction": "in",
        "ytick.direction": "in",
        "xtick.top": True,
        "ytick.right": True,
        "xtick.major.width": 0.6,
        "ytick.major.width": 0.6,
        "xtick.major.size": 3.0,
        "ytick.major.size": 3.0,
        "lines.linewidth": 1.0,
        "lines.solid_capstyle": "round",
        "lines.solid_joinstyle": "round",
        "figure.dpi": 150,
        "savefig.dpi": 200,
        "savefig.bbox": None,
        "figure.facecolor": "white",
        "axes.facecolor": "white",
        "svg.fonttype": "path",
        "svg.hashsalt": "remanent",
        "pdf.fonttype": 42,
    }
)


def context() -> AbstractContextManager[None]:
    """Apply the house style inside a ``with`` block, and nowhere else.

    Examples
    --------
    >>> import matplotlib as mpl
    >>> before = mpl.rcParams["xtick.direction"]
    >>> with context():
    ...     inside = mpl.rcParams["xtick.direction"]
    >>> inside, mpl.rcParams["xtick.direction"] == before
    ('in', True)
    """
    return mpl.rc_context(dict(_MATPLOTLIB_SETTINGS))  # type: ignore[arg-type]  # keys are checked when set


def given_or_new_axes(
    ax: Axes | None, *, width: float = SINGLE_COLUMN_WIDTH_INCHES, height: float = 2.6
) -> Axes:
    """Return `ax`, or the axes of a new figure where it is None.

    Parameters
    ----------
    ax : matplotlib.axes.Axes or None
        Axes to draw in; None makes a figure known to pyplot, so that a notebook shows it.
    width, height : float
        Size of a new figure in inches.

    Returns
    -------
    matplotlib.axes.Axes
    """
    if ax is not None:
        return ax
    from matplotlib import pyplot as plt

    return plt.figure(figsize=(width, height), layout="constrained").add_subplot()


def axis_label(array: xr.DataArray | xr.Variable, *, words: bool = True) -> str:
    """Return the text of an axis: meaning, symbol and, where it has one, unit.

    Parameters
    ----------
    array : xarray.DataArray or xarray.Variable
        A variable with the attributes of the schema; those that arithmetic dropped are
        looked up by its name.
    words : bool
        Whether the meaning is spelt out before the symbol.

    Returns
    -------
    str

    Examples
    --------
    >>> import xarray as xr
    >>> attrs = {"units": "ms", "long_name": "time", "symbol": "t"}
    >>> axis_label(xr.Variable((), 0.0, attrs))
    'time, $t$ (ms)'
    """
    sign = math_symbol(array)
    name = _schema_attribute(array, "long_name")
    text = ", ".join(filter(None, (name, sign))) if words else sign or name
    units = _typeset_units(array)
    return f"{text} ({units})" if units else text


def math_symbol(array: xr.DataArray | xr.Variable) -> str:
    """Return the symbol between dollar signs; empty where there is none.

    Examples
    --------
    >>> import xarray as xr
    >>> math_symbol(xr.DataArray(0.0, name="b"))
    '$b$'
    """
    text = _schema_attribute(array, "symbol")
    return f"${text}$" if text else ""


def value_label(array: xr.DataArray | xr.Variable, value: object) -> str:
    """Return ``symbol = value unit``, for legends and panels.

    Examples
    --------
    >>> import xarray as xr
    >>> value_label(xr.Variable((), 0.0, {"units": "K", "symbol": "T", "long_name": ""}), 250.0)
    '$T = 250$ K'
    """
    if isinstance(value, str):
        return value
    units = _typeset_units(array)
    text = f"${_schema_attribute(array, 'symbol')} = {format_number(value)}$"
    return f"{text} {units}" if units else text


def format_number(value: object) -> str:
    """Format a number for mathtext, in at most six digits and without ``e``."""
    text = f"{float(value):.6g}"  # type: ignore[arg-type]
    mantissa, _, exponent = text.partition("e")
    if not exponent:
        return mantissa
    power = f"10^{{{int(exponent)}}}"
    return power if mantissa == "1" else rf"{mantissa}\times {power}"


def temperature_colours(temperatures: Iterable[float]) -> list[tuple[float, ...]]:
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
    values, (low, high) = list(temperatures), _TEMPERATURE_COLOUR_MAP_RANGE
    scale, colours = _temperature_normalisation(values), mpl.colormaps[_TEMPERATURE_COLOUR_MAP]
    return [tuple(map(float, colours(low + (high - low) * float(scale(t))))) for t in values]


def save_figure(figure: Figure, path: str | os.PathLike[str]) -> Path:
    """Write a figure, the same bytes for the same figure.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        A finished figure.
    path : str or path
        File whose suffix says the format: ``.svg``, ``.png`` or ``.pdf``.

    Returns
    -------
    pathlib.Path
    """
    path = Path(path)
    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None, "ModDate": None}}
    with context():
        figure.savefig(path, metadata=undated.get(path.suffix))
    return path


def set_panel_title(ax: Axes, letter: str, text: str) -> None:
    """Write ``(a)  text`` above the upper left corner of a panel."""
    ax.set_title(f"({letter})  {text}" if letter else text, loc="left")


def add_legend_above(owner: Axes | Figure, entries: Sequence[Artist]) -> None:
    """Put a legend above the axes or the figure, where it cannot hide data."""
    if len(entries) < 2:
        return
    columns = _legend_column_count(owner, [str(entry.get_label()) for entry in entries])
    # Matplotlib fills columns; readers read rows.
    rows = [entry for first in range(columns) for entry in entries[first::columns]]
    if isinstance(owner, Axes):
        owner.legend(
            handles=rows, ncols=columns, loc="lower left", bbox_to_anchor=(0.0, 1.0),
            borderaxespad=0.2,
        )  # fmt: skip
    else:
        owner.legend(handles=rows, ncols=columns, loc="outside upper center")


def _legend_column_count(owner: Axes | Figure, names: Sequence[str]) -> int:
    """How many entries fit side by side, by the length of the longest name."""
    figure = owner if isinstance(owner, Figure) else owner.get_figure(root=True)
    inches = figure.get_figwidth() if figure is not None else SINGLE_COLUMN_WIDTH_INCHES
    width = 72.0 * inches * (owner.get_position().width if isinstance(owner, Axes) else 1.0)
    letters = max(len(re.sub(r"\\[A-Za-z]+", "x", re.sub(r"[$^_{}]", "", name))) for name in names)
    return min(
        len(names),
        max(1, int(width / (_LEGEND_LETTER_WIDTH_POINTS * letters + _LEGEND_SAMPLE_WIDTH_POINTS))),
    )


def _schema_attribute(array: xr.DataArray | xr.Variable, key: str) -> str:
    """An attribute of a variable; where it is missing, that of the schema, or the name."""
    if key in array.attrs:
        return str(array.attrs[key])
    name = getattr(array, "name", None)
    if name is None:
        return ""
    try:
        return describe(str(name)).attributes()[key]
    except InputError:  # a variable of the user's own
        return str(name).replace("_", " ") if key == "long_name" else ""


def _typeset_units(array: xr.DataArray | xr.Variable) -> str:
    """Units in mathtext; nothing where dimensionless (angles are)."""
    units = _schema_attribute(array, "units")
    if units in {"", "1", "rad"}:
        return ""
    return re.sub(r"(?<=[A-Za-z])(-?\d+)", r"$^{\1}$", units)


def _temperature_normalisation(temperatures: Sequence[float]) -> Normalize:
    low, high = float(np.min(temperatures)), float(np.max(temperatures))
    inside = _TEMPERATURE_SCALE_KELVIN[0] <= low and high <= _TEMPERATURE_SCALE_KELVIN[1]
    if inside and (high == low or high - low >= _MIN_TEMPERATURE_SPREAD_KELVIN):
        return Normalize(*_TEMPERATURE_SCALE_KELVIN)
    if inside:
        return Normalize(low, high)
    return Normalize(
        min(low, _TEMPERATURE_SCALE_KELVIN[0]), max(high, _TEMPERATURE_SCALE_KELVIN[1])
    )
