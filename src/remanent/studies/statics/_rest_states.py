"""Every state of rest of a body under a constant load, and between which barriers each lies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from remanent._field import Role
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.statics.equilibria import find_force_zeros, force_slope
from remanent.studies.statics._biaxial import (
    acceleration_derivatives_by_stretch,
    biaxial_stretch_error,
    equilibria_of_case,
)
from remanent.studies.statics._static_ensemble import StaticEnsemble
from remanent.studies.statics._static_errors import stretch_error
from remanent.studies.statics._static_state import StaticState

#: Bodies whose forces are tabulated together, so that memory is needed for these only.
_CASES_PER_BATCH = 64
#: Time of the descent along the forces by which the valley of a state is found.
_DESCENT_DURATION = 1e4
#: Relative error of that descent.
_DESCENT_TOLERANCE = 1e-8
#: Distance from rest, at its end, of a descent that has come down.
_DESCENT_REACH = 1e-3


@dataclass(frozen=True)
class RestStates:
    """The states of rest of one body.

    Attributes
    ----------
    static : StaticEnsemble
        The body is one of its cases.
    case_index : int
    stretches : array (rest, coordinate)
        Of each coordinate; with one coordinate ascending.
    potential : array (rest,)
    is_stable : array (rest,) of bool
    """

    static: StaticEnsemble
    case_index: int
    stretches: FloatArray
    potential: FloatArray
    is_stable: BoolArray

    def well_of(self, state: FloatArray, energy: float) -> int | None:
        """Number of the state of rest about which a motion is caught, if it is.

        A motion whose energy does not grow stays where the potential is no larger.  It is caught
        where that region holds one stable state of rest and its edge no other.

        Parameters
        ----------
        state : array (state,)
        energy : float
            Of the state, with what it may be off by.
        """
        place = state[self.static.ensemble.vector_field.indices_of_roles(Role.COORDINATE)]
        if self.stretches.shape[1] == 1:
            return self._well_between_barriers(float(place[0]), energy)
        barriers = self.potential[~self.is_stable]
        if not self.is_stable.any() or not (energy < barriers).all():
            return None
        return self._well_downhill(place)

    def _well_between_barriers(self, stretch: float, energy: float) -> int | None:
        """Of one coordinate: the stable state between the nearest unstable ones."""
        x = self.stretches[:, 0]
        below = np.flatnonzero(~self.is_stable & (x <= stretch))
        above = np.flatnonzero(~self.is_stable & (x > stretch))
        first = below[-1] + 1 if below.size else 0
        last = above[0] if above.size else x.size
        barriers = self.potential[[*below[-1:], *above[:1]]]
        if last - first != 1 or not (energy < barriers).all():
            return None
        return int(first)

    def _well_downhill(self, place: FloatArray) -> int | None:
        """Of two coordinates: where the forces lead, down the potential."""

        def forces(_: float, stretches: FloatArray) -> FloatArray:
            case = np.full(1, self.case_index)
            return np.array(
                [float(a[0]) for a in self.static.accelerations(case, *stretches[:, None])]
            )

        way = solve_ivp(
            forces, (0.0, _DESCENT_DURATION), place, method="LSODA", rtol=_DESCENT_TOLERANCE
        )
        distance = np.abs(self.stretches - way.y[:, -1]).max(axis=1)
        distance = np.where(self.is_stable, distance, np.inf)
        nearest = int(np.argmin(distance))
        return nearest if distance[nearest] < _DESCENT_REACH else None

    def body(self, number: int) -> StaticState:
        """One of the states of rest."""
        ens, case = self.static.ensemble, np.full(1, self.case_index)
        row = [
            ens.parameter_values[name][self.case_index] for name in ens.vector_field.parameter_names
        ]
        state = self.static.states_at(case, *self.stretches[number][:, None])[0]
        return StaticState(ens.vector_field, np.array(row, dtype=np.float64), state)


def thickness_errors(chosen: Sequence[tuple[RestStates, int]]) -> FloatArray:
    """Errors of the thickness stretches of states of rest, each by its number, array (state,)."""
    errors = np.full(len(chosen), np.nan)
    ensembles = {id(rests.static): rests.static for rests, _ in chosen}
    for key, static in ensembles.items():
        rows = [k for k, (rests, _) in enumerate(chosen) if id(rests.static) == key]
        case = np.array([chosen[k][0].case_index for k in rows])
        stretches = np.array([chosen[k][0].stretches[chosen[k][1]] for k in rows])
        errors[rows] = _thickness_errors_of_ensemble(static, case, stretches)
    return errors


def _thickness_errors_of_ensemble(
    static: StaticEnsemble, case: IntArray, stretches: FloatArray
) -> FloatArray:
    """The same of stretches (state, coordinate) of one ensemble."""
    count = stretches.shape[1]
    error = (
        stretch_error(static, case, *stretches.T)[:, None]
        if count == 1
        else biaxial_stretch_error(static, case, *stretches.T)
    )
    pieces = [
        static.thickness_with_rounding(case, *np.roll(stretches, -k, axis=1).T)
        for k in range(count)
    ]
    slopes = np.stack([np.abs(piece.slope.value) for piece in pieces], axis=-1)
    return np.asarray(pieces[0].value.bound + (slopes * error).sum(axis=-1))


def rest_states_of_cases(static: StaticEnsemble, cases: IntArray) -> Iterator[RestStates]:
    """The states of rest of some bodies of an ensemble, in this order."""
    if static.ensemble.vector_field.indices_of_roles(Role.COORDINATE)[1:]:
        yield from (_biaxial_rest_states(static, int(k)) for k in cases)
        return
    grid = static.stretch_grid
    for begin in range(0, cases.size, _CASES_PER_BATCH):
        batch = cases[begin : begin + _CASES_PER_BATCH]
        zeros = _force_zeros(static, batch, grid if grid.ndim == 1 else grid[batch])
        yield from (
            _uniaxial_rest_states(static, int(k), x[np.isfinite(x)])
            for k, x in zip(batch, zeros, strict=True)
        )


def _force_zeros(static: StaticEnsemble, cases: IntArray, grid: FloatArray) -> FloatArray:
    """Stretches (case, rest) of some bodies, NaN where there are fewer."""
    return find_force_zeros(lambda i, x: static.first_acceleration(cases[i], x), cases.size, grid)


def _uniaxial_rest_states(static: StaticEnsemble, k: int, stretch: FloatArray) -> RestStates:
    case = np.full(stretch.size, k)
    return RestStates(
        static,
        k,
        stretch[:, None],
        static.potential(case, stretch),
        force_slope(static.first_acceleration, case, stretch) < 0.0,
    )


def _biaxial_rest_states(static: StaticEnsemble, k: int) -> RestStates:
    stretches = equilibria_of_case(static, k)
    case = np.full(len(stretches), k)
    matrix = acceleration_derivatives_by_stretch(static, case, *stretches.T)
    return RestStates(
        static,
        k,
        stretches,
        static.potential(case, *stretches.T),
        np.asarray((np.linalg.eigvals(matrix).real < 0.0).all(axis=-1)),
    )
