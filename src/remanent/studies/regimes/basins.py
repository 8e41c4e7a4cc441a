"""Basins: where motions from many initial states end."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from remanent._errors import InputError, shortened_repr
from remanent._typing import ArrayLike, BoolArray, FloatArray, IntArray
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import DriveArgument, RngArgument, as_seed, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectoryArray, to_dataset
from remanent.studies.ensemble.durations import require_drive_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import RESERVED_DIMENSIONS, OverArgument, lay_out_ensemble
from remanent.studies.ensemble.memory import require_memory
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.regimes._arguments import rename_arguments_in_errors
from remanent.studies.regimes._attractors import (
    ATTRACTOR_DIMENSION,
    TAIL_PERIODS,
    EndClassifier,
    MotionEnds,
    attractor_table,
    basin_numbers,
)
from remanent.studies.regimes._follower import missing_exponent_reasons
from remanent.studies.regimes._regime_classifier import (
    BYTES_PER_LABEL,
    RegimeClassifier,
    require_run_length,
)

#: Names of dimensions that results have of their own.
_RESERVED_DIMENSIONS = RESERVED_DIMENSIONS | {ATTRACTOR_DIMENSION, "state"}


def basins(
    system: System,
    drive: DriveArgument,
    grid: Mapping[str, ArrayLike],
    *,
    periods: int = 500,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
    rng: RngArgument = None,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Say where the motion from each of many initial states ends.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load.
    grid : mapping of str to array
        State variables with their initial values, ``{"stretch": ..., "stretch_rate": ...}``,
        each ascending; the others start from rest.
    periods : int
        Length of the runs in smallest periods of the load, at least 100.
    over : mapping of str to array_like or DataArray, optional
        Values of numeric fields of the system or the drive; they become dimensions of the
        result, before those of the grid.
    tolerance : float
        Bound of the error that one drive period adds, at the finest of the tolerances tried.
    rng : int, numpy.random.Generator or None
        Draws the frequencies of the 0-1 test, the same for every motion.  None is a fixed
        seed.  A generator is copied: it is not advanced.  The attribute ``rng`` of the result
        is the seed that was used: passed as `rng`, it gives the same result.
    progress : bool or callable, optional
        True draws a bar; a function is called with the share of motions that are
        finished, in [0, 1].

    Returns
    -------
    xarray.Dataset
        Along the variables of the grid all that :func:`remanent.classify` gives, the regime
        and the rotation number above all.  Where there is dissipation also:

        ``basin``
            The number of the attractor each motion ends on, −1 where its regime is undecided
            or it escaped.
        ``attractor_regime``, ``attractor_period``, ``attractor_state``
            Of each attractor, the most visited first; the state is a point of it.
        ``attractor_state_error``
            Estimated error of that point, where the attractor is a periodic orbit.  A point of
            a torus or of a chaotic set has none: NaN.
        ``fraction``, ``fraction_error``
            The fraction of the initial states that end there, and its standard error: the
            distance from the farther end of Wilson's interval.

        With `over` attractors are numbered anew for each set of parameters; where one has
        fewer than another, the rest is NaN, 0 or an empty text.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    See Also
    --------
    remanent.classify : The rules by which regimes are told apart.
    remanent.periodic_orbits : All orbits, the unstable ones between basins too.
    remanent.manifold_crossing : Where a basin's boundary passes through a state.

    Notes
    -----
    The standard error is that of states drawn at random from the grid's box: Wilson's interval
    of one standard deviation, which has a width also where all states end on one attractor.
    Periodic attractors are told apart by their points.  Tori and chaotic sets are told
    apart by averages of coordinates: two that lie in the same place count as one.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.basins(
    ...     rm.Actuator(dissipation=rm.Rayleigh(0.3)),
    ...     rm.SineSquared(0.4, 1.25),
    ...     {"stretch": [0.9, 1.0, 1.1], "stretch_rate": [0.0, 0.1]},
    ...     periods=200,
    ... )
    >>> ds.basin.values.tolist(), ds.fraction.values.tolist()
    ([[0, 0], [0, 0], [0, 0]], [1.0])
    """
    periods = require_run_length(periods)
    tolerance = require_tolerance(tolerance, "the error that one drive period adds")
    layout = _BasinLayout.from_grid(system, drive, grid, over)
    ens = layout.ensemble
    period_lengths = require_drive_periods(ens)
    needed = (
        BYTES_PER_LABEL + 8.0 * TAIL_PERIODS * len(ens.vector_field.state_names)
    ) * ens.trajectory_count
    require_memory("grid", needed, f"{ens.trajectory_count} ends")
    seed = as_seed(rng)
    classifier = RegimeClassifier.from_ensemble(ens, periods, tolerance, seed)
    work = EndClassifier(classifier, min(TAIL_PERIODS, periods))
    values = classifier.compute_in_chunks(work, work.result_templates, as_progress(progress))
    tail, tail_error, code = (values.pop(name) for name in ("tail", "tail_error", "code"))
    variables: dict[str, PerTrajectoryArray] = {
        "drive_period": period_lengths,
        **values,
        "reason": missing_exponent_reasons(values["exponent"], values["status"]),
    }
    shared: dict[str, Labelled] = {}
    coords: dict[str, Labelled] = {}
    if classifier.is_damped.any():
        ends = layout.build_motion_ends(
            tail, tail_error, code, values["period"], classifier.is_damped
        )
        attractors = ends.assign_attractors()
        variables["basin"] = basin_numbers(attractors, ends.initial_state_count)
        shared = attractor_table(ends, attractors, layout.parameter_dims, layout.parameter_shape)
        numbers = np.arange(shared["fraction"][1].shape[-1])
        coords = {
            ATTRACTOR_DIMENSION: ((ATTRACTOR_DIMENSION,), numbers),
            "state": (("state",), np.array(ens.vector_field.state_names)),
        }
    result = to_dataset(
        ens,
        variables,
        shared=shared,
        coords=coords,
        tolerance=tolerance,
        periods=periods,
        rng=seed,
    )
    return result.rename({f"initial.{name}": name for name in grid})


