"""What is told of branches: columns along each, special points, and why each end ended."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._status import Status
from remanent._typing import IntArray
from remanent.analysis.orbits.bifurcations import SpecialPoint
from remanent.analysis.orbits.curves import CurvePoints
from remanent.analysis.orbits.errors import orbit_errors
from remanent.results.build import Labelled
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.orbits._members import stack_padded, stack_tables
from remanent.studies.orbits._orbit_tables import describe_orbits, empty_orbit_columns
from remanent.studies.orbits._tracing import Branch, TracingOptions

#: What results call the ends of curves that their users cannot know under another name.
_RESULT_NAME_OF_END_REASON = MappingProxyType({"points": "max_points"})
#: Length of the longest reason.
_END_REASON_DTYPE = "<U10"
#: Length of the longest kind of special point.
_SPECIAL_KIND_DTYPE = "<U15"
#: Reasons that leave a branch unfinished.
_UNFINISHED_END_REASONS = ("max_points", "lost")
#: Labels of the two ends: before the first point and after the last.
END_LABELS = ("first", "last")

#: Columns along points that have a value for each multiplier.
_COLUMNS_BY_MULTIPLIER = ("multipliers", "multipliers_error")
#: Columns along points that have one value.
_COLUMNS_BY_POINT = ("stability", "amplitude", "maximum", "minimum", "residual", "error")
#: Columns along special points that keep their name in results.
_COLUMNS_BY_SPECIAL_POINT = ("kind", "branch", "error", "amplitude")

#: Columns by name, each an array whose first axes are padded.
ColumnTable = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class BranchTablesOfSystem:
    """The branches of one system.

    Attributes
    ----------
    point_tables : list of Table
        Of each branch, columns along its points.
    special_point_table : Table
        Columns along the special points of all branches; ``branch`` is the number of theirs.
    end_reasons : array (branch, end) of str
    """

    point_tables: list[ColumnTable]
    special_point_table: ColumnTable
    end_reasons: NDArray[Any]


def end_reasons_of_curves(ends: Sequence[tuple[str, str]]) -> NDArray[Any]:
    """Why curves ended, array (curve, end): ``bounds``, ``closed``, ``max_points``, ``lost``."""
    words = [[_RESULT_NAME_OF_END_REASON.get(end, end) for end in both] for both in ends]
    return np.array(words, dtype=_END_REASON_DTYPE).reshape(-1, len(END_LABELS))


def describe_branches(
    ens: Ensemble, branches: list[Branch], options: TracingOptions
) -> BranchTablesOfSystem:
    """All that is told of the branches of one system.

    Parameters
    ----------
    ens : Ensemble
        Of one trajectory.
    branches : list of Branch
    options : TracingOptions
    """
    points = [_describe_points(ens, branch.curve.points, options) for branch in branches]
    rows = [
        _describe_special_point(ens, special, number, options)
        for number, branch in enumerate(branches)
        for special in branch.special_points
    ]
    special = {
        name: np.array([row[name] for row in rows], dtype=least.dtype).reshape(-1, *least.shape[1:])
        for name, least in _empty_special_point_table(len(ens.vector_field.state_names)).items()
    }
    return BranchTablesOfSystem(
        points, special, end_reasons_of_curves([branch.curve.end_reasons for branch in branches])
    )


def _describe_points(ens: Ensemble, points: CurvePoints, options: TracingOptions) -> ColumnTable:
    """Columns along points of a curve: orbits with their parameter."""
    values = points.unknown[:, -1]
    orbits = orbit_errors(
        options.tracing_of_member(ens).map, points.unknown[:, :-1], values[:, None],
        options.orbit_period,
    )  # fmt: skip
    columns = describe_orbits(ens, orbits, options.orbit_period, {options.parameter: values})
    return columns | {"parameter": values}


def _describe_special_point(
    ens: Ensemble, special: SpecialPoint, branch: int, options: TracingOptions
) -> dict[str, Any]:
    orbit = _describe_points(ens, special.point, options)
    return {
        "kind": special.kind,
        "branch": branch,
        "parameter": orbit["parameter"][0],
        "state": orbit["initial"][0],
        "error": special.parameter_error,
        "amplitude": orbit["amplitude"][0],
    }


def _empty_point_table(state_variables: int) -> ColumnTable:
    return empty_orbit_columns(state_variables) | {"parameter": np.empty(0)}


def _empty_special_point_table(state_variables: int) -> ColumnTable:
    return {
        "kind": np.empty(0, dtype=_SPECIAL_KIND_DTYPE),
        "branch": np.empty(0, dtype=np.int64),
        "parameter": np.empty(0),
        "state": np.empty((0, state_variables)),
        "error": np.empty(0),
        "amplitude": np.empty(0),
    }


def label_branches(
    ens: Ensemble,
    tables: Sequence[BranchTablesOfSystem | None],
    options: TracingOptions,
    *,
    single: bool = False,
    **settings: Any,
) -> xr.Dataset:
    """The branches of all members as a Dataset, padded where there are fewer or shorter ones.

    Parameters
    ----------
    ens : Ensemble
    tables : sequence of BranchTablesOfSystem or None
        Of each member; None where there is none.
    options : TracingOptions
    single : bool
        Whether each member has one branch, so that no dimension ``branch`` is needed.
    **settings
        What else decides the numbers, for the attributes.
    """
    points, special, end_reason = _join_members(ens, tables, least=1 if single else 0)
    if single:  # each member has one branch, or none and padding
        points = {name: column[:, 0] for name, column in points.items()}
        end_reason = end_reason[:, 0]
    rows = ("point",) if single else ("branch", "point")
    variables: dict[str, PerTrajectoryArray] = {
        options.parameter: (rows, points["parameter"]),
        **{
            name: (rows, points["initial"][..., k])
            for k, name in enumerate(ens.vector_field.state_names)
        },
        **{name: ((*rows, "multiplier"), points[name]) for name in _COLUMNS_BY_MULTIPLIER},
        **{name: (rows, points[name]) for name in _COLUMNS_BY_POINT},
        **{f"special_{name}": (("special",), special[name]) for name in _COLUMNS_BY_SPECIAL_POINT},
        f"special_{options.parameter}": (("special",), special["parameter"]),
        **{
            f"special_{name}": (("special",), special["state"][..., k])
            for k, name in enumerate(ens.vector_field.state_names)
        },
        "end_reason": ((*rows[:-1], "end"), end_reason),
    }
    sizes = dict(zip(rows, points["parameter"].shape[1:], strict=True))
    sizes |= {"multiplier": len(ens.vector_field.state_names), "special": special["kind"].shape[1]}
    coords: dict[str, Labelled] = {name: ((name,), np.arange(n)) for name, n in sizes.items()}
    coords["end"] = (("end",), np.array(END_LABELS))
    reasons = [None if table is None else table.end_reasons for table in tables]
    status = member_status(ens, reasons, Status.DIVERGED)
    return to_dataset(
        ens, variables, coords=coords, status=status, tolerance=options.tolerance,
        parameter_range=options.parameter_range, orbit_period=options.orbit_period, **settings,
    )  # fmt: skip


def _join_members(
    ens: Ensemble, tables: Sequence[BranchTablesOfSystem | None], *, least: int
) -> tuple[ColumnTable, ColumnTable, NDArray[Any]]:
    """Columns (member, branch, point, ...) and (member, special, ...), and ends of branches.

    There are as many branches as the member with most of them has, but not fewer than `least`.
    """
    d = len(ens.vector_field.state_names)
    no_points = stack_tables([None] * least, _empty_point_table(d))
    of_members = [
        None if table is None else stack_tables(table.point_tables, _empty_point_table(d))
        for table in tables
    ]
    points = stack_tables(of_members, no_points)
    special = stack_tables(
        [None if t is None else t.special_point_table for t in tables],
        _empty_special_point_table(d),
    )
    no_reason = np.full((least, len(END_LABELS)), "", dtype=_END_REASON_DTYPE)
    reasons = [no_reason if table is None else table.end_reasons for table in tables]
    return points, special, stack_padded(reasons, no_reason)


def member_status(
    ens: Ensemble, end_reason: Sequence[NDArray[Any] | None], missing: Status
) -> IntArray:
    """Status of each member, array (member,): incomplete where a curve stopped early.

    Parameters
    ----------
    ens : Ensemble
    end_reason : sequence of array of str, or None
        Of the curves of each member; None where nothing was found.
    missing : Status
        What it means that nothing was found.
    """
    return np.array(
        [
            Status.INVALID if invalid
            else missing if reasons is None
            else Status.INCOMPLETE if np.isin(reasons, _UNFINISHED_END_REASONS).any()
            else Status.OK
            for reasons, invalid in zip(end_reason, ens.is_invalid, strict=True)
        ]
    )  # fmt: skip
