"""Basins: where motions from many initial states end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._typing import ArrayLike, IntArray
from remanent.analysis.basins import attractors, settled
from remanent.analysis.regimes import Regime
from remanent.integrate.ensemble.ensemble import Progress
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import require_count, require_periods
from remanent.studies.ensemble.ensemble import ensemble, require_memory
from remanent.studies.regimes._follower import Follower, damped, gathered, labelled
from remanent.studies.regimes.classify import FEWEST, KINDS, WHY, Judged

#: Periods at the end of a run that tell attractors apart.
_TAIL = 128


def basins(
    system: Actuator,
    drive: Drive,
    grid: Mapping[str, ArrayLike],
    *,
    periods: int = 500,
    tolerance: float = 1e-9,
    rng: np.random.Generator | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Say where the motion from each of many initial states ends.

    Parameters
    ----------
    system, drive
        What moves, and a periodic load.
    grid
        State variables with their initial values, ``{"stretch": ..., "stretch_rate": ...}``,
        each ascending; the others start from rest.
    periods
        Length of the runs in smallest periods of the load, at least 100.
    tolerance, rng, progress
        As for :func:`remanent.classify`.

    Returns
    -------
    xarray.Dataset
        Along the variables of the grid all that :func:`remanent.classify` gives, the regime
        and the rotation number above all.  With dissipation also ``basin``, the number
        of the attractor each motion ends on, −1 where its regime is undecided or it escaped;
        and along ``attractor``, the most visited first, ``attractor_regime``,
        ``attractor_period``, ``attractor_state`` (a point of it), the ``fraction`` of the
        initial states that end there and its standard error ``fraction_error``.

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
    """
    periods = require_count("periods", periods, WHY, FEWEST)
    tolerance = require_tolerance(tolerance)
    ens = ensemble(system, drive, _starts(grid))
    length = require_periods(ens)
    require_memory((300.0 + 8.0 * _TAIL * len(ens.field.state)) * ens.count, f"{ens.count} ends")
    seed = 0 if rng is None else int(rng.integers(2**31))
    last = min(_TAIL, periods)
    judged = Judged(Follower(ens, periods, min(2, len(ens.field.state))), tolerance, seed)

    def work(which: IntArray, cancelled: Callable[[], bool]) -> dict[str, np.ndarray]:
        verdict, path = judged.verdict(which, cancelled)
        assert path.visited is not None
        tail = path.visited[:, -last:].copy()
        if judged.damped[which].all():
            tail = settled(judged.iterate(which), tail, verdict.regime, verdict.period)
        return judged.variables(which, verdict, path) | {"tail": tail, "code": verdict.regime}

    shape = (0, last, len(ens.field.state))
    kinds = {**KINDS, "tail": np.empty(shape), "code": np.empty(0, dtype=np.int64)}
    whole = gathered(judged.follower.each(work, progress, most=judged.most), ens, kinds)
    tail, code = whole.pop("tail"), whole.pop("code")
    variables: dict[str, Labelled] = {"drive_period": (ens.dims, ens.shaped(length))}
    for name, values in whole.items():
        variables[name] = (ens.dims, ens.shaped(values))
    coords: dict[str, Labelled] = {}
    if damped(ens).all():
        found = attractors(tail, code, whole["period"])
        variables["basin"] = (ens.dims, ens.shaped(found.which))
        along = ("attractor",)
        names = [Regime(k).meaning for k in code[found.first]]
        variables["attractor_regime"] = (along, np.array(names, dtype="<U14"))
        variables["attractor_period"] = (along, whole["period"][found.first])
        variables["attractor_state"] = ((*along, "state"), tail[found.first, -1])
        share = np.array([np.mean(found.which == k) for k in range(found.first.size)])
        variables["fraction"] = (along, share)
        variables["fraction_error"] = (along, np.sqrt(share * (1.0 - share) / ens.count))
        coords = {
            "attractor": (along, np.arange(found.first.size)),
            "state": (("state",), np.array(ens.field.state)),
        }
    result = labelled(ens, variables, coords, tolerance, periods=periods)
    return result.rename({f"initial.{name}": name for name in grid})


def _starts(grid: Any) -> dict[str, Any]:
    if not isinstance(grid, Mapping) or not grid:
        raise InputError(
            "grid",
            "be a mapping of state variables to values",
            repr(grid)[:80],
            "It says from where the motions start.",
            "Pass for example {'stretch': numpy.linspace(0.5, 2, 64), 'stretch_rate': [0.0]}.",
        )
    return {f"initial.{name}": values for name, values in grid.items()}