@dataclass(frozen=True)
class _BasinLayout:
    """Initial states on a grid, for each set of parameters.

    Attributes
    ----------
    ensemble : Ensemble
        The parameters' dimensions first, then those of the grid.
    parameter_dims, parameter_shape
        Names and lengths of the parameters' dimensions.
    """

    ensemble: Ensemble
    parameter_dims: tuple[str, ...]
    parameter_shape: tuple[int, ...]

    @classmethod
    def from_grid(
        cls, system: System, drive: DriveArgument, grid: Any, over: OverArgument | None
    ) -> _BasinLayout:
        starts = _over_from_grid(grid)
        base = lay_out_ensemble(system, drive, over, reserved=_RESERVED_DIMENSIONS)
        _require_state_names(grid, base)
        _require_disjoint_from_grid(over or {}, starts)
        own_names = {
            f"over[{start!r}]": f"grid[{name!r}]" for name, start in zip(grid, starts, strict=True)
        }
        with rename_arguments_in_errors(own_names):
            ens = lay_out_ensemble(
                system, drive, {**(over or {}), **starts}, reserved=_RESERVED_DIMENSIONS
            )
        grid_dims, _ = ens.coords[next(iter(starts))]
        split = ens.dims.index(grid_dims[0])
        return cls(ens, ens.dims[:split], tuple(ens.dimension_sizes.values())[:split])

    def build_motion_ends(
        self,
        tail: np.ndarray,
        tail_error: FloatArray,
        regime: IntArray,
        period: IntArray,
        damped: BoolArray,
    ) -> MotionEnds:
        """How motions end, arrays (trajectory, ...), with an axis for the parameters."""

        def apart(values: Any) -> Any:
            return values.reshape(math.prod(self.parameter_shape), -1, *values.shape[1:])

        return MotionEnds(
            apart(tail), apart(tail_error), apart(regime), apart(period), apart(damped)[:, 0]
        )


def _over_from_grid(grid: Any) -> dict[str, Any]:
    if not isinstance(grid, Mapping) or not grid:
        raise InputError(
            "grid",
            must="be a mapping of state variables to values",
            got=shortened_repr(grid),
            why="It says from where the motions start.",
            fix="Pass for example {'stretch': numpy.linspace(0.5, 2, 64), 'stretch_rate': [0.0]}.",
        )
    return {f"initial.{name}": values for name, values in grid.items()}


def _require_state_names(grid: Mapping[str, Any], ens: Ensemble) -> None:
    unknown = [name for name in grid if name not in ens.vector_field.state_names]
    if unknown:
        raise InputError(
            "grid",
            must="name state variables",
            got=", ".join(map(repr, unknown)),
            why="It says from where the motions start.",
            fix=f"Name some of {', '.join(ens.vector_field.state_names)}.",
        )


def _require_disjoint_from_grid(over: Mapping[str, Any], starts: Mapping[str, Any]) -> None:
    """Refuse parameters that share a name or a dimension with the grid."""
    grid_dims = {dim for name, values in starts.items() for dim in _dims_of_values(name, values)}
    common = {
        name for name, values in over.items() if set(_dims_of_values(name, values)) & grid_dims
    }
    common |= over.keys() & starts.keys()
    if common:
        raise InputError(
            "over",
            must="have dimensions that the grid does not have",
            got=", ".join(map(repr, sorted(map(str, common)))),
            why="Every set of parameters has all initial states of the grid.",
            fix="Rename the dimension, or leave it out of one of them.",
        )


def _dims_of_values(name: str, values: Any) -> tuple[str, ...]:
    return tuple(map(str, values.dims)) if isinstance(values, xr.DataArray) else (name,)
