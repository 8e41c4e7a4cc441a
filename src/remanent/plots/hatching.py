"""Cells of a chart without an answer: hatched, and named in the legend."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Patch, PathPatch
from matplotlib.path import Path

from remanent._typing import BoolArray, FloatArray
from remanent.plots import colours

__all__ = ["edges", "hatch_cells"]

#: Hatching of cells without an answer, by what they are called.
_HATCHINGS: Final[Mapping[str, str]] = MappingProxyType(
    {"undecided": "////", "no result": "xxxx", "incomplete": "...."}
)
#: Colour under the hatching of cells without a result.
_NO_RESULT_COLOUR: Final = "#ffffff"
#: Colour of the hatching.
_HATCH_COLOUR: Final = "#4d4d4d"
#: Width of its lines, in points.
_HATCH_WIDTH_POINTS: Final = 0.5


def hatch_cells(
    axes: Axes, x: FloatArray, y: FloatArray, named: Mapping[str, BoolArray]
) -> list[Patch]:
    """Hatch cells of a chart, and return a legend entry for each name.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What the chart was drawn in.
    x, y : array (x,), array (y,)
        Centres of its columns and rows.
    named : mapping of str to array (y, x) of bool
        The cells; the part of a name before a colon says how they are hatched.

    Returns
    -------
    list of matplotlib.patches.Patch
    """
    entries = []
    for name, cells in named.items():
        kind = name.partition(":")[0]
        ground = colours.UNDECIDED_COLOUR if kind == "undecided" else _NO_RESULT_COLOUR
        looks: dict[str, Any] = {
            "hatch": _HATCHINGS[kind],
            "edgecolor": _HATCH_COLOUR,
            "linewidth": 0.0,
        }
        filled = {"facecolor": "none" if kind == "incomplete" else ground}
        axes.add_artist(_cell_patch(axes, x, y, cells, {**looks, **filled}))
        entries.append(Patch(**{**looks, **filled}, label=name))
    return entries


def _cell_patch(
    axes: Axes, x: FloatArray, y: FloatArray, cells: BoolArray, looks: Mapping[str, Any]
) -> PathPatch:
    """One patch of many rectangles, so that the hatching runs through neighbouring cells."""
    right, up = edges(np.asarray(x)), edges(np.asarray(y))
    rows, columns = np.nonzero(cells)
    corners = [
        np.stack([right[columns + i], up[rows + j]], axis=1)
        for i, j in ((0, 0), (1, 0), (1, 1), (0, 1), (0, 0))
    ]
    vertices = np.stack(corners, axis=1).reshape(-1, 2)
    steps = [Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY]
    codes = np.tile(np.asarray(steps, dtype=np.uint8), rows.size)
    return PathPatch(Path(vertices, codes), transform=axes.transData, zorder=1.5, **looks)


def edges(centres: FloatArray) -> FloatArray:
    """Borders of cells around their centres, as Matplotlib draws them.

    Parameters
    ----------
    centres : array (cell,)
        In order.

    Returns
    -------
    array (cell + 1,) of float
    """
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middles = 0.5 * (centres[1:] + centres[:-1])
    return np.concatenate(
        [[2.0 * centres[0] - middles[0]], middles, [2.0 * centres[-1] - middles[-1]]]
    )
