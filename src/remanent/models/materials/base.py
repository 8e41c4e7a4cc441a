"""What every elastomer is: a strain energy with unit shear modulus at rest."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from remanent._checks import Rule
from remanent.models.parts import Part

#: The rule of the share of the modulus that is proportional to temperature.
ENTROPIC_FRACTION_RULE = Rule(
    "be a finite number from 0 to 1",
    lambda x: np.asarray((x >= 0) & (x <= 1)),
    "It is the share of the shear modulus that is proportional to temperature.",
    "Pass 1 for rubber (entropic elasticity) or 0 for a modulus without temperature.",
)


@dataclass(frozen=True)
class Material(Part, ABC):
    """A strain energy per reference volume, divided by the shear modulus at T0.

    A subclass has a numeric field `entropic_fraction`, see
    :func:`remanent.models.heat.entropic_stiffness_ratio`.
    """

    #: Whether rates are brought to quotients of expanded polynomials.  False for formulas
    #: whose expansion is long: rates are then computed from the energy's derivatives as they
    #: are written.
    expand_energy: ClassVar[bool] = True

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

    def admissibility_conditions(
        self, l1: Any, l2: Any, l3: Any, p: Mapping[str, Any], fn: Any
    ) -> Sequence[Any]:
        """What must be positive for the energy to exist.

        Parameters
        ----------
        l1, l2, l3, p, fn
            Stretches, numeric fields and functions, as :meth:`energy` takes them.

        Returns
        -------
        sequence
            One value for each condition; none where every stretch is admissible.

        Notes
        -----
        A motion never leaves the states where all of it is positive: rates are NaN
        elsewhere, so that steps that would cross are made shorter or given up.
        """
        return ()


def sum_of_squares_minus_three(a1: Any, a2: Any, a3: Any) -> Any:
    """a1^2 + a2^2 + a3^2 - 3 for a1 a2 a3 = 1, without the cancellation near rest.

    Equation: (a1 - a2)^2 + (1 - a3)^2 (2 + a3)/a3, a square and a positive multiple of one.
    """
    return (a1 - a2) ** 2 + (1 - a3) ** 2 * (2 + a3) / a3


def first_invariant_minus_three(l1: Any, l2: Any, l3: Any) -> Any:
    """I1 - 3 = l1^2 + l2^2 + l3^2 - 3."""
    return sum_of_squares_minus_three(l1, l2, l3)


def second_invariant_minus_three(l1: Any, l2: Any, l3: Any) -> Any:
    """I2 - 3 = l1^-2 + l2^-2 + l3^-2 - 3."""
    return sum_of_squares_minus_three(1 / l1, 1 / l2, 1 / l3)
