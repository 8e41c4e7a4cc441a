"""The magnet inside the elastomer: its energy in the field, its remanence when warm."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

from remanent import _checks
from remanent._checks import Rule
from remanent.models.parts import Part

#: How the magnetisation follows the deformation.
LAWS = ("deformation-gradient", "rotation")


@dataclass(frozen=True)
class Magnet(Part):
    """A magnetisation law and the remanence's dependence on temperature.

    Parameters
    ----------
    temperature_coefficient
        alpha in B_r(T) = B_r(T0) [1 + alpha (T - T0)], per kelvin; about -0.001 for
        NdFeB.  Plain grades are rated to 80 degrees Celsius: at 400 K the linear law
        is used beyond its data.
    law
        ``"deformation-gradient"``: the residual flux moves with the material, F B_r
        (Zhao et al. 2019).  ``"rotation"``: it only rotates with it, R B_r, so that
        a field along the magnetisation exerts no load at all.  Which holds at large
        stretch is disputed (Danas and Reis 2024).
    """

    temperature_coefficient: float = 0.0
    law: str = "deformation-gradient"

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "temperature_coefficient": _checks.finite(
                "It is the relative change of the remanence per kelvin.",
                "Pass 0 for a constant remanence, or about -0.001 for NdFeB.",
            )
        }
    )
    choices: ClassVar[tuple[str, ...]] = ("law",)

    def checked_options(self) -> Mapping[str, Any]:
        """The law, if it is one of :data:`LAWS`."""
        return {"law": _checks.require_choice("law", self.law, LAWS)}

    def remanence(self, temperature: Any, reference: Any, p: Mapping[str, Any]) -> Any:
        """B_r(T)/B_r(T0) = 1 + alpha (T - T0)."""
        return 1 + p["temperature_coefficient"] * (temperature - reference)

    def energy(self, load: Any, l3: Any) -> Any:
        """Magnetic energy per reference volume, divided by mu.

        Equation: -(F B_r).B/(mu mu0) = -m l3 for the deformation-gradient law and
        -(R B_r).B/(mu mu0) = -m for the rotation law, where m is `load`, the magnetic
        load with the remanence at temperature, and l3 the thickness stretch.
        """
        return -load * l3 if self.law == "deformation-gradient" else -load
