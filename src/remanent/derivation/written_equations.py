"""From the formulas of one's own system to a first-order system."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, Final

import sympy as sp

from remanent._errors import InputError
from remanent._field import Role, StateVariable
from remanent.derivation.expansion import may_be_expanded
from remanent.derivation.linear_solve import (
    nested_in_pair,
    solve_pair_expanded,
    solve_symmetric,
)
from remanent.derivation.motion import FirstOrderForm
from remanent.derivation.symbols import (
    Expression,
    Symbol,
    loads_in_symbols,
    substitute_definitions,
    time_derivative,
)
from remanent.models.drives.base import Drive
from remanent.models.formula import Formula, as_exact_number
from remanent.models.own_systems.first_order_system import FirstOrderSystem
from remanent.models.own_systems.lagrangian_system import LagrangianSystem
from remanent.models.own_systems.names import RATE_SUFFIX
from remanent.models.own_systems.written_system import WrittenSystem


def first_order_form_of_rates(system: FirstOrderSystem, drive: Drive) -> FirstOrderForm:
    """The system as it is written: y' = f(y, p, load)."""
    symbols = symbols_by_name(system)
    rates = {
        symbols[name]: _in_symbols(one, symbols)
        for name, one in zip(system.state_names, system.formulas().values(), strict=True)
    }
    return _assemble(system, drive, rates, roles=dict.fromkeys(system.state_names, Role.COORDINATE))


def first_order_form_of_energies(system: LagrangianSystem, drive: Drive) -> FirstOrderForm:
    """Lagrange's equations, solved for accelerations and for rates of internal variables.

    Equations: d/dtau dT/dq'_i - dT/dq_i + dV/dq_i + dD/dq'_i = 0.  With the mass matrix M =
    d2T/dq'dq' of the coordinates that have a kinetic energy, M q'' = F(q, q'); for the others,
    of first order, the damping matrix d2D/dq'dq' takes the place of the mass matrix.
    """
    parts = lagrange_equations(system)
    velocity, moving, internal = parts.velocity, parts.moving, parts.internal
    balances, constants = _linear_in(parts.internal_balances, [velocity[xi] for xi in internal])
    definitions, solved = solve_symmetric(-balances, constants, "internal")
    for xi, rate in zip(internal, solved, strict=True):
        definitions[velocity[xi]] = rate

    def rates_for(accelerations: Sequence[Expression]) -> dict[Symbol, Expression]:
        """Rates of all state variables, in the order of the state."""
        rates: dict[Symbol, Expression] = {}
        for q, acceleration in zip(moving, accelerations, strict=True):
            rates[q], rates[velocity[q]] = velocity[q], acceleration
        return rates | {xi: velocity[xi] for xi in internal}

    roles = dict.fromkeys(system.first_order_names, Role.INTERNAL)
    for q in system.second_order_names:
        roles |= {q: Role.COORDINATE, f"{q}{RATE_SUFFIX}": Role.RATE}
    energies = _energies_and_powers(system, parts)

    def form(
        solution: tuple[Mapping[Symbol, Expression], Sequence[Expression]], **options: Any
    ) -> FirstOrderForm:
        more, accelerations = solution
        return _assemble(
            system, drive, rates_for(accelerations), roles=roles,
            definitions={**definitions, **more}, energies=energies, **options,
        )  # fmt: skip

    alternative = None
    if len(moving) == 2 and may_be_expanded(*parts.mass, *parts.forces):
        varying = (*moving, *velocity.values())
        more, accelerations = solve_pair_expanded(parts.mass, parts.forces, varying)

        def nested(expression: Expression) -> Expression:
            small = may_be_expanded(expression)
            return nested_in_pair(expression, (*varying, *accelerations)) if small else expression

        alternative = form((more, accelerations), rewritten=nested)
    return form(solve_symmetric(parts.mass, parts.forces, "motion"), alternative=alternative)


#: Largest number that rates may hold.
_LARGEST_NUMBER: Final = 10**300
#: Functions that rates may hold.
_REAL_FUNCTIONS: Final = frozenset({sp.exp, sp.log, sp.sin, sp.cos, sp.atan})


