"""The period map as a function of one's own states, with Jacobians and errors."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from remanent._checks import as_float_array, shortened_repr
from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray
from remanent.analysis.orbits.period_chain import PeriodChain
from remanent.analysis.orbits.point_rows import replace_rows, subset_of_rows
from remanent.models.system import System
from remanent.studies.ensemble.checks import DriveArgument, require_tolerance
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.layout import lay_out_ensemble
from remanent.studies.orbits._checks import require_orbit_period
from remanent.studies.orbits._period_map import (
    StroboscopicMap,
    finest_level,
    period_tolerance_for_residual,
)

#: Why a period map takes states.
_STATES_REASON = "The map takes states at phase 0 to their images."
#: Error of an image, relative to one plus its size, from which on nothing is known of it.
_MAX_RELATIVE_ERROR = 1e-2


@dataclass(frozen=True)
class PeriodMapImages:
    """Images of some states under the period map.

    Attributes
    ----------
    images : array (..., state)
        The states after the periods; NaN where the motion does not last so long.
    jacobians : array (..., state, state)
        ``jacobians[..., i, j]`` is the derivative of variable i of the image by variable j of
        the state.
    images_error : array (..., state)
        Estimated error of `images`: of the integration, through the Jacobian of what follows,
        and rounding; NaN where there is no image.
    jacobians_error : array (..., state, state)
        The same of each entry of `jacobians`.
    """

    images: FloatArray
    jacobians: FloatArray
    images_error: FloatArray
    jacobians_error: FloatArray


@dataclass(frozen=True)
class PeriodMapFunction:
    """The map of a system over `orbit_period` periods of its drive, from phase 0.

    Attributes
    ----------
    state_names : tuple of str
        Variables of a state, in order.
    orbit_period : int
        In drive periods.
    duration : float
        Length of these periods, tau.
    tolerance : float
        Of the errors of images; shorter steps are taken until it is met.
    """

    state_names: tuple[str, ...]
    orbit_period: int
    duration: float
    tolerance: float
    _map: StroboscopicMap = field(repr=False)

    def __call__(self, states: ArrayLike) -> PeriodMapImages:
        """Images, Jacobians and their errors of many states, array (..., state).

        The image of a state depends on the state alone.
        """
        given = self._require_states(states)
        rows = given.reshape(-1, len(self.state_names))
        chain = _chain_within_tolerance(self._map, rows, self.orbit_period, self.tolerance)
        error = chain.end_error
        known = (error <= _MAX_RELATIVE_ERROR * (1.0 + np.abs(chain.end))).all(axis=1)
        unknown = np.where(known, 0.0, np.nan)[:, None]
        shape = given.shape
        matrix_shape = (*shape, shape[-1])
        return PeriodMapImages(
            (chain.end + unknown).reshape(shape),
            (chain.jacobian + unknown[..., None]).reshape(matrix_shape),
            (error + unknown).reshape(shape),
            (chain.jacobian_error + unknown[..., None]).reshape(matrix_shape),
        )

    def _require_states(self, states: ArrayLike) -> FloatArray:
        names = ", ".join(self.state_names)
        remedy = f"Pass an array whose last axis is {names}."
        given = as_float_array(
            "states", states, what="finite numbers", why=_STATES_REASON, fix=remedy, finite=True
        )
        if given.ndim < 1 or given.shape[-1] != len(self.state_names):
            raise InputError(
                "states",
                must=f"have {len(self.state_names)} numbers along their last axis",
                got=f"an array of shape {given.shape}",
                why=_STATES_REASON,
                fix=remedy,
            )
        for k, variable in enumerate(self._map.ensemble.vector_field.variables):
            if variable.positive and (given[..., k] <= 0.0).any():
                raise InputError(
                    "states",
                    must=f"have {variable.name} above 0",
                    got=shortened_repr(float(given[..., k].min())),
                    why="A stretch is a ratio of lengths, a temperature is absolute.",
                    fix="Leave such states out.",
                )
        return given


def period_map(
    system: System, drive: DriveArgument, *, orbit_period: int = 1, tolerance: float = 1e-9
) -> PeriodMapFunction:
    """Make the map over drive periods a function of states: what an independent check needs.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load.
    orbit_period : int
        How many drive periods the map lasts.
    tolerance : float
        Of the errors of images; shorter steps are taken until it is met, or rounding forbids.

    Returns
    -------
    PeriodMapFunction
        A function of states at phase 0, array (..., state), with values
        :class:`~remanent.studies.orbits.period_map.PeriodMapImages`: ``images`` (..., state),
        ``jacobians`` (..., state, state), ``images_error`` and ``jacobians_error``.  Its
        attribute ``state_names`` tells the order of the variables.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    See Also
    --------
    periodic_orbits : Fixed points of this map.
    poincare_section : The map applied many times to one state.
    rates : The right-hand side of the equations of motion.

    Notes
    -----
    The Jacobian solves the variational equations.  The error that a period adds is told by a
    second solution with steps twice as long, and goes on through the Jacobian of the periods
    after it.

    Examples
    --------
    >>> import numpy as np
    >>> import remanent as rm
    >>> drive = rm.SineSquared(0.4, 1.25)
    >>> period_map = rm.period_map(rm.Actuator(temperature=350), drive)
    >>> found = period_map([1.1131665292, 0.0])
    >>> np.abs(found.images - [1.1131665292, 0.0]).max() < 1e-9  # an orbit of period 1
    np.True_
    >>> float(np.linalg.det(found.jacobians).round(9))  # area is preserved
    1.0
    """
    orbit_period = require_orbit_period(orbit_period)
    tolerance = require_tolerance(tolerance, "the error of images")
    ens = lay_out_ensemble(system, drive)
    length = float(require_drive_periods(ens)[0])
    map_ = StroboscopicMap(ens, (), period_tolerance_for_residual(tolerance))
    return PeriodMapFunction(
        ens.vector_field.state_names, orbit_period, orbit_period * length, tolerance, map_
    )


def _chain_within_tolerance(
    map_: StroboscopicMap, states: FloatArray, iterate: int, tolerance: float
) -> PeriodChain:
    """States followed with steps that leave an error within the tolerance, where there are any."""
    with np.errstate(all="ignore"):
        chain = _follow(map_, states, iterate)
        for level in range(1, finest_level(map_) + 1):
            missed = np.flatnonzero(
                np.isfinite(chain.end).all(axis=1) & ~(chain.end_error <= tolerance).all(axis=1)
            )
            if not missed.size:
                break
            finer = _follow(map_.with_smaller_errors(level), states[missed], iterate)
            better = finer.end_error.max(axis=1) < chain.end_error[missed].max(axis=1)
            chain = replace_rows(chain, missed[better], subset_of_rows(finer, better))
    return chain


def _follow(map_: StroboscopicMap, states: FloatArray, iterate: int) -> PeriodChain:
    return PeriodChain.along(map_, states, np.empty((len(states), 0)), iterate)
