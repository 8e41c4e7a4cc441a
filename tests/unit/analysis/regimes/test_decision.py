"""Labels of maps whose motion is known, and the rules behind them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from remanent._typing import BoolArray, FloatArray, IntArray
from remanent.analysis.regimes.agreement import (
    DEFAULT_REGIME_RULES,
    agreed_regime,
    chaotic_rule,
    periodic_rule,
    regime_of_run,
)
from remanent.analysis.regimes.collection import (
    INDICATOR_FUNCTIONS,
    collect_evidence,
    states_as_observables,
)
from remanent.analysis.regimes.decision import decide_regimes
from remanent.analysis.regimes.evidence import EvidenceTable
from remanent.analysis.regimes.labels import Regime, RegimeLabels
from remanent.analysis.regimes.long_runs import LongRun, propagate_tangents
from remanent.analysis.regimes.orbit_batch import OrbitBatch
from remanent.analysis.regimes.problem import RegimeProblem
from remanent.analysis.regimes.thresholds import RegimeThresholds
from tests.unit.analysis.regimes.iterated import (
    Iterated,
    Step,
    henon,
    logistic,
    rolled,
    run,
    standard,
)

GOLDEN = (np.sqrt(5.0) - 1.0) / 2.0


def label(
    step: Step, y0: FloatArray, par: FloatArray, periods: int, *, damped: bool = True
) -> RegimeLabels:
    """Labels; rounding in other orders stands for other tolerances."""
    points = Iterated(step, par)

    def again(which: IntArray, n: int, states: FloatArray | None = None, /) -> LongRun:
        moved = y0[which] * (1.0 + n * 1e-13) if states is None else states
        advance = Iterated(step, par[which])
        return propagate_tangents(advance, moved, periods, directions=y0.shape[1], every=True)

    problem = RegimeProblem(
        again,
        len(y0),
        damped=np.full(len(y0), damped),
        iterate_with_jacobian=points.iterate,
        observables=rolled if step is standard else states_as_observables,
    )
    return decide_regimes(problem)[0]


def test_the_golden_torus_breaks_near_0_97() -> None:
    """On x = 0 orbits of golden rotation are tori at K = 0.9; at 1.1 none of them is left.

    J. M. Greene, J. Math. Phys. 20 (1979) 1183: the last torus breaks at K = 0.971635.  What is
    quasi-periodic at 1.1 lies on islands, about orbits of rational rotation: 5/8 here.
    """
    v = np.linspace(4.0, 4.4, 24)
    starts = np.column_stack([np.zeros(24), v])
    turns, regimes = {}, {}
    for k in (0.9, 1.1):
        par = np.full((24, 1), k)
        regimes[k] = label(standard, starts, par, 1000, damped=False).regime
        path = propagate_tangents(
            Iterated(standard, par), starts, 1000, directions=2, every=True
        ).visited_states
        assert path is not None
        angle = np.remainder(np.diff(path[:, :, 0], axis=1), 2.0 * np.pi)
        turns[k] = angle.mean(axis=1) / (2.0 * np.pi)
    golden = np.abs(turns[0.9] - GOLDEN) < 4e-3
    assert golden.sum() >= 3
    assert (regimes[0.9][golden] == Regime.QUASI_PERIODIC).all()
    golden = np.abs(turns[1.1] - GOLDEN) < 4e-3
    assert golden.any()
    assert not (regimes[1.1][golden] == Regime.QUASI_PERIODIC).any()
    assert (regimes[1.1] == Regime.CHAOTIC).sum() >= 16


def test_labels_of_the_logistic_map() -> None:
    """A fixed point, periods 2 and 4, chaos in one band and in two, the window of period 3."""
    r = np.array([2.8, 3.2, 3.5, 4.0, 3.65, 3.835])
    found = label(logistic, np.full((6, 1), 0.3), r[:, None], 500)
    chaos, periodic = int(Regime.CHAOTIC), int(Regime.PERIODIC)
    expected = [periodic, periodic, periodic, chaos, chaos, periodic]
    assert found.regime.tolist() == expected
    assert found.period.tolist() == [1, 2, 4, 0, 0, 3]
    assert (found.margin >= 1.0).all()


@pytest.mark.parametrize("periods", [300, 350, 400])
def test_a_multiplier_near_minus_one_does_not_double_the_period(periods: int) -> None:
    """r = 2.95: the fixed point is approached from both sides in turn.

    After 300 periods the orbit is found ahead; after 350 it returns to within 1e-6 already, but
    better after two periods than after one.
    """
    found = label(logistic, np.array([[0.3]]), np.array([[2.95]]), periods)
    assert (found.regime[0], found.period[0]) == (Regime.PERIODIC, 1)


def test_at_the_edge_nothing_is_said() -> None:
    """r = 3, where period 1 gives way to period 2, and the end of the doublings."""
    found = label(logistic, np.full((2, 1), 0.3), np.array([[3.0], [3.569945672]]), 500)
    assert found.regime.tolist() == [Regime.UNDECIDED] * 2
    assert np.isnan(found.margin).all()


def test_what_leaves_has_escaped() -> None:
    """Henon's map at a = 1.5: the orbit of (0.1, 0.1) leaves every bound."""
    found = label(henon, np.array([[0.1, 0.1]]), np.array([[1.5, 0.3]]), 500)
    assert found.regime[0] == Regime.ESCAPED


