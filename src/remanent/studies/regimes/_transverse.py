"""Growth of the difference of two in-plane stretches along motion in which they are equal."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from remanent._errors import InputError
from remanent._threads import raise_if_stopped
from remanent._typing import FloatArray, IntArray
from remanent.analysis.orbits.stability import floquet_multipliers
from remanent.analysis.regimes.long_runs import LongRun, propagate_tangents
from remanent.integrate.maps.advance import BlockImage
from remanent.integrate.maps.period_map import PeriodMap
from remanent.integrate.variations import transverse_field
from remanent.studies.ensemble.checks import require_actuator
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.ensemble.two_coordinates import ensemble_with_two_coordinates
from remanent.studies.regimes._follower import status_of_run

#: Differences that do not grow exponentially grow at most like n e^EXCESS over n periods,
#: and those that do grow at least like n^POWER e^(2 EXCESS).
_LOG_GROWTH_EXCESS = 2.0
#: Power of the number of periods that exponential growth exceeds.
_GROWTH_POWER = 1.5
#: Logarithm of the growth in each half of the run, at least, where it is exponential.
_HALF_RUN_LOG_GROWTH = 2.0
#: A motion that closes within this after one period has multipliers.
_CLOSURE_DISTANCE = 1e-6
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
    """

    initial_states: FloatArray
    period_map: PeriodMap
    parameters: FloatArray
    period_lengths: FloatArray
    difference_dimension: int
    period_tolerance: float

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
        flow = PeriodMap(
            transverse_field(two.vector_field, pairs), arrays.timeline.waveforms_at_phase
        )
        lengths = np.where(ens.is_invalid, 1.0, require_drive_periods(ens))
        return cls(
            initial_states=ens.initial_states,
            period_map=flow,
            parameters=arrays.parameters,
            period_lengths=lengths,
            difference_dimension=len(pairs),
            period_tolerance=tolerance,
        )

    @property
    def result_templates(self) -> Mapping[str, np.ndarray]:
        """Types and later dimensions of what is told of each trajectory."""
        return {
            "symmetry": np.empty(0, dtype="<U9"),
            **dict.fromkeys(("transverse_growth", "transverse_exponent"), np.empty(0)),
            "transverse_multipliers": np.empty((0, self.difference_dimension), dtype=complex),
            **dict.fromkeys(("local_error", "status"), np.empty(0)),
        }

    def examine_growth(self, indices: IntArray, periods: int) -> dict[str, np.ndarray]:
        """Follow differences of a subset of the trajectories and say whether they grow."""
        path = propagate_tangents(
            _SubsetMap(self, indices),
            self.initial_states[indices],
            periods,
            directions=self.difference_dimension,
            width=self.difference_dimension,
            block=1,
        )
        label, growth, exponent = _decide_growth(path, periods)
        return {
            "symmetry": label,
            "transverse_growth": growth,
            "transverse_exponent": exponent / self.period_lengths[indices],
            "transverse_multipliers": self._multipliers(indices),
            "local_error": path.largest_period_error,
            "status": status_of_run(path),
        }

    def _multipliers(self, indices: IntArray) -> np.ndarray:
        """Of the difference, where the motion closes after one period; NaN elsewhere."""
        start = self.initial_states[indices]
        unit = np.tile(np.eye(self.difference_dimension), (indices.size, 1, 1))
        once = self.advance(indices, start, unit, 1)
        values, _ = floquet_multipliers(np.moveaxis(once.tangents, 1, 2), once.largest_period_error)
        values[np.abs(once.visited_states[:, -1] - start).max(axis=1) > _CLOSURE_DISTANCE] = np.nan
        return np.asarray(values)

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
        """Advance them; the last state is all that is ever needed."""
        assert not every
        return self.flow.advance(self.indices[which], states, tangents, periods)


def _decide_growth(path: LongRun, periods: int) -> tuple[np.ndarray, FloatArray, FloatArray]:
    """The label, the largest logarithm of the growth, and the exponent per period."""
    logs = _log_growth_up_to_each_block(path.triangular_factors)
    with np.errstate(invalid="ignore"):
        growth = logs.max(axis=1)
        middle = logs[:, periods // 2]
        halves = np.minimum(middle, logs[:, -1] - middle)
        is_kept = growth <= np.log(periods) + _LOG_GROWTH_EXCESS
        lost = (growth >= _GROWTH_POWER * np.log(periods) + 2.0 * _LOG_GROWTH_EXCESS) & (
            halves >= _HALF_RUN_LOG_GROWTH
        )
        exponent = (logs[:, -1] - middle) / (periods - periods // 2 - 1)
    return np.where(is_kept, "kept", np.where(lost, "lost", "undecided")), growth, exponent


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
