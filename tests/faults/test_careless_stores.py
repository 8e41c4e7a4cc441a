"""Stores: what people and machines do to them, and what verbs do that sees only a part."""

from __future__ import annotations

import json
import os
import shutil
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from filelock import FileLock

import remanent as rm
from remanent.studies.sweep import chunks
from remanent.studies.sweep.locks import sole_writer
from remanent.studies.sweep.repair import repair_store
from remanent.studies.sweep.run import run_here, writable_store
from remanent.studies.sweep.store import Store, open_store
from remanent.studies.sweep.study import Study
from remanent.studies.sweep.verify import Integrity, verify_store
from tests.faults.study_process import content

BODY = rm.Actuator(temperature=350.0, dissipation=rm.Rayleigh(0.05))
DRIVE = rm.SineSquared(0.4, 1.25)


def losses(**changes: Any) -> Study:
    """A quick study of some chunks."""
    over = {"b": np.linspace(0.2, 0.9, 9), "omega": np.linspace(0.9, 1.4, 4)}
    return Study("cycle_losses", BODY, DRIVE, over, {"periods": 1, **changes})


@pytest.fixture(autouse=True)
def _small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chunks, "_POINTS_PER_CHUNK", 4)
    monkeypatch.setattr(chunks, "_POINTS_PER_CHUNK_OF_SEARCHES", 4)


def filled(path: Path, study: Study) -> Path:
    """A store that is whole."""
    with writable_store(path, study) as store:
        run_here(store)
    return path


def by_single_chunks(path: Path, study: Study) -> xr.Dataset:
    """What a store holds whose chunks were computed one by one, the last one first."""
    with writable_store(path, study) as store:
        every = list(store.chunking.chunks())
        for index in range(len(every), 0, -1):
            run_here(store, (index, len(every)))
    return rm.load(path)


@pytest.mark.parametrize(
    ("verb", "over", "options"),
    [
        ("simulate", {"omega": [0.9, 1.25, 1.6], "b": [0.2, 0.3]}, {"periods": 1}),
        ("energy_balance", {"omega": [0.9, 1.25, 1.6]}, {"periods": 1}),
        ("simulate", {"b": np.linspace(0.1, 0.5, 9)}, {"periods": 2}),
        ("simulate", {"c": [-1.0, 1.0], "b": np.linspace(0.1, 0.2, 8)}, {"duration": 11.0}),
        ("step_response", {"temperature": np.linspace(250.0, 350.0, 6)}, {}),
        ("step_response", {"m": np.linspace(0.1, 0.3, 6)}, {"duration": 30.0}),
    ],
)
@pytest.mark.filterwarnings("ignore::remanent.InputWarning")
def test_points_that_depend_on_each_other_stay_together(
    verb: str, over: dict[str, Any], options: dict[str, Any], tmp_path: Path
) -> None:
    """Where the longest run says how long all are, or the slowest where times are given."""
    drive = rm.Constant(0.2) if verb == "step_response" else DRIVE
    study = Study(verb, BODY, drive, over, options)
    loaded = by_single_chunks(tmp_path / "it.zarr", study)
    xr.testing.assert_equal(loaded, study.result_of(study.grid.whole))
    assert verify_store(tmp_path / "it.zarr").integrity is Integrity.WHOLE


def test_a_result_that_does_not_fit_is_refused(tmp_path: Path) -> None:
    """What points share is the same for all that a store holds."""
    study = Study("simulate", BODY, DRIVE, {"b": [0.2, 0.3]}, {"duration": 5.0})
    with writable_store(tmp_path / "it.zarr", study) as store:
        result = study.result_of(study.grid.whole)
        other = result.assign_coords(time=2.0 * result["time"])
        for wrong in (other, result.rename(time="cycle")):
            with pytest.raises(rm.RemanentError, match="differs between points"):
                store.write(study.grid.whole, wrong)


def test_what_is_no_store_of_ours_is_left_alone(tmp_path: Path) -> None:
    """Zarr data of others, a store that lost its checksum, and the inside of a store."""
    precious = tmp_path / "precious.zarr"
    xr.Dataset({"precious": ("x", np.arange(5.0))}).to_zarr(precious, consolidated=False)
    own = filled(tmp_path / "own.zarr", losses())
    (own / "bookkeeping" / "description.sha256").unlink()
    for path in (precious, own, own / "bookkeeping", own / "b" / "new.zarr"):
        before = content(tmp_path)
        with pytest.raises(rm.InputError, match="`store` must"), writable_store(path, losses()):
            pass
        assert content(tmp_path) == before
    repair_store(own)
    assert verify_store(own).integrity is Integrity.WHOLE


