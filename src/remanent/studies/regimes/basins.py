"""Basins: where motions from many initial states end."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._typing import ArrayLike, BoolArray, IntArray
from remanent.models.drives.base import Drive
from remanent.models.system import System
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import Rng, as_seed, require_tolerance
from remanent.studies.ensemble.dataset import PerTrajectory, to_dataset
from remanent.studies.ensemble.durations import require_periods
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import RESERVED, Over, lay_out
from remanent.studies.ensemble.memory import require_memory
from remanent.studies.ensemble.progress import Progress, as_progress
from remanent.studies.regimes._arguments import renamed
from remanent.studies.regimes._attractors import (
    ATTRACTOR,
    TAIL,
    EndClassifier,
    Ends,
    attractor_table,
    basin_numbers,
)
from remanent.studies.regimes._regime_classifier import (
    BYTES_PER_LABEL,
    RegimeClassifier,
    require_run_length,
)

#: Names of dimensions that results have of their own.
_RESERVED = RESERVED | {ATTRACTOR, "state"}


def basins(
    system: System,
    drive: Drive,
    grid: Mapping[str, ArrayLike],
    *,
    periods: int = 500,
    over: Over | None = None,
    tolerance: float = 1e-9,
    rng: Rng = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Say where the motion from each of many initial states ends.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive
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
        seed.  A generator is copied: it is not advanced.
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
        ``fraction``, ``fraction_error``
            The fraction of the initial states that end there, and its standard error.

        With `over` attractors are numbered anew for each set of parameters; where one has
        fewer than another, the rest is NaN, 0 or an empty text.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    Notes
    -----
    The standard error is the binomial one, of states drawn at random from the grid's box.
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

    See Also
    --------
    remanent.classify : the rules by which regimes are told apart.
    remanent.periodic_orbits : all orbits, the unstable ones between basins too.
    remanent.manifold_crossing : where a basin's boundary passes through a state.
    """
    periods = require_run_length(periods)
    tolerance = require_tolerance(tolerance, "the error that one drive period adds")
    layout = _Layout.of(system, drive, grid, over)
    ens = layout.ensemble
    period_lengths = require_periods(ens)
    needed = (BYTES_PER_LABEL + 8.0 * TAIL * len(ens.field.state)) * ens.count
    require_memory("grid", needed, f"{ens.count} ends")
    classifier = RegimeClassifier.of(ens, periods, tolerance, as_seed(rng))
    work = EndClassifier(classifier, min(TAIL, periods))
    values = classifier.compute(work, work.templates, as_progress(progress))
    tail, code = values.pop("tail"), values.pop("code")
    variables: dict[str, PerTrajectory] = {"drive_period": period_lengths, **values}
    shared: dict[str, Labelled] = {}
    coords: dict[str, Labelled] = {}
    if classifier.damped.any():
        ends = layout.ends(tail, code, values["period"], classifier.damped)
        attractors = ends.sort()
        variables["basin"] = basin_numbers(attractors, ends.starts)
        shared = attractor_table(ends, attractors, layout.dims, layout.shape)
        numbers = np.arange(shared["fraction"][1].shape[-1])
        coords = {
            ATTRACTOR: ((ATTRACTOR,), numbers),
            "state": (("state",), np.array(ens.field.state)),
        }
    result = to_dataset(
        ens, variables, shared=shared, coords=coords, tolerance=tolerance, periods=periods
    )
    return result.rename({f"initial.{name}": name for name in grid})


@dataclass(frozen=True)
class _Layout:
    """Initial states on a grid, for each set of parameters.

    Attributes
    ----------
    ensemble : Ensemble
        The parameters' dimensions first, then those of the grid.
    dims, shape
        Names and lengths of the parameters' dimensions.
    """

    ensemble: Ensemble
    dims: tuple[str, ...]
    shape: tuple[int, ...]

    @classmethod
    def of(cls, system: System, drive: Drive, grid: Any, over: Over | None) -> _Layout:
        starts = _starts(grid)
        base = lay_out(system, drive, over, reserved=_RESERVED)
        _require_states(grid, base)
        _require_apart(over or {}, starts)
        own_names = {
            f"over[{start!r}]": f"grid[{name!r}]" for name, start in zip(grid, starts, strict=True)
        }
        with renamed(own_names):
            ens = lay_out(system, drive, {**(over or {}), **starts}, reserved=_RESERVED)
        grid_dims, _ = ens.coords[next(iter(starts))]
        split = ens.dims.index(grid_dims[0])
        return cls(ens, ens.dims[:split], tuple(ens.sizes.values())[:split])

    def ends(self, tail: np.ndarray, regime: IntArray, period: IntArray, damped: BoolArray) -> Ends:
        """How motions end, arrays (trajectory, ...), with an axis for the parameters."""

        def apart(values: Any) -> Any:
            return values.reshape(math.prod(self.shape), -1, *values.shape[1:])

        return Ends(apart(tail), apart(regime), apart(period), apart(damped)[:, 0])


def _starts(grid: Any) -> dict[str, Any]:
    if not isinstance(grid, Mapping) or not grid:
        raise InputError(
            "grid",
            must="be a mapping of state variables to values",
            got=repr(grid)[:80],
            why="It says from where the motions start.",
            fix="Pass for example {'stretch': numpy.linspace(0.5, 2, 64), 'stretch_rate': [0.0]}.",
        )
    return {f"initial.{name}": values for name, values in grid.items()}


def _require_states(grid: Mapping[str, Any], ens: Ensemble) -> None:
    unknown = [name for name in grid if name not in ens.field.state]
    if unknown:
        raise InputError(
            "grid",
            must="name state variables",
            got=", ".join(map(repr, unknown)),
            why="It says from where the motions start.",
            fix=f"They are {', '.join(ens.field.state)}.",
        )


def _require_apart(over: Mapping[str, Any], starts: Mapping[str, Any]) -> None:
    """Refuse parameters that share a name or a dimension with the grid."""
    grid_dims = {dim for name, values in starts.items() for dim in _dims(name, values)}
    common = {name for name, values in over.items() if set(_dims(name, values)) & grid_dims}
    common |= over.keys() & starts.keys()
    if common:
        raise InputError(
            "over",
            must="have dimensions that the grid does not have",
            got=", ".join(map(repr, sorted(map(str, common)))),
            why="Every set of parameters has all initial states of the grid.",
            fix="Rename the dimension, or leave it out of one of them.",
        )


def _dims(name: str, values: Any) -> tuple[str, ...]:
    return tuple(map(str, values.dims)) if isinstance(values, xr.DataArray) else (name,)
