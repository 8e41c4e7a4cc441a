"""Quantities with units into the dimensionless numbers of each kind."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final

import numpy as np

from remanent import _units
from remanent._errors import InputError, shortened_repr
from remanent._typing import FloatArray
from remanent._units import Quantity
from remanent.models.scaling import VACUUM_PERMEABILITY, Scales
from remanent.results.schema import QuantityKind

__all__ = ["dimensionless_numbers", "require_scales"]

#: SI unit of each kind, and the size of that unit's one in the actuator's own unit.
_SI_UNITS_AND_SIZES: Final[Mapping[QuantityKind, tuple[str, Callable[[Scales], float]]]] = (
    MappingProxyType(
        {
            QuantityKind.TIME: ("s", lambda s: 1.0 / s.time_unit),
            QuantityKind.RATE: ("1/s", lambda s: s.time_unit),
            QuantityKind.SQUARED_RATE: ("1/s^2", lambda s: s.time_unit**2),
            QuantityKind.LOAD: ("T", lambda s: 1.0 / s.flux_density_unit),
            QuantityKind.ROOT_LOAD: ("T", lambda s: 1.0 / s.flux_density_unit),
            QuantityKind.STRESS: ("Pa", lambda s: 1.0 / s.shear_modulus),
            QuantityKind.ENERGY_DENSITY: ("J/m^3", lambda s: 1.0 / s.shear_modulus),
            QuantityKind.VISCOSITY: ("Pa s", lambda s: 1.0 / (s.shear_modulus * s.time_unit)),
            QuantityKind.SHEAR_MODULUS: ("Pa", lambda s: 1.0 / s.shear_modulus),
            QuantityKind.DENSITY: ("kg/m^3", lambda s: 1.0 / s.density),
            QuantityKind.REMANENCE: (
                "T",
                lambda s: s.flux_density_unit / (s.shear_modulus * VACUUM_PERMEABILITY),
            ),
        }
    )
)


def dimensionless_numbers(
    argument: str, quantity: Quantity, kind: QuantityKind, scales: Scales | None
) -> FloatArray:
    """The numbers that stand for a quantity inside the package.

    Parameters
    ----------
    argument : str
        What the message calls it.
    quantity : text, pint quantity, or timedelta
        With its unit; single or an array.
    kind : QuantityKind
        What is measured.
    scales : Scales or None
        Sizes of the actuator, where they are known.

    Raises
    ------
    InputError
        A unit of another dimension, a kind that has none, or no sizes.
    """
    if kind is QuantityKind.NONE:
        return np.asarray(_units.magnitude_in_unit(argument, quantity, ""))
    if kind is QuantityKind.TEMPERATURE:
        return np.asarray(_units.magnitude_in_unit(argument, quantity, "K"))
    sizes = require_scales(argument, quantity, scales)
    if kind is QuantityKind.FREQUENCY:
        return np.asarray(_units.radians_per_second(argument, quantity) * sizes.time_unit)
    if kind not in _SI_UNITS_AND_SIZES:
        raise InputError(
            argument,
            must="be a dimensionless number",
            got=shortened_repr(quantity),
            why="Nothing of this kind is measured in a unit.",
            fix="Pass the number as it enters the equations.",
        )
    unit, size = _SI_UNITS_AND_SIZES[kind]
    numbers = np.asarray(_units.magnitude_in_unit(argument, quantity, unit)) * size(sizes)
    return np.sqrt(numbers) if kind is QuantityKind.ROOT_LOAD else numbers


def require_scales(argument: str, value: object, scales: Scales | None) -> Scales:
    """The sizes by which units turn into dimensionless numbers; raise where there are none."""
    if scales is None:
        raise InputError(
            argument,
            must="be dimensionless for this actuator",
            got=shortened_repr(value),
            why="Dimensionless numbers alone do not fix a length or a stress.",
            fix="Build the actuator with Actuator.from_si, or pass numbers without a unit.",
        )
    return scales