@pytest.mark.parametrize("damped", [True, False])
def test_one_tolerance_that_disagrees_takes_the_label_away(damped: bool) -> None:
    """Chaos needs two witnesses: chaos at one tolerance, a fixed point at another."""
    par = np.array([[3.9]])

    def again(which: IntArray, n: int, _states: FloatArray | None = None, /) -> LongRun:
        values = par[which] if n != 2 else np.full((which.size, 1), 2.8)
        start = np.full((which.size, 1), 0.3)
        return propagate_tangents(Iterated(logistic, values), start, 500, directions=1, every=True)

    found, _ = decide_regimes(RegimeProblem(again, 1, damped=np.array([damped])))
    assert found.regime[0] == Regime.UNDECIDED


@pytest.mark.parametrize(("later", "regime"), [(3.9, Regime.CHAOTIC), (2.8, Regime.UNDECIDED)])
def test_damped_chaos_has_to_outlast_the_run(later: float, regime: Regime) -> None:
    """Chaos needs two witnesses: chaos that settles in what follows the run was a transient."""

    def again(which: IntArray, n: int, states: FloatArray | None = None, /) -> LongRun:
        par = np.full((which.size, 1), 3.9 if states is None else later)
        start = np.full((which.size, 1), 0.3 + n * 1e-13) if states is None else states
        return propagate_tangents(Iterated(logistic, par), start, 500, directions=1, every=True)

    found, _ = decide_regimes(RegimeProblem(again, 1, damped=np.ones(1, dtype=np.bool_)))
    assert found.regime[0] == regime


# ---------------------------------------------------------------------------- rules

PERIODS = 500
#: Evidence that is beyond every line of its regime, for motion without and with damping.
CLEAR: dict[tuple[Regime, bool], dict[str, float]] = {
    (Regime.PERIODIC, False): {"defect": 1e-9, "late_defect": 1e-9, "log_growth": 6.0},
    (Regime.PERIODIC, True): {"defect": 1e-2, "late_defect": 1e-9, "log_growth": -20.0},
    (Regime.QUASI_PERIODIC, False): {"digits": 9.0, "log_growth": 6.0, "zero_one": 0.0},
    (Regime.QUASI_PERIODIC, True): {"digits": 9.0, "log_growth": 0.0, "zero_one": 0.0},
    (Regime.CHAOTIC, False): {"exponent": 0.1, "log_growth": 50.0, "log_growth_of_halves": 25.0},
    (Regime.CHAOTIC, True): {"exponent": 0.1, "log_growth": 50.0, "log_growth_of_halves": 25.0},
}


