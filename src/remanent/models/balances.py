"""What is conserved: the balances of energy and entropy, and the body's temperature.

Everything follows from the free energy per reference volume over mu,
Psi = mu(T)/mu W + theta Psi_v + caloric energy + energy in the field, theta = T/T0, and
theta s' = D - h (theta - theta_env),  s = -dPsi/dtheta  (in units of mu/T0).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy as sp

from remanent.models import thermal

if TYPE_CHECKING:
    from remanent.models.mechanics import Motion

Expression = Any  # SymPy is not typed
Symbol = Any


@dataclass(frozen=True)
class Warming:
    """The heat balance of a body, in symbols.

    Attributes
    ----------
    temperature
        Symbol of T, a state.
    reference
        Symbol of T0.
    free, free_in_field
        Free energy, and the part of it that the field makes, of theta and of the load,
        which stand in it as symbols.
    surroundings
        Temperature of the surroundings over T0.
    conductance
        h, exchanged power per unit of theta.
    load_rate
        Rate of the load; None where it is not known in closed form.
    """

    temperature: Symbol
    reference: Symbol
    free: Expression
    free_in_field: Expression
    surroundings: Expression
    conductance: Expression
    load_rate: Expression | None

    def entropy(self, motion: Motion) -> Expression:
        """s = -dPsi/dtheta."""
        return -sp.diff(self.free, motion.theta)

    def outflow(self, motion: Motion) -> Expression:
        """Power given to the surroundings, h (theta - theta_env)."""
        return self.conductance * (motion.theta - self.surroundings)

    def rate(
        self, rates: Mapping[Symbol, Expression], lost: Expression, motion: Motion
    ) -> dict[Symbol, Expression]:
        """T' from theta s' = D - h (theta - theta_env)."""
        theta, entropy = motion.theta, motion.natural(self.entropy(motion))
        elsewhere = along(entropy, self._moving(rates, motion))
        capacity = sp.simplify(theta * sp.diff(entropy, theta))
        power = lost - self.outflow(motion) - theta * elsewhere
        return {self.temperature: self.reference * power / capacity}

    def observed(
        self, rates: Mapping[Symbol, Expression], lost: Expression, motion: Motion
    ) -> dict[str, Expression]:
        """Internal energy without that in the field, and what changes it and the entropy.

        Equations: stored' = drive power - heat flow; with e = Psi + theta s the energy in
        the field is e_m, and the drive's power dPsi/dm m' - e_m'.
        entropy' = entropy production - entropy flow, the flow being what the surroundings
        gain, and the production D/theta + h (theta - theta_env)^2/(theta theta_env).
        """
        theta, around = motion.theta, self.surroundings
        in_field = self._internal(self.free_in_field, theta)
        moving = self._moving(rates, motion)
        moving[theta] = rates[self.temperature] / self.reference
        load_rate = moving.get(motion.load, sp.Integer(0))
        outflow = self.outflow(motion)
        dead = motion.terms[2][1]
        own = self._internal(self.free - self.free_in_field, theta)
        return {
            "stored_energy": motion.kinetic + dead + own,
            "drive_power": sp.diff(self.free, motion.load) * load_rate - along(in_field, moving),
            "dissipated_power": lost,
            "heat_flow": outflow,
            "entropy": self.entropy(motion),
            "entropy_flow": outflow / around,
            "entropy_production": lost / theta
            + self.conductance * (theta - around) ** 2 / (theta * around),
        }

    def _internal(self, free: Expression, theta: Symbol) -> Expression:
        """e = Psi - theta dPsi/dtheta, with the logarithms cancelled."""
        return sp.expand(free - theta * sp.diff(free, theta))

    def _moving(
        self, rates: Mapping[Symbol, Expression], motion: Motion
    ) -> dict[Symbol, Expression]:
        """Rates of everything but the temperature."""
        moving = {k: v for k, v in rates.items() if k != self.temperature}
        moving[motion.thickness] = motion.thickness_rate
        if self.load_rate is not None:
            moving[motion.load] = self.load_rate
        return moving


def warming(
    *,
    temperature: Symbol,
    p: Mapping[str, Symbol],
    theta: Symbol,
    mechanical: Expression,
    in_field: Expression,
    load_rate: Expression | None,
) -> Warming:
    """The heat balance of a body whose free energy has these parts.

    Parameters
    ----------
    temperature
        Symbol of T.
    p
        Numeric fields of the actuator, with ``heat.coupling`` k = mu/(rho c_p T0) and
        ``heat.exchange``, the rate at which the temperature would decay, so that h is
        the latter over the former.
    theta
        Symbol of T/T0, in which `mechanical` and `in_field` are written.
    """
    coupling, exchange = p["heat.coupling"], p["heat.exchange"]
    free = mechanical + in_field + thermal.caloric_energy(theta, coupling, sp)
    return Warming(
        temperature=temperature,
        reference=p["reference_temperature"],
        free=free,
        free_in_field=in_field,
        surroundings=p["temperature"] / p["reference_temperature"],
        conductance=exchange / coupling,
        load_rate=load_rate,
    )


def balances(
    motion: Motion, rates: Mapping[Symbol, Expression], lost: Expression
) -> dict[str, Expression]:
    """The energy without that in the field, and the powers that change it.

    Equations, where temperature is held: stored = T + U - U_m; stored' = drive power -
    dissipated power, where the drive's power is -dU_m/dq q' and the dissipated one q'
    dD/dq' - dU_v/dxi xi'.  Else see :meth:`Warming.observed`.
    """
    if motion.heat is not None:
        return motion.heat.observed(rates, lost, motion)
    return {
        "stored_energy": motion.kinetic + motion.potential - motion.magnetic,
        "drive_power": -along(motion.magnetic, {motion.thickness: motion.thickness_rate}),
        "dissipated_power": lost,
    }


def along(expression: Expression, rates: Mapping[Symbol, Expression]) -> Expression:
    """Time derivative of a function of the state along the motion."""
    return sum(
        (sp.diff(expression, symbol) * rate for symbol, rate in rates.items()),
        start=sp.Integer(0),
    )
