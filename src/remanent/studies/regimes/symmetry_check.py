"""Whether equal in-plane stretches stay equal: the growth of their difference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from remanent._errors import InputError
from remanent._typing import ArrayLike, FloatArray, IntArray
from remanent.analysis.following import Path, follow
from remanent.analysis.orbits import multipliers
from remanent.integrate.ensemble.ensemble import Progress
from remanent.integrate.maps.advance import Step
from remanent.integrate.maps.period_map import PeriodMap
from remanent.integrate.variations import transverse_field
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import require_count, require_periods
from remanent.studies.ensemble.ensemble import Ensemble, Over, ensemble, problem
from remanent.studies.ensemble.two_coordinates import two_coordinates
from remanent.studies.regimes._follower import CHUNK, Follower, gathered, labelled, status_of

#: Shorter runs cannot tell growth like a power of time from an exponential one.
FEWEST = 50
#: Differences grow at most like n e^EXCESS where they do not grow exponentially, and at
#: least like n^POWER e^(2 EXCESS), and by e^HALF in each half of the run, where they do.
_EXCESS, _POWER, _HALF = 2.0, 1.5, 2.0
#: A motion that closes within this after one period has multipliers.
_CLOSED = 1e-6
#: Size with which differences enter, as tangents do elsewhere.
_SIZE = 1e-3


def symmetry_check(
    system: Actuator,
    drive: Drive,
    *,
    periods: int = 200,
    initial: ArrayLike | None = None,
    over: Over | None = None,
    tolerance: float = 1e-9,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Say whether the model of one coordinate holds: whether equal stretches stay equal.

    Parameters
    ----------
    system
        With equal dead loads and edges, of one coordinate.
    drive
        A periodic load.
    periods
        Length of the run in smallest periods of the load, at least 50.
    initial, over, progress
        As for :func:`remanent.simulate`; the motion is that of one coordinate.
    tolerance
        Of the error that one drive period adds.

    Returns
    -------
    xarray.Dataset
        ``symmetry``: ``kept``, ``lost`` or ``undecided``; ``transverse_growth``, the logarithm
        of the growth of a difference λ₁ − λ₂ over the run, the largest of all directions
        and times; ``transverse_exponent`` per unit of τ, over the second half.  Where the
        motion closes after one drive period, ``transverse_multipliers``, the Floquet
        multipliers of the difference, else NaN.  ``local_error``, ``status``.

    Raises
    ------
    InputError
        A bad argument, a load without a period, or an actuator of two coordinates.

    Notes
    -----
    The equations of both coordinates are linearised about the motion with λ₁ = λ₂; the
    difference a of the stretches obeys a'' = −3[θ(1 + λ⁻⁶) − mλ⁻⁴] a without dissipation,
    and differences of viscous stretches follow it.  It is parametrically driven: the
    symmetry is lost in tongues, at resonance with half the drive's frequency or the
    motion's above all.  Nothing else than the growth of small differences is looked at; the
    run itself stays symmetric.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.symmetry_check(rm.Actuator(), rm.SineSquared(0.4, 2.0))
    >>> str(ds.symmetry.values)
    'kept'
    """
    periods = require_count("periods", periods, "Growth shows in a long run.", FEWEST)
    tolerance = require_tolerance(tolerance)
    ens = ensemble(system, drive, over, initial)
    length = require_periods(ens)
    apart = _Apart.of(ens, tolerance)
    follower = Follower(ens, periods, 0)
    parts = follower.each(
        lambda which, cancelled: apart.judged(which, periods, cancelled), progress, most=CHUNK
    )
    d = apart.width
    kinds = {
        "symmetry": np.empty(0, dtype="<U9"),
        **dict.fromkeys(("transverse_growth", "transverse_exponent"), np.empty(0)),
        "transverse_multipliers": np.empty((0, d), dtype=complex),
        **dict.fromkeys(("local_error", "status"), np.empty(0)),
    }
    whole = gathered(parts, ens, kinds)
    variables: dict[str, Labelled] = {"drive_period": (ens.dims, ens.shaped(length))}
    for name, values in whole.items():
        dims = (*ens.dims, "multiplier") if values.ndim > 1 else ens.dims
        variables[name] = (dims, ens.shaped(values))
    coords: dict[str, Labelled] = {"multiplier": (("multiplier",), np.arange(d))}
    return labelled(ens, variables, coords, tolerance, periods=periods)


