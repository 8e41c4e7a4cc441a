"""Backbones over forced response: the frequency of free oscillations on the axis of the drive."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from remanent._errors import InputError
from remanent.plots import ensemble, style
from remanent.results.provenance import has_drive, read_drive

__all__ = ["draw_backbone"]

#: Looks of a backbone: thin, and with dashes and dots, which no stability has.
_LOOKS: Final[dict[str, Any]] = {"linestyle": (0, (6.0, 1.6, 1.0, 1.6)), "linewidth": 0.8}
#: Dimensions along which a backbone runs begin so: it starts at rest from given stretches.
_START: Final = "initial."


def draw_backbone(
    axes: Axes, backbone: xr.Dataset | None, forced: xr.Dataset, variable: str
) -> list[Line2D]:
    """Draw a backbone where its oscillations have the period of the load; it sets no limits.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What forced response was drawn in.
    backbone : xarray.Dataset or None
        A result of ``backbone``, with at most two dimensions of ``over``; None draws nothing.
    forced : xarray.Dataset
        What was drawn, with its drive; a load such as (b sin ωτ)² has twice the frequency ω.
    variable : str
        What was drawn: ``amplitude``, ``maximum`` or ``minimum``.

    Returns
    -------
    list of matplotlib.lines.Line2D
        The legend entry; empty without a backbone.
    """
    if backbone is None:
        return []
    _require_backbone(backbone, forced, variable)
    ratio = _load_frequency_ratio(forced)
    along = [dim for dim in map(str, backbone[variable].dims) if dim.startswith(_START)]
    for member in ensemble.split_by_colour(backbone, ("frequency", variable), along):
        x, y = member.data["frequency"].values / ratio, member.data[variable].values
        # Not by `plot`: the limits are those of the response.
        axes.add_artist(Line2D(x, y, color=member.colour, zorder=1.8, gid="backbone", **_LOOKS))
    return [Line2D([], [], color=style.ink_colour(), label="backbone", **_LOOKS)]


def _load_frequency_ratio(forced: xr.Dataset) -> float:
    """The frequency of the load over ω of the drive: 2 for (b sin ωτ)²."""
    drive = read_drive(forced) if has_drive(forced) else None
    omega, period = getattr(drive, "omega", None), getattr(drive, "period", None)
    if not omega or not period:
        raise InputError(
            "dataset",
            must="say the drive that made it, with a frequency",
            got="one without" if drive is None else f"one by {type(drive).__name__}",
            why="A backbone is drawn at the frequency of the drive, which may not be the load's.",
            fix="Pass a result as its verb returns it.",
        )
    return float(2.0 * np.pi / (period * omega))


def _require_backbone(backbone: xr.Dataset, forced: xr.Dataset, variable: str) -> None:
    """Refuse what is no backbone, or one in other units than the response."""
    missing = {"frequency", variable} - set(map(str, backbone.data_vars))
    if missing or not any(str(dim).startswith(_START) for dim in backbone[variable].dims):
        raise InputError(
            "backbone",
            must=f"be a result of backbone, with its frequency and {variable}",
            got=", ".join(map(str, backbone.data_vars)) or "an empty one",
            why="It is drawn over the response.",
            fix="Pass rm.backbone(actuator, stretches).",
        )
    if ("scales_applied" in backbone.attrs) != ("scales_applied" in forced.attrs):
        raise InputError(
            "backbone",
            must="have the units of the response",
            got="one of the two in SI",
            why="They share their axes.",
            fix="Convert both by rm.to_si, or none.",
        )
