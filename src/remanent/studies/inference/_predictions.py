"""What the model predicts of the values in a table of measurements."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray
from remanent.analysis.inference.fitting import Observations
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Outcome, Problem, Request
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.durations import trajectory_durations
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.observables import blank_beyond_horizon, evaluate_observable
from remanent.studies.ensemble.problem import initial_value_problem

#: Variables of a table that say how good it is, and are not compared.
_UNCOMPARED_VARIABLES = frozenset({"crossings", "balance", "status", "horizon", "error"})


@dataclass(frozen=True)
class Measurements:
    """Measured values, one variable after the other.

    Attributes
    ----------
    table : xarray.Dataset
        Along ``time`` or ``omega``.
    """

    table: xr.Dataset

    @property
    def dimension_name(self) -> str:
        """``omega`` for a response, ``time`` for a history."""
        return "omega" if "omega" in self.table.dims else "time"

    @property
    def coordinate_values(self) -> FloatArray:
        """Times or frequencies, array (point,)."""
        return np.asarray(self.table[self.dimension_name].values)

    @property
    def compared_variables(self) -> list[str]:
        """Names of the variables that are compared."""
        names = [
            str(n) for n in self.table.data_vars if self.table[n].dims == (self.dimension_name,)
        ]
        return [n for n in names if not n.endswith("_error") and n not in _UNCOMPARED_VARIABLES]

    def observations(self) -> Observations:
        """The values with their standard deviations.

        Deviations count only where every variable has them: else there is no common unit in
        which one variable's residuals could be weighed against another's.
        """
        if self.dimension_name not in self.table.dims or not self.compared_variables:
            raise InputError(
                "data",
                must="hold variables along `time` or `omega`",
                got=list(self.table.sizes),
                why="They are compared with a history or a response.",
                fix="Use rm.read_measurements(...).",
            )
        values = np.concatenate([self.table[name].values for name in self.compared_variables])
        errors = [f"{name}_error" for name in self.compared_variables]
        has_deviations = all(error in self.table for error in errors)
        deviation = np.ones(values.size)
        if has_deviations:
            columns = [
                np.broadcast_to(self.table[error], self.coordinate_values.size) for error in errors
            ]
            deviation = np.concatenate(columns)
        bad = ~np.isfinite(values) | ~(deviation > 0.0)
        if bad.any():
            raise InputError(
                "data",
                must="be finite, with deviations above 0",
                got=f"{values[bad][0]} with deviation {deviation[bad][0]}",
                why="Each value counts by its deviation.",
                fix="Leave such rows out.",
            )
        return Observations(values, deviation, has_deviations)

    def observation_labels(self) -> dict[str, Labelled]:
        """What each value is, and where, along ``observation``."""
        return {
            "quantity": (
                ("observation",),
                np.repeat(self.compared_variables, self.coordinate_values.size),
            ),
            self.dimension_name: (
                ("observation",),
                np.tile(self.coordinate_values, len(self.compared_variables)),
            ),
        }


@dataclass(frozen=True)
class ResponseWindow:
    """The part of each run whose extremes a response is made of.

    Attributes
    ----------
    run_duration : float or None
        Length of the run, τ.
    run_periods : int or None
        Its length in drive periods, in place of `duration`.
    discarded_time : float
        Time at the beginning, τ, that does not count.
    """

    run_duration: float | None
    run_periods: int | None
    discarded_time: float

    def integrate_extremes(self, ens: Ensemble, tolerance: float) -> Outcome:
        """The extremes of every trajectory within the window."""
        duration = self.run_duration if self.run_periods is None else None
        durations = trajectory_durations(ens, duration, self.run_periods)
        request = Request(
            wants_extremes=True,
            extremes_begin=np.full(ens.trajectory_count, self.discarded_time),
        )
        return integrate(initial_value_problem(ens, durations), request, tolerance=tolerance)


@dataclass(frozen=True)
class MeasurementPredictor:
    """Predictions of measured values, for many candidates at once.

    Attributes
    ----------
    system : System
    drive : Drive
    parameter_names : tuple of str
        Of the parameters that differ between candidates.
    initial : array (state,) or None
    measurements : Measurements
    response_window : ResponseWindow
        Of a response.
    motion_tolerance : float
        Of the computed motion.
    """

    system: System
    drive: Drive
    parameter_names: tuple[str, ...]
    initial: ArrayLike | None
    measurements: Measurements
    response_window: ResponseWindow
    motion_tolerance: float

    def __call__(self, candidates: FloatArray) -> FloatArray:
        """Predictions of candidates (candidate, parameter), array (candidate, datum).

        NaN where the error bound is not met.
        """
        over = {
            name: xr.DataArray(column, dims="candidate")
            for name, column in zip(self.parameter_names, candidates.T, strict=True)
        }
        predict = (
            self._predict_history
            if self.measurements.dimension_name == "time"
            else self._predict_response
        )
        columns = predict(over)
        return np.concatenate(
            [columns[name] for name in self.measurements.compared_variables], axis=1
        )

    def _predict_history(self, over: Mapping[str, xr.DataArray]) -> dict[str, FloatArray]:
        ens = lay_out_ensemble(self.system, self.drive, over, self.initial, tells=False)
        measured = self.measurements.coordinate_values
        end = max(float(measured[-1]), np.finfo(float).tiny)
        problem = initial_value_problem(ens, np.full(ens.trajectory_count, end))
        times = np.broadcast_to(measured, (ens.trajectory_count, measured.size))
        outcome = integrate(problem, Request(times=times), tolerance=self.motion_tolerance)
        assert outcome.states is not None
        states = blank_beyond_horizon(outcome.states, times, outcome)
        return {
            name: _variable_history(problem, name, times, states)
            for name in self.measurements.compared_variables
        }

    def _predict_response(self, over: Mapping[str, xr.DataArray]) -> dict[str, FloatArray]:
        omega = xr.DataArray(self.measurements.coordinate_values, dims="reading")
        ens = lay_out_ensemble(
            self.system, self.drive, {**over, "omega": omega}, self.initial, tells=False
        )
        outcome = self.response_window.integrate_extremes(ens, self.motion_tolerance)
        low, high = (ens.reshape_to_dims(v) for v in (outcome.minimum, outcome.maximum))
        return {"maximum": high, "minimum": low, "amplitude": 0.5 * (high - low)}


def _variable_history(
    problem: Problem, name: str, times: FloatArray, states: FloatArray
) -> FloatArray:
    """A state variable or an observable, array (trajectory, time)."""
    field = problem.field
    if name in field.state_names:
        return states[:, :, field.state_names.index(name)]
    if name not in field.observables:
        raise InputError(
            "data",
            must=f"hold variables among {', '.join([*field.state_names, *field.observables])}",
            got=name,
            why="They are what a history has.",
            fix="Name the columns so, by rm.read_measurements(names=...).",
        )
    return evaluate_observable(problem, name, times, states)
