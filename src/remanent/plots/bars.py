"""One bar for each field: elasticities, indices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.container import BarContainer

from remanent._errors import InputError
from remanent.plots import footer, style
from remanent.results.schema import describe

__all__ = ["bars"]

#: Share of the distance between fields that their bars take together.
_GROUP_HEIGHT_SHARE: Final = 0.8
#: Share of its place that a bar covers, so that bars side by side are told apart.
_BAR_HEIGHT_SHARE: Final = 0.9


def bars(
    dataset: xr.Dataset,
    variables: str | Sequence[str] = "elasticity",
    *,
    ax: Axes | None = None,
    legend: bool = True,
    **bar: Any,
) -> list[BarContainer]:
    """Draw a bar for each field, with its error.

    Parameters
    ----------
    dataset : xarray.Dataset
        With `variables` along ``field`` and at most one more dimension, a bar for each of its
        entries; ``<variable>_error``, where present, is a line at the end of the bar.
    variables : str or sequence of str
        What to draw; several lie side by side.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure, with its footer, if None.
    legend : bool
        Whether to name the colours above the axes.
    **bar : Any
        Passed to matplotlib's ``barh``.

    Returns
    -------
    list of matplotlib.container.BarContainer
        One for each variable or entry.
    """
    names = [variables] if isinstance(variables, str) else list(variables)
    for name in names:
        if name not in dataset or "field" not in dataset[name].dims or dataset[name].ndim > 2:
            raise InputError(
                "variables",
                must="be variables along `field` and at most one more dimension",
                got=name,
                why="There is a bar for each field.",
                fix="Select values first, or name others.",
            )
    rows = [row for name in names for row in _labelled_bars(dataset, name)]
    positions = np.arange(dataset.sizes["field"])
    thickness = _GROUP_HEIGHT_SHARE / len(rows)
    with style.context():
        axes = style.given_or_new_axes(ax)
        artists = []
        for k, (label, values, errors) in enumerate(rows):
            colour = list(style.OKABE_ITO_COLOURS.values())[k % len(style.OKABE_ITO_COLOURS)]
            y = positions - 0.5 * _GROUP_HEIGHT_SHARE + (k + 0.5) * thickness
            looks = {
                "color": colour,
                "height": _BAR_HEIGHT_SHARE * thickness,
                "label": label,
                **bar,
            }
            artists.append(axes.barh(y, values, xerr=errors, error_kw={"lw": 0.8}, **looks))
        axes.axvline(0.0, color=style.INK_COLOUR, lw=0.6)
        fields = [describe(str(name)) for name in dataset["field"].values]
        axes.set_yticks(positions, [f"{field.long_name}, ${field.symbol}$" for field in fields])
        axes.tick_params(axis="y", length=0)
        axes.invert_yaxis()
        row = describe(names[0])
        axes.set_xlabel(f"{row.long_name}, ${row.symbol}$" if len(names) == 1 else "")
        entries = artists if legend and len(rows) > 1 else []
        footer.add_legend_and_footer(axes, ax, dataset, entries)  # type: ignore[arg-type]
    return artists


def _labelled_bars(dataset: xr.Dataset, name: str) -> list[tuple[str, Any, Any]]:
    """Label, values and errors of each set of bars."""
    values, error = dataset[name], dataset.get(f"{name}_error")
    second = next((dim for dim in values.dims if dim != "field"), None)
    if second is None:
        return [(describe(name).long_name, values, error)]
    return [
        (str(dataset[second].values[k]), values.isel({second: k}),
         None if error is None else error.isel({second: k}))
        for k in range(values.sizes[second])
    ]  # fmt: skip
