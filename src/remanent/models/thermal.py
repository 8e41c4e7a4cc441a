"""How temperature enters: entropic elasticity and the caloric free energy."""

from __future__ import annotations

from typing import Any


def stiffness(theta: Any, entropic_fraction: Any) -> Any:
    """Factor of the strain energy at temperature T = theta T0.

    Equation: mu(T)/mu(T0) = (1 - f) + f theta.  With f = 1, entropic elasticity, this
    is T/T0 (paper, section 2); with f = 0 the modulus does not depend on temperature.
    """
    return (1 - entropic_fraction) + entropic_fraction * theta


def caloric_energy(theta: Any, coupling: Any, fn: Any) -> Any:
    """Caloric part of the free energy per reference volume, divided by mu.

    Equation: rho c_p [T - T0 - T ln(T/T0)] / mu = [theta - 1 - theta ln theta] / k,
    where k = mu / (rho c_p T0) is the coupling number, about 2e-4.  It does not depend
    on the stretches: at constant temperature it is a constant and moves nothing.
    """
    return (theta - 1 - theta * fn.log(theta)) / coupling
