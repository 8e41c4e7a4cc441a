"""The right-hand side of the equations of motion as a function of time and state."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from remanent._checks import as_float_array
from remanent._errors import InputError
from remanent._load_schedule import LoadSchedule
from remanent._typing import ArrayLike, FloatArray, IntArray
from remanent.codegen.reference import evaluate_rates
from remanent.integrate.ensemble.problem import Problem
from remanent.models.system import System
from remanent.studies.ensemble.checks import DriveArgument
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.ensemble.problem import initial_value_problem

#: Why rates take states.
_STATE_REASON = "The rates of a state are those of its variables."
#: Why rates take times.
_TIME_REASON = "The load acts at a time."


@dataclass(frozen=True)
class Rates:
    """The rates of the state variables of a system under its load, y' = rates(t, y).

    Attributes
    ----------
    state_names : tuple of str
        Variables of a state, in order.
    """

    state_names: tuple[str, ...]
    _ensemble: Ensemble = field(repr=False)

    def __call__(self, t: ArrayLike, y: ArrayLike) -> FloatArray:
        """Rates of the state variables, array (..., state).

        Parameters
        ----------
        t : float or array (...)
            Time, tau.
        y : array (..., state)
            State.  Where no motion can be, as at a stretch of 0, rates are not finite.
        """
        names = ", ".join(self.state_names)
        remedy = f"Pass an array whose last axis is {names}."
        y = as_float_array("y", y, what="numbers", why=_STATE_REASON, fix=remedy)
        count = len(self.state_names)
        if y.ndim < 1 or y.shape[-1] != count:
            raise InputError(
                "y",
                must=f"have {count} numbers along the last axis",
                got=f"an array of shape {y.shape}",
                why=_STATE_REASON,
                fix=remedy,
            )
        times = self._require_times(t, y.shape[:-1])
        states = y.reshape(-1, count)
        if not len(states):
            return y
        problem = self._problem_until(float(times.max()))
        piece, phase = _places(problem.load_schedule, times)
        parameters = np.tile(problem.parameters, (len(states), 1))
        for name, values in problem.load_schedule.piece_parameters.items():
            column = problem.field.parameter_names.index(name)
            parameters[:, column] = np.broadcast_to(values, (len(values), 1))[piece, 0]
        with np.errstate(all="ignore"):
            rates_of_states = evaluate_rates(
                problem.field,
                phase,
                states,
                parameters,
                problem.load_schedule.waveforms_at_phase(phase),
            )
        return rates_of_states.reshape(y.shape)

    def _problem_until(self, time: float) -> Problem:
        """The pieces of the load up to a time at least."""
        first = self._first_problem
        if first.load_schedule.periodic or time <= 1.0:
            return first
        # A little longer, so that the piece that begins at this time is there.
        return initial_value_problem(self._ensemble, np.nextafter([time], np.inf))

    @cached_property
    def _first_problem(self) -> Problem:
        return initial_value_problem(self._ensemble, np.ones(1))

    def _require_times(self, t: ArrayLike, shape: tuple[int, ...]) -> FloatArray:
        """Times as one row, one for each state."""
        remedy = "Pass times from 0 on, one for all states or one for each."
        times = as_float_array(
            "t", t, what="finite times", why=_TIME_REASON, fix=remedy, finite=True
        )
        try:
            row = np.broadcast_to(times, shape).reshape(-1)
        except ValueError:
            raise InputError(
                "t",
                must=f"be one time or have the shape {shape} of the states",
                got=f"an array of shape {times.shape}",
                why=_TIME_REASON,
                fix=remedy,
            ) from None
        if (row < 0.0).any():
            raise InputError(
                "t",
                must="not be below 0",
                got=float(row.min()),
                why="Loads are given from time 0 on.",
                fix=remedy,
            )
        return row


def rates(system: System, drive: DriveArgument) -> Rates:
    """Make the right-hand side of the equations of motion a function of time and state.

    It is what the compiled kernels integrate, evaluated with NumPy, so that other integrators
    can be set beside those of the package.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        Its load.

    Returns
    -------
    Rates
        A function ``rates(t, y)`` of the time, tau, and of a state, array (..., state), as
        integrators of SciPy take it.  Its attribute ``state_names`` tells the order of the
        variables.

    Raises
    ------
    InputError
        A bad argument.

    See Also
    --------
    equations : The same as formulas.
    period_map : The flow over periods of the drive, with its Jacobian.

    Notes
    -----
    At a jump of the load, the load after it is taken: an integrator is to be started anew there.

    Examples
    --------
    >>> import remanent as rm
    >>> from scipy.integrate import solve_ivp
    >>> rates = rm.rates(rm.Actuator(), rm.SineSquared(0.4, 1.25))
    >>> rates.state_names
    ('stretch', 'stretch_rate')
    >>> solution = solve_ivp(rates, (0.0, 5.0), [1.0, 0.0], rtol=1e-10, atol=1e-12)
    >>> motion = rm.simulate(rm.Actuator(), rm.SineSquared(0.4, 1.25), duration=5.0)
    >>> bool(abs(solution.y[0, -1] - motion.stretch[-1]) < 1e-8)
    True
    """
    ens = lay_out_ensemble(system, drive)
    return Rates(ens.vector_field.state_names, ens)


def _places(load_schedule: LoadSchedule, times: FloatArray) -> tuple[IntArray, FloatArray]:
    """The piece that holds each time, and the phase or the fraction of the piece there."""
    lengths = load_schedule.piece_lengths[:, 0]
    if load_schedule.periodic:
        return np.zeros(times.size, dtype=np.int64), np.mod(times / lengths[0], 1.0)
    ends = np.cumsum(lengths)
    piece = np.minimum(np.searchsorted(ends, times, side="right"), len(lengths) - 1)
    begin = np.concatenate([[0.0], ends[:-1]])[piece]
    return piece, (times - begin) / np.where(lengths[piece] > 0.0, lengths[piece], 1.0)