@dataclass(frozen=True)
class LagrangeEquations:
    """Lagrange's equations M q'' = F of the coordinates that have a kinetic energy.

    Attributes
    ----------
    energies : mapping of name to Expression
        ``kinetic``, ``potential`` and ``dissipation``.
    velocity : mapping of Symbol to Symbol
        The rate of each coordinate.
    moving, internal : tuple of Symbol
        Coordinates of second and of first order.
    mass : Matrix
        Of the former.
    forces : tuple of Expression
        On the former.
    internal_balances : tuple of Expression
        What vanishes of the latter: -dV/dq + dT/dq - dD/dq'.
    """

    energies: Mapping[str, Expression]
    velocity: Mapping[Symbol, Symbol]
    moving: tuple[Symbol, ...]
    internal: tuple[Symbol, ...]
    mass: Any
    forces: tuple[Expression, ...]
    internal_balances: tuple[Expression, ...]


def lagrange_equations(system: LagrangianSystem) -> LagrangeEquations:
    """Lagrange's equations with Rayleigh's dissipation function, in symbols.

    Equation: d/dtau dT/dq'_i - dT/dq_i + dV/dq_i + dD/dq'_i = 0.
    """
    symbols = symbols_by_name(system)
    energies = {name: _in_symbols(one, symbols) for name, one in system.formulas().items()}
    kinetic, dissipation = energies["kinetic"], energies["dissipation"]
    lagrangian = kinetic - energies["potential"]
    velocity = {symbols[q]: symbols[f"{q}{RATE_SUFFIX}"] for q in system.coordinates}
    moving = tuple(symbols[q] for q in system.second_order_names)
    internal = tuple(symbols[q] for q in system.first_order_names)
    momenta = [sp.diff(kinetic, velocity[q]) for q in moving]
    mass = sp.Matrix(
        len(moving), len(moving), lambda i, j: sp.diff(momenta[i], velocity[moving[j]])
    )
    forces = tuple(
        sp.diff(lagrangian, q)
        - sp.diff(dissipation, velocity[q])
        - time_derivative(momentum, velocity)
        for q, momentum in zip(moving, momenta, strict=True)
    )
    balances = tuple(
        sp.diff(lagrangian, xi) - sp.diff(dissipation, velocity[xi]) for xi in internal
    )
    return LagrangeEquations(energies, velocity, moving, internal, mass, forces, balances)


def _linear_in(
    expressions: Sequence[Expression], unknowns: Sequence[Symbol]
) -> tuple[Any, list[Expression]]:
    """Coefficients of the unknowns, and what is left without them."""
    n = len(unknowns)
    matrix = sp.Matrix(n, n, lambda i, j: sp.diff(expressions[i], unknowns[j]))
    return matrix, [e.subs(dict.fromkeys(unknowns, 0)) for e in expressions]


def symbols_by_name(system: WrittenSystem) -> dict[str, Symbol]:
    """A symbol for every name in the formulas.

    Nothing is assumed of them, so that SymPy leaves roots of squares as they are written.
    """
    names = (*system.state_names, *system.parameter_values(), *system.rate_names())
    return {name: sp.Symbol(name) for name in (*names, *system.load_names)}


def _in_symbols(one: Formula, symbols: Mapping[str, Symbol]) -> Expression:
    return sp.sympify(one(symbols, sp))


def _energies_and_powers(
    system: LagrangianSystem, parts: LagrangeEquations
) -> dict[str, Expression]:
    """The energy, that without the loads, and the powers that change it.

    Equations: energy = T2 - T0 + V with Tk the part of T of degree k in the rates; stored =
    T2 - T0 + V0 with V0 the potential energy without loads; stored' = drive power - dissipated
    power, -d(V - V0)/dq q' and dD/dq' q'.
    """
    potential, velocity = parts.energies["potential"], parts.velocity
    at_rest = parts.energies["kinetic"].subs(dict.fromkeys(velocity.values(), 0))
    v = sp.Matrix([velocity[q] for q in parts.moving])
    quadratic = (v.T * parts.mass * v)[0] if len(v) else sp.Integer(0)
    of_motion = quadratic / 2 - at_rest
    unloaded = potential.subs({sp.Symbol(name): 0 for name in system.load_names})
    if unloaded.has(sp.zoo, sp.nan, sp.oo):
        raise InputError(
            "potential",
            must="have a value without loads",
            got=repr(system.potential),
            why="The work of the loads is counted from there.",
            fix="Write it so that it is finite where every load is 0.",
        )
    return {
        "energy": of_motion + potential,
        "stored_energy": of_motion + unloaded,
        "drive_power": -time_derivative(potential - unloaded, velocity),
        "dissipated_power": sum(
            (rate * sp.diff(parts.energies["dissipation"], rate) for rate in velocity.values()),
            start=sp.Integer(0),
        ),
    }


