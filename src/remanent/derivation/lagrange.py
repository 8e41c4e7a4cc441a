"""Lagrange's equations with dissipation, and the first-order system that they make."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from remanent._field import Role, StateVariable
from remanent.derivation.energy_balance import stored_energy_and_powers, temperature_rate
from remanent.derivation.motion import FirstOrderForm, Motion
from remanent.derivation.symbols import (
    AREA_STRETCH,
    THICKNESS_STRETCH,
    THICKNESS_STRETCH_RATE,
    Expression,
    Symbol,
    time_derivative,
)


def build_first_order_form(motion: Motion) -> FirstOrderForm:
    """Solve Lagrange's equations for the accelerations and list all rates."""
    solution = solve_accelerations(motion)
    rates: dict[Symbol, Expression] = {}
    pairs = zip(motion.coordinates, motion.rates, solution.coordinate_accelerations, strict=True)
    for coordinate, rate, acceleration in pairs:
        rates[coordinate], rates[rate] = rate, acceleration
    rates |= motion.internal_rates
    if motion.heat_balance is not None:
        rates |= temperature_rate(motion, motion.heat_balance, rates)
    rate_sign = _same_sign_without_division(motion.eliminate_thickness(THICKNESS_STRETCH_RATE))
    return FirstOrderForm(
        state_symbols=tuple(rates),
        variables=tuple(_describe_state_variable(symbol, motion) for symbol in rates),
        load_names=(motion.load.name,),
        definitions={**motion.definitions, **solution.definitions},
        rates=tuple(rates.values()),
        observable_name="thickness_stretch",
        observable_and_rates=(
            THICKNESS_STRETCH,
            THICKNESS_STRETCH_RATE,
            solution.thickness_acceleration,
            rate_sign,
        ),
        observables={
            "thickness_stretch": THICKNESS_STRETCH,
            "thickness_stretch_rate": THICKNESS_STRETCH_RATE,
            "energy": motion.kinetic_energy + motion.potential_energy,
            motion.load.name: motion.load,
            **stored_energy_and_powers(motion, rates),
        },
        admissibility_conditions=motion.admissibility_conditions,
    )


def _describe_state_variable(symbol: Symbol, motion: Motion) -> StateVariable:
    """What a state variable is: all stretches are 1 at rest, the body as warm as its surroundings.

    Stretches and absolute temperatures are positive, which their symbols know.
    """
    positive = bool(symbol.is_positive)
    if symbol in motion.coordinates:
        return StateVariable(symbol.name, Role.COORDINATE, 1.0, None, positive)
    if symbol in motion.rates:
        coordinate = motion.coordinates[motion.rates.index(symbol)]
        return StateVariable(symbol.name, Role.RATE, 0.0, coordinate.name, positive)
    if symbol in motion.internal_rates:
        coordinate = motion.relaxes_to[symbol]
        return StateVariable(symbol.name, Role.INTERNAL, 1.0, coordinate.name, positive)
    return StateVariable(symbol.name, Role.TEMPERATURE, "temperature", None, positive)


def _same_sign_without_division(expression: Expression) -> Expression:
    """Something with the same sign and without a division, where there is one."""
    numerator, denominator = sp.fraction(sp.together(expression))
    return numerator if denominator.is_positive else expression


# Accelerations ------------------------------------------------------------------------


@dataclass(frozen=True)
class Accelerations:
    """The accelerations, in terms of intermediate symbols.

    Attributes
    ----------
    definitions
        What the intermediate symbols stand for, in order.
    coordinate_accelerations
        q_i'' of each coordinate.
    thickness_acceleration
        Acceleration of the thickness stretch.
    """

    definitions: Mapping[Symbol, Expression]
    coordinate_accelerations: tuple[Expression, ...]
    thickness_acceleration: Expression