def evidence(**values: float) -> EvidenceTable:
    """One row; what is not given speaks for no regime."""
    row: dict[str, float] = {
        "exponent": 0.0, "exponent_error": 0.01, "swing_error": 0.01, "finite_time_error": 0.0,
        "log_growth": 20.0, "log_growth_of_halves": 10.0, "late_log_growth": 0.5,
        "digits": 2.0, "banded_digits": 2.0, "relative_band_scatter": 1.0,
        "zero_one": 0.9, "sali": 1.0, "rotation_number": 0.3, "rotation_error": 0.01,
        "rotation_digits": 2.0,
        "period": 1, "defect": 0.5, "late_defect": 0.5, "extent": 1.0,
    }  # fmt: skip
    row |= values
    columns: dict[str, FloatArray] = {name: np.array([value]) for name, value in row.items()}
    columns["log_growth_of_halves"] = np.full((1, 2), row["log_growth_of_halves"])
    return EvidenceTable.from_columns(columns)


def regime_of(table: EvidenceTable, damped: bool) -> Regime:
    regime, _ = regime_of_run(
        table, damped=np.array([damped]), periods=PERIODS, thresholds=RegimeThresholds()
    )
    return Regime(int(regime[0]))


@pytest.mark.parametrize(("regime", "damped"), CLEAR)
def test_clear_evidence_decides(regime: Regime, damped: bool) -> None:
    """The row that the lines below are drawn from has its label."""
    assert regime_of(evidence(**CLEAR[regime, damped]), damped) == regime


#: regime, damped, quantity, the threshold that bounds it: at most (1) or at least (-1).
LINES: list[tuple[Regime, bool, str, float, int]] = [
    (Regime.PERIODIC, False, "defect", 1e-6, 1),
    (Regime.PERIODIC, True, "late_defect", 1e-6, 1),
    (Regime.PERIODIC, True, "log_growth", 0.0, 1),
    (Regime.PERIODIC, False, "log_growth", np.log(PERIODS) + 2.0, 1),
    (Regime.PERIODIC, False, "late_log_growth", 2.5, 1),
    (Regime.QUASI_PERIODIC, False, "log_growth", np.log(PERIODS) + 2.0, 1),
    (Regime.QUASI_PERIODIC, False, "late_log_growth", 2.5, 1),
    (Regime.QUASI_PERIODIC, False, "digits", 5.0, -1),
    (Regime.QUASI_PERIODIC, False, "zero_one", 0.4, 1),
    (Regime.QUASI_PERIODIC, True, "late_log_growth", -1.0, -1),
    (Regime.QUASI_PERIODIC, True, "late_defect", 0.25, -1),
    (Regime.QUASI_PERIODIC, True, "relative_band_scatter", 0.1, -1),
    (Regime.CHAOTIC, False, "exponent", 0.03, -1),
    (Regime.CHAOTIC, False, "log_growth", 1.5 * np.log(PERIODS) + 4.0, -1),
    (Regime.CHAOTIC, False, "log_growth_of_halves", 4.5, -1),
    (Regime.CHAOTIC, False, "banded_digits", 3.5, 1),
]


@pytest.mark.parametrize(("regime", "damped", "quantity", "line", "side"), LINES)
def test_every_line_is_where_it_is_drawn(
    regime: Regime, damped: bool, quantity: str, line: float, side: int
) -> None:
    """Just on this side of each threshold the label is given, just beyond it nothing is."""
    step = side * 1e-6 * max(abs(line), 1e-6)
    for value, expected in ((line - step, regime), (line + step, Regime.UNDECIDED)):
        row = {**CLEAR[regime, damped], quantity: value}
        assert regime_of(evidence(**row), damped) == expected


