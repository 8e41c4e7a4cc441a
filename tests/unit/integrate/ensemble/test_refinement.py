"""The decisions of refinement, one row each: history and summary to what follows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from remanent._status import Status
from remanent.integrate.ensemble.refinement import (
    AttemptHistory,
    AttemptSummary,
    RefinementDecision,
    RefinementPolicy,
    TrajectoryScales,
)

POLICY = RefinementPolicy(tolerance=1e-8, order=8, max_resolution=1024)
DURATION = 100.0
NAN = math.nan


@dataclass(frozen=True)
class Row:
    """One trajectory: what was known, what an attempt shows, and what follows.

    By default the best attempt so far had resolution 16 and reached 20 of 100, and a new one
    with 32 reaches further without meeting the tolerance.
    """

    title: str
    status: Status
    refine: bool
    improved: bool = True
    stalls_after: int = 0
    # history
    best_horizon: float = 20.0
    best_resolution: int = 16
    stalls: int = 0
    status_before: Status = Status.HORIZON
    error_before: float = 1.5e-6
    # summary
    resolution: int = 32
    met: bool = False
    horizon: float = 40.0
    error_to_horizon: float = 0.9e-8
    largest_error: float = 1e-6
    size: float = 2.0
    # trajectory
    drive_slowness: float = 1.0


NEW: dict[str, Any] = {
    "best_horizon": NAN,
    "best_resolution": 0,
    "error_before": NAN,
    "status_before": Status.NOT_COMPUTED,
}
STUCK: dict[str, Any] = {"horizon": 20.5, "stalls_after": 1}

TABLE = [
    Row("accept: the tolerance is met", Status.OK, False, met=True, largest_error=1e-9),
    Row("accept at the first attempt", Status.OK, False, met=True, largest_error=1e-9, **NEW),
    Row("refine after a first attempt that falls short", Status.HORIZON, True, **NEW),
    Row("refine while the horizon grows", Status.HORIZON, True),
    Row(
        "keep the better attempt, though a finer one falls short of it",
        Status.HORIZON, False, improved=False, horizon=19.0, stalls_after=1,
    ),
    Row("give up: the horizon has stalled", Status.HORIZON, False, **STUCK),
    Row(
        "refine: a stall at hardly finer steps tells nothing",
        Status.HORIZON, True, horizon=20.5, resolution=20, stalls_after=0,
    ),
    Row(
        "refine: the error jumped past the tolerance, so that steps are too long",
        Status.HORIZON, True, horizon=20.5, error_to_horizon=1e-10, stalls_after=0,
    ),
    Row(
        "refine: the error has become less than half, though the horizon has stalled",
        Status.HORIZON, True, horizon=20.5, error_before=2.1e-6, stalls_after=0,
    ),
    Row(
        "refine: the motion is no longer lost, though the horizon has stalled",
        Status.HORIZON, True, horizon=20.5, error_before=NAN, largest_error=1e-4, stalls_after=0,
    ),
    Row(
        "give up: two errors that tell nothing do not become smaller",
        Status.HORIZON, False, error_before=math.inf, largest_error=0.02, **STUCK,
    ),
    Row(
        "refine: within the first cycles nothing is given up",
        Status.HORIZON, True, best_horizon=5.0, horizon=5.1, stalls_after=1,
    ),
    Row(
        "refine: late in the run one stall is not enough",
        Status.HORIZON, True, best_horizon=90.0, horizon=90.5, stalls_after=1,
    ),
    Row(
        "give up: late in the run two stalls are",
        Status.HORIZON, False, best_horizon=90.0, horizon=90.5, stalls=1, stalls_after=2,
    ),
    Row("refine: stalls count in a row only", Status.HORIZON, True, stalls=1, stalls_after=0),
    Row("give up: it escapes twice at the same time", Status.ESCAPED, False, size=1e7, **STUCK),
    Row("refine: a first escape may be of long steps", Status.HORIZON, True, size=1e7),
    Row("refine: an error that becomes no number later", Status.HORIZON, True, largest_error=NAN),
    Row(
        "refine: steps that are too long at once are not singular",
        Status.HORIZON, True, horizon=0.0, **NEW,
    ),
    Row(
        "refine what is singular at once, but say so",
        Status.SINGULAR, True, horizon=0.0, largest_error=NAN, size=NAN, **NEW,
    ),
    Row(
        "give up what is singular at the largest resolution, and say so",
        Status.SINGULAR, False, horizon=0.0, largest_error=NAN, size=NAN, resolution=1024, **NEW,
    ),
    Row("give up: the largest resolution is reached", Status.MAX_STEPS, False, resolution=1024),
    Row(
        "a slow drive may be resolved further",
        Status.HORIZON, True, resolution=1024, drive_slowness=4.0,
    ),
    Row(
        "at the largest resolution, a run that had stalled ends with its horizon",
        Status.HORIZON, False, best_horizon=90.0, horizon=90.5, resolution=1024, stalls_after=1,
    ),
    Row(
        "at the largest resolution, one that is stuck in its first cycles lacks resolution",
        Status.MAX_STEPS, False, best_horizon=5.0, horizon=5.1, resolution=1024, stalls_after=1,
    ),
]  # fmt: skip


def decide(rows: list[Row]) -> RefinementDecision:
    """What follows for some trajectories whose attempts have the same resolution."""

    def column(name: str) -> np.ndarray:
        return np.array([getattr(row, name) for row in rows])

    (resolution,) = {row.resolution for row in rows}
    return POLICY.decide(
        TrajectoryScales(
            np.full(len(rows), DURATION), np.full(len(rows), 2.5), column("drive_slowness")
        ),
        AttemptHistory(
            column("best_horizon"),
            column("best_resolution"),
            column("error_before"),
            column("stalls"),
            column("status_before").astype(np.int8),
        ),
        AttemptSummary(
            resolution,
            column("met"),
            column("horizon"),
            column("error_to_horizon"),
            column("largest_error"),
            column("size"),
        ),
    )


@pytest.mark.parametrize("row", TABLE, ids=lambda row: row.title)
def test_what_follows_from_an_attempt(row: Row) -> None:
    """Accept, refine, or give up with a status: one sentence for each row."""
    decision = decide([row])
    assert Status(decision.status[0]) == row.status
    assert decision.must_refine[0] == row.refine
    assert decision.is_improvement[0] == row.improved
    assert decision.stall_counts[0] == row.stalls_after
    assert decision.horizon[0] == (DURATION if row.met else row.horizon)


def test_a_decision_depends_on_its_trajectory_alone() -> None:
    """All rows of one resolution decided together: the same as one by one."""
    rows = [row for row in TABLE if row.resolution == 32]
    assert len(rows) > 10
    together = decide(rows)
    for k, row in enumerate(rows):
        alone = decide([row])
        for name in (
            "is_improvement", "must_refine", "next_resolution", "horizon", "stall_counts", "status",
        ):  # fmt: skip
            assert getattr(together, name)[k] == getattr(alone, name)[0], (row.title, name)


def test_the_next_resolution_follows_the_order() -> None:
    """An error 100 times the tolerance and order 8: (100/0.5)**(1/8) = 1.94 times as fine."""
    (resolution,) = decide([Row("", Status.HORIZON, True)]).next_resolution
    assert resolution == 64  # the next of 4, 5, 6, 7, 8, 10 ... above 32 * 1.94 = 62.05


def test_a_meaningless_error_doubles_the_resolution() -> None:
    """Errors above 1e-2, or none, are outside the asymptotic range."""
    for error in (0.5, math.inf, NAN):
        (resolution,) = decide([Row("", Status.HORIZON, True, largest_error=error)]).next_resolution
        assert resolution == 64
