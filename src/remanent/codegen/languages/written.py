"""All that a file with equations says, before it is written in a language."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, Final

import numpy as np

from remanent._field import Field, Program
from remanent.codegen.formula_program import program_of_values
from remanent.codegen.languages.computation import Computation, computation_of
from remanent.codegen.languages.expressions import Expression
from remanent.models.drives.base import Drive

#: The time.  No name of a user begins like these, which are reserved.
TIME: Final = "drive.time"
#: The phase of the drive, or the fraction of a piece.
PHASE: Final = "drive_phase"
#: Columns of the table of pieces before those of the parameters of a piece.
PIECE_START: Final = "drive.piece_start"
PIECE_LENGTH: Final = "drive.piece_length"
#: Share of the last time of a table of samples by which a run may be longer, through rounding.
_RELATIVE_END_ROUNDING: Final = 1e-9
#: Multiples of pi are told from other numbers in so many digits.
_DIGITS_OF_MULTIPLE: Final = 9


@dataclass(frozen=True)
class StateText:
    """A state variable in a header.

    Attributes
    ----------
    name
        Its name.
    unit
        Its unit, as the user gave it, or ``"1"``.
    initial
        Where it starts.
    """

    name: str
    unit: str
    initial: float


@dataclass(frozen=True)
class WrittenEquations:
    """Equations of motion under a load, in no language yet.

    Attributes
    ----------
    description
        Lines for people: what it is, what made it, its units.
    state
        The state variables in order.
    parameters
        Values of the numeric fields that the statements need, by name.
    unused
        Values of the other numeric fields.
    rates
        The rates of the state variables, from time, state, parameters and pieces.
    loads
        Each load by its name, from the same but the state.
    rates_over_period
        The rates times the period of the load, as functions of its phase; None without a period.
    period
        The period of the load, where it has one.
    period_field
        The numeric field to which it is inversely proportional, where there is one.
    pieces
        Rows of the table of pieces: start, length, and the parameters of each piece.
    piece_columns
        Names of the columns.
    breaks
        Times at which the load jumps or bends: an integrator is to be started anew there.
    known_until
        The time after which the load is not known, or infinity.
    """

    description: tuple[str, ...]
    state: tuple[StateText, ...]
    parameters: Mapping[str, float]
    unused: Mapping[str, float]
    rates: Computation
    loads: Mapping[str, Computation]
    rates_over_period: Computation | None
    period: float | None
    period_field: str | None
    pieces: tuple[tuple[float, ...], ...]
    piece_columns: tuple[str, ...]
    breaks: tuple[float, ...]
    known_until: float

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of everything that needs an identifier, in order."""
        state = [variable.name for variable in self.state]
        assigned = [
            name
            for one in (self.rates_over_period, self.rates, *self.loads.values())
            if one is not None
            for name, _ in one.assignments
        ]
        return tuple(dict.fromkeys([*state, *self.parameters, *assigned]))

    def needs_pieces(self, computation: Computation) -> bool:
        """Whether a computation reads the table of pieces."""
        return bool(computation.input_names & {*self.piece_columns})

    @property
    def usual_duration(self) -> float:
        """How long a first run may last: twenty periods, or past the last change of the load."""
        if math.isfinite(self.known_until):
            return self.known_until
        if self.period is not None:
            return 20.0 * self.period
        return 50.0 + 2.0 * max(self.breaks, default=0.0)


def written_equations(
    field: Field,
    drive: Drive,
    values: Mapping[str, float],
    state: tuple[StateText, ...],
    description: tuple[str, ...],
) -> WrittenEquations:
    """Equations of motion as they are exported.

    Parameters
    ----------
    field : Field
        The vector field under this drive.
    drive : Drive
        The law of its loads in time.
    values : mapping of str to float
        Values of all numeric fields.
    state : tuple of StateText
        The state variables.
    description : tuple of str
        Lines for people.
    """
    rows, columns = table_of_pieces(drive)
    before = [*_phase_in_time(drive, rows, columns), *waveform_expressions(drive)]
    rates = computation_of(field.rates).after(before)
    loads = {
        name: computation_of(program).after(before)
        for name, program in _load_programs(field, drive).items()
    }
    needed = {name for one in (rates, *loads.values()) for name in one.input_names}
    known_until = drive.known_until
    return WrittenEquations(
        description=description,
        state=state,
        parameters={name: value for name, value in values.items() if name in needed},
        unused={name: value for name, value in values.items() if name not in needed},
        rates=rates,
        loads=loads,
        rates_over_period=_rates_over_period(field, drive),
        period=drive.period,
        period_field=drive.period_field_name,
        pieces=tuple(rows) if needed & {*columns} else (),
        piece_columns=columns,
        # A spline through samples is smooth enough to be followed across them.
        breaks=() if math.isfinite(known_until) else tuple(row[0] for row in rows[1:]),
        known_until=known_until,
    )


