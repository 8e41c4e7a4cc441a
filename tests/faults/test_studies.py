"""Stores: those of studies outlive what happens to processes, disks and files.

Each test ends with a store that equals, file by file, that of a run which nothing happened to.
"""

from __future__ import annotations

import dataclasses
import json
import os
import random
import shutil
import signal
import subprocess
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from distributed import LocalCluster

import remanent as rm
from remanent._machine import THREADS_VARIABLE, available_processor_count
from remanent.studies.sweep import dask_engine
from remanent.studies.sweep.repair import repair_store
from remanent.studies.sweep.run import run_here, writable_store
from remanent.studies.sweep.sample import sample_on
from remanent.studies.sweep.verify import Integrity, verify_store
from tests.faults.study_process import computed_points, content, main, start, study


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The store of the study, computed in this process without trouble."""
    path = tmp_path_factory.mktemp("stores") / "whole.zarr"
    main(path)
    return path


def kill_when(process: subprocess.Popen[str], path: Path, points: int) -> None:
    """Kill a process as soon as its store has so many points."""
    while computed_points(path) < points and process.poll() is None:
        time.sleep(0.01)
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate()


def require_success(process: subprocess.Popen[str]) -> None:
    """Wait for a process, which must end without a fault."""
    _, told = process.communicate(timeout=1800)
    assert process.returncode == 0, told


def test_a_store_holds_what_the_verb_returns(whole: Path) -> None:
    """Bit for bit, as :func:`remanent.load` and xarray read it."""
    expected = study().result_of(study().grid.whole)
    loaded = rm.load(whole)
    xr.testing.assert_equal(loaded, expected)
    assert list(loaded.attrs["study_digest"]) == list(study().digest)
    opened = xr.open_zarr(str(whole), chunks=None)
    for name in ("initial", "multipliers", "error", "status", "b"):
        np.testing.assert_array_equal(opened[name], expected[name])
    assert verify_store(whole).integrity is Integrity.WHOLE


@pytest.mark.slow
@pytest.mark.parametrize("workers", [1, 2])
def test_workers_fill_the_same_store(whole: Path, tmp_path: Path, workers: int) -> None:
    """One worker or two: every file is the same."""
    path = tmp_path / "dask.zarr"
    require_success(start(path, workers=workers))
    assert content(path) == content(whole)


def test_workers_have_no_more_threads_than_there_are_processors() -> None:
    """All workers together, each of which computes one task at a time."""
    processors = available_processor_count()
    for count in (1, processors):
        with dask_engine.local_workers(count) as client:
            threads = client.run(available_processor_count)
            at_once = client.nthreads()
        assert set(at_once.values()) == {1}
        assert len(threads) == count
        assert sum(threads.values()) <= processors


@pytest.mark.slow
def test_workers_know_a_store_from_one_that_was_there_before(tmp_path: Path) -> None:
    """The same workers, the same path, one study after the other."""
    path = tmp_path / "again.zarr"
    with dask_engine.local_workers(1) as client:
        for one in (study(2), study(3), study(2)):
            shutil.rmtree(path, ignore_errors=True)
            with writable_store(path, one, take_sample=sample_on(client)) as store:
                dask_engine.run_on_workers(store, client)
            xr.testing.assert_equal(rm.load(path), one.result_of(one.grid.whole))


@pytest.mark.slow
def test_four_workers_of_a_running_scheduler_fill_the_same_store(
    whole: Path, tmp_path: Path
) -> None:
    """By its address, as `remanent run --scheduler` does."""
    path = tmp_path / "scheduler.zarr"
    with (
        LocalCluster(
            n_workers=4, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0",
            env={THREADS_VARIABLE: "1"}, silence_logs=50,
        ) as cluster,
        dask_engine.client_of(cluster.scheduler_address) as client,
        writable_store(path, study(), take_sample=sample_on(client)) as store,
    ):  # fmt: skip
        dask_engine.run_on_workers(store, client)
    assert content(path) == content(whole)


@pytest.mark.parametrize("kills", [2, pytest.param(50, marks=pytest.mark.slow)])
def test_killed_runs_are_gone_on_with(whole: Path, tmp_path: Path, kills: int) -> None:
    """However often the process is killed, the store is the same in the end."""
    path = tmp_path / "killed.zarr"
    rng = random.Random(kills)
    done = 0
    for _ in range(kills):
        process = start(path)
        kill_when(process, path, done + rng.randrange(0, 16))
        done = min(computed_points(path), 64)
    require_success(start(path))
    assert content(path) == content(whole)


@pytest.mark.slow
@pytest.mark.parametrize("kills", [2, 50])
def test_killed_workers_are_replaced(whole: Path, tmp_path: Path, kills: int) -> None:
    """Tasks of dead workers are given to others, and the store is the same in the end."""
    path = tmp_path / "workers.zarr"
    rng = random.Random(kills)
    points = 5 if kills < 10 else 40
    process = start(path, workers=2, points=points)
    killed = 0
    while process.poll() is None and killed < kills:
        time.sleep(0.3)
        with suppress(OSError, ValueError):
            ids = [int(word) for word in path.with_suffix(".workers").read_text().split()]
            if ids:  # else all of them are starting anew
                os.kill(rng.choice(ids), signal.SIGKILL)
                killed += 1
    require_success(process)
    if points == 5:
        assert content(path) == content(whole)
    else:
        xr.testing.assert_equal(rm.load(path), study(points).result_of(study(points).grid.whole))


@pytest.mark.slow
def test_parts_side_by_side_fill_one_store(whole: Path, tmp_path: Path) -> None:
    """Four shares at once, of which one is killed and run again."""
    path = tmp_path / "parts.zarr"
    processes = [start(path, part=f"{k}/4") for k in (1, 2, 3, 4)]
    os.killpg(processes[1].pid, signal.SIGKILL)
    for process in processes:
        process.communicate(timeout=300)
    require_success(start(path, part="2/4"))
    assert content(path) == content(whole)


def test_two_runs_of_one_store_are_refused(tmp_path: Path) -> None:
    """The same run, the same share, and shares of another count."""
    path = tmp_path / "busy.zarr"
    with (
        writable_store(path, study()),
        pytest.raises(rm.RemanentError, match="being written by another run"),
        writable_store(path, study()),
    ):
        pass
    with writable_store(path, study(), (1, 4)):
        for part in ((1, 4), (1, 1), (2, 3)):
            with (
                pytest.raises(rm.RemanentError, match="being written by a run of part 1 of 4"),
                writable_store(path, study(), part),
            ):
                pass
        with writable_store(path, study(), (2, 4)):
            pass


def test_another_study_is_refused(whole: Path) -> None:
    """A store is of one study; what differs is named."""
    turned = dataclasses.replace(study(), over=dict(reversed(list(study().over.items()))))
    for other, words in ((study(6), "another over"), (turned, "another order of dimensions")):
        with pytest.raises(rm.InputError, match=words), writable_store(whole, other):
            pass


def test_other_code_is_refused(whole: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Other sources may give other numbers; what differs is named."""
    monkeypatch.setattr(
        "remanent.studies.sweep.store.code_identity", lambda: {"sources": "changed"}
    )
    with (
        pytest.raises(rm.RemanentError, match="sources was"),
        writable_store(whole, study()),
    ):
        pass


