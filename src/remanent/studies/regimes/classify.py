"""Regimes of motion: periodic, quasi-periodic, chaotic, or not decided."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import xarray as xr

from remanent._typing import ArrayLike, FloatArray, IntArray
from remanent.analysis import regimes
from remanent.analysis.following import Path
from remanent.analysis.regimes import Regime, Verdict
from remanent.analysis.returns import Iterate
from remanent.integrate.ensemble.ensemble import Progress
from remanent.models.actuator import Actuator
from remanent.models.drives.base import Drive
from remanent.results.build import Labelled
from remanent.studies.ensemble.checks import require_tolerance
from remanent.studies.ensemble.durations import require_count, require_periods
from remanent.studies.ensemble.ensemble import Over, ensemble, require_memory
from remanent.studies.regimes._follower import Follower, damped, gathered, labelled, status_of

#: Factors between the tolerances that have to agree.
_TOLERANCES = (1.0, 10.0, 100.0)
#: Shorter runs say nothing of their regime.
FEWEST = 100
_EVIDENCE = ("digits", "zero_one", "sali", "rotation_number", "rotation_digits", "defect")
#: Types of what is told of each trajectory.
KINDS: Mapping[str, np.ndarray] = {
    "regime": np.empty(0, dtype="<U14"),
    "period": np.empty(0, dtype=np.int64),
    **dict.fromkeys(("margin", "exponent", "exponent_error"), np.empty(0)),
    **dict.fromkeys(("horizon", "local_error", "status"), np.empty(0)),
    **dict.fromkeys(_EVIDENCE, np.empty(0)),
}
WHY = "A regime shows in a long run."


def classify(
    system: Actuator,
    drive: Drive,
    *,
    periods: int,
    initial: ArrayLike | None = None,
    over: Over | None = None,
    tolerance: float = 1e-9,
    rng: np.random.Generator | None = None,
    progress: Progress | None = None,
) -> xr.Dataset:
    """Say what kind of motion each is, where independent indicators agree.

    Parameters
    ----------
    system, drive
        What moves, and a periodic load.
    periods
        Length of the run in smallest periods of the load, at least 100.  With 500 most
        motions show what they are; 2000 leave few undecided.
    initial, over, progress
        As for :func:`remanent.simulate`.
    tolerance
        Of the error that one drive period adds, at the finest of the tolerances tried; where
        a state variable exceeds 10, as a body's temperature does, so many times as much.
        Motions are followed at 100 and at 10 times as much; those that are not regular at
        both are followed at this one too.
    rng
        Draws the frequencies of the 0-1 test; by default the same every time.

    Returns
    -------
    xarray.Dataset
        ``regime``: ``periodic``, ``quasi-periodic``, ``chaotic``, ``escaped`` or
        ``undecided``; ``period`` where periodic, in drive periods, else 0;
        ``rotation_number``, turns per drive period about the middle of the section, in
        [0, 1), NaN where the section does not surround it, and the digits of it that have
        converged; ``margin``, the factor by which the weakest evidence clears its line.
        The evidence: ``exponent`` per unit of τ with ``exponent_error`` (standard error, and
        spread over the tolerances), ``digits`` of weighted averages, ``zero_one``, ``sali``
        (NaN unless the finest tolerance was needed), ``defect`` of the return;
        ``horizon``, ``local_error``, ``status``.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    Notes
    -----
    ``chaotic`` needs an exponent above 0 by three standard errors, the same at three
    tolerances, and averages that do not converge; damped motion has to stay so for two
    more runs, and so have sixteen that start beside it.  ``quasi-periodic`` needs tangents that
    grow like a power of time, averages that converge, and a 0-1 test near 0.  ``periodic``
    needs the orbit to close, or, where it still settles, a stable periodic orbit found by
    Newton's method that it approaches at the rate of its multiplier.  Where motion is
    damped the first half of the run is left out.  Sticky motion at the edge of an island is
    meant to be ``undecided``, and is so until it leaves; nobody can tell what it does after
    the run.  Sources: S. Das et al., Nonlinearity 30 (2017) 4111; G. A. Gottwald and I.
    Melbourne, SIAM J. Appl. Dyn. Syst. 8 (2009) 129; C. Skokos, J. Phys. A 34 (2001) 10029.

    Examples
    --------
    >>> import remanent as rm
    >>> ds = rm.classify(
    ...     rm.Actuator(dissipation=rm.Rayleigh(0.2)), rm.SineSquared(0.4, 1.25), periods=200
    ... )
    >>> str(ds.regime.values), int(ds.period)
    ('periodic', 1)
    """
    periods = require_count("periods", periods, WHY, FEWEST)
    tolerance = require_tolerance(tolerance)
    ens = ensemble(system, drive, over, initial)
    length = require_periods(ens)
    require_memory(300.0 * ens.count, f"{ens.count} labels")
    seed = 0 if rng is None else int(rng.integers(2**31))
    judged = Judged(Follower(ens, periods, min(2, len(ens.field.state))), tolerance, seed)
    parts = judged.follower.each(judged.chunk, progress, most=judged.most)
    whole = gathered(parts, ens, KINDS)
    variables: dict[str, Labelled] = {"drive_period": (ens.dims, ens.shaped(length))}
    for name, values in whole.items():
        variables[name] = (ens.dims, ens.shaped(values))
    return labelled(ens, variables, {}, tolerance, periods=periods)


class Judged:
    """Labels trajectories of an ensemble, a chunk at a time."""

    def __init__(self, follower: Follower, tolerance: float, seed: int) -> None:
        self.follower, self.tolerance, self.seed = follower, tolerance, seed
        self.damped = damped(follower.ensemble)
        #: Trajectories in a chunk: many share a resolution, and their states stay below 40 MB.
        self.most = int(np.clip(2**20 // follower.periods, 16, 4096))

    def verdict(
        self, which: IntArray, cancelled: Callable[[], bool] = lambda: False
    ) -> tuple[Verdict, Path]:
        """Label some trajectories."""
        follower = self.follower

        def run(some: IntArray, n: int, states: FloatArray | None = None, /) -> Path:
            return follower.run(
                which[some],
                self.tolerance * _TOLERANCES[n],
                states,
                directions=follower.directions if n == 0 else 1,
                every=True,
                cancelled=cancelled,
            )

        return regimes.classify(
            run, which.size, damped=self.damped[which], iterate=self.iterate(which), seed=self.seed
        )

    def iterate(self, which: IntArray) -> Iterate:
        """Images and Jacobians of some trajectories' maps at the finest tolerance."""
        dimension = len(self.follower.ensemble.field.state)
        finest = self.follower.advancer(which, self.tolerance, directions=dimension)

        def image(some: IntArray, states: FloatArray, period: int) -> tuple[FloatArray, FloatArray]:
            unit = np.tile(np.eye(dimension), (some.size, 1, 1))
            found = finest(some, states, unit, period, every=False)
            return found.visited[:, -1], np.moveaxis(found.tangents, 1, 2)

        return image

    def chunk(self, which: IntArray, cancelled: Callable[[], bool]) -> dict[str, np.ndarray]:
        """Label some trajectories: variables by name."""
        verdict, path = self.verdict(which, cancelled)
        return self.variables(which, verdict, path)

    def variables(self, which: IntArray, verdict: Verdict, path: Path) -> dict[str, np.ndarray]:
        """What is told of some trajectories, by name."""
        tau = self.follower.lengths[which]
        values = {
            "regime": np.array([Regime(code).meaning for code in verdict.regime], dtype="<U14"),
            "period": verdict.period,
            "margin": verdict.margin,
            "exponent": verdict.evidence.exponent / tau,
            "exponent_error": verdict.exponent_error / tau,
            "horizon": path.horizon * tau,
            "local_error": path.error,
            "status": status_of(path),
        }
        return values | {name: getattr(verdict.evidence, name) for name in _EVIDENCE}
