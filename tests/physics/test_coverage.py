"""The reported error beside the true one, over every drive, by the coverage study's own cases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from remanent._status import Status

pytest.importorskip("heyoka")
from benchmarks import coverage, taylor  # needs heyoka
from benchmarks.coverage import KINDS, Group, cases, group

ALL = range(len(KINDS))
#: Kinds of which extremes are asked.
EXTREME = [k for k in ALL if KINDS[k].extremes]


def shortened(some: Group, tolerance: float) -> Group:
    """The same motions for a tenth of the time: quick, and regular at any tolerance."""
    return replace(some, duration=0.1 * some.duration, tolerance=tolerance)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-11])
@pytest.mark.parametrize("kind", ALL, ids=[kind.name for kind in KINDS])
def test_reported_errors_cover_true_ones(kind: int, tolerance: float) -> None:
    """Coverage: all of 16 random trajectories, and not a hundred times too large at the median."""
    some = shortened(group(3, kind, 0), tolerance)
    outcome = some.computed()
    regular = np.flatnonzero(outcome.status == Status.OK)
    assert regular.size >= 14
    true = np.array([coverage.true_error(some, outcome, int(k)) for k in regular])
    assert (true <= outcome.error[regular]).all()
    assert (outcome.error[regular] <= tolerance).all()
    # where the error is less than a unit in the last place, that is its measure
    measured = np.maximum(true, np.finfo(float).eps)
    assert np.median(outcome.error[regular] / measured) <= 100.0


@pytest.mark.slow
def test_coverage_of_thousands_of_trajectories() -> None:
    """Coverage: 99.5 % covered, of every kind 99 %, the median bound within 100 times the error."""
    found = list(coverage.measured(4000, seed=4))
    total = coverage.summary(found)
    assert total["ok"] >= 0.95
    assert total["coverage"] >= 0.995
    assert total["median_ratio"] <= 100.0
    for kind in ALL:
        assert coverage.summary([c for c in found if c.kind == kind])["coverage"] >= 0.99


#: Groups in which steps that were too long ran off to thickness stretches of nothing, with
#: which both solutions agreed, at loose tolerances under slow drives.
RAN_OFF = [(8, 1), (8, 62), (7, 15)]


@pytest.mark.parametrize(("kind", "number"), RAN_OFF)
def test_extremes_of_a_solution_that_ran_off_are_not_reported(kind: int, number: int) -> None:
    """Coverage: extremes and statuses are right where the first resolutions are far too low."""
    found = list(cases(seed=1, kind=kind, number=number))
    assert all(case.status == Status.OK for case in found)
    assert max(case.true for case in found) <= 2.0 * found[0].tolerance


@pytest.mark.parametrize("kind", [k for k in ALL if k not in EXTREME])
def test_states_agree_with_taylor_series(kind: int) -> None:
    """heyoka in extended precision, every drive, to ten times the tolerance.

    Law: Independent engines.
    """
    some = shortened(group(5, kind, 0), 1e-9)
    outcome = some.computed()
    regular = np.flatnonzero(outcome.status == Status.OK)
    assert regular.size >= 14
    assert max(coverage.true_error(some, outcome, int(k)) for k in regular) <= 1e-8


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [1e-6, 1e-11])
@pytest.mark.parametrize("kind", ALL)
def test_many_results_agree_with_taylor_series(kind: int, tolerance: float) -> None:
    """Independent engines: states and extremes of a hundred trajectories of each kind."""
    for number in range(1, 7):
        some = replace(group(5, kind, number), tolerance=tolerance)
        outcome = some.computed()
        computed = np.flatnonzero(outcome.status == Status.OK)
        assert computed.size > outcome.status.size // 3
        for k in computed:
            assert coverage.true_error(some, outcome, int(k)) <= 10.0 * tolerance


def test_the_reference_agrees_with_itself_forward_and_back() -> None:
    """heyoka's own error is far below any tolerance: there and back under a constant load.

    Law: Independent engines.
    """
    some = group(6, 0, 0)
    motion = some.motion(0)
    there = taylor.states(motion, np.array([0.0, 30.0]))[-1]
    damped = motion.values.get("dissipation.0.eta", 0.0)
    assert damped == 0.0
    back = taylor.states(replace(motion, initial=(there[0], -there[1])), np.array([0.0, 30.0]))
    # what remains is the rounding of `there` to double precision, grown on the way back
    assert back[-1] == pytest.approx([motion.initial[0], -motion.initial[1]], abs=1e-13)
