"""The magnet inside the elastomer: its energy in the field, its remanence when warm."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

from remanent import _checks
from remanent._checks import Rule
from remanent.models.parts import Part

#: How the magnetisation follows the deformation.
MAGNETISATION_LAWS = ("deformation-gradient", "rotation")


@dataclass(frozen=True)
class Magnet(Part):
    r"""A magnetisation law and the remanence's dependence on temperature.

    Parameters
    ----------
    temperature_coefficient : float
        :math:`\alpha` in :math:`B_r(T) = B_r(T_0) [1 + \alpha (T - T_0)]`, per kelvin; about
        -0.001 for NdFeB.  Plain grades are rated to 80 degrees Celsius: at 400 K the linear law
        is used beyond its data.
    law : str
        ``"deformation-gradient"``: the residual flux moves with the material,
        :math:`F B_r` (Zhao et al. 2019).  ``"rotation"``: it only rotates with it,
        :math:`R B_r`, so that a field along the magnetisation exerts no load at all.  Which holds
        at large stretch is disputed (Danas and Reis 2024).
    demagnetisation : float, optional
        :math:`B_r^2/(\mu \mu_0)`, the strength of the field that the block makes in itself;
        0.163 for 100 kPa and 143 mT.  By default, None, that field is left out of the equations.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    Actuator : The body that it is a part of.

    References
    ----------
    A. Aharoni, Demagnetizing factors for rectangular ferromagnetic prisms, Journal of
    Applied Physics 83 (1998) 3432-3434.
    R. Zhao, Y. Kim, S. A. Chester, P. Sharma and X. Zhao, Mechanics of hard-magnetic soft
    materials, Journal of the Mechanics and Physics of Solids 124 (2019) 244-263.

    K. Danas and P. M. Reis, Stretch-independent magnetization in incompressible
    magnetorheological elastomers, arXiv:2403.03096 (2024).

    Examples
    --------
    >>> Magnet(-0.001, demagnetisation=0.163).parameter_values()
    {'temperature_coefficient': -0.001, 'demagnetisation': 0.163}
    """

    temperature_coefficient: float = 0.0
    law: str = "deformation-gradient"
    demagnetisation: float | None = None

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "temperature_coefficient": _checks.finite_rule(
                "It is the relative change of the remanence per kelvin.",
                "Pass 0 for a constant remanence, or about -0.001 for NdFeB.",
            ),
            "demagnetisation": _checks.not_negative_rule(
                "It is the square of the remanence over mu mu0.",
                "Pass None to leave the block's own field out.",
            ),
        }
    )
    structural_fields: ClassVar[tuple[str, ...]] = ("law",)

    def checked_fields(self) -> Mapping[str, Any]:
        """The law, if it is one of :data:`MAGNETISATION_LAWS`."""
        return {"law": _checks.require_choice("law", self.law, MAGNETISATION_LAWS)}

    def remanence_ratio(self, temperature: Any, reference: Any, p: Mapping[str, Any]) -> Any:
        """B_r(T)/B_r(T0) = 1 + alpha (T - T0)."""
        return 1 + p["temperature_coefficient"] * (temperature - reference)

    def energy_in_applied_field(self, load: Any, l3: Any) -> Any:
        """Magnetic energy per reference volume, divided by mu.

        Equation: -(F B_r).B/(mu mu0) = -m l3 for the deformation-gradient law and
        -(R B_r).B/(mu mu0) = -m for the rotation law, where m is `load`, the magnetic
        load with the remanence at temperature, and l3 the thickness stretch.
        """
        return -load * l3 if self.law == "deformation-gradient" else -load

    def energy_in_own_field(
        self, stretches: Sequence[Any], edges: Sequence[Any], p: Mapping[str, Any], fn: Any
    ) -> Any:
        """Energy of the block in its own field, per reference volume, divided by mu.

        Equation: N b^2 B_r0^2/(2 mu mu0) at T0, to be multiplied by (B_r(T)/B_r0)^2, with
        b = l3 for the deformation-gradient law and b = 1 for the rotation law; N is the
        demagnetising factor along the thickness of the block as it is.  It supposes a uniform
        magnetisation and no susceptibility besides.

        Parameters
        ----------
        stretches
            l1, l2, l3.
        edges
            Of the undeformed block, L1/L, L2/L, H/L.
        p, fn
            The magnet's numeric fields; where functions are found.
        """
        if self.demagnetisation is None:
            return 0
        a, b, c = (edge * stretch for edge, stretch in zip(edges, stretches, strict=True))
        flux = stretches[2] if self.law == "deformation-gradient" else 1
        return p["demagnetisation"] * demagnetising_factor(a, b, c, fn) * flux**2 / 2


def demagnetising_factor(a: Any, b: Any, c: Any, fn: Any) -> Any:
    """Demagnetising factor of a cuboid along its edge c, averaged over its volume.

    Equation 1 of Aharoni (1998), with ln[(r + a)/(r - a)] written as
    2 asinh(a/sqrt(r^2 - a^2)), which does not cancel.

    Parameters
    ----------
    a, b, c
        Edges, in any unit.
    fn
        Where ``sqrt``, ``log``, ``atan`` and ``pi`` are found: numpy, sympy.

    Examples
    --------
    >>> import math
    >>> round(demagnetising_factor(1.0, 1.0, 1.0, math), 15)
    0.333333333333333
    """

    def asinh(x: Any) -> Any:
        return fn.log(x + fn.sqrt(1 + x * x))

    ab, bc, ca = (fn.sqrt(x * x + y * y) for x, y in ((a, b), (b, c), (c, a)))
    r = fn.sqrt(a * a + b * b + c * c)
    logarithms = (
        (c * c - b * b) / (b * c) * asinh(a / bc)
        + (c * c - a * a) / (a * c) * asinh(b / ca)
        + b / c * asinh(a / b)
        + a / c * asinh(b / a)
        - c / a * asinh(b / c)
        - c / b * asinh(a / c)
    )
    cubes = a**3 + b**3 - 2 * c**3 - ab**3 - bc**3 - ca**3
    roots = (cubes + (a * a + b * b - 2 * c * c) * r) / (3 * a * b * c) + c * (ca + bc) / (a * b)
    return (logarithms + 2 * fn.atan(a * b / (c * r)) + roots) / fn.pi