def test_a_store_that_was_only_begun_is_made_anew(tmp_path: Path) -> None:
    """A process was killed before it had written the end of the description."""
    path = tmp_path / "it.zarr"
    with writable_store(path, losses()):
        pass
    shutil.rmtree(path / "error")
    (path / "bookkeeping" / "description.sha256").unlink()
    filled(path, losses())
    assert verify_store(path).integrity is Integrity.WHOLE


def test_a_repair_believes_no_spoilt_copy_of_the_study(tmp_path: Path) -> None:
    """There are two, each with a digest."""
    path = filled(tmp_path / "it.zarr", losses())
    before = content(path)
    copy = path / "bookkeeping" / "study.json"
    copy.write_text(copy.read_text().replace("350.0", "358.0"))
    repair_store(path)
    assert content(path) == before
    description = path / "zarr.json"
    description.write_text(description.read_text().replace("350.0", "358.0"))
    repair_store(path)
    assert content(path) == before
    for file in (copy, description):
        file.write_text(file.read_text().replace("350.0", "358.0"))
    with pytest.raises(rm.InputError, match="nothing sound"):
        repair_store(path)


def test_a_repair_does_not_mix_codes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nor says that other code computed what is there."""
    path = filled(tmp_path / "it.zarr", losses())
    (path / "b" / "zarr.json").write_text(" " + (path / "b" / "zarr.json").read_text() + "x")
    before = content(path)
    identity = {"versions": "1", "sources": "2", "processor": "3"}
    monkeypatch.setattr("remanent.studies.sweep.store.code_identity", lambda: identity)
    with pytest.raises(rm.RemanentError, match="begun by other code"):
        repair_store(path)
    assert content(path) == before


def test_a_repair_waits_for_no_writer(tmp_path: Path) -> None:
    """It changes nothing while another process writes."""
    path = filled(tmp_path / "it.zarr", losses())
    (path / "b" / "zarr.json").write_text("x")
    before = content(path)
    with (
        sole_writer(path / "bookkeeping", (1, 1)),
        pytest.raises(rm.RemanentError, match="being written"),
    ):
        repair_store(path)
    assert content(path) == before


@pytest.mark.parametrize("lengthened", [1, 3])
def test_a_kill_while_lists_grow_is_made_up_for(
    lengthened: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Some arrays are longer then, others are not, and the description is of before."""
    study = Study(
        "crossings", BODY, DRIVE, {"b": np.linspace(0.1, 0.9, 8)},
        {"variable": "thickness_stretch", "value": 1.02, "duration": 30.0},
    )  # fmt: skip
    path, whole = tmp_path / "it.zarr", filled(tmp_path / "whole.zarr", study)
    make_longer, done = Store._make_array_longer, []

    def stop_after_some(self: Store, name: str, result: xr.Dataset) -> None:
        make_longer(self, name, result)
        done.append(name)
        if len(done) > lengthened:
            raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(Store, "_make_array_longer", stop_after_some)
        with pytest.raises(KeyboardInterrupt):
            filled(path, study)
    with pytest.raises(rm.InputError, match="makes its lists longer"):
        rm.load(path)
    filled(path, study)
    assert verify_store(path).integrity is Integrity.WHOLE
    xr.testing.assert_equal(rm.load(path), rm.load(whole))
    assert xr.open_zarr(path).sizes == xr.open_zarr(whole).sizes


def test_a_late_task_does_not_write_into_another_store(tmp_path: Path) -> None:
    """A worker still had the store that was there before."""
    path = filled(tmp_path / "it.zarr", losses())
    old = open_store(path)
    part = old.chunking.part_of((0, 0))
    result = old.study.result_of(part)
    shutil.rmtree(path)
    filled(path, losses(tolerance=1e-3))
    before = content(path)
    with pytest.raises(rm.RemanentError, match="removed or replaced"):
        old.write(part, result)
    assert content(path) == before


def test_a_damaged_status_is_told_by_a_run(tmp_path: Path) -> None:
    """With what to do."""
    path = filled(tmp_path / "it.zarr", losses())
    file = next(f for f in (path / "status" / "c").rglob("*") if f.is_file())
    file.write_bytes(file.read_bytes()[:-1] + bytes([file.read_bytes()[-1] ^ 1]))
    with pytest.raises(rm.RemanentError, match=r"verify .* --repair"):
        filled(path, losses())
    repair_store(path)
    assert verify_store(path).integrity is Integrity.WHOLE


def test_who_only_asks_for_a_lock_is_no_writer(tmp_path: Path) -> None:
    """Shares that begin together ask each other whether the whole is being written."""
    asking = FileLock(tmp_path / "run-1-of-1.lock", thread_local=False)
    asking.acquire()
    threading.Timer(0.2, asking.release, [True]).start()
    with sole_writer(tmp_path, (1, 4)):
        pass


