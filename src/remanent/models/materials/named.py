"""Strain energies of incompressible elastomers, normalised to unit shear modulus."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Self

from remanent import _checks
from remanent._checks import Rule
from remanent._errors import InputError
from remanent._typing import FloatArray
from remanent.models.materials.base import (
    ENTROPIC_FRACTION_RULE,
    Material,
    first_invariant_minus_three,
    second_invariant_minus_three,
    sum_of_squares_minus_three,
)
from remanent.models.materials.strain_energy import StrainEnergy

__all__ = [
    "ArrudaBoyce", "Gent", "Material", "MooneyRivlin", "NeoHookean", "Ogden", "StrainEnergy",
]  # fmt: skip

#: The rule of the shear modulus that follows from the constants.
_MODULUS_RULE = _checks.positive_rule(
    "It is the shear modulus of the undeformed solid, by which the energy is divided.",
    "Check the constants and their signs; without a positive modulus the undeformed state is not "
    "stable.",
)


@dataclass(frozen=True)
class NeoHookean(Material):
    r"""The neo-Hookean solid, whose energy is linear in the first invariant [Thermal, eq. 3].

    :math:`W/\mu = (\lambda_1^2 + \lambda_2^2 + \lambda_3^2 - 3)/2`.

    Parameters
    ----------
    entropic_fraction : float
        Share of the modulus that is proportional to temperature.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    Gent : A solid whose chains have a limit.
    StrainEnergy : An energy of one's own.

    Examples
    --------
    >>> NeoHookean().energy(2.0, 1.0, 0.5, {}, None)
    1.125
    """

    entropic_fraction: float = 1.0

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {"entropic_fraction": ENTROPIC_FRACTION_RULE}
    )

    def energy(self, l1: Any, l2: Any, l3: Any, p: Mapping[str, Any], fn: Any) -> Any:
        """W/mu = [(l1 - l2)^2 + (1 - l3)^2 (2 + l3)/l3]/2.

        With l1 l2 l3 = 1 this is (l1^2 + l2^2 + l3^2 - 3)/2, without the cancellation
        near rest: both terms are squares.
        """
        return first_invariant_minus_three(l1, l2, l3) / 2


@dataclass(frozen=True)
class Gent(Material):
    r"""Gent's solid, whose chains have a limit.

    :math:`W/\mu = -(J_m/2) \ln[1 - (I_1 - 3)/J_m]`.  The first invariant
    :math:`I_1 = \lambda_1^2 + \lambda_2^2 + \lambda_3^2` stays below :math:`J_m + 3`; as
    :math:`J_m` grows, the solid becomes neo-Hookean.  An initial state beyond the limit is
    refused; steps that would cross it are made shorter, or the motion ends there with a status.

    Parameters
    ----------
    jm : float
        Limiting value :math:`J_m` of :math:`I_1 - 3`; about 30 to 100 for rubber, less for stiff
        tissue.
    entropic_fraction : float
        Share of the modulus that is proportional to temperature.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    ArrudaBoyce : Chains that stiffen without a limit.
    NeoHookean : Its limit as J_m grows.

    References
    ----------
    A. N. Gent, A new constitutive relation for rubber, Rubber Chemistry and Technology
    69 (1996) 59-61.

    Examples
    --------
    >>> import math
    >>> round(Gent(10.0).energy(2.0, 1.0, 0.5, {"jm": 10.0}, math), 12)
    1.274461248144
    """

    jm: float
    entropic_fraction: float = 1.0

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "jm": _checks.positive_rule(
                "It is the value of I1 - 3 at which the chains are fully stretched.",
                "Pass about 30 to 100 for rubber, or use NeoHookean() for no limit.",
            ),
            "entropic_fraction": ENTROPIC_FRACTION_RULE,
        }
    )

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(12.0)

    def energy(self, l1: Any, l2: Any, l3: Any, p: Mapping[str, Any], fn: Any) -> Any:
        """W/mu = -(J_m/2) ln[1 - (I1 - 3)/J_m]."""
        (remaining,) = self.admissibility_conditions(l1, l2, l3, p, fn)
        return -p["jm"] * fn.log(remaining) / 2

    def admissibility_conditions(
        self, l1: Any, l2: Any, l3: Any, p: Mapping[str, Any], fn: Any
    ) -> Sequence[Any]:
        """1 - (I1 - 3)/J_m, what remains of the extension of the chains."""
        return (1 - first_invariant_minus_three(l1, l2, l3) / p["jm"],)


@dataclass(frozen=True)
class MooneyRivlin(Material):
    r"""The solid of Mooney and Rivlin, linear in both invariants.

    :math:`W/\mu = [c_1 (I_1 - 3) + c_2 (I_2 - 3)]/[2 (c_1 + c_2)]`.  Only the ratio of the
    constants matters: the energy is divided by the shear modulus :math:`2 (c_1 + c_2)`, so they
    may be given in pascal.  With :math:`c_2 = 0` it is neo-Hookean.

    Parameters
    ----------
    c1, c2 : float
        Constants of the two invariants, not negative, not both zero.
    entropic_fraction : float
        Share of the modulus that is proportional to temperature.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    NeoHookean : The case c2 = 0.
    Ogden : The case of exponents 2 and -2.

    References
    ----------
    R. S. Rivlin, Large elastic deformations of isotropic materials IV, Philosophical
    Transactions of the Royal Society A 241 (1948) 379-397.

    Examples
    --------
    >>> MooneyRivlin(0.25, 0.25).energy(2.0, 1.0, 0.5, {"c1": 0.25, "c2": 0.25}, None)
    1.125
    """

    c1: float
    c2: float
    entropic_fraction: float = 1.0

    _constant_rule: ClassVar[Rule] = _checks.not_negative_rule(
        "With a negative constant the energy has no lower bound.", "Check its sign."
    )
    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {"c1": _constant_rule, "c2": _constant_rule, "entropic_fraction": ENTROPIC_FRACTION_RULE}
    )

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(0.3, 0.1)

    def derived_numbers(self, p: Mapping[str, Any]) -> Mapping[str, tuple[Any, Rule]]:
        """The shear modulus 2 (c1 + c2)."""
        return {"2 (c1 + c2)": (2 * (p["c1"] + p["c2"]), _MODULUS_RULE)}

    def energy(self, l1: Any, l2: Any, l3: Any, p: Mapping[str, Any], fn: Any) -> Any:
        """W/mu = [c1 (I1 - 3) + c2 (I2 - 3)]/[2 (c1 + c2)]."""
        c1, c2 = p["c1"], p["c2"]
        total = c1 * first_invariant_minus_three(l1, l2, l3) + c2 * second_invariant_minus_three(
            l1, l2, l3
        )
        return total / (2 * (c1 + c2))


@dataclass(frozen=True)
class Ogden(Material):
    r"""Ogden's solid, a sum of powers of the stretches.

    :math:`W = \sum_i (\mu_i/\alpha_i) (\lambda_1^{\alpha_i} + \lambda_2^{\alpha_i} +
    \lambda_3^{\alpha_i} - 3)`, divided by the shear modulus :math:`\sum_i \mu_i \alpha_i/2`, so
    that the moduli may be given in pascal.  Moduli and exponents may be varied one by one:
    ``material.moduli.0``, ``material.exponents.1`` ...

    Parameters
    ----------
    moduli, exponents : sequence of float (term,)
        :math:`\mu_i` and :math:`\alpha_i`, one of each per term; exponents are not zero.
    entropic_fraction : float
        Share of the modulus that is proportional to temperature.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    MooneyRivlin : Two terms with fixed exponents.
    Yeoh : Powers of the first invariant.

    References
    ----------
    R. W. Ogden, Large deformation isotropic elasticity, Proceedings of the Royal Society A
    326 (1972) 565-584.

    Examples
    --------
    >>> treloar = Ogden([0.63, 0.0012, -0.01], [1.3, 5.0, -2.0])  # MPa
    >>> round(float(treloar.energy(2.0, 1.0, 0.5, treloar.parameter_values(), None)), 12)
    1.039774630254
    """

    moduli: Sequence[float] | FloatArray
    exponents: Sequence[float] | FloatArray
    entropic_fraction: float = 1.0

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {"entropic_fraction": ENTROPIC_FRACTION_RULE}
    )
    table_rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "moduli": _checks.finite_rule("It is the factor of one term of the energy."),
            "exponents": Rule(
                "be a finite number other than 0",
                lambda x: x != 0,
                "It is the power of the stretches in one term.",
                "Leave the term out, or pass the power.",
            ),
        }
    )

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls([0.63, 0.0012, -0.01], [1.3, 5.0, -2.0])

    def checked_fields(self) -> Mapping[str, Any]:
        """Nothing new, if there is an exponent for each modulus."""
        if len(self.moduli) != len(self.exponents):
            raise InputError(
                "exponents",
                must=f"have as many entries as `moduli`, {len(self.moduli)}",
                got=len(self.exponents),
                why="Each term has a modulus and an exponent.",
                fix="Pass one entry per term.",
            )
        return {}

    def derived_numbers(self, p: Mapping[str, Any]) -> Mapping[str, tuple[Any, Rule]]:
        """The shear modulus, half the sum of the products mu_i alpha_i."""
        return {"sum of moduli times exponents": (self._twice_modulus(p), _MODULUS_RULE)}

    def energy(self, l1: Any, l2: Any, l3: Any, p: Mapping[str, Any], fn: Any) -> Any:
        """W/mu = sum_i 2 (mu_i/alpha_i)(sum_k l_k^alpha_i - 3)/sum_i mu_i alpha_i.

        Each bracket is that of the neo-Hookean energy for stretches to the power alpha_i/2,
        and is written without cancellation in the same way.
        """
        total = sum(
            mu
            / alpha
            * sum_of_squares_minus_three(*(stretch ** (alpha / 2) for stretch in (l1, l2, l3)))
            for mu, alpha in self._modulus_exponent_pairs(p)
        )
        return 2 * total / self._twice_modulus(p)

    def _modulus_exponent_pairs(self, p: Mapping[str, Any]) -> list[tuple[Any, Any]]:
        return [(p[f"moduli.{i}"], p[f"exponents.{i}"]) for i in range(len(self.moduli))]

    def _twice_modulus(self, p: Mapping[str, Any]) -> Any:
        return sum(mu * alpha for mu, alpha in self._modulus_exponent_pairs(p))


#: Coefficients of I1^i - 3^i in the series of Arruda and Boyce, i = 1, 2 ...
_ARRUDA_BOYCE_COEFFICIENTS = ((1, 2), (1, 20), (11, 1050), (19, 7000), (519, 673750))


@dataclass(frozen=True)
class ArrudaBoyce(Material):
    r"""The eight-chain solid of Arruda and Boyce, by its series of five terms.

    :math:`W = \sum_{i=1}^5 C_i L^{2 - 2 i} (I_1^i - 3^i)` with :math:`C` = 1/2, 1/20, 11/1050,
    19/7000, 519/673750, divided by its shear modulus at rest.  As :math:`L` grows it is
    neo-Hookean.  The series stands for the inverse Langevin function.  It stiffens but has no
    limiting extension: :math:`dW/dI_1` is 3 % too small where :math:`I_1 = 1.5 L^2`, 10 % at
    :math:`1.9 L^2` and 34 % at :math:`2.4 L^2` (the exact function is infinite at
    :math:`3 L^2`); :class:`Gent` has a limit.

    Parameters
    ----------
    locking_stretch : float
        :math:`L`, the stretch of a chain at its limit, above 1.
    entropic_fraction : float
        Share of the modulus that is proportional to temperature.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    Gent : A solid with a limiting extension.
    NeoHookean : Its limit as L grows.

    References
    ----------
    E. M. Arruda, M. C. Boyce, A three-dimensional constitutive model for the large stretch
    behavior of rubber elastic materials, J. Mech. Phys. Solids 41 (1993) 389-412.

    Examples
    --------
    >>> p = {"locking_stretch": 3.0}
    >>> round(ArrudaBoyce(3.0).energy(2.0, 1.0, 0.5, p, None), 12)
    1.15984810106
    """

    locking_stretch: float
    entropic_fraction: float = 1.0

    expand_energy: ClassVar[bool] = False

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "locking_stretch": Rule(
                "be a finite number greater than 1",
                lambda x: x > 1,
                "It is the stretch at which chains are fully extended; undeformed they have 1.",
                "Pass about 2 to 10.",
            ),
            "entropic_fraction": ENTROPIC_FRACTION_RULE,
        }
    )

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(2.5)

    def energy(self, l1: Any, l2: Any, l3: Any, p: Mapping[str, Any], fn: Any) -> Any:
        """W/mu = (I1 - 3) sum_i C_i y^(i - 1) [sum_k I1^k 3^(i - 1 - k)]/mu, y = 1/L^2.

        I1^i - 3^i with its factor I1 - 3 taken out, which is small near rest;
        mu = 2 sum_i i C_i (3 y)^(i - 1), twice the slope of W in I1 at I1 = 3.
        """
        invariant = first_invariant_minus_three(l1, l2, l3)  # I1 - 3, small near rest
        y = 1 / p["locking_stretch"] ** 2
        total, modulus = 0, 0
        for i, (above, below) in enumerate(_ARRUDA_BOYCE_COEFFICIENTS):
            powers = sum((3 + invariant) ** k * 3 ** (i - k) for k in range(i + 1))
            total = total + above * y**i / below * powers
            modulus = modulus + 2 * (i + 1) * above * (3 * y) ** i / below
        return invariant * total / modulus
