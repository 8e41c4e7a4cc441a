"""Strain energies of incompressible elastomers, normalised to unit shear modulus."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from remanent._checks import Rule
from remanent.models.parts import Part

ENTROPIC_FRACTION = Rule(
    "be a finite number from 0 to 1",
    lambda x: np.asarray((x >= 0) & (x <= 1)),
    "It is the share of the shear modulus that is proportional to temperature.",
    "Pass 1 for rubber (entropic elasticity) or 0 for a modulus without temperature.",
)


@dataclass(frozen=True)
class Material(Part, ABC):
    """A strain energy per reference volume, divided by the shear modulus at T0.

    A subclass has a numeric field `entropic_fraction`, see
    :func:`remanent.models.thermal.stiffness`.
    """

    @abstractmethod
    def energy(self, l1: Any, l2: Any, l3: Any, p: Mapping[str, Any], fn: Any) -> Any:
        """Strain energy at the reference temperature, zero and stress-free at rest.

        It is computed as it is written here: prefer a form without cancellation.

        Parameters
        ----------
        l1, l2, l3
            Principal stretches, l1 l2 l3 = 1.
        p
            Values of the material's numeric fields, by name.
        fn
            Where functions such as ``log`` are found: the module sympy or numpy.
        """


@dataclass(frozen=True)
class NeoHookean(Material):
    """The neo-Hookean solid, W/mu = (l1^2 + l2^2 + l3^2 - 3)/2 (paper, section 2).

    Parameters
    ----------
    entropic_fraction
        Share of the modulus that is proportional to temperature.

    Examples
    --------
    >>> NeoHookean().energy(2.0, 1.0, 0.5, {}, None)
    1.125
    """

    entropic_fraction: float = 1.0

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType({"entropic_fraction": ENTROPIC_FRACTION})

    def energy(self, l1: Any, l2: Any, l3: Any, p: Mapping[str, Any], fn: Any) -> Any:
        """W/mu = [(l1 - l2)^2 + (1 - l3)^2 (2 + l3)/l3]/2.

        With l1 l2 l3 = 1 this is (l1^2 + l2^2 + l3^2 - 3)/2, without the cancellation
        near rest: both terms are squares.
        """
        return ((l1 - l2) ** 2 + (1 - l3) ** 2 * (2 + l3) / l3) / 2
