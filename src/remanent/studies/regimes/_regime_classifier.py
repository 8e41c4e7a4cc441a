"""Regimes of an ensemble's trajectories: what `classify`, `regime_chart` and `basins` share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import xarray as xr

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.decision import decide_regimes
from remanent.analysis.regimes.labels import Regime, RegimeLabels
from remanent.analysis.regimes.limit_orbits import IterateWithJacobian
from remanent.analysis.regimes.long_runs import LongRun
from remanent.analysis.regimes.orbit_exponents import OrbitExponents
from remanent.analysis.regimes.problem import RegimeProblem
from remanent.studies.ensemble.dataset import to_dataset
from remanent.studies.ensemble.durations import require_count, require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.memory import require_memory
from remanent.studies.ensemble.progress import ProgressFunction
from remanent.studies.regimes._follower import (
    EnsembleFollower,
    is_damped,
    missing_exponent_reasons,
    require_memory_for_runs,
    status_of_run,
)

#: Factors between the tolerances whose labels have to agree, the finest first.
TOLERANCE_FACTORS = (1.0, 10.0, 100.0)
#: Shorter runs say nothing of their regime.
MIN_PERIODS = 100
#: The evidence that is told of each trajectory, beside its exponent.
EVIDENCE_VARIABLE_NAMES = (
    "digits",
    "zero_one",
    "sali",
    "rotation_number",
    "rotation_digits",
    "defect",
)
#: Types of what is told of each trajectory.
LABEL_TEMPLATES: Mapping[str, np.ndarray] = {
    "regime": np.empty(0, dtype="<U14"),
    "period": np.empty(0, dtype=np.int64),
    **dict.fromkeys(("margin", "exponent", "exponent_error"), np.empty(0)),
    "rotation_number_error": np.empty(0),
    **dict.fromkeys(("horizon", "local_error", "status"), np.empty(0)),
    **dict.fromkeys(EVIDENCE_VARIABLE_NAMES, np.empty(0)),
}
#: Tangents of the finest run: two, so that their alignment tells order from chaos.
_TANGENT_COUNT = 2
#: States kept in memory for one chunk, about: 40 MB.
_STATES_PER_CHUNK = 2**20
#: Trajectories in a chunk, at least, so that the lanes of a kernel are used.
_FEWEST_TRAJECTORIES_PER_CHUNK = 16
#: Trajectories in a chunk, at most.
_MOST_TRAJECTORIES_PER_CHUNK = 4096
#: Bytes that a run needs for each of its periods: its states, at several tolerances, and what is
#: made of them.
_BYTES_PER_PERIOD = 500.0
#: Memory that the result takes for each trajectory, bytes.
BYTES_PER_LABEL = 300.0


def require_run_length(periods: Any) -> int:
    """The number of periods of a run that is long enough for a regime to show."""
    return require_count("periods", periods, "A regime shows in a long run.", MIN_PERIODS)


def regime_dataset(
    ens: Ensemble, periods: int, tolerance: float, seed: int, report: ProgressFunction | None
) -> xr.Dataset:
    """Label every trajectory of an ensemble with its regime and the evidence for it."""
    period_lengths = require_drive_periods(ens)
    require_memory("over", BYTES_PER_LABEL * ens.trajectory_count, f"{ens.trajectory_count} labels")
    classifier = RegimeClassifier.from_ensemble(ens, periods, tolerance, seed)
    values = classifier.compute_in_chunks(classifier, LABEL_TEMPLATES, report)
    return to_dataset(
        ens,
        {
            "drive_period": period_lengths,
            **values,
            "reason": missing_exponent_reasons(values["exponent"], values["status"]),
        },
        tolerance=tolerance,
        periods=periods,
        rng=seed,
    )


@dataclass(frozen=True)
class RegimeClassifier:
    """Labels trajectories of an ensemble.

    Attributes
    ----------
    follower : Follower
    finest_period_tolerance : float
        The finest bound of a period's error.
    seed : int
        Of the frequencies of the 0-1 test, which are the same for every trajectory.
    """

    follower: EnsembleFollower
    finest_period_tolerance: float
    seed: int

    @classmethod
    def from_ensemble(
        cls, ens: Ensemble, periods: int, tolerance: float, seed: int
    ) -> RegimeClassifier:
        """The classifier of an ensemble's motion over so many periods."""
        tangents = min(_TANGENT_COUNT, len(ens.vector_field.state_names))
        return cls(EnsembleFollower(ens, periods, tangents), tolerance, seed)

    @cached_property
    def is_damped(self) -> BoolArray:
        """Where the motion loses energy, array (trajectory,)."""
        return is_damped(self.follower.ensemble)

    def compute_in_chunks(
        self,
        work: Callable[[IntArray], Mapping[str, np.ndarray]],
        templates: Mapping[str, np.ndarray],
        report: ProgressFunction | None,
    ) -> dict[str, np.ndarray]:
        """Do `work` on all trajectories, in chunks whose states fit into memory."""
        chunk_size = int(
            np.clip(
                _STATES_PER_CHUNK // self.follower.periods,
                _FEWEST_TRAJECTORIES_PER_CHUNK,
                _MOST_TRAJECTORIES_PER_CHUNK,
            )
        )
        require_memory_for_runs(
            self.follower.ensemble, self.follower.periods, _BYTES_PER_PERIOD, chunk_size
        )
        return self.follower.compute_in_chunks(work, templates, report, chunk_size=chunk_size)

    def __call__(self, indices: IntArray) -> dict[str, np.ndarray]:
        """Label a subset of the trajectories: variables by name."""
        labels, path = self.decide_regimes(indices)
        return self.label_variables(
            indices, labels, path, self.settled_orbits(indices, labels, path)
        )

    def decide_regimes(self, indices: IntArray) -> tuple[RegimeLabels, LongRun]:
        """Labels of a subset of the trajectories, and the paths they were read from."""

        def run(subset: IntArray, level: int, states: FloatArray | None = None, /) -> LongRun:
            # Only the finest run carries the second tangent: it is not needed where the two
            # coarser ones agree, and it costs as much as the first.
            return self.follower.follow(
                indices[subset],
                self.finest_period_tolerance * TOLERANCE_FACTORS[level],
                states,
                directions=self.follower.tangent_count if level == 0 else 1,
                every=True,
            )

        return decide_regimes(
            RegimeProblem(
                run,
                indices.size,
                damped=self.is_damped[indices],
                iterate_with_jacobian=self.iterate_map(indices),
                seed=self.seed,
            )
        )

    def iterate_map(self, indices: IntArray) -> IterateWithJacobian:
        """Images and Jacobians of the trajectories' maps at the finest tolerance."""
        return self.follower.iterate_map(indices, self.finest_period_tolerance)

    def settled_orbits(
        self, indices: IntArray, labels: RegimeLabels, path: LongRun
    ) -> OrbitExponents:
        """The orbits that a subset's periodic motions are on, or settle on."""
        periodic = labels.regime == Regime.PERIODIC
        return self.follower.settled_orbits(
            indices,
            path.last_state,
            np.where(periodic, labels.period, 0),
            self.finest_period_tolerance,
        )

    def label_variables(
        self, indices: IntArray, labels: RegimeLabels, path: LongRun, of_orbit: OrbitExponents
    ) -> dict[str, np.ndarray]:
        """What is told of a subset of the trajectories, by name."""
        tau = self.follower.period_lengths[indices]
        average, error = labels.evidence.exponent, labels.exponent_error
        known = np.isfinite(average)
        with np.errstate(invalid="ignore"):
            better = (of_orbit.exponents_error[:, 0] < error) | (
                ~known & np.isfinite(of_orbit.exponents_error[:, 0])
            )
        average, error = (np.where(known, each, np.nan) for each in (average, error))
        values = {
            "regime": np.array([Regime(code).meaning for code in labels.regime], dtype="<U14"),
            "period": labels.period,
            "margin": labels.margin,
            "exponent": np.where(better, of_orbit.exponents[:, 0], average) / tau,
            "exponent_error": np.where(better, of_orbit.exponents_error[:, 0], error) / tau,
            "rotation_number_error": labels.rotation_number_error,
            "horizon": path.horizon * tau,
            "local_error": path.largest_period_error,
            "status": status_of_run(path),
        }
        return values | {name: labels.evidence[name] for name in EVIDENCE_VARIABLE_NAMES}
