"""Frequencies over which a response is asked for, where nobody says which: resonances are inside.

Small vibrations about rest under the mean of the load have natural frequencies.  Each harmonic of
the load that has one of them makes a resonance: the second of a load that is quadratic in the
field, at half the natural frequency.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import Any, Final

import numpy as np

import remanent as rm
from remanent._errors import InputWarning, RemanentError
from remanent._field import Role
from remanent._typing import FloatArray
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.studies.ensemble.layout import lay_out_ensemble

#: How far beyond the lowest and the highest resonance the range goes: loads and amplitudes that
#: are not small move a resonance, by a third or so.
_BELOW, _ABOVE = 0.4, 1.6
#: The frequency of the load is inside too, with this margin, where it is not this far outside.
_MARGIN: Final = 1.25
_FAR: Final = 4.0
#: Range where nothing vibrates, as shares of the frequency of the load.
_SHARES: Final = (0.5, 2.0)
#: Instants in a period at which the load is looked at, and the least share of the largest
#: harmonic that is one.
_INSTANTS: Final = 64
_LEAST_HARMONIC: Final = 1e-3
#: How far from its rest a system of one's own is looked for equilibria, and in how many
#: coordinates.
_REACH: Final = 2.0
_MOST_COORDINATES: Final = 2
#: The least value that is looked at of a variable that is positive.
_LEAST_POSITIVE: Final = 1e-3
#: Digits of the ends.
_DIGITS: Final = 2


def frequency_range(system: System, drive: Drive) -> tuple[float, float]:
    """The lowest and the highest drive frequency of a response.

    Parameters
    ----------
    system : System
    drive : Drive
        With a period, and with ``omega`` among its numbers.
    """
    omega = drive.parameter_values()["omega"]
    found = resonances(system, drive)
    if not found.size:
        return _rounded(_SHARES[0] * omega, _SHARES[1] * omega)
    low, high = _BELOW * float(found.min()), _ABOVE * float(found.max())
    if low / _FAR <= omega <= high * _FAR:
        low, high = min(low, omega / _MARGIN), max(high, omega * _MARGIN)
    return _rounded(low, high)


def resonances(system: System, drive: Drive) -> FloatArray:
    """Drive frequencies at which a harmonic of the load has a natural frequency.

    Returns
    -------
    array (resonance,)
        Empty where there is no vibration, or none is found.
    """
    if drive.period is None:
        return np.zeros(0)
    load = np.fft.rfft(drive(np.arange(_INSTANTS) / _INSTANTS * drive.period)) / _INSTANTS
    sizes = np.abs(load[1:])
    harmonics = 1 + np.flatnonzero(sizes > _LEAST_HARMONIC * sizes.max(initial=0.0))
    turns = drive.period * drive.parameter_values()["omega"] / (2.0 * math.pi)
    natural = natural_frequencies(system, float(load[0].real))
    return np.ravel(turns * natural[:, None] / harmonics)


def natural_frequencies(system: System, load: float) -> FloatArray:
    """Frequencies of small vibrations about every stable equilibrium under a constant load.

    Returns
    -------
    array (mode,)
        With what loses energy and without; empty where nothing vibrates, or no equilibrium is
        found.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)
        try:
            rest = rm.equilibria(system, load, state_box=_box(system))
        except RemanentError:
            return np.zeros(0)
    stable = rest.isel(equilibrium=np.flatnonzero(rest.stability.values == "stable"))
    free = np.ravel(stable.natural_frequency) if "natural_frequency" in stable else np.zeros(0)
    damped = np.ravel(np.imag(stable.eigenvalues)) if "eigenvalues" in stable else np.zeros(0)
    found = np.concatenate([free, _stiffening(system) * free, damped])
    return np.asarray(found[np.isfinite(found) & (found > 0.0)])


def _stiffening(system: System) -> float:
    """By how much branches make vibrations faster that are too fast for them to relax, at most."""
    values = system.parameter_values() if isinstance(system, Actuator) else {}
    return math.sqrt(1.0 + sum(x for name, x in values.items() if name.endswith(".modulus")))


def _box(system: System) -> Mapping[str, Any] | None:
    """Where equilibria are looked for: around rest; an actuator knows it by itself."""
    if isinstance(system, Actuator):
        return None
    ens = lay_out_ensemble(system, rm.Constant(0.0))
    box = {}
    for one, rest in zip(ens.vector_field.variables, ens.initial_states[0], strict=True):
        if one.role is not Role.RATE:
            low = float(rest) - _REACH
            box[one.name] = (max(low, _LEAST_POSITIVE) if one.positive else low, rest + _REACH)
    if len(box) > _MOST_COORDINATES:
        raise RemanentError("Equilibria in so many variables take too long to find.")
    return box


def _rounded(low: float, high: float) -> tuple[float, float]:
    """The range with ends of few digits, moved outward."""
    return _to_digits(low, math.floor), _to_digits(high, math.ceil)


def _to_digits(value: float, towards: Any) -> float:
    step = 10.0 ** (math.floor(math.log10(value)) - _DIGITS + 1)
    return float(f"{towards(value / step + 0.0) * step:.{_DIGITS + 1}g}")
