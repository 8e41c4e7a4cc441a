"""From energies to a first-order system: Lagrange's equations with dissipation.

Nothing here knows a particular material or load.  The energies of the parts, written
for two in-plane stretches, are assembled for one coordinate (equal stretches) or two.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from remanent.models import thermal
from remanent.models.actuator import Actuator
from remanent.models.drive import Drive

Expression = Any  # SymPy is not typed
Symbol = Any


@dataclass(frozen=True)
class Motion:
    """Energies of a mechanical system with internal variables.

    All energies are per 8 H L^2 mu.  `potential` contains `magnetic`, the energy in the
    field, and `viscous`, what dissipative elements store.  `load` and the keys of
    `definitions` are symbols that depend on parameters and on the drive, not on the state.
    """

    coordinates: tuple[Symbol, ...]
    rates: tuple[Symbol, ...]
    kinetic: Expression
    potential: Expression
    magnetic: Expression
    rayleigh: Expression
    viscous: Expression
    internal: Mapping[Symbol, Expression]
    thickness: Expression
    load: Symbol
    definitions: Mapping[Symbol, Expression]


@dataclass(frozen=True)
class System:
    """A first-order system in symbols, with what is observed of it.

    Attributes
    ----------
    state
        Symbols of the state variables.
    definitions
        Intermediate symbols and what each stands for, in terms of parameters,
        waveforms, the phase and earlier definitions.
    rates
        Rate of each state variable.
    watched
        The thickness stretch, its rate, its acceleration, and the rate's sign.
    observables
        Further quantities by name.
    """

    state: tuple[Symbol, ...]
    definitions: Mapping[Symbol, Expression]
    rates: tuple[Expression, ...]
    watched: tuple[Expression, ...]
    observables: Mapping[str, Expression]


def derive(actuator: Actuator, drive: Drive, *, coordinates: int = 1) -> System:
    """The first-order system of an actuator under a drive.

    Only the structure of both is used, never a numeric value.

    Parameters
    ----------
    coordinates
        1 for equal in-plane stretches, 2 for two of them.
    """
    return first_order(motion(actuator, drive, coordinates=coordinates))


def motion(actuator: Actuator, drive: Drive | None, *, coordinates: int = 1) -> Motion:
    """Energies of an actuator; without a drive, the load is left as a symbol.

    Equations, per 8 H L^2 mu (paper, equations 1 to 9), l3 = 1/(l1 l2):
    T = (l1'^2 + l2'^2 + c l3'^2)/6,
    U = mu(T)/mu W(l1, l2, l3) - m l3 - S1 (l1 - 1) - S2 (l2 - 1) + viscous energy.
    """
    p = {name: parameter(name) for name in parameter_names(actuator, coordinates)}
    q, v = coordinate_symbols(coordinates)
    pair, pair_rate = (q[0], q[-1]), (v[0], v[-1])
    thickness = 1 / (pair[0] * pair[1])
    definitions = _definitions(actuator, drive, p)
    theta, stiffness, load, effective = definitions
    viscous = [
        _viscous(f"dissipation.{i}", part, pair, pair_rate, theta, p, coordinates)
        for i, part in enumerate(actuator.elements())
    ]
    strain = actuator.material.energy(*pair, thickness, _own(p, "material"), sp)
    magnetic = actuator.magnet.energy(effective, thickness)
    stored = sum((e.stored for e in viscous), start=sp.Integer(0))
    dead = sum(s * (stretch - 1) for s, stretch in zip(_prestress(p), pair, strict=True))
    return Motion(
        coordinates=q,
        rates=v,
        kinetic=kinetic_energy(pair, pair_rate, p["c"]),
        potential=stiffness * strain + magnetic - dead + stored,
        magnetic=magnetic,
        rayleigh=sum((e.rayleigh for e in viscous), start=sp.Integer(0)),
        viscous=stored,
        internal={k: rate for e in viscous for k, rate in e.internal.items()},
        thickness=thickness,
        load=load,
        definitions={k: e for k, e in definitions.items() if e is not None},
    )


def kinetic_energy(stretches: Sequence[Any], rates: Sequence[Any], c: Any) -> Any:
    """T per 8 H L^2 mu = (l1'^2 + l2'^2 + c l3'^2)/6 with l3 = 1/(l1 l2)."""
    (l1, l2), (v1, v2) = stretches, rates
    v3 = -(v1 / l1 + v2 / l2) / (l1 * l2)
    return (v1**2 + v2**2 + c * v3**2) / 6


def first_order(motion: Motion) -> System:
    """Solve Lagrange's equations for the accelerations and list all rates."""
    q, v = motion.coordinates, motion.rates
    rates: dict[Symbol, Expression] = {}
    for coordinate, rate, acceleration in zip(q, v, accelerations(motion), strict=True):
        rates[coordinate], rates[rate] = rate, acceleration
    rates |= motion.internal
    x = motion.thickness
    x_rate = along(x, rates)
    return System(
        state=tuple(rates),
        definitions=motion.definitions,
        rates=tuple(rates.values()),
        watched=(x, x_rate, along(x_rate, rates), _sign_of(x_rate)),
        observables={
            "thickness_stretch": x,
            "thickness_stretch_rate": x_rate,
            "energy": motion.kinetic + motion.potential,
            "load": motion.load,
            **powers(motion, rates),
        },
    )


def powers(motion: Motion, rates: Mapping[Symbol, Expression]) -> dict[str, Expression]:
    """The energy without that in the field, and the two powers that change it.

    Equations: stored = T + U - U_m; stored' = drive power - dissipated power, where the
    drive's power is -dU_m/dq q' and the dissipated one q' dD/dq' - dU_v/dxi xi'.
    """
    moving = {q: rates[q] for q in motion.coordinates}
    dashpots = sum((v * sp.diff(motion.rayleigh, v) for v in motion.rates), start=sp.Integer(0))
    return {
        "stored_energy": motion.kinetic + motion.potential - motion.magnetic,
        "drive_power": -along(motion.magnetic, moving),
        "dissipated_power": dashpots - along(motion.viscous, motion.internal),
    }


def _sign_of(expression: Expression) -> Expression:
    """Something with the same sign and without a division, where there is one."""
    numerator, denominator = sp.fraction(sp.together(expression))
    return numerator if denominator.is_positive else expression


def accelerations(motion: Motion) -> list[Expression]:
    """q'' = adj(M) f / det(M), where M q'' = f are Lagrange's equations."""
    mass, force = lagrange(motion)
    determinant = mass.det()
    return [entry / determinant for entry in mass.adjugate() * force]


def lagrange(motion: Motion) -> tuple[Any, Any]:
    """Mass matrix M and force f of Lagrange's equations M(q) q'' = f(q, q').

    Equation: d/dtau dT/dq' - dT/dq + dU/dq + dD/dq' = 0 (paper, equation 13).
    """
    q, v = motion.coordinates, motion.rates
    momenta = [sp.diff(motion.kinetic, rate) for rate in v]
    mass = sp.Matrix([[sp.diff(momentum, rate) for rate in v] for momentum in momenta])
    force = sp.Matrix(
        [
            sp.diff(motion.kinetic - motion.potential, q[i])
            - sp.diff(motion.rayleigh, v[i])
            - sum(sp.diff(momentum, q[j]) * v[j] for j in range(len(q)))
            for i, momentum in enumerate(momenta)
        ]
    )
    return mass, force


def along(expression: Expression, rates: Mapping[Symbol, Expression]) -> Expression:
    """Time derivative of a function of the state along the motion."""
    return sum(
        (sp.diff(expression, symbol) * rate for symbol, rate in rates.items()),
        start=sp.Integer(0),
    )


# Symbols ------------------------------------------------------------------------------


def parameter(name: str) -> Symbol:
    """The symbol of a numeric field."""
    kelvin = name in ("temperature", "reference_temperature")
    return sp.Symbol(name, positive=True) if kelvin or name == "c" else sp.Symbol(name, real=True)


def waveform(name: str) -> Symbol:
    """The symbol of a waveform of the drive."""
    return sp.Symbol(name, real=True)


def parameter_names(actuator: Actuator, coordinates: int) -> Iterable[str]:
    """Names of the actuator's numeric fields; two prestresses for two coordinates."""
    for name in actuator.parameters():
        if name == "prestress" and coordinates == 2:
            yield from ("prestress_1", "prestress_2")
        else:
            yield name


def coordinate_symbols(coordinates: int) -> tuple[tuple[Symbol, ...], tuple[Symbol, ...]]:
    """Stretches and their rates: one of each, or two."""
    suffixes = [""] if coordinates == 1 else [f"_{i + 1}" for i in range(coordinates)]
    stretches = tuple(sp.Symbol(f"stretch{suffix}", positive=True) for suffix in suffixes)
    rates = tuple(sp.Symbol(f"stretch{suffix}_rate", real=True) for suffix in suffixes)
    return stretches, rates


PHASE = sp.Symbol("drive_phase", real=True)


# Parts --------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Viscous:
    rayleigh: Expression
    stored: Expression
    internal: Mapping[Symbol, Expression]


def _viscous(
    prefix: str,
    part: Any,
    pair: Sequence[Symbol],
    pair_rate: Sequence[Symbol],
    theta: Symbol,
    p: Mapping[str, Symbol],
    coordinates: int,
) -> _Viscous:
    """One dissipative element; equal stretches share one internal variable per kind."""
    suffixes = ("", "") if coordinates == 1 else ("_1", "_2")
    symbols = [
        sp.Symbol(f"{prefix}.{kind}{suffix}", positive=True)
        for kind in part.internal
        for suffix in suffixes
    ]
    own = _own(p, prefix)
    rates = part.internal_rates(pair, symbols, theta, own)
    return _Viscous(
        rayleigh=part.rayleigh(pair, pair_rate, own),
        stored=theta * part.stored(pair, symbols, own),
        internal=dict(zip(symbols, rates, strict=True)),
    )


def _definitions(
    actuator: Actuator, drive: Drive | None, p: Mapping[str, Symbol]
) -> dict[Symbol, Expression | None]:
    """Temperature ratio, stiffness, load, and load with the remanence at temperature."""
    theta = sp.Symbol("theta", positive=True)
    stiffness = sp.Symbol("stiffness", positive=True)
    load, effective = sp.symbols("load effective_load", real=True)
    temperature, reference = p["temperature"], p["reference_temperature"]
    fraction = p["material.entropic_fraction"]
    remanence = actuator.magnet.remanence(temperature, reference, _own(p, "magnet"))
    return {
        theta: temperature / reference,
        stiffness: thermal.stiffness(theta, fraction),
        load: None if drive is None else drive_load(drive),
        effective: remanence * load,
    }


def drive_load(drive: Drive) -> Expression:
    """The load law of a drive in symbols."""
    names = (*drive.parameters(), *drive.piece_parameters)
    p = {name: parameter(name) for name in names}
    u = {name: waveform(name) for name in drive.waveforms}
    return sp.sympify(drive.load(p, u, PHASE, sp))


def _own(p: Mapping[str, Symbol], prefix: str) -> dict[str, Symbol]:
    start = f"{prefix}."
    return {name.removeprefix(start): s for name, s in p.items() if name.startswith(start)}


def _prestress(p: Mapping[str, Symbol]) -> tuple[Symbol, Symbol]:
    if "prestress" in p:
        return p["prestress"], p["prestress"]
    return p["prestress_1"], p["prestress_2"]