def _rates_over_period(field: Field, drive: Drive) -> Computation | None:
    """Rates times the period of the load: those by the phase, which runs on without jumps."""
    if drive.period is None:
        return None
    before: list[tuple[str, Expression]] = [("drive.period", period_expression(drive))]
    for name, one in zip(drive.waveform_names, drive.waveforms, strict=True):
        # The load is the same where both waveforms of a squared sine have changed their sign.
        before.append((name, (one.function, ("mul", one.span * one.repeats, PHASE))))
    rates = computation_of(field.rates)
    scaled = tuple(("mul", "drive.period", rate) for rate in rates.outputs)
    return Computation(rates.assignments, scaled).after(before)


def _load_programs(field: Field, drive: Drive) -> dict[str, Program]:
    """The loads themselves, as the drive gives them."""
    return {
        name: program_of_values(field.input_names, partial(_load, field, drive, name))
        for name in field.load_names
    }


def _load(field: Field, drive: Drive, name: str, values: Mapping[str, Any], functions: Any) -> Any:
    waveforms = {waveform: values[waveform] for waveform in field.waveform_names}
    return drive.loads_by_name(values, waveforms, values[PHASE], functions)[name]


def table_of_pieces(drive: Drive) -> tuple[list[tuple[float, ...]], tuple[str, ...]]:
    """The table of pieces of a load without a period, and the names of its columns.

    The last piece goes on for ever: its law holds beyond its length.
    """
    columns = (PIECE_START, PIECE_LENGTH, *drive.piece_parameter_names)
    if drive.period is not None:
        return [], columns
    # Long enough that the last piece has a length, by which its fraction is counted.
    end = min(2.0 * drive.last_change + 1.0, drive.known_until, sys.float_info.max)
    with np.errstate(all="ignore"):
        schedule = drive.load_schedule({}, np.array([end]))
    lengths = schedule.piece_lengths[:, 0]
    starts = np.concatenate([[0.0], np.cumsum(lengths[:-1])])
    parameters = [schedule.piece_parameters[name][:, 0] for name in drive.piece_parameter_names]
    rows = [tuple(map(float, row)) for row in zip(starts, lengths, *parameters, strict=True)]
    if math.isfinite(drive.known_until):
        end = drive.known_until * (1.0 + _RELATIVE_END_ROUNDING)
        rows.append((end, 1.0, *(math.nan for _ in parameters)))
    return rows, columns


def _phase_in_time(
    drive: Drive, rows: list[tuple[float, ...]], columns: tuple[str, ...]
) -> list[tuple[str, Expression]]:
    """The phase of the drive in [0, 1), or the fraction of a piece, from the time t."""
    if drive.period is not None:
        turns = ("drive.turns", ("div", TIME, "drive.period"))
        phase = (PHASE, ("sub", "drive.turns", ("floor", "drive.turns")))
        return [("drive.period", period_expression(drive)), turns, phase]
    fraction: Expression = ("div", ("sub", TIME, PIECE_START), PIECE_LENGTH)
    single: list[tuple[str, Expression]] = []
    if len(rows) == 1:
        single = list(zip(columns, rows[0], strict=True))
        fraction = TIME if rows[0][:2] == (0.0, 1.0) else fraction
    return [*single, (PHASE, fraction)]


def period_expression(drive: Drive) -> Expression:
    """The period in terms of the frequency, so that it follows a change of that."""
    period, name = drive.period, drive.period_field_name
    assert period is not None
    if name is None:
        return period
    angle = period * drive.parameter_values()[name]
    rounded = round(angle / math.pi, _DIGITS_OF_MULTIPLE) * math.pi
    # The angle of a period is a multiple of pi, but for the rounding of the product.
    return ("div", rounded if math.isclose(angle, rounded, rel_tol=1e-14) else angle, name)


def waveform_expressions(drive: Drive) -> list[tuple[str, Expression]]:
    """The waveforms of the load from the phase."""
    found: list[tuple[str, Expression]] = []
    for name, one in zip(drive.waveform_names, drive.waveforms, strict=True):
        fraction: Expression = PHASE
        if one.repeats != 1.0:
            repeated = f"drive.repeats_{one.repeats:g}"
            found.append((repeated, ("mul", one.repeats, PHASE)))
            fraction = ("sub", repeated, ("floor", repeated))
        found.append((name, (one.function, ("mul", one.span, fraction))))
    return list(dict(found).items())
