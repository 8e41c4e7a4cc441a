"""Legends: above the axes, never over data, and added to the one that is there."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, TypeVar

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.textpath import text_to_path

__all__ = ["add_legend_above", "row_count"]

#: What stands beside a name, in sizes of its letters.
_PARTS_BESIDE_NAME: Final = (
    "legend.handlelength",
    "legend.handletextpad",
    "legend.columnspacing",
)
#: Height of a row of a legend, over the size of its letters.
_LINE_HEIGHT_RATIO: Final = 1.7
#: Width of a figure that is not known, in inches.
_USUAL_FIGURE_WIDTH_INCHES: Final = 3.5

_Entry = TypeVar("_Entry")


def add_legend_above(owner: Axes | Figure, entries: Sequence[Artist]) -> None:
    """Put a legend above the axes or the figure, where it cannot hide data.

    Entries of a legend that the axes have already stay; of two that read the same the first
    is kept.  A line alone needs no name, a mark or a patch alone does.  Where axes have a
    title, or their figure makes no room above them, the legend goes inside, where it hides
    least.

    Parameters
    ----------
    owner : matplotlib.axes.Axes or matplotlib.figure.Figure
        What the legend belongs to.
    entries : sequence of matplotlib.artist.Artist
        What it names, in order.
    """
    named = _unlike_entries([*_present_entries(owner), *entries])
    if not entries or not named or (len(named) == 1 and _is_plain_line(named[0])):
        return
    if isinstance(owner, Figure):
        columns = _column_count(owner, named)
        owner.legend(handles=_in_rows(named, columns), ncols=columns, loc="outside upper center")
        return
    columns = _column_count(owner, named)
    if _has_room_above(owner, -(-len(named) // columns)):
        owner.legend(
            handles=_in_rows(named, columns), ncols=columns, loc="lower left",
            bbox_to_anchor=(0.0, 1.0), borderaxespad=0.2,
        )  # fmt: skip
    else:
        owner.legend(handles=named, loc="best")


def _present_entries(owner: Axes | Figure) -> list[Artist]:
    """Entries of the legend that the axes have, by rows as a reader reads them."""
    legend = owner.get_legend() if isinstance(owner, Axes) else None
    if legend is None:
        return []
    handles = [handle for handle in legend.legend_handles if handle is not None]
    for handle, text in zip(handles, legend.get_texts(), strict=True):
        handle.set_label(text.get_text())
    columns: int = legend._ncols  # type: ignore[attr-defined]  # has no getter
    order = _in_rows(range(len(handles)), columns)
    return [handles[order.index(k)] for k in range(len(handles))]


def _unlike_entries(entries: Sequence[Artist]) -> list[Artist]:
    """The entries without those that read as an earlier one does."""
    return list({str(entry.get_label()): entry for entry in reversed(entries)}.values())[::-1]


def _is_plain_line(entry: Artist) -> bool:
    """Whether an entry is a line without marks, which needs no name where it is alone."""
    nothing = ("None", None, "", " ")
    if not isinstance(entry, Line2D) or entry.get_marker() not in nothing:
        return False
    return entry.get_linestyle() not in nothing


def _has_room_above(axes: Axes, rows: int) -> bool:
    """Whether a legend fits above the axes, or the figure makes room for it there."""
    figure = axes.get_figure(root=True)
    if figure is None or any(axes.get_title(loc=place) for place in ("left", "center", "right")):
        return False
    if figure.get_layout_engine() is not None:
        return True
    font = FontProperties(size=mpl.rcParams["legend.fontsize"])
    lines = rows * _LINE_HEIGHT_RATIO * font.get_size_in_points()
    return bool((1.0 - axes.get_position().y1) * 72.0 * figure.get_figheight() >= lines)


def _in_rows(entries: Sequence[_Entry], columns: int) -> list[_Entry]:
    """Entries in the order that makes rows of them: Matplotlib fills columns."""
    return [entry for first in range(columns) for entry in entries[first::columns]]


def _column_count(owner: Axes | Figure, entries: Sequence[Artist]) -> int:
    """How many columns fit side by side, each as wide as its longest name."""
    figure = owner if isinstance(owner, Figure) else owner.get_figure(root=True)
    inches = figure.get_figwidth() if figure is not None else _USUAL_FIGURE_WIDTH_INCHES
    width = 72.0 * inches * (owner.get_position().width if isinstance(owner, Axes) else 1.0)
    widths = [_entry_width(str(entry.get_label())) for entry in entries]
    fitting = (
        columns
        for columns in range(len(entries), 1, -1)
        if sum(max(widths[first::columns]) for first in range(columns)) <= width
    )
    return next(fitting, 1)


def row_count(owner: Axes) -> int:
    """How many lines of text the legend of some axes has; 0 without one.

    Parameters
    ----------
    owner : matplotlib.axes.Axes
        With a legend by :func:`add_legend_above`, or without.

    Returns
    -------
    int
    """
    entries = _present_entries(owner)
    if not entries:
        return 0
    columns: int = owner.get_legend()._ncols  # type: ignore[union-attr]  # has no getter
    rows = [entries[first : first + columns] for first in range(0, len(entries), columns)]
    return sum(max(str(e.get_label()).count("\n") + 1 for e in row) for row in rows)


def _entry_width(name: str) -> float:
    """Width of an entry with its sample and the space beside it, in points."""
    font = FontProperties(size=mpl.rcParams["legend.fontsize"])
    beside = sum(float(mpl.rcParams[part]) for part in _PARTS_BESIDE_NAME)
    longest = max(
        text_to_path.get_text_width_height_descent(line, font, ismath="$" in line)[0]
        for line in name.split("\n")
    )
    return float(longest + beside * font.get_size_in_points())
