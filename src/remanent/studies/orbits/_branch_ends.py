"""Why curves end, in the words of results, and what that means for their status."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remanent._status import Status
from remanent._typing import IntArray
from remanent.analysis.orbits.curves import Curve
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.orbits._members import stack_padded

#: What results call the ends of curves that their users cannot know under another name.
_RESULT_NAME_OF_END_REASON = MappingProxyType(
    {"points": "max_points", "branching": "period doubling"}
)
#: Length of the longest reason for an end.
END_REASON_DTYPE = "<U15"
#: Labels of the two ends: before the first point and after the last.
END_LABELS = ("first", "last")
#: What stopped a curve that could be followed further, and the remedy.
_WHY_UNFINISHED = MappingProxyType(
    {
        "max_points": "has as many points as max_points allows; pass a larger number",
        "lost": "was lost: steps became too short for the accuracy of the map",
    }
)


@dataclass(frozen=True)
class CurveEnds:
    """Why the curves of one system ended.

    Attributes
    ----------
    reasons : array (curve, end) of str
        ``bounds``, ``closed``, ``period doubling``, ``max_points`` or ``lost``.
    bounds : array (curve, end) of str
        The parameter or state variable that reached its bound; "" where none did.
    """

    reasons: NDArray[Any]
    bounds: NDArray[Any]


def ends_of_curves(curves: Sequence[Curve], unknown_names: Sequence[str]) -> CurveEnds:
    """The ends of some curves.

    Parameters
    ----------
    curves : sequence of Curve
    unknown_names : sequence of str
        Of the unknowns along them.
    """
    reasons = [
        [_RESULT_NAME_OF_END_REASON.get(reason, reason) for reason in curve.end_reasons]
        for curve in curves
    ]
    bounds = [
        [unknown_names[k] if k >= 0 else "" for k in curve.bounded_unknowns] for curve in curves
    ]
    ends = len(END_LABELS)
    width = max(map(len, unknown_names), default=1)
    return CurveEnds(
        np.array(reasons, dtype=END_REASON_DTYPE).reshape(-1, ends),
        np.array(bounds, dtype=f"<U{width}").reshape(-1, ends),
    )


def stack_ends(ends: Sequence[CurveEnds | None], count: int) -> CurveEnds:
    """The ends of curves of several members, arrays (member, curve, end), padded with ""."""
    missing = CurveEnds(
        np.full((count, len(END_LABELS)), "", dtype=END_REASON_DTYPE),
        np.full((count, len(END_LABELS)), "", dtype="<U1"),
    )
    known = [missing if one is None else one for one in ends]
    return CurveEnds(
        stack_padded([one.reasons for one in known], missing.reasons),
        stack_padded([one.bounds for one in known], missing.bounds),
    )


def member_status(
    ens: Ensemble,
    ends: Sequence[CurveEnds | None],
    missing: Status,
    free_bounds: Collection[str],
    search_reasons: Sequence[str] | None = None,
) -> tuple[IntArray, NDArray[Any]]:
    """Status of each member, and what stopped it early: arrays (member,) of int and of str.

    A curve is incomplete that ended before the range of its parameter did, at no bound that
    was asked for; curves are where the search for orbits to start from was.

    Parameters
    ----------
    ens : Ensemble
    ends : sequence of CurveEnds or None
        Of the curves of each member; None where nothing was found.
    missing : Status
        What it means that nothing was found.
    free_bounds : collection of str
        State variables whose bounds are those by default.
    search_reasons : sequence of str, optional
        Why the search for orbits to start from was incomplete, for each member; "" where it
        was not.
    """
    status, reasons = [], []
    searches = search_reasons or [""] * len(ends)
    for known, invalid, search in zip(ends, ens.is_invalid, searches, strict=True):
        words = (
            [] if known is None else [*filter(None, [search]), *_what_stopped(known, free_bounds)]
        )
        reasons.append("; ".join(words))
        status.append(
            Status.INVALID if invalid
            else missing if known is None
            else Status.INCOMPLETE if words
            else Status.OK
        )  # fmt: skip
    return np.array(status), np.array(reasons, dtype=np.str_)


def _what_stopped(ends: CurveEnds, free_bounds: Collection[str]) -> list[str]:
    """A clause for each end at which a curve stopped early."""
    words = []
    several = len(ends.reasons) > 1
    for number, (reasons, bounds) in enumerate(zip(ends.reasons, ends.bounds, strict=True)):
        for label, reason, bound in zip(END_LABELS, reasons, bounds, strict=True):
            why = _WHY_UNFINISHED.get(str(reason), "")
            if bound in free_bounds:
                why = f"left the box of states, where {bound} has its bound; pass state_box"
            if why:
                curve = f"branch {number}" if several else "the curve"
                words.append(f"{curve} at its {label} point {why}")
    return words
