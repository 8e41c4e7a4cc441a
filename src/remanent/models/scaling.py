"""Between SI and dimensionless numbers, in one place."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Final, Self

import numpy as np

from remanent import _checks, _units
from remanent._errors import InputError, shortened_repr
from remanent._typing import ArrayLike, FloatArray
from remanent._units import Quantity
from remanent.models.pairs import is_several_numbers, split_by_direction

#: Permeability of free space, N/A^2 (CODATA 2022).
VACUUM_PERMEABILITY: Final = 1.25663706127e-6


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
    def from_quantities(
        cls,
        *,
        shear_modulus: Quantity,
        density: Quantity,
        half_length: Quantity,
        remanence: Quantity | None = None,
    ) -> Self:
        """Scales from quantities with units, ``"100 kPa"`` or pint's."""
        return cls(
            shear_modulus=_units.positive_magnitude("shear_modulus", shear_modulus, "Pa"),
            density=_units.positive_magnitude("density", density, "kg/m^3"),
            half_length=_units.positive_magnitude("half_length", half_length, "m"),
            remanence=None
            if remanence is None
            else _units.positive_magnitude("remanence", remanence, "T"),
        )

    @property
    def time_unit(self) -> float:
        """The unit of time, L sqrt(rho/mu), in seconds."""
        return self.half_length * math.sqrt(self.density / self.shear_modulus)

    @property
    def flux_density_unit(self) -> float:
        """The flux density of unit magnetic load, mu mu0/B_r, in tesla."""
        if self.remanence is None:
            raise InputError(
                "remanence",
                must="be given to convert magnetic loads",
                got=None,
                why="The magnetic load is B_r B/(mu mu0).",
                fix='Pass remanence="143 mT" to Actuator.from_si.',
            )
        return self.shear_modulus * VACUUM_PERMEABILITY / self.remanence

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
        return self.remanence**2 / (self.shear_modulus * VACUUM_PERMEABILITY)

    # From SI to dimensionless ---------------------------------------------------------

    def dimensionless_stress(self, stress: Quantity) -> float | FloatArray:
        """Stress or modulus over mu, of ``"50 kPa"``."""
        return _units.magnitude_in_unit("stress", stress, "Pa") / self.shear_modulus

    def dimensionless_viscosity(self, viscosity: Quantity) -> float | FloatArray:
        """eta over mu times the unit of time, of ``"20 Pa s"``."""
        unit = self.shear_modulus * self.time_unit
        return _units.magnitude_in_unit("viscosity", viscosity, "Pa s") / unit

    def dimensionless_load(self, flux_density: Quantity) -> float | FloatArray:
        """Magnetic load m = B_r B/(mu mu0) of a flux density, ``"140 mT"``."""
        return _units.magnitude_in_unit("flux_density", flux_density, "T") / self.flux_density_unit

    def dimensionless_frequency(self, frequency: Quantity) -> float | FloatArray:
        """omega in radians per unit of tau, of ``"50 Hz"`` or ``"314 rad/s"``."""
        return _units.radians_per_second("frequency", frequency) * self.time_unit

    def dimensionless_time(self, time: Quantity) -> float | FloatArray:
        """tau of a time, ``"1 s"``."""
        return _units.magnitude_in_unit("time", time, "s") / self.time_unit

    def thermal_coupling(
        self, heat_capacity: Quantity, reference_temperature: float
    ) -> float | FloatArray:
        """mu/(rho c_p T0) of a heat capacity c_p, ``"1.9 kJ/(kg K)"``, and T0 in kelvin."""
        capacity = _units.magnitude_in_unit("heat_capacity", heat_capacity, "J/(kg K)")
        return self.shear_modulus / (self.density * reference_temperature * capacity)

    def dimensionless_nominal_stress(
        self,
        force: Quantity | Sequence[Quantity],
        half_thickness: float,
        edges: tuple[float, float] | None,
    ) -> float | tuple[float, float]:
        """Nominal stress over mu of forces on the faces of a block.

        Parameters
        ----------
        force
            P on both pairs of faces 2 L x 2 H, or a pair, each on its own face.
        half_thickness
            H in metres.
        edges
            L1/L and L2/L; None for equal edges.

        Returns
        -------
        float or pair of float
            P/(4 L H mu); for a pair or edges, P_i over the face that it pulls at.
        """
        unit = 4.0 * self.half_length * half_thickness * self.shear_modulus
        if edges is None and not is_several_numbers(force):
            return _units.single_magnitude("force", force, "N") / unit
        force_1, force_2 = split_by_direction("force", force).values()
        edge_1, edge_2 = edges or (1.0, 1.0)
        # A force along one edge pulls at the faces that the other edge spans.
        return (
            _units.single_magnitude("force", force_1, "N") / (unit * edge_2),
            _units.single_magnitude("force", force_2, "N") / (unit * edge_1),
        )

    # From dimensionless to SI ---------------------------------------------------------

    def in_unit(self, values: ArrayLike, unit: str) -> float | FloatArray:
        """Dimensionless numbers as what their unit measures: time, frequency, load ...

        Parameters
        ----------
        values : float or array_like
            Times for ``"ms"``, angular frequencies for ``"Hz"`` and ``"rad/s"``, magnetic loads
            for ``"mT"``, stresses and energy densities for ``"kPa"``, viscosities for
            ``"Pa s"``.
        unit : str
            A unit that pint knows.
        """
        numbers = _checks.as_float_array(
            "values",
            values,
            what="dimensionless numbers",
            why="They are multiplied by a unit.",
            fix="Pass a number or an array of them.",
        )
        found = numbers * self._size_over_unit(_units.with_unit("unit", np.array(1.0), unit), unit)
        return float(found) if found.ndim == 0 else np.asarray(found)

    def _size_over_unit(self, one: Quantity, unit: str) -> float:
        """The dimensionless one of whatever has this unit, in this unit."""
        sizes: dict[str, Callable[[], float]] = {
            "s": lambda: self.time_unit,
            "T": lambda: self.flux_density_unit,
            "Pa": lambda: self.shear_modulus,
            "Pa s": lambda: self.shear_modulus * self.time_unit,
        }
        for base, size in sizes.items():
            bases = _magnitude_or_none(one, base)
            if bases is not None:
                return size() / bases
        with suppress(InputError):
            return 1.0 / (self.time_unit * float(_units.radians_per_second("unit", one)))
        raise InputError(
            "unit",
            must="be one of a time, a frequency, a flux density, a stress or a viscosity",
            got=shortened_repr(unit),
            why="Dimensionless numbers stand for these.",
            fix='Pass for example "ms", "Hz", "mT", "kPa" or "Pa s".',
        )

    def si_factors(self) -> dict[str, float]:
        """SI units in one dimensionless unit, by the names that results carry.

        ``time_s``: seconds per tau.  ``frequency_hz``: hertz per omega, which is an
        angular frequency.  ``load_T``: tesla per m (left out without a remanence).
        ``stress_pa``: pascal per S, and joule per cubic metre of reference volume per
        unit of energy.
        """
        factors = {
            "time_s": self.time_unit,
            "frequency_hz": 1.0 / (2.0 * math.pi * self.time_unit),
            "stress_pa": self.shear_modulus,
        }
        return factors if self.remanence is None else factors | {"load_T": self.flux_density_unit}


def _magnitude_or_none(quantity: Quantity, unit: str) -> float | None:
    """The number of `unit` in a quantity; None where that has another dimension."""
    try:
        return float(_units.magnitude_in_unit("unit", quantity, unit))
    except InputError:
        return None
