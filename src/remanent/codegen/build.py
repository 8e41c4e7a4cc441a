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

    def program(form: FirstOrderForm, *outputs: Any, **options: Any) -> Program:
        return lower_to_program(
            outputs, inputs=inputs, levels=levels, definitions=form.definitions, **options
        )

    def program_of_rates(form: FirstOrderForm) -> Program:
        conditions = form.admissibility_conditions
        return program(form, *form.rates, admissibility_conditions=conditions)

    forms = [form, *([form.alternative] if form.alternative else [])]
    rates = [program_of_rates(one) for one in forms]
    # Of equal costs the first.
    cheapest = min(range(len(forms)), key=lambda k: program_cost(rates[k]))

    return Field(
        variables=form.variables,
        load_names=form.load_names,
        parameter_names=parameters,
        waveform_names=drive.waveform_names,
        rates=rates[cheapest],
        observable_name=form.observable_name,
        observable_and_rates=program(forms[cheapest], *forms[cheapest].observable_and_rates),
        observables={
            name: program(form, e, as_written=True) for name, e in form.observables.items()
        },
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
