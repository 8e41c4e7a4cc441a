"""Regimes of motion: periodic, quasi-periodic, chaotic, or not decided."""

from __future__ import annotations

import xarray as xr

from remanent._typing import ArrayLike
from remanent.models.system import System
from remanent.studies.ensemble.checks import DriveArgument, RngArgument, as_seed, require_tolerance
from remanent.studies.ensemble.layout import OverArgument, lay_out_ensemble
from remanent.studies.ensemble.progress import ProgressArgument, as_progress
from remanent.studies.regimes._regime_classifier import regime_dataset, require_run_length


def classify(
    system: System,
    drive: DriveArgument,
    *,
    periods: int,
    initial: ArrayLike | None = None,
    over: OverArgument | None = None,
    tolerance: float = 1e-9,
    rng: RngArgument = None,
    progress: ProgressArgument = None,
) -> xr.Dataset:
    """Say what kind of motion each is, where independent indicators agree.

    Parameters
    ----------
    system : System
        What moves.
    drive : Drive, or mapping of str to Drive
        A periodic load.
    periods : int
        Length of the run in smallest periods of the load, at least 100.  With 500 most
        motions show what they are; 2000 leave few undecided.
    initial : array_like (state,), optional
        State at τ = 0: stretch and rate of each coordinate in turn, to which internal variables
        and the temperature may be added; rest, (1, 0), by default.
    over : mapping of str to array_like or DataArray, optional
        Values of numeric fields of the system, the drive or the initial state; they become
        dimensions of the result.
    tolerance : float
        Bound of the error that one drive period adds, at the finest of the tolerances tried.
        Where a state variable exceeds 10, as a body's temperature does, the bound is relative
        to a tenth of it.  Motions are followed at 100 and at 10 times the bound; those that
        are not regular at both are followed at the bound itself too.
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
        Along the dimensions of `over`:

        ``regime``
            ``periodic``, ``quasi-periodic``, ``chaotic``, ``escaped`` or ``undecided``.
        ``period``
            Of periodic motion, in drive periods, else 0.
        ``margin``
            The factor by which the weakest evidence clears its threshold.
        ``rotation_number``, ``rotation_number_error``, ``rotation_digits``
            Turns per drive period about the middle of the section, in [0, 1), NaN where the
            section is not seen to surround it; its error, from the differences of windows of two
            thirds of the run, that of two tolerances, and the error that one period adds; how
            many digits the first and the last two thirds of the run have in common.
        ``exponent``, ``exponent_error``
            The largest Lyapunov exponent per unit of τ.  Of periodic motion that of the orbit,
            from its multipliers; else the mean with its standard error, as for
            :func:`remanent.lyapunov`, combined with the spread over the tolerances.
        ``digits``, ``zero_one``, ``sali``, ``defect``
            The rest of the evidence: digits to which weighted averages converge, the 0-1
            test, the smaller alignment index (NaN unless the finest tolerance was needed),
            the defect of the best return.  These describe the run and are compared with
            thresholds; they estimate no number beyond the run, and like ``margin`` they have no
            error.  What they leave open makes the regime ``undecided``.
        ``drive_period``, ``horizon``, ``local_error``, ``status``, ``reason``
            Of the run: the load's period, exact but for rounding; how long the motion itself is
            known to 0.01 and the largest error of one period, themselves estimates of errors;
            what became of it; and why there is no exponent where there is none.

    Raises
    ------
    InputError
        A bad argument, or a load without a period.

    See Also
    --------
    remanent.regime_chart : The same along two parameters.
    remanent.basins : The same for many initial states, with the attractors.
    remanent.lyapunov : Exponents alone.

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
    periods = require_run_length(periods)
    tolerance = require_tolerance(tolerance, "the error that one drive period adds")
    ens = lay_out_ensemble(system, drive, over, initial)
    return regime_dataset(ens, periods, tolerance, as_seed(rng), as_progress(progress))
