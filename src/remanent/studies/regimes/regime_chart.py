"""Charts of regimes over two parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._typing import ArrayLike
from remanent.integrate.ensemble.ensemble import Progress
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.studies.ensemble.ensemble import Over
from remanent.studies.regimes.classify import classify


def regime_chart(
    system: Actuator,
    drive: Drive,
    over: Over,
    *,
    periods: int = 300,
    initial: ArrayLike | None = None,
    tolerance: float = 1e-9,
    rng: np.random.Generator | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Chart the regime of the motion over two parameters.

    Parameters
    ----------
    system, drive
        What moves, and a periodic load.
    over
        Two fields with their values, the axes of the chart.
    periods, initial, tolerance, rng, progress
        As for :func:`remanent.classify`.

    Returns
    -------
    xarray.Dataset
        As of :func:`remanent.classify`, along both axes.

    Raises
    ------
    InputError
        A bad argument, other than two axes, or a load without a period.

    Notes
    -----
    Every point is judged by the same rules as a single motion; the finest charts are not
    cheaper by being less sure.  With 300 periods some more points stay undecided than with
    500: 8 in 100 instead of 4 where the frequency of the undamped actuator is charted
    against its load, b from 0.1 to 1.2.

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
    axes = _axes(over)
    if axes != 2:
        raise InputError(
            "over",
            "have two axes",
            f"{axes}",
            "A chart has two; regimes along other numbers of axes are no chart.",
            "Pass for example {'omega': ..., 'b': ...}, or call rm.classify.",
        )
    return classify(
        system,
        drive,
        periods=periods,
        initial=initial,
        over=over,
        tolerance=tolerance,
        rng=rng,
        progress=progress,
    )


def _axes(over: Any) -> int:
    """How many dimensions the values span."""
    if not isinstance(over, Mapping):
        return 0
    names: set[Any] = set()
    for name, value in over.items():
        names |= set(value.dims) if isinstance(value, xr.DataArray) else {name}
    return len(names)
