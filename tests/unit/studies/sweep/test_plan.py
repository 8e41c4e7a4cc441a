"""The plan of a study is what a run of it does, and making it writes nothing."""

from __future__ import annotations

from itertools import count, pairwise
from pathlib import Path

import pytest

import remanent as rm
from remanent.studies.sweep import plan as plan_module
from remanent.studies.sweep.grid import Grid
from remanent.studies.sweep.plan import Plan, plan_study, text
from remanent.studies.sweep.run import TASK_SECONDS, run_here, writable_store
from remanent.studies.sweep.study import Study

DRIVE = rm.SineSquared(0.4, 1.25)
OVER = {"b": [0.1, 0.2, 0.3], "temperature": [280.0, 300.0]}
STUDIES = {
    "simulate": Study("simulate", rm.Actuator(), DRIVE, OVER, {"duration": 1.0}),
    "crossings": Study(
        "crossings", rm.Actuator(), DRIVE, OVER,
        {"variable": "stretch", "value": 1.0, "duration": 5.0},
    ),
    "equilibria": Study("equilibria", rm.Actuator(), None, {"m": [0.0, 0.1, 0.2]}, {}),
}  # fmt: skip


def plan_by_ticks(study: Study, tick: float) -> Plan:
    """A plan by a clock that goes on by a tick whenever it is read."""
    ticks = count()
    return plan_study(study, lambda: tick * next(ticks))


@pytest.mark.parametrize("verb", ["simulate", "equilibria"])
def test_bytes_are_those_of_the_result(verb: str) -> None:
    """Law: where no list is longer than the tried ones, the bytes are those of the result."""
    study = STUDIES[verb]
    result = study.result_over(study.over)
    assert plan_by_ticks(study, 1e-6).store_bytes == result.nbytes


@pytest.mark.parametrize("verb", STUDIES)
def test_chunks_are_those_of_the_store(verb: str, tmp_path: Path) -> None:
    """Law: the store that a run makes has the points and the chunks of the plan."""
    plan = plan_by_ticks(STUDIES[verb], 1e-6)
    assert not list(tmp_path.iterdir())
    with writable_store(tmp_path / "store.zarr", STUDIES[verb]) as store:
        run_here(store)
        assert plan.points == STUDIES[verb].grid.point_count
        assert plan.chunks == store.chunking.chunk_count


def test_time_is_the_pace_of_the_last_trial() -> None:
    """Law: seconds of all points are those of the tried ones, in the ratio of their numbers."""
    quick = plan_by_ticks(STUDIES["simulate"], 1e-6)
    assert quick.points_tried == 6
    assert quick.seconds == pytest.approx(1e-6, rel=1e-6)
    slow = plan_by_ticks(STUDIES["simulate"], 50.0)
    assert slow.points_tried == 1
    assert slow.seconds == pytest.approx(300.0)
    assert (slow.chunks, slow.tasks) == (1, 1)


def test_a_task_is_no_smaller_than_a_chunk_and_takes_some_seconds() -> None:
    """Quick points go together in tasks of that time; slow ones have a chunk each."""
    plan = Plan("simulate", (("b", 1000),), 4, 10, 100, 8000, 800, 50.0 * TASK_SECONDS)
    assert plan.tasks == 50
    assert Plan("simulate", (("b", 1000),), 4, 10, 100, 8000, 800, 5000.0).tasks == 100
    assert Plan("simulate", (("b", 1000),), 4, 10, 100, 8000, 800, 0.1).tasks == 1


@pytest.mark.parametrize("shape", [(1,), (7,), (3, 5), (64, 64), (2, 3, 4)])
def test_samples_grow_to_the_whole_grid(shape: tuple[int, ...]) -> None:
    """Each sample is a part of the grid, none is smaller than the one before, the last is all."""
    names = list(rm.Actuator().parameter_values())
    over = {name: range(1, size + 1) for name, size in zip(names, shape, strict=False)}
    grid = Grid.from_over(over, rm.Actuator())
    samples = [grid.over(part) for part in plan_module._samples(False, grid)]
    sizes = [[len(values) for values in sample.values()] for sample in samples]
    assert sizes[0] == [1] * len(shape)
    assert sizes[-1] == list(shape)
    assert all(a <= b for few, many in pairwise(sizes) for a, b in zip(few, many, strict=True))


def test_points_that_take_long_are_said_to_be_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    """A trial is broken off after a while, and what it would have shown is not made up."""
    monkeypatch.setattr(plan_module, "_LONGEST_TRIAL_SECONDS", 0.0)
    plan = plan_study(STUDIES["simulate"])
    assert (plan.points_tried, plan.seconds, plan.store_bytes, plan.tasks) == (0, None, None, None)
    assert "unknown" in text(plan)


def test_the_table_for_people() -> None:
    """Every number has its unit, and estimates are called that."""
    plan = Plan("classify", (("b", 64), ("omega", 64)), 8, 128, 8, 3 * 2**20, 2**21, 5400.0)
    assert text(plan).split("\n") == [
        "verb    classify",
        "grid    b 64 x omega 64 = 4,096 points",
        "chunks  8",
        "tasks   about 8",
        "disk    about 3 MiB, uncompressed; lists as long as in what was tried",
        "memory  about 2 MiB a task, beside the process itself",
        "time    about 90 min or less on 8 processors",
        "tried   128 of the points, spread over the grid; nothing was written",
    ]
