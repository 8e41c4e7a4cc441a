"""Where the energy of a motion comes from and goes to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import xarray as xr

from remanent._field import Role
from remanent._typing import ArrayLike, FloatArray
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import ERROR_SHARE_IN_FUNCTIONS, Problem, Request
from remanent.integrate.variations import field_with_integrals
from remanent.models.system import System
from remanent.studies.ensemble.checks import DriveArgument, require_energy, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.durations import require_exactly_one_argument
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.observables import (
    blank_beyond_horizon,
    evaluate_observable,
    largest_observable_error,
)
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.ensemble.quantities import without_unit
from remanent.studies.ensemble.time_grid import time_grid

#: Powers that are integrated along a motion, and the name of the integral.
_WORK_OF_POWER = {"drive_power": "drive_work", "dissipated_power": "dissipated_energy"}
#: The same of a heat balance.
_HEAT_INTEGRAL_OF_OBSERVABLE = {
    "heat_flow": "heat_given_off",
    "entropy_flow": "entropy_given_off",
    "entropy_production": "entropy_produced",
}


def energy_balance(
    system: System,
    drive: DriveArgument,
    *,
    duration: float | None = None,
    periods: int | None = None,
    times: ArrayLike | None = None,
    initial: ArrayLike | None = None,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Follow the work of the drive and what is dissipated, beside the energy of the block.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        The magnetic load on it.
    duration : float, str or quantity, optional
        Length of the run in units of tau; with a unit, ``"60 ms"``, where
        the actuator has SI sizes.
    periods : int, optional
        Length of the run in smallest periods of the load.
    times : array_like (time,), optional
        When the balance is taken: tau, increasing, not negative.  Exactly one of
        `duration`, `periods` and `times` must be given.
    initial : array_like (2,), (4,) or (state,), optional
        State to start from; rest by default, as for :func:`remanent.simulate`.
    over : mapping of str to array_like or DataArray, optional
        Values of numeric fields; they become dimensions of the result.
    tolerance : float
        Largest error of the state and of the integrals that is allowed, at any of the times;
        absolute.
    progress : bool or callable, optional
        True draws a bar; a function is called with the share that is done.

    Returns
    -------
    xarray.Dataset
        Against ``time``, per reference volume and μ: ``stored_energy`` (kinetic, elastic
        and of the dead loads, without that in the field), ``drive_work`` and
        ``dissipated_energy`` since τ = 0, ``balance`` = change of the stored energy − work
        + dissipation, which is zero but for the error; ``mean_thickness_stretch``, the
        average since τ = 0.  With a heat balance ``stored_energy`` is the internal energy
        and the kinetic, and the balance has ``heat_given_off`` to the surroundings in place
        of the dissipation, which stays in the body; in units of μ/T0 also its ``entropy``,
        ``entropy_produced`` within and by the exchange, ``entropy_given_off``, and
        ``entropy_balance`` = change of the entropy − production + what was given off.
        Per trajectory the largest error of each over the times, under its name with
        ``_error``; ``error``, the largest of the state and of the integrals, from which they
        follow; ``horizon``, ``status``.

    Raises
    ------
    InputError
        A bad argument; the message says which and what to do.

    See Also
    --------
    simulate : The motion itself.
    cycle_losses : The same work and dissipation, period by period.

    Notes
    -----
    The integrals are advanced with the state, by the same steps and under the same error
    bound; nothing is summed from samples.  Work and dissipation per cycle are differences
    over a drive period.

    The field's energy per reference volume is that of the magnet in the load, U_m = −m λ₃ with
    λ₃ the thickness stretch (its factor of temperature included).  It is no part of
    ``stored_energy``, and the power of ``drive_work`` is −∂U_m/∂λ₃ λ₃' where the temperature is
    held.  Where the temperature T of the body is a state, with θ = T/T₀, a magnet whose
    remanence depends on it, m = m₀ f(θ), has the free energy Ψ_m = −m₀ f λ₃ and the internal
    energy e_m = −m₀ (f − θ f') λ₃: the block gives e_m, not Ψ_m, to the field.
    ``drive_work`` is then the integral of ∂Ψ_m/∂m₀ m₀' − e_m', in which the load's own change
    cancels but for −θ f' λ₃ m₀'.

    Examples
    --------
    >>> import remanent as rm
    >>> damped = rm.Actuator(dissipation=rm.Rayleigh(0.1))
    >>> ds = rm.energy_balance(damped, rm.SineSquared(0.4, 1.25), periods=50)
    >>> bool(abs(ds.balance).max() < 1e-8)
    True
    """
    require_exactly_one_argument(duration=duration, periods=periods, times=times)
    tolerance = require_tolerance(tolerance, "the global error of the state and of the integrals")
    report = as_progress(progress)
    ens = lay_out_ensemble(system, drive, over, initial)
    duration = without_unit("duration", duration, "time", system)
    grid = time_grid(ens, duration, periods, times)
    require_energy(ens)
    warms = bool(ens.vector_field.indices_of_roles(Role.TEMPERATURE))
    observable = ens.vector_field.observable_name
    integrals = {observable: f"mean_{observable}", **_WORK_OF_POWER}
    integrals |= _HEAT_INTEGRAL_OF_OBSERVABLE if warms else {}
    problem = _append_integrals(initial_value_problem(ens, grid.durations), integrals)
    request = Request(times=grid.times)
    outcome = integrate(problem, request, tolerance=tolerance, progress=report)
    assert outcome.states is not None
    states = blank_beyond_horizon(outcome.states, grid.times, outcome)
    sums = np.moveaxis(states[:, :, -len(integrals) :], 2, 0)
    columns = _balance_variables(
        problem, grid.times, states, dict(zip(integrals.values(), sums, strict=True)), warms
    )
    variables: dict[str, PerTrajectoryArray] = {
        name: ((grid.time_dimension,), values) for name, values in columns.items()
    }
    variables |= _balance_errors(problem, grid.times, states, outcome.error, integrals, warms)
    return to_dataset(
        ens,
        variables,
        coords={"time": grid.time_coordinate(ens)},
        outcome=outcome,
        tolerance=tolerance,
        duration=duration,
        periods=periods,
    )


