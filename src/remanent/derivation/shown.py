"""What a notebook shows of a system, a part or a drive: its formulas, typeset.

A part is shown by what it adds to an actuator, a drive by its load as a function of time. All
of it comes from the functions that the equations of motion are derived from.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import singledispatch
from types import MappingProxyType

import numpy as np
import sympy as sp

from remanent.derivation.block import build_motion
from remanent.derivation.letters import latex, letter
from remanent.derivation.motion import Motion
from remanent.derivation.readable import (
    Equations,
    equation_latex,
    equations,
    letters_of_actuator,
)
from remanent.derivation.symbols import Expression, Symbol, parameter_symbol
from remanent.derivation.unexpanded import without_mark
from remanent.models.actuator import Actuator
from remanent.models.dissipation import Dissipation
from remanent.models.drives.base import Drive
from remanent.models.drives.loads import Loads
from remanent.models.heat import Heat
from remanent.models.magnet import Magnet
from remanent.models.materials.base import (
    Material,
    first_invariant_minus_three,
    second_invariant_minus_three,
)
from remanent.models.own_systems.written_system import WrittenSystem
from remanent.models.temperature_shift import TemperatureShift

#: Longest formula that is shown, in characters of LaTeX: about half a page.
LONGEST_FORMULA = 1500
#: Time, in units of the system.
_TAU = sp.Symbol("tau", real=True)


@singledispatch
def formulas(value: object) -> tuple[str, ...]:  # noqa: ARG001
    r"""LaTeX of the formulas of a system, a part of a model or a drive, one a line.

    Parameters
    ----------
    value
        Of any kind; what has no formulas has none.

    Examples
    --------
    >>> from remanent.models.drives.waves import Constant
    >>> formulas(Constant(0.2))
    ('m(\\tau) = m',)
    """
    return ()


@formulas.register
def _(value: Actuator) -> tuple[str, ...]:
    return _rows(equations(value))


@formulas.register
def _(value: WrittenSystem) -> tuple[str, ...]:
    return _rows(equations(value))  # type: ignore[arg-type]


@formulas.register
def _(value: Material) -> tuple[str, ...]:
    motion = build_motion(Actuator(material=value, prestress=(0, 0)), None)
    return (
        _equation("W", strain_energy_in_invariants(value, motion)),
        _equation("g", motion.definitions[sp.Symbol("stiffness", positive=True)]),
    )


@formulas.register
def _(value: Magnet) -> tuple[str, ...]:
    motion = build_motion(Actuator(magnet=value, prestress=(0, 0)), None)
    energies = motion.energies
    load = sp.Symbol("effective_load", real=True)
    rows = [
        _equation("U_m", energies.applied_field.product),
        _equation("m_T", motion.definitions[load]),
    ]
    if value.demagnetisation is not None:
        rows.append(_equation("U_d", energies.self_field.product))
    return tuple(rows)


@formulas.register
def _(value: Dissipation) -> tuple[str, ...]:
    motion = build_motion(Actuator(dissipation=(value,), prestress=(0, 0)), None)
    stored, rates = motion.viscous_energy, motion.internal_rates
    rows = []
    if motion.rayleigh_function != 0:
        rows.append(("D", motion.rayleigh_function))
    if stored != 0:
        rows.append(("U_v", motion.in_principal_stretches(stored)))
    rows += [(_unnumbered(f"{symbol.name}'"), rate) for symbol, rate in rates.items()]
    return tuple(
        _equation(name, right, {s.name: _unnumbered(s.name) for s in right.free_symbols})
        for name, right in rows
    )


def _unnumbered(name: str) -> str:
    """The letter of a number of an element that is the only one."""
    return letter(name.replace("dissipation.0.", "dissipation."))


@formulas.register
def _(value: TemperatureShift) -> tuple[str, ...]:
    p = {name: parameter_symbol(name) for name in value.parameter_values()}
    temperature, reference = map(parameter_symbol, ("temperature", "reference_temperature"))
    return (_equation("a_T", value.shift_factor(temperature, reference, p, sp)),)


@formulas.register
def _(value: Heat) -> tuple[str, ...]:
    shown = equations(Actuator(heat=value))
    return _rows(replace(shown, second_order=()))


@formulas.register
def _(value: Drive) -> tuple[str, ...]:
    return (_load_equation(r"m(\tau)", value),)


@formulas.register
def _(value: Loads) -> tuple[str, ...]:
    return tuple(
        _load_equation(rf"\mathrm{{{name.replace('_', ' ')}}}(\tau)", drive)
        for name, drive in value.parts().items()
        if isinstance(drive, Drive)
    )


def _load_equation(name: str, drive: Drive) -> str:
    """The load as a function of time, and until when it is that."""
    end = min(drive.last_change + 1.0, drive.known_until)
    lengths = drive.load_schedule({}, np.array([end])).piece_lengths
    until = rf", \quad 0 \leq \tau \leq {float(lengths[0, 0]):g}" if len(lengths) > 1 else ""
    return _equation(name, load_in_time(drive)) + until


def letters_of(value: object) -> dict[str, str]:
    """Letters of numbers that are others than usual, by name."""
    return letters_of_actuator(value) if isinstance(value, Actuator) else {}


def load_in_time(drive: Drive) -> Expression:
    """The load of a drive as a function of the symbol tau.

    Parameters
    ----------
    drive : Drive
        With one load.  One in pieces is shown in its first piece.
    """
    p = {name: parameter_symbol(name) for name in drive.parameter_values()}
    pieces = drive.piece_parameters_in_time(p, _TAU)
    u = {
        name: getattr(sp, wave.function)(angle)
        for name, wave, angle in zip(
            drive.waveform_names, drive.waveforms, _angles(drive, p), strict=True
        )
    }
    load = sp.sympify(drive.load({**p, **pieces}, u, sp.Integer(1), sp))
    load = sp.trigsimp(load) if u else load  # waveforms and phases are sines of a sum
    return load.xreplace({number: _short(number) for number in load.atoms(sp.Float)})


def _short(number: Expression) -> Expression:
    """A floating-point number as people write it: whole, or in six digits."""
    return sp.Integer(number) if number == int(number) else sp.Float(number, 6)


def _angles(drive: Drive, p: Mapping[str, Symbol]) -> Iterator[Expression]:
    """Angles of the waveforms: that of one period times the share of it that has passed."""
    name, period = drive.period_field_name, drive.period
    if name is None or period is None:
        return
    for wave in drive.waveforms:
        turns = wave.span * wave.repeats / (period * drive.parameter_values()[name])
        yield sp.nsimplify(turns, rational=True, tolerance=1e-9) * p[name] * _TAU


def strain_energy_in_invariants(material: Material, motion: Motion) -> Expression:
    """The strain energy in the invariants where it is written in them, else in stretches."""
    names = ("stretch_1", "stretch_2", "thickness")
    stretches = [sp.Symbol(name, positive=True) for name in names]
    p = {name: sp.Symbol(f"material.{name}", real=True) for name in material.parameter_values()}
    with sp.evaluate(False):  # so that the invariants stay as they are written
        energy = sp.sympify(material.energy(stretches[0], stretches[1], stretches[2], p, sp))
        invariants = {
            first_invariant_minus_three(*stretches): sp.Symbol("I1") - 3,
            second_invariant_minus_three(*stretches): sp.Symbol("I2") - 3,
        }
        energy = energy.xreplace(invariants)
    if not energy.has(*stretches):
        return energy.doit()
    energy = motion.in_principal_stretches(motion.energies.strain.energy)
    squares = sum(stretch**2 for stretch in stretches)
    return without_mark(energy).subs(squares, sp.Symbol("I1"))


def _rows(shown: Equations) -> tuple[str, ...]:
    """Equations of motion, and what those symbols stand for that occur in them."""
    rows = [*shown.second_order, *shown.first_order]
    needed = set().union(*(row.free_symbols for row in rows))
    meanings = []
    for definition in reversed(shown.definitions):
        if definition.lhs in needed:
            needed |= definition.rhs.free_symbols
            meanings.append(definition)
    return tuple(equation_latex(row, shown.letters) for row in (*rows, *meanings))


def _equation(
    name: str, expression: Expression, names: Mapping[str, str] = MappingProxyType({})
) -> str:
    """An equation for what is called `name` in LaTeX."""
    return f"{name} = {latex(without_mark(expression), names)}"
