"""Rest under the mean of a load, and the free oscillations about it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from remanent._errors import InputError
from remanent._field import Role
from remanent._typing import FloatArray
from remanent.analysis.statics.equilibria import find_force_zeros, force_slope
from remanent.models.actuator import Actuator
from remanent.models.drives.waves import Constant
from remanent.models.own_systems.lagrangian_system import LagrangianSystem
from remanent.models.system import System
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.response._free_oscillations import free_oscillations
from remanent.studies.statics._static_ensemble import StaticEnsemble
from remanent.studies.statics._static_state import StaticState
from remanent.studies.statics._written_body import WrittenBody

#: Free oscillations that are compared.
_FREE_OSCILLATION_COUNT = 80
#: Smallest turning point they start from, relative to rest.
_SMALLEST_RELATIVE_TURNING_POINT = 1.001
#: Largest turning point they start from.
_LARGEST_RELATIVE_TURNING_POINT = 6.0
#: The same of systems of one's own, as shares of the way to the end of the box or to the next
#: equilibrium, which no oscillation reaches.
_TURNING_POINT_SHARES = (1e-3, 0.999)
#: Error of the free oscillations in the table, and of those at the peaks' amplitudes.
_FREE_OSCILLATION_TOLERANCES = (1e-6, 1e-10)
#: Oscillations through which a curve can be laid.
_FEWEST_OSCILLATIONS = 4
#: Equilibria are as near to the state at rest as each other within this share of the box.
_EQUALLY_NEAR_SHARE = 1e-9


@dataclass(frozen=True)
class MeanRest:
    """A system of one coordinate at rest under the mean of its load.

    Attributes
    ----------
    elastic : System
        The same without what takes energy.
    mean : float
        The load.
    turning_points : array (oscillation,)
        From which free oscillations about this rest start.
    natural_frequency : float
        Modulus of the eigenvalue of small oscillations; NaN where there are none.
    elastic_frequency : float
        The same of the elastic system.
    """

    elastic: System
    mean: float
    turning_points: FloatArray
    natural_frequency: float
    elastic_frequency: float


def rest_under_mean_load(system: System, mean: float, state_box: FloatArray) -> MeanRest:
    """Where a system is at rest under the mean of its load.

    Parameters
    ----------
    system : System
        Of one coordinate.
    mean : float
    state_box : array (state, 2)
        Where orbits are looked for: a system of one's own is at rest in it.

    Raises
    ------
    InputError
        Without a stable equilibrium, or with several of which none is the one.
    """
    if isinstance(system, Actuator):
        return _rest_of_actuator(system, mean)
    assert isinstance(system, LagrangianSystem)
    return _rest_of_own_system(system, mean, state_box[0])


def free_frequency(
    rest: MeanRest, amplitude: FloatArray, amplitude_error: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Frequency of the free oscillation of each amplitude under the mean load, and its error.

    Branches that relax make all of them faster, by as much as they do small oscillations.  A
    table of oscillations tells from where each starts; its frequency is then computed.
    """
    field_name = _coordinate_name(rest)

    def oscillations(starts: FloatArray, tolerance: float) -> tuple[FloatArray, ...]:
        order = np.argsort(starts, kind="stable")
        _, first, back = np.unique(starts[order], return_index=True, return_inverse=True)
        over = {f"initial.{field_name}": starts[order][first]}
        ens = lay_out_ensemble(rest.elastic, Constant(rest.mean), over)
        free = free_oscillations(ens, tolerance)
        columns = (free.amplitude, free.frequency, free.frequency_error, free.outcome.error)
        place = np.empty(starts.size, dtype=np.int64)
        place[order] = back
        return tuple(np.asarray(column)[place] for column in columns)

    starts = rest.turning_points
    sizes, frequencies, *_ = oscillations(starts, _FREE_OSCILLATION_TOLERANCES[0])
    known = np.isfinite(sizes) & np.isfinite(frequencies)
    # Amplitudes grow with the turning point as far as oscillations stay about this rest.
    known &= np.concatenate([[True], np.diff(np.maximum.accumulate(np.nan_to_num(sizes))) > 0.0])
    if known.sum() < _FEWEST_OSCILLATIONS:
        return np.full(amplitude.shape, np.nan), np.full(amplitude.shape, np.nan)
    sizes, frequencies, starts = sizes[known], frequencies[known], starts[known]
    wanted = np.clip(amplitude, sizes[0], sizes[-1])
    start_at, frequency_at = CubicSpline(sizes, starts), CubicSpline(sizes, frequencies)
    found, frequency, error, found_error = oscillations(
        np.asarray(start_at(wanted)), _FREE_OSCILLATION_TOLERANCES[1]
    )
    slope = np.asarray(frequency_at.derivative()(wanted))
    missed = amplitude - found
    error = error + np.abs(slope) * (amplitude_error + found_error + 0.1 * np.abs(missed))
    # Smaller than any in the table: the frequency is even in the amplitude.
    small = amplitude < sizes[0]
    error = np.where(small, error + np.abs(slope * sizes[0]), error)
    frequency = frequency + np.where(small, 0.0, slope * missed)
    stiffening = rest.natural_frequency / rest.elastic_frequency
    inside = amplitude <= sizes[-1]
    return (
        np.where(inside, stiffening * frequency, np.nan),
        np.where(inside, stiffening * error, np.nan),
    )


