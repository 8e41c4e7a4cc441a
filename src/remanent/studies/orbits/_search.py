"""Every periodic orbit of one actuator at some values of a parameter: guesses, then Newton."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from remanent._errors import InputError
from remanent._field import Role, StateVariable
from remanent._roots import find_root
from remanent._typing import FloatArray
from remanent.analysis.orbits.periodic_orbits import Orbits, distinct_orbits, newton_fixed_points
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.initial import rest_values
from remanent.studies.orbits._period_map import StroboscopicMap

#: Default box: stretches, and their rates.
STRETCHES, RATES = (0.3, 4.0), (-8.0, 8.0)
#: Kelvin around the surroundings in which a body's temperature is looked for.
WARMTH = 5.0
#: Tolerance and largest resolution of the search: guesses that need more lead nowhere.
_ROUGH, _COARSE = 1e-6, 128
#: Guesses along the symmetry line.
_LINE = 600
#: Guesses in the box, along each stretch and rate, by their number: where orbits are looked
#: for at one place only, and where at many or where most are on the symmetry line.
_DENSE = MappingProxyType({2: (36, 25), 4: (7, 5, 7, 5)})
_SPARSE = MappingProxyType({2: (14, 9), 4: (5, 3, 5, 3)})


@dataclass(frozen=True)
class Search:
    """Where and how orbits are looked for.

    Attributes
    ----------
    map
        Over one drive period; its parameters are the columns of `parameters` below.
    box : array (state, 2)
    period
        Of the orbits, in drive periods.
    tolerance
        Of the residual.
    symmetric
        Undamped, with a load that is even in time: symmetric orbits start at zero rate.
    dense
        Whether to spend many guesses.
    """

    map: StroboscopicMap
    box: FloatArray
    period: int
    tolerance: float
    symmetric: bool
    dense: bool = True


def box_of(ens: Ensemble, bounds: Mapping[str, Any] | None) -> FloatArray:
    """Lower and upper bounds of every state variable, array (state, 2)."""
    state = ens.field.state
    given = dict(bounds or {})
    for name in given:
        if name not in state:
            raise InputError(
                "bounds",
                must=f"name state variables, {', '.join(state)}",
                got=repr(name),
                why="Orbits are looked for in a box of states.",
                fix="Pass {'stretch': (0.3, 4.0)}.",
            )
    rows = []
    for variable in ens.field.variables:
        name = variable.name
        pair = np.asarray(given.get(name, _default(variable, ens)), float)
        if pair.shape != (2,) or not np.isfinite(pair).all() or not pair[0] < pair[1]:
            raise InputError(
                "bounds",
                must=f"give {name} a lower and a larger upper number",
                got=repr(given[name]),
                why="Orbits are looked for in a box of states.",
                fix="Pass {'stretch': (0.3, 4.0)}.",
            )
        if variable.positive and pair[0] <= 0.0:
            raise InputError(
                "bounds",
                must=f"keep {name} above 0",
                got=float(pair[0]),
                why="A stretch is a ratio of lengths.",
                fix="Pass {'stretch': (0.3, 4.0)}.",
            )
        rows.append(pair)
    return np.array(rows)


def _default(variable: StateVariable, ens: Ensemble) -> tuple[float, float]:
    """Bounds of a state variable that none were given for."""
    if variable.role is Role.TEMPERATURE:
        around = rest_values(variable, ens.values, ens.count)
        return float(around.min()) - WARMTH, float(around.max()) + WARMTH
    return RATES if variable.role is Role.RATE else STRETCHES


def require_isolated(ens: Ensemble) -> None:
    """Refuse adiabatic bodies: they warm for ever, or have an orbit for each entropy."""
    warms = bool(ens.field.indices(Role.TEMPERATURE))
    if warms and not (ens.values["heat.exchange"] > 0.0).all():
        raise InputError(
            "system",
            must="exchange heat where its temperature is a state",
            got=ens.system,
            why="Without exchange it warms for ever, or has an orbit for every temperature.",
            fix="Pass rm.Heat(exchange=...) above 0, or heat=None.",
        )


def is_symmetric(system: System, drive: Drive) -> bool:
    """Whether reversing time leaves the motion's equation as it is."""
    period = drive.period
    if period is None or not system.conservative:
        return False
    times = np.linspace(0.0, 0.5, 33) * period
    ahead, back = drive(times), drive(period - times)
    return bool(np.allclose(ahead, back, rtol=0.0, atol=1e-13 * (1.0 + np.abs(ahead).max())))