def solve_accelerations(motion: Motion) -> Accelerations:
    """Solve Lagrange's equations for the accelerations.

    With weights w_i, the thickness stretch x(q) as a further stretch of weight c, g_i =
    dx/dq_i and x'' = sum g_i q_i'' + K, d'Alembert's principle gives, times 3,
    w_i q_i'' + c g_i (sum g_j q_j'') = A_i - g_i Y,  A_i = -3 (dU/dq_i + dD/dq_i'),
    Y = 3 dU/dx + c K,  with derivatives at fixed x.  For two coordinates, with the
    cancellations of M^-1 done: q_1'' = [w_2 (A_1 - g_1 Y) + g_2 r]/det,  q_2'' =
    [w_1 (A_2 - g_2 Y) - g_1 r]/det,  r = c (g_2 A_1 - g_1 A_2).  The thickness stretch has
    x'' = [w_2 g_1 (A_1 - g_1 F) + w_1 g_2 (A_2 - g_2 F) + w_1 w_2 K]/det,  F = 3 dU/dx:
    in sum g_i q_i'' + K, most of K would cancel.
    """
    c = motion.kinetic_weights[-1]
    # Symbols have the letters of the equations above.  SymPy sorts sums and products by names,
    # so these names also decide the order of the instructions, and with it the last digits.
    g, a = _thickness_gradient_symbols(motion), _force_symbols(motion)
    force, convective, resistance = sp.Symbol("F"), sp.Symbol("K"), sp.Symbol("Y")
    inertia, inverse_inertia = sp.Symbol("inertia"), sp.Symbol("inverse_inertia")
    definitions: dict[Symbol, Expression] = {}
    x_rate = motion.definitions[THICKNESS_STRETCH_RATE]
    for g_i, a_i, coordinate, rate in zip(g, a, motion.coordinates, motion.rates, strict=True):
        definitions[g_i] = sp.diff(x_rate, rate)
        definitions[a_i] = -3 * (
            _potential_slope(motion, coordinate) + sp.diff(motion.rayleigh_function, rate)
        )
    definitions[force] = 3 * _potential_slope(motion, THICKNESS_STRETCH)
    definitions[convective] = _convective_acceleration(motion)
    definitions[resistance] = force + c * convective
    # Each acceleration is its numerator over the determinant.
    if len(g) == 1:
        (w, _), (g_1,), (a_1,) = motion.kinetic_weights, g, a
        determinant, numerators = w + c * g_1**2, [a_1 - g_1 * resistance]
        thickness = g_1 * (a_1 - g_1 * force) + w * convective
    else:
        (w_1, w_2, _), (g_1, g_2), (a_1, a_2) = motion.kinetic_weights, g, a
        cross_force = sp.Symbol("r")
        definitions[cross_force] = c * (g_2 * a_1 - g_1 * a_2)
        determinant = w_1 * w_2 + c * (w_2 * g_1**2 + w_1 * g_2**2)
        numerators = [
            w_2 * (a_1 - g_1 * resistance) + g_2 * cross_force,
            w_1 * (a_2 - g_2 * resistance) - g_1 * cross_force,
        ]
        thickness = (
            w_2 * g_1 * (a_1 - g_1 * force)
            + w_1 * g_2 * (a_2 - g_2 * force)
            + w_1 * w_2 * convective
        )
    # The gradients are x^2 times a stretch: in units of x^4 the determinant is a polynomial.
    definitions[inertia] = _determinant_over_thickness_power_four(
        determinant.subs({k: definitions[k] for k in g})
    )
    definitions[inverse_inertia] = AREA_STRETCH**4 / inertia
    return Accelerations(
        definitions,
        tuple(inverse_inertia * numerator for numerator in numerators),
        inverse_inertia * thickness,
    )


def _thickness_gradient_symbols(motion: Motion) -> list[Symbol]:
    """g_i = dx/dq_i."""
    return [sp.Symbol(f"g_{i + 1}") for i in range(len(motion.coordinates))]


def _force_symbols(motion: Motion) -> list[Symbol]:
    """A_i, three times the generalised forces at fixed thickness stretch."""
    return [sp.Symbol(f"A_{i + 1}") for i in range(len(motion.coordinates))]


def _determinant_over_thickness_power_four(determinant: Expression) -> Expression:
    """The determinant over x^4, the area being 1/x."""
    constant = determinant.subs(THICKNESS_STRETCH, 0)
    rest = sp.factor_terms(sp.expand((determinant - constant) / THICKNESS_STRETCH**4))
    return constant * AREA_STRETCH**4 + rest


def _convective_acceleration(motion: Motion) -> Expression:
    """K, the acceleration of the thickness stretch without accelerations in the plane."""
    rates = dict(zip(motion.coordinates, motion.rates, strict=True))
    rates[THICKNESS_STRETCH] = THICKNESS_STRETCH_RATE
    return sp.factor_terms(time_derivative(motion.definitions[THICKNESS_STRETCH_RATE], rates))


def _potential_slope(motion: Motion, stretch: Symbol) -> Expression:
    """dU/d(stretch), term by term, with the thickness stretch as a stretch of its own."""
    return sum(
        term.temperature_factor * sp.diff(motion.in_principal_stretches(term.energy), stretch)
        for term in motion.energies
    )


def mass_matrix_and_force(motion: Motion) -> tuple[Any, Any]:
    """Mass matrix M and force f of Lagrange's equations M(q) q'' = f(q, q').

    Equation: d/dtau dT/dq' - dT/dq + dU/dq + dD/dq' = 0 [Thermal, eq. 8].
    """
    q, v = motion.coordinates, motion.rates
    kinetic = motion.eliminate_thickness(motion.kinetic_energy)
    potential = motion.eliminate_thickness(motion.potential_energy)
    momenta = [sp.diff(kinetic, rate) for rate in v]
    mass = sp.Matrix([[sp.diff(momentum, rate) for rate in v] for momentum in momenta])
    force = sp.Matrix(
        [
            sp.diff(kinetic - potential, q[i])
            - sp.diff(motion.rayleigh_function, v[i])
            - _convective_momentum_rate(momentum, q, v)
            for i, momentum in enumerate(momenta)
        ]
    )
    return mass, force


def _convective_momentum_rate(
    momentum: Expression, q: Sequence[Symbol], v: Sequence[Symbol]
) -> Expression:
    """The part of a momentum's time derivative that has no accelerations."""
    return sum(sp.diff(momentum, q[j]) * v[j] for j in range(len(q)))
