"""From an actuator and a drive to a Field, by derivation."""

from __future__ import annotations

from typing import Any

from remanent._field import Field, Program
from remanent.codegen.lower import DRIVE, PARAMETER, STATE, lower
from remanent.derivation import lagrange
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive


def build(actuator: Actuator, drive: Drive) -> Field:
    """Derive the equations of motion and translate them to straight-line code.

    Only the structure of both arguments is used, never a numeric value.
    """
    system = lagrange.derive(actuator, drive)
    state = tuple(symbol.name for symbol in system.state)
    parameters = (
        *actuator.parameters(),
        *drive.parameters(),
        *drive.piece_parameters,
    )
    inputs = ("drive_phase", *state, *parameters, *drive.waveforms)
    levels = _levels(system, parameters, drive)

    def program(*outputs: Any, **options: Any) -> Program:
        return lower(
            outputs,
            inputs=inputs,
            levels=levels,
            definitions=system.definitions,
            **options,
        )

    return Field(
        variables=system.variables,
        parameters=parameters,
        waveforms=drive.waveforms,
        rates=program(*system.rates, room=system.room),
        watched=program(*system.watched),
        observables={name: program(e, as_written=True) for name, e in system.observables.items()},
    )


def _levels(
    system: lagrange.System, parameters: tuple[str, ...], drive: Drive
) -> dict[lagrange.Symbol, int]:
    """What each input varies with."""
    return (
        dict.fromkeys(system.state, STATE)
        | {lagrange.parameter(name): PARAMETER for name in parameters}
        | {lagrange.waveform(name): DRIVE for name in drive.waveforms}
        | {lagrange.PHASE: DRIVE}
    )
