"""From a system and a drive to a Field, by derivation."""

from __future__ import annotations

from typing import Any

from remanent._field import Field, Program
from remanent.codegen.lower import Level, lower
from remanent.derivation.derive import derive
from remanent.derivation.motion import FirstOrderForm
from remanent.derivation.symbols import PHASE, Symbol, parameter, waveform
from remanent.models.drives.base import Drive
from remanent.models.system import System


def build(system: System, drive: Drive) -> Field:
    """Derive the equations of motion and translate them to straight-line code.

    Only the structure of both arguments is used, never a numeric value.
    """
    form = derive(system, drive)
    state = tuple(symbol.name for symbol in form.state)
    parameters = (
        *system.parameters(),
        *drive.parameters(),
        *drive.piece_parameters,
    )
    inputs = ("drive_phase", *state, *parameters, *drive.waveforms)
    levels = _levels(form, parameters, drive)

    def program(*outputs: Any, **options: Any) -> Program:
        return lower(
            outputs,
            inputs=inputs,
            levels=levels,
            definitions=form.definitions,
            **options,
        )

    return Field(
        variables=form.variables,
        loads=form.loads,
        parameters=parameters,
        waveforms=drive.waveforms,
        rates=program(*form.rates, admissibility=form.admissibility),
        observable=form.observable,
        watched=program(*form.watched),
        observables={name: program(e, as_written=True) for name, e in form.observables.items()},
    )


def _levels(form: FirstOrderForm, parameters: tuple[str, ...], drive: Drive) -> dict[Symbol, Level]:
    """What each input varies with."""
    return (
        dict.fromkeys(form.state, Level.STATE)
        | {parameter(name): Level.PARAMETER for name in parameters}
        | {waveform(name): Level.DRIVE for name in drive.waveforms}
        | {PHASE: Level.DRIVE}
    )
