"""Yeoh's strain energy, a cubic in the first invariant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Self

from remanent import _checks
from remanent._checks import Rule
from remanent.models.materials.base import (
    ENTROPIC_FRACTION_RULE,
    Material,
    first_invariant_minus_three,
)

#: The rule of the constants beyond the first.
_CONSTANT_RULE = _checks.finite_rule(
    "It is a constant of Yeoh's energy, in the unit of the first.", "Pass 0 to leave its term out."
)


@dataclass(frozen=True)
class Yeoh(Material):
    r"""Yeoh's solid, a cubic in the first invariant.

    :math:`W = c_1 (I_1 - 3) + c_2 (I_1 - 3)^2 + c_3 (I_1 - 3)^3`, divided by the shear modulus
    :math:`2 c_1`, so that the constants may be given in pascal.  Usually :math:`c_2` is negative
    (rubber softens first) and :math:`c_3` positive (it stiffens later).

    Parameters
    ----------
    c1, c2, c3 : float
        Constants of the powers of :math:`I_1 - 3`, in one unit; `c1` above 0.
    entropic_fraction : float
        Share of the modulus that is proportional to temperature.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    NeoHookean : The case c2 = c3 = 0.
    StrainEnergy : Any other function of the invariants.

    References
    ----------
    O. H. Yeoh, Some forms of the strain energy function for rubber, Rubber Chemistry and
    Technology 66 (1993) 754-771.

    Examples
    --------
    >>> p = {"c1": 0.5, "c2": -0.005, "c3": 0.0001}
    >>> round(Yeoh(0.5, -0.005, 0.0001).energy(2.0, 1.0, 0.5, p, None), 12)
    1.1008265625
    """

    c1: float
    c2: float
    c3: float = 0.0
    entropic_fraction: float = 1.0

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "c1": _checks.positive_rule(
                "Twice this constant is the shear modulus.", "Check its sign."
            ),
            "c2": _CONSTANT_RULE,
            "c3": _CONSTANT_RULE,
            "entropic_fraction": ENTROPIC_FRACTION_RULE,
        }
    )

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(0.5, -0.005, 0.0001)

    def energy(self, l1: Any, l2: Any, l3: Any, p: Mapping[str, Any], fn: Any) -> Any:
        """W/mu = [c1 J + c2 J^2 + c3 J^3]/(2 c1), J = I1 - 3."""
        invariant = first_invariant_minus_three(l1, l2, l3)
        c1, c2, c3 = p["c1"], p["c2"], p["c3"]
        return invariant * (c1 + invariant * (c2 + invariant * c3)) / (2 * c1)
