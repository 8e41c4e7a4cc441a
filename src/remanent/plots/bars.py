"""One bar for each field: elasticities, indices."""

from __future__ import annotations

import itertools
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.container import BarContainer
from matplotlib.patches import Patch

from remanent._errors import InputError
from remanent._typing import FloatArray, IntArray
from remanent.models.variable_text import VariableText
from remanent.plots import colours, style
from remanent.plots.footer import add_legend_and_footer
from remanent.plots.labels import field_label, lone_part_names
from remanent.results.provenance import own_variable_texts
from remanent.results.schema import describe

__all__ = ["bars"]

#: Share of the distance between fields that their bars take together.
_GROUP_HEIGHT_SHARE: Final = 0.8
#: Share of its place that a bar covers, so that bars side by side are told apart.
_BAR_HEIGHT_SHARE: Final = 0.9
#: Hatching of sets of bars, a second cue beside their colour.
_HATCHINGS: Final = ("", "////", "....", "\\\\\\\\", "xxxx", "----", "++++")
#: Size of the words where a bar is missing, in points.
_NOTE_SIZE_POINTS: Final = 7.0
#: Letters of a field's name in one line.
_NAME_LINE_LENGTH: Final = 24
#: What stands for a blank that must stay in its line.
_NO_BREAK: Final = "\u2060"


def bars(
    dataset: xr.Dataset,
    variables: str | Sequence[str] = "elasticity",
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    sort: bool = True,
    **bar: Any,
) -> list[BarContainer]:
    """Draw a bar for each field, with its error, the longest on top.

    Parameters
    ----------
    dataset : xarray.Dataset
        With `variables` along ``field`` and at most one more dimension, a bar for each of its
        entries; ``<variable>_error``, where present, is a line at the end of the bar.
    variables : str or sequence of str
        What to draw; several lie side by side.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name the colours above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    sort : bool
        Whether fields are sorted by the size of their largest value; else they stay in order.
    **bar : Any
        Passed to matplotlib's ``barh``.

    Returns
    -------
    list of matplotlib.container.BarContainer
        One for each variable or entry.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    remanent.sensitivity : Derivatives and elasticities.
    remanent.uncertainty : Indices of Sobol'.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> rest = rm.Measure(rm.equilibria, rm.Actuator(), 0.16, of="turning_upper")
    >>> ds = rm.sensitivity(rest, parameters=["temperature", "prestress"])
    >>> [len(container) for container in rm.plot.bars(ds)]
    [2]
    >>> plt.close()
    """
    names = [variables] if isinstance(variables, str) else list(variables)
    for name in names:
        if name not in dataset or "field" not in dataset[name].dims or dataset[name].ndim > 2:
            raise InputError(
                "variables",
                must="be variables along `field` and at most one more dimension",
                got=name,
                why="There is a bar for each field.",
                fix="Pass the result of rm.sensitivity or rm.uncertainty; select values first, or "
                "name other variables.",
            )
    if sort:
        dataset = _sorted_by_size(dataset, names)
    rows = [row for name in names for row in _labelled_bars(dataset, name)]
    positions = np.arange(dataset.sizes["field"])
    thickness = _GROUP_HEIGHT_SHARE / len(rows)
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax)
        artists = []
        tones = colours.category_colours(len(rows))
        for k, (label, values, errors) in enumerate(rows):
            colour = tones[k]
            y = positions - 0.5 * _GROUP_HEIGHT_SHARE + (k + 0.5) * thickness
            looks = {
                "facecolor": colour,
                "height": _BAR_HEIGHT_SHARE * thickness,
                "label": label,
                "hatch": _HATCHINGS[(k + k // len(_HATCHINGS)) % len(_HATCHINGS)],
                "edgecolor": axes.get_facecolor(),
                "linewidth": 0.0,
                **bar,
            }
            artists.append(
                axes.barh(
                    y,
                    values,
                    xerr=errors,
                    error_kw={"lw": 0.8, "ecolor": style.ink_colour()},
                    **looks,
                )
            )
            _name_missing_bars(axes, np.asarray(y, dtype=np.float64), np.asarray(values), thickness)
        _show_whole_groups(axes, positions, thickness)
        axes.axvline(0.0, color=style.ink_colour(), lw=0.6)
        own, lone = own_variable_texts(dataset), lone_part_names(dataset)
        fields = [field_label(name, own, lone) for name in dataset["field"].values]
        axes.set_yticks(positions, [_wrap(name) for name in fields])
        axes.tick_params(axis="y", length=0)
        axes.invert_yaxis()
        style.label_axes(axes, _value_label(names, own), "")
        entries = [_legend_entry(a) for a in artists] if len(rows) > 1 and positions.size else []
        add_legend_and_footer(axes, ax, dataset, entries, legend=legend, footer=footer)
    return artists


def _sorted_by_size(dataset: xr.Dataset, names: Sequence[str]) -> xr.Dataset:
    """Fields in order of their largest value in size, those that are not defined last."""
    sizes = [np.abs(dataset[name].transpose("field", ...).values) for name in names]
    columns = [np.nan_to_num(size.reshape(len(size), -1), nan=-1.0) for size in sizes]
    largest = np.concatenate(columns, axis=1).max(axis=1, initial=-1.0)
    return dataset.isel(field=np.argsort(-largest, kind="stable"))


def _value_label(names: Sequence[str], own: Mapping[str, VariableText]) -> str:
    """Meaning and symbol of one variable, or the last words that the names of several share."""
    rows = [describe(name, own) for name in names]
    if len(rows) == 1:
        return f"{rows[0].long_name}, ${rows[0].symbol}$"
    backwards = zip(*(row.long_name.split()[::-1] for row in rows), strict=False)
    shared = list(itertools.takewhile(lambda words: len(set(words)) == 1, backwards))
    return " ".join(words[0] for words in shared[::-1])


def _legend_entry(bars: BarContainer) -> Patch:
    """The look of a set of bars, with its name."""
    one = bars.patches[0]
    return Patch(
        facecolor=one.get_facecolor(), edgecolor=one.get_edgecolor(), hatch=one.get_hatch(),
        linewidth=0.0, label=str(bars.get_label()),
    )  # fmt: skip


def _name_missing_bars(axes: Axes, y: FloatArray, values: FloatArray, thickness: float) -> None:
    """Say where a bar has no length: nothing drawn would read as zero."""
    size = np.clip(_NOTE_SIZE_POINTS * thickness / 0.25, 5.0, _NOTE_SIZE_POINTS)
    for place in y[~np.isfinite(values.astype(np.float64))]:
        axes.annotate(
            "not defined", (0.0, place), xytext=(3, 0), textcoords="offset points", va="center",
            fontsize=float(size), style="italic", color=style.ink_colour(),
        )  # fmt: skip


def _show_whole_groups(axes: Axes, positions: IntArray, thickness: float) -> None:
    """Give the words of a field that has no bars at all the room of its bars."""
    if positions.size:
        half = 0.5 * (_GROUP_HEIGHT_SHARE - (1.0 - _BAR_HEIGHT_SHARE) * thickness)
        axes.update_datalim([(0.0, positions[0] - half), (0.0, positions[-1] + half)])


def _wrap(name: str) -> str:
    """A name in lines, its symbol kept whole."""
    words, _, symbol = name.rpartition(", ")
    return "\n".join(textwrap.wrap(f"{words}, {symbol.replace(' ', _NO_BREAK)}",
                                   _NAME_LINE_LENGTH)).replace(_NO_BREAK, " ")  # fmt: skip


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
