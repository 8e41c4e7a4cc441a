"""How temperature enters: entropic elasticity, the caloric free energy, heat exchange."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, ClassVar

from remanent import _checks
from remanent._checks import Rule
from remanent.models.parts import Part


@dataclass(frozen=True)
class Heat(Part):
    r"""A heat balance: the temperature of the body becomes a state, ``body_temperature``.

    :math:`T s' = D - \rho c_p h (T - T_\infty)` per reference volume, with
    :math:`s = -\partial\Psi/\partial T` of the whole free energy, :math:`D` the dissipated power
    and :math:`h` the `exchange`.  For the entropic model and :math:`\theta = T/T_0` that is
    :math:`\theta' = k [\theta (W + \psi_v)' + D] - h (\theta -
    \theta_\infty)`, plus a term of the remanence where that depends on temperature.
    :math:`T_\infty` is the actuator's ``temperature``, from which the body starts too, unless
    `initial` says otherwise.

    Parameters
    ----------
    coupling : float
        :math:`k = \mu/(\rho c_p T_0)`, about 2e-4 for elastomers; see :meth:`Actuator.coupling`.
        The temperature follows the strain energy as :math:`\ln(T/T_i) = k (W - W_i)`.
    exchange : float
        :math:`h`, the rate, per unit of tau, at which the body takes on the temperature of its
        surroundings: 0 is adiabatic, infinity isothermal.

    Raises
    ------
    InputError
        A value that breaks the rule of its field; the message says which and what to do.

    See Also
    --------
    energy_balance : Heat and entropy along a motion.
    Actuator.coupling : The coupling number of a material.

    Notes
    -----
    The free energy without an external field is that of [Thermal, eq. 6].

    Examples
    --------
    >>> Heat().parameter_values()
    {'coupling': 0.0002, 'exchange': 0.0}
    """

    coupling: float = 2e-4
    exchange: float = 0.0

    rules: ClassVar[Mapping[str, Rule]] = MappingProxyType(
        {
            "coupling": _checks.positive_rule(
                "It is mu/(rho c_p T0), by which strain energy warms the body.",
                "Pass about 2e-4; to hold the temperature leave `heat` out.",
            ),
            "exchange": _checks.not_negative_rule(
                "It is a rate of cooling per unit of tau.", "Pass 0 for an adiabatic body."
            ),
        }
    )


def entropic_stiffness_ratio(theta: Any, entropic_fraction: Any) -> Any:
    """Factor of the strain energy at temperature T = theta T0.

    Equation: mu(T)/mu(T0) = (1 - f) + f theta.  With f = 1, entropic elasticity, this
    is T/T0 [Thermal, eq. 6]; with f = 0 the modulus does not depend on temperature.
    """
    return (1 - entropic_fraction) + entropic_fraction * theta


def caloric_free_energy(theta: Any, coupling: Any, fn: Any) -> Any:
    """Caloric part of the free energy per reference volume, divided by mu.

    Equation: rho c_p [T - T0 - T ln(T/T0)] / mu = [theta - 1 - theta ln theta] / k,
    where k = mu / (rho c_p T0) is the coupling number, about 2e-4.  It does not depend
    on the stretches: at constant temperature it is a constant and moves nothing.
    """
    return (theta - 1 - theta * fn.log(theta)) / coupling