@pytest.mark.parametrize("count", [20, pytest.param(1000, marks=pytest.mark.slow)])
def test_every_damage_is_found(whole: Path, tmp_path: Path, count: int) -> None:
    """Bits flipped, files cut short and deleted; what is repaired is what was damaged."""
    path = _copied(whole, tmp_path)
    files = sorted(f for f in path.rglob("*") if f.is_file() and "/c/" in f.as_posix())
    rng = random.Random(count)
    for k in range(count):
        file = rng.choice(files)
        before = file.read_bytes()
        _damage(file, before, rng, k % 3)
        found = verify_store(path)
        assert found.integrity is not Integrity.WHOLE, file
        if file.parent.parent.name != "status" and k % 10 == 0 and found.damaged:
            assert repair_store(path).damaged == found.damaged
            assert content(path) == content(whole)
        file.write_bytes(before)
    assert content(path) == content(whole)


def _damage(file: Path, before: bytes, rng: random.Random, kind: int) -> None:
    if kind == 0:
        place = rng.randrange(len(before))
        flipped = before[place] ^ (1 << rng.randrange(8))
        file.write_bytes(before[:place] + bytes([flipped]) + before[place + 1 :])
    elif kind == 1:
        file.write_bytes(before[: rng.randrange(len(before))])
    else:
        file.unlink()


def _copied(whole: Path, folder: Path) -> Path:
    return Path(shutil.copytree(whole, folder / "copy.zarr"))


@pytest.mark.parametrize("file", ["zarr.json", "initial/zarr.json", "bookkeeping/study.json"])
def test_a_damaged_description_is_written_anew(whole: Path, tmp_path: Path, file: str) -> None:
    """From the study, of which there are two copies; chunks stay."""
    path = _copied(whole, tmp_path)
    (path / file).write_bytes(b"x" + (path / file).read_bytes()[1:])
    assert verify_store(path).integrity is Integrity.DAMAGED
    repair_store(path)
    assert content(path) == content(whole)


