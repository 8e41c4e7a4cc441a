"""How viscosities and relaxation times depend on temperature."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Self

from remanent import _checks
from remanent._checks import Rule
from remanent.models.parts import Part


@dataclass(frozen=True)
class TemperatureShift(Part, ABC):
    """A factor a_T of the viscosity or relaxation time, 1 at the reference temperature."""

    @abstractmethod
    def shift_factor(self, temperature: Any, reference: Any, p: Mapping[str, Any], fn: Any) -> Any:
        """a_T at a temperature, both in kelvin.

        Parameters
        ----------
        temperature, reference
            T, and T0 at which the numbers of the element are given; kelvin.
        p
            Values of the numeric fields, by name.
        fn
            Where ``exp`` is found: the module sympy or numpy.
        """

    def where_valid(self, temperature: Any, reference: Any, p: Mapping[str, Any]) -> Any:
        """Whether the law can be used at a temperature."""
        return temperature > 0.0


@dataclass(frozen=True)
class WLF(TemperatureShift):
    r"""The law of Williams, Landel and Ferry.

    :math:`\log_{10} a_T = -c_1 (T - T_0)/(c_2 + T - T_0)`.  It holds above the glass transition,
    up to some 100 K; temperatures from :math:`T_0 - c_2` down, where it has a pole, are refused.

    Parameters
    ----------
    c1, c2 : float
        Constants for the actuator's reference temperature :math:`T_0`; `c2` in kelvin.  The
        universal 17.44 and 51.6 K belong to the glass transition temperature.  Constants
        :math:`c_1, c_2` for :math:`T_1` become, for :math:`T_0`: :math:`c_2' = c_2 + T_0 - T_1`
        and :math:`c_1' = c_1 c_2/c_2'`.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    Arrhenius : An activated process.
    Zener : An element whose relaxation time it shifts.

    References
    ----------
    M. L. Williams, R. F. Landel and J. D. Ferry, J. Am. Chem. Soc. 77 (1955) 3701.

    Examples
    --------
    >>> import numpy
    >>> law = WLF(8.0, 200.0)
    >>> round(float(law.shift_factor(343.0, 293.0, law.parameter_values(), numpy)), 6)
    0.025119
    """

    c1: float
    c2: float

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "c1": _checks.finite_rule("It is the first WLF constant.", "Pass for example 8.86."),
            "c2": _checks.positive_rule(
                "It is the distance in kelvin of T0 from where motion freezes.",
                "Pass for example 101.6.",
            ),
        }
    )

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(8.0, 200.0)

    def shift_factor(self, temperature: Any, reference: Any, p: Mapping[str, Any], fn: Any) -> Any:
        """exp[-ln 10 c1 (T - T0)/(c2 + T - T0)]."""
        above = temperature - reference
        return fn.exp(-fn.log(10) * p["c1"] * above / (p["c2"] + above))

    def where_valid(self, temperature: Any, reference: Any, p: Mapping[str, Any]) -> Any:
        """Above the pole."""
        return p["c2"] + temperature - reference > 0.0


@dataclass(frozen=True)
class Arrhenius(TemperatureShift):
    r"""The law of Arrhenius, of an activated process.

    :math:`\ln a_T = A (1/T - 1/T_0)` with the activation energy over the gas constant,
    :math:`A = E/R`.

    Parameters
    ----------
    activation_temperature : float
        :math:`A` in kelvin; 1 kJ/mol is 120.27 K.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    WLF : The law above the glass transition.
    Zener : An element whose relaxation time it shifts.

    References
    ----------
    J. D. Ferry, Viscoelastic Properties of Polymers (Wiley, 1980), chapter 11.

    Examples
    --------
    >>> import numpy
    >>> law = Arrhenius(6000.0)
    >>> round(float(law.shift_factor(343.0, 293.0, law.parameter_values(), numpy)), 6)
    0.050534
    """

    activation_temperature: float

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "activation_temperature": _checks.finite_rule(
                "It is an activation energy over the gas constant, in kelvin.",
                "Pass for example 6000.",
            )
        }
    )

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(6000.0)

    def shift_factor(self, temperature: Any, reference: Any, p: Mapping[str, Any], fn: Any) -> Any:
        """exp[A (1/T - 1/T0)]."""
        return fn.exp(p["activation_temperature"] * (1 / temperature - 1 / reference))