@pytest.mark.parametrize(
    ("quantity", "line", "side"),
    [("digits", 3.4, -1), ("rotation_digits", 4.5, -1), ("late_log_growth", 1.5, 1),
     ("zero_one", 0.2, 1)],
)  # fmt: skip
def test_fewer_digits_need_a_rotation_number(quantity: str, line: float, side: int) -> None:
    """A torus with four digits: all the other evidence has to be clearer."""
    clear = {"digits": 4.0, "rotation_digits": 6.0, "log_growth": 6.0, "zero_one": 0.0}
    step = side * 1e-6
    for value, expected in (
        (line - step, Regime.QUASI_PERIODIC), (line + step, Regime.UNDECIDED)
    ):  # fmt: skip
        assert regime_of(evidence(**{**clear, quantity: value}), False) == expected


def test_an_open_orbit_is_not_one_that_nearly_closes() -> None:
    """Between closed (1e-6) and open (1e-5) there is no label."""
    for defect, expected in (
        (0.9e-6, Regime.PERIODIC), (3e-6, Regime.UNDECIDED), (1.1e-5, Regime.QUASI_PERIODIC)
    ):  # fmt: skip
        row = {**CLEAR[Regime.QUASI_PERIODIC, False], "defect": defect, "late_defect": defect}
        assert regime_of(evidence(**row), False) == expected


def test_missing_evidence_decides_nothing() -> None:
    """A row of NaN, as of an orbit that escaped."""
    nothing = evidence(**dict.fromkeys(("exponent", "log_growth", "digits", "defect"), np.nan))
    assert regime_of(nothing, False) == Regime.UNDECIDED


@pytest.mark.parametrize(("ratio", "regime"), [(2.9, Regime.CHAOTIC), (3.1, Regime.UNDECIDED)])
def test_chaotic_exponents_have_to_agree(ratio: float, regime: Regime) -> None:
    """Two witnesses: both runs are chaotic, their exponents within a factor of three."""
    clear = CLEAR[Regime.CHAOTIC, False]
    runs = [evidence(**clear), evidence(**{**clear, "exponent": ratio * clear["exponent"]})]
    label, margin = agreed_regime(runs, damped=np.zeros(1, dtype=np.bool_), periods=PERIODS)
    assert label[0] == regime
    assert np.isnan(margin[0]) == (regime == Regime.UNDECIDED)


def test_the_margin_is_that_of_the_weaker_run() -> None:
    """Exponents 10 and 5 standard errors above 0, of which 3 are asked: 5/3."""
    clear = CLEAR[Regime.CHAOTIC, False]
    runs = [evidence(**clear), evidence(**{**clear, "exponent": 0.05})]
    _, margin = agreed_regime(runs, damped=np.zeros(1, dtype=np.bool_), periods=PERIODS)
    assert margin[0] == pytest.approx(5.0 / 3.0)


def test_the_finest_tolerance_is_kept_for_what_is_disputed() -> None:
    """Of a fixed point and chaos, the finest tolerance follows the second alone."""
    par = np.array([[2.8], [3.9]])
    asked: dict[int, list[int]] = {0: [], 1: [], 2: []}

    def follow(which: IntArray, n: int, states: FloatArray | None = None, /) -> LongRun:
        if states is None:
            asked[n] += which.tolist()
        start = np.full((which.size, 1), 0.3 + n * 1e-13) if states is None else states
        advance = Iterated(logistic, par[which])
        return propagate_tangents(advance, start, 500, directions=1, every=True)

    found, _ = decide_regimes(RegimeProblem(follow, 2, damped=np.ones(2, dtype=np.bool_)))
    assert found.regime.tolist() == [Regime.PERIODIC, Regime.CHAOTIC]
    assert asked == {0: [1], 1: [0, 1], 2: [0, 1]}


