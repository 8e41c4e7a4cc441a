"""The energies of an actuator's parts, put together as the energies of its motion.

Nothing here knows a particular material or load.  The energies of the parts, written
for two in-plane stretches, are assembled for one coordinate (equal stretches) or two.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from remanent.derivation.energy_balance import assemble_heat_balance
from remanent.derivation.motion import Energies, EnergyTerm, HeatBalance, Motion
from remanent.derivation.symbols import (
    AREA_STRETCH,
    BODY_TEMPERATURE,
    LOAD,
    LOAD_AT_TEMPERATURE,
    STIFFNESS_RATIO,
    TEMPERATURE_RATIO,
    THICKNESS_STRETCH,
    THICKNESS_STRETCH_RATE,
    Expression,
    Symbol,
    coordinate_symbols,
    loads_in_symbols,
    parameter_symbol,
)
from remanent.derivation.unexpanded import Unexpanded
from remanent.models import heat
from remanent.models.actuator import Actuator
from remanent.models.dissipation import Dissipation
from remanent.models.drives.base import Drive
from remanent.models.parts import part_parameters


def build_motion(actuator: Actuator, drive: Drive | None) -> Motion:
    """Energies of an actuator; without a drive, the load is left as a symbol.

    Equations, per 8 H L1 L2 mu [Thermal, eqs. 3 to 12], l3 = 1/(l1 l2):
    T = (w1 l1'^2 + w2 l2'^2 + c l3'^2)/6,  w_i = (L_i/L)^2, here 1 where edges are equal,
    U = mu(T)/mu W(l1, l2, l3) - m l3 - S1 (l1 - 1) - S2 (l2 - 1) + viscous energy
    + the magnet's energy in its own field.  Where physical sizes differ from those that the
    actuator was built with, mu of W, rho of T and B_r of the magnet's energies are theirs, over
    those in the units.
    """
    p = {name: parameter_symbol(name) for name in actuator.parameter_values()}
    q, v = coordinate_symbols(actuator.coordinate_count)
    # Of one coordinate both stretches are the same symbol, so that energies are written once.
    pair, pair_rates = (q[0], q[-1]), (v[0], v[-1])
    elements = [
        _build_dissipative_element(
            f"dissipation.{i}", part, (*pair, THICKNESS_STRETCH), pair_rates, actuator, p
        )
        for i, part in enumerate(actuator.dissipative_elements())
    ]
    energies = _build_potential_energies(actuator, pair, elements, p)
    geometry = {
        AREA_STRETCH: pair[0] * pair[1],
        THICKNESS_STRETCH: 1 / AREA_STRETCH,
        THICKNESS_STRETCH_RATE: -(THICKNESS_STRETCH**2)
        * (pair_rates[0] * pair[1] + pair_rates[1] * pair[0]),
    }
    admissibility_conditions = actuator.material.admissibility_conditions(
        *pair, THICKNESS_STRETCH, part_parameters("material", p), sp
    )
    return Motion(
        coordinates=q,
        rates=v,
        kinetic_weights=tuple(
            _size(p, "density") * weight for weight in (*_kinetic_weights(actuator, p), p["c"])
        ),
        energies=energies,
        rayleigh_function=sum((e.rayleigh_function for e in elements), start=sp.Integer(0)),
        internal_rates={xi: rate for e in elements for xi, rate in e.internal_rates.items()},
        relaxes_to={xi: stretch for e in elements for xi, stretch in e.relaxes_to.items()},
        load=LOAD,
        theta=TEMPERATURE_RATIO,
        definitions=_temperature_and_load_definitions(actuator, drive, p) | geometry,
        admissibility_conditions=tuple(admissibility_conditions),
        heat_balance=_build_heat_balance(actuator, drive, p, energies),
    )


def _build_potential_energies(
    actuator: Actuator,
    pair: tuple[Symbol, Symbol],
    elements: Sequence[_DissipativeElement],
    p: Mapping[str, Symbol],
) -> Energies:
    """The parts of the potential energy."""
    stretches = (*pair, THICKNESS_STRETCH)
    strain = actuator.material.energy(*stretches, part_parameters("material", p), sp)
    edges = (*_edge_ratios(actuator, p), sp.sqrt(p["c"]))
    self_field = actuator.magnet.energy_in_own_field(
        stretches, edges, part_parameters("magnet", p), sp
    )
    work = sum(
        s * (stretch - 1)
        for s, stretch in zip(_parameter_symbol_pair(p, "prestress"), pair, strict=True)
    )
    return Energies(
        strain=EnergyTerm(
            STIFFNESS_RATIO, strain if actuator.material.expand_energy else Unexpanded(strain)
        ),
        applied_field=EnergyTerm(
            1, actuator.magnet.energy_in_applied_field(LOAD_AT_TEMPERATURE, THICKNESS_STRETCH)
        ),
        dead_loads=EnergyTerm(1, -work),
        self_field=EnergyTerm(
            Unexpanded(_remanence_ratio(actuator, p) ** 2), Unexpanded(self_field)
        ),
        viscous=tuple(EnergyTerm(TEMPERATURE_RATIO, e.stored_energy) for e in elements),
    )


@dataclass(frozen=True)
class _DissipativeElement:
    """Rayleigh's function, stored energy and rates of internal variables of an element."""

    rayleigh_function: Expression
    stored_energy: Expression
    internal_rates: Mapping[Symbol, Expression]
    relaxes_to: Mapping[Symbol, Symbol]


def _build_dissipative_element(
    prefix: str,
    part: Dissipation,
    stretches: Sequence[Symbol],
    rates: Sequence[Symbol],
    actuator: Actuator,
    p: Mapping[str, Symbol],
) -> _DissipativeElement:
    """One dissipative element; equal stretches share one internal variable per kind."""
    suffixes = ("", "") if actuator.coordinate_count == 1 else ("_1", "_2")
    symbols, directions = [], []
    for kind in part.internal_variable_kinds:
        for suffix, stretch in zip(suffixes, stretches[:2], strict=True):
            symbols.append(sp.Symbol(f"{prefix}.{kind}{suffix}", positive=True))
            directions.append(stretch)
    temperature, reference = body_temperature_symbol(actuator), p["reference_temperature"]
    numbers = part.parameters_at_temperature(temperature, reference, part_parameters(prefix, p), sp)
    internal_rates = part.internal_rates(stretches, symbols, TEMPERATURE_RATIO, numbers)
    return _DissipativeElement(
        rayleigh_function=sp.sympify(part.rayleigh_function(stretches, rates, numbers)),
        stored_energy=sp.sympify(part.stored_energy(stretches, symbols, numbers)),
        internal_rates=dict(zip(symbols, internal_rates, strict=True)),
        relaxes_to=dict(zip(symbols, directions, strict=True)),
    )


def _temperature_and_load_definitions(
    actuator: Actuator, drive: Drive | None, p: Mapping[str, Symbol]
) -> dict[Symbol, Expression]:
    """Temperature ratio, stiffness, load, and load with the remanence at temperature."""
    definitions = {
        TEMPERATURE_RATIO: body_temperature_symbol(actuator) / p["reference_temperature"],
        STIFFNESS_RATIO: _stiffness_ratio(p),
    }
    if drive is not None:
        definitions[LOAD] = loads_in_symbols(drive.loads_by_name, drive)[LOAD]
    definitions[LOAD_AT_TEMPERATURE] = _remanence_ratio(actuator, p) * LOAD
    return definitions


def _build_heat_balance(
    actuator: Actuator, drive: Drive | None, p: Mapping[str, Symbol], energies: Energies
) -> HeatBalance | None:
    """The heat balance: factors of the energies in terms of theta, and the load itself."""
    if actuator.heat is None:
        return None
    of_theta = {
        STIFFNESS_RATIO: _stiffness_ratio(p),
        body_temperature_symbol(actuator): TEMPERATURE_RATIO * p["reference_temperature"],
    }
    return assemble_heat_balance(
        energies,
        of_theta,
        p=p,
        coupling=p["heat.coupling"] / _size(p, "density"),
        in_field=EnergyTerm(
            _remanence_ratio(actuator, p).subs(of_theta),
            energies.applied_field.energy.subs(LOAD_AT_TEMPERATURE, LOAD),
        ),
        load_rate=None
        if drive is None
        else loads_in_symbols(drive.load_rates_by_name, drive)[LOAD],
    )


def _size(p: Mapping[str, Symbol], name: str) -> Expression:
    """A physical size over the one in the units; 1 where it does not differ."""
    return p.get(name, sp.Integer(1))


def _stiffness_ratio(p: Mapping[str, Symbol]) -> Expression:
    """mu(T) over the modulus in the units."""
    fraction = p["material.entropic_fraction"]
    ratio = heat.entropic_stiffness_ratio(TEMPERATURE_RATIO, fraction)
    return _size(p, "shear_modulus") * ratio


def _remanence_ratio(actuator: Actuator, p: Mapping[str, Symbol]) -> Expression:
    """B_r(T) over the remanence in the units."""
    temperature, reference = body_temperature_symbol(actuator), p["reference_temperature"]
    ratio = actuator.magnet.remanence_ratio(temperature, reference, part_parameters("magnet", p))
    return _size(p, "remanence") * ratio


def body_temperature_symbol(actuator: Actuator) -> Symbol:
    """The symbol of T: a state where there is a heat balance, else a numeric field."""
    return parameter_symbol("temperature") if actuator.heat is None else BODY_TEMPERATURE


def _parameter_symbol_pair(p: Mapping[str, Symbol], name: str) -> tuple[Symbol, Symbol]:
    return (p[name], p[name]) if name in p else (p[f"{name}_1"], p[f"{name}_2"])


def _edge_ratios(actuator: Actuator, p: Mapping[str, Symbol]) -> tuple[Expression, Expression]:
    """L1/L and L2/L."""
    return (
        (sp.Integer(1), sp.Integer(1))
        if actuator.edges is None
        else _parameter_symbol_pair(p, "edges")
    )


def _kinetic_weights(actuator: Actuator, p: Mapping[str, Symbol]) -> tuple[Expression, ...]:
    """Of the coordinates in the kinetic energy: (L_i/L)^2, 1 where edges are equal."""
    edge_1, edge_2 = _edge_ratios(actuator, p)
    if actuator.coordinate_count == 2:
        return edge_1**2, edge_2**2
    return (edge_1**2 + edge_2**2,)
