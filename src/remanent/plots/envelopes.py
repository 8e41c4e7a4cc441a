"""Long histories: the band between the extremes of a motion, its last oscillations beside it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent._typing import FloatArray

__all__ = ["add_last_oscillations", "draw_as_bands", "extent_of", "oscillation_count"]

#: Oscillations for each point of width from which none is seen for itself.
_BAND_OSCILLATIONS_PER_POINT: Final = 0.5
#: Size of a piece of which the extremes are drawn: so many points of width at least, and so many
#: oscillations, so that each has a whole one.
_PIECE_WIDTH_POINTS: Final = 1.0
_PIECE_OSCILLATIONS: Final = 1.0
#: Opacity of a band, and width of its outline in points.
_BAND_OPACITY: Final = 0.35
_OUTLINE_WIDTH: Final = 0.6
#: How many oscillations are drawn beside bands, for themselves.
_LAST_OSCILLATION_COUNT: Final = 10
#: Width of the axes with the last oscillations, over that of the axes with all.
_LAST_OSCILLATIONS_WIDTH: Final = 0.45


def draw_as_bands(
    axes: Axes, artists: Sequence[Line2D], given: Mapping[str, Any], width: float
) -> list[tuple[Line2D, FloatArray]]:
    """Draw lines whose oscillations run into a solid block as bands between their extremes.

    The line becomes the outline of its band; small motions lie over large ones.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What the lines were drawn in.
    artists : sequence of matplotlib.lines.Line2D
        Each against time.
    given : mapping
        What the user says of lines, which stays.
    width : float
        Width of the axes in points.

    Returns
    -------
    list of (matplotlib.lines.Line2D, array (point, 2))
        All lines, and what they were before; none where no line is a band now.
    """
    if {"marker", "ls", "linestyle"} & set(given):  # each point is to be seen
        return []
    before = [(artist, np.asarray(artist.get_xydata(), dtype=np.float64)) for artist in artists]
    crowded = [a for a in artists if oscillation_count(a) > _BAND_OSCILLATIONS_PER_POINT * width]
    crowded.sort(key=lambda artist: -float(np.prod(extent_of(artist))))
    for rank, artist in enumerate(crowded):
        pieces = min(width / _PIECE_WIDTH_POINTS, oscillation_count(artist) / _PIECE_OSCILLATIONS)
        points = np.asarray(artist.get_xydata(), dtype=np.float64)
        upper, lower = _extremes(points, max(int(pieces), 1))
        artist.set_data(*np.concatenate([upper, [[np.nan, np.nan]], lower]).T)
        artist.set_rasterized(False)
        if "zorder" not in given:
            artist.set_zorder(2.0 + 0.5 * rank / len(crowded))
        if not {"lw", "linewidth"} & set(given):
            artist.set_linewidth(_OUTLINE_WIDTH)
        for part in _runs(upper, lower):
            axes.fill(*part.T, color=artist.get_color(), alpha=_BAND_OPACITY, linewidth=0.0,
                      zorder=artist.get_zorder())  # fmt: skip
    return before if crowded else []


def add_last_oscillations(axes: Axes, before: Sequence[tuple[Line2D, FloatArray]]) -> Axes | None:
    """Draw the last oscillations beside bands, in axes of their own on the right.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        With the bands, labelled, and alone in its figure.
    before : sequence of (matplotlib.lines.Line2D, array (point, 2))
        As :func:`draw_as_bands` returns them; without any there is nothing to add.

    Returns
    -------
    matplotlib.axes.Axes or None
    """
    if not before:
        return None
    known = [points[np.isfinite(points).all(axis=1)] for _, points in before]
    # As many oscillations of the slowest; what hardly oscillates does not count.
    counts = [_oscillations_of(points[:, 1]) for points in known]
    spans = [points[[0, -1], 0] for points in known]
    counted = [k for k, count in enumerate(counts) if count >= _LAST_OSCILLATION_COUNT]
    period = max(float(np.ptp(spans[k])) / counts[k] for k in counted)
    begin = max(float(spans[k][1]) for k in counted) - _LAST_OSCILLATION_COUNT * period
    figure = axes.get_figure(root=True)
    assert figure is not None
    grid = figure.add_gridspec(1, 2, width_ratios=(1.0, _LAST_OSCILLATIONS_WIDTH))
    axes.set_subplotspec(grid[0, 0])
    beside = figure.add_subplot(grid[0, 1], sharey=axes)
    for (artist, _), points in zip(before, known, strict=True):
        shown = points[points[:, 0] >= begin]
        beside.plot(*shown.T, color=artist.get_color(), linestyle=artist.get_linestyle())
    beside.margins(x=0.0)
    beside.tick_params(labelleft=False)
    beside.set(xlabel=axes.get_xlabel())
    beside.set_title(f"the last {_LAST_OSCILLATION_COUNT} oscillations", loc="left")
    return beside


def oscillation_count(artist: Line2D) -> int:
    """How often what is drawn has a maximum."""
    return _oscillations_of(np.asarray(artist.get_ydata(), dtype=np.float64))


def _oscillations_of(values: FloatArray) -> int:
    return int((np.diff(np.sign(np.diff(values[np.isfinite(values)]))) < 0.0).sum())


def extent_of(artist: Line2D) -> FloatArray:
    """Width and height of what is drawn, array (2,)."""
    points = np.asarray(artist.get_xydata(), dtype=np.float64)
    points = points[np.isfinite(points).all(axis=1)]
    return np.ptp(points, axis=0) if len(points) else np.zeros(2)


def _extremes(points: FloatArray, count: int) -> tuple[FloatArray, FloatArray]:
    """The highest and the lowest point of each of `count` pieces, arrays (count, 2).

    NaN where a piece has no value: there the band has a gap.
    """
    nothing = np.full(2, np.nan)
    upper, lower = [], []
    for piece in np.array_split(points, count):
        known = piece[np.isfinite(piece).all(axis=1)]
        upper.append(known[known[:, 1].argmax()] if len(known) else nothing)
        lower.append(known[known[:, 1].argmin()] if len(known) else nothing)
    return np.array(upper), np.array(lower)


def _runs(upper: FloatArray, lower: FloatArray) -> list[FloatArray]:
    """Polygons between two lines, one for each run without a gap."""
    known = np.isfinite(upper[:, 0]).astype(np.int8)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], known, [0]]))).reshape(-1, 2)
    return [np.concatenate([upper[a:b], lower[a:b][::-1]]) for a, b in edges]
