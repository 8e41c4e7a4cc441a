"""Legends: above the axes, never over data, and added to the one that is there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeVar

import matplotlib as mpl
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation
from matplotlib.transforms import offset_copy

from remanent.plots.text_fit import points, text_width, wrapped_text

__all__ = ["add_legend_above", "height_above", "row_count"]

#: Length of a sample, its distance from the name, and from one column to the next, in sizes of
#: letters.
_SAMPLE_LENGTH: Final = 1.6
_DISTANCE_OF_NAME: Final = 0.5
_DISTANCE_OF_COLUMNS: Final = 1.1
#: Distance of a row from the next, and of the legend from what is below, in the same.
_DISTANCE_OF_ROWS: Final = 0.35
_DISTANCE_OF_LEGEND: Final = 0.2
#: Blank around a legend, in the same.
_PADDING: Final = 0.3
#: Height of a line of text, in the same.
_LINE_HEIGHT: Final = 1.2
#: Largest share of the height of a figure that a legend takes.
_MAX_HEIGHT_SHARE: Final = 0.24
#: Smallest letters, and how much smaller the next try is, in points.
_MIN_SIZE_POINTS: Final = 6.0
_SIZE_STEP_POINTS: Final = 0.5
#: Share of the width of a figure that is free beside a colour bar, and without one.
_FREE_WIDTH_SHARE: Final = 0.93
_FREE_WIDTH_SHARE_BESIDE_BAR: Final = 0.62
#: Share of the width of axes that a colour bar and its label leave in a small figure.
_WIDTH_SHARE_BESIDE_BAR: Final = 0.6
#: Size of a note over that of a legend, and the lines that it has at most.
_NOTE_SIZE_RATIO: Final = 0.875
_MAX_NOTE_LINE_COUNT: Final = 2
#: Name of the note in the axes that have one.
_NOTE_GID: Final = "remanent.note"
#: Where the legend is in axes without room above.
_INSIDE: Final = "best"
#: Width of a figure that is not known, in inches.
_USUAL_FIGURE_WIDTH_INCHES: Final = 3.5

_Entry = TypeVar("_Entry")


@dataclass(frozen=True)
class _Arrangement:
    """How a legend is set.

    Attributes
    ----------
    size : float
        Of its letters, in points.
    columns : int
        How many entries lie side by side.
    width, height : float
        Of the whole, in points.
    """

    size: float
    columns: int
    width: float
    height: float

    @property
    def looks(self) -> dict[str, Any]:
        """Arguments of a legend of Matplotlib."""
        return {
            "ncols": self.columns, "fontsize": self.size, "handlelength": _SAMPLE_LENGTH,
            "handletextpad": _DISTANCE_OF_NAME, "columnspacing": _DISTANCE_OF_COLUMNS,
            "labelspacing": _DISTANCE_OF_ROWS, "borderaxespad": _DISTANCE_OF_LEGEND,
            "borderpad": _PADDING,
        }  # fmt: skip


def add_legend_above(owner: Axes | Figure, entries: Sequence[Artist], note: str = "") -> None:
    """Put a legend above the axes or the figure, where it cannot hide data.

    Entries of a legend that the axes have already stay; of two that read the same the first
    is kept.  A line alone needs no name, a mark or a patch alone does.  Where it would take
    more than a quarter of the height its letters are smaller, down to 6 points.  Where axes
    have a title, or their figure makes no room above them, the legend goes inside, where it
    hides least.

    Parameters
    ----------
    owner : matplotlib.axes.Axes or matplotlib.figure.Figure
        What the legend belongs to.
    entries : sequence of matplotlib.artist.Artist
        What it names, in order.
    note : str
        A sentence between legend and axes.
    """
    named = _unlike_entries([*_present_entries(owner), *entries])
    if len(named) == 1 and _is_plain_line(named[0]):
        named = []
    if isinstance(owner, Figure):
        if entries and named:
            layout = _arrangement(owner, named)
            owner.legend(
                handles=_in_rows(named, layout.columns), loc="outside upper center", **layout.looks
            )
        return
    if not (entries and named) and not note:
        return
    layout = _arrangement(owner, named)
    if not _has_room_above(owner, layout.height):
        inside = [*named, *([_entry_of_note(note)] if note else [])]
        owner.legend(handles=inside, loc=_INSIDE, fontsize=layout.size)
        return
    below = _write_note(owner, note)
    if not named:
        return
    # A legend that is wider than the axes reaches over the labels on their left.
    is_wide = layout.width > _width_of(owner)
    figure = owner.get_figure(root=True)
    owner.legend(
        handles=_in_rows(named, layout.columns), loc="lower right" if is_wide else "lower left",
        bbox_to_anchor=(float(is_wide), 1.0), **layout.looks,
        bbox_transform=offset_copy(owner.transAxes, figure, y=below, units="points"),
    )  # fmt: skip


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


def _has_room_above(axes: Axes, height: float) -> bool:
    """Whether a legend fits above the axes, or the figure makes room for it there."""
    figure = axes.get_figure(root=True)
    if figure is None or any(axes.get_title(loc=place) for place in ("left", "center", "right")):
        return False
    if figure.get_layout_engine() is not None:
        return True
    return bool((1.0 - axes.get_position().y1) * 72.0 * figure.get_figheight() >= height)


def _in_rows(entries: Sequence[_Entry], columns: int) -> list[_Entry]:
    """Entries in the order that makes rows of them: Matplotlib fills columns."""
    return [entry for first in range(columns) for entry in entries[first::columns]]


def _arrangement(owner: Axes | Figure, entries: Sequence[Artist]) -> _Arrangement:
    """The largest letters with which a legend takes at most a quarter of the height."""
    largest = points(mpl.rcParams["legend.fontsize"])
    figure = owner if isinstance(owner, Figure) else owner.get_figure(root=True)
    room = _MAX_HEIGHT_SHARE * 72.0 * figure.get_figheight() if figure is not None else 72.0
    size = largest
    found = _arrangement_at(owner, entries, size)
    while found.height > room and size > _MIN_SIZE_POINTS:
        size = max(size - _SIZE_STEP_POINTS, _MIN_SIZE_POINTS)
        found = _arrangement_at(owner, entries, size)
    return found


def _arrangement_at(owner: Axes | Figure, entries: Sequence[Artist], size: float) -> _Arrangement:
    """As many columns as fit side by side, each as wide as its longest name."""
    if not entries:
        return _Arrangement(size, 1, 0.0, 0.0)
    beside = _SAMPLE_LENGTH + _DISTANCE_OF_NAME
    names = [str(entry.get_label()) for entry in entries]
    widths = [text_width(name, size) + beside * size for name in names]
    room = _free_width(owner)
    fitting = (k for k in range(len(entries), 1, -1) if _row_width(widths, k, size) <= room)
    row_count = -(-len(entries) // next(fitting, 1))
    # Of as many rows, those of about one length.
    columns = next(k for k in range(1, len(entries) + 1) if k * row_count >= len(entries))
    width = _row_width(widths, columns, size)
    rows = [names[first : first + columns] for first in range(0, len(names), columns)]
    lines = sum(max(name.count("\n") + 1 for name in row) for row in rows)
    blank = len(rows) * _DISTANCE_OF_ROWS + 2.0 * _PADDING + _DISTANCE_OF_LEGEND
    return _Arrangement(size, columns, width, (lines * _LINE_HEIGHT + blank) * size)


def _row_width(widths: Sequence[float], columns: int, size: float) -> float:
    """Width of a legend with columns as wide as their longest entry, in points."""
    blank = (columns - 1) * _DISTANCE_OF_COLUMNS + 2.0 * _PADDING
    return sum(max(widths[first::columns]) for first in range(columns)) + blank * size


def _free_width(owner: Axes | Figure) -> float:
    """Width that a legend may have, in points: that of the figure, or of its part for the axes."""
    if isinstance(owner, Figure):
        return _FREE_WIDTH_SHARE * 72.0 * owner.get_figwidth()
    figure, place = owner.get_figure(root=True), owner.get_subplotspec()
    inches = figure.get_figwidth() if figure is not None else _USUAL_FIGURE_WIDTH_INCHES
    if place is None or figure is None:
        return 72.0 * inches * owner.get_position().width
    grid = place.get_gridspec()
    share = _FREE_WIDTH_SHARE_BESIDE_BAR if _has_bar(figure) else _FREE_WIDTH_SHARE
    return float(share * 72.0 * inches * len(place.colspan) / grid.ncols)


def _has_bar(figure: Figure | None) -> bool:
    return figure is not None and any(one.get_label() == "<colorbar>" for one in figure.axes)


def _width_of(axes: Axes) -> float:
    """Width of axes beside a colour bar and labels of ticks that are words, in points."""
    figure, place = axes.get_figure(root=True), axes.get_position()
    points_of_figure = 72.0 * (figure.get_figwidth() if figure else _USUAL_FIGURE_WIDTH_INCHES)
    size = points(mpl.rcParams["ytick.labelsize"])
    words = [text_width(label.get_text(), size) for label in axes.get_yticklabels()]
    beyond = max([*words, 0.0]) - place.x0 * points_of_figure
    share = _WIDTH_SHARE_BESIDE_BAR if _has_bar(figure) else 1.0
    return float(share * points_of_figure * place.width - max(beyond, 0.0))


def _write_note(axes: Axes, note: str) -> float:
    """Write a note just above the axes, after those that are there; return its height."""
    size = max(_NOTE_SIZE_RATIO * points(mpl.rcParams["legend.fontsize"]), _MIN_SIZE_POINTS)
    present = _note_of(axes)
    if present is not None and note:
        note = " ".join(dict.fromkeys([*_lines(present), note]))
        present.remove()
    elif present is not None:
        return _height_of_note(present)
    if not note:
        return 0.0
    text = wrapped_text(note, _width_of(axes), size, _MAX_NOTE_LINE_COUNT)
    written = axes.annotate(
        text, (0.0, 1.0), xycoords="axes fraction", xytext=(0.0, 2.0), textcoords="offset points",
        va="bottom", fontsize=size, style="italic", gid=_NOTE_GID, annotation_clip=False,
    )  # fmt: skip
    return _height_of_note(written)


def _note_of(axes: Axes) -> Annotation | None:
    """The note above axes, where there is one."""
    notes = (text for text in axes.texts if text.get_gid() == _NOTE_GID)
    return next((text for text in notes if isinstance(text, Annotation)), None)


def _lines(note: Annotation) -> list[str]:
    return [note.get_text().replace("\n", " ")]


def _height_of_note(note: Annotation) -> float:
    lines = note.get_text().count("\n") + 1
    return float(_LINE_HEIGHT * lines * points(note.get_fontsize()) + 2.0)


def _entry_of_note(note: str) -> Line2D:
    """A note where only the legend has room for it."""
    size = points(mpl.rcParams["legend.fontsize"])
    text = wrapped_text(note, 20.0 * size, size, _MAX_NOTE_LINE_COUNT)
    return Line2D([], [], linestyle="", marker="", label=text)


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


def height_above(axes: Axes) -> float:
    """Height of legend and note above axes, in points; 0 where they are inside.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        After :func:`add_legend_above`.

    Returns
    -------
    float
    """
    note, legend = _note_of(axes), axes.get_legend()
    height = _height_of_note(note) if note is not None else 0.0
    if legend is None or legend._loc == 0:  # type: ignore[attr-defined]  # has no getter
        return height
    texts = legend.get_texts()
    size = points(texts[0].get_fontsize()) if texts else 0.0
    return height + (row_count(axes) * (_LINE_HEIGHT + _DISTANCE_OF_ROWS) + 1.0) * size
