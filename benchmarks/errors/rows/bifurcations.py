"""Folds and period doublings: located from nearby, and on branches through them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import xarray as xr

import remanent as rm
from benchmarks.errors.row import Judged, Row, shared
from benchmarks.errors.rows.branches import SAME, TOLERANCES, Case, random_case
from benchmarks.errors.special_points import at, special_point
from remanent._typing import FloatArray

#: Systems beside the one whose branch showed a special point, and how far their fields are off.
_NEIGHBOURS = 48
_RELATIVE_DISTANCE = 0.03
#: Fields in which they differ.
_FIELDS = ("c", "temperature", "b")
#: Half the range of frequencies of the branch through a special point, where it starts, and how
#: many points it has in each direction.
_HALF_RANGE = 0.2
_START = 0.0003
_POINTS = 32


@shared
def _located(rng: np.random.Generator, kind: str) -> Iterator[tuple[Case, xr.Dataset, FloatArray]]:
    """Special points of neighbours of one system: as they are located, and as they are."""
    case = random_case(rng, bifurcating=True)
    branch = case.branch()
    if branch is None or kind not in branch.special_kind.values:
        return
    one = branch.isel(special=int(rng.choice(np.flatnonzero(branch.special_kind.values == kind))))
    state = [float(one[f"special_{name}"]) for name in ("stretch", "stretch_rate")]
    factors = 1.0 + _RELATIVE_DISTANCE * rng.uniform(-1.0, 1.0, (len(_FIELDS), _NEIGHBOURS))
    over = {
        name: xr.DataArray(case.values[name] * row, dims="case")
        for name, row in zip(_FIELDS, factors, strict=True)
    }
    found = rm.locate_bifurcation(
        case.body, case.drive.replace(omega=float(one.special_omega)), kind, "omega",
        initial=state, over=over, tolerance=case.tolerance,
    )  # fmt: skip
    for k in np.flatnonzero(found.status.values == rm.Status.OK):
        there = found.isel(case=int(k))
        values = {**case.values, **{name: float(column[k]) for name, column in over.items()}}
        neighbour = replace(case, values={**values, "omega": float(there.omega)})
        place = [float(there[name]) for name in ("stretch", "stretch_rate", "omega")]
        exact = special_point(neighbour.reference, kind, "omega", place, 1)
        if exact is not None and np.abs(np.array(place) - exact).max() < SAME:
            yield neighbour, there, exact


def _locations(rng: np.random.Generator) -> Iterator[tuple[str, Judged]]:
    kind = str(rng.choice(["fold", "period doubling"]))
    for case, found, exact in _located(rng, kind):
        place = np.array([float(found[name]) for name in ("stretch", "stretch_rate", "omega")])
        off = np.abs(place - exact).astype(float)
        yield "omega", case.judged(kind, found.omega_error, off[2])
        yield "state", case.judged(kind, found.error, off[:2].max())


@shared
def _on_branches(rng: np.random.Generator, kind: str) -> Iterator[tuple[str, Judged]]:
    """Special points on short branches through them: parameter, state and amplitude."""
    side = 1.0
    for located, _, exact in _located(rng, kind):
        case = replace(located, tolerance=10.0 ** rng.uniform(*TOLERANCES))
        branch = _short_branch(case, exact, side)
        if branch is None:  # a fold: orbits are on the other side
            side = -side
            branch = _short_branch(case, exact, side)
        if branch is None or kind not in branch.special_kind.values:
            continue
        those = branch.isel(special=np.flatnonzero(branch.special_kind.values == kind))
        one = those.isel(special=int(np.abs(those.special_omega.values - float(exact[2])).argmin()))
        names = ("stretch", "stretch_rate", "omega")
        place = np.array([float(one[f"special_{name}"]) for name in names])
        off = np.abs(place - exact).astype(float)
        if off.max() > SAME:
            continue
        low, high = at(case.reference, "omega", exact[2]).extremes(exact[:2], 1)
        apart = abs(float(one.special_amplitude) - 0.5 * (high - low))
        yield "omega", case.judged(kind, one.special_error, off[2])
        yield "state", case.judged(kind, one.special_state_error, off[:2].max())
        yield "amplitude", case.judged(kind, one.special_amplitude_error, apart)


def _short_branch(case: Case, exact: FloatArray, side: float) -> xr.Dataset | None:
    """A branch through a special point, from an orbit beside it; None where there is none."""
    omega = float(exact[2])
    values = {**case.values, "omega": omega + side * _START}
    limits = (omega - _HALF_RANGE, omega + _HALF_RANGE)
    beside = replace(case, values=values, limits=limits)
    return beside.branch(initial=exact[:2].astype(float), max_points=_POINTS)


def _of(
    what: str, numbers: Callable[..., Any], *args: str
) -> Callable[[np.random.Generator], Iterator[Judged]]:
    return lambda rng: (judged for name, judged in numbers(rng, *args) if name == what)


ROWS = (
    *(
        Row(f"{words} of {kind}s", f"continue_orbit: {error}", _of(what, _on_branches, kind))
        for kind in ("fold", "period doubling")
        for what, words, error in (
            ("omega", "parameters", "special_error"),
            ("state", "states", "special_state_error"),
            ("amplitude", "amplitudes", "special_amplitude_error"),
        )
    ),
    Row(
        "parameters of located bifurcations",
        "locate_bifurcation: omega_error",
        _of("omega", _locations),
    ),
    Row("states at located bifurcations", "locate_bifurcation: error", _of("state", _locations)),
)