def _coordinate_name(rest: MeanRest) -> str:
    """The one coordinate."""
    field = lay_out_ensemble(rest.elastic, Constant(rest.mean)).vector_field
    (name,) = field.names_of_roles(Role.COORDINATE)
    return name


# An actuator ------------------------------------------------------------------------------


def _rest_of_actuator(system: Actuator, mean: float) -> MeanRest:
    place = _stable_stretch(system, mean)
    starts = place * np.geomspace(
        _SMALLEST_RELATIVE_TURNING_POINT,
        _LARGEST_RELATIVE_TURNING_POINT / place,
        _FREE_OSCILLATION_COUNT,
    )
    elastic = system.replace(dissipation=(), heat=None)
    frequencies = [_small_oscillation_frequency(one, mean, place) for one in (system, elastic)]
    return MeanRest(elastic, mean, starts, *frequencies)


def _stable_stretch(system: Actuator, mean: float) -> float:
    """The stretch at the one stable equilibrium under a load."""
    at_rest = StaticEnsemble(lay_out_ensemble(system, Constant(mean)))
    roots = find_force_zeros(at_rest.first_acceleration, 1, at_rest.stretch_grid)[0]
    stable = roots[
        force_slope(at_rest.first_acceleration, np.zeros(roots.size, dtype=np.int64), roots) < 0.0
    ]
    if stable.size != 1:
        raise InputError(
            "drive",
            must="have a mean load with one stable equilibrium",
            got=mean,
            why="Resonances are named by the free oscillations about it.",
            fix="Pass another load or prestress.",
        )
    return float(stable[0])


def _small_oscillation_frequency(system: Actuator, mean: float, stretch: float) -> float:
    """Modulus of the eigenvalue of small oscillations about rest; NaN where there are none."""
    static = StaticEnsemble(lay_out_ensemble(system, Constant(mean)))
    ens = static.ensemble
    row = np.array([ens.parameter_values[name][0] for name in ens.vector_field.parameter_names])
    state = static.states_at(np.zeros(1, dtype=np.int64), np.array([stretch]))[0]
    return _modulus(StaticState(ens.vector_field, row, state).rate_derivatives()[0])


def _modulus(derivatives: FloatArray) -> float:
    """Modulus of the eigenvalue that oscillates; NaN where none does."""
    values = np.linalg.eigvals(derivatives)
    return max((abs(complex(s)) for s in values if s.imag > 0.0), default=np.nan)


# A system of one's own --------------------------------------------------------------------


def _rest_of_own_system(system: LagrangianSystem, mean: float, box: FloatArray) -> MeanRest:
    """At the stable equilibrium in the box that is nearest to the state at rest."""
    elastic = system.without_dissipation()
    damped, free = (
        WrittenBody(lay_out_ensemble(one, Constant(mean)), 0) for one in (system, elastic)
    )
    places = free.equilibria(box[None])[0][:, 0]
    stable = places[free.stiffness(places[:, None])[:, 0, 0] < 0.0]
    place = _nearest_to_rest(system, stable, box)
    end = _farthest_turning_point(free, places, place, box)
    starts = place + (end - place) * np.geomspace(*_TURNING_POINT_SHARES, _FREE_OSCILLATION_COUNT)
    states = free.states(np.array([[place]]))
    frequencies = [_modulus(body.rate_derivatives(states)[0]) for body in (damped, free)]
    return MeanRest(elastic, mean, starts, *frequencies)


def _nearest_to_rest(system: LagrangianSystem, stable: FloatArray, box: FloatArray) -> float:
    """The one of the stable equilibria that is nearest to the state at rest."""
    (coordinate,) = system.second_order_names
    distance = np.abs(stable - system.rest_values()[coordinate])
    near = distance <= distance.min(initial=np.inf) + _EQUALLY_NEAR_SHARE * float(np.ptp(box))
    if near.sum() != 1:
        raise InputError(
            "state_box",
            must="hold a stable equilibrium under the mean load, one that is nearest to `rest`",
            got=f"{coordinate} between {box[0]:g} and {box[1]:g}, with "
            + (f"{', '.join(f'{x:g}' for x in stable)}" if stable.size else "none"),
            why="Resonances are named by the free oscillations about it.",
            fix=f"Pass a box around the one that is meant, or a system with rest={{{coordinate!r}: "
            "...} beside it.",
        )
    return float(stable[near][0])


def _farthest_turning_point(
    free: WrittenBody, places: FloatArray, place: float, box: FloatArray
) -> float:
    """Up to where free oscillations about a place reach, on the side where that is told best.

    That is the next equilibrium, over which motion leaves with the least energy; where there is
    none on either side, the end of the box with the larger energy.
    """
    (energy,) = free.ens.vector_field.energy_names

    def level(at: Any) -> float:
        return float(free.observable(energy, free.states(np.array([[at]])))[0])

    saddles = [*places[places < place][-1:], *places[places > place][:1]]
    if saddles:
        return float(min(saddles, key=level))
    return float(max(box, key=level))
