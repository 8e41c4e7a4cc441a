"""Rise, settling, overshoot and residual vibration of motions that follow a command of steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.control import settling
from remanent.integrate import events
from remanent.integrate.crossings import Crossings
from remanent.integrate.ensemble.ensemble import integrate, states_of_known_run
from remanent.integrate.ensemble.problem import Outcome, Problem, Request
from remanent.studies.ensemble.checks import FINEST_TOLERANCE
from remanent.studies.ensemble.observables import evaluate_observable
from remanent.studies.statics._static_state import StaticState

#: Shares of the change between which the rise is timed.
_RISE_SHARES = (0.1, 0.9)
#: Rates of the thickness stretch per tau below which turns are left out, over the half-width of
#: the settling band: what swings more slowly takes no motion from one edge to the other.
_LEAST_TURN_OVER_BAND = 0.05
#: Levels are tried at their nominal place and moved by the error to both sides.
_SIDES = np.array([0.0, -1.0, 1.0])
#: Tolerance of the motion that tells the error of another, over that one's.
_FINER_SHARE = 0.01
#: Factor of the difference of the two.
_SAFETY = 1.5
#: Change of a state by which derivatives are told.
_SMALL_CHANGE = 1e-6


@dataclass(frozen=True)
class StepMotion:
    """The motion of every trajectory: its turning points, and states at any instant.

    Attributes
    ----------
    problem : Problem
    tolerance : float
    outcome : Outcome
        Of the states, up to the end.
    turns : Crossings
        Where the rate of the thickness stretch vanishes.
    """

    problem: Problem
    tolerance: float
    outcome: Outcome
    turns: Crossings

    @classmethod
    def from_problem(
        cls, problem: Problem, tolerance: float, final_thickness: FloatArray, band: float
    ) -> StepMotion:
        """Integrate the motion once for its turning points.

        Parameters
        ----------
        problem : Problem
        tolerance : float
        final_thickness : array (trajectory,)
            Thickness stretch at the final rest, NaN where there is none.
        band : float
            Share of the change within which the motion counts as settled.
        """
        start = problem.initial_states[:, None]
        change = final_thickness - evaluate_observable(
            problem, "thickness_stretch", np.zeros((len(start), 1)), start
        )[:, 0]  # fmt: skip
        turns, outcome = events.find_crossings(
            problem, "thickness_stretch_rate", 0.0, tolerance=tolerance,
            least_excursion=_LEAST_TURN_OVER_BAND * band * np.abs(change),
        )  # fmt: skip
        return cls(problem, tolerance, outcome, turns)

    def states_at(self, times: FloatArray) -> FloatArray:
        """States (trajectory, time, state) at ascending times (trajectory, time)."""
        return states_of_known_run(self.problem, times, self.outcome, tolerance=self.tolerance)

    def __call__(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Thickness stretch and its rate at times (trajectory, time) in any order."""
        order = np.argsort(times, axis=1)
        ascending = np.take_along_axis(times, order, axis=1)
        states, back = self.states_at(ascending), np.argsort(order, axis=1)
        names = ("thickness_stretch", "thickness_stretch_rate")
        x, v = (evaluate_observable(self.problem, name, ascending, states) for name in names)
        return np.take_along_axis(x, back, axis=1), np.take_along_axis(v, back, axis=1)

    @cached_property
    def end_states(self) -> FloatArray:
        """States at the end of every run, array (trajectory, state)."""
        return self.states_at(self.problem.duration[:, None])[:, 0]

    @cached_property
    def nodes(self) -> tuple[FloatArray, FloatArray]:
        """Times and states at the start, the turning points and the end, then NaN.

        Arrays (trajectory, node) and (trajectory, node, state).
        """
        count, dimension = self.problem.initial_states.shape
        number = np.bincount(self.turns.trajectory, minlength=count)
        first = np.cumsum(number) - number
        place = 1 + np.arange(self.turns.trajectory.size) - first[self.turns.trajectory]
        times = np.full((count, int(number.max(initial=0)) + 2), np.nan)
        states = np.full((*times.shape, dimension), np.nan)
        row = np.arange(count)
        times[:, 0], states[:, 0] = 0.0, self.problem.initial_states
        times[self.turns.trajectory, place] = self.turns.time
        states[self.turns.trajectory, place] = self.turns.states
        times[row, number + 1], states[row, number + 1] = self.problem.duration, self.end_states
        return times, states

    @cached_property
    def node_thickness(self) -> FloatArray:
        """Thickness stretch at the nodes, array (trajectory, node)."""
        return self.thickness(*self.nodes)

    def thickness(self, times: FloatArray, states: FloatArray) -> FloatArray:
        """Thickness stretch of states (trajectory, time, state)."""
        with np.errstate(all="ignore"):
            return evaluate_observable(self.problem, "thickness_stretch", times, states)

    @cached_property
    def thickness_error(self) -> FloatArray:
        """Largest error of the thickness stretch at the nodes, array (trajectory,)."""
        times, _ = self.nodes
        with np.errstate(invalid="ignore"):
            error = self.thickness_errors(np.nan_to_num(times), self.node_thickness)
        return np.asarray(np.where(np.isfinite(times), np.nan_to_num(error), 0.0).max(axis=1))

    def thickness_errors(self, times: FloatArray, thickness: FloatArray) -> FloatArray:
        """Errors of the thickness stretch at times (trajectory, time) in any order.

        The motion is integrated once more with a smaller tolerance: the difference is the error,
        but for what the smaller bound leaves.  Where that cannot be met the bound itself is it.
        """
        order = np.argsort(times, axis=1)
        ascending = np.take_along_axis(times, order, axis=1)
        tolerance, outcome = self._finer_run
        states = states_of_known_run(self.problem, ascending, outcome, tolerance=tolerance)
        finer = self.thickness(ascending, states)
        finer = np.take_along_axis(finer, np.argsort(order, axis=1), axis=1)
        difference = (
            _SAFETY * np.abs(finer - thickness)
            + (self._stretch_sensitivity * outcome.error)[:, None]
        )
        bound = (self._stretch_sensitivity * self.outcome.error)[:, None]
        return np.where(np.isfinite(difference), np.minimum(difference, bound), bound)

    @cached_property
    def _finer_run(self) -> tuple[float, Outcome]:
        """A smaller tolerance, and the outcome of the motion with it."""
        tolerance = max(_FINER_SHARE * self.tolerance, FINEST_TOLERANCE)
        return tolerance, integrate(self.problem, Request(), tolerance=tolerance)

    @cached_property
    def _stretch_sensitivity(self) -> FloatArray:
        """Largest sum of derivatives of the thickness stretch by states, array (trajectory,)."""
        times, states = self.nodes
        moved = [
            np.abs(self.thickness(times, states + _SMALL_CHANGE * direction) - self.node_thickness)
            for direction in np.eye(states.shape[2])
        ]
        return np.asarray(np.nan_to_num(np.sum(moved, axis=0)).max(axis=1) / _SMALL_CHANGE)


