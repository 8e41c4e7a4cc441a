"""What the steps of the derivation hand on: energies, their motion, and its first-order form.

Nothing here computes more than a sum; the steps are functions in files of their own.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import sympy as sp

from remanent._field import StateVariable
from remanent.derivation.symbols import (
    AREA_STRETCH,
    THICKNESS_STRETCH,
    THICKNESS_STRETCH_RATE,
    Expression,
    Symbol,
)
from remanent.derivation.unexpanded import Unexpanded


@dataclass(frozen=True)
class EnergyTerm:
    """A product f e of a factor f, which depends on temperature alone, and an energy e.

    Attributes
    ----------
    temperature_factor
        f(theta); 1 where the energy does not depend on temperature.
    energy
        e(state), per reference volume over mu.
    """

    temperature_factor: Expression
    energy: Expression

    @property
    def product(self) -> Expression:
        """f e."""
        return self.temperature_factor * self.energy


@dataclass(frozen=True)
class Energies:
    """The parts of the potential energy, each by its name; iteration goes through all terms.

    Attributes
    ----------
    strain
        Strain energy of the elastomer, times mu(T)/mu(T0).
    applied_field
        Energy of the magnet in the applied field, with the load at temperature.
    dead_loads
        Minus the work of the dead loads.
    self_field
        Energy of the magnet in its own field, times (B_r(T)/B_r(T0))^2.
    viscous
        What each dissipative element stores, times theta: its springs are entropic.
    """

    strain: EnergyTerm
    applied_field: EnergyTerm
    dead_loads: EnergyTerm
    self_field: EnergyTerm
    viscous: tuple[EnergyTerm, ...]

    def __iter__(self) -> Iterator[EnergyTerm]:
        yield from (
            self.strain,
            self.applied_field,
            self.dead_loads,
            self.self_field,
            *self.viscous,
        )


@dataclass(frozen=True)
class HeatBalance:
    """What the heat balance of a body is made of.

    Attributes
    ----------
    temperature
        Symbol of T, a state.
    reference_temperature
        Symbol of T0.
    free_energy_terms
        Terms of the free energy without the part that the applied field makes.
    free_energy_in_field
        That part, which is proportional to the load.
    surroundings_theta
        Temperature of the surroundings over T0.
    conductance
        h, exchanged power per unit of theta.
    load_rate
        Rate of the load; None where it is not known in closed form.
    """

    temperature: Symbol
    reference_temperature: Symbol
    free_energy_terms: tuple[EnergyTerm, ...]
    free_energy_in_field: EnergyTerm
    surroundings_theta: Expression
    conductance: Expression
    load_rate: Expression | None

    @property
    def all_free_energy_terms(self) -> tuple[EnergyTerm, ...]:
        """All terms of the free energy."""
        return (*self.free_energy_terms, self.free_energy_in_field)


@dataclass(frozen=True)
class Motion:
    """Energies of a mechanical system with internal variables.

    All energies are per 8 H L^2 mu.  They are written with the thickness stretch as a
    symbol of its own, which `definitions` explains; :meth:`eliminate_thickness` puts in
    what it is.

    Attributes
    ----------
    coordinates, rates
        In-plane stretches and their rates.
    kinetic_weights
        Of each coordinate in the kinetic energy, and c, that of the thickness stretch:
        T = (sum of weight rate^2)/6.
    energies
        The parts of the potential energy.
    rayleigh_function
        Rayleigh's dissipation function.
    internal_rates
        Rate of each internal variable.
    relaxes_to
        The coordinate to which each internal variable relaxes.
    load, theta
        Symbols of the magnetic load and of T/T0.
    definitions
        What symbols stand for that are neither parameters nor states, in order.
    admissibility_conditions
        What is positive in the states that the material can reach.
    heat_balance
        The heat balance; None where temperature is held.
    """

    coordinates: tuple[Symbol, ...]
    rates: tuple[Symbol, ...]
    kinetic_weights: tuple[Expression, ...]
    energies: Energies
    rayleigh_function: Expression
    internal_rates: Mapping[Symbol, Expression]
    relaxes_to: Mapping[Symbol, Symbol]
    load: Symbol
    theta: Symbol
    definitions: Mapping[Symbol, Expression]
    admissibility_conditions: tuple[Expression, ...] = ()
    heat_balance: HeatBalance | None = None

    @property
    def kinetic_energy(self) -> Expression:
        """Kinetic energy: T = (w1 l1'^2 + w2 l2'^2 + c l3'^2)/6."""
        rates = (*self.rates, THICKNESS_STRETCH_RATE)
        return sum((w * v**2 for w, v in zip(self.kinetic_weights, rates, strict=True))) / 6

    @property
    def potential_energy(self) -> Expression:
        """Potential energy."""
        return sum(term.product for term in self.energies)

    @property
    def viscous_energy(self) -> Expression:
        """What dissipative elements store: theta is the factor of each of them."""
        stored = (term.energy for term in self.energies.viscous)
        return self.theta * sum(stored, start=sp.Integer(0))

    def eliminate_thickness(self, expression: Expression) -> Expression:
        """The expression in coordinates and rates, without the thickness stretch."""
        for symbol in (THICKNESS_STRETCH_RATE, THICKNESS_STRETCH, AREA_STRETCH):
            expression = sp.sympify(expression).subs(symbol, self.definitions[symbol])
        return expression

    def in_principal_stretches(self, energy: Expression) -> Expression:
        """The same energy with no negative powers of in-plane stretches, by l1 l2 l3 = 1.

        Energies are written so that they keep their digits near rest; their derivatives
        are short and keep theirs everywhere in this form: l1^2 + l2^2 + l3^2 - 3.  What is
        marked as unexpanded stays as it is written.
        """
        if isinstance(energy, Unexpanded):
            return energy
        if energy.has(sp.Function):
            return energy.func(*map(self.in_principal_stretches, energy.args))
        q = self.coordinates
        factor, rest = energy.as_independent(*q, THICKNESS_STRETCH, as_Add=False)
        terms = sp.Add.make_args(sp.expand(self.eliminate_thickness(rest)))
        return factor * sum(_with_thickness_powers(term, q) for term in terms)


def _with_thickness_powers(term: Expression, q: Sequence[Symbol]) -> Expression:
    """A product of powers, in which negative powers of coordinates became powers of l3.

    The term is multiplied by (l1 l2)^k l3^k, which is 1, with the least k that leaves no
    negative power of a coordinate.
    """
    powers = term.as_powers_dict()
    powers_in_area = 2 // len(q)  # the area is stretch^2, or stretch_1 stretch_2
    below = {sp.sympify(-powers.get(symbol, 0)) / powers_in_area for symbol in q}
    if all(power.is_number for power in below):
        k = max(0, *map(sp.ceiling, below))
    else:  # powers in symbols, which stand for positive numbers here
        k = 0 if len(below) > 1 or min(below).could_extract_minus_sign() else min(below)
    return term * sp.Mul(*(symbol ** (powers_in_area * k) for symbol in q)) * THICKNESS_STRETCH**k


@dataclass(frozen=True)
class FirstOrderForm:
    """A first-order system in symbols, y' = f(phase, y, p, u), with what is observed of it.

    Attributes
    ----------
    state_symbols
        Symbols of the state variables.
    variables
        Their names, roles and values at rest.
    load_names
        Names of the loads, each of which is an observable too.
    definitions
        Intermediate symbols and what each stands for, in terms of states, parameters,
        waveforms, the phase and earlier definitions.
    rates
        Rate of each state variable.
    observable_name
        Name of the quantity whose extremes are followed, among the observables.
    observable_and_rates
        That quantity (the thickness stretch), its rate, its acceleration, and something with
        the sign of the rate.
    observables
        Further quantities by name.
    admissibility_conditions
        What is positive in the states that the material can reach.
    parameter_symbols
        Symbols of numeric fields of the system, where they are not those of an actuator's.
    alternative
        The same system with other intermediate symbols, which may be cheaper to compute.
    """

    state_symbols: tuple[Symbol, ...]
    variables: tuple[StateVariable, ...]
    load_names: tuple[str, ...]
    definitions: Mapping[Symbol, Expression]
    rates: tuple[Expression, ...]
    observable_name: str
    observable_and_rates: tuple[Expression, ...]
    observables: Mapping[str, Expression]
    admissibility_conditions: tuple[Expression, ...] = ()
    parameter_symbols: Mapping[str, Symbol] = field(default_factory=dict)
    alternative: FirstOrderForm | None = None