def _append_integrals(problem: Problem, integrals: dict[str, str]) -> Problem:
    """The problem with integrals of observables as further state variables, from 0."""
    start = np.pad(problem.initial_states, ((0, 0), (0, len(integrals))))
    return replace(
        problem, field=field_with_integrals(problem.field, tuple(integrals)), initial_states=start
    )


def _balance_errors(
    problem: Problem,
    times: FloatArray,
    states: FloatArray,
    error: FloatArray,
    integrals: dict[str, str],
    warms: bool,
) -> dict[str, FloatArray]:
    """Errors of the integrals and the energies, the largest over the times, (trajectory,)."""
    observable = problem.field.observable_name
    errors = {
        name: largest_observable_error(problem, name, times, states, error)
        for name in (observable, "stored_energy", *(("entropy",) if warms else ()))
    }
    error = ERROR_SHARE_IN_FUNCTIONS * error
    sums = dict.fromkeys(integrals.values(), error)
    # The mean over a short time has the error of the observable, and a sum's over the time.
    at_once, last = errors.pop(observable), times[:, -1]
    with np.errstate(divide="ignore", invalid="ignore"):
        sums[f"mean_{observable}"] = at_once + np.where(last > 0.0, error / last, 0.0)
    balance = errors["stored_energy"] + 2.0 * error  # of the work and the outflow
    totals = {**sums, **errors, "balance": balance}
    if warms:
        totals["entropy_balance"] = errors["entropy"] + 2.0 * error
    return {f"{name}_error": values for name, values in totals.items()}


def _balance_variables(
    problem: Problem,
    times: FloatArray,
    states: FloatArray,
    integrals: dict[str, FloatArray],
    warms: bool,
) -> dict[str, FloatArray]:
    """The integrals, each array (trajectory, time), with the energies that they balance."""
    columns = dict(integrals)

    def gain(name: str) -> FloatArray:
        """What a function of the state has gained since the start."""
        before = evaluate_observable(
            problem, name, np.zeros((len(times), 1)), problem.initial_states[:, None]
        )
        return evaluate_observable(problem, name, times, states) - before

    observable = problem.field.observable_name
    at_once = evaluate_observable(problem, observable, times, states)  # the mean over no time
    with np.errstate(all="ignore"):
        mean = columns[f"mean_{observable}"] / times
    columns[f"mean_{observable}"] = np.where(times > 0.0, mean, at_once)
    columns["stored_energy"] = evaluate_observable(problem, "stored_energy", times, states)
    outflow = columns["heat_given_off" if warms else "dissipated_energy"]
    columns["balance"] = gain("stored_energy") - columns["drive_work"] + outflow
    if warms:
        columns["entropy"] = evaluate_observable(problem, "entropy", times, states)
        inner = gain("entropy") - columns["entropy_produced"]
        columns["entropy_balance"] = inner + columns["entropy_given_off"]
    return columns