def _assemble(
    system: WrittenSystem,
    drive: Drive,
    rates: Mapping[Symbol, Expression],
    *,
    roles: Mapping[str, Role],
    definitions: Mapping[Symbol, Expression] | None = None,
    energies: Mapping[str, Expression] | None = None,
    alternative: FirstOrderForm | None = None,
    rewritten: Callable[[Expression], Expression] = sp.sympify,
) -> FirstOrderForm:
    """Everything put together, with the observable and its rates in the form `rewritten`."""
    symbols = symbols_by_name(system)
    inner = dict(definitions or {})
    loads = [symbols[name] for name in system.load_names]
    observable = _in_symbols(system.observable_formula, symbols)
    rate = time_derivative(observable, rates)
    whole_rate = substitute_definitions(rate, inner) if _needs_all(rate, inner) else rate
    acceleration = time_derivative(whole_rate, rates)
    load_rates = {
        symbols[load.name]: law
        for load, law in loads_in_symbols(drive.load_rates_by_name, drive).items()
        if whole_rate.has(symbols[load.name])
    }
    acceleration += time_derivative(whole_rate, load_rates)
    named = {system.observable_name: observable, f"{system.observable_name}_rate": rate}
    bare = _bare_conditions(system)
    by_load = loads_in_symbols(drive.loads_by_name, drive)
    laws = {symbols[load.name]: law for load, law in by_load.items()}
    written = [*rates.values(), *inner.values(), observable, rate, acceleration]
    conditions = tuple(
        _in_symbols(part, symbols) * _in_symbols(part, _rest_symbols(system, symbols))
        for part in system.sign_conditions()
        if part.text not in bare
    )
    _require_real(system, [*written, *(energies or {}).values(), *conditions])
    return FirstOrderForm(
        state_symbols=tuple(rates),
        variables=tuple(
            _describe(symbol.name, roles[symbol.name], system, bare) for symbol in rates
        ),
        load_names=system.load_names,
        definitions={**laws, **inner},
        rates=tuple(rates.values()),
        observable_name=system.observable_name,
        observable_and_rates=tuple(map(rewritten, (observable, rate, acceleration, rate))),
        observables={
            **named,
            **{load.name: load for load in loads},
            **(energies or {}),
        },
        admissibility_conditions=conditions,
        parameter_symbols={name: symbols[name] for name in system.parameter_values()},
        alternative=alternative,
    )


def _require_real(system: WrittenSystem, expressions: Sequence[Expression]) -> None:
    """Raise where rates have no value in real numbers, whatever the state."""
    for expression in map(sp.sympify, expressions):
        functions = {f.func for f in expression.atoms(sp.Function)}
        large = any(abs(n) > _LARGEST_NUMBER for n in expression.atoms(sp.Rational))
        complex_powers = any(
            # Those of whole exponents are numbers by now.
            power.base.is_number and power.base.is_negative
            for power in expression.atoms(sp.Pow)
        )
        infinite = expression.has(sp.I, sp.zoo, sp.nan, sp.oo)
        if functions - _REAL_FUNCTIONS or infinite or large or complex_powers:
            raise InputError(
                next(iter(system.formulas())),
                must="have derivatives in real numbers that a float can hold",
                got=repr(system)[:80],
                why="The equations of motion hold the derivatives of the formulas.",
                fix="Look for powers of large numbers, and for powers, roots and logarithms of "
                "negative numbers.",
            )


def _bare_conditions(system: WrittenSystem) -> frozenset[str]:
    """State variables that are positive by themselves: formulas divide by them alone."""
    rest = system.rest_values()
    texts = {part.text for part in system.sign_conditions()}
    return frozenset(name for name, value in rest.items() if name in texts and value > 0.0)


def _rest_symbols(system: WrittenSystem, symbols: Mapping[str, Symbol]) -> dict[str, Expression]:
    """Symbols of parameters, the states at rest and the loads 0."""
    rest = {
        name: as_exact_number(Fraction(value), sp) for name, value in system.rest_values().items()
    }
    return {**symbols, **rest, **dict.fromkeys(system.load_names, sp.Integer(0))}


def _describe(
    name: str, role: Role, system: WrittenSystem, positive: frozenset[str]
) -> StateVariable:
    coordinate = name.removesuffix(RATE_SUFFIX) if role is Role.RATE else None
    return StateVariable(
        name, role, system.rest_values()[name], coordinate, positive=name in positive
    )


def _needs_all(expression: Expression, definitions: Mapping[Symbol, Expression]) -> bool:
    """Whether intermediate symbols stand in an expression that is to be differentiated."""
    return bool(expression.free_symbols & definitions.keys())
