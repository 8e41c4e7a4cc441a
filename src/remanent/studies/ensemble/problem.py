"""From an ensemble to what the integrators take."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from remanent._checks import shortened_repr
from remanent._errors import InputError
from remanent._load_schedule import LoadSchedule
from remanent._typing import FloatArray
from remanent.integrate.ensemble.problem import Problem
from remanent.models.drives.base import Drive
from remanent.studies.ensemble.ensemble import Ensemble


def initial_value_problem(ens: Ensemble, duration: FloatArray) -> Problem:
    """The trajectories of an ensemble, each lasting its `duration`, array (trajectory,).

    Invalid trajectories take harmless values: nothing is integrated there, but whatever works
    on whole arrays need not make exceptions for them.
    """
    defaults = {**ens.system.parameters(), **ens.drive.parameters()}
    durations = np.where(ens.is_invalid, 1.0, duration)
    values = {
        name: np.where(ens.is_invalid, defaults[name], column)
        for name, column in ens.parameter_values.items()
    }
    load_schedule = _load_schedule(ens.drive, values, durations)
    lengths = np.broadcast_to(
        load_schedule.piece_lengths, (len(load_schedule.piece_lengths), ens.trajectory_count)
    )
    load_schedule = LoadSchedule(
        lengths,
        load_schedule.periodic,
        load_schedule.piece_parameters,
        load_schedule.waveforms_at_phase,
    )
    # Parameters that the load schedule gives piece by piece have no value of their own.
    columns = [
        values.get(name, np.zeros(ens.trajectory_count))
        for name in ens.vector_field.parameter_names
    ]
    parameters = np.column_stack(columns) if columns else np.zeros((ens.trajectory_count, 0))
    return Problem(
        ens.vector_field, load_schedule, parameters, ens.initial_states, durations, ens.is_invalid
    )


def _load_schedule(drive: Drive, values: Mapping[str, FloatArray], end: FloatArray) -> LoadSchedule:
    try:
        with np.errstate(all="ignore"):
            return drive.load_schedule(values, end)
    except InputError:
        raise
    except ValueError as error:  # from the interpolation of samples
        raise InputError(
            "drive",
            must="have loads that a spline can pass through in floating point",
            got=shortened_repr(drive),
            why=f"Interpolation failed: {error}",
            fix="Use loads and times of ordinary size.",
        ) from error