@dataclass(frozen=True)
class _Apart:
    """Follows differences of an ensemble's in-plane stretches."""

    ens: Ensemble
    flow: PeriodMap
    parameters: FloatArray
    lengths: FloatArray
    width: int
    tolerance: float

    @classmethod
    def of(cls, ens: Ensemble, tolerance: float) -> _Apart:
        if ens.system.coordinates != 1:
            raise InputError(
                "actuator",
                "have one coordinate",
                ens.system,
                "What is asked is whether that one is enough.",
                "Pass one number as prestress, and no edges.",
            )
        two, pairs = two_coordinates(ens)
        field = transverse_field(two.field, pairs)
        asked = problem(two, np.ones(ens.count))
        lengths = np.where(ens.invalid, 1.0, require_periods(ens))
        flow = PeriodMap(field, asked.timeline.waveform)
        return cls(ens, flow, asked.parameters, lengths, len(pairs), tolerance)

    def judged(self, which: IntArray, periods: int, cancelled: Any) -> dict[str, np.ndarray]:
        """What is told of some trajectories."""
        start = self.ens.initial[which]

        path = follow(
            _Some(self, which), start, periods, directions=self.width, width=self.width, block=1,
            cancelled=cancelled,
        )  # fmt: skip
        unit = np.tile(np.eye(self.width), (which.size, 1, 1))
        once = self.advanced(which, start, unit, 1)
        values, _ = multipliers(np.moveaxis(once.tangents, 1, 2), once.error)
        values[np.abs(once.visited[:, -1] - start).max(axis=1) > _CLOSED] = np.nan
        tau = self.lengths[which]
        verdict, growth, exponent = _verdict(path, periods)
        return {
            "symmetry": verdict,
            "transverse_growth": growth,
            "transverse_exponent": exponent / tau,
            "transverse_multipliers": values,
            "local_error": path.error,
            "status": status_of(path),
        }

    def advanced(self, which: IntArray, states: FloatArray, frame: FloatArray, n: int) -> Step:
        """Advance motions with several differences each, as so many trajectories."""
        many = frame.shape[1]
        start = np.repeat(states, many, axis=0)
        rows = np.repeat(which, many)
        image = self.flow(
            np.concatenate([start, _SIZE * frame.reshape(-1, self.width)], axis=1),
            self.parameters[rows],
            self.lengths[rows],
            tolerance=self.tolerance,
            cycles=n,
        )
        d = states.shape[1]
        error = image.error.reshape(-1, many).max(axis=1)
        ends = image.state[:, d:].reshape(-1, many, self.width) / _SIZE
        return Step(image.state[::many, None, :d], ends, error, error <= self.tolerance)


@dataclass(frozen=True)
class _Some:
    """Some of the motions, by their number among these."""

    whole: _Apart
    which: IntArray

    def __call__(
        self,
        which: IntArray,
        states: FloatArray,
        tangents: FloatArray,
        periods: int,
        *,
        every: bool,
    ) -> Step:
        """Advance them; only the last state is ever wanted."""
        assert not every
        return self.whole.advanced(self.which[which], states, tangents, periods)


def _verdict(path: Path, periods: int) -> tuple[np.ndarray, FloatArray, FloatArray]:
    """The label, the largest logarithm of the growth, and the exponent per period."""
    logs = _norms(path.factors)
    with np.errstate(invalid="ignore"):
        growth = logs.max(axis=1)
        middle = logs[:, periods // 2]
        halves = np.minimum(middle, logs[:, -1] - middle)
        kept = growth <= np.log(periods) + _EXCESS
        lost = (growth >= _POWER * np.log(periods) + 2.0 * _EXCESS) & (halves >= _HALF)
        exponent = (logs[:, -1] - middle) / (periods - periods // 2 - 1)
    return np.where(kept, "kept", np.where(lost, "lost", "undecided")), growth, exponent


def _norms(factors: FloatArray) -> FloatArray:
    """Logarithm of the largest growth of any difference up to each block, (point, block).

    The rows of a frame become R^T Q in each block; what counts is the largest singular value
    of the product of the R^T.
    """
    points, blocks, d, _ = factors.shape
    product = np.tile(np.eye(d), (points, 1, 1))
    logs, size = np.full((points, blocks), np.nan), np.zeros(points)
    for k in range(blocks):
        known = np.isfinite(factors[:, k]).all(axis=(1, 2))
        product[known] = product[known] @ np.swapaxes(factors[known, k], 1, 2)
        norm = np.linalg.norm(product, 2, axis=(1, 2))
        product /= norm[:, None, None]
        size += np.log(norm)
        logs[known, k] = size[known]
    return logs
