"""Lyapunov exponents: how fast neighbouring motions part."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._typing import ArrayLike, IntArray
from remanent.analysis.lyapunov import exponents
from remanent.integrate.ensemble.ensemble import Progress
from remanent.integrate.maps.period_map import ErrorControl
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import require_count, require_periods
from remanent.studies.ensemble.ensemble import Over, ensemble, require_memory
from remanent.studies.regimes._follower import Follower, gathered, labelled, status_of

#: Most points of the history.
_HISTORY = 100
#: Two runs of a chaotic motion differ by chance, hardly ever by so many standard errors.
_BY_CHANCE = 3.0
#: A tangent with less than this share of the growth of the first is rounding.
_COLLAPSED = 1e-13


def lyapunov(
    system: Actuator,
    drive: Drive,
    *,
    periods: int,
    count: int = 1,
    initial: ArrayLike | None = None,
    over: Over | None = None,
    tolerance: float = 1e-9,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Average the growth of small differences over many drive periods.

    Parameters
    ----------
    system, drive
        What moves, and a periodic load.
    periods
        Length of the run in smallest periods of the load.  The first tenth is left out of
        the average.
    count
        How many exponents, the largest first; at most as many as there are state variables.
    initial, over, progress
        As for :func:`remanent.simulate`.
    tolerance
        Of the error that one drive period adds; as many times as much as the largest state
        variable exceeds 10, so 30 times for the temperature of a body.  Chaotic motion itself
        is known for a short time only; its statistics are those of a motion nearby.

    Returns
    -------
    xarray.Dataset
        ``exponent``, per unit of τ, with a dimension ``exponent_number`` if `count` is above
        1; ``exponent_error``: standard error by batch means, plus the difference from a run
        with steps twice as long; ``exponent_history``, the mean up to each of some
        ``period``; ``drive_period``; ``horizon``, up to which the motion itself is known to
        0.01; ``local_error``, the largest error of one period; ``status``.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    Notes
    -----
    Tangents obey w' = J w along the motion and are made orthonormal again after every few
    periods (W = Q R); the exponent of direction j is the mean of ln R[j, j] over time.
    Source: G. Benettin et al., Meccanica 15 (1980) 9.  With few periods, ``exponent_error``
    is infinite: there are no batches to compare.

    Examples
    --------
    An undamped torus has exponent 0:

    >>> import remanent as rm
    >>> ds = rm.lyapunov(rm.Actuator(), rm.SineSquared(0.4, 1.25), periods=100)
    >>> bool(abs(ds.exponent) < 3 * ds.exponent_error + 0.05)
    True
    """
    periods = require_count("periods", periods, "Exponents are averaged over whole drive periods.")
    count = require_count("count", count, "It is a number of exponents.")
    tolerance = require_tolerance(tolerance)
    ens = ensemble(system, drive, over, initial)
    length = require_periods(ens)
    dimension = len(ens.field.state)
    if count > dimension:
        raise InputError(
            "count",
            f"be at most {dimension}",
            count,
            "There is one exponent for each state variable.",
            f"Pass {dimension} for the whole spectrum.",
        )
    shown = min(periods, _HISTORY)
    require_memory(8.0 * ens.count * count * (shown + 3), f"{ens.count} histories")
    follower = Follower(ens, periods, count)
    block = None if count == 1 else 1
    blocks = follower.blocks(block)
    some = np.unique(np.linspace(0, blocks.size - 1, shown).astype(int))
    ends = np.cumsum(blocks)[some]

    averages = _Averages(follower, tolerance, block, some)
    each = np.empty(0)
    kinds = dict.fromkeys(("horizon", "local_error", "status"), each)
    kinds |= dict.fromkeys(("exponent", "exponent_error"), np.empty((0, count)))
    kinds["exponent_history"] = np.empty((0, ends.size, count))
    whole = gathered(follower.each(averages, progress), ens, kinds)
    number: tuple[str, ...] = ("exponent_number",) if count > 1 else ()
    coords: dict[str, Labelled] = {"period": (("period",), ends)}
    if count > 1:
        coords["exponent_number"] = (number, np.arange(count))
    variables: dict[str, Labelled] = {"drive_period": (ens.dims, ens.shaped(length))}
    for name in ("exponent", "exponent_error"):
        values = whole[name] if count > 1 else whole[name][:, 0]
        variables[name] = ((*ens.dims, *number), ens.shaped(values))
    history = whole["exponent_history"]
    history = history if count > 1 else history[..., 0]
    variables["exponent_history"] = ((*ens.dims, "period", *number), ens.shaped(history))
    for name in ("horizon", "local_error", "status"):
        variables[name] = (ens.dims, ens.shaped(whole[name]))
    return labelled(ens, variables, coords, tolerance, periods=periods, count=count)


@dataclass(frozen=True)
class _Averages:
    """Exponents of some of a follower's trajectories, with their errors.

    Attributes
    ----------
    block
        Periods between renormalisations, by default what suits one tangent.
    shown
        Numbers of the blocks after which the mean is kept.
    """

    follower: Follower
    tolerance: float
    block: int | None
    shown: IntArray

    def __call__(self, which: IntArray, cancelled: Callable[[], bool]) -> dict[str, np.ndarray]:
        if self.follower.directions > 1:  # their sums are known better than each of them
            found = self._measured(which, "all", cancelled)
        else:
            found = self._measured(which, "state", cancelled)
            # Where steps matter more than chance, the tangent decides on them too.
            limit = np.maximum(self.tolerance, _BY_CHANCE * found["scatter"])
            again = (found["difference"] > limit).any(axis=1)
            if again.any():
                better = self._measured(which[again], "all", cancelled)
                for name, values in found.items():
                    values[again] = better[name]
        found["exponent_error"] = found.pop("scatter") + found.pop("difference")
        return found

    def _measured(
        self, which: IntArray, error_control: ErrorControl, cancelled: Callable[[], bool]
    ) -> dict[str, np.ndarray]:
        """Means of two runs: those of the first, their scatter, and how far the others are."""
        path, other = self.follower.follow_with_doubled_steps(
            which,
            self.tolerance,
            error_control=error_control,
            block=self.block,
            cancelled=cancelled,
        )
        fine, coarse = (exponents(p.growth, p.lengths) for p in (path, other))
        tau = self.follower.lengths[which]
        # Tangents that lined up within a period leave a bound, not a value.
        collapsed = (path.growth - path.growth[:, :, :1] < np.log(_COLLAPSED)).any(axis=1)
        return {
            "exponent": fine.mean / tau[:, None],
            "scatter": np.where(collapsed, np.inf, fine.error) / tau[:, None],
            "difference": np.abs(fine.mean - coarse.mean) / tau[:, None],
            "exponent_history": fine.history[:, self.shown] / tau[:, None, None],
            "horizon": path.horizon * tau,
            "local_error": path.error,
            "status": status_of(path),
        }
