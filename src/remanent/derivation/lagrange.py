"""From energies to a first-order system: Lagrange's equations with dissipation.

Nothing here knows a particular material or load.  The energies of the parts, written
for two in-plane stretches, are assembled for one coordinate (equal stretches) or two.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sympy as sp

from remanent.derivation.energy_balance import Warming, along, balances, warming
from remanent.derivation.unexpanded import Kept
from remanent.models import heat
from remanent.models.actuator import Actuator
from remanent.models.dissipation import Dissipation, own
from remanent.models.drives.base import Drive

Expression = Any  # SymPy is not typed
Symbol = Any


@dataclass(frozen=True)
class Motion:
    """Energies of a mechanical system with internal variables.

    All energies are per 8 H L^2 mu.  They are written with the thickness stretch as a
    symbol of its own, which `definitions` explains; :meth:`explicit` puts in what it is.

    Attributes
    ----------
    coordinates, rates
        In-plane stretches and their rates.
    weights
        Of each coordinate in the kinetic energy, and c, that of the thickness stretch:
        T = (sum of weight rate^2)/6.
    terms
        Factors with the energies they multiply; their sum is the potential energy.
    magnetic
        Of these, the energy in the field.
    viscous
        Of these, what dissipative elements store.
    rayleigh
        Rayleigh's dissipation function.
    internal
        Rate of each internal variable.
    thickness, thickness_rate
        Symbols of the thickness stretch and its rate.
    load, theta
        Symbols of the magnetic load and of T/T0.
    definitions
        What symbols stand for that are neither parameters nor states, in order.
    room
        What is positive in the states that the material can reach.
    heat
        The heat balance; None where temperature is held.
    """

    coordinates: tuple[Symbol, ...]
    rates: tuple[Symbol, ...]
    weights: tuple[Expression, ...]
    terms: tuple[tuple[Expression, Expression], ...]
    magnetic: Expression
    viscous: Expression
    rayleigh: Expression
    internal: Mapping[Symbol, Expression]
    thickness: Symbol
    thickness_rate: Symbol
    load: Symbol
    theta: Symbol
    definitions: Mapping[Symbol, Expression]
    room: tuple[Expression, ...] = ()
    heat: Warming | None = None

    @property
    def kinetic(self) -> Expression:
        """Kinetic energy: T = (w1 l1'^2 + w2 l2'^2 + c l3'^2)/6."""
        rates = (*self.rates, self.thickness_rate)
        return sum((w * v**2 for w, v in zip(self.weights, rates, strict=True))) / 6

    @property
    def potential(self) -> Expression:
        """Potential energy."""
        return sum(factor * energy for factor, energy in self.terms)

    def explicit(self, expression: Expression) -> Expression:
        """The expression in coordinates and rates, without the thickness stretch."""
        for symbol in (self.thickness_rate, self.thickness, AREA):
            expression = sp.sympify(expression).subs(symbol, self.definitions[symbol])
        return expression

    def natural(self, energy: Expression) -> Expression:
        """The same energy with no negative powers of in-plane stretches, by l1 l2 x = 1.

        Energies are written so that they keep their digits near rest; their derivatives
        are short and keep theirs everywhere in this form: l1^2 + l2^2 + x^2 - 3.  What is
        kept stays as it is written.
        """
        if isinstance(energy, Kept):
            return energy
        if energy.has(sp.Function):
            return energy.func(*map(self.natural, energy.args))
        q, x = self.coordinates, self.thickness
        factor, rest = energy.as_independent(*q, x, as_Add=False)
        terms = sp.Add.make_args(sp.expand(self.explicit(rest)))
        return factor * sum(_by_thickness(term, q, x) for term in terms)


@dataclass(frozen=True)
class System:
    """A first-order system in symbols, with what is observed of it.

    Attributes
    ----------
    state
        Symbols of the state variables.
    definitions
        Intermediate symbols and what each stands for, in terms of states, parameters,
        waveforms, the phase and earlier definitions.
    rates
        Rate of each state variable.
    watched
        The thickness stretch, its rate, its acceleration, and the rate's sign.
    observables
        Further quantities by name.
    room
        What is positive in the states that the material can reach.
    """

    state: tuple[Symbol, ...]
    definitions: Mapping[Symbol, Expression]
    rates: tuple[Expression, ...]
    watched: tuple[Expression, ...]
    observables: Mapping[str, Expression]
    room: tuple[Expression, ...] = ()


def derive(actuator: Actuator, drive: Drive) -> System:
    """The first-order system of an actuator under a drive.

    Only the structure of both is used, never a numeric value.
    """
    return first_order(motion(actuator, drive))


def motion(actuator: Actuator, drive: Drive | None) -> Motion:
    """Energies of an actuator; without a drive, the load is left as a symbol.

    Equations, per 8 H L1 L2 mu [Thermal, eqs. 3 to 12], l3 = 1/(l1 l2):
    T = (w1 l1'^2 + w2 l2'^2 + c l3'^2)/6,  w_i = (L_i/L)^2, here 1 where edges are equal,
    U = mu(T)/mu W(l1, l2, l3) - m l3 - S1 (l1 - 1) - S2 (l2 - 1) + viscous energy
    + the magnet's energy in its own field.
    """
    p = {name: parameter(name) for name in actuator.parameters()}
    q, v = coordinate_symbols(actuator.coordinates)
    pair, pair_rate = (q[0], q[-1]), (v[0], v[-1])
    x, x_rate = sp.Symbol("thickness", positive=True), sp.Symbol("thickness_rate", real=True)
    theta, stiffness, load, effective = _LOAD_SYMBOLS
    viscous = [
        _viscous(f"dissipation.{i}", part, (*pair, x), pair_rate, actuator, p)
        for i, part in enumerate(actuator.elements())
    ]
    strain = actuator.material.energy(*pair, x, own(p, "material"), sp)
    strain = Kept(strain) if actuator.material.kept else strain
    magnetic = actuator.magnet.energy(effective, x)
    edges = (*_edges(actuator, p), sp.sqrt(p["c"]))
    own_field = actuator.magnet.self_energy((*pair, x), edges, own(p, "magnet"), sp)
    dead = sum(s * (stretch - 1) for s, stretch in zip(_pair(p, "prestress"), pair, strict=True))
    terms = (
        (stiffness, strain),
        (1, magnetic),
        (1, -dead),
        (Kept(_remanence(actuator, p) ** 2), Kept(own_field)),
        *((theta, e.stored) for e in viscous),
    )
    geometry = {
        AREA: pair[0] * pair[1],
        x: 1 / AREA,
        x_rate: -(x**2) * (pair_rate[0] * pair[1] + pair_rate[1] * pair[0]),
    }
    return Motion(
        coordinates=q,
        rates=v,
        weights=(*_weights(actuator, p), p["c"]),
        terms=terms,
        magnetic=magnetic,
        viscous=theta * sum((e.stored for e in viscous), start=sp.Integer(0)),
        rayleigh=sum((e.rayleigh for e in viscous), start=sp.Integer(0)),
        internal={k: rate for e in viscous for k, rate in e.internal.items()},
        thickness=x,
        thickness_rate=x_rate,
        load=load,
        theta=theta,
        definitions=_definitions(actuator, drive, p) | geometry,
        room=tuple(actuator.material.room(*pair, x, own(p, "material"), sp)),
        heat=_heat(actuator, drive, p, terms),
    )


def first_order(motion: Motion) -> System:
    """Solve Lagrange's equations for the accelerations and list all rates."""
    q, v = motion.coordinates, motion.rates
    named, solved, thickness_acceleration = accelerations(motion)
    rates: dict[Symbol, Expression] = {}
    for coordinate, rate, acceleration in zip(q, v, solved, strict=True):
        rates[coordinate], rates[rate] = rate, acceleration
    rates |= motion.internal
    lost = dissipated(motion)
    if motion.heat is not None:
        rates |= motion.heat.rate(rates, damped(motion), motion)
    x, x_rate = motion.thickness, motion.thickness_rate
    return System(
        state=tuple(rates),
        definitions={**motion.definitions, **named},
        rates=tuple(rates.values()),
        watched=(x, x_rate, thickness_acceleration, _sign_of(motion.explicit(x_rate))),
        observables={
            "thickness_stretch": x,
            "thickness_stretch_rate": x_rate,
            "energy": motion.kinetic + motion.potential,
            "load": motion.load,
            **balances(motion, rates, lost),
        },
        room=motion.room,
    )


def _sign_of(expression: Expression) -> Expression:
    """Something with the same sign and without a division, where there is one."""
    numerator, denominator = sp.fraction(sp.together(expression))
    return numerator if denominator.is_positive else expression


def dissipated(motion: Motion) -> Expression:
    """The power that becomes heat: sum of q' dD/dq' - dU_v/dxi xi'."""
    return damped(motion) - along(motion.natural(motion.viscous), motion.internal)


def damped(motion: Motion) -> Expression:
    """The part of it from dashpots that lie in parallel: sum of q' dD/dq'."""
    return sum((v * sp.diff(motion.rayleigh, v) for v in motion.rates), start=sp.Integer(0))


def accelerations(motion: Motion) -> tuple[dict[Symbol, Expression], list[Expression], Expression]:
    """Intermediate symbols, and in terms of them the accelerations and that of the thickness.

    With weights w_i, the thickness stretch x(q) as a further stretch of weight c, g_i =
    dx/dq_i and x'' = sum g_i q_i'' + K, d'Alembert's principle gives, times 3,
    w_i q_i'' + c g_i (sum g_j q_j'') = A_i - g_i Y,  A_i = -3 (dU/dq_i + dD/dq_i'),
    Y = 3 dU/dx + c K,  with derivatives at fixed x.  For two coordinates, with the
    cancellations of M^-1 done: q_1'' = [w_2 (A_1 - g_1 Y) + c g_2 R]/det,  q_2'' =
    [w_1 (A_2 - g_2 Y) - c g_1 R]/det,  R = g_2 A_1 - g_1 A_2.  The thickness stretch has
    x'' = [w_2 g_1 (A_1 - g_1 F) + w_1 g_2 (A_2 - g_2 F) + w_1 w_2 K]/det,  F = 3 dU/dx:
    in sum g_i q_i'' + K, most of K would cancel.
    """
    q, v, x = motion.coordinates, motion.rates, motion.thickness
    c = motion.weights[-1]
    x_rate = motion.definitions[motion.thickness_rate]
    inertia, scale, drag = sp.Symbol("inertia"), sp.Symbol("scale"), sp.Symbol("drag")
    pressed, bent = sp.Symbol("pressed"), sp.Symbol("bent")
    slopes = [sp.Symbol(f"slope_{i}") for i in range(len(q))]
    pushes = [sp.Symbol(f"push_{i}") for i in range(len(q))]
    named: dict[Symbol, Expression] = {}
    for slope, push, coordinate, rate in zip(slopes, pushes, q, v, strict=True):
        named[slope] = sp.diff(x_rate, rate)
        named[push] = -3 * (_force(motion, coordinate) + sp.diff(motion.rayleigh, rate))
    named[pressed], named[bent] = 3 * _force(motion, x), _bent(motion)
    named[drag] = pressed + c * bent
    if len(q) == 1:
        (w, _), (g,), (push,) = motion.weights, slopes, pushes
        determinant, solved = w + c * g**2, [push - g * drag]
        thickened = g * (push - g * pressed) + w * bent
    else:
        (w1, w2, _), (g1, g2), (a1, a2) = motion.weights, slopes, pushes
        twist = sp.Symbol("twist")
        named[twist] = c * (g2 * a1 - g1 * a2)
        determinant = w1 * w2 + c * (w2 * g1**2 + w1 * g2**2)
        solved = [w2 * (a1 - g1 * drag) + g2 * twist, w1 * (a2 - g2 * drag) - g1 * twist]
        thickened = w2 * g1 * (a1 - g1 * pressed) + w1 * g2 * (a2 - g2 * pressed) + w1 * w2 * bent
    # The slopes are x^2 times a stretch: in units of x^4 the determinant is a polynomial.
    known = {g: named[g] for g in slopes}
    named[inertia] = _polynomial(determinant.subs(known), x)
    named[scale] = AREA**4 / inertia
    return named, [scale * e for e in solved], scale * thickened


def _polynomial(determinant: Expression, x: Symbol) -> Expression:
    """The determinant over x^4, the area being 1/x."""
    constant = determinant.subs(x, 0)
    return constant * AREA**4 + sp.factor_terms(sp.expand((determinant - constant) / x**4))


def _bent(motion: Motion) -> Expression:
    """What the acceleration of the thickness stretch is without accelerations in the plane."""
    moving = dict(zip(motion.coordinates, motion.rates, strict=True))
    moving[motion.thickness] = motion.thickness_rate
    return sp.factor_terms(along(motion.definitions[motion.thickness_rate], moving))


def _force(motion: Motion, stretch: Symbol) -> Expression:
    """dU/d(stretch), term by term, with the thickness stretch as a stretch of its own."""
    return sum(factor * sp.diff(motion.natural(energy), stretch) for factor, energy in motion.terms)


def _by_thickness(term: Expression, q: Sequence[Symbol], x: Symbol) -> Expression:
    """A product of powers; the negative powers of coordinates are those of the thickness."""
    powers = term.as_powers_dict()
    each = 2 // len(q)  # powers of a coordinate in the area
    below = {sp.sympify(-powers.get(symbol, 0)) / each for symbol in q}
    if all(power.is_number for power in below):
        k = max(0, *map(sp.ceiling, below))
    else:  # powers in symbols, which stand for positive numbers here
        k = 0 if len(below) > 1 or min(below).could_extract_minus_sign() else min(below)
    return term * sp.Mul(*(symbol ** (each * k) for symbol in q)) * x**k


def lagrange(motion: Motion) -> tuple[Any, Any]:
    """Mass matrix M and force f of Lagrange's equations M(q) q'' = f(q, q').

    Equation: d/dtau dT/dq' - dT/dq + dU/dq + dD/dq' = 0 [Thermal, eq. 8].
    """
    q, v = motion.coordinates, motion.rates
    kinetic, potential = motion.explicit(motion.kinetic), motion.explicit(motion.potential)
    rayleigh = motion.rayleigh
    momenta = [sp.diff(kinetic, rate) for rate in v]
    mass = sp.Matrix([[sp.diff(momentum, rate) for rate in v] for momentum in momenta])
    force = sp.Matrix(
        [
            sp.diff(kinetic - potential, q[i])
            - sp.diff(rayleigh, v[i])
            - sum(sp.diff(momentum, q[j]) * v[j] for j in range(len(q)))
            for i, momentum in enumerate(momenta)
        ]
    )
    return mass, force


# Symbols ------------------------------------------------------------------------------


def parameter(name: str) -> Symbol:
    """The symbol of a numeric field."""
    return sp.Symbol(name, positive=True) if name in _POSITIVE else sp.Symbol(name, real=True)


def waveform(name: str) -> Symbol:
    """The symbol of a waveform of the drive."""
    return sp.Symbol(name, real=True)


def coordinate_symbols(coordinates: int) -> tuple[tuple[Symbol, ...], tuple[Symbol, ...]]:
    """Stretches and their rates: one of each, or two."""
    suffixes = [""] if coordinates == 1 else [f"_{i + 1}" for i in range(coordinates)]
    stretches = tuple(sp.Symbol(f"stretch{suffix}", positive=True) for suffix in suffixes)
    rates = tuple(sp.Symbol(f"stretch{suffix}_rate", real=True) for suffix in suffixes)
    return stretches, rates


_POSITIVE = frozenset({"c", "temperature", "reference_temperature", "edges_1", "edges_2"})
PHASE = sp.Symbol("drive_phase", real=True)
#: The product of the in-plane stretches, one over the thickness stretch.
AREA = sp.Symbol("area", positive=True)
#: T/T0, the factor of the strain energy, the load, and the load with the remanence at T.
_LOAD_SYMBOLS = (
    *sp.symbols("theta stiffness", positive=True),
    *sp.symbols("load effective_load", real=True),
)


# Parts --------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Viscous:
    rayleigh: Expression
    stored: Expression
    internal: Mapping[Symbol, Expression]


def _viscous(
    prefix: str,
    part: Dissipation,
    stretches: Sequence[Symbol],
    rates: Sequence[Symbol],
    actuator: Actuator,
    p: Mapping[str, Symbol],
) -> _Viscous:
    """One dissipative element; equal stretches share one internal variable per kind."""
    suffixes = ("", "") if actuator.coordinates == 1 else ("_1", "_2")
    symbols = [
        sp.Symbol(f"{prefix}.{kind}{suffix}", positive=True)
        for kind in part.internal
        for suffix in suffixes
    ]
    numbers = part.at(body_temperature(actuator), p["reference_temperature"], own(p, prefix), sp)
    theta = _LOAD_SYMBOLS[0]
    found = part.internal_rates(stretches, symbols, theta, numbers)
    return _Viscous(
        rayleigh=sp.sympify(part.rayleigh(stretches, rates, numbers)),
        stored=sp.sympify(part.stored(stretches, symbols, numbers)),
        internal=dict(zip(symbols, found, strict=True)),
    )


def _definitions(
    actuator: Actuator, drive: Drive | None, p: Mapping[str, Symbol]
) -> dict[Symbol, Expression]:
    """Temperature ratio, stiffness, load, and load with the remanence at temperature."""
    theta, stiffness, load, effective = _LOAD_SYMBOLS
    temperature, reference = body_temperature(actuator), p["reference_temperature"]
    fraction = p["material.entropic_fraction"]
    meanings = {
        theta: temperature / reference,
        stiffness: heat.stiffness(theta, fraction),
        load: None if drive is None else in_symbols(drive.load, drive),
        effective: _remanence(actuator, p) * load,
    }
    return {symbol: e for symbol, e in meanings.items() if e is not None}


def _remanence(actuator: Actuator, p: Mapping[str, Symbol]) -> Expression:
    """B_r(T)/B_r(T0)."""
    temperature, reference = body_temperature(actuator), p["reference_temperature"]
    return actuator.magnet.remanence(temperature, reference, own(p, "magnet"))


def _heat(
    actuator: Actuator, drive: Drive | None, p: Mapping[str, Symbol], terms: Sequence[Any]
) -> Warming | None:
    """The heat balance: factors of the energies above in terms of theta, and the load itself."""
    if actuator.heat is None:
        return None
    theta, stiffness, load, effective = _LOAD_SYMBOLS
    fraction, temperature = p["material.entropic_fraction"], body_temperature(actuator)
    of_theta = {
        stiffness: heat.stiffness(theta, fraction),
        temperature: theta * p["reference_temperature"],
    }
    strain, (_, magnetic), _, *others = terms
    return warming(
        temperature=temperature,
        p=p,
        theta=theta,
        mechanical=[(factor.subs(of_theta), energy) for factor, energy in (strain, *others)],
        in_field=(_remanence(actuator, p).subs(of_theta), magnetic.subs(effective, load)),
        load_rate=None if drive is None else in_symbols(drive.rate, drive),
    )


def body_temperature(actuator: Actuator) -> Symbol:
    """The symbol of T: a state where there is a heat balance, else a numeric field."""
    if actuator.heat is not None:
        return sp.Symbol("body_temperature", positive=True)
    return parameter("temperature")


def in_symbols(law: Callable[..., Any], drive: Drive) -> Expression:
    """The load of a drive, or its rate, in symbols; None where it has none."""
    names = (*drive.parameters(), *drive.piece_parameters)
    p = {name: parameter(name) for name in names}
    u = {name: waveform(name) for name in drive.waveforms}
    found = law(p, u, PHASE, sp)
    return None if found is None else sp.sympify(found)


def _pair(p: Mapping[str, Symbol], name: str) -> tuple[Symbol, Symbol]:
    return (p[name], p[name]) if name in p else (p[f"{name}_1"], p[f"{name}_2"])


def _edges(actuator: Actuator, p: Mapping[str, Symbol]) -> tuple[Expression, Expression]:
    """L1/L and L2/L."""
    return (sp.Integer(1), sp.Integer(1)) if actuator.edges is None else _pair(p, "edges")


def _weights(actuator: Actuator, p: Mapping[str, Symbol]) -> tuple[Expression, ...]:
    """Of the coordinates in the kinetic energy: (L_i/L)^2, 1 where edges are equal."""
    one, two = _edges(actuator, p)
    return (one**2, two**2) if actuator.coordinates == 2 else (one**2 + two**2,)