def test_a_store_of_a_newer_version_says_so(whole: Path, tmp_path: Path) -> None:
    """It is neither misread nor called damaged."""
    path = _copied(whole, tmp_path)
    description = json.loads((path / "zarr.json").read_text())
    description["attributes"]["schema_version"] = 2
    (path / "zarr.json").write_text(json.dumps(description))
    for call in (lambda: rm.load(path), lambda: verify_store(path)):
        with pytest.raises(rm.InputError, match="newer remanent"):
            call()


def test_an_incomplete_store_is_read_and_completed(whole: Path, tmp_path: Path) -> None:
    """What is missing is NaN with status 0."""
    path = tmp_path / "half.zarr"
    with writable_store(path, study(), (1, 2)) as store:
        run_here(store, (1, 2))
    half = rm.load(path)
    assert verify_store(path).integrity is Integrity.INCOMPLETE
    assert set(np.unique(half.status)) == {0, 1}
    assert np.isnan(half.error.values[half.status.values == 0]).all()
    with writable_store(path, study()) as store:
        run_here(store)
    assert content(path) == content(whole)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "place", "status"),
    [("crash", 3, "FAILED"), ("hang", 3, "TIMEOUT"), ("crash", 0, "FAILED")],
)
def test_a_point_that_takes_its_worker_down_is_given_up(
    whole: Path, tmp_path: Path, kind: str, place: int, status: str
) -> None:
    """After three failures; all other points are as they are without it."""
    path = tmp_path / "bad.zarr"
    environment = {
        **_bad_point(kind, place),
        "DASK_DISTRIBUTED__WORKER__PRELOAD": "tests.faults.bad_point",
    }
    seconds = {"seconds": 3.0} if kind == "hang" else {}
    require_success(start(path, environment, workers=1, **seconds))
    _require_one_point_lost(path, whole, place, rm.Status[status])


def test_a_worker_that_dask_has_lost_is_replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    """Dask gives up a worker that is long in coming back; its tasks would wait for ever."""
    monkeypatch.setattr(dask_engine, "_LOST_AFTER_SECONDS", 0.5)
    monkeypatch.setattr(dask_engine, "_REPLACED_EVERY_SECONDS", 0.2)
    with dask_engine.local_workers(1) as client:
        first = client.submit(os.getpid, pure=False).result(60)
        (nanny,) = client.cluster.workers.values()
        client.cluster.sync(nanny.close)
        assert client.submit(os.getpid, pure=False).result(60) != first


@pytest.mark.slow
@pytest.mark.parametrize("place", [3, 0])
def test_a_point_that_takes_this_process_down_is_given_up(
    whole: Path, tmp_path: Path, place: int
) -> None:
    """Each run gets as far as the point, and the one after the third failure passes it."""
    path = tmp_path / "bad.zarr"
    for _ in range(12):
        process = start(path, _bad_point("crash", place))
        process.communicate(timeout=300)
        if process.returncode == 0:
            break
    _require_one_point_lost(path, whole, place, rm.Status.FAILED)


def _bad_point(kind: str, place: int) -> dict[str, str]:
    """Variables of the environment: what happens, and at which place along omega."""
    omega = study().grid.fields.arrays["omega"][1][place]
    return {"REMANENT_TEST_BAD_POINT": kind, "REMANENT_TEST_BAD_OMEGA": repr(float(omega))}


def _require_one_point_lost(path: Path, whole: Path, place: int, status: rm.Status) -> None:
    ds, expected = rm.load(path), rm.load(whole)
    lost = {"b": [0], "omega": [place]}
    assert int(ds.status.isel(lost).item()) == status
    assert "process" in ds.reason.isel(lost).item() or "cap" in ds.reason.isel(lost).item()
    assert int((ds.status != rm.Status.OK).sum()) == 1
    others = xr.ones_like(ds.status, dtype=bool)
    others[lost] = False
    for name in ("error", "initial", "multipliers"):
        xr.testing.assert_equal(ds[name].where(others), expected[name].where(others))


def test_a_full_disk_is_told_and_the_run_gone_on_with(whole: Path, tmp_path: Path) -> None:
    """A small file system in memory; the store is readable while it is full."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mounted = subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=400k", "tmpfs", str(disk)], capture_output=True,
        check=False,
    )  # fmt: skip
    if mounted.returncode:
        pytest.skip("mounting a file system needs rights that this user does not have")
    try:
        path = disk / "full.zarr"
        process = start(path)
        _, told = process.communicate(timeout=300)
        assert process.returncode == 1
        assert "No space left on device" in told
        assert set(np.unique(rm.load(path).status)) <= {0, 1}
        subprocess.run(["mount", "-o", "remount,size=40m", str(disk)], check=True)
        require_success(start(path))
        assert content(path) == content(whole)
    finally:
        subprocess.run(["umount", str(disk)], check=True)