@pytest.mark.parametrize("damped", [True, False])
def test_the_first_two_fifths_of_a_damped_run_leave_no_trace(damped: bool) -> None:
    """What comes before is a transient, of which nothing enters the evidence; without damping all.

    The logistic map at r = 3.7, and the same run with another beginning.
    """
    whole = run(logistic, np.array([0.3]), np.array([3.7]), 500, every=True)
    assert whole.visited_states is not None
    states, factors = whole.visited_states.copy(), whole.triangular_factors.copy()
    states[:, :199] = 0.5
    factors[:, : int(0.39 * factors.shape[1])] *= 3.0
    other = replace(whole, visited_states=states, triangular_factors=factors)
    before, after = (collect_evidence(one, damped=np.array([damped])) for one in (whole, other))
    same = {
        name
        for name, column in before.column_of_name.items()
        if np.array_equal(column, after[name], equal_nan=True)
    }
    if damped:
        assert same == set(before.column_of_name)
    else:
        assert not same & {"exponent", "log_growth", "digits", "banded_digits", "zero_one"}


def test_labels_do_not_depend_on_company() -> None:
    """Determinism: an orbit alone and among others has the same evidence, bit for bit."""
    r = np.array([2.8, 3.2, 3.5, 4.0, 3.65, 3.0, 2.95])[:, None]
    together = label(logistic, np.full((7, 1), 0.3), r, 300)
    assert together.evidence.column_of_name
    for k in range(7):
        alone = label(logistic, np.full((1, 1), 0.3), r[k : k + 1], 300)
        assert alone.regime[0] == together.regime[k]
        for name, column in together.evidence.column_of_name.items():
            np.testing.assert_array_equal(column[k], alone.evidence[name][0], err_msg=name)


def test_a_new_indicator_is_a_function_and_a_line_in_a_table() -> None:
    """The scatter of the orbit as a column, and a rule that calls narrow chaos undecided."""

    def scatter(batch: OrbitBatch) -> FloatArray:
        return np.asarray(batch.observable_values[:, :, 0].std(axis=1))

    def wide_chaos(
        e: EvidenceTable, damped: BoolArray, periods: int, t: RegimeThresholds
    ) -> tuple[BoolArray, FloatArray]:
        chaotic, margin = chaotic_rule(e, damped, periods, t)
        return chaotic & (e["scatter"] > 0.25), margin

    par = np.array([[3.65], [4.0]])  # within two bands, and all over the interval

    def follow(which: IntArray, n: int, states: FloatArray | None = None, /) -> LongRun:
        start = np.full((which.size, 1), 0.3 + n * 1e-13) if states is None else states
        advance = Iterated(logistic, par[which])
        return propagate_tangents(advance, start, 500, directions=1, every=True)

    problem = RegimeProblem(
        follow,
        2,
        damped=np.ones(2, dtype=np.bool_),
        indicators={**INDICATOR_FUNCTIONS, "scatter": scatter},
        rules=(*DEFAULT_REGIME_RULES[:-1], (Regime.CHAOTIC, wide_chaos)),
    )
    found, _ = decide_regimes(problem)
    assert found.regime.tolist() == [Regime.UNDECIDED, Regime.CHAOTIC]
    # At r = 4 the density is 1/(pi sqrt(x(1 - x))), whose standard deviation is 1/sqrt(8).
    assert found.evidence["scatter"][1] == pytest.approx(8.0**-0.5, rel=0.05)


def test_the_margin_of_a_periodic_orbit_is_one_at_the_threshold() -> None:
    """Of the digits to which it closes: twice as many are a margin of 2, half as many of 1/2."""
    found = label(logistic, np.full((3, 1), 0.3), np.full((3, 1), 3.2), 500)
    thresholds = RegimeThresholds()
    limit = thresholds.max_closed_return_defect
    table = replace(found.evidence, defect=np.array([limit, limit**2, limit**0.5]))
    closed, margin = periodic_rule(table, np.zeros(3, dtype=np.bool_), 500, thresholds)
    np.testing.assert_allclose(margin, [1.0, 2.0, 0.5])
    assert closed.tolist() == [True, True, False]
