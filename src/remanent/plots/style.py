"""The house style: sizes, fonts, figures and their files.  Nothing global is changed.

Figures of our own carry the style to whatever call saves them: TrueType fonts, 300 dots per
inch, and 600 for what is drawn as pixels inside a PDF or an SVG.  In axes that were given,
the user's fonts, ground and labels stay.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from types import MappingProxyType
from typing import Any, Final

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from remanent.plots.colours import OKABE_ITO_COLOURS, temperature_colours
from remanent.plots.labels import axis_label, format_number, math_symbol, value_label
from remanent.plots.legends import add_legend_above, height_above
from remanent.plots.text_fit import broken_text, points, text_width

__all__ = [
    "DOUBLE_COLUMN_WIDTH_INCHES",
    "OKABE_ITO_COLOURS",
    "SINGLE_COLUMN_WIDTH_INCHES",
    "HouseFigure",
    "add_legend_above",
    "axis_label",
    "context",
    "context_of",
    "fit_label",
    "format_number",
    "given_or_new_axes",
    "ink_colour",
    "label_axes",
    "math_symbol",
    "save_figure",
    "set_panel_title",
    "subplots",
    "temperature_colours",
    "value_label",
]

#: Width of a journal's single column, in inches (89 mm).
SINGLE_COLUMN_WIDTH_INCHES: Final = 3.5
#: Width of a journal's double column, in inches (183 mm).
DOUBLE_COLUMN_WIDTH_INCHES: Final = 7.2

#: Line styles for a second dimension of an ensemble; solid first.
LINE_STYLES: Final = ("-", (0, (4, 1.6)), (0, (1, 1.2)), (0, (5, 1.4, 1, 1.4)))
#: Markers for the same.
MARKERS: Final = ("o", "D", "s", "^")
#: Colour of text, axes and what belongs to no member.
INK_COLOUR: Final = "#1a1a1a"
#: Colour of what is read last: the footer, lines of reference.
FAINT_COLOUR: Final = "#767676"

#: Longest label of an axis, as a share of its length before room for other things is made.
_LABEL_SHARE: Final = 0.85
#: Name of a label that is ours, and not the user's.
_LABEL_GID: Final = "remanent.label"
#: Dots per inch of pictures in pixels.
_PIXEL_RESOLUTION_DPI: Final = 300
#: Dots per inch of what is drawn as pixels inside pictures in vectors.
_LAYER_RESOLUTION_DPI: Final = 600
#: Formats in which lines and letters stay vectors.
_VECTOR_FORMATS: Final = frozenset({"pdf", "svg", "svgz", "ps", "eps"})
#: Where the metadata of a format say what the picture shows.
_DESCRIPTION_KEYS: Final[Mapping[str, str]] = MappingProxyType(
    {"png": "Description", "svg": "Description", "pdf": "Subject"}
)
#: Matplotlib's settings that count when a picture is saved: TrueType fonts, paths in SVG, and
#: nothing random.
_SAVING_SETTINGS: Final[Mapping[str, Any]] = MappingProxyType(
    {
        "savefig.bbox": None,
        "svg.fonttype": "path",
        "svg.hashsalt": "remanent",
        "pdf.fonttype": 42,
        "ps.fonttype": 42,
    }
)

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
        "savefig.dpi": _PIXEL_RESOLUTION_DPI,
        "figure.facecolor": "white",
        "axes.facecolor": "white",
        **_SAVING_SETTINGS,
    }
)


class HouseFigure(Figure):
    """A figure that carries the house style to any call that saves it.

    Attributes
    ----------
    description : str
        What made it, for the metadata of its files.
    """

    description: str = ""

    def savefig(self, fname: Any, **options: Any) -> None:
        """Save with TrueType fonts and fine pixels, unless `options` say otherwise."""
        kind = options.get("format") or Path(str(fname)).suffix.lstrip(".")
        kind = str(kind).lower()
        layers = kind in _VECTOR_FORMATS
        key = _DESCRIPTION_KEYS.get(kind)
        if key and self.description:
            options["metadata"] = {key: self.description} | (options.get("metadata") or {})
        with mpl.rc_context(dict(_SAVING_SETTINGS)):  # type: ignore[arg-type]  # checked when set
            super().savefig(
                fname,
                **{"dpi": _LAYER_RESOLUTION_DPI if layers else _PIXEL_RESOLUTION_DPI, **options},
            )


def context() -> AbstractContextManager[None]:
    """Apply the house style inside a ``with`` block, and nowhere else.

    Returns
    -------
    context manager
        The style is in force until it ends.

    See Also
    --------
    subplots : A figure that carries the style.

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


