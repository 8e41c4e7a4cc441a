"""What is conserved: the balances of energy and entropy, and the body's temperature.

Everything follows from the free energy per reference volume over mu,
Psi = mu(T)/mu W + theta Psi_v + caloric energy + energy in the field, theta = T/T0, and
theta s' = D - h (theta - theta_env),  s = -dPsi/dtheta  (in units of mu/T0).
Psi is a sum of products f(theta) e(state), whose entropy is -f' e and whose internal energy
(f - theta f') e.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import sympy as sp

from remanent.models import heat

if TYPE_CHECKING:
    from remanent.derivation.lagrange import Motion

Expression = Any  # SymPy is not typed
Symbol = Any
#: A factor that depends on theta alone, and the energy that it multiplies.
Term = tuple[Expression, Expression]


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
        Terms of the free energy without the part that the field makes, and that part, which
        is proportional to the load.
    surroundings
        Temperature of the surroundings over T0.
    conductance
        h, exchanged power per unit of theta.
    load_rate
        Rate of the load; None where it is not known in closed form.
    """

    temperature: Symbol
    reference: Symbol
    free: tuple[Term, ...]
    free_in_field: Term
    surroundings: Expression
    conductance: Expression
    load_rate: Expression | None

    def entropy(self, motion: Motion) -> Expression:
        """s = -dPsi/dtheta."""
        return self._entropy(motion.theta)

    def outflow(self, motion: Motion) -> Expression:
        """Power given to the surroundings, h (theta - theta_env)."""
        return self.conductance * (motion.theta - self.surroundings)

    def rate(
        self, rates: Mapping[Symbol, Expression], damped: Expression, motion: Motion
    ) -> dict[Symbol, Expression]:
        """T' from theta s' = D - h (theta - theta_env).

        Of D, `damped` comes from dashpots in parallel, and -f de/dxi xi' from each term
        with internal variables; theta s' holds -theta f' de/dxi xi' of the same.  Their
        difference is taken here: where f is theta, as of entropic springs, nothing is left.
        """
        theta = motion.theta
        moving = self._moving(rates, motion)
        inner = {k: moving.pop(k) for k in motion.internal}
        elsewhere = along(self._entropy(theta, motion.natural), moving)
        capacity = sum(-theta * sp.diff(factor, theta, 2) * e for factor, e in self._terms())
        relaxed = -sum(
            factor * along(motion.natural(e), inner)
            for factor, e in _internal_terms(self._terms(), theta)
        )
        power = damped + relaxed - self.outflow(motion) - theta * elsewhere
        return {self.temperature: self.reference * power / capacity}

    def observed(
        self, rates: Mapping[Symbol, Expression], lost: Expression, motion: Motion
    ) -> dict[str, Expression]:
        """Internal energy without that in the field, and what changes it and the entropy.

        Equations: stored' = drive power - heat flow; with e = Psi + theta s the energy in
        the field is e_m = Psi_m + theta s_m, and the drive's power dPsi_m/dm m' - e_m', in which
        dPsi_m/dm m' cancels.
        entropy' = entropy production - entropy flow, the flow being what the surroundings
        gain, and the production D/theta + h (theta - theta_env)^2/(theta theta_env).
        """
        theta, around = motion.theta, self.surroundings
        in_field = _internal([self.free_in_field], theta)
        factor, energy = self.free_in_field
        moving = self._moving(rates, motion)
        moving[theta] = rates[self.temperature] / self.reference
        load_rate = moving.pop(motion.load, sp.Integer(0))
        outflow = self.outflow(motion)
        dead = motion.terms[2][1]
        return {
            "stored_energy": motion.kinetic + dead + _internal(self.free, theta),
            "drive_power": theta * sp.diff(factor, theta) * sp.diff(energy, motion.load) * load_rate
            - along(in_field, moving),
            "dissipated_power": lost,
            "heat_flow": outflow,
            "entropy": self.entropy(motion),
            "entropy_flow": outflow / around,
            "entropy_production": lost / theta
            + self.conductance * (theta - around) ** 2 / (theta * around),
        }

    def _terms(self) -> tuple[Term, ...]:
        return (*self.free, self.free_in_field)

    def _entropy(
        self, theta: Symbol, written: Callable[[Expression], Expression] = sp.sympify
    ) -> Expression:
        return sum(-sp.diff(factor, theta) * written(e) for factor, e in self._terms())

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
    mechanical: Sequence[Term],
    in_field: Term,
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
        Symbol of T/T0, on which the factors of `mechanical` and `in_field` depend.
    """
    coupling, exchange = p["heat.coupling"], p["heat.exchange"]
    return Warming(
        temperature=temperature,
        reference=p["reference_temperature"],
        free=(*mechanical, (heat.caloric_energy(theta, coupling, sp), sp.Integer(1))),
        free_in_field=in_field,
        surroundings=p["temperature"] / p["reference_temperature"],
        conductance=exchange / coupling,
        load_rate=load_rate,
    )


def _internal(terms: Sequence[Term], theta: Symbol) -> Expression:
    """e = Psi - theta dPsi/dtheta, with the logarithms cancelled."""
    return sum(factor * energy for factor, energy in _internal_terms(terms, theta))


def _internal_terms(terms: Sequence[Term], theta: Symbol) -> list[Term]:
    return [(sp.expand(f - theta * sp.diff(f, theta)), energy) for f, energy in terms]


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
