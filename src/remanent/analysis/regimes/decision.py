"""What kind of motion an orbit is: a label only where independent indicators agree.

Three kinds of evidence are weighed, at more than one tolerance: the growth of tangents, the
convergence of weighted averages along the orbit, and its return to the same point.  Where
they disagree, or where the run is too short for them to speak, the label is `undecided`.

The decision is a row of steps, each of which takes the labelling so far and returns a new
one.  :func:`decide_regimes` names them in order; a new step goes between two of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from remanent._typing import FloatArray, IntArray
from remanent.analysis.regimes.evidence import EvidenceTable
from remanent.analysis.regimes.labels import Regime, RegimeLabels
from remanent.analysis.regimes.limit_orbits import (
    IterateWithJacobian,
    find_approached_orbit_periods,
)
from remanent.analysis.regimes.long_runs import LongRun
from remanent.analysis.regimes.problem import RegimeProblem
from remanent.analysis.regimes.transients import LOOSEST_TOLERANCE_INDEX, chaos_lasts

#: An orbit that returns worse than this, relative to its extent, is not settling yet.
_MAX_SETTLING_RETURN_DEFECT = 0.5
#: An orbit that returns better than this, relative to its extent, has settled.
_MAX_SETTLED_RETURN_DEFECT = 1e-10


@dataclass(frozen=True)
class PartialLabelling:
    """Labels as far as the steps have come; every step returns a new one.

    Attributes
    ----------
    regime, period : array (orbit,) of int
    margin : array (orbit,)
    evidence : EvidenceTable
        At the finest tolerance so far.
    exponent_spread_between_tolerances : array (orbit,)
        Of the exponents at the tolerances so far.
    rotation_spread_between_tolerances : array (orbit,)
        The same of the rotation numbers, in turns.
    run : LongRun
        At the finest tolerance so far.
    """

    regime: IntArray
    period: IntArray
    margin: FloatArray
    evidence: EvidenceTable
    exponent_spread_between_tolerances: FloatArray
    rotation_spread_between_tolerances: FloatArray
    run: LongRun

    def to_regime_labels(self) -> RegimeLabels:
        """The labels with their evidence."""
        evidence = self.evidence
        error = np.hypot(evidence.swing_error, self.exponent_spread_between_tolerances)
        rotation_error = (
            evidence.rotation_error
            + self.rotation_spread_between_tolerances
            + self.run.largest_period_error
        )
        return RegimeLabels(
            regime=self.regime,
            period=self.period,
            margin=self.margin,
            evidence=evidence,
            exponent_error=error + evidence.finite_time_error,
            rotation_number_error=np.where(
                np.isfinite(evidence.rotation_number), rotation_error, np.nan
            ),
        )


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
    labelling, loosest, disputed = screen_at_loose_tolerances(problem)
    labelling = rerun_disputed_orbits(problem, labelling, loosest, disputed)
    labelling = reject_transient_chaos(problem, labelling)
    labelling = unlabel_untrusted_orbits(labelling)
    labelling = take_periods_from_returns(labelling)
    labelling = label_settling_orbits(problem, labelling)
    labelling = reduce_multiple_periods(problem, labelling)
    labelling = label_escaped_orbits(labelling)
    return labelling.to_regime_labels(), labelling.run


def screen_at_loose_tolerances(
    problem: RegimeProblem,
) -> tuple[PartialLabelling, EvidenceTable, IntArray]:
    """Follow every orbit at the two loosest tolerances.

    Returns
    -------
    labelling : PartialLabelling
        What both tolerances agree on, with the evidence of the finer.
    loosest : EvidenceTable
        The evidence at the loosest tolerance.
    disputed : array (orbit,) of int
        Orbits that need the finest tolerance: those that escape in one run alone, and those
        that both runs do not call regular.
    """
    everyone = np.arange(problem.orbit_count)
    first = problem.run_at_tolerance(everyone, LOOSEST_TOLERANCE_INDEX)
    loosest = problem.evidence_of_run(first, everyone)
    # An orbit whose error was not met at the loosest tolerance will not meet a finer one.
    trusted = np.flatnonzero(first.error_bound_met)
    second = problem.run_at_tolerance(trusted, LOOSEST_TOLERANCE_INDEX - 1)
    evidence = loosest.with_replaced_rows(trusted, problem.evidence_of_run(second, trusted))
    regime, margin = problem.agreed_regime([evidence, loosest], everyone, first.periods)
    run = first.with_replaced_rows(trusted, second)

    regular = np.isin(regime[trusted], (Regime.PERIODIC, Regime.QUASI_PERIODIC))
    unclear = (first.escaped[trusted] != second.escaped) | (~run.escaped[trusted] & ~regular)
    disputed = trusted[unclear & run.error_bound_met[trusted]]

    labelling = PartialLabelling(
        regime=regime,
        period=np.zeros(problem.orbit_count, dtype=np.int64),
        margin=margin,
        evidence=evidence,
        exponent_spread_between_tolerances=_spread([evidence.exponent, loosest.exponent]),
        rotation_spread_between_tolerances=_spread_on_circle(
            [evidence.rotation_number, loosest.rotation_number]
        ),
        run=run,
    )
    return labelling, loosest, disputed


def rerun_disputed_orbits(
    problem: RegimeProblem, labelling: PartialLabelling, loosest: EvidenceTable, disputed: IntArray
) -> PartialLabelling:
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
    run = problem.run_at_tolerance(disputed, 0)
    finest = problem.evidence_of_run(run, disputed)
    runs = [finest, labelling.evidence.subset(disputed), loosest.subset(disputed)]
    by_two, margin_by_two = problem.agreed_regime(runs[:2], disputed, labelling.run.periods)
    by_three, margin_by_three = problem.agreed_regime(runs, disputed, labelling.run.periods)
    chaotic = by_two == Regime.CHAOTIC
    return replace(
        labelling,
        regime=_with_replaced_values(
            labelling.regime, disputed, np.where(chaotic, by_three, by_two)
        ),
        margin=_with_replaced_values(
            labelling.margin, disputed, np.where(chaotic, margin_by_three, margin_by_two)
        ),
        evidence=labelling.evidence.with_replaced_rows(disputed, finest),
        exponent_spread_between_tolerances=_with_replaced_values(
            labelling.exponent_spread_between_tolerances,
            disputed,
            _spread([evidence.exponent for evidence in runs]),
        ),
        rotation_spread_between_tolerances=_with_replaced_values(
            labelling.rotation_spread_between_tolerances,
            disputed,
            _spread_on_circle([evidence.rotation_number for evidence in runs[:2]]),
        ),
        run=labelling.run.with_replaced_rows(disputed, run),
    )


def reject_transient_chaos(problem: RegimeProblem, labelling: PartialLabelling) -> PartialLabelling:
    """Take the label from damped chaos that ends within two more runs.

    Motion without damping has no attractor on which it could settle.
    """
    chaotic = np.flatnonzero(problem.damped & (labelling.regime == Regime.CHAOTIC))
    lasts = chaos_lasts(
        problem.run_at_tolerance,
        chaotic,
        labelling.run.last_state[chaotic],
        problem.thresholds.min_chaos_log_growth_per_half,
    )
    passing = chaotic[~lasts]
    return replace(
        labelling,
        regime=_with_replaced_values(labelling.regime, passing, Regime.UNDECIDED),
        margin=_with_replaced_values(labelling.margin, passing, np.nan),
    )


def unlabel_untrusted_orbits(labelling: PartialLabelling) -> PartialLabelling:
    """Say nothing of orbits whose error bound was not met."""
    untrusted = np.flatnonzero(~labelling.run.error_bound_met)
    return replace(
        labelling, regime=_with_replaced_values(labelling.regime, untrusted, Regime.UNDECIDED)
    )


def take_periods_from_returns(labelling: PartialLabelling) -> PartialLabelling:
    """Take the periods of periodic orbits from their best returns."""
    periodic = labelling.regime == Regime.PERIODIC
    return replace(labelling, period=np.where(periodic, labelling.evidence.period, 0))


def label_settling_orbits(problem: RegimeProblem, labelling: PartialLabelling) -> PartialLabelling:
    """Label damped motion that is seen to approach a stable periodic orbit.

    Only motion whose tangents shrink and that already returns to its neighbourhood is looked
    at: Newton's method from anywhere else would find orbits that have nothing to do with it.
    """
    run, evidence = labelling.run, labelling.evidence
    if problem.iterate_with_jacobian is None:
        return labelling
    open_question = (labelling.regime == Regime.UNDECIDED) & ~run.escaped & run.error_bound_met
    contracting = (evidence.exponent < 0.0) & (evidence.late_defect < _MAX_SETTLING_RETURN_DEFECT)
    candidates = np.flatnonzero(problem.damped & open_question & contracting)
    period = _approached_orbit_periods_of_run(
        problem.iterate_with_jacobian, run, candidates, evidence.period[candidates]
    )
    settling = candidates[period > 0]
    return replace(
        labelling,
        regime=_with_replaced_values(labelling.regime, settling, Regime.PERIODIC),
        period=_with_replaced_values(labelling.period, settling, period[period > 0]),
        margin=_with_replaced_values(labelling.margin, settling, 1.0),
    )


def reduce_multiple_periods(
    problem: RegimeProblem, labelling: PartialLabelling
) -> PartialLabelling:
    """Replace a multiple of the period by the period, where motion still settles.

    While the approach alternates between two sides of an orbit of period 1, every second point
    returns better than every point does.
    """
    if problem.iterate_with_jacobian is None:
        return labelling
    unsettled = labelling.evidence.late_defect > _MAX_SETTLED_RETURN_DEFECT
    candidates = np.flatnonzero(problem.damped & (labelling.period > 1) & unsettled)
    period = labelling.period[candidates]
    settling_period = _approached_orbit_periods_of_run(
        problem.iterate_with_jacobian, labelling.run, candidates, period
    )
    period = np.where(settling_period > 0, settling_period, period)
    return replace(labelling, period=_with_replaced_values(labelling.period, candidates, period))


def label_escaped_orbits(labelling: PartialLabelling) -> PartialLabelling:
    """Label what left every bound."""
    escaped = np.flatnonzero(labelling.run.escaped)
    return replace(
        labelling, regime=_with_replaced_values(labelling.regime, escaped, Regime.ESCAPED)
    )


def _approached_orbit_periods_of_run(
    iterate: IterateWithJacobian, run: LongRun, orbits: IntArray, candidates: IntArray
) -> IntArray:
    assert run.visited_states is not None
    return find_approached_orbit_periods(run.visited_states[orbits], orbits, candidates, iterate)


def _spread(values: Sequence[FloatArray]) -> FloatArray:
    """Largest less least of some numbers of each orbit; NaN where one is infinite."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.ptp(np.array(values), axis=0))


def _spread_on_circle(turns: Sequence[FloatArray]) -> FloatArray:
    """Distance of two numbers of turns modulo 1; half a turn where one is not known."""
    difference = np.abs(turns[0] - turns[1])
    distance = np.minimum(difference, 1.0 - difference)
    return np.where(np.isnan(distance), 0.5, distance)


def _with_replaced_values(
    values: np.ndarray, indices: IntArray, new: np.ndarray | float
) -> np.ndarray:
    """A copy with new values at some places."""
    changed = values.copy()
    changed[indices] = new
    return changed
