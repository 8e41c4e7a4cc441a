"""Thresholds of systems of one's own: folds, crossings and dynamic thresholds, labelled."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remanent._errors import InputError
from remanent._status import Status
from remanent._typing import FloatArray, IntArray
from remanent.results.build import Labelled
from remanent.studies.ensemble.dataset import PerTrajectoryArray
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.statics._static_box import require_static_box
from remanent.studies.statics._written_body import WrittenBody
from remanent.studies.statics._written_folds import MeetingPoints, folds_and_crossings
from remanent.studies.statics._written_snaps import Thresholds, snap_thresholds

#: Columns of one member by name, each an array (point,).
_Columns = dict[str, NDArray[Any]]


def written_thresholds(
    ens: Ensemble,
    name: str,
    limits: tuple[float, float],
    state_box: Mapping[str, Any] | None,
    *,
    has_start: bool,
) -> tuple[dict[str, PerTrajectoryArray], dict[str, Labelled], NDArray[Any], FloatArray]:
    """Thresholds of every member of an ensemble.

    Parameters
    ----------
    ens : Ensemble
        Its initial states are those from which motions start.
    name : str
        The parameter.
    limits : (float, float)
        Its least and largest value.
    state_box : mapping of name to (lower, upper), or None
        What was passed.
    has_start : bool
        Whether a start was asked for.

    Returns
    -------
    variables, coordinates, status, box
    """
    bodies = [WrittenBody(ens, k) for k in range(ens.trajectory_count)]
    box = require_static_box(state_box, ens, bodies[0].unknown)
    snaps = moves_without_loss(ens)
    if has_start and not snaps:
        raise InputError(
            "initial",
            must="be left out for this system",
            got=ens.system,
            why="How far a motion goes follows from conservation of energy only with one "
            "coordinate, and nothing that dissipates.",
            fix="Leave it out: the folds are found without. Try steps with simulate.",
        )
    rows: dict[str, list[_Columns]] = {"fold": [], "branch_point": []}
    rows |= {"snap": []} if snaps else {}
    reasons = []
    for body, invalid in zip(bodies, ens.is_invalid, strict=True):
        found = _thresholds_of_body(body, name, limits, box[:0] if invalid else box, snaps=snaps)
        for dim, columns in found[0].items():
            rows[dim].append(columns)
        reasons.append(found[1])
    variables: dict[str, PerTrajectoryArray] = {"reason": np.array(reasons)}
    coords: dict[str, Labelled] = {}
    for dim, members in rows.items():
        columns = stack_columns(members)
        variables |= {f"{dim}_{k}": ((dim,), column) for k, column in columns.items()}
        coords[dim] = ((dim,), np.arange(columns[name].shape[1]))
    words = np.where(np.array(reasons) != "", Status.INCOMPLETE, Status.OK)
    status = np.where(ens.is_invalid, Status.INVALID, words).astype(np.int8)
    return variables, coords, status, box


def moves_without_loss(ens: Ensemble) -> bool:
    """Whether motions have one coordinate and keep their energy."""
    field = ens.vector_field
    return ens.system.conservative and bool(field.energy_names) and len(field.state_names) == 2


def written_fold_columns(
    ens: Ensemble,
    box: FloatArray,
    name: str,
    cases: IntArray,
    bounds: tuple[FloatArray, FloatArray],
) -> tuple[dict[str, NDArray[Any]], list[str]]:
    """Columns of the folds of some members, each an array (case, fold), and what may be missing.

    Parameters
    ----------
    ens : Ensemble
    box : array (unknown, 2)
    name : str
        The parameter.
    cases : array (case,)
        Members of the ensemble.
    bounds : two arrays (case,)
        Least and largest value of the parameter.
    """
    members, reasons = [], []
    for case, low, high in zip(cases, *bounds, strict=True):
        body = WrittenBody(ens, int(case))
        folds, _, reason = folds_and_crossings(body, name, (float(low), float(high)), box)
        members.append(_columns_of_meeting(body, name, folds))
        reasons.append(reason)
    return stack_columns(members), reasons


def stack_columns(members: Sequence[_Columns]) -> _Columns:
    """Columns of members as arrays (member, point), NaN or empty text after the last."""
    width = max((len(next(iter(one.values()))) for one in members), default=0)
    stacked: _Columns = {}
    for key in members[0] if members else ():
        first = members[0][key]
        blank = "" if first.dtype.kind == "U" else np.nan
        rows = np.full((len(members), width), blank, dtype=first.dtype)
        for row, one in zip(rows, members, strict=True):
            row[: len(one[key])] = one[key]
        stacked[key] = rows
    return stacked


def _thresholds_of_body(
    body: WrittenBody, name: str, limits: tuple[float, float], box: FloatArray, *, snaps: bool
) -> tuple[dict[str, _Columns], str]:
    """Columns by dimension; none where there is no box, of a member that is invalid."""
    nothing = np.empty(0)
    folds = crossings = MeetingPoints(
        np.empty((0, body.dimension)), np.empty((0, body.dimension)), nothing, nothing,
        np.empty(0, dtype="<U9"),
    )  # fmt: skip
    thresholds, reasons = Thresholds(nothing, nothing, nothing, nothing, nothing), [""]
    if len(box):
        folds, crossings, reason = folds_and_crossings(body, name, limits, box)
        reasons.append(reason)
        if snaps:
            start = float(body.ens.initial_states[body.case, body.unknown[0]])
            thresholds, reason = snap_thresholds(body, name, limits, box, start)
            reasons.append(reason)
    columns = {
        "fold": _columns_of_meeting(body, name, folds),
        "branch_point": _columns_of_meeting(body, name, crossings),
    }
    if snaps:
        places = thresholds.places[:, None], thresholds.place_errors[:, None]
        columns["snap"] = {
            **_columns_of_places(body, name, (thresholds.values, thresholds.value_errors), *places),
            "direction": thresholds.directions,
        }
    return columns, "; ".join(dict.fromkeys(one for one in reasons if one))


def _columns_of_meeting(body: WrittenBody, name: str, points: MeetingPoints) -> _Columns:
    values = points.values, points.value_errors
    return {
        **_columns_of_places(body, name, values, points.places, points.place_errors),
        "stability": points.stability,
    }


def _columns_of_places(
    body: WrittenBody,
    name: str,
    values: tuple[FloatArray, FloatArray],
    places: FloatArray,
    errors: FloatArray,
) -> _Columns:
    """The parameter, the unknowns and the observable there, with errors."""
    field = body.ens.vector_field
    columns: _Columns = {name: values[0], f"{name}_error": values[1]}
    for position, k in enumerate(body.unknown):
        state = field.state_names[k]
        columns[state], columns[f"{state}_error"] = places[:, position], errors[:, position]
    if field.observable_name not in field.state_names:
        pair = body.observable_with_error(
            field.observable_name, body.states(places), errors, {name: values[0]}
        )
        columns["observable"], columns["observable_error"] = pair
    return columns
