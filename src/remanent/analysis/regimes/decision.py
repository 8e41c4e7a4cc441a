"""What kind of motion an orbit is: a label only where independent indicators agree.

Three kinds of evidence are weighed, at more than one tolerance: the growth of tangents, the
convergence of weighted averages along the orbit, and its return to the same point.  Where
they disagree, or where the run is too short for them to speak, the label is `undecided`.

The decision is a row of steps, each of which takes the labelling so far and returns a new
one.  :func:`decide_regimes` names them in order; a new step goes between two of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.analysis.regimes.evidence import EvidenceTable
from remanent.analysis.regimes.labels import Regime, RegimeLabels
from remanent.analysis.regimes.limit_orbits import IterateMap, settling_periods
from remanent.analysis.regimes.long_runs import LongRun
from remanent.analysis.regimes.problem import RegimeProblem
from remanent.analysis.regimes.transients import LOOSEST, chaos_lasts

#: An orbit that returns worse than this, relative to its extent, is not settling yet.
_MAX_SETTLING_DEFECT = 0.5
#: An orbit that returns better than this, relative to its extent, has settled.
_MAX_SETTLED_DEFECT = 1e-10


@dataclass(frozen=True)
class Labelling:
    """Labels as far as the steps have come; every step returns a new one.

    Attributes
    ----------
    regime, period : array (orbit,) of int
    margin : array (orbit,)
    evidence : EvidenceTable
        At the finest tolerance so far.
    exponent_spread : array (orbit,)
        Of the exponents at the tolerances so far.
    run : LongRun
        At the finest tolerance so far.
    """

    regime: IntArray
    period: IntArray
    margin: FloatArray
    evidence: EvidenceTable
    exponent_spread: FloatArray
    run: LongRun

    def labels(self) -> RegimeLabels:
        """The labels with their evidence."""
        error = np.hypot(self.evidence.exponent_error, self.exponent_spread)
        return RegimeLabels(self.regime, self.period, self.margin, self.evidence, error)


def decide_regimes(problem: RegimeProblem) -> tuple[RegimeLabels, LongRun]:
    """Label many orbits.

    Parameters
    ----------
    problem : RegimeProblem
        The orbits, and what follows them.

    Returns
    -------
    RegimeLabels
    LongRun
        At the finest tolerance at which each orbit was followed; its tangents are not kept.

    Notes
    -----
    Most orbits of a chart are regular, and two loose tolerances suffice to see that.  So all
    orbits are screened at these two, and the finest tolerance is kept for the others.
    """
    labelling, loosest, disputed = screen(problem)
    labelling = refine_disputed(problem, labelling, loosest, disputed)
    labelling = confirm_chaos(problem, labelling)
    labelling = withhold_untrusted(labelling)
    labelling = read_periods(labelling)
    labelling = find_settling_orbits(problem, labelling)
    labelling = reduce_periods(problem, labelling)
    labelling = mark_escapes(labelling)
    return labelling.labels(), labelling.run


def screen(problem: RegimeProblem) -> tuple[Labelling, EvidenceTable, IntArray]:
    """Follow every orbit at the two loosest tolerances.

    Returns
    -------
    labelling : Labelling
        What both tolerances agree on, with the evidence of the finer.
    loosest : EvidenceTable
        The evidence at the loosest tolerance.
    disputed : array (orbit,) of int
        Orbits that need the finest tolerance: those that escape in one run alone, and those
        that both runs do not call regular.
    """
    everyone = np.arange(problem.count)
    first = problem.run(everyone, LOOSEST)
    loosest = problem.evidence(first, everyone)
    # An orbit whose error was not met at the loosest tolerance will not meet a finer one.
    trusted = np.flatnonzero(first.trusted)
    second = problem.run(trusted, LOOSEST - 1)
    evidence = loosest.with_rows(trusted, problem.evidence(second, trusted))
    regime, margin = problem.agreed([evidence, loosest], everyone, first.periods)
    run = first.with_rows(trusted, second)

    regular = np.isin(regime[trusted], (Regime.PERIODIC, Regime.QUASI_PERIODIC))
    unclear = (first.escaped[trusted] != second.escaped) | (~run.escaped[trusted] & ~regular)
    disputed = trusted[unclear & run.trusted[trusted]]

    labelling = Labelling(
        regime=regime,
        period=np.zeros(problem.count, dtype=np.int64),
        margin=margin,
        evidence=evidence,
        exponent_spread=np.abs(evidence.exponent - loosest.exponent),
        run=run,
    )
    return labelling, loosest, disputed


def refine_disputed(
    problem: RegimeProblem, labelling: Labelling, loosest: EvidenceTable, disputed: IntArray
) -> Labelling:
    """Follow the disputed orbits at the finest tolerance, and judge them again.

    The two finer runs have to agree.  Chaos needs all three: errors of integration can carry
    regular motion into a chaotic layer, but hardly at three tolerances alike.

    Parameters
    ----------
    loosest : EvidenceTable
        The evidence of all orbits at the loosest tolerance.
    disputed : array (orbit,) of int
    """
    if not disputed.size:
        return labelling
    run = problem.run(disputed, 0)
    finest = problem.evidence(run, disputed)
    runs = [finest, labelling.evidence.subset(disputed), loosest.subset(disputed)]
    by_two, margin_by_two = problem.agreed(runs[:2], disputed, labelling.run.periods)
    by_three, margin_by_three = problem.agreed(runs, disputed, labelling.run.periods)
    chaotic = by_two == Regime.CHAOTIC
    exponents = np.array([evidence.exponent for evidence in runs])
    return replace(
        labelling,
        regime=_put(labelling.regime, disputed, np.where(chaotic, by_three, by_two)),
        margin=_put(labelling.margin, disputed, np.where(chaotic, margin_by_three, margin_by_two)),
        evidence=labelling.evidence.with_rows(disputed, finest),
        exponent_spread=_put(labelling.exponent_spread, disputed, np.ptp(exponents, axis=0)),
        run=labelling.run.with_rows(disputed, run),
    )


def confirm_chaos(problem: RegimeProblem, labelling: Labelling) -> Labelling:
    """Take the label from damped chaos that ends within two more runs.

    Motion without damping has no attractor on which it could settle.
    """
    chaotic = np.flatnonzero(problem.damped & (labelling.regime == Regime.CHAOTIC))
    lasts = chaos_lasts(
        problem.run, chaotic, labelling.run.last_state[chaotic], problem.thresholds.min_half_growth
    )
    passing = chaotic[~lasts]
    return replace(
        labelling,
        regime=_put(labelling.regime, passing, Regime.UNDECIDED),
        margin=_put(labelling.margin, passing, np.nan),
    )


def withhold_untrusted(labelling: Labelling) -> Labelling:
    """Say nothing of orbits whose error bound was not met."""
    untrusted = np.flatnonzero(~labelling.run.trusted)
    return replace(labelling, regime=_put(labelling.regime, untrusted, Regime.UNDECIDED))


def read_periods(labelling: Labelling) -> Labelling:
    """Take the periods of periodic orbits from their best returns."""
    periodic = labelling.regime == Regime.PERIODIC
    return replace(labelling, period=np.where(periodic, labelling.evidence.period, 0))


def find_settling_orbits(problem: RegimeProblem, labelling: Labelling) -> Labelling:
    """Label damped motion that is seen to approach a stable periodic orbit.

    Only motion whose tangents shrink and that already returns to its neighbourhood is looked
    at: Newton's method from anywhere else would find orbits that have nothing to do with it.
    """
    run, evidence = labelling.run, labelling.evidence
    if problem.iterate is None:
        return labelling
    open_question = (labelling.regime == Regime.UNDECIDED) & ~run.escaped & run.trusted
    contracting = (evidence.exponent < 0.0) & (evidence.late_defect < _MAX_SETTLING_DEFECT)
    candidates = np.flatnonzero(problem.damped & open_question & contracting)
    period = _settling_periods(problem.iterate, run, candidates, evidence.period[candidates])
    settling = candidates[period > 0]
    return replace(
        labelling,
        regime=_put(labelling.regime, settling, Regime.PERIODIC),
        period=_put(labelling.period, settling, period[period > 0]),
        margin=_put(labelling.margin, settling, 1.0),
    )


def reduce_periods(problem: RegimeProblem, labelling: Labelling) -> Labelling:
    """Replace a multiple of the period by the period, where motion still settles.

    While the approach alternates between two sides of an orbit of period 1, every second point
    returns better than every point does.
    """
    if problem.iterate is None:
        return labelling
    unsettled = labelling.evidence.late_defect > _MAX_SETTLED_DEFECT
    candidates = np.flatnonzero(problem.damped & (labelling.period > 1) & unsettled)
    period = labelling.period[candidates]
    found = _settling_periods(problem.iterate, labelling.run, candidates, period)
    period = np.where(found > 0, found, period)
    return replace(labelling, period=_put(labelling.period, candidates, period))


def mark_escapes(labelling: Labelling) -> Labelling:
    """Label what left every bound."""
    escaped = np.flatnonzero(labelling.run.escaped)
    return replace(labelling, regime=_put(labelling.regime, escaped, Regime.ESCAPED))


def _settling_periods(
    iterate: IterateMap, run: LongRun, orbits: IntArray, candidates: IntArray
) -> IntArray:
    assert run.visited is not None
    return settling_periods(run.visited[orbits], orbits, candidates, iterate)


def _put(values: np.ndarray, indices: IntArray, new: np.ndarray | float) -> np.ndarray:
    """A copy with new values at some places."""
    changed = values.copy()
    changed[indices] = new
    return changed
