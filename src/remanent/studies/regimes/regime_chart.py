"""Charts of regimes over two parameters."""

from __future__ import annotations

import xarray as xr

from remanent._errors import InputError
from remanent._typing import ArrayLike
from remanent.models.system import System
from remanent.studies.ensemble.checks import DriveArgument, RngArgument, as_seed, require_tolerance
from remanent.studies.ensemble.ensemble import Ensemble
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.regimes._regime_classifier import regime_dataset, require_run_length

#: Axes of a chart.
_AXIS_COUNT = 2


def regime_chart(
    system: System,
    drive: DriveArgument,
    over: OverArgument,
    *,
    periods: int = 300,
    initial: ArrayLike | None = None,
    tolerance: float = 1e-9,
    rng: RngArgument = None,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Chart the regime of the motion over two parameters.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load.
    over : mapping of str to array_like or DataArray
        Two numeric fields with their values: the axes of the chart.
    periods : int
        Length of each run in smallest periods of the load, at least 100.
    initial : array_like (state,), optional
        State at τ = 0: stretch and rate of each coordinate in turn, to which internal variables
        and the temperature may be added; rest, (1, 0), by default.
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
        What :func:`remanent.classify` tells of a motion, along both axes: ``regime``,
        ``period``, the evidence and its ``margin``, ``status``.

    Raises
    ------
    InputError
        A bad argument, other than two axes, or a load without a period.

    See Also
    --------
    remanent.classify : The rules, and the same along any number of parameters.
    remanent.plots.map : A picture of the chart.

    Notes
    -----
    Every point is labelled by the same rules as a single motion, however fine the chart is.
    With fewer periods more points stay undecided.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.regime_chart(
    ...     rm.Actuator(),
    ...     rm.SineSquared(0.4, 1.25),
    ...     {"b": [0.2, 0.3], "omega": [1.7, 2.0]},
    ... )
    >>> ds.regime.dims, set(ds.regime.values.ravel().tolist())
    (('b', 'omega'), {'quasi-periodic'})
    """
    periods = require_run_length(periods)
    tolerance = require_tolerance(tolerance, "the error that one drive period adds")
    ens = lay_out_ensemble(system, drive, over, initial)
    _require_two_axes(ens)
    return regime_dataset(ens, periods, tolerance, as_seed(rng), as_progress(progress))


def _require_two_axes(ens: Ensemble) -> None:
    if len(ens.dimension_sizes) != _AXIS_COUNT:
        raise InputError(
            "over",
            must="have two axes",
            got=f"{len(ens.dimension_sizes)}",
            why="A chart has two; regimes along other numbers of axes are no chart.",
            fix="Pass for example {'omega': ..., 'b': ...}, or call rm.classify.",
        )
