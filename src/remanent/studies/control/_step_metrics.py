"""Rise, settling, overshoot and residual vibration of motions that follow a command of steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from remanent._typing import FloatArray
from remanent.analysis.control import settling
from remanent.integrate.ensemble.ensemble import integrate
from remanent.integrate.ensemble.problem import Outcome, Problem, Request
from remanent.studies.ensemble.observables import evaluate_observable
from remanent.studies.statics._static_state import StaticState

#: Shares of the change between which the rise is timed.
_RISE_SHARES = (0.1, 0.9)


@dataclass(frozen=True)
class StepMotion:
    """The motion of every trajectory: its extremes, and states at any instant.

    Attributes
    ----------
    problem : Problem
    tolerance : float
    outcome : Outcome
        With the extremes of the thickness stretch.
    """

    problem: Problem
    tolerance: float
    outcome: Outcome

    @classmethod
    def from_problem(cls, problem: Problem, tolerance: float) -> StepMotion:
        """Integrate the motion once for its extremes."""
        return cls(
            problem,
            tolerance,
            integrate(problem, Request(wants_extremes=True), tolerance=tolerance),
        )

    def states_at(self, times: FloatArray) -> FloatArray:
        """States (trajectory, time, state) at ascending times (trajectory, time)."""
        outcome = integrate(self.problem, Request(times=times), tolerance=self.tolerance)
        assert outcome.states is not None
        return outcome.states

    def __call__(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Thickness stretch and its rate at times (trajectory, time) in any order."""
        order = np.argsort(times, axis=1)
        ascending = np.take_along_axis(times, order, axis=1)
        states, back = self.states_at(ascending), np.argsort(order, axis=1)
        names = ("thickness_stretch", "thickness_stretch_rate")
        x, v = (evaluate_observable(self.problem, name, ascending, states) for name in names)
        return np.take_along_axis(x, back, axis=1), np.take_along_axis(v, back, axis=1)


def final_rest_and_residual_vibration(
    rests: Sequence[StaticState | None], states: FloatArray, error: FloatArray
) -> dict[str, FloatArray]:
    """The final rest, and the energy and amplitude of the vibration about it, by name.

    Parameters
    ----------
    rests : sequence of StaticState or None
        Of each trajectory, under the last load.
    states : array (trajectory, state)
        Right after the last step.
    error : array (trajectory,)
        Of the states.
    """
    names = ("final", "residual_energy", "residual_amplitude", "residual_amplitude_error")
    table = np.full((len(rests), len(names)), np.nan)
    for k, body in enumerate(rests):
        if body is not None and np.isfinite(states[k]).all():
            energy = body.excess_energy_of(states[k])
            # The energy of an error as large as the states' is the least that can be told
            # from rest: an amplitude is not linear in errors where it vanishes.
            error_energy = body.excess_energy_of(body.state + error[k])
            energies = np.array([max(energy, 0.0), error_energy])
            amplitudes = np.sqrt(2.0 * energies / body.thickness_stiffness())
            table[k] = [body.thickness(), energy, *amplitudes]
    return dict(zip(names, table.T, strict=True))


@dataclass(frozen=True)
class Transient:
    """The passage from the start to the final rest.

    Attributes
    ----------
    motion : StepMotion
    start_thickness, final_thickness : array (trajectory,)
        Thickness stretch at the start and at the final rest.
    settling_band_share : float
        Share of the change within which the motion counts as settled.
    sample_spacing : float
        Between the samples among which passages of levels are bracketed.
    actuator_time_unit : array (trajectory,)
        The actuator's unit of time in that of each trajectory.
    """

    motion: StepMotion
    start_thickness: FloatArray
    final_thickness: FloatArray
    settling_band_share: float
    sample_spacing: float
    actuator_time_unit: FloatArray

    @property
    def thickness_change(self) -> FloatArray:
        """Of the thickness stretch, array (trajectory,); NaN where there is none."""
        return np.where(
            self.final_thickness == self.start_thickness,
            np.nan,
            self.final_thickness - self.start_thickness,
        )

    def compute_metrics(self) -> dict[str, FloatArray]:
        """Rise, settling, peak and overshoot with their errors, by name."""
        return self._rise_and_settling() | self._peak_and_overshoot()

    def _rise_and_settling(self) -> dict[str, FloatArray]:
        """Rise and settling times in the actuator's unit.

        Samples bracket the first passages of 10 and 90 %, and the last passage of the edge of
        the band that the motion enters by; each is refined on the dense output.
        """
        end = self.motion.problem.duration
        samples = int(np.ceil(end.max() / self.sample_spacing)) + 1
        grid = np.linspace(0.0, 1.0, samples) * end[:, None]
        with np.errstate(all="ignore"):
            share = (self.motion(grid)[0] - self.start_thickness[:, None]) / self.thickness_change[
                :, None
            ]
        outside = settling.last_index_outside_band(
            share, 1.0 - self.settling_band_share, 1.0 + self.settling_band_share
        )
        before = np.stack(
            [*(settling.first_index_at_or_above(share, s) - 1 for s in _RISE_SHARES), outside],
            axis=1,
        )
        above = share[np.arange(len(share)), outside] > 1.0
        edge = 1.0 + np.where(above, self.settling_band_share, -self.settling_band_share)
        levels = np.stack([*(np.full(len(share), s) for s in _RISE_SHARES), edge])
        stretches = self.start_thickness[:, None] + levels.T * self.thickness_change[:, None]
        passages = settling.locate_level_crossings(self.motion, grid, before, stretches)
        unit = self.actuator_time_unit[:, None]
        # A passage is late by the error of the stretch over the speed of the passage.
        error = self.motion.outcome.error[:, None] / np.abs(passages.rate) / unit
        times = passages.time / unit
        return {
            "rise_time": times[:, 1] - times[:, 0],
            "rise_time_error": error[:, 0] + error[:, 1],
            "settling_time": np.where(outside < 0, 0.0, times[:, 2]),
            "settling_time_error": np.where(outside < 0, 0.0, error[:, 2]),
        }

    def _peak_and_overshoot(self) -> dict[str, FloatArray]:
        """The farthest thickness stretch, and by how much it exceeds the final one."""
        outcome, change = self.motion.outcome, self.thickness_change
        peak = np.where(change > 0.0, outcome.maximum, outcome.minimum)
        return {
            "farthest": peak,
            "farthest_error": outcome.error,
            "overshoot": np.maximum((peak - self.final_thickness) / change, 0.0),
            "overshoot_error": outcome.error / np.abs(change),
        }
