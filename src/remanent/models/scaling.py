"""Between SI and dimensionless numbers, in one place."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final, Self

from remanent import _units
from remanent._errors import InputError
from remanent._units import Quantity

#: Permeability of free space, N/A^2 (CODATA 2022).
MU0: Final = 1.25663706127e-6


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

    @classmethod
    def of(
        cls,
        *,
        shear_modulus: Quantity,
        density: Quantity,
        half_length: Quantity,
        remanence: Quantity | None = None,
    ) -> Self:
        """Scales from quantities with units, ``"100 kPa"`` or pint's."""
        return cls(
            shear_modulus=_units.positive("shear_modulus", shear_modulus, "Pa"),
            density=_units.positive("density", density, "kg/m^3"),
            half_length=_units.positive("half_length", half_length, "m"),
            remanence=None if remanence is None else _units.positive("remanence", remanence, "T"),
        )

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
                must="be given to convert magnetic loads",
                got=None,
                why="The magnetic load is B_r B/(mu mu0).",
                fix='Pass remanence="143 mT" to Actuator.from_si.',
            )
        return self.shear_modulus * MU0 / self.remanence

    @property
    def demagnetisation(self) -> float:
        """Strength of the magnet's field in itself, B_r^2/(mu mu0)."""
        if self.remanence is None:
            raise InputError(
                "remanence",
                must="be given to know the magnet's own field",
                got=None,
                why="Its strength is B_r^2/(mu mu0).",
                fix='Pass remanence="143 mT" to Actuator.from_si.',
            )
        return self.remanence**2 / (self.shear_modulus * MU0)

    def factors(self) -> dict[str, float]:
        """SI units in one dimensionless unit, by the names that results carry.

        ``time_s``: seconds per tau.  ``frequency_hz``: hertz per omega, which is an
        angular frequency.  ``load_T``: tesla per m (left out without a remanence).
        ``stress_pa``: pascal per S, and joule per cubic metre of reference volume per
        unit of energy.
        """
        factors = {
            "time_s": self.time,
            "frequency_hz": 1.0 / (2.0 * math.pi * self.time),
            "stress_pa": self.shear_modulus,
        }
        return factors if self.remanence is None else factors | {"load_T": self.flux_density}
