"""The period map of a system as analysis wants it: states, and the parameters that vary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.analysis.orbits.errors import OrbitErrors
from remanent.analysis.orbits.maps import MapImage
from remanent.analysis.orbits.refinement import refine_orbits
from remanent.integrate.ensemble.problem import Problem
from remanent.integrate.ensemble.resolution import COARSE_RESOLUTION_LADDER, MAX_RESOLUTION
from remanent.integrate.maps.period_map import PeriodMap, PeriodMapImage
from remanent.integrate.variations import LOG_PERIOD_PARAMETER_NAME
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.problem import initial_value_problem
from remanent.studies.orbits._pilot_resolution import PilotResolution

#: Largest error that a period adds, where the residual may be larger.
_MAX_PERIOD_ERROR = 1e-10


def period_tolerance_for_residual(tolerance: float, share: float = 0.1) -> float:
    """Error of a period that leaves a residual of `tolerance` its meaning."""
    return min(share * tolerance, _MAX_PERIOD_ERROR)


#: Smallest error of a period that is asked for: rounding makes as much.
_MIN_PERIOD_TOLERANCE = 1e-14
#: Largest resolution of maps for such errors: rounding grows with the number of steps.
_FINEST_RESOLUTION_AGAINST_ROUNDING = 2048


def refine_on_period_map(
    map_: StroboscopicMap,
    states: FloatArray,
    parameters: FloatArray,
    iterate: int,
    tolerance: float,
) -> OrbitErrors:
    """Points near periodic orbits moved onto them, until the error of each is below `tolerance`.

    Parameters
    ----------
    map_ : StroboscopicMap
        To begin with; where its steps leave a larger error, shorter ones are taken.
    states : array (orbit, state)
    parameters : array (orbit, parameter)
    iterate : int
        Periods after which the orbits close.
    tolerance : float
        Of the error of each variable of the state.
    """
    return refine_orbits(
        map_.with_smaller_errors, finest_level(map_), states, parameters, iterate, tolerance
    )


def finest_level(map_: StroboscopicMap) -> int:
    """Last level of :meth:`StroboscopicMap.with_smaller_errors` that rounding allows."""
    room = np.log10(map_.period_tolerance / _MIN_PERIOD_TOLERANCE)
    return int(np.floor(np.maximum(room, 0.0)))


@dataclass(frozen=True)
class StroboscopicMap:
    """The map over one drive period of a single system and drive.

    The image of a point depends on the point alone: not on the points beside it, nor on
    earlier calls (see :mod:`remanent.studies.orbits._pilot_resolution`).

    Attributes
    ----------
    ensemble : Ensemble
        Of one trajectory, whose values hold for all fields that do not vary.
    parameter_names : sequence of str
        Fields that vary: they are the map's parameters.
    period_tolerance : float
        Of the error that a period adds.
    section_phase : float
        Of the section within the drive period, in [0, 1).
    undifferentiated_parameter_names : sequence of str
        Those of `parameter_names` by which no derivative is wanted: it is given as 0.
    finest_resolution : int
        Largest resolution tried, double steps per period.
    state_cell_bits : int
        Binary digits of a state variable that tell its cell of equal first resolution.
    """

    ensemble: Ensemble
    parameter_names: Sequence[str]
    period_tolerance: float
    section_phase: float = 0.0
    undifferentiated_parameter_names: Sequence[str] = ()
    finest_resolution: int = MAX_RESOLUTION
    state_cell_bits: int = 4

    def __post_init__(self) -> None:
        drive = self.ensemble.drive.with_varied(self.parameter_names)
        object.__setattr__(self, "ensemble", replace(self.ensemble, drive=drive))
        require_drive_periods(self.ensemble)

    @property
    def dimension(self) -> int:
        """Number of state variables."""
        return self._period_map.dimension

    def with_smaller_errors(self, level: int) -> StroboscopicMap:
        """The map with errors of a period 10**level times smaller."""
        if level == 0:
            return self
        return replace(
            self,
            period_tolerance=self.period_tolerance * 10.0**-level,
            finest_resolution=_FINEST_RESOLUTION_AGAINST_ROUNDING,
        )

    def __call__(self, states: FloatArray, parameters: FloatArray, iterate: int) -> MapImage:
        """Apply the map; see :class:`remanent.analysis.orbits.maps.Map`."""
        return self.run(states, parameters, iterate)

    def run(
        self, states: FloatArray, parameters: FloatArray, iterate: int, *, half: bool = False
    ) -> MapImage:
        """Apply the map to many points.

        Parameters
        ----------
        states : array (point, state)
        parameters : array (point, parameter)
            In the order of `parameter_names`.
        iterate : int
            How many times.
        half : bool
            Whether half of the map follows.
        """

        def pilot(x: FloatArray, p: FloatArray, resolution: IntArray) -> PeriodMapImage:
            # Any error will do, so each point is run once, at the resolution it is told.
            return self._flow_over_periods(
                x, p, iterate, half, resolution, tolerance=np.inf, finest=0
            )

        resolution = self._pilot_resolution(pilot, states, parameters, iterate=iterate, half=half)
        image = self._flow_over_periods(
            states, parameters, iterate, half, resolution,
            tolerance=self.period_tolerance, finest=self.finest_resolution,
        )  # fmt: skip
        return self._map_image(image, parameters, iterate)

    def run_at_resolution(
        self, resolution: IntArray, states: FloatArray, parameters: FloatArray, iterate: int
    ) -> tuple[MapImage, IntArray]:
        """Apply the map, beginning with given resolutions.

        For iterations that stay near where they were: what one step tells about the
        resolution is passed to the next.

        Parameters
        ----------
        resolution : array (point,) of int
            Double steps per period to begin with.
        states : array (point, state)
        parameters : array (point, parameter)
        iterate : int

        Returns
        -------
        MapImage
        array (point,) of int
            Resolutions that would have been enough.
        """
        image = self._flow_over_periods(
            states, parameters, iterate, False, resolution,
            tolerance=self.period_tolerance, finest=self.finest_resolution,
        )  # fmt: skip
        return self._map_image(
            image, parameters, iterate
        ), self._pilot_resolution.resolutions_sufficient_in_hindsight(image)

    def _flow_over_periods(
        self,
        states: FloatArray,
        parameters: FloatArray,
        iterate: int,
        half: bool,
        resolution: IntArray,
        *,
        tolerance: float,
        finest: int,
    ) -> PeriodMapImage:
        """The flow over some periods, with the resolutions to begin with and at most."""
        values = self._parameter_columns(parameters)
        return self._period_map(
            states, self._vector_field_parameters(values, len(states)),
            self._period_lengths(values, len(states)),
            tolerance=tolerance, cycles=iterate, half=half, resolution=resolution,
            max_resolution=finest,
        )  # fmt: skip

    def _map_image(self, image: PeriodMapImage, parameters: FloatArray, iterate: int) -> MapImage:
        """What analysis wants of an image."""
        jacobian = np.moveaxis(image.tangents[:, : self.dimension], 1, 2)
        slope = self._parameter_derivatives(image, self._parameter_columns(parameters))
        error = image.largest_period_error * max(iterate, 1)
        if iterate != 1 or image.last_tangents_error is None:
            return MapImage(image.state, jacobian, slope, error)
        jacobian_error = np.moveaxis(image.last_tangents_error[:, : self.dimension], 1, 2)
        return MapImage(image.state, jacobian, slope, error, image.last_state_error, jacobian_error)

    def _parameter_derivatives(
        self, image: PeriodMapImage, values: dict[str, FloatArray]
    ) -> FloatArray:
        """Derivatives by the map's parameters, array (point, state, parameter)."""
        count, d = image.state.shape
        slope = np.zeros((count, d, len(self.parameter_names)))
        for k, name in enumerate(self.parameter_names):
            if name == self.ensemble.drive.frequency_field_name:
                # The period is inversely proportional to this field.
                slope[:, :, k] = image.tangents[:, -1] / -values[name][:, None]
            if name in self._differentiated_parameter_names:
                slope[:, :, k] += image.tangents[
                    :, d + self._differentiated_parameter_names.index(name)
                ]
        return slope

    def _parameter_columns(self, parameters: FloatArray) -> dict[str, FloatArray]:
        """Values of the fields that vary, each an array (point,)."""
        return {
            name: np.ascontiguousarray(parameters[:, k])
            for k, name in enumerate(self.parameter_names)
        }

    def _vector_field_parameters(self, values: dict[str, FloatArray], count: int) -> FloatArray:
        """Parameters of the vector field, array (point, parameter)."""
        rows = np.tile(self._problem.parameters, (count, 1))
        for name in self._varied_vector_field_parameter_names:
            rows[:, self._problem.field.parameter_names.index(name)] = values[name]
        return rows

    def _period_lengths(self, values: dict[str, FloatArray], count: int) -> FloatArray:
        """Drive periods, array (point,)."""
        fields = {
            name: np.broadcast_to(v, count) for name, v in self.ensemble.parameter_values.items()
        }
        lengths = self.ensemble.drive.periods(fields | values)
        assert lengths is not None
        return np.broadcast_to(lengths, count)

    @cached_property
    def _problem(self) -> Problem:
        return initial_value_problem(self.ensemble, np.ones(1))

    @cached_property
    def _varied_vector_field_parameter_names(self) -> list[str]:
        """Those of the varied fields that the vector field knows."""
        return [
            name for name in self.parameter_names if name in self._problem.field.parameter_names
        ]

    @cached_property
    def _differentiated_parameter_names(self) -> list[str]:
        """Fields whose derivatives the kernel carries along.

        The field that times the drive acts through the length of the period, and through the
        rate of the load where that enters the equations.
        """
        timed = self.ensemble.drive.frequency_field_name
        return [
            name
            for name in self._varied_vector_field_parameter_names
            if name not in self.undifferentiated_parameter_names
            and (name != timed or self._load_rate_matters)
        ]

    @property
    def _load_rate_matters(self) -> bool:
        """Whether rates of the loads enter the equations."""
        return self.ensemble.system.needs_load_rate(
            self.ensemble.parameter_values, varied=self.parameter_names
        )

    @cached_property
    def _period_map(self) -> PeriodMap:
        last = (
            [LOG_PERIOD_PARAMETER_NAME]
            if self.ensemble.drive.frequency_field_name in self.parameter_names
            else []
        )
        return PeriodMap(
            self._problem.field,
            self._problem.load_schedule.waveforms_at_phase,
            directions=len(self._problem.field.state_names),
            parameters=(*self._differentiated_parameter_names, *last),
            phase=self.section_phase,
            # The points of a search differ much in what they need, and are few.
            resolution_ladder=COARSE_RESOLUTION_LADDER,
        )

    @cached_property
    def _pilot_resolution(self) -> PilotResolution:
        return PilotResolution(
            self.period_tolerance,
            self._period_map.order,
            self.finest_resolution,
            self.state_cell_bits,
        )