def all_orbits(search: Search, parameters: FloatArray) -> list[Orbits]:
    """The orbits in the box, for each of some values of the map's parameters.

    Parameters
    ----------
    parameters : array (case, parameter)

    Returns
    -------
    list of Orbits
        One entry a case.
    """
    box = _in_box(search)
    line = [np.empty((0, search.map.dimension))] * len(parameters)
    if search.symmetric and search.map.dimension == 2:
        line = _on_line(search, parameters)
    rough = replace(search.map, tolerance=_ROUGH, most=_COARSE)
    found = []
    for row, own in zip(parameters, line, strict=True):
        near = _closed(search, rough, np.concatenate([own, box]), row, 10.0 * _ROUGH)
        found.append(_closed(search, search.map, near.state, row, search.tolerance))
    return found


def _closed(
    search: Search, map_: StroboscopicMap, guesses: FloatArray, row: FloatArray, tolerance: float
) -> Orbits:
    """Different orbits that Newton's method reaches from guesses."""
    orbits = newton_fixed_points(
        map_, guesses, np.tile(row, (len(guesses), 1)),
        iterate=search.period, tolerance=tolerance, box=search.box, max_error=10.0 * _ROUGH,
    )  # fmt: skip
    return distinct_orbits(map_, orbits, row, iterate=search.period)


def _in_box(search: Search) -> FloatArray:
    """A grid of guesses, denser in stretch where stretch is small.

    What is internal is guessed from the stretches: relaxed, at the temperature outside.
    """
    field = search.map.ensemble.field
    moving = field.indices(Role.COORDINATE, Role.RATE)
    counts = (_DENSE if search.dense else _SPARSE)[len(moving)]
    axes = [
        np.geomspace(low, high, n) if low > 0.0 else np.linspace(low, high, n)
        for (low, high), n in zip(search.box[moving], counts, strict=True)
    ]
    grid = np.stack([axis.ravel() for axis in np.meshgrid(*axes, indexing="ij")], axis=1)
    guesses = np.tile(search.box.mean(axis=1), (len(grid), 1))
    guesses[:, moving] = grid
    for k in field.indices(Role.INTERNAL):
        coordinate = field.variables[k].belongs_to
        if coordinate is not None:
            guesses[:, k] = guesses[:, field.state.index(coordinate)]
    return guesses


def _on_line(search: Search, parameters: FloatArray) -> list[FloatArray]:
    """Starts of symmetric orbits: at rest at phase 0 and half their period later.

    An orbit of even period may instead be at rest at phase 1/2 twice.
    """
    late = (False, True) if search.period % 2 == 0 else (False,)
    parts = [_symmetric(search, parameters, half) for half in late]
    return [np.concatenate(own) for own in zip(*parts, strict=True)]


def _symmetric(search: Search, parameters: FloatArray, late: bool) -> list[FloatArray]:
    """Those at rest at phase 0, or at phase 1/2; their states at phase 0."""
    map_ = replace(search.map, phase=0.5 if late else 0.0, tolerance=_ROUGH, most=4 * _COARSE)
    q = search.period

    def rate(stretch: FloatArray, case: FloatArray) -> FloatArray:
        states = np.column_stack([stretch, np.zeros(stretch.size)])
        own = parameters[case.astype(np.int64)]
        return map_.run(states, own, q // 2, half=q % 2 == 1).state[:, 1]

    grid = np.geomspace(search.box[0, 0], search.box[0, 1], _LINE)
    case = np.repeat(np.arange(len(parameters), dtype=float), grid.size)
    values = rate(np.tile(grid, len(parameters)), case).reshape(-1, grid.size)
    with np.errstate(invalid="ignore"):
        row, k = np.nonzero(values[:, :-1] * values[:, 1:] <= 0.0)
    if not row.size:
        return [np.empty((0, 2))] * len(parameters)
    root = find_root(
        rate, (grid[k], grid[k + 1]), args=(row.astype(float),),
        tolerances={"xatol": 1e-7, "xrtol": 1e-7, "fatol": 0.0, "frtol": 0.0},
    )  # fmt: skip
    states = np.column_stack([root.x, np.zeros(row.size)])
    if late:
        states = map_.run(states, parameters[row], 0, half=True).state
    return [states[root.success & (row == k)] for k in range(len(parameters))]


def nearest_rest(orbits: Orbits, ens: Ensemble) -> Orbits:
    """The orbit whose point is nearest to rest, alone."""
    rest = [float(rest_values(v, ens.values, ens.count)[0]) for v in ens.field.variables]
    k = int(np.argmin(np.linalg.norm(orbits.state - rest, axis=1)))
    return orbits.subset(np.array([k]))