def end_states_with_errors(problem: Problem, tolerance: float) -> tuple[FloatArray, FloatArray]:
    """States at the ends of runs, and errors of each variable, arrays (trajectory, state).

    As in :meth:`StepMotion.thickness_errors`, the motion with a smaller tolerance tells them.
    """
    request = Request(times=problem.duration[:, None])
    outcome = integrate(problem, request, tolerance=tolerance)
    finer_tolerance = max(_FINER_SHARE * tolerance, FINEST_TOLERANCE)
    finer = integrate(problem, request, tolerance=finer_tolerance)
    assert outcome.states is not None
    assert finer.states is not None
    states, bound = outcome.states[:, 0], outcome.error[:, None]
    error = _SAFETY * np.abs(finer.states[:, 0] - states) + finer.error[:, None]
    return states, np.where(np.isfinite(error), np.fmin(error, bound), bound)


def residual_vibration(
    bodies: Sequence[StaticState | None], states: FloatArray, error: FloatArray
) -> dict[str, FloatArray]:
    """The final rest, and the energy and amplitude of the vibration about it, by name.

    Parameters
    ----------
    bodies : sequence of StaticState or None
        The rest of each trajectory, under the last load.
    states : array (trajectory, state)
        Right after the last step.
    error : array (trajectory, state)
        Of the states.
    """
    names = (
        "final", "residual_energy", "residual_energy_error",
        "residual_amplitude", "residual_amplitude_error",
    )  # fmt: skip
    table = np.full((len(bodies), len(names)), np.nan)
    for k, body in enumerate(bodies):
        if body is not None and np.isfinite(states[k]).all():
            directions = np.eye(states.shape[1])[body.moving_indices]
            moved = states[k] + _SIDES[:, None, None] * error[k] * directions
            energies = body.excess_energies_of(moved)
            energy = energies[0, 0]
            energy_error = np.abs(energies - energy).max(axis=0).sum()
            energy_error += np.finfo(float).eps * abs(energy)
            stiffness = body.thickness_stiffness()
            ends = np.maximum(energy + energy_error * _SIDES, 0.0)
            amplitude, least, most = np.sqrt(2.0 * ends / stiffness)
            amplitude_error = max(most - amplitude, amplitude - least)
            table[k] = [body.thickness(), energy, energy_error, amplitude, amplitude_error]
    return dict(zip(names, table.T, strict=True))


