"""Physical sizes of a body over those that it was built with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import ClassVar, Final

from remanent._checks import Rule, positive_rule
from remanent.models.parts import Part

#: The rule of every size.
PHYSICAL_SIZE_RULE: Final[Rule] = positive_rule(
    "It is a physical size over the one that the actuator was built with.",
    "Pass 1 for no change, 1.05 for five per cent more.",
)


@dataclass(frozen=True)
class PhysicalSizes(Part):
    """Shear modulus, density and remanence over those that an actuator was built with.

    Units of time, stress and load stay those of the actuator as it was built, so that flux
    densities, dead loads, viscosities and times keep their values in SI while a size changes:
    the strain energy is multiplied by the modulus, the kinetic energy and the heat capacity
    by the density, the energy in the applied field by the remanence and that in the magnet's
    own field by its square.

    Parameters
    ----------
    shear_modulus, density, remanence
        1 for no change.
    """

    shear_modulus: float = 1.0
    density: float = 1.0
    remanence: float = 1.0

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        dict.fromkeys(("shear_modulus", "density", "remanence"), PHYSICAL_SIZE_RULE)
    )


#: Names of the sizes.
PHYSICAL_SIZES: Final[tuple[str, ...]] = tuple(PhysicalSizes.rules)
