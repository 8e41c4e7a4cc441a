"""Between SI and dimensionless numbers, both ways, in one table."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Final

from remanent._errors import InputError

#: Permeability of free space, N/A^2 (CODATA 2022).
MU0: Final = 1.25663706127e-6


class Kind(StrEnum):
    """What a dimensionless number measures."""

    TIME = "time"
    RATE = "rate"
    ACCELERATION = "acceleration"
    FREQUENCY = "frequency"
    LOAD = "load"
    STRESS = "stress"
    ENERGY = "energy"
    VISCOSITY = "viscosity"
    TEMPERATURE = "temperature"
    NUMBER = "number"


@dataclass(frozen=True)
class Unit:
    """An SI unit and how many of it make one of the dimensionless number."""

    name: str
    factor: float


@dataclass(frozen=True, kw_only=True)
class Scales:
    """The physical sizes behind a dimensionless actuator, in SI units.

    Parameters
    ----------
    shear_modulus
        mu at the reference temperature, Pa.
    density
        rho, kg/m^3.
    half_length
        L, m.
    remanence
        B_r at the reference temperature, T; None where it was not given.
    """

    shear_modulus: float
    density: float
    half_length: float
    remanence: float | None = None

    @property
    def time(self) -> float:
        """The unit of time, L sqrt(rho/mu), in seconds."""
        return self.half_length * math.sqrt(self.density / self.shear_modulus)

    @property
    def flux_density(self) -> float:
        """The flux density of unit magnetic load, mu mu0/B_r, in tesla."""
        if self.remanence is None:
            raise InputError(
                "remanence",
                "be given to convert magnetic loads",
                None,
                "The magnetic load is B_r B/(mu mu0).",
                'Pass remanence="143 mT" to Actuator.from_si.',
            )
        return self.shear_modulus * MU0 / self.remanence

    def units(self) -> Mapping[Kind, Unit]:
        """SI unit of each kind of quantity: SI value = factor * dimensionless value.

        An energy is per reference volume of the block (8 H L^2), a frequency is the
        angular frequency omega given as omega/(2 pi) in Hz.
        """
        units = {
            Kind.TIME: Unit("s", self.time),
            Kind.RATE: Unit("1/s", 1.0 / self.time),
            Kind.ACCELERATION: Unit("1/s^2", 1.0 / self.time**2),
            Kind.FREQUENCY: Unit("Hz", 1.0 / (2.0 * math.pi * self.time)),
            Kind.STRESS: Unit("Pa", self.shear_modulus),
            Kind.ENERGY: Unit("J/m^3", self.shear_modulus),
            Kind.VISCOSITY: Unit("Pa s", self.shear_modulus * self.time),
            Kind.TEMPERATURE: Unit("K", 1.0),
            Kind.NUMBER: Unit("1", 1.0),
        }
        if self.remanence is not None:
            units[Kind.LOAD] = Unit("T", self.flux_density)
        return units
