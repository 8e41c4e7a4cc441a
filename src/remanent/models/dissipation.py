"""Dissipation: dashpots on the stretches, and branches with internal variables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar, Self

from remanent import _checks
from remanent._checks import Rule
from remanent.models.materials.base import first_invariant_minus_three
from remanent.models.parts import Part, part_parameters
from remanent.models.temperature_shift import TemperatureShift

#: The rule of a viscosity.
_VISCOSITY_RULE = _checks.not_negative_rule(
    "A dashpot takes energy out of the motion.", "Pass 0 for no damping."
)


@dataclass(frozen=True)
class Dissipation(Part):
    """A dissipative element acting in parallel with the elastic solid.

    An element may have a Rayleigh function, and it may have internal variables (for
    example the stretch of a spring in series with a dashpot), one of each kind for
    each of the two in-plane directions, with a stored energy and their own rates.
    All energies are per reference volume, divided by mu at T0; time is tau.
    """

    #: Kinds of internal variables.  There is one of each kind for each in-plane direction; it
    #: is 1 at rest in the undeformed state and relaxes to the stretch in its direction.
    internal_variable_kinds: ClassVar[tuple[str, ...]] = ()
    #: The numeric field that is 0 where the element does nothing.
    strength_field_name: ClassVar[str] = "eta"
    #: The numeric field that a shift multiplies by its factor.
    shifted_field_name: ClassVar[str] = "eta"

    def rayleigh_function(
        self, stretches: Sequence[Any], rates: Sequence[Any], p: Mapping[str, Any]
    ) -> Any:
        """Rayleigh function D; the force on stretch i is -dD/d(rate i).

        Parameters
        ----------
        stretches, rates
            In-plane stretches and their rates, two of each.
        p
            Values of the element's numeric fields, by name.
        """
        return 0

    def stored_energy(
        self, stretches: Sequence[Any], internal: Sequence[Any], p: Mapping[str, Any]
    ) -> Any:
        """Energy stored in the element at T0; it is multiplied by T/T0.

        Parameters
        ----------
        stretches
            All three principal stretches, whose product is 1.
        internal
            Internal variables, kind by kind, two directions each.
        p
            Values of the element's numeric fields, by name.
        """
        return 0

    def internal_rates(
        self, stretches: Sequence[Any], internal: Sequence[Any], theta: Any, p: Mapping[str, Any]
    ) -> Sequence[Any]:
        """Rates of the internal variables.

        Parameters
        ----------
        stretches
            All three principal stretches, whose product is 1.
        internal
            Internal variables, kind by kind, two directions each.
        theta
            T/T0.
        p
            Values of the element's numeric fields, by name.

        Returns
        -------
        sequence
            One rate for each entry of `internal`, in that order.
        """
        return ()

    def parameters_at_temperature(
        self, temperature: Any, reference: Any, p: Mapping[str, Any], fn: Any
    ) -> Mapping[str, Any]:
        """The numeric fields `p` at a temperature: the shifted one times the factor."""
        shift: TemperatureShift | None = getattr(self, "shift", None)
        if shift is None:
            return p
        factor = shift.shift_factor(temperature, reference, part_parameters("shift", p), fn)
        return {**p, self.shifted_field_name: p[self.shifted_field_name] * factor}


@dataclass(frozen=True)
class Rayleigh(Dissipation):
    r"""A linear dashpot on the stretches.

    :math:`D = \eta (\lambda_1'^2 + \lambda_2'^2)/2` per :math:`8 H L^2 \mu`.  For equal
    stretches the term :math:`\eta \lambda'` joins the bracket of [Thermal, eq. 16].

    Parameters
    ----------
    eta : float
        Viscosity divided by the product of mu and the unit of time, dimensionless;
        :meth:`Actuator.viscosity` makes it of Pa s.
    shift : WLF or Arrhenius, optional
        How the viscosity depends on temperature, :class:`WLF` or :class:`Arrhenius`.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    KelvinVoigt : A viscous fluid, for finite strain.
    Zener : A spring in series with a dashpot.

    Examples
    --------
    >>> Rayleigh(0.1).rayleigh_function((1.0, 1.0), (2.0, 2.0), {"eta": 0.1})
    0.4
    """

    eta: float
    shift: TemperatureShift | None = None

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType({"eta": _VISCOSITY_RULE})
    nested_part_types: ClassVar[Mapping[str, type[Part]]] = MappingProxyType(
        {"shift": TemperatureShift}
    )

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(0.2)

    def rayleigh_function(
        self, stretches: Sequence[Any], rates: Sequence[Any], p: Mapping[str, Any]
    ) -> Any:
        """D = eta (l1'^2 + l2'^2)/2."""
        return p["eta"] * (rates[0] ** 2 + rates[1] ** 2) / 2


@dataclass(frozen=True)
class KelvinVoigt(Dissipation):
    r"""A Newtonian fluid in parallel.

    :math:`D = \eta [e_1^2 + e_2^2 + (e_1 + e_2)^2]` with :math:`e_i = \lambda_i'/\lambda_i`.
    The third rate is that of the thickness, :math:`e_3 = -(e_1 + e_2)`, so that :math:`D` is half
    the power that the Newtonian stress :math:`2 \eta e` dissipates.  For equal stretches it is
    :math:`6 \eta (\lambda'/\lambda)^2`: near :math:`\lambda = 1` a :class:`Rayleigh` dashpot of
    six times this viscosity.

    Parameters
    ----------
    eta : float
        Shear viscosity divided by the product of mu and the unit of time, dimensionless;
        :meth:`Actuator.viscosity` makes it of Pa s.
    shift : WLF or Arrhenius, optional
        How the viscosity depends on temperature, :class:`WLF` or :class:`Arrhenius`.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    Rayleigh : A linear dashpot.
    Zener : A spring in series with a dashpot.

    Notes
    -----
    Its derivative by the rates enters Lagrange's equation [Thermal, eq. 8].

    Examples
    --------
    >>> KelvinVoigt(0.1).rayleigh_function((2.0, 2.0), (1.0, 1.0), {"eta": 0.1})
    0.15000000000000002
    """

    eta: float
    shift: TemperatureShift | None = None

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType({"eta": _VISCOSITY_RULE})
    nested_part_types: ClassVar[Mapping[str, type[Part]]] = MappingProxyType(
        {"shift": TemperatureShift}
    )

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(0.1)

    def rayleigh_function(
        self, stretches: Sequence[Any], rates: Sequence[Any], p: Mapping[str, Any]
    ) -> Any:
        """D = eta (e1^2 + e2^2 + (e1 + e2)^2)."""
        e1, e2 = (v / x for x, v in zip(stretches[:2], rates, strict=True))
        return p["eta"] * (e1**2 + e2**2 + (e1 + e2) ** 2)


@dataclass(frozen=True)
class Zener(Dissipation):
    r"""A spring in series with a dashpot; several of them are a Prony series.

    The state gains the viscous stretches :math:`\xi`, in-plane, whose product with the third is
    1.  With :math:`q_i = (\lambda_i/\xi_i)^2`, :math:`q_3 = (\lambda_3 \xi_1 \xi_2)^2` and
    :math:`\theta = T/T_0` the energy is :math:`\theta (\mu_v/\mu) (q_1 + q_2 + q_3 - 3)/2`, and
    :math:`\xi_i'/\xi_i = \theta [q_i - (q_1 + q_2 + q_3)/3]/(2 t_r)`.  For equal stretches
    :math:`\xi'/\xi = \theta (\lambda^2 \xi^{-2} - \lambda^{-4} \xi^4)/(6 t_r)`.

    Parameters
    ----------
    modulus : float
        :math:`\mu_v/\mu`, shear modulus of the spring at :math:`T_0` over that of the elastic
        solid.
    relaxation_time : float
        :math:`t_r = \eta/\mu_v` in units of tau.  Where it goes to infinity, the element is a
        spring in parallel; where it goes to 0, it vanishes, to first order in :math:`t_r`, and
        the equations become stiff: steps are then as short as :math:`t_r`.
    shift : WLF or Arrhenius, optional
        How the relaxation time depends on temperature, :class:`WLF` or
        :class:`Arrhenius`.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    KelvinVoigt : The dashpot alone.
    cycle_losses : What it dissipates in a period.

    References
    ----------
    S. Govindjee and S. Reese, A presentation and comparison of two large deformation
    viscoelasticity models, Journal of Engineering Materials and Technology 119 (1997) 251-255.

    Examples
    --------
    >>> Zener(0.5, 2.0).stored_energy((2.0, 1.0, 0.5), (1.0, 1.0), {"modulus": 0.5})
    0.5625
    """

    modulus: float
    relaxation_time: float
    shift: TemperatureShift | None = None

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "modulus": _checks.not_negative_rule(
                "It is the shear modulus of a spring over that of the solid.",
                "Pass 0 for none.",
            ),
            "relaxation_time": _checks.positive_rule(
                "It is the time in which the spring relaxes.",
                "Pass a time above 0; a spring that never relaxes is a larger shear modulus.",
            ),
        }
    )
    nested_part_types: ClassVar[Mapping[str, type[Part]]] = MappingProxyType(
        {"shift": TemperatureShift}
    )
    internal_variable_kinds: ClassVar[tuple[str, ...]] = ("viscous_stretch",)
    strength_field_name: ClassVar[str] = "modulus"
    shifted_field_name: ClassVar[str] = "relaxation_time"

    @classmethod
    def example(cls) -> Self:
        """An instance with usual numbers, on which contract tests try every public part."""
        return cls(0.5, 0.7)

    def stored_energy(
        self, stretches: Sequence[Any], internal: Sequence[Any], p: Mapping[str, Any]
    ) -> Any:
        """(mu_v/mu) (q1 + q2 + q3 - 3)/2, without cancellation near rest."""
        return (
            p["modulus"] * first_invariant_minus_three(*_spring_stretches(stretches, internal)) / 2
        )

    def internal_rates(
        self, stretches: Sequence[Any], internal: Sequence[Any], theta: Any, p: Mapping[str, Any]
    ) -> Sequence[Any]:
        """xi_i theta/(2 t_r) [q_i - (q1 + q2 + q3)/3], written as sums of differences."""
        q1, q2, q3 = _squared_spring_stretches(stretches, internal)
        speed = theta / (6 * p["relaxation_time"])
        return (
            internal[0] * speed * ((q1 - q2) + (q1 - q3)),
            internal[1] * speed * ((q2 - q1) + (q2 - q3)),
        )


def _squared_spring_stretches(
    stretches: Sequence[Any], internal: Sequence[Any]
) -> tuple[Any, Any, Any]:
    """Squares of the spring's own stretches."""
    e1, e2, e3 = _spring_stretches(stretches, internal)
    return e1**2, e2**2, e3**2


def _spring_stretches(stretches: Sequence[Any], internal: Sequence[Any]) -> tuple[Any, Any, Any]:
    """The spring's own stretches, l_i/xi_i, whose product is 1."""
    (l1, l2, l3), (x1, x2) = stretches, internal
    return l1 / x1, l2 / x2, l3 * x1 * x2
