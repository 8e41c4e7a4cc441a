"""What a result does not hold, by name: lost runs, gaps, early ends, searches cut short."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.markers import TICKUP, MarkerStyle
from numpy.typing import NDArray

from remanent._status import Status
from remanent.plots import style
from remanent.plots.ensemble import Member

__all__ = [
    "NO_RESULT",
    "cut_cloud_entries",
    "has_values",
    "incomplete_note",
    "mark_ends",
    "mark_gaps",
    "status_words",
    "why_missing",
    "write_in_empty_frame",
]

#: Status codes under which nothing is missing for a reason that the code could tell.
_SILENT_STATUS_CODES: Final = frozenset({int(Status.OK)})
#: Mark of a line that stops before its end.
_END_MARKER: Final = "x"
#: Words where the status is no reason.
NO_RESULT: Final = "no result"
#: Mark at a value without a result; on the lower edge of axes it stands inside.
_GAP_MARKER: Final = "|"
_GAP_MARKER_ON_EDGE: Final = MarkerStyle(TICKUP)
#: Most clouds that stop early of which each is named.
_MAX_CUT_CLOUD_COUNT: Final = 4
#: Most reasons that are written out.
_MAX_REASON_COUNT: Final = 2


def has_values(member: Member, *variables: str) -> bool:
    """Whether a member has finite values of all of some variables."""
    return all(bool(np.isfinite(member.data[name].values).any()) for name in variables)


def status_words(codes: Iterable[float]) -> str:
    """The meanings of status codes, without those that say nothing is amiss.

    Parameters
    ----------
    codes : iterable of number
        Values of a ``status``; NaN, which arithmetic with results leaves, says nothing.

    Returns
    -------
    str

    Examples
    --------
    >>> status_words([1, 3, 3])
    'escaped'
    """
    known = {int(code) for code in Status}
    found = sorted({int(code) for code in codes if np.isfinite(code)} - _SILENT_STATUS_CODES)
    return ", ".join(Status(code).meaning for code in found if code in known)


def why_missing(member: Member, lost: xr.DataArray | None = None) -> str:
    """Words for what a member does not have: those of its status, or that there is no result.

    Parameters
    ----------
    member : Member
        With its ``status``, where it has one.
    lost : xarray.DataArray of bool, optional
        Where values are missing; everywhere by default.

    Returns
    -------
    str
    """
    status = member.data.get("status")
    if status is None:
        return NO_RESULT
    codes: NDArray[Any] = np.ravel(status.values)
    if lost is not None and set(status.dims) <= set(lost.dims):
        codes = xr.broadcast(status, lost)[0].transpose(*lost.dims).values[lost.values]
    words = status_words(codes)
    return f"{NO_RESULT}: {words}" if words else NO_RESULT


def mark_ends(axes: Axes, members: Sequence[Member], x: str, y: str) -> list[Line2D]:
    """Mark where lines stop before their end, and return a legend entry for each reason.

    A gap inside a line is named and not marked: it is seen.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What the lines were drawn in.
    members : sequence of Member
        With `x` and `y` along one dimension.
    x, y : str
        What was drawn against what.

    Returns
    -------
    list of matplotlib.lines.Line2D
    """
    reasons: dict[str, None] = {}
    gaps = False
    for member in members:
        across, up = member.data[x].values, member.data[y].values
        drawn = np.flatnonzero(np.isfinite(up) & np.isfinite(across))
        if not drawn.size:
            continue
        gaps = gaps or bool(drawn[-1] - drawn[0] >= drawn.size)
        if drawn[-1] < up.size - 1:
            end = across[drawn[-1]], up[drawn[-1]]
            axes.plot(*end, _END_MARKER, color=member.colour, ms=4.5, mew=1.1, zorder=6)
            reason = why_missing(member).removeprefix("no result").removeprefix(": ")
            reasons[reason or "no result from here on"] = None
    entries = [_mark_entry(_END_MARKER, reason) for reason in reasons]
    return entries + ([_mark_entry("", "gaps: no result")] if gaps else [])


def mark_gaps(
    axes: Axes, members: Sequence[Member], x: str, y: str, nothing: str = NO_RESULT
) -> list[Line2D]:
    """Mark values of `x` without a result on the lower edge; return their legend entries.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What the curves were drawn in.
    members : sequence of Member
        With `y` along the dimension of `x`, and others, of which all are missing together.
    x, y : str
        What was drawn against what.
    nothing : str
        Words for what is missing where the status is no reason.

    Returns
    -------
    list of matplotlib.lines.Line2D
    """
    reasons: dict[str, None] = {}
    for member in members:
        values = member.data[y]
        at = member.data[x]
        lost = values.copy(data=~np.isfinite(values.values))
        others = [dim for dim in values.dims if dim not in at.dims]
        gaps = lost.all(others)
        if at.ndim != 1 or not has_values(member, y) or not bool(gaps.any()):
            continue
        axes.plot(
            at.values[gaps.transpose(*at.dims).values], np.zeros(int(gaps.sum())),
            marker=_GAP_MARKER_ON_EDGE, color=member.colour, ms=5, mew=1.2, linestyle="",
            transform=axes.get_xaxis_transform(), clip_on=False, zorder=6,
        )  # fmt: skip
        reason = why_missing(member, gaps)
        reasons[nothing if reason == NO_RESULT else reason] = None
    return [_mark_entry(_GAP_MARKER, reason) for reason in reasons]


def cut_cloud_entries(members: Sequence[Member], x: str, y: str) -> list[Line2D]:
    """Legend entries, in words, of clouds of points that stop before their end.

    Parameters
    ----------
    members : sequence of Member
        With `x` and `y` along ``period`` alone.
    x, y : str
        What was drawn against what.

    Returns
    -------
    list of matplotlib.lines.Line2D
    """
    words: dict[str, str] = {}
    reasons: dict[str, None] = {}
    for member in members:
        drawn = np.isfinite(member.data[x].values) & np.isfinite(member.data[y].values)
        if not bool(drawn.any()) or bool(drawn.all()):
            continue
        reason = why_missing(member).removeprefix("no result").removeprefix(": ")
        count = f"{int(drawn.sum())} of {drawn.size} points"
        words[member.label] = ": ".join(filter(None, (count, reason)))
        reasons[reason] = None
    labels = [", ".join(filter(None, pair)) for pair in words.items()]
    if len(labels) > _MAX_CUT_CLOUD_COUNT:
        labels = [": ".join(filter(None, (f"{len(labels)} stop early", *reasons)))]
    return [Line2D([], [], linestyle="", marker="", label=label) for label in labels]


def write_in_empty_frame(axes: Axes, members: Sequence[Member], x: str, variable: str) -> None:
    """Say what happened where there is nothing to draw: a scale of nothing has no ticks.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        What would have been drawn in.
    members : sequence of Member
        What would have been drawn.
    x, variable : str
        Against what, and what has no value.
    """
    if any(has_values(member, x, variable) for member in members):
        return
    words = "\n".join(dict.fromkeys(why_missing(member) for member in members))
    axes.text(
        0.5, 0.5, words or "no result", transform=axes.transAxes, ha="center", va="center",
        color=style.ink_colour(),
    )  # fmt: skip
    if _has_finite_lines(axes):
        return
    axes.set_yticks([])
    places = np.concatenate([np.ravel(member.data[x].values) for member in members])
    places = places[np.isfinite(places)]
    if places.size and np.ptp(places) > 0.0:
        axes.set_xlim(places.min(), places.max())
    else:
        axes.set_xticks([])


def incomplete_note(dataset: xr.Dataset) -> str:
    """A sentence that says that a search or a branch stopped early, and what stopped it.

    Parameters
    ----------
    dataset : xarray.Dataset
        A result; ``status`` and ``reason`` where it has them, as variables or attributes.

    Returns
    -------
    str
        Empty where nothing stopped early.
    """
    status = dataset["status"].values if "status" in dataset else np.asarray(
        dataset.attrs.get("status", Status.OK)
    )  # fmt: skip
    early = np.ravel(status == int(Status.INCOMPLETE))
    if not early.any():
        return ""
    where = f" ({int(early.sum())} of {early.size})" if early.size > 1 else ""
    reasons = _reasons(dataset, early)
    return f"{Status.INCOMPLETE.meaning}{where}" + (f": {'; '.join(reasons)}" if reasons else "")


def _reasons(dataset: xr.Dataset, early: NDArray[Any]) -> list[str]:
    """The first few reasons of what stopped early."""
    if "reason" in dataset:
        values = np.ravel(dataset["reason"].values).astype(str)
        values = values[early] if values.size == early.size else values
    else:
        values = np.asarray([str(dataset.attrs.get("reason", ""))])
    found = [reason for reason in dict.fromkeys(values.tolist()) if reason]
    more = ["…"] if len(found) > _MAX_REASON_COUNT else []
    return [text.replace("$", r"\$") for text in found[:_MAX_REASON_COUNT]] + more


def _mark_entry(marker: str, label: str) -> Line2D:
    return Line2D(
        [], [], linestyle="", marker=marker, ms=4.5, mew=1.1, color=style.ink_colour(), label=label
    )


def _has_finite_lines(axes: Axes) -> bool:
    """Whether anything that was drawn before has a finite value."""
    return any(np.isfinite(np.asarray(line.get_ydata(), dtype=float)).any() for line in axes.lines)
