"""What follows a command of steps: rise, overshoot, settling, residual vibration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import xarray as xr

from remanent._checks import positive, require_real
from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray
from remanent.analysis import shaping, steps
from remanent.codegen.field import field_for
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Outcome, Problem, Request
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.models.drives.piecewise import Steps
from remanent.models.drives.waves import Constant
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectory, to_dataset
from remanent.studies.ensemble.ensemble import Over
from remanent.studies.ensemble.observables import observe
from remanent.studies.ensemble.physical_scales import Physical, physical
from remanent.studies.statics._static_state import Body

_BAND = positive("It is a share of the change of thickness stretch.", "Pass 0.02.")
_TIME = positive("A run takes a positive time.", "Pass a time in units of tau.")
#: Half periods after the last step that are followed by default, and samples in each.
_FOLLOWED, _SAMPLES = 20.0, 24
_RISE = (0.1, 0.9)


def step_response(
    system: Actuator,
    drive: Drive,
    *,
    duration: float | None = None,
    band: float = 0.02,
    initial: ArrayLike | None = None,
    over: Over | None = None,
    tolerance: float = 1e-9,
) -> xr.Dataset:
    """Measure how the thickness stretch answers a command of steps.

    Parameters
    ----------
    system
        What moves.
    drive
        :class:`remanent.Steps`, or :class:`remanent.Constant`, one step at τ = 0.
    duration
        Length of the run, tau; by default ten natural periods after the last step.
    band
        Share of the change within which the answer counts as settled.
    initial, tolerance
        As for :func:`remanent.simulate`.
    over
        Values of numeric fields, and of ``shear_modulus``, ``density`` and ``remanence``
        over their nominal values, while the command, the dead loads and the viscosities stay
        as they are in SI; they become dimensions of the result.

    Returns
    -------
    xarray.Dataset
        ``final``, the thickness stretch x∞ of rest under the last load;
        ``residual_energy`` above that rest right after the last step, per reference volume
        over μ, and ``residual_amplitude``, that of the vibration of thickness stretch it
        makes; ``rise_time`` from 10 to 90 % of the change x∞ − x(0), ``settling_time``, the
        last instant outside the band, NaN if it ends outside; ``farthest``, the farthest
        thickness stretch in the direction of the change, and ``overshoot`` = (farthest −
        x∞)/change, at least 0; NaN without a change.  All with errors; times
        in the actuator's unit of time; ``error``, ``horizon``, ``status``.

    Raises
    ------
    InputError
        A bad argument, or a last load without a state of rest near the start.

    Notes
    -----
    residual amplitude = √(2 E_r/k), with k = dm/dx along the states of rest: for a small
    vibration its amplitude, for any other the static deflection of the same energy.  Passages
    of levels are bracketed between 24 samples per half period and refined on the dense output.

    Examples
    --------
    >>> import remanent as rm
    >>> command = rm.shape_command(rm.Actuator(), 1.5)
    >>> shaped = rm.step_response(rm.Actuator(), command)
    >>> plain = rm.step_response(rm.Actuator(), rm.Constant(command.loads[-1]))
    >>> bool(shaped.residual_amplitude < 1e-6 * plain.residual_amplitude)
    True
    """
    require_tolerance(tolerance)
    band = require_real("band", band, _BAND)
    if not isinstance(drive, Steps | Constant):
        raise InputError(
            "drive", "be rm.Steps or rm.Constant", repr(drive),
            "A response to steps ends under a load that stays.", "Pass rm.shape_command(...).",
        )  # fmt: skip
    many = physical(system, drive, over, initial)
    ens = many.ensemble
    rests = _rests(many)
    half = _half_periods(rests)
    last = _last(many)
    if duration is None:
        duration = float(np.nanmax((last + _FOLLOWED * half) / many.time))
    length = require_real("duration", duration, _TIME)
    asked = many.problem(np.full(ens.count, length))
    answer = _Answer(asked, tolerance)
    found = _residuals(rests, answer.states(last[:, None])[:, 0], answer.outcome.error)
    start = answer(np.zeros((ens.count, 1)))[0][:, 0]
    spacing = float(np.nanmin(half)) / _SAMPLES
    found |= _metrics(answer, many, start, found["final"], spacing, band)
    variables: dict[str, PerTrajectory] = {
        name: np.where(ens.invalid, np.nan, values) for name, values in found.items()
    }
    return to_dataset(
        ens, variables, outcome=answer.outcome, tolerance=tolerance, duration=length, band=band
    )


class _Answer:
    """The motion of every trajectory: its extremes, and states at any instant."""

    def __init__(self, asked: Problem, tolerance: float) -> None:
        self.asked, self.tolerance = asked, tolerance
        self.outcome: Outcome = integrate(asked, Request(extremes=True), tolerance=tolerance)

    def states(self, times: FloatArray) -> FloatArray:
        """States (trajectory, time, state) at ascending times (trajectory, time)."""
        outcome = integrate(self.asked, Request(times=times), tolerance=self.tolerance)
        assert outcome.states is not None
        return outcome.states

    def __call__(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Thickness stretch and its rate at times (trajectory, time) in any order."""
        order = np.argsort(times, axis=1)
        ascending = np.take_along_axis(times, order, axis=1)
        states, back = self.states(ascending), np.argsort(order, axis=1)
        names = ("thickness_stretch", "thickness_stretch_rate")
        x, v = (observe(self.asked, name, ascending, states) for name in names)
        return np.take_along_axis(x, back, axis=1), np.take_along_axis(v, back, axis=1)


