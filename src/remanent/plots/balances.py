"""Where the work of the drive goes: what is stored, and what is dissipated."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from remanent._errors import InputError
from remanent.plots import colours, style
from remanent.plots.ensemble import split_into_members
from remanent.plots.footer import add_legend_and_footer
from remanent.plots.missing import mark_ends, write_in_empty_frame
from remanent.results.provenance import own_variable_texts
from remanent.results.schema import describe

__all__ = ["energy_balance"]

#: Opacity of the areas.
_AREA_OPACITY: Final = 0.55
#: Hatching of the area of what is stored, a second cue beside its colour.
_STORED_HATCH: Final = "////"


def energy_balance(
    dataset: xr.Dataset,
    *,
    ax: Axes | None = None,
    legend: bool = True,
    footer: bool = True,
    **line: Any,
) -> list[Line2D]:
    """Draw what is dissipated, and on it the change of what is stored, up to the work.

    The two areas end in the line of the work but for the defect of the balance, which the legend
    says: the energy is accounted for.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result of ``energy_balance`` of one motion, over ``time``.
    ax : matplotlib.axes.Axes, optional
        Axes to draw in; a new figure if None.
    legend : bool
        Whether to name line and areas above the axes.
    footer : bool
        Whether a new figure says below what made it; files say so in their metadata.
    **line : Any
        Passed to matplotlib's ``plot``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        The work.

    Raises
    ------
    InputError
        A Dataset without what is drawn, or a word that Matplotlib does not know.

    See Also
    --------
    history : The motion itself.
    remanent.energy_balance : The result that is drawn.

    Examples
    --------
    >>> import matplotlib.pyplot as plt
    >>> import remanent as rm
    >>> damped = rm.Actuator(dissipation=rm.Rayleigh(0.05))
    >>> ds = rm.energy_balance(damped, rm.SineSquared(0.4, 1.25), duration=20.0)
    >>> (work,) = rm.plot.energy_balance(ds)
    >>> plt.close()
    """
    lost = _name_of_loss(dataset)
    names = ("drive_work", "stored_energy", lost, "balance", "time")
    _require_one_motion(dataset, names)
    with style.context_of(ax):
        axes = style.given_or_new_axes(ax)
        (member,) = split_into_members(dataset, names, ("time", "cycle"))
        data = member.data
        time, work = data["time"].values, data["drive_work"].values
        away = data[lost].values
        stored = data["stored_energy"].values
        change = stored - (stored[0] if stored.size else 0.0)
        tones = colours.category_colours(2)
        looks: dict[str, Any] = {"alpha": _AREA_OPACITY, "linewidth": 0.0}
        axes.fill_between(time, 0.0, away, color=tones[1], **looks)
        axes.fill_between(time, away, away + change, facecolor=tones[0], hatch=_STORED_HATCH,
                          edgecolor=axes.get_facecolor(), **looks)  # fmt: skip
        ink = style.ink_colour()
        artists = axes.plot(time, work, **{"color": ink, "linewidth": 1.0, **line})
        own = own_variable_texts(dataset)
        unit = style.axis_label(data["drive_work"], words=False).partition(" (")[1:]
        label = "energy per reference volume, $E$" + "".join(unit)
        style.label_axes(axes, style.axis_label(data["time"]), label)
        axes.margins(x=0.0)
        ends = mark_ends(axes, [member], "time", "drive_work")
        write_in_empty_frame(axes, [member], "time", "drive_work")
        words = {name: describe(name, own).long_name for name in ("drive_work", lost)}
        entries = [
            Line2D([], [], color=artists[0].get_color(), lw=1.0, label=words["drive_work"]),
            Patch(color=tones[1], label=words[lost], **looks),
            Patch(facecolor=tones[0], hatch=_STORED_HATCH, edgecolor=axes.get_facecolor(),
                  label="change of stored energy", **looks),
            *_defect_entries(data["balance"]), *ends,
        ]  # fmt: skip
        add_legend_and_footer(axes, ax, dataset, entries, legend=legend, footer=footer)
    return artists


def _name_of_loss(dataset: xr.Dataset) -> str:
    """What leaves the body: heat where it has a balance of heat, else what is dissipated."""
    return "heat_given_off" if "heat_given_off" in dataset else "dissipated_energy"


def _require_one_motion(dataset: xr.Dataset, names: tuple[str, ...]) -> None:
    others = {str(dim) for name in names if name in dataset for dim in dataset[name].dims}
    others -= {"time", "cycle"}
    if others:
        raise InputError(
            "dataset",
            must="be of one motion",
            got=f"several along {', '.join(sorted(others))}",
            why="The areas of two motions would cover each other.",
            fix=f"Select values first, for example dataset.isel({min(others)}=0).",
        )


def _defect_entries(balance: xr.DataArray) -> list[Line2D]:
    """Legend entry, in words, of the largest defect of the balance."""
    values = np.abs(balance.values[np.isfinite(balance.values)])
    if not values.size:
        return []
    text = style.format_number(float(f"{values.max():.1g}"))
    unit = style.axis_label(balance, words=False).partition(" (")[2].rstrip(")")
    return [Line2D([], [], linestyle="", label=f"defect at most ${text}$ {unit}".rstrip())]