@dataclass(frozen=True)
class Transient:
    """The passage from the start to the final rest.

    Attributes
    ----------
    motion : StepMotion
    final_thickness, final_error : array (trajectory,)
        Thickness stretch at the final rest.
    stays_in_band : array (trajectory,) of bool
        Whether a motion that ends its run within the band stays there.
    settling_band_share : float
        Share of the change within which the motion counts as settled.
    """

    motion: StepMotion
    final_thickness: FloatArray
    final_error: FloatArray
    stays_in_band: BoolArray
    settling_band_share: float

    @cached_property
    def thickness_change(self) -> FloatArray:
        """Of the thickness stretch, array (trajectory,); NaN where there is none."""
        change = self.final_thickness - self.motion.node_thickness[:, 0]
        is_known = np.abs(change) > self.motion.thickness_error + self.final_error
        return np.where(is_known, change, np.nan)

    def compute_metrics(self) -> dict[str, FloatArray]:
        """Rise, settling, peak and overshoot with their errors, by name."""
        return self._rise_and_settling() | self._peak_and_overshoot()

    def _rise_and_settling(self) -> dict[str, FloatArray]:
        """Rise and settling times in the actuator's unit.

        Turning points tell between which of them the response first comes to 10 and 90 % of the
        change, and enters the band for the last time; the instants are then located on the dense
        output.  Each is found at its level and at levels off by the error of the response: the
        differences are the error of the time, also where a turning point nearly touches a level.
        """
        times, _ = self.motion.nodes
        count = len(times)
        start = self.motion.node_thickness[:, :1]
        change = self.thickness_change[:, None]
        with np.errstate(all="ignore"):
            share = (self.motion.node_thickness - start) / change
            error = (self.motion.thickness_error + self.final_error)[:, None] / np.abs(change)
        shares = np.concatenate([s + error * _SIDES for s in _RISE_SHARES], axis=1)
        half_width = self.settling_band_share + error * _SIDES
        rise = settling.way_to_level(share, shares)
        outside = settling.last_node_outside(share, 1.0 - half_width, 1.0 + half_width)
        above = np.take_along_axis(share, np.maximum(outside, 0), axis=1) > 1.0
        edges = 1.0 + np.where(above, half_width, -half_width)
        before = np.concatenate([rise, outside], axis=1)
        levels = start + np.concatenate([shares, edges], axis=1) * change
        brackets = self._brackets(before)
        nodes = self.motion.node_thickness
        direction = np.sign(self._at(nodes, before + 1) - self._at(nodes, before))
        passages = settling.locate_level_crossings(self.motion, *brackets, levels, direction)
        located = passages.time.reshape(count, 3, _SIDES.size)
        missed = passages.miss.reshape(count, 3, _SIDES.size)
        run = self.motion.problem.duration[:, None]
        with np.errstate(all="ignore"):
            # Where a moved level is not passed at all, nothing is known but the run.
            moved = np.where(np.isfinite(located[..., 1:]), located[..., 1:], run[..., None])
            off = np.abs(moved - located[..., :1]).max(axis=2) + missed[..., 0]
            off += np.finfo(float).eps * run + self._lateness(passages)
        # A change that is not known has no share, and nothing of it lies outside.
        settled_from_start = (outside[:, 0] < 0) & np.isfinite(share[:, 0])
        settles = np.where(settled_from_start, 0.0, located[:, 2, 0])
        settles = np.where(self.stays_in_band, settles, np.nan)
        return {
            "rise_time": located[:, 1, 0] - located[:, 0, 0],
            "rise_time_error": off[:, 0] + off[:, 1],
            "settling_time": settles,
            "settling_time_error": np.where(
                np.isnan(settles), np.nan, np.where(settled_from_start, 0.0, off[:, 2])
            ),
        }

    def _lateness(self, passages: settling.LevelCrossings) -> FloatArray:
        """How late the error of the motion makes passages of nominal levels (trajectory, passage).

        Parameters
        ----------
        passages : LevelCrossings
            (trajectory, passage * side), of nominal levels and of those moved by the error.
        """
        times, thickness, rate = (
            column[:, :: _SIDES.size] for column in (passages.time, passages.value, passages.rate)
        )
        with np.errstate(all="ignore"):
            error = self.motion.thickness_errors(np.nan_to_num(times), thickness)
            return np.asarray(error / np.abs(rate))

    def _brackets(self, before: IntArray) -> tuple[FloatArray, FloatArray]:
        """Times of the nodes before and after, NaN where there is no such node."""
        times = self.motion.nodes[0]
        return self._at(times, before), self._at(times, before + 1)

    @staticmethod
    def _at(values: FloatArray, number: IntArray) -> FloatArray:
        """Values (trajectory, node) at numbers of nodes, NaN where there is no such node."""
        inside = (number >= 0) & (number < values.shape[1])
        return np.where(
            inside, np.take_along_axis(values, np.where(inside, number, 0), axis=1), np.nan
        )

    def _peak_and_overshoot(self) -> dict[str, FloatArray]:
        """The farthest thickness stretch, and by how much it exceeds the final one."""
        change, error = self.thickness_change, self.motion.thickness_error
        ends = [f.reduce(self.motion.node_thickness, axis=1) for f in (np.fmax, np.fmin)]
        peak = np.where(np.isnan(change), np.nan, np.where(change > 0.0, *ends))
        with np.errstate(all="ignore"):
            overshoot = (peak - self.final_thickness) / change
            share_error = (error + self.final_error * (1.0 + np.abs(overshoot))) / np.abs(change)
        return {
            "farthest": peak,
            "farthest_error": np.where(np.isnan(peak), np.nan, error),
            "overshoot": np.maximum(overshoot, 0.0),
            "overshoot_error": share_error,
        }