def context_of(ax: Axes | None) -> AbstractContextManager[None]:
    """Apply the house style where a figure of our own is made; `ax` keeps the user's style.

    Parameters
    ----------
    ax : matplotlib.axes.Axes or None
        The axes that the user asked to draw in, if any.

    Returns
    -------
    context manager
    """
    if ax is None or isinstance(ax.get_figure(root=True), HouseFigure):
        return context()
    return nullcontext()


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

    return plt.figure(
        figsize=(width, height), layout="constrained", FigureClass=HouseFigure
    ).add_subplot()


def subplots(
    rows: int = 1,
    columns: int = 1,
    *,
    figsize: tuple[float, float] = (SINGLE_COLUMN_WIDTH_INCHES, 2.6),
    **options: Any,
) -> tuple[Figure, Any]:
    """Make a figure in the house style with axes for several plots.

    Parameters
    ----------
    rows, columns : int
        How many axes lie below and beside each other.
    figsize : (float, float)
        Width and height in inches.
    **options : Any
        Passed to ``matplotlib.pyplot.subplots``.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Known to pyplot.  However it is saved, fonts are TrueType and pixels are fine.
    axes : matplotlib.axes.Axes or array of them
        For the argument ``ax`` of the plots.

    See Also
    --------
    save_figure : Write a figure to a file.

    Examples
    --------
    >>> from matplotlib import pyplot as plt
    >>> figure, axes = subplots(1, 2)
    >>> axes.shape
    (2,)
    >>> plt.close(figure)
    """
    from matplotlib import pyplot as plt

    with context():
        return plt.subplots(
            rows, columns, figsize=figsize, layout="constrained", FigureClass=HouseFigure, **options
        )


def ink_colour() -> str:
    """Colour of text and of what belongs to no member, in the style that is in force."""
    return str(mpl.rcParams["text.color"])


def label_axes(axes: Axes, across: str, up: str) -> None:
    """Label axes; a label that is there already stays.

    Of panels in a column that share a horizontal axis only the last is labelled, of those in a
    row that share a vertical one only the first.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What was drawn in.
    across, up : str
        Labels of the horizontal and of the vertical axis.
    """
    beside_x = _places_beside(axes, axes.get_shared_x_axes().get_siblings(axes))
    beside_y = _places_beside(axes, axes.get_shared_y_axes().get_siblings(axes))
    if not axes.get_xlabel() and not any(row > 0 and column == 0 for row, column in beside_x):
        axes.set_xlabel(across)
    if not axes.get_ylabel() and not any(row == 0 and column < 0 for row, column in beside_y):
        axes.set_ylabel(up, gid=_LABEL_GID)
        fit_label(axes)


def _places_beside(axes: Axes, others: Iterable[Axes]) -> list[tuple[int, int]]:
    """Rows and columns between axes in a grid and others."""
    own = axes.get_subplotspec()
    places = [place for other in others if (place := other.get_subplotspec()) is not None]
    if own is None:
        return []
    return [(place.rowspan.start - own.rowspan.start, place.colspan.start - own.colspan.start)
            for place in places]  # fmt: skip


def fit_label(axes: Axes) -> None:
    """Break our label of the vertical axis where it is longer than the axis under its legend.

    Where nothing makes room for a second line, and where three do not suffice, the symbol with
    its unit stands for the whole.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Labelled by :func:`label_axes`; a label of the user's stays as it is.
    """
    figure, label = axes.get_figure(root=True), axes.yaxis.label
    if figure is None or label.get_gid() != _LABEL_GID:
        return
    place, inch = axes.get_position(), 72.0 * figure.get_figheight()
    above = height_above(axes) - (1.0 - place.y1) * inch
    room = _LABEL_SHARE * (place.height * inch - max(above, 0.0))
    size = points(label.get_fontsize())
    whole = label.get_text().replace("\n", " ")
    text = broken_text(whole, room, size)
    is_crowded = "\n" in text and figure.get_layout_engine() is None
    if is_crowded or text_width(text, size) > place.height * inch - max(above, 0.0):
        text = whole.rpartition(", ")[2]
    axes.set_ylabel(text)


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
        The file.

    See Also
    --------
    subplots : A figure in the house style.

    Examples
    --------
    >>> import tempfile
    >>> from matplotlib import pyplot as plt
    >>> figure, axes = subplots()
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     save_figure(figure, f"{folder}/figure.pdf").suffix
    '.pdf'
    >>> plt.close(figure)
    """
    path = Path(path)
    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None, "ModDate": None}}
    layers = path.suffix.lstrip(".") in _VECTOR_FORMATS
    with context():
        figure.savefig(
            path, dpi=_LAYER_RESOLUTION_DPI if layers else _PIXEL_RESOLUTION_DPI,
            metadata=undated.get(path.suffix),
        )  # fmt: skip
    return path


def set_panel_title(ax: Axes, letter: str, text: str) -> None:
    """Write ``(a)  text`` above the upper left corner of a panel."""
    ax.set_title(f"({letter})  {text}" if letter else text, loc="left")
