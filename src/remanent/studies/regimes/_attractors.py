"""The attractors that motions from many initial states end on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.attractors import (
    AttractorAssignment,
    assign_attractors,
    replace_tails_by_limit_orbits,
)
from remanent.analysis.regimes.labels import Regime
from remanent.results.build import Labelled
from remanent.studies.regimes._regime_classifier import LABEL_TEMPLATES, RegimeClassifier

#: Periods at the end of a run that tell attractors apart.
TAIL_PERIODS = 128
#: The dimension that attractors of one set of parameters have.
ATTRACTOR_DIMENSION = "attractor"


@dataclass(frozen=True)
class EndClassifier:
    """Labels trajectories and keeps the last points of each.

    Attributes
    ----------
    classifier : RegimeClassifier
    tail_point_count : int
        How many points are kept.
    """

    classifier: RegimeClassifier
    tail_point_count: int

    @property
    def result_templates(self) -> dict[str, np.ndarray]:
        """Types and later dimensions of what is told of each trajectory."""
        dimension = len(self.classifier.follower.ensemble.vector_field.state_names)
        points = np.empty((0, self.tail_point_count, dimension))
        return {
            **LABEL_TEMPLATES,
            "tail": points,
            "tail_error": np.empty(0),
            "code": np.empty(0, dtype=np.int64),
        }

    def __call__(self, indices: IntArray) -> dict[str, np.ndarray]:
        """Labels and last points of a subset of the trajectories, by name."""
        labels, path = self.classifier.decide_regimes(indices)
        assert path.visited_states is not None
        tail = path.visited_states[:, -self.tail_point_count :].copy()
        settled = self.classifier.settled_orbits(indices, labels, path)
        if self.classifier.is_damped[indices].any():
            tail = replace_tails_by_limit_orbits(
                self.classifier.iterate_map(indices), tail, settled
            )
        variables = self.classifier.label_variables(indices, labels, path, settled)
        return variables | {
            "tail": tail,
            "tail_error": settled.state_error,
            "code": labels.regime,
        }


@dataclass(frozen=True)
class MotionEnds:
    """How motions from the same initial states end, for each set of parameters.

    Attributes
    ----------
    tail_states : array (parameters, start, iterate, state)
    last_state_error : array (parameters, start)
        Estimated error of the last of them, where that is a point of a periodic orbit.
    regime, period : array (parameters, start)
    is_damped : array (parameters,) of bool
        Only damped motion has attractors.
    """

    tail_states: np.ndarray
    last_state_error: FloatArray
    regime: IntArray
    period: IntArray
    is_damped: BoolArray

    @property
    def initial_state_count(self) -> int:
        """Number of initial states."""
        return int(self.regime.shape[1])

    def assign_attractors(self) -> list[AttractorAssignment | None]:
        """The attractors of each set of parameters, and who ends there."""
        return [
            assign_attractors(self.tail_states[k], self.regime[k], self.period[k])
            if self.is_damped[k]
            else None
            for k in range(len(self.is_damped))
        ]


def basin_numbers(sorted_ends: list[AttractorAssignment | None], starts: int) -> IntArray:
    """Number of the attractor of each trajectory, array (trajectory,); -1 where it has none."""
    none = np.full(starts, -1, dtype=np.int64)
    return np.concatenate([none if each is None else each.attractor_number for each in sorted_ends])


def error_of_fraction(fraction: FloatArray, count: int) -> FloatArray:
    """Distance of an observed fraction from the farther end of Wilson's interval.

    The interval is that of one standard deviation, z = 1,
    (f + z^2/2n)/(1 + z^2/n) +- z/(1 + z^2/n) sqrt(f (1 - f)/n + z^2/4n^2).  It does not shrink
    to nothing where all or none of few states end on an attractor.  Source: E. B. Wilson,
    J. Am. Stat. Assoc. 22 (1927) 209.

    Parameters
    ----------
    fraction : array
        Of the states that end on an attractor.
    count : int
        How many states there were.
    """
    centre = (fraction + 0.5 / count) / (1.0 + 1.0 / count)
    half = np.sqrt(fraction * (1.0 - fraction) / count + 0.25 / count**2) / (1.0 + 1.0 / count)
    return np.asarray(
        np.maximum(np.abs(centre - half - fraction), np.abs(centre + half - fraction))
    )


def attractor_table(
    ends: MotionEnds,
    sorted_ends: list[AttractorAssignment | None],
    dims: tuple[str, ...],
    shape: tuple[int, ...],
) -> dict[str, Labelled]:
    """What is told of each attractor, by name.

    Parameters
    ----------
    dims, shape
        Names and lengths of the parameters' dimensions.  Sets of parameters with fewer
        attractors than others have NaN, -1 or an empty text in place of the rest.
    """
    points = len(ends.regime)
    count = max(
        (each.representative_orbit.size for each in sorted_ends if each is not None), default=0
    )
    regime = np.zeros((points, count), dtype="<U14")
    period = np.full((points, count), -1, dtype=ends.period.dtype)
    state = np.full((points, count, ends.tail_states.shape[-1]), np.nan)
    fraction, state_error = np.full((2, points, count), np.nan)
    for k, each in enumerate(sorted_ends):
        if each is None:
            continue
        first, number = each.representative_orbit, each.representative_orbit.size
        regime[k, :number] = [Regime(code).meaning for code in ends.regime[k, first]]
        period[k, :number] = ends.period[k, first]
        state[k, :number] = ends.tail_states[k, first, -1]
        state_error[k, :number] = ends.last_state_error[k, first]
        fraction[k, :number] = [np.mean(each.attractor_number == n) for n in range(number)]
    columns: dict[str, tuple[tuple[str, ...], np.ndarray]] = {
        "attractor_regime": ((ATTRACTOR_DIMENSION,), regime),
        "attractor_period": ((ATTRACTOR_DIMENSION,), period),
        "attractor_state": ((ATTRACTOR_DIMENSION, "state"), state),
        "attractor_state_error": (
            (ATTRACTOR_DIMENSION, "state"),
            np.broadcast_to(state_error[..., None], state.shape),
        ),
        "fraction": ((ATTRACTOR_DIMENSION,), fraction),
        "fraction_error": (
            (ATTRACTOR_DIMENSION,),
            error_of_fraction(fraction, ends.initial_state_count),
        ),
    }
    return {
        name: ((*dims, *later), values.reshape(*shape, *values.shape[1:]))
        for name, (later, values) in columns.items()
    }
