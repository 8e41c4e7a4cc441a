"""Which regime the evidence speaks for, and whether runs at several tolerances agree.

A new regime, or a new way to recognise one, is a function here and a line in
:data:`DEFAULT_REGIME_RULES`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.evidence import EvidenceTable
from remanent.analysis.regimes.labels import Regime
from remanent.analysis.regimes.thresholds import RegimeThresholds

#: ``rule(evidence, damped, periods, thresholds)`` of a table, an array (orbit,) of bool that says
#: where motion contracts, and the length of the run.  It says of each orbit whether it is of the
#: regime, and by what factor the evidence clears its threshold: arrays (orbit,).
RegimeRule = Callable[
    [EvidenceTable, BoolArray, int, RegimeThresholds], tuple[BoolArray, FloatArray]
]


def periodic_rule(
    e: EvidenceTable, damped: BoolArray, periods: int, t: RegimeThresholds
) -> tuple[BoolArray, FloatArray]:
    """The orbit closes, and its tangents do not grow.

    Damped motion approaches its orbit, so only the end of the run has to close, and tangents
    must shrink.  Without damping they may grow like n.
    """
    defect = np.where(damped, e.late_defect, e.defect)
    quiet = np.where(damped, e.log_growth < 0.0, _tangents_grow_at_most_linearly(e, periods, t))
    margin = np.log(defect) / np.log(t.max_closed_return_defect)
    return (defect <= t.max_closed_return_defect) & quiet, margin


def quasi_periodic_rule(
    e: EvidenceTable, damped: BoolArray, periods: int, t: RegimeThresholds
) -> tuple[BoolArray, FloatArray]:
    """The orbit stays open, tangents grow like a power of n, and averages converge.

    Averages have to reach many digits; or fewer, where the rotation number converges and the
    other evidence is clearer than it need be otherwise.
    """
    attracts = _does_not_settle_on_periodic_orbit(e, t) & (
        e["relative_band_scatter"] >= t.min_torus_relative_band_scatter
    )
    many_digits = (e["digits"] >= t.min_torus_digits) & ~(e["zero_one"] > t.max_torus_zero_one)
    fewer_digits = (
        (e["digits"] >= t.min_torus_digits_if_rotation_converges)
        & (e.rotation_digits >= t.min_torus_rotation_digits)
        & (e.late_log_growth <= t.max_torus_late_log_growth_if_rotation_converges)
        & ~(e["zero_one"] > t.max_torus_zero_one_if_rotation_converges)
    )
    margin = e["digits"] / np.where(
        many_digits, t.min_torus_digits, t.min_torus_digits_if_rotation_converges
    )
    torus = (
        _has_open_orbit(e, t)
        & _tangents_grow_at_most_linearly(e, periods, t)
        & (~damped | attracts)
    )
    return torus & (many_digits | fewer_digits), margin


def chaotic_rule(
    e: EvidenceTable, _damped: BoolArray, periods: int, t: RegimeThresholds
) -> tuple[BoolArray, FloatArray]:
    """The exponent is positive, tangents grow throughout, and averages do not converge.

    The 0-1 test has no say: in thin chaotic layers it stays near 0.
    """
    significance = e.exponent / (t.min_chaos_exponent_over_error * e.exponent_error)
    least_growth = t.min_chaos_growth_power * np.log(periods) + t.min_chaos_log_growth_excess
    chaotic = (
        _has_open_orbit(e, t)
        & (significance > 1.0)
        & (e.log_growth >= least_growth)
        & (e.log_growth_of_halves.min(axis=1) >= t.min_chaos_log_growth_per_half)
        & (e["banded_digits"] <= t.max_chaos_digits)
    )
    return chaotic, np.minimum(significance, e.log_growth / least_growth)


#: Rules in the order in which they are asked; where several hold, the last one decides.
RegimeRules = Sequence[tuple[Regime, RegimeRule]]
#: The rule of each regime.
DEFAULT_REGIME_RULES: RegimeRules = (
    (Regime.PERIODIC, periodic_rule),
    (Regime.QUASI_PERIODIC, quasi_periodic_rule),
    (Regime.CHAOTIC, chaotic_rule),
)


def _has_open_orbit(e: EvidenceTable, t: RegimeThresholds) -> BoolArray:
    return np.asarray(np.maximum(e.defect, e.late_defect) >= t.min_open_return_defect)


def _tangents_grow_at_most_linearly(
    e: EvidenceTable, periods: int, t: RegimeThresholds
) -> BoolArray:
    """Tangents grow at most in proportion to time, and no faster at the end."""
    bound = np.log(periods) + t.max_regular_log_growth_excess
    return np.asarray((e.log_growth <= bound) & (e.late_log_growth <= t.max_torus_late_log_growth))


def _does_not_settle_on_periodic_orbit(e: EvidenceTable, t: RegimeThresholds) -> BoolArray:
    """The motion does not close in on a periodic orbit."""
    lasting = e.late_log_growth >= t.min_torus_late_log_growth
    return np.asarray(lasting & (e.late_defect >= t.min_torus_late_defect_share * e.defect))


def regime_of_run(
    evidence: EvidenceTable,
    *,
    damped: BoolArray,
    periods: int,
    thresholds: RegimeThresholds,
    rules: RegimeRules = DEFAULT_REGIME_RULES,
) -> tuple[IntArray, FloatArray]:
    """The regime that one run speaks for, and the margin, arrays (orbit,)."""
    count = evidence.exponent.size
    regime, margin = np.full(count, int(Regime.UNDECIDED)), np.full(count, np.nan)
    with np.errstate(all="ignore"):  # comparisons with NaN are false: nothing is decided
        for label, rule in rules:
            holds, clearance = rule(evidence, damped, periods, thresholds)
            regime = np.where(holds, int(label), regime)
            margin = np.where(holds, clearance, margin)
    return regime, margin


def agreed_regime(
    runs: Sequence[EvidenceTable],
    *,
    damped: BoolArray,
    periods: int,
    thresholds: RegimeThresholds | None = None,
    rules: RegimeRules = DEFAULT_REGIME_RULES,
) -> tuple[IntArray, FloatArray]:
    """The regime that runs at all tolerances agree on, and the margin.

    Parameters
    ----------
    runs : sequence of EvidenceTable
        Evidence at two tolerances or more, the finest first.
    damped : array (orbit,) of bool
        Where motion contracts.
    periods : int
        Length of the runs.
    thresholds : RegimeThresholds, optional
    rules : sequence of (Regime, callable)
        Where several hold, the last one decides.

    Returns
    -------
    regime : array (orbit,) of int
        Undecided where the runs differ, or where chaotic exponents do.
    margin : array (orbit,)
        The least of the runs; NaN where nothing is decided.
    """
    thresholds = thresholds or RegimeThresholds()
    verdicts = [
        regime_of_run(run, damped=damped, periods=periods, thresholds=thresholds, rules=rules)
        for run in runs
    ]
    regime = verdicts[0][0]
    agreed = np.all([label == regime for label, _ in verdicts[1:]], axis=0)
    exponents = np.array([run.exponent for run in runs])
    with np.errstate(invalid="ignore"):
        alike = exponents.max(
            axis=0
        ) <= thresholds.max_exponent_ratio_between_tolerances * exponents.min(axis=0)
    agreed = agreed & (alike | (regime != Regime.CHAOTIC))
    margin = np.min([clearance for _, clearance in verdicts], axis=0)
    regime = np.where(agreed, regime, Regime.UNDECIDED)
    return regime, np.where(regime == Regime.UNDECIDED, np.nan, margin)
