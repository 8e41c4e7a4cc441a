"""The period map of an actuator as analysis wants it: states, and the parameters that vary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import KDTree

from remanent._typing import FloatArray, IntArray
from remanent.analysis.orbits.maps import MapImage
from remanent.integrate.ensemble.ensemble import MAX_RESOLUTION
from remanent.integrate.ensemble.problem import Problem
from remanent.integrate.ensemble.resolution import ladder
from remanent.integrate.maps.period_map import Image, PeriodMap
from remanent.integrate.variations import LOG_PERIOD
from remanent.studies.ensemble.durations import require_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.problem import initial_value_problem

#: Double steps per period to begin with, and at least.
_FIRST = 8
#: Resolution aims this factor below the tolerance.
_AIM = 0.5
#: So many points are few, and this share of them most.
_FEW, _MOST = 32, 0.9
#: Points whose resolutions are remembered.
_REMEMBERED = 1024
#: Points that differ by less than this lie together.
_ALIKE = 1e-9
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
    _known: _Known | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        require_periods(self.ensemble)
        base = initial_value_problem(self.ensemble, np.ones(1))
        own = [name for name in self.names if name in base.field.parameters]
        self._problem: Problem = base
        self._slots: list[int] = [base.field.parameters.index(name) for name in own]
        # The field that times the drive acts through the length of the period, and through the
        # rate of the load where that takes part in the heat balance.
        timed = self.ensemble.drive.timed_by
        self._carried: list[str] = [
            n for n in own if n not in self.held and (n != timed or self._rate_matters)
        ]
        last = [LOG_PERIOD] if timed in self.names else []
        self._flow = PeriodMap(
            base.field,
            base.timeline.waveform,
            directions=len(base.field.state),
            parameters=(*self._carried, *last),
            phase=self.phase,
        )

    @property
    def _rate_matters(self) -> bool:
        """Whether rates of the loads enter the equations."""
        return self.ensemble.system.needs_load_rate(self.ensemble.values, varied=self.names)

    @property
    def dimension(self) -> int:
        """Number of state variables."""
        return self._flow.dimension

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        """Apply the map; see :class:`remanent.analysis.orbits.maps.Map`."""
        return self.run(states, parameters, iterate)

    def run(
        self, states: FloatArray, parameters: FloatArray, iterate: int, *, half: bool = False
    ) -> MapImage:
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
            resolution=self._foreseen(states, parameters),
            finest=self.most,
        )
        self._learn(states, parameters, image)
        slope = np.zeros((count, d, len(self.names)))
        for k, name in enumerate(self.names):
            if name == drive.timed_by:  # the period is inversely proportional to this field
                slope[:, :, k] = image.tangent[:, -1] / -values[name][:, None]
            if name in self._carried:
                slope[:, :, k] += image.tangent[:, d + self._carried.index(name)]
        jacobian = np.moveaxis(image.tangent[:, :d], 1, 2)
        return MapImage(image.state, jacobian, slope, image.error * max(iterate, 1))

    def _foreseen(self, states: FloatArray, parameters: FloatArray) -> IntArray | int:
        """The resolution that was wanted at the nearest point of late.

        Few points share what is enough for most of them: lanes would be idle else.
        """
        if self._known is None:
            return _FIRST
        found = self._known.nearest(np.nan_to_num(np.hstack([states, parameters])))
        if found.size > _FEW:
            return found
        return int(np.quantile(found, _MOST, method="lower")) if found.size else _FIRST

    def _learn(self, states: FloatArray, parameters: FloatArray, image: Image) -> None:
        with np.errstate(all="ignore"):
            share = (image.error / (_AIM * self.tolerance)) ** (1.0 / self._flow.order)
        wanted = image.resolution * np.clip(np.nan_to_num(share, nan=1.0), 0.25, 1.0)
        places = np.hstack([states, parameters])
        known = np.isfinite(places).all(axis=1) & np.isfinite(image.error)
        if known.any():
            found = np.minimum(ladder(np.clip(wanted[known], _FIRST, self.most)), self.most)
            new = _Known(places[known], found)
            self._known = new if self._known is None else new.and_then(self._known)


@dataclass(frozen=True)
class _Known:
    """Resolutions that were wanted at some places, the latest first."""

    places: FloatArray
    wanted: IntArray

    def and_then(self, earlier: _Known) -> _Known:
        """With as many of the earlier ones as are remembered: after a few, these still count."""
        room = max(_REMEMBERED - self.wanted.size, 0)
        return _Known(
            np.concatenate([self.places, earlier.places[:room]]),
            np.concatenate([self.wanted, earlier.wanted[:room]]),
        )

    def nearest(self, places: FloatArray) -> IntArray:
        """What was wanted at the nearest of them, in units of their spread."""
        scale = np.maximum(np.ptp(self.places, axis=0), _ALIKE)
        tree = KDTree(self.places / scale, balanced_tree=False, compact_nodes=False)  # asked once
        _, nearest = tree.query(places / scale)
        return np.asarray(self.wanted[nearest])
