"""What is told of branches: columns along each, special points, and why each end ended."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from remanent._status import Status
from remanent.analysis.orbits.bifurcations import SpecialPoint
from remanent.results.build import Labelled
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.orbits._branch_ends import (
    END_LABELS,
    CurveEnds,
    ends_of_curves,
    member_status,
    stack_ends,
)
from remanent.studies.orbits._branch_points import (
    MULTIPLIER_COLUMNS,
    POINT_COLUMNS,
    describe_branch,
    empty_point_columns,
    observe_orbits,
)
from remanent.studies.orbits._members import stack_tables
from remanent.studies.orbits._tracing import Branch, Tracing, TracingOptions

#: Length of the longest kind of special point.
_SPECIAL_KIND_DTYPE = "<U15"
#: Columns along special points that keep their name in results.
_COLUMNS_BY_SPECIAL_POINT = (
    "kind", "branch", "orbit_period", "error", "state_error", "amplitude", "amplitude_error",
)  # fmt: skip

#: Tolerance of extremes at special points, few and exactly known.
_SPECIAL_EXTREMES_TOLERANCE = 5e-11

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
    ends : CurveEnds
    missing : str
        Why branches may be missing; empty where none is.
    """

    point_tables: list[ColumnTable]
    special_point_table: ColumnTable
    ends: CurveEnds
    missing: str


def describe_branches(
    tracing: Tracing, branches: list[Branch], parameter: str, missing: str = ""
) -> BranchTablesOfSystem:
    """All that is told of the branches of one system.

    Parameters
    ----------
    tracing : Tracing
    branches : list of Branch
    parameter : str
        That varies along them.
    missing : str
        Why branches may be missing; empty where none is.
    """
    names = tracing.map.ensemble.vector_field.state_names
    points = [describe_branch(tracing, parameter, one) for one in branches]
    rows = [
        _describe_special_point(tracing, parameter, special, number, joins)
        for number, branch in enumerate(branches)
        for special, joins in zip(branch.special_points, branch.joins_shorter_period, strict=True)
    ]
    special = {
        name: np.array([row[name] for row in rows], dtype=least.dtype).reshape(-1, *least.shape[1:])
        for name, least in _empty_special_point_table(len(names)).items()
    }
    ends = ends_of_curves([branch.curve for branch in branches], [*names, parameter])
    return BranchTablesOfSystem(points, special, ends, missing)


def _describe_special_point(
    tracing: Tracing, parameter: str, special: SpecialPoint, branch: int, joins: bool
) -> dict[str, Any]:
    orbit = observe_orbits(
        tracing, parameter, special.point, special.error[None], _SPECIAL_EXTREMES_TOLERANCE
    )
    return {
        "kind": special.kind,
        "branch": branch,
        "orbit_period": tracing.orbit_period // 2 if joins else tracing.orbit_period,
        "parameter": special.point.unknown[0, -1],
        "state": special.point.unknown[0, :-1],
        "error": special.parameter_error,
        "state_error": special.state_error,
        "amplitude": orbit["amplitude"][0],
        "amplitude_error": orbit["amplitude_error"][0],
    }


def _empty_special_point_table(state_variables: int) -> ColumnTable:
    return {
        "kind": np.empty(0, dtype=_SPECIAL_KIND_DTYPE),
        "branch": np.empty(0, dtype=np.int64),
        "orbit_period": np.empty(0, dtype=np.int64),
        "parameter": np.empty(0),
        "state": np.empty((0, state_variables)),
        "error": np.empty(0),
        "state_error": np.empty(0),
        "amplitude": np.empty(0),
        "amplitude_error": np.empty(0),
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
        By which they were followed.
    single : bool
        Whether each member has one branch, so that no dimension ``branch`` is needed.
    **settings
        What else decides the numbers, for the attributes.
    """
    field = ens.vector_field
    observed = tuple(n for n in field.observable_and_rate_names if n not in field.state_names)
    least = empty_point_columns(len(field.state_names), options.orbit_period, observed)
    points, special, ends = _join_members(ens, tables, least, count=1 if single else 0)
    if single:  # each member has one branch, or none and padding
        points = {name: column[:, 0] for name, column in points.items()}
        ends = CurveEnds(ends.reasons[:, 0], ends.bounds[:, 0])
    rows = ("point",) if single else ("branch", "point")
    variables: dict[str, PerTrajectoryArray] = {
        options.parameter: (rows, points["parameter"]),
        **{name: (rows, points["initial"][..., k]) for k, name in enumerate(field.state_names)},
        **{name: ((*rows, "period"), points[name]) for name in observed},
        **{name: ((*rows, "multiplier"), points[name]) for name in MULTIPLIER_COLUMNS},
        **{name: (rows, points[name]) for name in POINT_COLUMNS},
        **{f"special_{name}": (("special",), special[name]) for name in _COLUMNS_BY_SPECIAL_POINT},
        f"special_{options.parameter}": (("special",), special["parameter"]),
        **{
            f"special_{name}": (("special",), special["state"][..., k])
            for k, name in enumerate(field.state_names)
        },
        "end_reason": ((*rows[:-1], "end"), ends.reasons),
        "end_bound": ((*rows[:-1], "end"), ends.bounds),
    }
    sizes = dict(zip(rows, points["parameter"].shape[1:], strict=True))
    sizes |= {"multiplier": len(field.state_names), "special": special["kind"].shape[1]}
    sizes |= {"period": options.orbit_period}
    coords: dict[str, Labelled] = {name: ((name,), np.arange(n)) for name, n in sizes.items()}
    coords["end"] = (("end",), np.array(END_LABELS))
    status, variables["reason"] = member_status(
        ens, [None if table is None else table.ends for table in tables], Status.DIVERGED,
        set(field.state_names) - set(options.state_box or {}),
        ["" if table is None else table.missing for table in tables],
    )  # fmt: skip
    return to_dataset(
        ens, variables, coords=coords, status=status, tolerance=options.tolerance,
        parameter_range=options.parameter_range, orbit_period=options.orbit_period, **settings,
    )  # fmt: skip


def _join_members(
    ens: Ensemble,
    tables: Sequence[BranchTablesOfSystem | None],
    least: ColumnTable,
    *,
    count: int,
) -> tuple[ColumnTable, ColumnTable, CurveEnds]:
    """Columns (member, branch, point, ...) and (member, special, ...), and ends of branches.

    There are as many branches as the member with most of them has, but not fewer than `count`.
    """
    no_points = stack_tables([None] * count, least)
    of_members = [
        None if table is None else stack_tables(table.point_tables, least) for table in tables
    ]
    points = stack_tables(of_members, no_points)
    special = stack_tables(
        [None if t is None else t.special_point_table for t in tables],
        _empty_special_point_table(len(ens.vector_field.state_names)),
    )
    return points, special, stack_ends([None if t is None else t.ends for t in tables], count)
