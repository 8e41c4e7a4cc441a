"""Symbols of the derivation, each defined once, and the time derivative of an expression."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import sympy as sp

from remanent.models.drives.base import Drive
from remanent.models.physical_sizes import PHYSICAL_SIZES

#: SymPy is not typed.
Expression = Any
#: A SymPy symbol.
Symbol = Any

#: Phase of the drive in [0, 1), or the fraction of the current piece of the load.
DRIVE_PHASE = sp.Symbol("drive_phase", real=True)
#: The product of the in-plane stretches, one over the thickness stretch.
AREA_STRETCH = sp.Symbol("area", positive=True)
#: The thickness stretch, which incompressibility makes 1/area.
THICKNESS_STRETCH = sp.Symbol("thickness", positive=True)
#: Rate of the thickness stretch.
THICKNESS_STRETCH_RATE = sp.Symbol("thickness_rate", real=True)
#: theta = T/T0.
TEMPERATURE_RATIO = sp.Symbol("theta", positive=True)
#: mu(T)/mu(T0), the factor of the strain energy.
STIFFNESS_RATIO = sp.Symbol("stiffness", positive=True)
#: The magnetic load m.
LOAD = sp.Symbol("load", real=True)
#: The magnetic load with the remanence at temperature, m B_r(T)/B_r(T0).
LOAD_AT_TEMPERATURE = sp.Symbol("effective_load", real=True)
#: T of the body, a state where there is a heat balance.
BODY_TEMPERATURE = sp.Symbol("body_temperature", positive=True)

#: Numeric fields that only take positive values.  What is negative elsewhere is real.
_POSITIVE_PARAMETERS = frozenset(
    {"c", "temperature", "reference_temperature", "edges_1", "edges_2", *PHYSICAL_SIZES}
)


def parameter_symbol(name: str) -> Symbol:
    """The symbol of a numeric field."""
    if name in _POSITIVE_PARAMETERS:
        return sp.Symbol(name, positive=True)
    return sp.Symbol(name, real=True)


def waveform_symbol(name: str) -> Symbol:
    """The symbol of a waveform of the drive."""
    return sp.Symbol(name, real=True)


def load_symbol(name: str) -> Symbol:
    """The symbol of a load."""
    return sp.Symbol(name, real=True)


def loads_in_symbols(
    laws: Callable[..., Mapping[str, Any]], drive: Drive
) -> dict[Symbol, Expression]:
    """The loads of a drive, or their rates, in symbols; None where there is no closed form.

    Parameters
    ----------
    laws
        ``drive.loads_by_name`` or ``drive.load_rates_by_name``.
    """
    names = (*drive.parameter_values(), *drive.piece_parameter_names)
    p = {name: parameter_symbol(name) for name in names}
    u = {name: waveform_symbol(name) for name in drive.waveform_names}
    return {
        load_symbol(name): None if law is None else sp.sympify(law)
        for name, law in laws(p, u, DRIVE_PHASE, sp).items()
    }


def coordinate_symbols(coordinates: int) -> tuple[tuple[Symbol, ...], tuple[Symbol, ...]]:
    """In-plane stretches and their rates: one of each, or two."""
    suffixes = [""] if coordinates == 1 else [f"_{i + 1}" for i in range(coordinates)]
    stretches = tuple(sp.Symbol(f"stretch{suffix}", positive=True) for suffix in suffixes)
    rates = tuple(sp.Symbol(f"stretch{suffix}_rate", real=True) for suffix in suffixes)
    return stretches, rates


def time_derivative(expression: Expression, rates: Mapping[Symbol, Expression]) -> Expression:
    """Time derivative of a function of the state: the sum of its slopes times `rates`."""
    return sum(
        (sp.diff(expression, symbol) * rate for symbol, rate in rates.items()),
        start=sp.Integer(0),
    )


def substitute_definitions(
    expression: Expression, definitions: Mapping[Symbol, Expression]
) -> Expression:
    """The expression with what symbols stand for put in, the last definition first."""
    for symbol, meaning in reversed(list(definitions.items())):
        expression = expression.subs(symbol, meaning)
    return expression
