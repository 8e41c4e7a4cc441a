"""Where orbits of a system with one stretch can be: the energy at phase 0 tells it.

With dissipation, the energy that a motion of large energy has at phase 0 falls from period to
period.  So every point of a periodic orbit lies where, over the orbit's own period, the energy at
phase 0 does not fall.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from remanent._typing import BoolArray, FloatArray
from remanent.integrate.ensemble.problem import Problem
from remanent.studies.ensemble.observables import evaluate_observable
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.orbits._period_map import StroboscopicMap

#: Observable of a field that is its energy, where it has one.
_ENERGY = "energy"
#: Imaginary step of a derivative.
_COMPLEX_STEP = 1e-30
#: Stretches at which the energy at rest is known.
_STRETCHES = np.geomspace(1e-3, 1e4, 2001)
#: Outside of these the energy at rest rises outwards.
_USUAL_STRETCHES = (0.3, 4.0)
#: Stretch whose energy at rest, above the least, sets the scale of energies.
_SCALE_STRETCH = 4.0
#: Levels of energy that are tried first, in units of the scale.
_FIRST_LEVELS = 2.0 ** np.arange(-6.0, 3.0)
#: Factor from one level to the next.
_LEVEL_RATIO = 2.0
#: Highest level that is tried.
_HIGHEST_LEVEL = 4.0**7
#: Levels in a row on which the energy has to fall.
_LEVELS_OF_FALL = 3
#: Points on each level.
_POINTS_ON_LEVEL = 16


@dataclass(frozen=True)
class EnergyAtSection:
    """The energy of states at phase 0.

    Attributes
    ----------
    map : StroboscopicMap
    parameters : array (parameter,)
        Of the map.
    """

    map: StroboscopicMap
    parameters: FloatArray

    def __call__(self, states: FloatArray) -> FloatArray:
        """Energies, array (point,)."""
        return np.asarray(self._evaluated(states).real)

    def with_gradient(self, states: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Energies, array (point,), and their derivatives by the state, array (point, state)."""
        steps = _COMPLEX_STEP * 1j * np.eye(states.shape[1])
        there = (states + steps[:, None]).reshape(-1, states.shape[1])
        values = self._evaluated(there).reshape(len(steps), -1)
        return np.asarray(values[0].real), np.asarray(values.imag.T / _COMPLEX_STEP)

    def _evaluated(self, states: Any) -> Any:
        """Energies of states, which may be complex."""
        times = np.zeros((1, len(states)))
        return evaluate_observable(self._problem, _ENERGY, times, states[None])[0]

    @cached_property
    def _problem(self) -> Problem:
        ens = self.map.ensemble
        varied = {
            name: self.parameters[k : k + 1] for k, name in enumerate(self.map.parameter_names)
        }
        return initial_value_problem(
            ens.with_initial_states(ens.initial_states[:1], varied), np.ones(1)
        )


@dataclass(frozen=True)
class EnergyLevels:
    """Curves of equal energy in the plane of a stretch and its rate.

    Attributes
    ----------
    potential, inertia : array (stretch,)
        Energy at rest, and twice the kinetic energy at unit rate, at `_STRETCHES`.
    """

    potential: FloatArray
    inertia: FloatArray

    @classmethod
    def of(cls, energy: EnergyAtSection) -> EnergyLevels:
        """Those of one system."""
        at_rest = energy(np.column_stack([_STRETCHES, np.zeros_like(_STRETCHES)]))
        moving = energy(np.column_stack([_STRETCHES, np.ones_like(_STRETCHES)]))
        low, high = _ends_of_rise(at_rest)
        place = np.arange(len(at_rest))
        at_rest = np.where((place >= low) & (place <= high), at_rest, np.nan)
        with np.errstate(all="ignore"):
            return cls(at_rest, 2.0 * (moving - at_rest))

    @property
    def least(self) -> float:
        """The least energy."""
        return float(np.nanmin(self.potential))

    @property
    def scale(self) -> float:
        """Energy at rest at the stretch that sets the scale, above the least."""
        stretch = min(_SCALE_STRETCH, np.sqrt(self.possible_stretches[1]))
        return float(np.interp(stretch, _STRETCHES, self.potential)) - self.least

    def is_known(self, share: float) -> bool:
        """Whether a level, in units of the scale, lies below the energy at both ends."""
        known = self.potential[np.isfinite(self.potential)]
        if not known.size:
            return False
        highest = min(known[0], known[-1])
        return bool(share <= _HIGHEST_LEVEL and self.least + share * self.scale < highest)

    @property
    def possible_stretches(self) -> tuple[float, float]:
        """Between which the energy is known: it is finite, and rises outside of usual stretches.

        Chains of some materials have an end, and some magnets a pole at extreme stretches.
        """
        finite = _STRETCHES[np.isfinite(self.potential)]
        return (float(finite[0]), float(finite[-1])) if finite.size else (1.0, 1.0)

    def stretch_range(self, level: float) -> tuple[float, float]:
        """Least and largest stretch with this energy."""
        inside = _STRETCHES[self.potential <= level]
        ratio = _STRETCHES[1] / _STRETCHES[0]
        return float(inside[0] / ratio), float(inside[-1] * ratio)

    def points(self, level: float) -> FloatArray:
        """Points on a level, array (point, 2), evenly in the logarithm of the stretch."""
        low, high = np.log(self.stretch_range(level))
        angle = 2.0 * np.pi * (np.arange(_POINTS_ON_LEVEL) + 0.5) / _POINTS_ON_LEVEL
        stretch = np.exp(0.5 * (low + high) - 0.5 * (high - low) * np.cos(angle))
        kinetic = level - np.interp(stretch, _STRETCHES, self.potential)
        rate = np.sqrt(
            2.0 * np.maximum(kinetic, 0.0) / np.interp(stretch, _STRETCHES, self.inertia)
        )
        return np.column_stack([stretch, np.sign(np.sin(angle)) * rate])

    def box(self, level: float) -> FloatArray:
        """The least box that holds a level, array (2, 2)."""
        inside = self.potential <= level
        rate = np.sqrt(2.0 * (level - self.potential[inside]) / self.inertia[inside]).max()
        return np.array([self.stretch_range(level), (-rate, rate)])


