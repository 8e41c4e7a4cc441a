"""The period map of an actuator as analysis wants it: states, and the parameters that vary."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.analysis.maps import Mapped
from remanent.integrate.ensemble import MAX_RESOLUTION
from remanent.integrate.period_map import PeriodMap
from remanent.integrate.problem import Problem
from remanent.integrate.variations import LOG_PERIOD
from remanent.studies._ensemble import Ensemble, problem
from remanent.studies._time import require_periods

#: Double steps per period to begin with.
_FIRST = 8
#: Dimensions that results about orbits have of their own.
DIMENSIONS = frozenset({"orbit", "state", "multiplier", "branch", "point", "special"})


@dataclass
class StroboscopicMap:
    """The map over one drive period of a single actuator and drive.

    Attributes
    ----------
    ensemble
        Of one trajectory, whose values hold for all fields that do not vary.
    names
        Fields that vary: they are the map's parameters.
    held
        Those of them by which no derivative is wanted: it is given as 0.
    tolerance
        Of the error that a period adds.
    phase
        Of the section within the drive period.
    most
        Largest resolution tried, double steps per period.
    """

    ensemble: Ensemble
    names: Sequence[str]
    tolerance: float
    phase: float = 0.0
    held: Sequence[str] = ()
    most: int = MAX_RESOLUTION
    _resolution: int = field(default=_FIRST, repr=False)

    def __post_init__(self) -> None:
        require_periods(self.ensemble)
        base = problem(self.ensemble, np.ones(1))
        own = [name for name in self.names if name in base.field.parameters]
        self._problem: Problem = base
        self._slots: list[int] = [base.field.parameters.index(name) for name in own]
        # The field that times the drive acts through the length of the period alone.
        timed = self.ensemble.drive.timed_by
        self._carried: list[str] = [n for n in own if n not in self.held and n != timed]
        last = [LOG_PERIOD] if timed in self.names else []
        self._flow = PeriodMap(
            base.field,
            base.timeline.waveform,
            directions=len(base.field.state),
            parameters=(*self._carried, *last),
            phase=self.phase,
        )

    @property
    def dimension(self) -> int:
        """Number of state variables."""
        return self._flow.dimension

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> Mapped:
        """Apply the map; see :class:`remanent.analysis.maps.Map`."""
        return self.run(states, parameters, iterate)

    def run(
        self, states: FloatArray, parameters: FloatArray, iterate: int, *, half: bool = False
    ) -> Mapped:
        """Apply the map, and half of it once more where asked."""
        count, d = states.shape
        values = {name: np.ascontiguousarray(parameters[:, k]) for k, name in enumerate(self.names)}
        p = np.tile(self._problem.parameters, (count, 1))
        for slot in self._slots:
            p[:, slot] = values[self._problem.field.parameters[slot]]
        drive = self.ensemble.drive
        whole = {
            name: np.broadcast_to(v, count) for name, v in self.ensemble.values.items()
        } | values
        lengths = drive.periods(whole)
        assert lengths is not None
        image = self._flow(
            states,
            p,
            np.broadcast_to(lengths, count),
            tolerance=self.tolerance,
            cycles=iterate,
            half=half,
            resolution=self._resolution,
            finest=self.most,
        )
        self._resolution = self._typical(image.resolution)
        slope = np.zeros((count, d, len(self.names)))
        for k, name in enumerate(self.names):
            if name == drive.timed_by:  # the period is inversely proportional to this field
                slope[:, :, k] = image.tangent[:, -1] / -values[name][:, None]
            elif name in self._carried:
                slope[:, :, k] = image.tangent[:, d + self._carried.index(name)]
        jacobian = np.moveaxis(image.tangent[:, :d], 1, 2)
        return Mapped(image.state, jacobian, slope, image.error * max(iterate, 1))

    @staticmethod
    def _typical(resolution: IntArray) -> int:
        """What was enough for most points: others are refined by themselves."""
        if not resolution.size:
            return _FIRST
        middle = (9 * (resolution.size - 1)) // 10
        return int(np.partition(resolution, middle)[middle])


def spread(ensemble: Ensemble, states: FloatArray, varied: Mapping[str, FloatArray]) -> Ensemble:
    """Many trajectories like a single one, with their own initial states and some values."""
    count = len(states)
    own = {name: np.broadcast_to(v, count).copy() for name, v in ensemble.values.items()}
    return replace(
        ensemble,
        sizes={"point": count},
        coords={},
        values=own | dict(varied),
        initial=states,
        invalid=np.zeros(count, dtype=np.bool_),
    )


def at(ensemble: Ensemble, which: int) -> Ensemble:
    """One trajectory of an ensemble as an ensemble of its own."""
    values = {name: v[which : which + 1] for name, v in ensemble.values.items()}
    return replace(
        ensemble,
        sizes={},
        coords={},
        values=values,
        initial=ensemble.initial[which : which + 1],
        invalid=ensemble.invalid[which : which + 1],
    )
