"""Growth of the difference of two in-plane stretches along motion in which they are equal."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from remanent._errors import InputError
from remanent._threads import raise_if_stopped
from remanent._typing import ComplexArray, FloatArray, IntArray
from remanent.analysis.orbits.stability import floquet_multipliers
from remanent.analysis.regimes.long_runs import LongRun, propagate_tangents
from remanent.analysis.regimes.lyapunov import lyapunov_exponents
from remanent.analysis.regimes.orbit_exponents import (
    OrbitExponents,
    find_settled_orbit_periods,
)
from remanent.integrate.ensemble.resolution import round_up_resolution
from remanent.integrate.maps.advance import BlockImage
from remanent.integrate.maps.period_map import PeriodMap
from remanent.integrate.variations import transverse_field
from remanent.studies.ensemble.checks import require_actuator
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.two_coordinates import ensemble_with_two_coordinates
from remanent.studies.regimes._follower import (
    ERROR_PER_DIFFERENCE,
    LIMIT_ORBIT_TOLERANCE,
    MIN_COARSE_RESOLUTION,
    EnsembleFollower,
    is_damped,
    status_of_run,
)

#: Differences that do not grow exponentially grow at most like n e^EXCESS over n periods,
#: and those that do grow at least like n^POWER e^(2 EXCESS).
_LOG_GROWTH_EXCESS = 2.0
#: Power of the number of periods that exponential growth exceeds.
_GROWTH_POWER = 1.5
#: Logarithm of the growth in each half of the run, at least, where it is exponential.
_HALF_RUN_LOG_GROWTH = 2.0
#: A motion that closes within this after one period has multipliers.
_CLOSURE_DISTANCE = 1e-6
#: Factor of safety of the errors of exponents and multipliers.  Measured.
_SAFETY_FACTOR = 4.0
#: Rounding errors of many steps over those of one.
_ROUNDING_FACTOR = 40.0
#: Periods at the end of a run that show whether it has settled on a periodic orbit.
_TAIL_PERIODS = 256
#: Size with which differences enter, as tangents do elsewhere.
_INITIAL_DIFFERENCE_SIZE = 1e-3


@dataclass(frozen=True)
class TransverseFlow:
    """Differences of in-plane stretches along the trajectories of an ensemble.

    Attributes
    ----------
    initial_states : array (trajectory, state)
    period_map : PeriodMap
        Of the motion and of one difference along it.
    parameters : array (trajectory, parameter)
    period_lengths : array (trajectory,)
    difference_dimension : int
        Components of a difference.
    period_tolerance : float
        Bound of a period's error.
    unchecked_period_map : PeriodMap
        The same as `period_map`, with the steps that it is told.
    """

    initial_states: FloatArray
    period_map: PeriodMap
    parameters: FloatArray
    period_lengths: FloatArray
    difference_dimension: int
    period_tolerance: float
    unchecked_period_map: PeriodMap

    @classmethod
    def from_ensemble(cls, ens: Ensemble, tolerance: float) -> TransverseFlow:
        """The differences along an ensemble's motion, which has one coordinate."""
        actuator = require_actuator("system", ens.system)
        if actuator.coordinate_count != 1:
            raise InputError(
                "system",
                must="have one coordinate",
                got=actuator,
                why="What is asked is whether that one is enough.",
                fix="Pass one number as prestress, and no edges.",
            )
        two, pairs = ensemble_with_two_coordinates(ens)
        arrays = initial_value_problem(two, np.ones(ens.trajectory_count))
        field, waveform = (
            transverse_field(two.vector_field, pairs),
            arrays.load_schedule.waveforms_at_phase,
        )
        lengths = np.where(ens.is_invalid, 1.0, require_drive_periods(ens))
        return cls(
            initial_states=ens.initial_states,
            period_map=PeriodMap(field, waveform),
            parameters=arrays.parameters,
            period_lengths=lengths,
            difference_dimension=len(pairs),
            period_tolerance=tolerance,
            unchecked_period_map=PeriodMap(field, waveform, error_control="none"),
        )

    @property
    def result_templates(self) -> Mapping[str, np.ndarray]:
        """Types and later dimensions of what is told of each trajectory."""
        return {
            "symmetry": np.empty(0, dtype="<U9"),
            **dict.fromkeys(("transverse_growth", "transverse_exponent"), np.empty(0)),
            "transverse_exponent_error": np.empty(0),
            "transverse_multipliers": np.empty((0, self.difference_dimension), dtype=complex),
            "transverse_multipliers_error": np.empty((0, self.difference_dimension)),
            "settled_period": np.empty(0, dtype=np.int64),
            **dict.fromkeys(("local_error", "status"), np.empty(0)),
        }

    def examine_growth(
        self,
        indices: IntArray,
        periods: int,
        follower: EnsembleFollower,
    ) -> dict[str, np.ndarray]:
        """Follow differences of a subset of the trajectories and say whether they grow.

        Where the motion is a periodic orbit, or settles on one, the exponent is that of the
        orbit; `follower` knows the motion without differences.
        """
        path = propagate_tangents(
            _SubsetMap(self, indices),
            self.initial_states[indices],
            periods,
            directions=self.difference_dimension,
            width=self.difference_dimension,
            every=min(_TAIL_PERIODS, periods // 2),
            block=1,
        )
        label, growth, average, error = _decide_growth(path, periods)
        orbits = self._orbits(indices, path, follower)
        multipliers, multipliers_error, exponent, exponent_error = self._multipliers(
            indices, orbits
        )
        with np.errstate(invalid="ignore"):
            better = exponent_error < error
        length = self.period_lengths[indices]
        return {
            "symmetry": label,
            "transverse_growth": growth,
            "transverse_exponent": np.where(better, exponent, average) / length,
            "transverse_exponent_error": np.where(better, exponent_error, error) / length,
            "transverse_multipliers": multipliers,
            "transverse_multipliers_error": multipliers_error,
            "settled_period": orbits.period,
            "local_error": path.largest_period_error,
            "status": status_of_run(path),
        }

    def _orbits(
        self, indices: IntArray, path: LongRun, follower: EnsembleFollower
    ) -> OrbitExponents:
        """The periodic orbits that motions start on or settle on."""
        start = self.initial_states[indices]
        once = self.period_map(
            np.pad(start, ((0, 0), (0, self.difference_dimension))),
            self.parameters[indices],
            self.period_lengths[indices],
            tolerance=self.period_tolerance,
        )
        image = once.state[:, : start.shape[1]]
        with np.errstate(invalid="ignore"):
            closes = np.abs(image - start).max(axis=1) <= _CLOSURE_DISTANCE
        assert path.visited_states is not None
        period = np.where(closes, 1, 0)
        others = np.flatnonzero(~closes & np.isfinite(path.visited_states).all(axis=(1, 2)))
        period[others] = find_settled_orbit_periods(
            path.visited_states[others],
            others,
            follower.iterate_map(indices, self.period_tolerance),
            is_damped(follower.ensemble)[indices[others]],
        )
        near = np.where(closes[:, None], start, path.last_state)
        return follower.settled_orbits(indices, near, period, self.period_tolerance)

    def _multipliers(
        self, indices: IntArray, orbits: OrbitExponents
    ) -> tuple[ComplexArray, FloatArray, FloatArray, FloatArray]:
        """Multipliers of a difference over each orbit, their errors; the exponent and its error.

        Steps of two lengths say what steps matter, and points beside the orbit what its own
        error does.
        """
        count, d = indices.size, self.difference_dimension
        multipliers = np.full((count, d), np.nan + 0j)
        multipliers_error, exponent, exponent_error = (
            np.full((count, d), np.nan),
            *np.full((2, count), np.nan),
        )
        known = np.isfinite(orbits.state).all(axis=1) & np.isfinite(orbits.state_error)
        for q in np.unique(orbits.period[known & (orbits.period > 0)]).tolist():
            some = np.flatnonzero(known & (orbits.period == q))
            rows, states = indices[some], orbits.state[some]
            enough = self._resolution_of_orbit(rows, states, q)
            fine = self._transverse_jacobian(rows, states, q, 2 * enough)
            others = [(ERROR_PER_DIFFERENCE, self._transverse_jacobian(rows, states, q, enough))]
            for unit in np.eye(states.shape[1]):
                beside = states + orbits.state_error[some, None] * unit
                others.append((1.0, self._transverse_jacobian(rows, beside, q, 2 * enough)))
            multipliers[some], multipliers_error[some] = _multipliers_and_errors(
                fine, [f * (other - fine) for f, other in others]
            )
            logs, rounding = _log_of_largest_multiplier(fine)
            moved = sum(f * np.abs(_log_of_largest_multiplier(o)[0] - logs) for f, o in others)
            exponent[some], exponent_error[some] = logs / q, _SAFETY_FACTOR * (moved + rounding) / q
        return multipliers, multipliers_error, exponent, exponent_error

    def _resolution_of_orbit(self, rows: IntArray, states: FloatArray, periods: int) -> IntArray:
        """Double steps per period that the coarser of two maps takes."""
        image = self.period_map(
            np.pad(
                states,
                ((0, 0), (0, self.difference_dimension)),
                constant_values=_INITIAL_DIFFERENCE_SIZE,
            ),
            self.parameters[rows],
            self.period_lengths[rows],
            tolerance=min(self.period_tolerance, LIMIT_ORBIT_TOLERANCE),
            cycles=periods,
        )
        return round_up_resolution(np.maximum(0.5 * image.resolution, MIN_COARSE_RESOLUTION))

    def _transverse_jacobian(
        self, rows: IntArray, states: FloatArray, periods: int, resolution: IntArray
    ) -> FloatArray:
        """Derivatives of a difference by itself over some periods, array (motion, d, d)."""
        d = self.difference_dimension
        unit = np.tile(np.eye(d), (rows.size, 1, 1))
        every = np.repeat(rows, d)
        image = self.unchecked_period_map(
            np.concatenate(
                [np.repeat(states, d, axis=0), _INITIAL_DIFFERENCE_SIZE * unit.reshape(-1, d)],
                axis=1,
            ),
            self.parameters[every],
            self.period_lengths[every],
            tolerance=np.inf,
            cycles=periods,
            resolution=np.repeat(resolution, d),
        )
        columns = image.state[:, states.shape[1] :].reshape(-1, d, d) / _INITIAL_DIFFERENCE_SIZE
        return np.moveaxis(columns, 1, 2)

    def advance(
        self, indices: IntArray, states: FloatArray, frame: FloatArray, periods: int
    ) -> BlockImage:
        """Advance motions with several differences each.

        The flow carries one difference along, so a motion with n of them is integrated n
        times; the error of a motion is the largest of these.
        """
        per_motion = frame.shape[1]
        start = np.repeat(states, per_motion, axis=0)
        rows = np.repeat(indices, per_motion)
        image = self.period_map(
            np.concatenate(
                [start, _INITIAL_DIFFERENCE_SIZE * frame.reshape(-1, self.difference_dimension)],
                axis=1,
            ),
            self.parameters[rows],
            self.period_lengths[rows],
            tolerance=self.period_tolerance,
            cycles=periods,
        )
        d = states.shape[1]
        error = image.largest_period_error.reshape(-1, per_motion).max(axis=1)
        differences = (
            image.state[:, d:].reshape(-1, per_motion, self.difference_dimension)
            / _INITIAL_DIFFERENCE_SIZE
        )
        return BlockImage(
            image.state[::per_motion, None, :d], differences, error, error <= self.period_tolerance
        )


def _multipliers_and_errors(
    jacobian: FloatArray, changes: Sequence[FloatArray]
) -> tuple[ComplexArray, FloatArray]:
    """Multipliers, largest first, and how far changes of the Jacobian and rounding move each."""
    multipliers, rounding = floquet_multipliers(jacobian, np.zeros(len(jacobian)))
    moved = _ROUNDING_FACTOR * rounding
    for change in changes:
        others = np.linalg.eigvals(jacobian + change)
        moved = moved + np.abs(multipliers[:, :, None] - others[:, None, :]).min(axis=2)
    return multipliers, _SAFETY_FACTOR * moved


def _log_of_largest_multiplier(jacobian: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Logarithm of the size of the largest multiplier, and what rounding may add to it."""
    multipliers, rounding = floquet_multipliers(jacobian, np.zeros(len(jacobian)))
    with np.errstate(divide="ignore", invalid="ignore"):
        size = np.abs(multipliers[:, 0])
        return np.log(size), _ROUNDING_FACTOR * rounding[:, 0] / size


@dataclass(frozen=True)
class _SubsetMap:
    """A subset of the motions, numbered from 0, as a map that analysis can follow."""

    flow: TransverseFlow
    indices: IntArray

    def __call__(
        self,
        which: IntArray,
        states: FloatArray,
        tangents: FloatArray,
        periods: int,
        *,
        every: bool,
    ) -> BlockImage:
        """Advance them by one period, whose end is all there is to keep."""
        assert not every or periods == 1
        return self.flow.advance(self.indices[which], states, tangents, periods)


def _decide_growth(
    path: LongRun, periods: int
) -> tuple[np.ndarray, FloatArray, FloatArray, FloatArray]:
    """The label, the largest logarithm of the growth, the exponent per period and its error."""
    logs = _log_growth_up_to_each_block(path.triangular_factors)
    with np.errstate(invalid="ignore"):
        growth = logs.max(axis=1)
        middle = logs[:, periods // 2]
        halves = np.minimum(middle, logs[:, -1] - middle)
        is_kept = growth <= np.log(periods) + _LOG_GROWTH_EXCESS
        lost = (growth >= _GROWTH_POWER * np.log(periods) + 2.0 * _LOG_GROWTH_EXCESS) & (
            halves >= _HALF_RUN_LOG_GROWTH
        )
    late = lyapunov_exponents(
        np.diff(logs[:, periods // 2 :], axis=1)[..., None],
        np.ones(periods - periods // 2 - 1, dtype=np.int64),
        transient=0.0,
    )
    # Growth in proportion to time over the second half of the run, and the errors of steps.
    in_proportion = np.log(2.0) / late.running_mean.shape[1]
    error = late.error[:, 0] + np.minimum(np.abs(late.mean[:, 0]), in_proportion)
    error = error + path.largest_period_error / _INITIAL_DIFFERENCE_SIZE
    label = np.where(is_kept, "kept", np.where(lost, "lost", "undecided"))
    return label, growth, late.mean[:, 0], error


def _log_growth_up_to_each_block(factors: FloatArray) -> FloatArray:
    """Logarithm of the largest growth of any difference up to each block, (point, block).

    The rows of a frame become R^T Q in each block; what counts is the largest singular value
    of the product of the R^T.  The product is divided by it after every block, lest it
    overflows.
    """
    points, blocks, d, _ = factors.shape
    product = np.tile(np.eye(d), (points, 1, 1))
    logs, size = np.full((points, blocks), np.nan), np.zeros(points)
    for k in range(blocks):
        raise_if_stopped()
        finite = np.isfinite(factors[:, k]).all(axis=(1, 2))
        product[finite] = product[finite] @ np.swapaxes(factors[finite, k], 1, 2)
        norm = np.linalg.norm(product, 2, axis=(1, 2))
        product /= norm[:, None, None]
        size += np.log(norm)
        logs[finite, k] = size[finite]
    return logs
