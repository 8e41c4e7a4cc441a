"""Colour bars beside axes, with labels that fit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colorbar import Colorbar

from remanent.plots.text_fit import broken_text, points

__all__ = ["add_colour_bar"]

#: Width of a bar and its distance, over the width of the axes.
_WIDTH_SHARE: Final = 0.05
_DISTANCE_SHARE: Final = 0.02
#: Distance of a further bar where nothing makes room for the label of the one before.
_CROWDED_DISTANCE_SHARE: Final = 0.2
#: Distance of a further bar from the label of the one before.
_FURTHER_DISTANCE_SHARE: Final = 0.05
#: Length of a bar over its width.
_ASPECT: Final = 28
#: Longest label, as a share of the bar's length.
_LABEL_SHARE: Final = 0.9


def add_colour_bar(
    axes: Axes, source: ScalarMappable, label: str, ticks: Sequence[float] | None = None
) -> Colorbar:
    """Add a colour bar to the right of axes.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What it belongs to.
    source : matplotlib.cm.ScalarMappable
        Its numbers and colours.
    label : str
        What the numbers are; in two lines where it is longer than the bar.
    ticks : sequence of float, optional
        Where there are ticks; those of Matplotlib by default.

    Returns
    -------
    matplotlib.colorbar.Colorbar
    """
    figure = axes.get_figure(root=True)
    assert figure is not None
    length = 72.0 * figure.get_figheight() * axes.get_position().height
    is_further = any(other.get_label() == "<colorbar>" for other in figure.axes)
    crowded = is_further and figure.get_layout_engine() is None
    further = _FURTHER_DISTANCE_SHARE if is_further else _DISTANCE_SHARE
    bar = figure.colorbar(
        source, ax=axes, fraction=_WIDTH_SHARE, aspect=_ASPECT, ticks=ticks,
        pad=_CROWDED_DISTANCE_SHARE if crowded else further,
    )  # fmt: skip
    size = points(mpl.rcParams["axes.labelsize"])
    bar.set_label(broken_text(label, _LABEL_SHARE * length, size))
    outline: Any = bar.outline
    outline.set_linewidth(0.5)
    if ticks is not None:
        bar.ax.minorticks_off()
        bar.ax.tick_params(length=0)
    return bar
