"""From a system and a drive to a Field, by derivation."""

from __future__ import annotations

from typing import Any

from remanent._field import Field, Program
from remanent._instructions import program_cost
from remanent.codegen.lower import DependenceLevel, lower_to_program
from remanent.derivation.derive import derive
from remanent.derivation.motion import FirstOrderForm
from remanent.derivation.symbols import DRIVE_PHASE, Symbol, parameter_symbol, waveform_symbol
from remanent.models.drives.base import Drive
from remanent.models.system import System


def build_field(system: System, drive: Drive) -> Field:
    """Derive the equations of motion and translate them to straight-line code.

    Only the structure of both arguments is used, never a numeric value.
    """
    form = derive(system, drive)
    state = tuple(symbol.name for symbol in form.state_symbols)
    parameters = (
        *system.parameter_values(),
        *drive.parameter_values(),
        *drive.piece_parameter_names,
    )
    inputs = ("drive_phase", *state, *parameters, *drive.waveform_names)
    levels = _dependence_level_of_symbol(form, parameters, drive)

    def program(*outputs: Any, definitions: Any = form.definitions, **options: Any) -> Program:
        return lower_to_program(
            outputs, inputs=inputs, levels=levels, definitions=definitions, **options
        )

    ways = [(form.definitions, form.rates), *([form.alternative] if form.alternative else [])]
    rates = [
        program(
            *outputs,
            definitions=definitions,
            admissibility_conditions=form.admissibility_conditions,
        )
        for definitions, outputs in ways
    ]

    return Field(
        variables=form.variables,
        load_names=form.load_names,
        parameter_names=parameters,
        waveform_names=drive.waveform_names,
        rates=min(rates, key=program_cost),
        observable_name=form.observable_name,
        observable_and_rates=program(*form.observable_and_rates),
        observables={name: program(e, as_written=True) for name, e in form.observables.items()},
    )


def _dependence_level_of_symbol(
    form: FirstOrderForm, parameters: tuple[str, ...], drive: Drive
) -> dict[Symbol, DependenceLevel]:
    """What each input varies with."""
    return (
        dict.fromkeys(form.state_symbols, DependenceLevel.STATE)
        | {
            form.parameter_symbols.get(name, parameter_symbol(name)): DependenceLevel.PARAMETER
            for name in parameters
        }
        | {waveform_symbol(name): DependenceLevel.DRIVE for name in drive.waveform_names}
        | {DRIVE_PHASE: DependenceLevel.DRIVE}
    )