def _ends_of_rise(potential: FloatArray) -> tuple[int, int]:
    """First and last of `_STRETCHES` up to which a potential rises outwards.

    Between the usual stretches it may do as it likes, as long as it is finite.
    """
    middle = int(np.searchsorted(_STRETCHES, 1.0))
    usual = [int(k) for k in np.searchsorted(_STRETCHES, _USUAL_STRETCHES)]
    with np.errstate(all="ignore"):
        rises = np.diff(potential) > 0.0
        falls = np.diff(potential) < 0.0
    finite = np.isfinite(potential)
    low, high = middle, middle
    while low > 0 and finite[low - 1] and (low > usual[0] or falls[low - 1]):
        low -= 1
    last = len(potential) - 1
    while high < last and finite[high + 1] and (high < usual[1] or rises[high]):
        high += 1
    return low, high


@dataclass(frozen=True)
class SearchRegion:
    """Where all points of all orbits of some period are.

    Attributes
    ----------
    box : array (2, 2)
    energy : float
        Which they do not exceed at phase 0.
    """

    box: FloatArray
    energy: float


def has_energy(map_: StroboscopicMap) -> bool:
    """Whether the field observes its energy."""
    return _ENERGY in map_.ensemble.vector_field.observables


def region_of_orbits(
    map_: StroboscopicMap, energy: EnergyAtSection, iterate: int
) -> SearchRegion | None:
    """Beyond which energy decreases over `iterate` periods; None where no such bound is found.

    The period of the orbits has to be a part of them.

    The region is a level above the highest one with a point where energy does not decrease.
    """
    levels = EnergyLevels.of(energy)
    shares = [s for s in _FIRST_LEVELS if levels.is_known(s)]
    if not shares:
        return None
    with np.errstate(all="ignore"):
        falls = list(_energy_falls(map_, energy, levels, np.array(shares), iterate))
        while not all(falls[-_LEVELS_OF_FALL:]):
            if not levels.is_known(_LEVEL_RATIO * shares[-1]):
                return None
            shares.append(shares[-1] * _LEVEL_RATIO)
            falls += list(_energy_falls(map_, energy, levels, np.array(shares[-1:]), iterate))
        highest = max((k for k, fall in enumerate(falls) if not fall), default=-1)
        bound = levels.least + levels.scale * shares[highest + 1]
        return SearchRegion(levels.box(bound), float(bound))


def _energy_falls(
    map_: StroboscopicMap,
    energy: EnergyAtSection,
    levels: EnergyLevels,
    shares: FloatArray,
    iterate: int,
) -> BoolArray:
    """Whether the energy falls from every point of some levels, array (level,)."""
    states = np.concatenate([levels.points(levels.least + levels.scale * s) for s in shares])
    rows = np.tile(energy.parameters, (len(states), 1))
    image = map_.run(states, rows, iterate)
    before, after = energy(states), energy(image.state)
    _, gradient = energy.with_gradient(image.state)
    slack = np.abs(gradient).sum(axis=1) * image.error
    falls = after + slack < before
    return np.asarray(falls.reshape(len(shares), -1).all(axis=1))