def _last(many: Physical) -> FloatArray:
    """Own time of the last step of each trajectory."""
    drive = many.ensemble.drive
    return many.time * (float(drive.times[-1]) if isinstance(drive, Steps) else 0.0)


def _rests(many: Physical) -> list[Body | None]:
    """Every trajectory's state of rest under the last load."""
    ens = many.ensemble
    drive = ens.drive
    loads = many.load * float(drive.loads[-1]) if isinstance(drive, Steps) else ens.values["m"]
    field = field_for(ens.system, Constant(0.0))
    found: list[Body | None] = []
    for k in np.arange(ens.count):
        values = {name: v[k] for name, v in ens.values.items()} | {"m": loads[k]}
        row = np.array([float(values[name]) for name in field.parameters])
        found.append(None if ens.invalid[k] else Body(field, row, ens.initial[k]).at_rest())
    if all(body is None for body in found):
        raise InputError(
            "drive", "end under a load with a state of rest near the start", loads.tolist(),
            "What is left of a vibration is counted from there.", "Pass a smaller last load.",
        )  # fmt: skip
    return found


def _half_periods(rests: Sequence[Body | None]) -> FloatArray:
    """Half the longest natural period at every rest."""
    return np.array(
        [np.nan if b is None else shaping.interval(shaping.poles(*b.linear())) for b in rests]
    )


def _residuals(
    rests: Sequence[Body | None], states: FloatArray, error: FloatArray
) -> dict[str, FloatArray]:
    """Rest after the last step, and what is left of motion right after it."""
    names = ("final", "residual_energy", "residual_amplitude", "residual_amplitude_error")
    table = np.full((len(rests), len(names)), np.nan)
    for k, body in enumerate(rests):
        if body is not None and np.isfinite(states[k]).all():
            stiffness = body.stiffness()
            energy = body.energy_above(states[k])
            wrong = body.energy_above(body.state + error[k])
            amplitudes = np.sqrt(2.0 * np.array([max(energy, 0.0), wrong]) / stiffness)
            table[k] = [body.thickness(), energy, *amplitudes]
    return dict(zip(names, table.T, strict=True))


def _metrics(
    answer: _Answer,
    many: Physical,
    start: FloatArray,
    final: FloatArray,
    spacing: float,
    band: float,
) -> dict[str, FloatArray]:
    """Rise, settling, peak and overshoot, times in the actuator's unit."""
    change, end = np.where(final == start, np.nan, final - start), answer.asked.duration
    grid = np.linspace(0.0, 1.0, int(np.ceil(end.max() / spacing)) + 1) * end[:, None]
    with np.errstate(all="ignore"):
        share = (answer(grid)[0] - start[:, None]) / change[:, None]
    outside = steps.last_outside(share, 1.0 - band, 1.0 + band)
    before = np.stack([*(steps.first_above(share, s) - 1 for s in _RISE), outside], axis=1)
    above = share[np.arange(len(share)), outside] > 1.0
    levels = np.stack(
        [*(np.full(len(share), s) for s in _RISE), 1.0 + np.where(above, band, -band)]
    )
    found = steps.passages(answer, grid, before, start[:, None] + levels.T * change[:, None])
    wrong = answer.outcome.error[:, None] / np.abs(found.rate) / many.time[:, None]
    t = found.time / many.time[:, None]
    rising = change > 0.0
    peak = np.where(rising, answer.outcome.maximum, answer.outcome.minimum)
    return {
        "rise_time": t[:, 1] - t[:, 0],
        "rise_time_error": wrong[:, 0] + wrong[:, 1],
        "settling_time": np.where(outside < 0, 0.0, t[:, 2]),
        "settling_time_error": np.where(outside < 0, 0.0, wrong[:, 2]),
        "farthest": peak,
        "farthest_error": answer.outcome.error,
        "overshoot": np.maximum((peak - final) / change, 0.0),
        "overshoot_error": answer.outcome.error / np.abs(change),
    }