@pytest.mark.parametrize("name", ["arm", "spring"])
def test_names_of_ones_own_may_be_like_those_of_lengths(name: str, tmp_path: Path) -> None:
    """A coordinate of a system, and a parameter over a dimension of one's own."""
    own = f"{name}_length"
    system = rm.LagrangianSystem(
        coordinates=own, kinetic=f"{own}_rate**2/2", potential=f"-k*{name}2_length*{own}**4/4",
        parameters={"k": 1.0, f"{name}2_length": 1.0}, rest={own: 1.0},
    )  # fmt: skip
    over = {
        f"{name}2_length": xr.DataArray([1.0, 2.0], dims=f"{name}2"), "k": [-1.0, 1.0, 5.0]
    }  # fmt: skip
    study = Study("simulate", system, rm.Constant(0.0), over, {"duration": 8.0})
    filled(tmp_path / "it.zarr", study)
    xr.testing.assert_equal(rm.load(tmp_path / "it.zarr"), study.result_of(study.grid.whole))
    assert verify_store(tmp_path / "it.zarr").integrity is Integrity.WHOLE


@pytest.mark.parametrize("dim", ["bookkeeping", "a/b", "../evil", "zarr.json"])
def test_names_that_are_no_folders_are_refused(dim: str, tmp_path: Path) -> None:
    """Before anything is written."""
    values = xr.DataArray([0.2, 0.3], dims=dim, coords={dim: ["x", "y"]})
    with pytest.raises(rm.InputError, match="names can be those of folders"):
        rm.sweep(BODY, DRIVE, {"b": values}, "cycle_losses", periods=1, store=tmp_path / "it.zarr")
    assert not os.listdir(tmp_path)


def test_any_order_and_labels_that_verbs_take(tmp_path: Path) -> None:
    """Unsorted values of a dimension of their own; dates are refused in words."""
    values = xr.DataArray([0.3, 0.2, 0.5], dims="b")
    options: dict[str, Any] = {"periods": 1}
    stored = rm.sweep(BODY, DRIVE, {"b": values}, "cycle_losses", store=tmp_path / "a", **options)
    xr.testing.assert_equal(stored, rm.cycle_losses(BODY, DRIVE, over={"b": values}, **options))
    days = np.array(["2026-01-01", "2026-01-02"], dtype="datetime64[ns]")
    for labels in (days, np.array([1, 2], dtype=np.uint64)):
        dated = xr.DataArray([0.3, 0.2], dims="day", coords={"day": labels})
        with pytest.raises(rm.InputError, match="text or signed numbers"):
            rm.sweep(BODY, DRIVE, {"b": dated}, "cycle_losses", store=tmp_path / "b", **options)
    assert sorted(os.listdir(tmp_path)) == ["a"]


def test_another_function_of_the_name_of_a_verb_is_refused() -> None:
    """A study is run by name."""

    def simulate() -> xr.Dataset:
        return xr.Dataset()

    with pytest.raises(rm.InputError, match="a verb of this package"):
        rm.sweep(BODY, DRIVE, {"b": [0.3]}, simulate, duration=1.0)
    assert rm.sweep(BODY, DRIVE, {"b": [0.3]}, rm.simulate, duration=1.0).sizes["b"] == 1


@pytest.mark.parametrize("dim", ["point", "case"])
def test_grids_of_points_are_drawn(dim: str) -> None:
    """Values that go together, alone and beside others."""
    alone: dict[str, Any] = {}
    for further in (alone, {"temperature": [300.0, 350.0]}):
        over: dict[str, Any] = {
            "b": xr.DataArray([0.3, 0.4, 0.2], dims=dim),
            "omega": xr.DataArray([1.0, 1.2, 0.9], dims=dim),
            **further,
        }
        rm.plot.overview(rm.cycle_losses(BODY, DRIVE, periods=1, over=over))
        rm.plot.overview(rm.classify(BODY, DRIVE, periods=100, tolerance=1e-6, over=over))


def test_both_descriptions_say_what_the_other_says(tmp_path: Path) -> None:
    """The study, its digest, and the code."""
    path = filled(tmp_path / "it.zarr", losses())
    copy = json.loads((path / "bookkeeping" / "study.json").read_text())
    attributes = json.loads((path / "zarr.json").read_text())["attributes"]
    assert copy["study"] == json.loads(attributes["study"])
    assert copy["study_digest"] == attributes["study_digest"]
    assert all(attributes[f"code_{key}"] == value for key, value in copy["code"].items())
