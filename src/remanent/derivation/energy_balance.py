"""What is conserved: the balances of energy and entropy, and the body's temperature.

Everything follows from the free energy per reference volume over mu,
Psi = mu(T)/mu W + theta Psi_v + caloric energy + energy in the field, theta = T/T0, and
theta s' = D - h (theta - theta_env),  s = -dPsi/dtheta  (in units of mu/T0).
Psi is a sum of products f(theta) e(state), whose entropy is -f' e and whose internal energy
(f - theta f') e.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import sympy as sp

from remanent.derivation.motion import Energies, EnergyTerm, HeatBalance, Motion
from remanent.derivation.symbols import (
    BODY_TEMPERATURE,
    TEMPERATURE_RATIO,
    THICKNESS_STRETCH,
    THICKNESS_STRETCH_RATE,
    Expression,
    Symbol,
    time_derivative,
)
from remanent.models import heat


def assemble_heat_balance(
    energies: Energies,
    of_theta: Mapping[Symbol, Expression],
    *,
    p: Mapping[str, Symbol],
    coupling: Expression,
    in_field: EnergyTerm,
    load_rate: Expression | None,
) -> HeatBalance:
    """The heat balance of a body with these energies.

    Dead loads hold no entropy, so that their energy is no part of the free energy here.

    Parameters
    ----------
    energies
        The parts of the potential energy.
    of_theta
        What symbols in their factors stand for, in terms of theta.
    p
        Numeric fields of the actuator, with ``heat.exchange``, the rate at which the
        temperature would decay, so that h is that over the coupling.
    coupling
        k = mu/(rho c_p T0), with mu in the units and the body's own density.
    in_field
        The energy in the applied field, its factor in terms of theta.
    load_rate
        Rate of the load; None where it is not known in closed form.
    """
    exchange = p["heat.exchange"]
    mechanical = (energies.strain, energies.self_field, *energies.viscous)
    caloric = EnergyTerm(heat.caloric_free_energy(TEMPERATURE_RATIO, coupling, sp), sp.Integer(1))
    return HeatBalance(
        temperature=BODY_TEMPERATURE,
        reference_temperature=p["reference_temperature"],
        free_energy_terms=(
            *(EnergyTerm(t.temperature_factor.subs(of_theta), t.energy) for t in mechanical),
            caloric,
        ),
        free_energy_in_field=in_field,
        surroundings_theta=p["temperature"] / p["reference_temperature"],
        conductance=exchange / coupling,
        load_rate=load_rate,
    )


# Dissipation and heat -----------------------------------------------------------------


def dissipated_power(motion: Motion) -> Expression:
    """The power that becomes heat: sum of q' dD/dq' - dU_v/dxi xi'."""
    stored = motion.in_principal_stretches(motion.viscous_energy)
    return dashpot_power(motion) - time_derivative(stored, motion.internal_rates)


def dashpot_power(motion: Motion) -> Expression:
    """The part of it from dashpots that lie in parallel: sum of q' dD/dq'."""
    return sum(
        (v * sp.diff(motion.rayleigh_function, v) for v in motion.rates), start=sp.Integer(0)
    )


def temperature_rate(
    motion: Motion, balance: HeatBalance, rates: Mapping[Symbol, Expression]
) -> dict[Symbol, Expression]:
    """T' from theta s' = D - h (theta - theta_env).

    D is the power of dashpots in parallel, and -f de/dxi xi' of each term with internal
    variables; theta s' holds -theta f' de/dxi xi' of the same.  Their difference is taken
    here: where f is theta, as of entropic springs, nothing remains.

    Parameters
    ----------
    balance
        The heat balance of `motion`.
    rates
        Rates of coordinates, their rates, and internal variables.
    """
    theta = motion.theta
    outer_rates = _rates_without_temperature(rates, motion, balance)
    internal_rates = {xi: outer_rates.pop(xi) for xi in motion.internal_rates}
    entropy = _entropy(balance, theta, motion.in_principal_stretches)
    capacity = sum(
        -theta * sp.diff(t.temperature_factor, theta, 2) * t.energy
        for t in balance.all_free_energy_terms
    )
    relaxation_power = -sum(
        t.temperature_factor
        * time_derivative(motion.in_principal_stretches(t.energy), internal_rates)
        for t in _internal_energy_terms(balance.all_free_energy_terms, theta)
    )
    power = (
        dashpot_power(motion)
        + relaxation_power
        - _heat_flow(motion, balance)
        - theta * time_derivative(entropy, outer_rates)
    )
    return {balance.temperature: balance.reference_temperature * power / capacity}


