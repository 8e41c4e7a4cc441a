"""From an ensemble to what the integrators take."""

from __future__ import annotations

import numpy as np

from remanent._load_schedule import LoadSchedule
from remanent._typing import FloatArray
from remanent.integrate.ensemble.problem import Problem
from remanent.studies.ensemble.ensemble import Ensemble


def initial_value_problem(ens: Ensemble, duration: FloatArray) -> Problem:
    """The trajectories of an ensemble, each lasting its `duration`, array (trajectory,).

    Invalid trajectories take harmless values: nothing is integrated there, but whatever works
    on whole arrays need not make exceptions for them.
    """
    defaults = {**ens.system.parameter_values(), **ens.drive.parameter_values()}
    durations = np.where(ens.is_invalid, 1.0, duration)
    values = {
        name: np.where(ens.is_invalid, defaults[name], column)
        for name, column in ens.parameter_values.items()
    }
    with np.errstate(all="ignore"):
        load_schedule = ens.drive.load_schedule(values, durations)
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
