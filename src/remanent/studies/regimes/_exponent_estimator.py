"""Lyapunov exponents of trajectories, with their statistical and discretisation errors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from remanent._status import Status
from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.long_runs import LongRun
from remanent.analysis.regimes.lyapunov import LyapunovExponents, lyapunov_exponents
from remanent.analysis.regimes.orbit_exponents import (
    OrbitExponents,
    find_settled_orbit_periods,
)
from remanent.integrate.maps.period_map import ErrorControl
from remanent.studies.regimes._follower import EnsembleFollower, is_damped, status_of_run

#: Periods at the end of a run that show whether it has settled on a periodic orbit.
_TAIL_PERIODS = 256
#: Standard errors above 0 beyond which an exponent is that of no stable orbit.
_MAX_REGULAR_EXPONENT_OVER_ERROR = 3.0
#: Points of the history, at most.
MAX_HISTORY_POINTS = 100
#: Standard errors by which two runs of a chaotic motion hardly ever differ.
_CHANCE_LIMIT_STANDARD_ERRORS = 3.0
#: A tangent with less than this share of the growth of the first is rounding.
_COLLAPSED_TANGENT_SHARE = 1e-13
#: Periods between renormalisations of several tangents, which must not line up.
_PERIODS_BETWEEN_RENORMALISATIONS_OF_SEVERAL = 1


@dataclass(frozen=True)
class ExponentEstimator:
    """Estimates exponents of a subset of a follower's trajectories.

    Attributes
    ----------
    follower : Follower
        With one tangent for each exponent.
    period_tolerance : float
        Bound of a period's error.
    """

    follower: EnsembleFollower
    period_tolerance: float

    @property
    def exponent_count(self) -> int:
        """How many exponents."""
        return self.follower.tangent_count

    @property
    def periods_per_block(self) -> int | None:
        """Periods between renormalisations; None is what suits one tangent."""
        return None if self.exponent_count == 1 else _PERIODS_BETWEEN_RENORMALISATIONS_OF_SEVERAL

    @cached_property
    def history_blocks(self) -> IntArray:
        """Numbers of the blocks after which the mean is kept, array (point,)."""
        blocks = self.follower.block_lengths_in_periods(self.periods_per_block).size
        points = min(self.follower.periods, MAX_HISTORY_POINTS)
        return np.unique(np.linspace(0, blocks - 1, points).astype(int))

    @property
    def history_periods(self) -> IntArray:
        """Periods after which the mean is kept, array (point,)."""
        return np.cumsum(self.follower.block_lengths_in_periods(self.periods_per_block))[
            self.history_blocks
        ]

    @property
    def result_templates(self) -> dict[str, np.ndarray]:
        """Types and later dimensions of what is told of each trajectory."""
        return {
            **dict.fromkeys(("exponent", "exponent_error"), np.empty((0, self.exponent_count))),
            "settled_period": np.empty(0, dtype=np.int64),
            "exponent_history": np.empty((0, self.history_blocks.size, self.exponent_count)),
            **dict.fromkeys(("horizon", "local_error", "status"), np.empty(0)),
        }

    def __call__(self, indices: IntArray) -> dict[str, np.ndarray]:
        """Exponents of a subset of the trajectories, by name.

        For several exponents the tangents take part in the choice of steps, since their sums
        are known better than each of them.  One exponent is estimated from steps that suit
        the state, which are cheaper; where these turn out to matter more than chance, the
        trajectory is followed again with steps that suit the tangent too.
        """
        if self.exponent_count > 1:
            return with_total_error(self._estimate_exponents(indices, "all"))
        estimate = self._estimate_exponents(indices, "state")
        limit = np.maximum(
            self.period_tolerance, _CHANCE_LIMIT_STANDARD_ERRORS * estimate["scatter"]
        )
        repeated = (estimate["difference"] > limit).any(axis=1)
        if repeated.any():
            better = self._estimate_exponents(indices[repeated], "all")
            for name, values in estimate.items():
                values[repeated] = better[name]
        return with_total_error(estimate)

    def _estimate_exponents(
        self, indices: IntArray, error_control: ErrorControl
    ) -> dict[str, np.ndarray]:
        """Means of a run, their scatter, and their difference from a run of coarser steps."""
        path, coarse_path = self.follower.follow_with_doubled_steps(
            indices,
            self.period_tolerance,
            error_control=error_control,
            block=self.periods_per_block,
            kept=min(_TAIL_PERIODS, max(1, self.follower.periods // 2)),
        )
        fine, coarse = (
            lyapunov_exponents(p.log_growth, p.block_lengths_in_periods)
            for p in (path, coarse_path)
        )
        tau = self.follower.period_lengths[indices]
        # Tangents that lined up within a period leave a bound, not a value.
        with np.errstate(invalid="ignore"):
            collapsed = (
                path.log_growth - path.log_growth[:, :, :1] < np.log(_COLLAPSED_TANGENT_SHARE)
            ).any(axis=1)
            difference = np.abs(fine.mean - coarse.mean)
        settled = self._settled_orbits(indices, path, fine)
        return {
            "exponent": fine.mean / tau[:, None],
            "scatter": np.where(collapsed, np.inf, fine.error) / tau[:, None],
            "difference": difference / tau[:, None],
            "finite_time": fine.finite_time_error / tau[:, None],
            "of_orbit": settled.exponents[:, : self.exponent_count] / tau[:, None],
            "of_orbit_error": settled.exponents_error[:, : self.exponent_count] / tau[:, None],
            "settled_period": settled.period,
            "exponent_history": fine.running_mean[:, self.history_blocks] / tau[:, None, None],
            "horizon": path.horizon * tau,
            "local_error": path.largest_period_error,
            "status": status_of_run(path),
        }

    def _settled_orbits(
        self, indices: IntArray, path: LongRun, average: LyapunovExponents
    ) -> OrbitExponents:
        """The periodic orbits that motions end on, where their exponents do not deny it."""
        assert path.visited_states is not None
        chaotic = _is_chaotic(average.mean, average.error, average.finite_time_error)
        known = path.error_bound_met & ~path.escaped & ~chaotic
        candidates = np.flatnonzero(known & np.isfinite(path.visited_states).all(axis=(1, 2)))
        period = np.zeros(indices.size, dtype=np.int64)
        period[candidates] = find_settled_orbit_periods(
            path.visited_states[candidates],
            candidates,
            self.follower.iterate_map(indices, self.period_tolerance),
            (is_damped(self.follower.ensemble)[indices] & (average.mean[:, 0] < 0.0))[candidates],
        )
        return self.follower.settled_orbits(indices, path.last_state, period, self.period_tolerance)


def _is_chaotic(mean: FloatArray, error: FloatArray, finite_time: FloatArray) -> BoolArray:
    """Where the largest of the means (orbit, direction) is no chance and no linear growth."""
    with np.errstate(invalid="ignore"):
        limit = _MAX_REGULAR_EXPONENT_OVER_ERROR * error[:, 0] + finite_time[:, 0]
        return np.asarray(mean[:, 0] > limit)


def with_total_error(estimate: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The estimate with its errors, of chance, of the run's length and of steps.

    Regular motion converges as the run gets longer, and the three add up to a bound.  Chaos
    parts two runs until nothing but chance is common to them: their difference is one more
    sign of chance, so that it is added in squares to the standard error, and nothing of the mean
    is growth in proportion to time.

    Where the motion ends on a periodic orbit, what the orbit says is taken if it is known
    better than the average.
    """
    chance, finite_time, difference = (
        estimate.pop(name) for name in ("scatter", "finite_time", "difference")
    )
    chaotic = _is_chaotic(estimate["exponent"], chance, finite_time)[:, None]
    error = np.where(chaotic, np.hypot(chance, difference), chance + finite_time + difference)
    of_orbit, of_orbit_error = estimate.pop("of_orbit"), estimate.pop("of_orbit_error")
    lost = ~np.isfinite(estimate["exponent"])
    with np.errstate(invalid="ignore"):
        better = (of_orbit_error < error) | (lost & np.isfinite(of_orbit_error))
    exponent = np.where(better, of_orbit, np.where(lost, np.nan, estimate["exponent"]))
    unknown = np.isnan(exponent).any(axis=1) & (estimate["status"] == Status.OK)
    return {
        **estimate,
        "status": np.where(unknown, int(Status.INCOMPLETE), estimate["status"]),
        "exponent": exponent,
        "exponent_error": np.where(better, of_orbit_error, np.where(lost, np.nan, error)),
    }