def _rates_without_temperature(
    rates: Mapping[Symbol, Expression], motion: Motion, balance: HeatBalance
) -> dict[Symbol, Expression]:
    """Rates of everything on which the free energy depends beside the temperature."""
    remaining = {k: v for k, v in rates.items() if k != balance.temperature}
    remaining[THICKNESS_STRETCH] = THICKNESS_STRETCH_RATE
    if balance.load_rate is not None:
        remaining[motion.load] = balance.load_rate
    return remaining


def _entropy(
    balance: HeatBalance,
    theta: Symbol,
    rewrite: Callable[[Expression], Expression] = sp.sympify,
) -> Expression:
    """s = -dPsi/dtheta, the energies rewritten by a function."""
    return sum(
        -sp.diff(t.temperature_factor, theta) * rewrite(t.energy)
        for t in balance.all_free_energy_terms
    )


def _heat_flow(motion: Motion, balance: HeatBalance) -> Expression:
    """Power given to the surroundings, h (theta - theta_env)."""
    return balance.conductance * (motion.theta - balance.surroundings_theta)


# Balances -----------------------------------------------------------------------------


def stored_energy_and_powers(
    motion: Motion, rates: Mapping[Symbol, Expression]
) -> dict[str, Expression]:
    """The energy without that in the field, and the powers that change it.

    Equations, where temperature is held: stored = T + U - U_m; stored' = drive power -
    dissipated power, where the drive's power is -dU_m/dq q' and the dissipated one q'
    dD/dq' - dU_v/dxi xi'.  Where it is a state, see :func:`_internal_energy_and_flows`.

    Parameters
    ----------
    rates
        Rate of each state variable.
    """
    if motion.heat_balance is not None:
        return _internal_energy_and_flows(motion, motion.heat_balance, rates)
    in_field = motion.energies.applied_field.energy
    return {
        "stored_energy": motion.kinetic_energy + motion.potential_energy - in_field,
        "drive_power": -time_derivative(in_field, {THICKNESS_STRETCH: THICKNESS_STRETCH_RATE}),
        "dissipated_power": dissipated_power(motion),
    }


def _internal_energy_and_flows(
    motion: Motion, balance: HeatBalance, rates: Mapping[Symbol, Expression]
) -> dict[str, Expression]:
    """Internal energy without that in the field, and what changes it and the entropy.

    Equations: stored' = drive power - heat flow; with e = Psi + theta s the energy in
    the field is e_m = Psi_m + theta s_m, and the drive's power dPsi_m/dm m' - e_m', in which
    dPsi_m/dm m' cancels.
    entropy' = entropy production - entropy flow, the flow being what the surroundings
    gain, and the production D/theta + h (theta - theta_env)^2/(theta theta_env).
    """
    theta, surroundings = motion.theta, balance.surroundings_theta
    dissipated, heat_flow = dissipated_power(motion), _heat_flow(motion, balance)
    in_field, load = balance.free_energy_in_field, motion.load
    all_rates = _rates_without_temperature(rates, motion, balance)
    all_rates[theta] = rates[balance.temperature] / balance.reference_temperature
    # The load is held here, since its part cancels.
    load_rate = all_rates.pop(load, sp.Integer(0))
    dead_loads = motion.energies.dead_loads.energy
    return {
        "stored_energy": motion.kinetic_energy
        + dead_loads
        + _internal_energy(balance.free_energy_terms, theta),
        "drive_power": theta
        * sp.diff(in_field.temperature_factor, theta)
        * sp.diff(in_field.energy, load)
        * load_rate
        - time_derivative(_internal_energy([in_field], theta), all_rates),
        "dissipated_power": dissipated,
        "heat_flow": heat_flow,
        "entropy": _entropy(balance, theta),
        "entropy_flow": heat_flow / surroundings,
        "entropy_production": dissipated / theta
        + balance.conductance * (theta - surroundings) ** 2 / (theta * surroundings),
    }


def _internal_energy(terms: Sequence[EnergyTerm], theta: Symbol) -> Expression:
    """e = Psi - theta dPsi/dtheta, with the logarithms cancelled."""
    return sum(term.product for term in _internal_energy_terms(terms, theta))


def _internal_energy_terms(terms: Sequence[EnergyTerm], theta: Symbol) -> list[EnergyTerm]:
    return [
        EnergyTerm(
            sp.expand(t.temperature_factor - theta * sp.diff(t.temperature_factor, theta)), t.energy
        )
        for t in terms
    ]
