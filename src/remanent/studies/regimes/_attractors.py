"""The attractors that motions from many initial states end on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from remanent._typing import BoolArray, IntArray
from remanent.analysis.regimes.attractors import (
    AttractorAssignment,
    assign_attractors,
    replace_tails_by_limit_orbits,
)
from remanent.analysis.regimes.labels import Regime
from remanent.results.build import Labelled
from remanent.studies.regimes._regime_classifier import TEMPLATES, RegimeClassifier

#: Periods at the end of a run that tell attractors apart.
TAIL = 128
#: The dimension that attractors of one set of parameters have.
ATTRACTOR = "attractor"


@dataclass(frozen=True)
class EndClassifier:
    """Labels trajectories and keeps the last points of each.

    Attributes
    ----------
    classifier : RegimeClassifier
    tail : int
        How many points are kept.
    """

    classifier: RegimeClassifier
    tail: int

    @property
    def templates(self) -> dict[str, np.ndarray]:
        """Types and later dimensions of what is told of each trajectory."""
        dimension = len(self.classifier.follower.ensemble.field.state)
        points = np.empty((0, self.tail, dimension))
        return {**TEMPLATES, "tail": points, "code": np.empty(0, dtype=np.int64)}

    def __call__(self, indices: IntArray, cancelled: Callable[[], bool]) -> dict[str, np.ndarray]:
        """Labels and last points of a subset of the trajectories, by name."""
        labels, path = self.classifier.decide(indices, cancelled)
        assert path.visited_states is not None
        tail = path.visited_states[:, -self.tail :].copy()
        contracting = np.flatnonzero(self.classifier.damped[indices])
        if contracting.size:
            tail[contracting] = replace_tails_by_limit_orbits(
                self.classifier.iterate(indices[contracting]),
                tail[contracting],
                labels.regime[contracting],
                labels.period[contracting],
            )
        variables = self.classifier.variables(indices, labels, path)
        return variables | {"tail": tail, "code": labels.regime}


@dataclass(frozen=True)
class Ends:
    """How motions from the same initial states end, for each set of parameters.

    Attributes
    ----------
    tail : array (parameters, start, iterate, state)
    regime, period : array (parameters, start)
    damped : array (parameters,) of bool
        Only damped motion has attractors.
    """

    tail: np.ndarray
    regime: IntArray
    period: IntArray
    damped: BoolArray

    @property
    def starts(self) -> int:
        """Number of initial states."""
        return int(self.regime.shape[1])

    def sort(self) -> list[AttractorAssignment | None]:
        """The attractors of each set of parameters, and who ends there."""
        return [
            assign_attractors(self.tail[k], self.regime[k], self.period[k])
            if self.damped[k]
            else None
            for k in range(len(self.damped))
        ]


def basin_numbers(sorted_ends: list[AttractorAssignment | None], starts: int) -> IntArray:
    """Number of the attractor of each trajectory, array (trajectory,); -1 where it has none."""
    none = np.full(starts, -1, dtype=np.int64)
    return np.concatenate([none if each is None else each.attractor_number for each in sorted_ends])


def attractor_table(
    ends: Ends,
    sorted_ends: list[AttractorAssignment | None],
    dims: tuple[str, ...],
    shape: tuple[int, ...],
) -> dict[str, Labelled]:
    """What is told of each attractor, by name.

    Parameters
    ----------
    dims, shape
        Names and lengths of the parameters' dimensions.  Sets of parameters with fewer
        attractors than others have NaN, 0 or an empty text in place of the rest.
    """
    points = len(ends.regime)
    count = max(
        (each.representative_orbit.size for each in sorted_ends if each is not None), default=0
    )
    regime = np.zeros((points, count), dtype="<U14")
    period = np.zeros((points, count), dtype=ends.period.dtype)
    state = np.full((points, count, ends.tail.shape[-1]), np.nan)
    fraction = np.full((points, count), np.nan)
    for k, each in enumerate(sorted_ends):
        if each is None:
            continue
        first, number = each.representative_orbit, each.representative_orbit.size
        regime[k, :number] = [Regime(code).meaning for code in ends.regime[k, first]]
        period[k, :number] = ends.period[k, first]
        state[k, :number] = ends.tail[k, first, -1]
        fraction[k, :number] = [np.mean(each.attractor_number == n) for n in range(number)]
    columns: dict[str, tuple[tuple[str, ...], np.ndarray]] = {
        "attractor_regime": ((ATTRACTOR,), regime),
        "attractor_period": ((ATTRACTOR,), period),
        "attractor_state": ((ATTRACTOR, "state"), state),
        "fraction": ((ATTRACTOR,), fraction),
        "fraction_error": ((ATTRACTOR,), np.sqrt(fraction * (1.0 - fraction) / ends.starts)),
    }
    return {
        name: ((*dims, *later), values.reshape(*shape, *values.shape[1:]))
        for name, (later, values) in columns.items()
    }
